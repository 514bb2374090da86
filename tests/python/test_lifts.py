"""Lifts over the height of a dam (quoin report): statics by hand at level sections, bed joints found, the least factor named and judged."""

import math
import os
import re
import subprocess
from contextlib import nullcontext
from pathlib import Path

import pytest
from quoin_tools.assess import assessment, lifts
from quoin_tools.assess.assessment_options import options_from, parser
from quoin_tools.mesh.blockmesh import write
from quoin_tools.show import report
from test_section import meshed

pytest.importorskip("gmsh")
ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
pytestmark = pytest.mark.skipif(not QUOIN.exists(), reason="the solver is not built")

HEIGHT, WIDTH, LEVEL, FRICTION = 6.0, 3.0, 5.5, 35.0
WALL = f"size: 3\ndam: {{upstream: [[0, 0], [0, {HEIGHT}]], downstream: [[{WIDTH}, 0], [{WIDTH}, {HEIGHT}]]PATTERN}}\n"
COURSES = ", pattern: {courses: 1, stones: 3, bond: 0}"
SCENE = """
model: model.h5
materials: {dam: {density: 2400, young: 10e9, poisson: 0.2, STRENGTH}}
joints: {default: {k_n: 10e9, k_s: 5e9, friction: 35}}
supports: {bottom: {fix: xy}}
loads:
  weight: {type: self_weight}
  water: {type: reservoir, faces: upstream, level: 5.5}
stages: [{full: {loads: [weight, water]}}]
"""


def solved(folder, pattern, strength=""):
    mesh = meshed(folder, WALL.replace("PATTERN", pattern))
    write(folder / "model.h5", mesh)
    names = [name for name in mesh.face_sets if "bottom" in name or name == "base"]
    text = SCENE.replace("STRENGTH", strength).replace("bottom", names[0])
    (folder / "scene.yaml").write_text(text, encoding="utf-8")
    done = subprocess.run([QUOIN, "-options_file", folder / "scene.yaml", "-model", folder / "model.h5", "-output", folder], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr + str(sorted(mesh.face_sets))
    return folder


@pytest.fixture(scope="module")
def courses(tmp_path_factory):
    return solved(tmp_path_factory.mktemp("courses"), COURSES)


@pytest.fixture(scope="module")
def solid(tmp_path_factory):
    return solved(tmp_path_factory.mktemp("solid"), "", "friction: 45, cohesion: 0.2e6")


def swept(folder, *arguments):
    case = assessment.load_case(str(folder), options_from(parser("report", "").parse_args([str(folder), *arguments])))
    return lifts.sweep(case, "full", [])


def by_hand(y, uplift=False):
    """N, T [N/m] of what stands above a level."""
    depth = max(LEVEL - y, 0.0)
    return 2400 * 9.81 * WIDTH * (HEIGHT - y) - uplift * 9810 * depth * WIDTH / 2, 9810 * depth**2 / 2


@pytest.mark.parametrize("rule", [(), ("--uplift", "npb", "--drain", "1")])
def test_bed_joints_are_found(courses, rule):
    found, left_out = swept(courses, *rule)
    assert [lift.level for lift in found] == pytest.approx([1, 2, 3, 4, 5]) and not left_out
    for lift in found:
        N, T = by_hand(lift.level, bool(rule))
        assert lift.hand.T == pytest.approx(T, rel=1e-6)
        if lift.hand.crack == 0:  # the full head follows a crack
            assert lift.hand.N == pytest.approx(N, rel=1e-6)
        assert lift.source == "joint default" and lift.strength["friction"] == FRICTION
        assert lift.hand.sliding_factor(FRICTION) == pytest.approx(lift.hand.N * math.tan(math.radians(FRICTION)) / T)
        without = by_hand(lift.level)
        assert lift.block == pytest.approx(without[0] * math.tan(math.radians(FRICTION)) / without[1], rel=1e-3)  # of the run, without uplift
    assert lifts.worst(found) is found[0]


def test_a_solid_dam_is_swept_in_steps(solid):
    found, _ = swept(solid, "--lifts", "4")
    assert [lift.level for lift in found] == pytest.approx([1.5, 3.0, 4.5])
    for lift in found:
        N, T = by_hand(lift.level)
        assert lift.source == "blocks of dam" and lift.block is None
        assert lift.factor == pytest.approx((N + 0.2e6 * (WIDTH - lift.hand.crack)) / T, rel=1e-6)
    assert swept(solid, "--lifts", "0") == ([], [])
    given, _ = swept(solid, "--lifts", "4", "--strength-on", "lifts=30,0")
    assert [lift.factor for lift in given] == pytest.approx([by_hand(y)[0] * math.tan(math.pi / 6) / by_hand(y)[1] for y in (1.5, 3.0, 4.5)])


def test_the_least_factor_is_named_and_judged(courses, monkeypatch):
    monkeypatch.setattr(report.plots, "drawing", lambda *_, **__: nullcontext(list))
    N, T = by_hand(1)
    factor = f"{N * math.tan(math.radians(FRICTION)) / T:.2f}"

    def written(*arguments):
        assert report.main([str(courses), *arguments]) == 0
        return re.sub("<[^>]*>", " ", (courses / "report.html").read_text(encoding="utf-8"))

    assert f"Least sliding factor in stage full: {factor} at 1.00 m (joint default)" in written()
    path = ("--path", f"low=0,0.5,{WIDTH},0.5", "--strength-on", "low=60,1e6")
    text = written("--guideline", "usbr", "--strength", "10e6", *path)
    assert 0 < float(factor) < 3 and f"sliding factor {factor} of the lift at 1.00 m in stage full" in text and "FAIL" in text
    assert "of the lift at" not in written("--guideline", "usbr", "--strength", "10e6", *path, "--condition", "full=extreme")
    assert "of the lift at" not in written("--guideline", "usbr", "--strength", "10e6", *path, "--lifts", "0")


WET = """
model: model.h5
materials: {dam: {density: 2400, young: 10e9, poisson: 0.2, compression: 12e6, tension: 1e6, cohesion: 2e6, friction: 45}, rock: {density: 2600, young: 10e9, poisson: 0.2}}
joints: {default: {k_n: 10e9, k_s: 5e9, friction: 45}, lift: {friction: 35}}
supports: {rock_bottom: {fix: xy}}
loads:
  weight: {type: self_weight, groups: [dam]}
  water: {type: reservoir, faces: upstream, level: 5.5}
  under: {type: uplift, faces: base, level: 5.5}
stages: [{dry: {loads: [weight, water]}}, {wet: {loads: [weight, water, under]}}, {falls: {loads: [weight, water, under], joints: {lift: {friction: 5}}}}]
"""


@pytest.fixture(scope="module")
def wet(tmp_path_factory):
    """Two lifts above a base with an uplift load; in its last stage they slide away."""
    folder = tmp_path_factory.mktemp("wet")
    write(folder / "model.h5", meshed(folder, WALL.replace("PATTERN", ", lifts: [2, 4]") + "rock: {upstream: 3, downstream: 3, depth: 3}\n"))
    (folder / "scene.yaml").write_text(WET, encoding="utf-8")
    done = subprocess.run([QUOIN, "-options_file", "scene.yaml", "-output", "out"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 6, done.stderr
    return folder / "out"


def test_lifts_are_wet_where_the_base_is(wet):
    """Straight from the level of the water, without the full head in a crack, as the scene has it below. --uplift none is dry."""
    case = assessment.load_case(str(wet), options_from(parser("report", "").parse_args([str(wet)])))
    for stage, is_wet in (("dry", False), ("wet", True)):
        for lift in lifts.sweep(case, stage, [])[0]:
            assert lift.line == is_wet and (lift.hand.N, lift.hand.T) == pytest.approx(by_hand(lift.level, is_wet), rel=1e-6)
    other = assessment.load_case(str(wet), options_from(parser("report", "").parse_args([str(wet), "--uplift", "none"])))
    assert not any(lift.hand.uplift for lift in lifts.sweep(other, "wet", [])[0])


def test_a_collapsed_stage_has_no_factors_of_the_block_model(wet):
    """Contact forces of a state that moves say nothing of what it could bear."""
    arguments = [str(wet), "--path", f"low=0,2,{WIDTH},2", "--strength-on", "low=35,0"]
    case = assessment.load_case(str(wet), options_from(parser("report", "").parse_args(arguments)))
    found, _ = assessment.assess(case)
    factors = {a.stage: a.block and a.block["peak"] for a in found if a.name == "low"}
    assert factors["wet"] is not None and factors["falls"] is None
    assert [lift.block is None for stage in ("wet", "falls") for lift in lifts.sweep(case, stage, [])[0]] == [False, False, True, True]


def test_compression_is_held_against_the_strength_of_the_scene(wet):
    """materials.dam.compression, where --strength names none."""
    for arguments, strength in (((), 12e6), (("--strength", "6e6"), 6e6)):
        options = [str(wet), "--guideline", "usbr", "--condition", "wet=usual", *arguments]
        found, _ = assessment.assess(assessment.load_case(str(wet), options_from(parser("report", "").parse_args(options))))
        base = next(a for a in found if a.stage == "wet" and a.kind == "joint")
        limit = next(limit for limit in base.limits if limit.quantity == "strength")
        assert limit.value == pytest.approx(base.hand.compression / strength) and limit.verdict == "met"
