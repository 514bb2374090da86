"""Posterior of the model's parameters by readings: against closed forms, on dams that are a formula; and into the ensemble."""

import json
import os
import re
import runpy
import threading
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import scipy
import yaml
from quoin_tools.base import solver as solvers
from quoin_tools.ensemble import analysis, design
from quoin_tools.ensemble.drawn import with_posterior
from quoin_tools.ensemble.journal import Journal, Row
from quoin_tools.ensemble.running import Samples, run
from quoin_tools.ensemble.variables import EnsembleError, variables
from quoin_tools.front import main
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.readings import drift, hybrid, posterior, responses, sensors, surfaces
from quoin_tools.readings import table as table_of_readings
from quoin_tools.readings.sensors import ReadingsError, Sensor
from quoin_tools.show import ensemble_part, ensembles, updated

EXAMPLE = Path(__file__).parents[2] / "examples/guilhofrei_readings"
solver = pytest.mark.skipif(not os.path.exists(os.environ.get("QUOIN", "build/quoin")), reason="the solver is not built")
LOW, HIGH, ACCURACY = 10.0, 30.0, 0.1
BOX = surfaces.Box(np.zeros(2), np.full(2, surfaces.WIDEST))


def formula(state, z):
    """Something that an instrument might read: water to the third power, a season, two parameters; the kink is what opens."""
    x, year = state[:, 0] / 30, 2 * np.pi * state[:, 1] / surfaces.YEAR
    return (1 + 0.2 * z[..., 0]) * x**3 * 4 + 0.3 * z[..., 1] * np.cos(year) + 0.1 * z[..., 0] * z[..., 1] * x


def table(truth, runs=60, states=5, seed=3):
    random = np.random.default_rng(seed)
    normal = np.repeat(random.uniform(-surfaces.WIDEST, surfaces.WIDEST, (runs, 2)), states, axis=0)
    state = np.column_stack([random.uniform(LOW, HIGH, runs * states), random.uniform(0, surfaces.YEAR, runs * states)])
    return surfaces.Table(np.repeat(np.arange(runs), states), state, normal, {"a": truth(state, normal)})


def surface(truth=formula, **more):
    return surfaces.Surface.of(table(truth), BOX, "a", LOW, HIGH, True, **more)


def states(time, random):
    return np.column_stack([np.clip(20 + 8 * np.sin(time / 90) + random.normal(0, 1, len(time)), LOW, HIGH), time % surfaces.YEAR])


def channel(made, time, state, value, free):
    return posterior.Channel.of("a", ACCURACY, time, state, value, made, free)


def test_surface_meets_a_formula_and_tells_its_error():
    made, random = surface(), np.random.default_rng(8)
    state, z = np.column_stack([random.uniform(LOW, HIGH, 50), random.uniform(0, surfaces.YEAR, 50)]), random.uniform(-2, 2, (50, 2))
    assert made.at(state, z) == pytest.approx(formula(state, z), abs=1e-9)
    assert made.error < 1e-9 and made.n == 60
    kinked = surface(lambda state, z: formula(state, z) + np.maximum(state[:, 0] - 25, 0))
    there = np.abs(kinked.at(state, z) - formula(state, z) - np.maximum(state[:, 0] - 25, 0))
    assert 0.3 * kinked.error < np.sqrt(np.mean(there**2)) < 3 * kinked.error  # a kink is no polynomial, and the error says so
    assert kinked.error > 0.01


def test_surface_of_a_discharge_is_of_its_logarithm():
    made = surface(lambda state, z: np.exp(2 * z[..., 0] + state[:, 0] / 10), log=True)
    assert made.error < 1e-9
    with pytest.raises(ReadingsError, match="1 readings are not above 0"):
        posterior.Channel.of("a", 0.1, np.arange(3.0), np.full((3, 2), 20.0), np.array([1.0, 0.0, 2.0]), made, False)


@pytest.mark.parametrize("free", [False, True])
def test_likelihood_is_that_of_the_whole_covariance(free):
    random = np.random.default_rng(2)
    time = np.sort(random.uniform(0, 700, 40))
    state, made = states(time, random), surface()
    made.error = 0.07
    one = channel(made, time, state, formula(state, np.array([0.5, -1.0])) + random.normal(0, 0.2, 40), free)
    z = np.array([[0.3, -0.7], [1.0, 0.2]])
    by_hand = []
    for tau in one.taus:
        for spread in posterior.SPREADS:
            cover = (spread * ACCURACY) ** 2 * np.exp(-np.abs(time[:, None] - time) / tau) + ACCURACY**2 * np.eye(40)
            variance = np.where(one.weight > 0, 1 / np.maximum(one.weight, 1e-12), 1e4)  # a flat prior of zero and rate: the limit of a wide one
            cover = cover + (one.own * variance) @ one.own.T
            by_hand.append([scipy.stats.multivariate_normal(made.at(state, x), cover).logpdf(one.value) for x in z] + np.log(spread / (1 + spread**2)))
    likelihood = posterior.Likelihood([one], BOX)
    found = likelihood.grid(0, z)
    by_hand = np.array(by_hand).T
    assert found - found[0, 0] == pytest.approx(by_hand - by_hand[0, 0], abs=1e-2 if free else 1e-6)
    before = likelihood(z)
    likelihood.near(z)
    assert 0 < len(likelihood.places[0]) < found.shape[1] and likelihood(z) == pytest.approx(before, abs=1e-9)
    assert likelihood.grid(0, z) == pytest.approx(found[:, likelihood.places[0]])
    assert set(likelihood.errors(z, random)[:, 0]) <= set(likelihood.places[0])


def test_posterior_of_a_straight_model_is_the_normal_one():
    """With model errors that hardly matter: mean and deviation by hand."""
    random = np.random.default_rng(5)
    time = np.arange(0.0, 3000, 60)
    state = states(time, random)
    straight = surface(lambda state, z: 0.05 * z[..., 0] + 0.02 * z[..., 1] * (state[:, 0] - 20))
    one = channel(straight, time, state, straight.at(state, np.array([1.0, -0.5])) + random.normal(0, ACCURACY, len(time)), False)
    found = posterior.sample(["p", "q"], [one], BOX, enough=2500)
    tried = np.array([[(p, q) for p in np.linspace(-2.6, 2.6, 105)] for q in np.linspace(-2.6, 2.6, 105)]).reshape(-1, 2)
    value = posterior.Likelihood([one], BOX)(tried)
    weight = np.exp(value - value.max())
    mean = weight @ tried / weight.sum()
    deviation = np.sqrt(weight @ (tried - mean) ** 2 / weight.sum())
    assert found.mean() == pytest.approx(mean, abs=0.1 * deviation.max())
    assert found.normal.std(axis=0) == pytest.approx(deviation, rel=0.08)
    assert (found.r_hat < 1.05).all() and (found.effective > 2500).all()


# ---- the file of the model ---------------------------------------------------------------------------------

MODEL = {"scene": str(EXAMPLE / "scene.yaml"), "stage": "now", "variables": {"amplitude": {"keys": ["loads.season.amplitude"], "distribution": "normal", "mean": 8, "deviation": 2}},
         "level": {"keys": ["loads.water.level", "loads.lake.level"], "min": 18, "max": 33}, "season": {"keys": ["loads.season.day"]}}  # fmt: skip


def model_of(folder, **changed):
    (folder / "model.yaml").write_text(yaml.safe_dump({key: value for key, value in (MODEL | changed).items() if value is not None}, sort_keys=False))
    return surfaces.read(str(folder / "model.yaml"))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"level": MODEL["level"] | {"min": "low"}}, "level: .*'min': 'low'.*expected keys of the scene, min and max"),
        ({"level": MODEL["level"] | {"max": float("inf")}}, "level: .*inf.*expected keys"),
        ({"level": MODEL["level"] | {"max": 3}}, "level: .*expected keys"),
        ({"level": None}, "level: None: expected keys"),
        ({"level": MODEL["level"] | {"keys": []}}, r"level.keys: \[\]: expected a list"),
        ({"level": MODEL["level"] | {"keys": "loads.water.level"}}, "level.keys: loads.water.level: expected a list"),
        ({"level": MODEL["level"] | {"keys": [1]}}, "level.keys: 1: expected a number of a load"),
        ({"season": {"keys": ["loads.season.amplitude"]}}, "season.keys: loads.season.amplitude: expected it once"),
        ({"season": MODEL["season"] | {"warmest": "july"}}, "season.warmest: july: expected 0 to 366"),
        ({"season": MODEL["season"] | {"warmest": float("nan")}}, "season.warmest: nan: expected 0 to 366"),
        ({"rounds": True}, "expected whole numbers"),
        ({"runs": 9}, "runs at least 10"),
        ({"variables": None}, "model.yaml: variables: expected at least one"),
        ({"run": 200}, "model.yaml: run: unknown key; there are scene, .*variables, .*level, season, runs, states, rounds"),
        ({"samples": 60}, "model.yaml: samples: unknown key; there are scene"),
        ({"stage": None}, "model.yaml: stage: missing: expected that of the scene"),
        ({"scene": "none.yaml"}, "none.yaml: no such file"),
    ],
)
def test_a_model_that_is_wrong_is_refused(tmp_path, changed, message):
    with pytest.raises(ReadingsError, match=message) as refused:
        model_of(tmp_path, **changed)
    assert "model.yaml: " in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.parametrize("text", ["- a\n", "title: none\nstages: [{now: {loads: [water]}}]\n", "loads: {a: {type: self_weight}}\n", "loads: {a: {type: self_weight}}\nstages: [now]\n"])
def test_a_scene_without_loads_or_stages_is_refused(tmp_path, text):
    (tmp_path / "scene.yaml").write_text(text)
    with pytest.raises(ReadingsError, match="scene.yaml: expected a scene with loads and a list of stages"):
        surfaces.scene_of_states(model_of(tmp_path, scene="scene.yaml"), [(20.0, 0.0)])


def test_a_variable_of_a_load_with_the_season_reaches_the_copies_of_that_load(tmp_path):
    model = model_of(tmp_path)
    scene = surfaces.scene_of_states(model, [(20.0, 3.0), (25.0, 9.0)])
    assert surfaces.copies(model, "loads.season.amplitude", 2) == ["loads.season.amplitude", "loads.season_at_0.amplitude", "loads.season_at_1.amplitude"]
    assert surfaces.copies(model, "loads.curtain.factor", 2) == ["loads.curtain.factor"] and surfaces.copies(model, "materials.dam.young", 2) == ["materials.dam.young"]
    for k, (level, day) in enumerate([(20.0, 3.0), (25.0, 9.0)]):
        assert (scene["loads"][f"season_at_{k}"]["day"], scene["loads"][f"water_at_{k}"]["level"], scene["loads"][f"lake_at_{k}"]["level"]) == (day, level, level)
        assert {f"season_at_{k}", f"water_at_{k}", f"lake_at_{k}", "curtain", "weight"} <= set(scene["stages"][-2 + k][f"state_{k}"]["loads"])


@pytest.mark.filterwarnings("ignore:The balance properties")
def test_more_runs_go_on_with_those_that_are_there(tmp_path):
    few, more, other = (model_of(tmp_path, **keys) for keys in ({"runs": 20}, {"runs": 30}, {"runs": 20, "states": 2}))
    assert few.mark == more.mark != other.mark
    for one, same in zip(surfaces.points(few, surfaces.widest(few), 1), surfaces.points(more, surfaces.widest(more), 1), strict=True):
        assert np.array_equal(one, same[:20])


def test_pressure_is_that_at_the_elevation_of_the_instrument():
    """A cell that lies beside a joint reads the pressure of the joint's head at its own height, not that on the joint."""
    flow = SimpleNamespace(point=np.array([[[0.0, 2.0], [4.0, 2.0]]]), head=np.array([[10.0, 8.0]]), pressure=9810.0 * np.array([[8.0, 6.0]]))
    end = SimpleNamespace(flow=flow)
    for y, metres in ((2.0, 7.0), (1.0, 8.0), (3.5, 5.5)):
        cell = Sensor("P", "P", "pressure", "kPa", point=(2.0, y))
        assert responses.water(None, end, cell) == pytest.approx(9810 * metres) and responses.water(None, end, replace(cell, quantity="piezometric head")) == 9.0
    flow.head[:] = 1.0  # below the joint: it is dry there
    assert responses.water(None, end, cell) == 0.0


def two_blocks():
    """A rock 10 m wide and 4 m high, and a dam 6 m high on it; the joint is at y = 4."""
    corners = [[0, 0], [10, 0], [10, 4], [0, 4], [0, 4], [10, 4], [10, 10], [0, 10]]
    return BlockMesh(np.array(corners, dtype=float), np.arange(8).reshape(2, 4), [0, 1], ["rock", "dam"], [0, 0], {}, {})


@pytest.mark.parametrize(
    ("point", "vertex", "words"),
    [
        ((10, 10), 6, []),
        ((10, 9.95), 6, []),
        ((10, 9), 6, ["[10, 10], which is 1 m away"]),
        ((0, 4), 3, ["that of block 0 (rock), not of 1 (dam)"]),
        ((0, 4.001), 4, []),
        ((0, 3.999), 3, []),
        ((2, 4), 3, ["[0, 4], which is 2 m away", "block 0 (rock), not of 1 (dam)"]),
    ],
)
def test_the_vertex_of_a_displacement_is_that_of_the_block_of_the_point(point, vertex, words):
    crest, mesh = Sensor("crest", "crest", "displacement", "mm", point=point, direction=(1.0, 0.0)), two_blocks()
    assert responses.nearest(mesh, crest)[0] == vertex
    said = responses.told(mesh, crest)
    assert len(said) == len(words) and all(word in text for word, text in zip(words, said, strict=True))


@solver
def test_an_instrument_far_from_water_is_refused_before_anything_is_written(tmp_path, capsys):
    made = runpy.run_path(str(EXAMPLE / "mesh.py"))
    made["write"](str(tmp_path / "model.h5"), made["rock_mesh"]())
    for name in ("scene.yaml", "model.yaml", "readings.csv"):
        (tmp_path / name).write_text((EXAMPLE / name).read_text())
    far = (EXAMPLE / "readings.yaml").read_text().replace("point: [10.0, 1.0]", "point: [10.0, 20.0]")
    (tmp_path / "readings.yaml").write_text(far)
    assert main.main(["readings", str(tmp_path / "readings.yaml"), "--model", str(tmp_path / "model.yaml"), "-o", str(tmp_path / "out")]) != 0
    assert re.search(r"readings.yaml: sensors.piezometer.P2.point: [\d.]+ m from the nearest joint with water", capsys.readouterr().err)
    assert not (tmp_path / "out").exists()


@solver
def test_the_solver_takes_a_variable_of_a_load_with_the_season(tmp_path):
    made = runpy.run_path(str(EXAMPLE / "mesh.py"))
    made["write"](str(tmp_path / "model.h5"), made["rock_mesh"]())
    model = model_of(tmp_path, model="model.h5")
    crest = {"crest": Sensor("crest", "crest", "displacement", "mm", point=(6.65, 33.0), direction=(1.0, 0.0))}
    small, large = (surfaces.responses(model, crest, np.array([[25.0, 0.0]]), np.array([z]), str(tmp_path / "run"))[0]["crest"] for z in (-2.0, 2.0))
    assert large < small - 1e-3  # a warm downstream face leans the dam towards the water


def record(random, years=8, z=(0.8, -0.6), drifts=0.0, start=4.0, correlated=0.1):
    time = np.arange(0.0, years * surfaces.YEAR, 14)
    state = states(time, random)
    scores = np.tile(z, (len(time), 1))
    scores[:, 0] += drifts * np.maximum(time / surfaces.YEAR - start, 0)
    keep = np.exp(-14 / 30)
    weather = scipy.signal.lfilter([1], [1, -keep], random.normal(0, 1, len(time)) * np.r_[1, np.full(len(time) - 1, np.sqrt(1 - keep**2))])
    return time, state, formula(state, scores) + correlated * weather + random.normal(0, ACCURACY, len(time))


def test_held_out_readings_lie_in_their_band_and_zero_and_rate_are_found():
    made, shares, rates = surface(), [], []
    for seed in range(4):
        random = np.random.default_rng(seed)
        time, state, value = record(random)
        value = value + 3.0 + 0.1 * time / surfaces.YEAR
        fit = time < 7 * surfaces.YEAR
        found = posterior.sample(["p", "q"], [channel(made, time[fit], state[fit], value[fit], True)], BOX, seed, 300, 1000)
        mean, deviation = found.predicted(0, time[~fit], state[~fit])
        shares.append((np.abs(value[~fit] - mean) < 1.96 * deviation).mean())
        rates.append((found.rate(0)[0] - 0.1) / found.rate(0)[1])
        assert (np.abs(found.mean() - [0.8, -0.6]) < 4 * found.normal.std(axis=0)).all()
    assert 0.9 < np.mean(shares) < 0.99
    assert np.abs(rates).max() < 3.5


def test_a_drift_is_found_and_named_and_none_where_there_is_none():
    made, false, late = surface(), 0, []
    for seed in range(4):
        time, state, value = record(np.random.default_rng(seed))
        found = posterior.sample(["p", "q"], [channel(made, time, state, value, False)], BOX, seed, 200, 500)
        false += drift.search(found).alarm
        time, state, value = record(np.random.default_rng(seed), drifts=2.0)
        other = channel(made, time, state, value, False)
        looked = drift.search(drift.until(posterior.Posterior(found.names, [other], BOX, found.normal, found.errors, found.r_hat, found.effective, 1), 5 * surfaces.YEAR))
        assert looked.alarm and looked.name == "p"
        late.append(looked.first <= 4.1 * surfaces.YEAR and looked.last >= 3.9 * surfaces.YEAR)
    assert false == 0 and sum(late) >= 3


def test_parameters_whose_drifts_look_alike_are_named_together():
    """p and q do the same to all readings but for a hundredth: no reading can tell which drifts."""
    alike = surface(lambda state, z: formula(state, np.column_stack([z[..., 0] + z[..., 1], 0.01 * z[..., 0]])))
    time, state, value = record(np.random.default_rng(1), z=(0.3, 0.0), drifts=0.5)
    found = posterior.sample(["p", "q"], [channel(alike, time, state, value, False)], BOX, 1, 200, 500)
    one = drift.search(found)
    assert one.alarm and set(one.named()) == {"p", "q"} and sum(one.probability.values()) == pytest.approx(1)
    assert one.gains.max() > one.least()


@pytest.mark.long
def test_repetitions_of_the_example_on_a_dam_of_three_instruments(monkeypatch, tmp_path):
    """The short form of its hundred dams: parameters and readings in their bands, a curtain that decays found within a year, no false alarm, the flood."""
    monkeypatch.syspath_prepend(str(EXAMPLE))
    import repetitions

    laws = {"pendulum.crest": lambda x, year, z: 8e-3 * (1 - 0.25 * z[..., 1]) * x**4 + 2e-3 * np.cos(year), "piezometer.P2": lambda x, year, z: 3 + (1 + 0.4 * z[..., 0]) * x**2,
            "drain.total": lambda x, year, z: np.log(2e-5) + 0.3 * z[..., 0] + x}  # fmt: skip
    made = {}
    for name, law in laws.items():
        random, found = np.random.default_rng(3), table(formula)
        found.state[:, 0] = random.uniform(18, 33.5, len(found.state))
        found.numbers = {"a": law(found.state[:, 0] / 30, 2 * np.pi * found.state[:, 1] / surfaces.YEAR, found.normal)}
        made[name] = surfaces.Surface.of(found, BOX, "a", 18.0, 33.5, True)
        made[name].log = name == "drain.total"
    (tmp_path / "readings.yaml").write_text((EXAMPLE / "readings.yaml").read_text().replace("scene: scene.yaml", "").replace("readings.csv", str(EXAMPLE / "readings.csv")))
    plan = sensors.read(str(tmp_path / "readings.yaml"))
    box = surfaces.Box(np.zeros(3), np.full(3, surfaces.WIDEST))
    monkeypatch.setattr(repetitions, "setting", lambda folder: (["curtain", "E", "season.delay"], {name: plan.sensors[name] for name in made}, box, made))
    rows = [repetitions.one(k, "") for k in range(2)]
    assert sum(row[f"in:{name}"] for row in rows for name in ("curtain", "E", "season.delay")) >= 5
    assert 0.85 < np.mean([row[f"held:{name}"] for row in rows for name in made]) <= 1
    assert all(np.isnan(row["false"]) for row in rows)
    assert all(0 <= row["delay"] <= 1 and row["drift_of"].split()[0] == "curtain" for row in rows)
    _dates, unseen, answers = repetitions.beyond(0, "")
    read, methods = answers["pendulum.crest"]
    assert unseen.sum() >= 5
    assert (np.abs(read - methods["hybrid"][0]) < methods["hybrid"][1])[unseen].mean() >= 0.8


def told_of(made, seed, *shifts):
    """Sentences on two instruments that see p: where p of each is that of the dam and its shift."""
    random = np.random.default_rng(seed)
    time, state, value = record(random, z=(0.8 + shifts[0], -0.6))
    values = value, made[1].at(state, np.array([0.8 + shifts[1], -0.6])) + random.normal(0, ACCURACY, len(time))
    channels = [posterior.Channel.of(name, ACCURACY, time, state, one, surface_, False) for name, one, surface_ in zip("ab", values, made, strict=True)]
    found = posterior.sample(["p", "q"], channels, BOX, seed, 100, 500)
    each = variables({name: {"distribution": "normal", "mean": 10, "deviation": 1} for name in "pq"}, None)
    instruments = {name: Sensor(name, name, "piezometric head", "m", accuracy=ACCURACY) for name in "ab"}
    return hybrid.doubts(SimpleNamespace(sensors=instruments), SimpleNamespace(names=["p", "q"], design=SimpleNamespace(variables=each)), found, posterior.summary(found, each))


def test_a_model_that_is_wrong_in_kind_is_told_and_a_right_one_is_not():
    made = surface(), surface(lambda state, z: 2 * z[..., 0] * state[:, 0] / 30 + 0.5 * z[..., 1] * np.sin(2 * np.pi * state[:, 1] / surfaces.YEAR))
    assert not any(told_of(made, seed, shift, shift) for seed, shift in enumerate((0.0, -1.0)))
    near = told_of(made, 0, 0.0, 0.3)  # model errors of an accuracy and a half, far beyond the band of p
    assert list(near) == ["b"] and "contradicts the other instruments; without it they want p 10." in near["b"] and "(with it 11." in near["b"]
    far = told_of(made, 1, 0.0, 1.5)
    assert set(far) == {"a", "b"} and "for 600 days" in far["a"] and "times the accuracy of 0.1 m" in far["a"] and "contradicts" not in far["a"]


def test_what_is_not_identified_is_said():
    rows = [{"name": "E", "ratio": 0.2}, {"name": "k_n", "ratio": 0.3}, {"name": "friction", "ratio": 0.98}]
    said = [text.format(*values) for text, *values in posterior.identified(rows, np.array([[1, -0.95, 0], [-0.95, 1, 0], [0, 0, 1]]))]
    assert len(said) == 2 and "friction: the prior alone gave 98 %" in said[0] and "E and k_n trade off (correlation -0.95)" in said[1]


# ---- rounds ------------------------------------------------------------------------------------------------


def posterior_of(normal, box):
    return posterior.Posterior(["p", "q"], [], box, normal, np.zeros((len(normal), 0), dtype=int), np.ones(2), np.full(2, 4000.0), 1)


def test_next_box_reaches_past_an_end_that_samples_crowd():
    random = np.random.default_rng(1)
    normal = np.column_stack([-1 + np.abs(random.normal(0, 0.3, 4000)), random.normal(0.2, 0.1, 4000)])
    found = posterior_of(normal, surfaces.Box(np.zeros(2), np.ones(2)))
    assert hybrid.crowded(found, 2).tolist() == [[True, False], [False, False]]
    box = hybrid.narrowed(found, 2)
    assert (box.centre - box.half)[0] == pytest.approx(-2) and (box.centre + box.half)[0] == pytest.approx(normal[:, 0].mean() + 5 * normal[:, 0].std())
    assert box.centre[1] == pytest.approx(0.2, abs=0.01) and box.half[1] == pytest.approx(0.5, rel=0.05)  # the cut posterior of p may be too narrow for q as well
    mirrored = hybrid.narrowed(posterior_of(-normal, surfaces.Box(np.zeros(2), np.ones(2))), 2)
    assert (mirrored.centre, mirrored.half) == (pytest.approx(-box.centre), pytest.approx(box.half))
    prior = posterior_of(normal - [1.6, 0], surfaces.Box(np.array([-1.6, 0]), np.ones(2)))
    assert not hybrid.crowded(prior, 2).any()  # the box ends where the prior does


@pytest.mark.parametrize("more", [0, 2])
def test_rounds_go_on_while_samples_crowd_at_an_end(tmp_path, monkeypatch, more):
    """Boxes that are far too narrow: the rounds that may follow reach past their ends; without them the end is told."""
    random, truth = np.random.default_rng(2), -0.7
    time = np.arange(0.0, 6 * surfaces.YEAR, 14)
    state = np.column_stack([np.clip(26 + 5 * np.sin(time / 90) + random.normal(0, 1, len(time)), 19, 32), time % surfaces.YEAR])
    law = lambda state, z: 1e-3 * ((4 + z) * (state[:, 0] / 30) ** 3 + 2 * np.cos(2 * np.pi * state[:, 1] / surfaces.YEAR))  # noqa: E731
    dates = pd.Timestamp("2011-01-01") + pd.to_timedelta(time, unit="D")
    state[:, 1] = (dates.day_of_year.to_numpy() - 1) % surfaces.YEAR
    pd.DataFrame({"date": dates, "level": state[:, 0], "crest": 1e3 * law(state, truth) + random.normal(0, 0.1, len(time))}).to_csv(tmp_path / "r.csv", index=False)
    own = {"level": {"quantity": "level", "unit": "m"}, "crest": {"quantity": "displacement", "unit": "mm", "point": [6, 33], "direction": [1, 0], "accuracy": 0.1}}
    (tmp_path / "readings.yaml").write_text(yaml.safe_dump({"file": "r.csv", "dates": {"column": "date"}, "sensors": own}))
    model_of(tmp_path, season=MODEL["season"] | {"warmest": 1}, runs=30, rounds=2)

    def run(model, instruments, box, folder, jobs, round_, report):
        normal, states = surfaces.points(model, box, round_)
        normal, states = np.repeat(normal, 3, axis=0), states.reshape(-1, 2)
        return surfaces.Table(np.repeat(np.arange(30), 3), states, normal, {"crest": law(states, normal[:, 0])})

    monkeypatch.setattr(surfaces, "run", run)
    monkeypatch.setattr(hybrid.narrowed, "__defaults__", (1.5, 0.0))
    monkeypatch.setattr(hybrid, "MORE", more)
    readings = table_of_readings.read(str(tmp_path / "readings.yaml"))
    found = hybrid.updated(readings, str(tmp_path / "model.yaml"), str(tmp_path / "out"))
    if more:
        assert not found.edges and len(found.boxes) > 2 and found.doubts == {}
        assert not any("crowd" in line for line in updated.lines(readings, found))
        assert {os.path.basename(path) for path in updated.pictures(readings, found, str(tmp_path)) if os.path.getsize(path)} == {f"{name}.png" for name in ("posterior", "rounds", "drift", "hybrid", "surfaces", "checks")}
        assert abs(found.posterior.mean()[0] - truth) < 3 * found.posterior.normal[:, 0].std()
    else:
        assert found.edges == ["amplitude"] and len(found.boxes) == 2
        assert any("amplitude: its samples crowd" in line for line in updated.lines(readings, found))
        hybrid.write(replace(found, refused={"P1": None}), str(tmp_path))
        written = yaml.safe_load((tmp_path / "posterior.yaml").read_text())
        assert written["basis"] == found.model.design.basis and "refused" in written["warnings"]["P1"] and "crowd" in written["warnings"]["amplitude"]


# ---- into the ensemble -------------------------------------------------------------------------------------

KEYS = {"c": ["joints.base.cohesion"], "other": ["loads.x.value"]}


PRIOR = variables({"c": {"distribution": "lognormal", "mean": 1, "cov": 0.3}}, None).each[0].spread()


def written(folder, rows, ensemble=""):
    (folder / "scene.yaml").write_text("title: none\n")
    (folder / "posterior.csv").write_text("c,other\n" + "".join(f"{a},{b}\n" for a, b in rows))
    numbers = [dict(zip(("mean", "sd", "low", "high"), map(float, (column.mean(), column.std(), *np.quantile(column, [0.025, 0.975])))), prior_mean=PRIOR[0], prior_sd=PRIOR[1], ratio=0.5) for column in np.array(rows, dtype=float).T]
    head = {"format": "quoin-posterior", "version": 1, "samples": "posterior.csv"}
    (folder / "posterior.yaml").write_text(yaml.safe_dump(head | {"variables": {name: {"keys": KEYS[name]} | row for name, row in zip(KEYS, numbers, strict=True)}}, sort_keys=False))
    text = "{scene: scene.yaml, samples: 400, seed: 1, fail: x.y < 1, variables: {joints.base.friction: {distribution: normal, mean: 40, deviation: 3}, c: {keys: [joints.base.cohesion], distribution: lognormal, mean: 1, cov: 0.3}}"
    (folder / "e.yaml").write_text(text + ensemble + "}\n")
    return design.read(str(folder / "e.yaml"))


def test_samples_take_rows_of_the_posterior_and_keep_the_rest(tmp_path):
    before = written(tmp_path, [(k, 7) for k in range(1, 101)])
    after = with_posterior(before, str(tmp_path / "posterior.yaml"))
    first, second = ([Samples(one).of(k)[0] for k in range(400)] for one in (before, after))
    assert [row[0] for row in first] == [row[0] for row in second]  # the friction of each sample stays
    drawn = np.array([row[1] for row in second])
    assert set(drawn) <= set(range(1, 101)) and len(set(drawn)) > 90 and drawn.mean() == pytest.approx(50.5, abs=4)
    assert after.drawn.unused == ("other",) and after.mark != before.mark
    assert "by the readings" in after.words()[1] and "normal" in after.words()[0]


def test_samples_have_mean_deviation_and_correlation_of_the_posterior(tmp_path):
    """Of variables in another order than in the posterior; another seed takes other rows."""
    random = np.random.default_rng(4)
    c = random.lognormal(0, 0.2, 3000)
    rows = np.column_stack([c, c**-2 * random.lognormal(0, 0.1, 3000)])
    written(tmp_path, rows.tolist())
    text = (tmp_path / "e.yaml").read_text().replace("variables: {", "variables: {other: {keys: [loads.x.value], distribution: lognormal, mean: 1, cov: 0.3}, ")
    (tmp_path / "e.yaml").write_text(text.replace("samples: 400", "samples: 3000"))
    (tmp_path / "f.yaml").write_text(text.replace("seed: 1", "seed: 2"))
    one, two = (with_posterior(design.read(str(tmp_path / name)), str(tmp_path / "posterior.yaml")) for name in ("e.yaml", "f.yaml"))
    assert one.columns() == ["other", "joints.base.friction", "c"] and one.drawn.unused == ()
    drawn = np.array([Samples(one).of(k)[0] for k in range(3000)])[:, [2, 0]]
    assert (np.abs(drawn.mean(axis=0) - rows.mean(axis=0)) < 4 * rows.std(axis=0) / 3000**0.5).all()
    assert drawn.std(axis=0) == pytest.approx(rows.std(axis=0), rel=0.1)
    assert scipy.stats.spearmanr(drawn).statistic == pytest.approx(scipy.stats.spearmanr(rows).statistic, abs=0.02)
    assert {tuple(row) for row in drawn} <= {tuple(row) for row in rows}
    assert [Samples(one).of(k)[0] for k in range(5)] != [Samples(two).of(k)[0] for k in range(5)]


def replaced(name, old, new):
    """Returns a change of a file of a folder."""

    def change(folder):
        text = (folder / name).read_text()
        assert old in text
        (folder / name).write_text(text.replace(old, new, 1))

    return change


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda folder: (folder / "posterior.csv").write_text("c,other\n1,2\n1,nan\n"), "posterior.csv: line 3: 1,nan: expected 2 finite numbers"),
        (lambda folder: (folder / "posterior.csv").write_text("c,other\n1,2\n1\n"), "posterior.csv: line 3: 1: expected 2 finite numbers"),
        (lambda folder: (folder / "posterior.csv").write_text("c,other\n1,two\n"), "posterior.csv: line 2: 1,two: expected 2 finite numbers"),
        (lambda folder: (folder / "posterior.csv").write_text("c\n1\n"), "columns c: expected those"),
        (lambda folder: (folder / "posterior.csv").write_text("c,other\n"), "no samples: expected a line of names"),
        (lambda folder: (folder / "posterior.csv").write_bytes(b""), "no samples: expected a line of names"),
        (lambda folder: (folder / "posterior.csv").unlink(), "posterior.csv: .*expected the samples of a posterior"),
        (lambda folder: (folder / "posterior.csv").write_text("c,other\n1e-9,2\n3e-9,2\n"), "posterior.yaml: variables.c.mean: 2: expected 2e-09, as the samples of .*posterior.csv have"),
        (lambda folder: (folder / "posterior.yaml").write_text("a: 1\n"), "expected the posterior.yaml of quoin readings"),
        (replaced("posterior.yaml", "version: 1", "version: 2"), "version: 2: expected 1"),
        (replaced("posterior.yaml", "keys:", "key:"), "variables.c: .*expected its keys, a list"),
        (replaced("posterior.yaml", "sd: 1.0", "sd: -1.0"), "variables.c.sd: -1.0: expected a number >= 0"),
        (replaced("posterior.yaml", "sd: 1.0", "sd: 2.0"), "variables.c.sd: 2: expected 1, as the samples"),
        (replaced("posterior.yaml", "sd: 1.0", "sd: .nan"), "variables.c.sd: nan: expected a number >= 0"),
        (replaced("posterior.yaml", "high: 2.95", "high: 3.95"), "variables.c.high: 3.95: expected 2.95, as the samples"),
        (replaced("posterior.yaml", "    ratio: 0.5\n", ""), "variables.c.ratio: None: expected a number >= 0"),
        (lambda folder: (folder / "posterior.yaml").write_text((folder / "posterior.yaml").read_text() + "warnings: [P2]\n"), "warnings: .*expected names, each with a sentence"),
    ],
)
def test_a_posterior_that_does_not_fit_is_refused(tmp_path, change, message):
    made = written(tmp_path, [(1, 2), (3, 2)])
    change(tmp_path)
    with pytest.raises(EnsembleError, match=message):
        with_posterior(made, str(tmp_path / "posterior.yaml"))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("mean: 1, cov", "mean: 1e9, cov", r"variables.c: mean 9.9\d*e\+08, deviation .*: expected the prior of .*posterior.yaml, mean 0.9999"),
        ("cov: 0.3", "cov: 0.3, max: 1.5", "variables.c: mean .*: expected the prior"),
        ("distribution: lognormal, mean: 1, cov: 0.3", "distribution: choice, values: [a, b]", r"variables.c: c: a \(50 %\), b \(50 %\): expected the prior"),
        ("  c:", "  cohesion:", "variables.cohesion: keys joints.base.cohesion: expected variable c with those"),
        ("[joints.base.cohesion]", "[joints.base_cohesion]", "variables.c: keys joints.base_cohesion: expected variable c with those"),
        ("[joints.base.cohesion]", "[joints.base.cohesion, joints.sheet.cohesion]", "variables.c: keys joints.base.cohesion, joints.sheet.cohesion: expected variable c with those"),
    ],
)
def test_a_variable_that_is_not_that_of_the_posterior_is_refused(tmp_path, old, new, message):
    written(tmp_path, [(1, 2), (3, 2)])
    replaced("e.yaml", old.strip(), new.strip())(tmp_path)
    with pytest.raises(EnsembleError, match=message):
        with_posterior(design.read(str(tmp_path / "e.yaml")), str(tmp_path / "posterior.yaml"))


def test_another_scene_and_few_rows_are_told(tmp_path):
    made = written(tmp_path, [(1, 2), (3, 2)])
    (tmp_path / "posterior.yaml").write_text((tmp_path / "posterior.yaml").read_text() + f"basis: {made.basis}\nwarnings: {{P2: refused}}\n")
    assert with_posterior(replace(made, samples=2), str(tmp_path / "posterior.yaml")).drawn.warnings == {"P2": "refused"}
    assert "2 rows for 400 samples" in with_posterior(made, str(tmp_path / "posterior.yaml")).drawn.warnings["posterior.csv"]
    (tmp_path / "scene.yaml").write_text("title: another\n")
    assert "nothing says that the runs behind" in with_posterior(design.read(str(tmp_path / "e.yaml")), str(tmp_path / "posterior.yaml")).drawn.warnings["scene.yaml"]


def test_a_folder_of_another_posterior_is_refused_before_anything_is_written(tmp_path, capsys):
    written(tmp_path, [(1, 2), (3, 2)])
    (tmp_path / "e/posterior").mkdir(parents=True)
    (tmp_path / "e/posterior/rows_1.csv").write_text("# quoin ensemble 0123456789abcdef; of another\n")
    words = ["ensemble", str(tmp_path / "e.yaml"), "-o", str(tmp_path / "e"), "--posterior", str(tmp_path / "posterior.yaml")]
    assert main.main(words) == 2 and "posterior/rows_1.csv: rows of another ensemble" in capsys.readouterr().err
    assert main.main([*words, "--posterior", "other.yaml"]) == 2 and "other.yaml: expected one" in capsys.readouterr().err
    assert [path.name for path in (tmp_path / "e").iterdir()] == ["posterior"]


def test_a_posterior_of_other_keys_or_with_other_methods_is_refused(tmp_path):
    with pytest.raises(EnsembleError, match="method: sobol: expected monte_carlo"):
        with_posterior(written(tmp_path, [(1, 2)], ", method: sobol"), str(tmp_path / "posterior.yaml"))
    with pytest.raises(EnsembleError, match="correlation: c, joints.base.friction"):
        with_posterior(written(tmp_path, [(1, 2)], ", correlation: [[c, joints.base.friction, 0.5]]"), str(tmp_path / "posterior.yaml"))


@pytest.mark.parametrize("end", [solvers.Ended(15), KeyboardInterrupt()])
def test_a_sample_that_the_end_of_the_process_has_cut_is_no_row(tmp_path, end):
    """Or it would stay undecided for ever, and the command that goes on would tell another result."""
    made, begun, stopped = replace(written(tmp_path, [(1, 2)]), samples=2), threading.Event(), threading.Event()

    class Model:
        processes = False

        def judge(self, values, index, level):
            if index == 1:
                begun.set()
                stopped.wait(60)
            return ("undecided", None, "ended by SIGTERM") if index else ("stands", 2.0, "")

        def close(self):
            pass

    def report(*_):
        begun.wait(60)
        stopped.set()
        raise end

    try:
        with pytest.raises(type(end)):
            run(made, str(tmp_path), 2, report=report, judge=lambda *_: Model())
    finally:
        solvers.ENDING.clear()
    assert [key[0] for key in Journal(str(tmp_path), made).rows()] == [0]
    assert len(run(made, str(tmp_path), 2, judge=lambda *_: Model())) == 2  # one that ends without a signal to this process counts


def test_danger_level_is_where_the_number_meets_its_limit(tmp_path):
    made = written(tmp_path, [(1, 2)], ", levels: {keys: loads.w.level, values: [10, 20, 30]}")
    made.samples = 4
    numbers = {0: (3.0, 1.5, 0.5), 1: (0.9, 0.8, 0.7), 2: (3.0, 2.0, 1.5), 3: (1.5, 0.5, 0.1)}  # fails below 1: at 25, below 10, above 30, at 15
    rows = {(k, level): Row(k, level, 1.0, "fails" if number < 1 else "stands", number, 0.0, "", (40.0, 1.0)) for k, all_ in numbers.items() for level, number in zip(made.levels, all_, strict=True)}
    found = analysis.danger(made, rows)
    assert (found.median, found.low, found.high, found.never, found.always, found.n) == (15.0, None, None, 1, 1, 4)
    assert found.words() == "15, between below 10 and above 30 for 95 % of 4 samples"
    assert json.dumps(found.__dict__)


@pytest.mark.parametrize("level", [10, None])
def test_before_and_after_are_written_and_drawn(tmp_path, level):
    made = with_posterior(written(tmp_path, [(1, 2)], "" if level is None else ", levels: {keys: loads.w.level, values: [10, 20]}"), str(tmp_path / "posterior.yaml"))
    for name, value in (("before", 0.2), ("after", 0.4)):
        (tmp_path / name).mkdir()
        rows = [{"level": None if level is None else level + 10 * k, "value": value, "low": value - 0.1, "high": value + 0.1} for k in range(1 if level is None else 2)]
        (tmp_path / name / "ensemble.json").write_text(json.dumps({"probabilities": rows, "danger": None if level is None else {"median": 15.0}, "posterior": None}))
    made = replace(made, drawn=replace(made.drawn, warnings={"P2": "the model errs"}))
    picture = ensembles.write_after(made, str(tmp_path / "after"), str(tmp_path / "before"))
    told = json.loads((tmp_path / "before" / "ensemble.json").read_text())
    assert told["probabilities"][0]["value"] == 0.2 and told["after"]["probabilities"][0]["value"] == 0.4 and told["after"]["warnings"] == {"P2": "the model errs"}
    page = ensemble_part.beside(told | {"danger": None}, "level")
    assert "<td>P2</td><td>the model errs</td>" in page and "As in the scene stay other:" in page
    assert picture is None if level is None else os.path.getsize(picture) > 1000
    ensembles.write(made, {}, [], None, [], str(tmp_path / "before"))  # without the posterior
    assert not (tmp_path / "before" / "before_after.png").exists() and "after" not in json.loads((tmp_path / "before" / "ensemble.json").read_text())


def test_summary_has_prior_and_posterior():
    made = variables({"E": {"distribution": "lognormal", "mean": 10.0, "cov": 0.3}}, None)
    normal = np.random.default_rng(1).normal(0.5, 0.1, (4000, 1))
    row = posterior.summary(posterior.Posterior(["E"], [], BOX, normal, np.zeros((4000, 0), dtype=int), np.ones(1), np.full(1, 4000.0), 1), made)[0]
    assert row["prior_mean"] == pytest.approx(10.0, rel=1e-3) and row["prior_sd"] == pytest.approx(3.0, rel=2e-2)
    assert row["ratio"] == pytest.approx(0.1, rel=0.05) and row["low"] < row["mean"] < row["high"]


@pytest.mark.parametrize("keys, label", [
    (["loads.water.level", "loads.silt.level"], "level of water, silt [m]"),
    (["loads.water.level", "joints.base.friction"], "loads.water.level, joints.base.friction [SI; angles in degrees]"),
])  # fmt: skip
def test_an_axis_of_levels_is_in_metres(keys, label):
    assert ensembles.label_of(keys) == label
