"""The table of loads of results.h5: forces of each load on each face by closed forms, whole and above a cut through blocks, at the level that a flood has reached, on 1 and 2 ranks."""

import dataclasses
import math
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import yaml
from quoin_tools.assess import assessment, scene_loads, section_cut
from quoin_tools.assess.assessment_options import Options
from quoin_tools.assess.scene_loads import SceneLoads
from quoin_tools.base import scene as scenes
from quoin_tools.base.results import Results
from quoin_tools.base.sample_rows import Rows
from quoin_tools.base.solver import SolverError, environment
from quoin_tools.mesh.blockmesh import face_ends, write
from quoin_tools.mesh.meshing import join, rectangle, renamed

ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
pytestmark = pytest.mark.skipif(not QUOIN.exists(), reason="the solver is not built")
G, H, B, THICK = 9.81, 12.0, 8.0, 2.0  # an upright wall, its upstream face at x = 0, on a base
STILL, OVER, SILT, ICE, CUT, K_H = 9.5, 13.0, 4.0, 9.2, 3.3, 0.15  # no level and no cut is that of a block
WATER = 1000 * G * THICK
LOADS = {
    "weight": {"type": "self_weight", "groups": ["dam"]},
    "water": {"type": "reservoir", "faces": "up", "level": STILL},
    "over": {"type": "overflow", "faces": "up", "crest": "crest", "level": OVER, "velocity_head": 0.4, "crest_pressure": 0.5},
    "tail": {"type": "tailwater", "faces": "down", "level": 5.0, "effective": 0.6, "bottom": 0},
    "silt": {"type": "silt", "faces": "up", "level": SILT, "density": 800, "lateral": 0.4},
    "ice": {"type": "ice", "faces": "up", "level": ICE, "force": 150e3},
    "wave": {"type": "wave", "faces": "up", "level": STILL, "height": 1.2},
    "bridge": {"type": "crest_load", "faces": "crest", "value": [20e3, -50e3], "at": 5.2, "lever": 1.5},
    "wind": {"type": "traction", "faces": "down", "value": [-600.0, -100.0]},
    "gas": {"type": "pressure", "faces": "up", "pressure": 7e3},
    "shake": {"type": "pseudo_static", "coefficient": [K_H, 0], "groups": ["dam"], "faces": "up", "level": STILL},
    "lift": {"type": "uplift", "faces": "base_joint", "level": STILL, "tailwater": 2.0},
}


@pytest.fixture(autouse=True)
def this_solver(monkeypatch):
    monkeypatch.setenv("QUOIN_SOLVER", str(QUOIN))


def system(x, y, at):
    return np.array([x, y, at[0] * y - at[1] * x])


def by_hand(foot):
    """(X, Y, M about the origin) of each load on the wall above an elevation, over the thickness."""
    water = lambda level: system(WATER * (level - foot) ** 2 / 2, 0, (0, foot + (level - foot) / 3))  # noqa: E731
    surface, tail = OVER - 0.4, 0.6 * 5.0
    deep = WATER * (surface - np.array([foot, H]))  # pressure at the foot and at the crest
    over = system(deep.mean() * (H - foot), 0, (0, foot + (H - foot) * (deep[0] + 2 * deep[1]) / (3 * deep.sum())))
    back = WATER * max(0.0, tail - foot) ** 2 / 2
    s = (STILL - foot) / STILL  # of the depth: Westergaard's 7/8 rho a sqrt(H z), its force 7/12 and its moment 7/20 of sqrt(H) z^1.5, z^2.5
    shaken = WATER * K_H * STILL**2 * 7 / 12 * s**1.5
    side = THICK * (H - foot)
    return {
        "water": water(STILL), "over": over + system(0, -0.5 * WATER * (OVER - H) * B, (B / 2, H)), "tail": system(-back, 0, (B, foot + max(0.0, tail - foot) / 3)),
        "silt": 0.4 * 0.8 * water(SILT), "ice": system(150e3 * THICK, 0, (0, ICE)), "wave": system(2 * WATER * 1.2**2, 0, (0, STILL + 3 / 8 * 1.2)),
        "bridge": system(20e3 * THICK, -50e3 * THICK, (5.2, H + 1.5)), "wind": system(-600 * side, -100 * side, (B, (H + foot) / 2)),
        "gas": system(7e3 * side, 0, (0, (H + foot) / 2)), "shake": system(shaken, 0, (0, STILL - 3 / 5 * (STILL - foot))),
    }  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("loads")
    dam = rectangle(0, 0, B, H, 3, 5, group="dam")
    write(folder / "model.h5", join([renamed(rectangle(-2, -2, B + 4, 2, 1, 1, group="base", rigid=True), {}),
                                     renamed(dam, {"up": "left", "crest": "top", "down": "right", "base_joint": "bottom"})]))  # fmt: skip
    acting = [name for name in LOADS if name != "over"]
    keys = {
        "model": "model.h5", "thickness": THICK, "gravity": G, "strain": "small", "relaxation": {"tolerance": 1e-6},
        "materials": {"dam": {"density": 2400, "young": 1e11, "poisson": 0.2}, "base": {"density": 0, "rigid": True}},
        "joints": {"default": {"k_n": 1e10, "k_s": 1e10, "law": "elastic"}}, "supports": {"base": {"fix": "xy"}}, "loads": LOADS,
        "stages": [{"all": {"loads": acting}}, {"spilled": {"loads": ["weight", "over"]}},
                   {"flood": {"type": "flood", "loads": ["weight", "water"], "rises": ["water"], "step": 0.7, "limit": STILL + 0.7}}],
    }  # fmt: skip
    (folder / "scene.yaml").write_text(yaml.safe_dump(keys, sort_keys=False))
    for ranks in (1, 2):
        done = subprocess.run(["mpirun", "-n", str(ranks), QUOIN, "-options_file", "scene.yaml", "-output", f"out{ranks}"], cwd=folder, env=environment(2), capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 0, done.stderr
    return folder


def of_load(loads, name):
    return loads.of(name)


@pytest.mark.alone  # the first to ask for the runs
def test_whole_wall(folder):
    stages = {stage: Results(folder / "out1").stage(stage).loads for stage in ("all", "spilled")}
    for name, wanted in by_hand(0.0).items():
        mine = of_load(stages["spilled" if name == "over" else "all"], name)
        assert mine.systems().sum(axis=0) == pytest.approx(wanted, rel=1e-9, abs=1e-6), name
    assert not len(of_load(stages["all"], "weight").load) and not len(of_load(stages["all"], "over").load)


def test_uplift_presses_both_sides(folder):
    lift = of_load(Results(folder / "out1").stage("all").loads, "lift")
    up = lift.force[..., 1] > 0
    mean = WATER * (STILL + 2.0) / 2
    assert lift.systems()[up.any(axis=1)].sum(axis=0)[1] == pytest.approx(mean * B) and lift.force.sum() == pytest.approx(0, abs=1e-6)


def test_above_a_cut_through_blocks(folder):
    case = assessment.load_case(folder / "out1", Options())
    part = section_cut.cut(case.mesh, [(-1, CUT), (B + 1, CUT)])
    forces = {stage: case.forces(stage, part)[0] for stage in ("all", "spilled")}
    for name, wanted in by_hand(CUT).items():
        own = system(K_H * 2400 * G * THICK * B * (H - CUT), 0, (B / 2, (H + CUT) / 2)) if name == "shake" else 0
        found = forces["spilled" if name == "over" else "all"][name]
        assert found == pytest.approx(wanted + own, rel=1e-5) if name == "shake" else found == pytest.approx(wanted, rel=1e-6, abs=1e-1), name


def test_flood_has_the_loads_of_its_last_stable_trial(folder):
    results = Results(folder / "out1")
    level = results.stage_summary("flood")["flood"]["stable"]
    assert level == pytest.approx(STILL + 0.7)
    assert of_load(results.stage("flood").loads, "water").systems().sum(axis=0)[0] == pytest.approx(WATER * level**2 / 2)


def test_ranks_agree(folder):
    one, two = (Results(folder / f"out{ranks}").stage("all").loads for ranks in (1, 2))
    for name in ("load", "face", "point", "force"):
        assert np.array_equal(getattr(one, name), getattr(two, name)), name
    assert math.isclose(one.force.sum(), two.force.sum())


def test_restart_that_adds_a_load_before_the_others(folder):
    keys = yaml.safe_load((folder / "scene.yaml").read_text())
    keys["loads"] = {"snow": {"type": "crest_load", "faces": "crest", "value": [0, -1e3], "at": 4}} | keys["loads"]
    keys["stages"].append({"last": {"loads": ["weight", "water", "snow"]}})
    shutil.copytree(folder / "out1", folder / "added")
    (folder / "added.yaml").write_text(yaml.safe_dump(keys, sort_keys=False))
    done = subprocess.run([QUOIN, "-options_file", "added.yaml", "-output", "added", "-restart", "auto"], cwd=folder, env=environment(1), capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    case = assessment.load_case(folder / "added", Options())
    assert case.forces("all")[0]["water"] == pytest.approx(by_hand(0.0)["water"])
    assert case.forces("last")[0]["snow"] == pytest.approx(system(0, -1e3 * THICK, (4, H)))


BATTERED = {
    "weight": {"type": "self_weight", "groups": ["dam"]},
    "water": {"type": "reservoir", "faces": "up", "level": 17.3},
    "tail": {"type": "tailwater", "faces": "down", "level": 4.1, "effective": 0.7, "bottom": 0.2},
    "silt": {"type": "silt", "faces": "up", "level": 5.7, "density": 900, "friction": 28},
    "ice": {"type": "ice", "faces": "up", "level": 16.9, "force": 120e3},
    "molitor": {"type": "wave", "faces": "up", "level": 17.3, "fetch": 9e3, "wind": 25},
    "sainflou": {"type": "wave", "faces": "up", "level": 17.3, "formula": "sainflou", "height": 0.9, "length": 22, "bottom": 0.1},
    "bridge": {"type": "crest_load", "faces": "crest", "value": [20e3, -50e3], "at": 2.2, "lever": 1.5},
    "wind": {"type": "traction", "faces": "down", "value": [-600.0, -100.0]},
    "gas": {"type": "pressure", "faces": "down", "pressure": 7e3},
    "westergaard": {"type": "pseudo_static", "coefficient": [0.13, 0.04], "groups": ["dam"], "faces": "up", "level": 17.3},
    "zangar": {"type": "pseudo_static", "coefficient": [0.13, 0], "groups": ["dam"], "faces": "up", "level": 17.3, "rule": "zangar"},
}  # fmt: skip


AT, WEIGHT = (0.5 * (values + shift) for values, shift in zip(np.polynomial.legendre.leggauss(24), (1.0, 0.0)))


def pushed(wall, sense, pressure, breaks=(), lateral=1.0):
    """(X, Y, M) of a pressure of the elevation on a wall (n, 2), from its foot up; sense: 1 where the dam is to its right. Corners of the pressure are among the breaks, where it may begin as the root of the depth."""
    total = np.zeros(3)
    for a, b in zip(wall[:-1], wall[1:]):
        cuts = sorted({0.0, 1.0, *((y - a[1]) / (b[1] - a[1]) for y in breaks if a[1] < y < b[1])})
        for s, t in zip(cuts[:-1], cuts[1:]):
            for at, weight in zip(s + (t - s) * (1 - (1 - AT) ** 2), (t - s) * 2 * (1 - AT) * WEIGHT):
                place = a + at * (b - a)
                total += system(*(THICK * weight * pressure(place[1]) * sense * np.array([lateral * (b[1] - a[1]), a[0] - b[0]])), place)
    return total


def line(wall, force, y):
    """(X, Y, M) of a horizontal force at an elevation of a wall."""
    return system(THICK * force, 0.0, (np.interp(y, wall[:, 1], wall[:, 0]), y))


def battered_by_hand(up, down, sense, at):
    """(X, Y, M) of each load of BATTERED. up, down: the walls."""
    unit, level, lengths = 1000 * G, 17.3, np.hypot(*np.diff(down, axis=0).T)
    still = lambda top, gamma=unit: lambda y: gamma * max(0.0, top - y)  # noqa: E731
    tail, rankine, km = 0.2 + 0.7 * 3.9, (1 - math.sin(math.radians(28))) / (1 + math.sin(math.radians(28))), 9.0
    molitor = 0.032 * math.sqrt(3.6 * 25 * km) + 0.763 - 0.271 * km**0.25  # Stevenson's height
    k, d, h = 2 * math.pi / 22, level - 0.1, 0.9
    mean, bottom = math.pi * h**2 / 22 / math.tanh(k * d), h / math.cosh(k * d)  # Sainflou: rise of the mean level, head at the bottom
    wave = lambda y, p: (lambda z: unit * np.interp(z, y, p, left=0.0), y)  # noqa: E731
    small, large = wave((level - molitor / 3, level + molitor / 8, level + 4 * molitor / 3), (0, 2.4 * molitor, 0)), wave((0.1, level, level + h + mean), (bottom, (bottom + d) * (h + mean) / (d + h + mean), 0))
    # inertia to the right: water to the left of the dam presses, water to its right sucks
    lean = math.degrees(math.atan(abs(np.interp(level, up[:, 1], up[:, 0]) - up[0, 0]) / level))
    largest = 0.7412 - 0.0073 * lean
    upward = [np.array(wall)[None] for wall in zip(up[:-1], up[1:])]

    def westergaard(wall):
        (a, b), = wall
        return pushed(np.array([a, b]), sense, lambda y: sense * 0.13 * unit * 7 / 8 * math.sqrt(level * max(0.0, level - y)) * (b[1] - a[1]) / math.hypot(*(b - a)), (level,))

    def zangar(y):
        s = max(0.0, level - y) / level
        return sense * 0.13 * unit * level * largest / 2 * (s * (2 - s) + math.sqrt(s * (2 - s)))

    return {
        "water": pushed(up, sense, still(level), (level,)), "tail": pushed(down, -sense, still(tail), (tail,)), "silt": pushed(up, sense, still(5.7, 900 * G), (5.7,), rankine),
        "ice": line(up, sense * 120e3, 16.9), "molitor": pushed(up, sense, *small), "sainflou": pushed(up, sense, *large), "bridge": system(20e3 * THICK, -50e3 * THICK, (at, 19 + 1.5)),
        "wind": sum(system(-600 * THICK * n, -100 * THICK * n, (a + b) / 2) for n, a, b in zip(lengths, down[:-1], down[1:])), "gas": pushed(down, -sense, lambda y: 7e3),
        "westergaard": sum(westergaard(wall) for wall in upward), "zangar": pushed(up, sense, zangar, (level,)),
    }  # fmt: skip


@pytest.mark.parametrize("mirrored", [False, True])
def test_loads_on_battered_faces(tmp_path, mirrored):
    """Each kind by hand, of a run and of a scene that has not been run, on a dam with two batters and with its water on either side."""
    flat = rectangle(0, 0, 6, 19, 2, 7, group="dam")
    share = flat.vertices[:, 1] / 19
    flat.vertices[:, 0] = (flat.vertices[:, 0] - 2.4) * (3.1 - 2.1 * share) + 3 * np.minimum(share, 0.5)  # both faces lean, upstream with a kink
    dam = renamed(flat, {"up": "left", "crest": "top", "down": "right", "bottom": "bottom"})
    if mirrored:
        dam = renamed(flat, {"up": "right", "crest": "top", "down": "left", "bottom": "bottom"})
    write(tmp_path / "model.h5", dam)
    at = float(np.median(flat.vertices[flat.vertices[:, 1] > 18.9, 0]))
    loads = {name: load | {"at": at} if name == "bridge" else load for name, load in BATTERED.items()}
    keys = {
        "model": "model.h5", "thickness": THICK, "gravity": G, "strain": "small", "materials": {"dam": {"density": 2400, "young": 1e11, "poisson": 0.2}},
        "supports": {"bottom": {"fix": "xy"}}, "loads": loads, "stages": [{"all": {"loads": list(loads)}}],
    }  # fmt: skip
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(keys, sort_keys=False))
    done = subprocess.run([QUOIN, "-options_file", "scene.yaml", "-output", "out"], cwd=tmp_path, env=environment(1), capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    used = scenes.read(tmp_path / "scene.yaml")
    of_run, alone = Results(tmp_path / "out").stage("all").loads, SceneLoads(dam, used).of(used, "all").table
    assert np.array_equal(of_run.face, alone.face) and np.array_equal(of_run.point, alone.point) and np.array_equal(of_run.force, alone.force)
    walls = [np.unique(dam.vertices[face_ends(dam, dam.face_sets[name])].reshape(-1, 2), axis=0) for name in ("up", "down")]
    hand = battered_by_hand(*(wall[np.argsort(wall[:, 1])] for wall in walls), -1 if mirrored else 1, at)
    assert {of_run.names[row] for row in of_run.load} == set(hand) == set(loads) - {"weight"}
    for name, wanted in hand.items():
        found = of_run.of(name).systems().sum(axis=0)
        assert np.abs(wanted[:2]).max() > 1e3 and found == pytest.approx(wanted, rel=1e-9, abs=1e-9 * np.abs(wanted).max()), name


def test_floods_and_other_numbers(monkeypatch):
    """A process answers for levels of a flood and for other numbers of loads, with loads of its own for each stage; what it cannot is one line."""
    dam = renamed(rectangle(0, 0, B, H, 3, 5, group="dam", rigid=True), {"up": "left", "crest": "top", "down": "right"})
    keys = {"thickness": THICK, "gravity": G, "materials": {"dam": {"density": 2400}}, "stages": [{"full": {"loads": ["weight", "water", "gas"]}}, {"flood": {"type": "flood", "loads": ["water", "wave", "tail"]}}],
            "loads": {name: LOADS[name] for name in ("weight", "water", "gas", "wave", "tail")}}  # fmt: skip
    used = scenes.parse(yaml.safe_dump(keys, sort_keys=False), "scene.yaml")
    asked = SceneLoads(dam, used)
    on = lambda scene, stage, name, rise=0.0: asked.of(scene, stage, rise).table.of(name).force[..., 0].sum()  # noqa: E731
    assert on(used, "full", "water") == pytest.approx(WATER * STILL**2 / 2)
    flood = asked.of(used, "flood", 1.3)
    assert (flood.start, flood.rises) == (STILL, ("water", "wave"))
    assert on(used, "flood", "water", 1.3) == pytest.approx(WATER * (STILL + 1.3) ** 2 / 2)
    assert on(used, "flood", "tail", 1.3) == pytest.approx(-WATER * (0.6 * 5) ** 2 / 2)
    running = asked.rows
    for level in (4.0, 6.0):
        other = dataclasses.replace(used, loads=used.loads | {"tail": used.loads["tail"] | {"level": level}})
        assert on(other, "flood", "tail") == pytest.approx(-WATER * (0.6 * level) ** 2 / 2)
    assert asked.rows is not running  # for the first other number a new process, for the next the same
    none = dataclasses.replace(used, loads=used.loads | {"water": used.loads["water"] | {"density": 0.0}})
    still = SceneLoads(dam, used, floods=False).of(none, "full").table
    assert still.of("gas").force[..., 0].sum() == pytest.approx(7e3 * THICK * H) and not len(still.of("water").load)
    monkeypatch.setattr(scene_loads, "MOST", 0)  # of more numbers than a row has each set needs a process
    fresh = SceneLoads(dam, used)
    for pressure in (2e3, 3e3):
        other = dataclasses.replace(used, loads=used.loads | {"gas": used.loads["gas"] | {"pressure": pressure}})
        assert fresh.of(other, "full").table.of("gas").force[..., 0].sum() == pytest.approx(pressure * THICK * H) and not fresh.columns
    running = asked.rows
    assert on(used, "flood", "tail") == pytest.approx(-WATER * (0.6 * 5) ** 2 / 2) and asked.rows is running
    assert on(used, "full", "gas") == pytest.approx(7e3 * THICK * H)
    turned = dataclasses.replace(used, loads=used.loads | {"gas": used.loads["gas"] | {"faces": "down"}})
    assert on(turned, "full", "gas") == pytest.approx(-7e3 * THICK * H)
    for row, why in (("a,x,flood", "rise: 'x' is not a number [m]"), ("a,,flood", "rise: '' is not a number [m]"), ("a,1,none", "loads: no stage named 'none'")):
        rows = Rows(["-options_file", asked.path("scene.yaml"), "-model", asked.path("model.h5")], "sample,rise,loads")
        assert [rows.answer(row)[key] for key in ("outcome", "why", "on_faces")] == ["refused", why, ""] and rows.close()[0] == 0
    wrong = dataclasses.replace(used, loads=used.loads | {"tail": used.loads["tail"] | {"effective": 7.0}})
    with pytest.raises(SolverError, match=r"^loads.tail.effective: 7.0 is out of range"):
        asked.of(wrong, "flood")
    assert on(used, "flood", "water", 2.0) == pytest.approx(WATER * (STILL + 2.0) ** 2 / 2)
