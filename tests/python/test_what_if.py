"""The section what_if: a rectangular dam with each item against statics by hand, on one core and two; refusals; changes without effect."""

import math
import os
import subprocess
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
import yaml
from quoin_tools.assess import assessment
from quoin_tools.assess.assessment_options import Options
from quoin_tools.ensemble import what_if
from quoin_tools.front import running
from quoin_tools.mesh.blockmesh import BlockMesh, write
from quoin_tools.show import report, what_if_part

ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
B, H, LEVEL, DRAIN, E = 8.0, 10.0, 9.5, 2.0, 0.6  # m
PHI, C, PULL, WATER = 40.0, 5e4, 3e5, 9810.0  # degree, Pa, N/m, N/m3
ITEMS = {
    "cohesion_halved": {"joints.base.cohesion": "x 0.5"},
    "friction_lost": {"joints": {"base": {"friction": 30, "friction_residual": 30}}},
    "drains_clogged": {"loads.uplift.efficiency": 0},
    "leached": {"materials.dam.density": "x 0.9"},
    "tendon_lost": {"anchors.tendon": "lost"},
    "all": {"joints.base": {"cohesion": 0, "friction": 15, "friction_residual": 15}, "loads.uplift.efficiency": 0, "anchors.tendon": "lost"},
    "idle": {"joints.base.cohesion": C},
    "of_no_matter": {"materials.ground.density": 1000},
}
SCENE = {
    "model": "model.h5", "output": "out",
    "materials": {"dam": {"density": 2400, "rigid": True}, "ground": {"density": 0, "rigid": True}},
    "joints": {"base": {"k_n": 20e9, "k_s": 8e9, "friction": PHI, "cohesion": C, "stress_model": "tptm"}},
    "supports": {"bottom": {"fix": "xy"}},
    "anchors": {"tendon": {"head": [4.0, 9.0], "root": [4.0, -1.0], "area": 1e-4, "young": 1e8, "prestress": PULL, "lock": "empty"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": {"type": "reservoir", "faces": "upstream", "level": LEVEL},
              "uplift": {"type": "uplift", "faces": "base", "level": LEVEL, "rule": "usace", "drain": DRAIN, "efficiency": E}},
    "stages": [{"empty": {"loads": ["weight"]}}, {"full": {"loads": ["weight", "water", "uplift"]}}],
}  # fmt: skip

solver = pytest.mark.skipif(not QUOIN.exists(), reason="the solver is not built")


def by_hand(density=2400.0, friction=PHI, cohesion=C, efficiency=E, pull=PULL):
    """(sliding factor, 2 e / L, crack / L) of the rectangle, uncracked."""
    at_drain = (1 - efficiency) * LEVEL * (B - DRAIN) / B
    # trapezium and triangle of the diagram, and their distances from the heel
    near, far = (LEVEL + at_drain) / 2 * DRAIN, at_drain / 2 * (B - DRAIN)
    x_near, x_far = DRAIN / 3 * (LEVEL + 2 * at_drain) / (LEVEL + at_drain), DRAIN + (B - DRAIN) / 3
    weight, thrust = density * 9.81 * B * H, WATER * LEVEL**2 / 2
    N = weight + pull - WATER * (near + far)
    overturning = thrust * LEVEL / 3 + WATER * (near * (B / 2 - x_near) + far * (B / 2 - x_far))
    e = overturning / N
    crack = max(0.0, B - 3 * (B / 2 - e))
    return (N * math.tan(math.radians(friction)) + cohesion * (B - crack)) / thrust, 2 * e / B, crack / B


HAND = {
    "as_it_is": by_hand(), "cohesion_halved": by_hand(cohesion=C / 2), "friction_lost": by_hand(friction=30), "drains_clogged": by_hand(efficiency=0), "leached": by_hand(density=2160),
    "tendon_lost": by_hand(pull=0), "idle": by_hand(), "of_no_matter": by_hand(), "all": by_hand(cohesion=0, friction=15, efficiency=0, pull=0),
}  # fmt: skip


def solve(folder, items, *options, **changes):
    folder.mkdir(exist_ok=True)
    vertices = np.array([[-2, -2], [B + 2, -2], [B + 2, 0], [-2, 0], [0, 0], [B, 0], [B, H], [0, H]], dtype=float)
    write(folder / "model.h5", BlockMesh(vertices, [[0, 1, 2, 3], [4, 5, 6, 7]], [1, 0], ["dam", "ground"], [1, 1], {"bottom": [(0, 0)], "base": [(1, 0)], "upstream": [(1, 3)]}, {}))
    (folder / "scene.yaml").write_text(yaml.safe_dump(SCENE | {"what_if": items} | changes, sort_keys=False), encoding="utf-8")
    return subprocess.run([QUOIN, "-options_file", "scene.yaml", *options], cwd=folder, capture_output=True, text=True, timeout=60, check=False)


def rows(folder, jobs=2):
    case = assessment.load_case(str(folder / "out"), Options())
    return what_if_part.dams(case, assessment.assess(case)[0], what_if.run(str(folder / "out"), case.scene, case.mesh_path, jobs))


@solver
def test_each_item_is_the_dam_of_a_hand_calculation(tmp_path):
    assert solve(tmp_path, ITEMS).returncode == 0
    as_it_is, found = rows(tmp_path)
    by_name = {row.item.name: row for row in found} | {"as_it_is": as_it_is}
    for name, hand in HAND.items():
        assert (by_name[name].sliding, by_name[name].middle) == pytest.approx(hand[:2], rel=2e-4), name
        assert by_name[name].crack == pytest.approx(hand[2], abs=1e-3)
    factors = [row.sliding for row in found if not row.fails]
    assert factors == sorted(factors) and found[0].item.name == "all"
    assert what_if_part.outcome(found[0])[1] == "fail" and not by_name["tendon_lost"].fails
    said = [text for row in found for text in what_if_part.remarks(as_it_is, row)]
    assert sorted(said) == ["idle: joints.base.cohesion has this value already, so the change does nothing.", "of_no_matter: no number of this table changes."]


@solver
def test_the_sheet_has_one_line_and_one_table(tmp_path, monkeypatch):
    monkeypatch.setattr(report.plots, "drawing", lambda *_, **__: nullcontext(list))
    assert solve(tmp_path, {name: ITEMS[name] for name in ("cohesion_halved", "all")}).returncode == 0
    assert report.main([str(tmp_path / "out"), "--guideline", "cadam", "--given", "tests=with", "--what-if", "1"]) == 0
    text = (tmp_path / "out/report.html").read_text(encoding="utf-8")
    assert text.count("What if") == 2 and "1 of 2 items fails; worst: all, fails" in text and "joints.base.cohesion 50000 → 25000" in text and "anchors.tendon lost" in text and "changes of keys (SI)" in text  # in any unit of the sheet
    written = os.path.getmtime(tmp_path / "out/what_if/1/summary.json")
    assert report.main([str(tmp_path / "out")]) == 0 and os.path.getmtime(tmp_path / "out/what_if/1/summary.json") == written  # not run again
    assert report.main([str(tmp_path / "out"), "--what-if", "0"]) == 0
    assert "What if" not in (tmp_path / "out/report.html").read_text(encoding="utf-8")


@solver
def test_the_change_is_that_of_the_same_cases(tmp_path):
    """The flood decides; with an item whose usual stage collapses it is not run, and the change is that of the usual stage."""
    loads = SCENE["loads"] | {"flood": {"type": "reservoir", "faces": "upstream", "level": 10.0}}
    stages = [*SCENE["stages"], {"flood": {"from": "full", "loads": ["weight", "flood", "uplift"]}}]
    items = {"slides": {"joints.base": {"cohesion": 0, "friction": 14, "friction_residual": 14}, "anchors.tendon": "lost"}, "lower": {"joints.base.cohesion": "x 0.8"}, "none": {"materials.dam.density": 10}}
    assert solve(tmp_path, items, loads=loads, stages=stages).returncode == 0
    case = assessment.load_case(str(tmp_path / "out"), Options(conditions={"full": "usual", "flood": "extreme"}))
    as_it_is, found = what_if_part.dams(case, assessment.assess(case)[0], what_if.run(str(tmp_path / "out"), case.scene, case.mesh_path, 2))
    assert [row.item.name for row in found] == ["none", "slides", "lower"] and as_it_is.stage.startswith("flood")
    slides, usual = found[1], by_hand()[0]
    assert slides.stage.startswith("full") and slides.sliding == pytest.approx(by_hand(friction=14, cohesion=0, pull=0)[0], rel=2e-4)
    assert what_if_part.as_before(as_it_is, slides) == pytest.approx(usual, rel=2e-4) and as_it_is.sliding < 0.95 * usual
    assert what_if_part.remarks(as_it_is, slides)[-1].startswith("slides: no result of flood; the change is against")
    assert what_if_part.as_before(as_it_is, found[2]) == as_it_is.sliding and not what_if_part.remarks(as_it_is, found[2])


@solver
def test_a_change_of_default_reaches_joints_that_have_the_key_from_there(tmp_path):
    """The base has its cohesion from `default` and a friction of its own: the first change is the hand calculation without cohesion, the second changes nothing."""
    base = SCENE["joints"]["base"]
    joints = {"default": base | {"friction": 10}, "base": {"friction": PHI}}
    items = {"weaker": {"joints.default.cohesion": "x 0.4"}, "own": {"joints.default": {"cohesion": 0, "friction": 5}, "joints.base.cohesion": 4e4}}
    assert solve(tmp_path, items, joints=joints).returncode == 0
    as_it_is, found = rows(tmp_path, 1)
    assert {row.item.name: row.sliding for row in (as_it_is, *found) if row.item} == pytest.approx({"weaker": by_hand(cohesion=2e4)[0], "own": by_hand(cohesion=4e4)[0]}, rel=2e-4)
    said = {row.item.name: what_if_part.changes_words(row.item) for row in found}
    assert said["weaker"] == "joints.default.cohesion 50000 → 20000" and said["own"].endswith("joints.base.cohesion 50000 → 40000")


@solver
def test_a_stage_that_gives_the_key_itself_is_named(tmp_path):
    stages = [SCENE["stages"][0], {"full": SCENE["stages"][1]["full"] | {"joints": {"base": {"cohesion": 1e4}}}}]
    assert solve(tmp_path, {"lower": {"joints.base.cohesion": "x 0.5"}, "there": {"stages.full.joints.base.cohesion": "x 0.5"}}, stages=stages).returncode == 0
    as_it_is, found = rows(tmp_path, 1)
    said = {row.item.name: what_if_part.remarks(as_it_is, row) for row in found}
    assert said == {"there": [], "lower": ["lower: stage full gives joints.base.cohesion itself, and the change does not reach it.", "lower: no number of this table changes."]}


@solver
@pytest.mark.parametrize("items, message", [
    ({"gone": {"materials.rock.density": "x 0.9"}}, "what_if.gone.materials.rock.density: the scene has no key or row materials.rock.density"),
    ({"gone": {"joints": {"lift": {"cohesion": 0}}}}, "what_if.gone.joints.lift.cohesion: the scene has no key or row joints.lift.cohesion"),
    ({"gone": {"anchors.bar": "lost"}}, "the scene has no key or row anchors.bar"),
    ({"empty": {}}, "what_if.empty: changes no key"),
    ({"odd": {"joints..cohesion": 0}}, "'joints..cohesion' is not a name"),
    ({"odd": 3}, "what_if.odd: keys below it expected"),
])  # fmt: skip
def test_the_solver_refuses(items, message, tmp_path):
    done = solve(tmp_path, items)
    assert done.returncode == 2 and message in done.stderr and len(done.stderr.splitlines()) == 1


@solver
@pytest.mark.parametrize("items, message", [
    ({"odd": {"joints.base.cohesion": "x much"}}, "what_if.odd.joints.base.cohesion: x much: expected x and a factor"),
    ({"odd": {"joints.base.law": "x 0.5"}}, "what_if.odd.joints.base.law: x 0.5: the scene has no number there"),
    ({"odd": {"materials.dam": "lost"}}, "what_if.odd.materials.dam: lost: expected one of the anchors or loads"),
    ({"odd": {"materials.dam": 3}}, "what_if.odd.materials.dam: 3: expected keys below it"),
    ({"odd": {"joints.base.friction": 95}}, "joints.base.friction: 95"),
    ({"odd": {"loads.water.efficiency": 0}}, "loads.water"),
    ({"odd": {"joints.base.friction": [1, 2]}}, "joints.base.friction"),
])  # fmt: skip
def test_an_item_that_cannot_be_run_is_a_row(items, message, tmp_path, capsys, monkeypatch):
    """The sheet has the other items, and says why this one has no numbers; `quoin check` says it before anything runs, in one line."""
    assert solve(tmp_path, items | {"right": {"joints.base.cohesion": 2e4}}).returncode == 0
    for _again in range(2):  # a row that was refused is not asked again, nor the others
        as_it_is, found = rows(tmp_path)
        assert [row.item.name for row in found] == ["right", "odd"] and found[0].sliding == pytest.approx(by_hand(cohesion=2e4)[0], rel=2e-4)
        words, kind = what_if_part.outcome(found[1])
        assert words.startswith("cannot be run: ") and message in words and kind == "open" and "\n" not in words
        assert what_if_part.line(as_it_is, found).endswith("; cannot be run: odd") and message in what_if_part.what_if_part(as_it_is, found)
        times = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("summary.json")}
    assert len(times) == 2
    monkeypatch.chdir(tmp_path)
    capsys.readouterr()
    assert running.check(["scene.yaml"]) == 2
    told = [line for line in capsys.readouterr().err.splitlines() if "warning" not in line]
    assert len(told) == 1 and ".yaml:" not in told[0].removeprefix("scene.yaml:") and told[0].startswith("scene.yaml: what_if.odd") and message in told[0]


@solver
def test_check_finds_nothing_wrong(tmp_path, capsys, monkeypatch):
    assert solve(tmp_path, ITEMS).returncode == 0
    monkeypatch.chdir(tmp_path)
    assert running.check(["scene.yaml"]) == 0 and "nothing was run" in capsys.readouterr().out
