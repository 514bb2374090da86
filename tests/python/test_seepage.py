"""Water in joints in the tools: table, pictures, gravity method, sheet, CSV, comparison; on rigid dams, whose numbers are known.

The dam stands on its base joint of 28 m (aperture 0.15 mm at rest, k_n 20 GPa/m) with 37 m of water. A frame of blocks of 1 m is a dam with a
free surface (24 and 4 m of water)."""

import csv
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from matplotlib import pyplot  # noqa: E402
from quoin_tools.assess import assessment, base_water, terminal  # noqa: E402
from quoin_tools.assess.assessment_options import options_from, parser  # noqa: E402
from quoin_tools.base import results as tables  # noqa: E402
from quoin_tools.base.flow import Flow  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh import blockmesh  # noqa: E402
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed, separated  # noqa: E402
from quoin_tools.show import compare, export, plots, report, seepage, style  # noqa: E402
from sealed import read_summary, write_summary  # noqa: E402

QUOIN = os.environ.get("QUOIN", str(ROOT / "build" / "quoin"))
LEVEL, WIDTH, GW = 37.0, 28.0, 9810.0
WATER = ["weight", "water", "up", "down"]

pytestmark = pytest.mark.skipif(not os.path.exists(QUOIN), reason="the solver is not built")


@pytest.fixture(autouse=True)
def pictures(request, monkeypatch):
    """As in test_report.py: pictures are put together and left undrawn, but by tests marked `drawn`."""
    if not request.node.get_closest_marker("drawn"):
        monkeypatch.setattr(style, "save_figure", lambda figure, path, **options: Path(path).write_bytes(b"none"))


def solve(folder, mesh, scene):
    folder.mkdir(exist_ok=True)
    blockmesh.write(folder / "model.h5", mesh)
    (folder / "scene.yaml").write_text(yaml.safe_dump({"model": "model.h5", "output": "."} | scene, sort_keys=False), encoding="utf-8")
    done = subprocess.run([QUOIN, "-options_file", "scene.yaml"], cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return folder


def dam_mesh():
    rock = renamed(rectangle(0, -2, WIDTH, 2, 14, 1, group="rock", rigid=True))
    dam = quad_patch((0, 0), (WIDTH, 0), (4, 38), (0, 38), 14, 1, group="dam", rigid=True)
    return join([rock, renamed(dam, {"upstream": "left", "downstream": "right", "base": "bottom"}, {"heel": "bottom_left"})])


def dam_scene(stages, level=LEVEL, **loads):
    return {
        "strain": "small", "relaxation": {"tolerance": 1e-8, "velocity_tolerance": 1e-8},
        "materials": {"rock": {"density": 2400, "rigid": True}, "dam": {"density": 2350, "rigid": True}},
        "joints": {"default": {"k_n": 2e10, "k_s": 2e10, "friction": 45},
                   "base": {"aperture": 1.5e-4, "aperture_residual": 3e-5, "aperture_max": 1e-3}},
        "supports": {"rock": {"fix": "xy"}},
        "loads": {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": {"type": "reservoir", "faces": "upstream", "level": level},
                  "up": {"type": "head", "faces": "upstream", "level": level}, "down": {"type": "head", "faces": "downstream", "level": 0},
                  "drain": {"type": "drain", "joint": "base", "distance": 4, "gallery": 2}, **loads},
        "stages": stages,
    }  # fmt: skip


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    stages = [{"dry": {"loads": ["weight"]}}, {"full": {"loads": WATER}}, {"drained": {"loads": [*WATER, "drain"]}}]
    return solve(tmp_path_factory.mktemp("dam"), dam_mesh(), dam_scene(stages))


@pytest.fixture(scope="module")
def frame(tmp_path_factory):
    dam = separated(renamed(rectangle(0, 0, 16, 26, 16, 26, group="dam", rigid=True), {"upstream": "left", "downstream": "right", "base": "bottom"}), ["dam"])
    a = 2e-4
    scene = dam_scene([{"seep": {"loads": ["weight", "up", "down"]}}])
    scene["supports"]["dam"] = {"fix": "xy"}
    scene["joints"]["default"] |= {"aperture": a, "aperture_residual": a, "aperture_max": a}
    scene["joints"]["base"] = dict.fromkeys(("aperture", "aperture_residual", "aperture_max"), a * 0.5 ** (1 / 3))
    scene["loads"]["up"]["level"], scene["loads"]["down"]["level"] = 24, 4
    return solve(tmp_path_factory.mktemp("frame"), join([rectangle(0, -2, 16, 2, 16, 1, group="rock", rigid=True), dam]), scene)


@pytest.fixture
def copy(run, tmp_path):
    return Path(shutil.copytree(run, tmp_path / "copy"))


def case_of(folder, *arguments):
    return assessment.load_case(str(folder), options_from(parser("assessment", "").parse_args([str(folder), *arguments])))


def assess(folder, *arguments):
    case = case_of(folder, *arguments)
    found, complaints = assessment.assess(case)
    return {(a.stage, a.name): a for a in found}, complaints


def changed(folder, stage, **members):
    """The summary of a run with other numbers of the water in a stage."""
    summary = read_summary(folder)
    next(s for s in summary["stages"] if s["name"] == stage)["flow"] |= members
    write_summary(folder, summary)
    return folder


def rows_of(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


# ---- the table


def test_table_of_a_stage(run):
    results = Results(run)
    assert results.stage("dry").flow is None
    flow, facts = results.stage("drained").flow, results.stage_summary("drained")["flow"]
    assert len(flow) == facts["pieces"] == 14 and flow.point.shape == (14, 2, 2)  # the drain is where contacts meet
    assert {results.mesh.joint_names[row] for row in flow.joint} == {"base"} and flow.length.sum() == pytest.approx(WIDTH)
    assert flow.pressure == pytest.approx(GW * flow.pressure_head, abs=1e-3 * GW) and flow.wet().all()
    force = (0.5 * flow.length * flow.pressure.sum(axis=1)).sum()
    assert force == pytest.approx(facts["joints"]["base"]["uplift"], rel=1e-12)
    flux = np.sort(np.abs(flow.discharge))  # to the drain through two contacts, beyond it through twelve
    up, down = (abs(facts["conditions"][name]["discharge"]) for name in ("up", "down"))
    assert flux[-2:] == pytest.approx(up, rel=1e-9) and flux[:12] == pytest.approx(down, rel=1e-9)


def test_pieces_in_order_along_a_joint(run):
    results = Results(run)
    flow, row = results.stage("full").flow, results.mesh.joint_names.index("base")
    distance, pressure, aperture = flow.along(row, np.array([0.0, 0.0]), np.array([WIDTH, 0.0]))
    assert distance.ravel() == pytest.approx(np.repeat(np.arange(0, 29, 2.0), 2)[1:-1])
    assert (np.diff(pressure.ravel()) <= 0).all() and pressure[0, 0] == pytest.approx(GW * LEVEL) and pressure[-1, 1] == 0
    assert pressure[1:, 0] == pytest.approx(pressure[:-1, 1]) and aperture[0, 0] > aperture[-1, 1]
    backwards = flow.along(row, np.array([WIDTH, 0.0]), np.array([0.0, 0.0]))
    assert backwards[0].ravel() == pytest.approx(distance.ravel()) and backwards[1] == pytest.approx(pressure[::-1, ::-1])


def pieces(aperture, head, saturation=((1, 1), (1, 1))):
    """Two pieces of a level joint in a row."""
    columns = {"aperture": aperture, "head": head, "pressure": GW * np.array(head), "saturation": saturation}
    point = [[0, 0, 1, 0], [1, 0, 2, 0]]
    return Flow(np.array(point, float), **{name: np.array(rows, float) for name, rows in columns.items()}, discharge=np.zeros(2), length=np.ones(2),
                joint=np.zeros(2))  # fmt: skip


@pytest.mark.parametrize("aperture, head, saturation, coarse", [
    (((3, 1), (1, 1)), ((10, 5), (5, 0)), ((1, 1), (1, 1)), [0]),
    (((2, 1), (1, 3)), ((10, 5), (5, 0)), ((1, 1), (1, 1)), [1]),  # a ratio of 2 is none of more
    (((3, 1), (1, 1)), ((10, 9.5), (9.5, 0)), ((1, 1), (1, 1)), []),  # it carries little
    (((3, 1), (1, 1)), ((10, 5), (5, 0)), ((1, 0.5), (1, 1)), []),  # nothing presses in it
])  # fmt: skip
def test_pieces_that_are_too_coarse(aperture, head, saturation, coarse):
    assert pieces(aperture, head, saturation).too_coarse().tolist() == coarse


def test_columns_must_belong_together():
    flow = pieces(((1, 1), (1, 1)), ((1, 1), (1, 1)))
    with pytest.raises(ValueError, match="do not belong together"):
        Flow(flow.point.reshape(-1, 4), flow.head[:1], flow.pressure, flow.aperture, flow.saturation, flow.discharge, flow.length, flow.joint)


def test_terminal_table(run, capsys):
    assert tables.main([str(run)]) == 0
    text = capsys.readouterr().out
    facts = Results(run).stage_summary("drained")["flow"]

    def row(section, *words):
        lines = text.split(section)[1].split("\n\n")[0].splitlines()
        return next(line.split()[2:] for line in lines if line.split()[:2] == list(words))

    drain, base = facts["conditions"]["drain"], facts["joints"]["base"]
    assert row("Water that leaves", "drained", "drain") == [f"{drain['discharge']:+.4e}", f"{drain['litres_per_minute']:+.4f}"]
    assert drain["discharge"] > 0 and row("Force of the water", "drained", "base")[:3] == ["28.000", f"{base['uplift'] / 1e3:.1f}", f"{base['centre_x']:.3f}"]
    assert row("Water that flows", "drained", "steady")[0] == str(facts["rounds"]) and "dry" not in text.split("Water that flows")[1].split("Why")[0]


def test_numbers_that_are_none(copy, capsys):
    nothing = {"conditions": {"up": {"nodes": 1, "discharge": None, "litres_per_minute": None}}, "inflow": None, "change": None, "reynolds": None}
    changed(copy, "full", **nothing)
    assert tables.main([str(copy)]) == plots.main([str(copy)]) == report.main([str(copy)]) == export.main([str(copy)]) == 0
    assert ["full", "up", "-", "-"] in [line.split() for line in capsys.readouterr().out.splitlines()]


# ---- pictures


@pytest.mark.drawn
def test_pictures_of_stages_with_flow_only(run, capsys):
    assert plots.main([str(run)]) == 0
    paths = [Path(line) for line in capsys.readouterr().out.split()]
    wet = {path.stem for path in paths if path.stem.startswith(("water", "uplift"))}
    assert wet == {f"{kind}_{stage}" for kind in ("water", "uplift_base") for stage in ("full", "drained")}
    assert all(path.stat().st_size > 10000 for path in paths if path.stem in wet)


def test_free_surface(frame):
    """Within 0.2 m of that of a network of 0.125 m, by an independent program."""
    flow = Results(frame).stage("seep").flow
    places = dict(map(tuple, np.round(seepage.free_surface(flow), 6)))
    assert sorted(places) == list(range(1, 16))  # one in each upright joint
    assert [places[x] for x in (4, 8, 12)] == pytest.approx([22.58, 20.41, 17.43], abs=0.2)
    assert not len(seepage.free_surface(pieces(((1, 1), (1, 1)), ((5, 4), (4, 3)))))


def test_bars_lie_below_and_left(frame):
    flow = Results(frame).stage("seep").flow
    box = seepage.box_of(Results(frame).mesh, flow, whole=False)
    rows = np.flatnonzero(flow.pressure.min(axis=1) > 0)
    drawn = seepage.bars(flow, rows, box)
    way = drawn[:, 3] - drawn[:, 0]  # from the first end to its tip
    level = np.abs(np.diff(flow.point[rows][..., 1], axis=1)[:, 0]) < 1e-9
    assert (way[level, 1] < 0).all() and np.abs(way[level, 0]).max() < 1e-9 and (way[~level, 0] < 0).all()
    metres = seepage.longest_bar(flow, rows, box)
    assert metres < 1.0  # joints are 1 m apart
    assert np.hypot(*way.T) == pytest.approx(metres * flow.pressure[rows, 0] / flow.pressure[rows].max())


def test_bars_of_a_joint_that_rises_a_little_are_long(run):
    flow = Results(run).stage("full").flow
    box, rows = seepage.box_of(Results(run).mesh, flow, whole=False), np.arange(len(flow))
    level = seepage.longest_bar(flow, rows, box)
    flow.point[..., 1] += 0.001 * flow.point[..., 0]
    assert seepage.longest_bar(flow, rows, box) == level == pytest.approx(seepage.REACH * (box[3] - box[2]))


def test_arrows_follow_the_water(frame):
    flow = Results(frame).stage("seep").flow
    box = seepage.box_of(Results(frame).mesh, flow, whole=False)
    chosen = seepage.arrows(flow, seepage.seen_in(flow, box), box)
    way = (flow.point[chosen, 1] - flow.point[chosen, 0]) * np.sign(flow.discharge[chosen])[:, None]
    level = np.abs(way[:, 1]) < 1e-9
    assert level.sum() > 50 and (way[level, 0] > 0).all() and (way[~level, 1] < 0).all()  # downstream, and down


def test_what_flows_in_words():
    conditions = {"rounding": 1e-16, "none": None} | {f"drain{i}": i * 1e-6 for i in range(1, 7)} | {"up": -2.1e-5}
    facts = {"conditions": {name: {"discharge": q} for name, q in conditions.items()}}
    assert seepage.what_flows(facts) == ["up gives 1.26, drain6 takes 0.36, drain5 takes 0.3", "drain4 takes 0.24, drain3 takes 0.18, drain2 takes 0.12", "1 more"]


def test_water_that_stands_still(frame):
    """What rounding leaves has no lines and no arrows."""
    flow = Results(frame).stage("seep").flow
    figure, axes = pyplot.subplots()
    box = seepage.box_of(Results(frame).mesh, flow, whole=False)
    assert seepage.draw_discharge(axes, flow, box)
    flow.discharge *= 1e-12
    assert seepage.draw_discharge(axes, flow, box) == [] and "stands still" in axes.get_title()
    pyplot.close(figure)


def test_steps_in_time(copy, monkeypatch):
    """A transient stage: its history is drawn, and both methods have the levels of its last step."""
    summary = read_summary(copy)
    stage = next(s for s in summary["stages"] if s["name"] == "full")
    waters = [{"water": {"level": level}, "up": {"level": level}, "down": {"level": 0}} for level in (36, 35, LEVEL)]
    stage["steps"] = [{"value": 2.0 * k, "waters": water, "flow": stage["flow"] if k else None} for k, water in enumerate(waters)]
    write_summary(copy, summary)
    assert case_of(copy).scene.stage_loads("full")["water"]["level"] == LEVEL and not assess(copy)[1]["full"]
    drawn = []
    monkeypatch.setattr(seepage.style, "save", lambda figure, path: drawn.append(figure))
    assert seepage.plot_transient(Results(copy), "full", "x") and not seepage.plot_transient(Results(copy), "drained", "x")
    levels, forces, discharges = ({line.get_label(): line.get_ydata() for line in axes.lines} for axes in drawn[0].axes)
    assert list(levels["up"]) == [36, 35, LEVEL] and list(drawn[0].axes[0].lines[0].get_xdata()) == [0, 2, 4]
    assert forces["base"][1:] == pytest.approx([stage["flow"]["joints"]["base"]["uplift"] / 1e3] * 2) and np.isnan(forces["base"][0])
    assert discharges["up"][1] == pytest.approx(stage["flow"]["conditions"]["up"]["litres_per_minute"]) and set(discharges) == {"up", "down"}
    pyplot.close("all")
    stage["steps"][-1]["waters"] = waters[0]
    write_summary(copy, summary)
    assert any("is not what was run" in line for line in assess(copy)[1]["full"])


def legend(stage, results):
    figure, axes = pyplot.subplots()
    facts = results.stage_summary(stage)["joints"]["base"]
    row = results.mesh.joint_names.index("base")
    ends = [np.array([facts[at]["x"], facts[at]["y"]]) for at in ("start", "end")]
    seepage.draw_uplift(axes, results, stage, "base", results.stage(stage).flow.along(row, *ends), facts["chord"])
    words = [text.get_text() for text in axes.get_legend().get_texts()]
    pyplot.close(figure)
    return words


def test_legend_of_the_uplift(run):
    results = Results(run)
    for stage in ("full", "drained"):
        joint = results.stage_summary(stage)["flow"]["joints"]["base"]
        computed, straight = legend(stage, results)
        assert computed == f"computed: {seepage.style.plain(joint['uplift'] / 1e3)} kN at {joint['centre_x']:.2f} m"
        assert straight.endswith(f": {seepage.style.plain(0.5 * 9.81 * LEVEL * WIDTH)} kN at {WIDTH / 3:.2f} m")


def test_water_that_does_not_reach_an_end():
    distance, pressure = np.array([[0.0, 2.0], [2.0, 3.0]]), np.array([[9.0, 6.0], [6.0, 6.0]])
    assert seepage.end_pressures(distance, pressure, 3.0).tolist() == [9.0, 6.0]
    assert seepage.end_pressures(distance, pressure, 8.0).tolist() == [9.0, 0.0]
    force, centre = seepage.resultant(distance, pressure)
    assert force == pytest.approx(21.0) and centre == pytest.approx((15 * 14 / 15 + 6 * 2.5) / 21)


def test_uplift_where_water_flows_is_refused(tmp_path):
    """Both would press: the water would count twice."""
    rule = {"type": "uplift", "faces": "base", "level": 20, "rule": "npb", "drain": 4}
    folder = tmp_path / "both"
    folder.mkdir()
    blockmesh.write(folder / "model.h5", dam_mesh())
    scene = dam_scene([{"dry": {"loads": ["weight"]}}, {"both": {"loads": [*WATER, "rule"]}}], 20, rule=rule)
    (folder / "scene.yaml").write_text(yaml.safe_dump({"model": "model.h5"} | scene, sort_keys=False), encoding="utf-8")
    done = subprocess.run([QUOIN, "-options_file", "scene.yaml"], cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 2 and "water flows in the joint 'base' and presses on 'base' too" in done.stderr


# ---- beside the gravity method


def test_gravity_method_has_the_computed_water(run):
    found, complaints = assess(run)
    assert not any(complaints.values()) and found["dry", "base"].computed is None
    results = Results(run)
    weight = 9.81 * 2350 * 0.5 * (WIDTH + 4) * 38
    for stage in ("full", "drained"):
        base, joint = found[stage, "base"], results.stage_summary(stage)["flow"]["joints"]["base"]
        assert base.computed[1] == pytest.approx(joint["uplift"], rel=1e-9) and base.computed[0] == pytest.approx(0, abs=1e-3)
        assert base_water.centre(base.base, base.computed) == pytest.approx(joint["centre_x"], rel=1e-9)
        assert base.hand.N == pytest.approx(weight - joint["uplift"], rel=1e-9) and base.hand.T == pytest.approx(GW * LEVEL**2 / 2, rel=1e-9)
        for key, number in (("N", base.hand.N), ("T", base.hand.T), ("M", base.hand.M), ("uplift", joint["uplift"])):
            assert base.block[key] == pytest.approx(number, rel=1e-5), key
        assert base.block["crack"] == pytest.approx(base.hand.crack, abs=0.05)
        assert "does not know" not in " ".join(base.notes)
    assert found["full", "base"].hand.crack > 1.5


def test_uplift_side_by_side(run):
    """In the stage with a drain the rule has it, in the other it is the straight line."""
    found, _ = assess(run, "--uplift", "npb", "--drain", "4")
    line, drained = 0.5 * 9.81 * LEVEL * WIDTH, 9.81 * LEVEL * (4 * (1 + 1 / 3) / 2 + 24 / 3 / 2)
    for stage, rule in (("full", line), ("drained", drained)):
        base = found[stage, "base"]
        computed, straight, prescribed = base_water.side_by_side(base)
        assert computed[:2] == ("computed", pytest.approx(1e-3 * base.computed[1])) and straight[1] == pytest.approx(line, rel=1e-6)
        assert straight[2] == pytest.approx(WIDTH / 3, rel=1e-6) and prescribed[:2] == ("rule npb", pytest.approx(rule, rel=1e-6))
        weight = base.hand.N + base.computed[1]
        for row in (computed, straight, prescribed):
            assert row[4] == pytest.approx((weight - 1e3 * row[1]) / base.hand.T, rel=1e-6) == row[6]  # friction of 45 degrees
        assert computed[3] == pytest.approx(computed[4], rel=1e-4) and straight[3] is prescribed[3] is None
    assert any("No drain was given" in note for note in found["full", "base"].notes)


def test_limits_count_computed_water_and_rule(run):
    arguments = ["--guideline", "usace", "--strength", "10e6", "--condition", "full=usual", "--condition", "drained=usual"]
    found, _ = assess(run, *arguments, "--uplift", "usace", "--drain", "4", "--efficiency", "0.5", "--uplift-in-crack", "unchanged")
    for stage, governs in (("full", "hand"), ("drained", "with_uplift")):  # without a drain more than the straight line, with it less than the rule
        base = found[stage, "base"]
        values = {limit.quantity: limit.value for limit in base.limits}
        assert values["sliding_peak"] == pytest.approx(getattr(base, governs).sliding_factor(45), rel=1e-4)
        assert values["middle"] == pytest.approx(2 * abs(getattr(base, governs).eccentricity) / WIDTH, rel=1e-4)
    alone = assess(run, *arguments)[0]["drained", "base"]
    assert not alone.complete and any("Uplift is the computed one; this guideline goes with rule usace" in note for note in alone.notes)
    assert not any("no uplift" in note for note in alone.notes)


def test_a_path_through_joints_has_their_water(frame):
    """At 10 m, and along two levels: what presses on the level pieces of the path, and the upright one."""
    flow = Results(frame).stage("seep").flow
    middle = flow.point.mean(axis=1)
    found, _ = assess(frame, "--path", "lift=0,10,16,10", "--path", "step=0,10,8,10,8,5,16,5")

    def force(here):
        return (0.5 * flow.length * flow.pressure.sum(axis=1))[here].sum()

    low = np.abs(middle[:, 1] - 10) < 1e-9
    assert found["seep", "lift"].computed[:2] == pytest.approx([0, force(low)], rel=1e-9, abs=1e-3)
    part = case_of(frame)
    step = base_water.computed(part, "seep", part.part("step", np.array([[0, 10], [8, 10], [8, 5], [16, 5.0]])))
    left, right = low & (middle[:, 0] < 8), (np.abs(middle[:, 1] - 5) < 1e-9) & (middle[:, 0] > 8)
    upright = (np.abs(middle[:, 0] - 8) < 1e-9) & (middle[:, 1] > 5) & (middle[:, 1] < 10)
    assert step[:2] == pytest.approx([force(upright), force(left | right)], rel=1e-9)

    def moment(here, axis):  # Simpson's rule, exact
        x, p = (np.column_stack([ends[here, 0], ends[here].mean(axis=1), ends[here, 1]]) for ends in (flow.point[..., axis], flow.pressure))
        return (flow.length[here] / 6 * ((x * p) @ [1, 4, 1])).sum()

    assert step[2] == pytest.approx(moment(left | right, 0) - moment(upright, 1), rel=1e-9)


def test_levels_of_heads_at_the_ends(frame):
    """No reservoir: the heads whose faces come to the ends of the base."""
    base = assess(frame)[0]["seep", "base"]
    assert base_water.water_levels(case_of(frame), "seep", base.base) == (24.0, 4.0)
    line = assess(frame, "--uplift", "linear")[0]["seep", "base"]
    assert base_water.side_by_side(line)[2][1] == pytest.approx(0.5 * 9.81 * (24 + 4) * 16, rel=1e-6)


@pytest.mark.parametrize("members, said, spoils", [
    ({"reynolds": 499.0}, None, False),
    ({"reynolds": 500.0}, "Reynolds number 500: from 500 on", False),
    ({"reynolds": 2000.0}, "is not laminar: Reynolds number 2000", True),
    ({"error": 2e-8}, "does not balance: a node is out by 2.0e-08 of the inflow", True),
    ({"error": 0.3, "inflow": 1e-19}, None, False),  # a crack that leads nowhere: of nothing
    ({"error": None}, "a node is out by inf of the inflow", True),
    ({"cut_off_length": 3.5}, "Joints of 3.50 m are cut off from every head", False),
    ({"state": "frozen"}, "pressures are those of the stage before", False),
])  # fmt: skip
def test_what_is_said_of_the_water(copy, members, said, spoils):
    found, complaints = assess(changed(copy, "full", **members))
    lines = complaints["full"] + base_water.remarks(Results(copy), "full")
    assert any(said in line for line in lines) if said else not lines
    assert found["full", "base"].complete != spoils and found["drained", "base"].complete


def test_wide_and_narrow_ends_are_said(tmp_path):
    """A base that opens within one contact."""
    mesh = join([rectangle(0, -2, WIDTH, 2, 1, 1, group="rock", rigid=True), renamed(
        quad_patch((0, 0), (WIDTH, 0), (4, 38), (0, 38), 1, 1, group="dam", rigid=True), {"upstream": "left", "downstream": "right", "base": "bottom"})])
    scene = dam_scene([{"dry": {"loads": ["weight"]}}, {"full": {"loads": WATER}}], 34)
    scene["joints"]["base"] |= {"aperture": 4e-5, "aperture_residual": 1e-6}
    results = Results(solve(tmp_path / "one", mesh, scene))
    a = results.stage("full").flow.aperture
    assert a.max() > 2 * a.min()
    line, = base_water.remarks(results, "full")
    assert "between the ends of 1 piece of joints" in line and "at (14.00, 0.00) m" in line


# ---- sheet, CSV, comparison


def test_sheet_sets_uplift_beside_the_rule(run):
    assert report.main([str(run), "--uplift", "npb", "--drain", "4"]) == 0
    text = (run / "report.html").read_text(encoding="utf-8")
    part = text[text.index("<h2>Water in joints</h2>") : text.index("<h2>Displacements")]
    assert part.count("<h3>Stage") == 2 and "steady flow" in part and "Stage dry" not in part
    facts = Results(run).stage_summary("drained")["flow"]
    for words in ("straight line between the heads of its ends", "rule npb", f"{facts['joints']['base']['uplift'] / 1e3:.1f}",
                  f"{facts['conditions']['drain']['discharge'] * 6e4:+.4f}", f"{facts['conditions']['up']['discharge']:+.4e}"):  # fmt: skip
        assert words in part, words
    assert "<th class=\"n\">aperture [mm]</th>" in text and "Water pressure along a joint, base drained." in text
    assert text.count("Water in joints, stage ") == 4  # alt text and caption of two pictures


def test_sheet_without_water_has_no_such_part(tmp_path):
    folder = solve(tmp_path / "dry", dam_mesh(), dam_scene([{"dry": {"loads": ["weight"]}}]) | {"joints": {"base": {"k_n": 2e10, "k_s": 2e10, "friction": 45}}})
    assert report.main([str(folder)]) == 0
    text = (folder / "report.html").read_text(encoding="utf-8")
    assert "Water in joints" not in text and "aperture" not in text.split("<h2>Input</h2>")[0]
    assert not list(folder.glob("water_*.png")) and not list(folder.glob("uplift_*.png"))


def test_names_of_the_scene_are_escaped(copy):
    evil = "<script>alert(1)</script>"
    conditions = {evil: {"nodes": 1, "discharge": 1e-6, "litres_per_minute": 0.06}}
    assert report.main([str(changed(copy, "full", conditions=conditions, state=evil))]) == 0
    text = (copy / "report.html").read_text(encoding="utf-8")
    assert "<script" not in text and "&lt;script&gt;" in text


def test_flood_has_the_water_of_its_last_stable_level(tmp_path):
    flood = {"type": "flood", "loads": WATER, "rises": ["water", "up"], "step": 1, "limit": 31, "bracket": 0.5}
    folder = solve(tmp_path / "flood", dam_mesh(), dam_scene([{"dry": {"loads": ["weight"]}}, {"flood": flood}], 30))
    found, complaints = assess(folder)
    assert not any(complaints.values())
    trial = Results(folder).stage_summary("flood")["flood"]["trials"][-1]
    base = found["flood", "base"]
    assert trial["value"] == 31 and base.computed[1] == pytest.approx(trial["flow"]["joints"]["base"]["uplift"], rel=1e-9)
    assert base.hand.T == pytest.approx(GW * 31**2 / 2, rel=1e-9)
    assert report.main([str(folder)]) == 0 and "Stage flood: steady flow" in (folder / "report.html").read_text(encoding="utf-8")
    assert (folder / "water_flood.png").exists()


def test_terminal_of_the_assessment(run, capsys):
    assert terminal.main([str(run), "--uplift", "npb", "--drain", "4"]) == 0
    text = capsys.readouterr().out
    assert "Stage full: water in joints, steady" in text and "Stage dry: water" not in text and text.count("rule npb") == 3  # two rows, a remark


def test_export(run, tmp_path):
    assert export.main([str(run), "--to", str(tmp_path)]) == 0
    names = set(os.listdir(tmp_path))
    assert {"full_flow.csv", "drained_flow.csv", "discharges.csv", "uplifts.csv"} <= names and "dry_flow.csv" not in names
    results = Results(run)
    flow, rows = results.stage("full").flow, rows_of(tmp_path / "full_flow.csv")
    assert len(rows) == 2 * len(flow) and rows[1]["end"] == "1" and rows[0]["joint"] == "base"
    for column, array in (("pressure [Pa]", flow.pressure), ("head [m]", flow.head), ("aperture [m]", flow.aperture), ("x [m]", flow.point[..., 0]),
                          ("discharge [m2/s]", np.repeat(flow.discharge, 2))):  # fmt: skip
        assert np.array_equal([float(row[column]) for row in rows], array.ravel()), column
    discharges = {(row["stage"], row["load"]): float(row["discharge [m2/s]"]) for row in rows_of(tmp_path / "discharges.csv")}
    assert sum(value for (stage, _), value in discharges.items() if stage == "drained") == pytest.approx(0, abs=1e-15)
    assert discharges["drained", "drain"] > 0 > discharges["drained", "up"] and len(discharges) == 5
    uplifts = {row["stage"]: float(row["force [N]"]) for row in rows_of(tmp_path / "uplifts.csv")}
    assert uplifts == {stage: results.stage_summary(stage)["flow"]["joints"]["base"]["uplift"] for stage in ("full", "drained")}


def test_compare(run, tmp_path, capsys):
    assert compare.main([str(run), str(run)]) == 0 and "the same bits" in capsys.readouterr().out
    stages = [{"dry": {"loads": ["weight"]}}, {"full": {"loads": WATER}}, {"drained": {"loads": [*WATER, "drain"]}}]
    other = dam_scene(stages, drain={"type": "drain", "joint": "base", "distance": 5, "gallery": 2})
    other = solve(tmp_path / "other", dam_mesh(), other)
    assert compare.main([str(run), str(other)]) == 1
    text = capsys.readouterr().out
    assert "Stage full: the same bits" in text and "flow.joints.base.uplift [kN]" in text and "flow.conditions.drain.discharge [l/(min m)]" in text
    assert "stage drained: water flows in other pieces of joints" in text
    wider = dam_scene(stages)
    wider["joints"]["base"]["aperture"] = 1.6e-4
    assert compare.main([str(run), str(solve(tmp_path / "wider", dam_mesh(), wider))]) == 1
    text = capsys.readouterr().out
    assert "field flow.pressure [MPa]" in text and "flow.joints.base.widest [mm]" in text and "Stage dry: the same bits" in text


def test_compare_sees_water_where_nothing_moves(frame, tmp_path, capsys):
    """Held blocks stay whatever the water does; checksum and compare see the water."""
    scene = yaml.safe_load((frame / "scene.yaml").read_text(encoding="utf-8"))
    scene["loads"]["up"]["level"] = 20
    mesh = blockmesh.read(frame / "model.h5")
    other = solve(tmp_path / "lower", mesh, scene)
    one, two = read_summary(frame)["stages"][0], read_summary(other)["stages"][0]
    assert one["max_displacement"]["value"] == two["max_displacement"]["value"] == 0 and one["checksum"] != two["checksum"]
    assert compare.main([str(frame), str(other)]) == 1 and "flow.inflow" in capsys.readouterr().out
