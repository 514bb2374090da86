"""Partial factors: on strengths in stages of the run, on loads, in the gravity method and on the sheet. Numbers by hand of a dam with an upright face, friction alone or with cohesion."""

import math
import subprocess
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from quoin_tools.assess import assessment, base_names, guidelines, lifts, partial_factors, planes
from quoin_tools.assess.assessment_options import OptionError, options_from, parser
from quoin_tools.base import scene as scenes
from quoin_tools.front import cases, new
from quoin_tools.show import front_page, limit
from test_combinations import QUOIN
from test_sheet import assessed
from test_sheet_by_hand import blank, sheet  # noqa: F401

H, B, C = 30.0, 27.95, 50e3  # [m] water at the crest, base; [Pa] cohesion that slip does not take
THRUST, UPLIFT = 0.5 * 9810 * H**2, 0.5 * 9810 * H * B
WEIGHT = 2400 * 9.81 * (5 * H + 0.5 * 0.9 * 25.5**2)  # a crest of 5 m, a slope of 0.9 from 25.5 m down
EDGE = (WEIGHT - UPLIFT) / (THRUST - C * B / 2)  # factor on friction with which the dam is about to slide: N tan(45) / F + c B / 2 = T
OURS = """
guidelines:
  ours:
    like: is6512
    title: Our rules
    conditions:
      usual:
        sliding_partial: {value: 1.0, place: p, read: document, friction: 1.2, cohesion: 2.0, actions: {self_weight: {favourable: 0.97, unfavourable: 1.1}, water: 1.05, uplift: {favourable: 0.9, unfavourable: 1.04}}}
      extreme:
        sliding_partial: {value: 1.0, place: p, read: document, friction: null, cohesion: 2.0}
"""
STAGES = """
  - stands: {from: usual, loads: [weight, water, uplift], friction_factor: FROM, cohesion_factor: 2}
  - slides: {from: usual, loads: [weight, water, uplift], friction_factor: TO, cohesion_factor: 2}
  - again: {from: stands, loads: [weight, water, uplift], condition: none}
  - light: {from: usual, loads: [light, heavy, more], friction_factor: 1.2, cohesion_factor: 2}
"""
LOADS = """
  light: {type: self_weight, groups: [dam], partial_factor: 0.97}
  heavy: {type: reservoir, faces: upstream, level: 30, partial_factor: 1.05}
  more: {type: uplift, faces: base, level: 30, partial_factor: 1.04}
"""


@pytest.fixture(scope="module")
def dam(tmp_path_factory):
    folder = tmp_path_factory.mktemp("factors") / "dam"
    assert new.main([str(folder), "--height", "30", "--batter", "0", "--slope", "0.9", "--columns", "4"]) == 0
    text = (folder / "scene.yaml").read_text().replace("friction: 45}", f"friction: 45, cohesion: {C}, cohesion_residual: {C}}}")
    head, rest = text.split("\nstages:")
    stages = "\n  - empty: {loads: [weight]}\n  - usual: {condition: usual, loads: [weight, water, uplift]}" + STAGES.replace("FROM", f"{0.99 * EDGE}").replace("TO", f"{1.01 * EDGE}")
    (folder / "scene.yaml").write_text(head.rstrip() + LOADS + "stages:" + stages)
    (folder / "ours.yaml").write_text(OURS)
    subprocess.run([QUOIN, "-options_file", "scene.yaml"], cwd=folder, check=False, capture_output=True)  # one stage slides
    return folder


def of(case, found, stage):
    return next(a for a in found if a.stage == stage and a.name == "base")


def test_the_run_slides_where_statics_says(dam):
    """1 % less than the factor on friction by hand stands, 1 % more slides; the stage after it has its full strengths again."""
    case, found, _complaints = assessed(dam / "out")
    verdicts = {s["name"]: s["verdict"] for s in case.results.summary["stages"]}
    assert (verdicts["stands"], verdicts["slides"], verdicts["again"]) == ("converged", "collapsed", "converged")
    full = ((WEIGHT - UPLIFT) + C * B) / THRUST
    assert_allclose(of(case, found, "again").block["peak"], full, rtol=2e-3)
    own = of(case, found, "stands")
    assert_allclose(own.block["peak"], ((WEIGHT - UPLIFT) / (0.99 * EDGE) + C * B / 2) / THRUST, rtol=2e-3)
    assert_allclose(partial_factors.by_hand([own], "stands"), own.block["peak"], rtol=2e-3)
    assert case.conditions == {"usual": "usual"}  # stages with partial factors are no cases


def test_loads_have_their_factors(dam):
    case, found, _complaints = assessed(dam / "out")
    facts = case.results.stage_summary("light")
    assert facts["verdict"] == "converged"
    assert_allclose([facts["applied"]["x"], facts["applied"]["y"]], [1.05 * THRUST, -0.97 * WEIGHT], rtol=2e-3)
    N, T = 0.97 * WEIGHT - 1.04 * UPLIFT, 1.05 * THRUST
    own = of(case, found, "light")
    for values in (own.block, {"N": own.hand.N, "T": own.hand.T}):
        assert_allclose([values["N"], values["T"]], [N, T], rtol=2e-3)
    assert_allclose(own.block["peak"], (N / 1.2 + C / 2 * B) / T, rtol=2e-3)


def test_limit_analysis_has_the_factors(dam, capsys):
    """All loads but the weight times a factor: 0.97 W / 1.2 + c B / 2 = factor (1.05 T + 1.04 U / 1.2)."""
    assert limit.main([str(dam / "out"), "--stage", "light"]) == 0
    row = next(line for line in capsys.readouterr().out.splitlines() if line.strip().startswith("light ") and "not above" in line)
    assert_allclose(float(row.split("not above")[1].split()[0]), (0.97 * WEIGHT / 1.2 + C / 2 * B) / (1.05 * THRUST + 1.04 * UPLIFT / 1.2), rtol=2e-3)


def test_the_sheet_of_a_guideline_with_factored_actions(dam, blank):  # noqa: F811
    """The gravity method factors the actions of the case itself; the run with the same factors stands beside it."""
    arguments = ("--guideline", "ours", "--guidelines", str(dam / "ours.yaml"))
    case, found, _complaints = assessed(dam / "out", *arguments)
    N, T = 0.97 * WEIGHT - 1.04 * UPLIFT, 1.05 * THRUST
    (limit,) = of(case, found, "usual").limits
    assert_allclose(limit.value, (N / 1.2 + C / 2 * B) / T, rtol=2e-3)
    assert limit.verdict == guidelines.PASS and limit.words.endswith("on actions self weight 0.97 or 1.1, water 1.05, uplift 0.9 or 1.04")
    rows = partial_factors.judged(case, "usual")
    assert [(row.verdict, row.entry["friction"]) for row in rows] == [(guidelines.PASS, 1.2)]  # the other two have other factors on loads: they say nothing
    assert partial_factors.words(case, found, "light") == f"design strengths, 1.2 on friction, 2 on cohesion: stands; gravity method {(N / 1.2 + C / 2 * B) / T:.2f}: stands"
    assert partial_factors.summary(case, found) == "With design strengths 2 of 3 cases stand in the run, 2 of 3 by the gravity method. Not so: slides."
    text, chapters = sheet(dam / "out", *arguments)
    assert "stands (from usual)" in text and "slides (from usual)" in text and "does not stand" in text
    assert [row[4:7] for row in chapters["Limits"] if row[2:3] == ["the run"]] == [["yes", "yes", "pass"]]


@pytest.mark.parametrize("friction, verdicts", [(1.2, [guidelines.PASS]), (2.5, [guidelines.FAIL]), (1.0, [guidelines.PASS]), ("edge", [guidelines.OPEN])])
def test_what_a_stage_says_of_other_factors(dam, friction, verdicts):
    """A stage that stands says yes to its factors and smaller ones, a stage that slides no to its factors and larger ones; between both nothing is known."""
    (dam / "weak.yaml").write_text(f"guidelines: {{weak{friction}: {{like: is6512, title: W, conditions: {{usual: {{sliding_partial: {{value: 1, place: p, read: document, friction: {EDGE if friction == 'edge' else friction}, cohesion: 2}}}}}}}}}}")
    guidelines.read.cache_clear()
    arguments = ("--guideline", f"weak{friction}", "--guidelines", str(dam / "weak.yaml"))
    case = assessment.load_case(str(dam / "out"), options_from(parser("report", "").parse_args([str(dam / "out"), *arguments])))
    assert [row.verdict for row in partial_factors.judged(case, "usual")] == verdicts


def test_a_factor_that_is_to_be_filled_in(dam):
    ours = guidelines.read(str(dam / "ours.yaml"))["ours"]
    (row,) = guidelines.judge(ours, "extreme", {"sliding_partial": lambda entry: 9.0})
    assert row.verdict == guidelines.OPEN and row.bound == "to be filled in" and guidelines.overall([row]) == "INCOMPLETE"


def test_a_load_that_helps_takes_its_favourable_factor():
    """A weight of 10 on a level base with tan(phi) / F = 0.5, a push of 3 and a pull of -1: 0.9 x 10 x 0.5 over 1.2 x 3 - 0.8 x 1."""
    base = partial_factors_base()
    pulls = {"weight": np.array([0.0, -10.0, -5.0]), "push": np.array([3.0, 0.0, 0.0]), "pull": np.array([-1.0, 0.0, 0.0])}
    all_of = partial_factors.Acting(pulls, {"weight": "self_weight", "push": "water", "pull": "water"}, {}, np.zeros(3))
    found = SimpleNamespace(base=base, acting=all_of, strength={"friction": 45.0, "cohesion": 0.0, "friction_residual": 45.0, "cohesion_residual": 0.0})
    entry = {"friction": 2.0, "cohesion": 2.0, "actions": {"self_weight": {"favourable": 0.9, "unfavourable": 1.1}, "water": {"favourable": 0.8, "unfavourable": 1.2}}}
    assert partial_factors.least_of(found, [])(entry) == pytest.approx(0.9 * 10 / 2 / (1.2 * 3 - 0.8))
    block = [(1.1, 1.1)]  # its factor by friction: it has the loads as they are, and counts where no factor changes one
    assert partial_factors.least_of(found, block)(entry | {"actions": {"self_weight": 1.0, "ice": 1.3}}) == pytest.approx(1.1 / 2)
    assert partial_factors.least_of(found, block)(entry) == pytest.approx(0.9 * 10 / 2 / (1.2 * 3 - 0.8))


def test_no_equilibrium_with_factored_loads_is_said(dam):
    """2.5 times the thrust tips the dam, which stands without factors: the factor is 0, and a note says why; with 1.05 there is none."""
    (dam / "heavy.yaml").write_text(OURS.replace("water: 1.05", "water: 2.5"))
    for file, zero in (("heavy.yaml", True), ("ours.yaml", False)):
        guidelines.read.cache_clear()
        case, found, _complaints = assessed(dam / "out", "--guideline", "ours", "--guidelines", str(dam / file))
        own = of(case, found, "usual")
        assert (own.limits[0].value == 0) == zero and own.hand.crack is not None
        assert own.limits[0].printed(own.limits[0].value).endswith("0.00 (no equilibrium)") == zero
        assert any(note.startswith("Gravity method with factored loads: no equilibrium without tension, ") for note in own.notes) == zero


def partial_factors_base():
    from quoin_tools.assess.gravity import Base

    return Base((0.0, 0.0), (1.0, 0.0))


def test_quoin_new_writes_the_stages_with_design_strengths(tmp_path):
    (tmp_path / "ours.yaml").write_text(OURS)
    loads, stages, _usual = cases.of_guideline("ours", cases.Numbers(30, quake=0.1), str(tmp_path / "ours.yaml"))
    read = scenes.parse("\n".join(["loads:", *loads, "stages:", "  - empty: {loads: [weight]}", *stages]), "scene.yaml")
    assert read.stages["normal_operation_design"] | {"loads": None} == {"from": "normal_operation", "loads": None, "friction_factor": 1.2, "cohesion_factor": 2}
    assert [read.loads[name].get("partial_factor", 1) for name in read.stages["normal_operation_design"]["loads"]] == [0.97, 1.05, 1.04]
    assert read.is_design("normal_operation_design") and not read.is_design("normal_operation")
    assert not any(name.startswith("flood_drains_out_of_work_design") for name in read.stages)  # its factors are to be filled in


def test_each_plane_has_its_own_limits(dam):
    """The blocks on both sides say what a base is: the guideline has 3.0 for the contact and lifts, 4.0 for the foundation; --plane says otherwise."""
    paths = ("--guideline", "usbr", "--path", "through=-5,10,30,10", "--path", "under=-200,-12,200,-12")
    for more, wanted in (((), {"base": ("contact", 3.0), "through": ("lift", 3.0), "under": ("foundation", 4.0)}), (("--plane", "base=foundation"), {"base": ("foundation", 4.0)})):
        _case, found, _complaints = assessed(dam / "out", *paths, *more)
        limits = {a.name: (a.plane, next(limit.limit for limit in a.limits if limit.quantity == "sliding_peak")) for a in found if a.stage == "usual"}
        assert wanted.items() <= limits.items(), limits
    with pytest.raises(base_names.UnknownBaseError, match="--plane: no base 'seam'"):
        assessed(dam / "out", *paths, "--plane", "seam=lift")
    with pytest.raises(OptionError, match="--plane: it says whose limits hold"):
        assessed(dam / "out", "--guideline", "usace", "--plane", "base=lift")


def test_a_point_that_is_held_makes_no_ground():
    """A crest held at a point is no rock; a group held whole, or by its faces, is."""
    mesh = SimpleNamespace(blocks=np.array([[0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11]]), block_group=np.array([0, 1, 2]), group_names=["dam", "rock", "bank"], face_sets={"bottom": np.array([[1, 0]])}, points={"crest": 3})
    supports = {"bottom": {"fix": "xy"}, "top": {"target": "crest", "fix": "x"}, "bank": {}}
    case = SimpleNamespace(mesh=mesh, scene=SimpleNamespace(supports=supports))
    assert planes.ground(case).tolist() == [False, True, True]
    assert planes.held_by(case, "top").tolist() == [True, False, False] and planes.held_by(case, "bank").tolist() == [False, False, True]


@pytest.mark.parametrize("file, name, words", [("cfbr2012", "cfbr", {"INCOMPLETE"}), ("eurocode7", "ec7", {"NOT CONFIRMED", "INCOMPLETE"})])
def test_files_of_the_examples(file, name, words):
    """They can be read, their cases written, and no sheet passes by them."""
    path = str(Path(__file__).resolve().parents[2] / f"examples/guidelines/{file}.yaml")
    guideline = guidelines.read(path)[name]
    good = {"sliding_partial": lambda entry: 9.0, "crack": 0.0, "strength": 0.0}
    assert {guidelines.overall(guidelines.judge(guideline, condition, good)).split(":")[0] for condition in guideline["conditions"]} == words
    _loads, stages, _usual = cases.of_guideline(name, cases.Numbers(30, pool=29, flood=31, tailwater=2, quake=0.1, ice=1e5), path)
    designs = [line for line in stages if "_design" in line]
    assert len(designs) == (2 if name == "ec7" else 0) and (not designs or "ice_x1p3" in designs[0] and "friction_factor: 1.25" in designs[0])


def test_a_weak_lift_is_held_against_partial_factors(dam):
    """Lifts of tan(phi) 0.9 and no cohesion: the least N tan(phi) / 1.5 over T of all of them, below 1, is said; with 0.3 MPa of cohesion over 3.6 none is."""
    for cohesion, said in ((0, True), (300e3, False)):
        case, found, _complaints = assessed(dam / "out", "--guideline", "is6512", "--strength-on", f"lifts={math.degrees(math.atan(0.9))},{cohesion}")
        swept = {"usual": lifts.sweep(case, "usual", lifts.feet(case, [a for a in found if a.stage == "usual"]))}
        least = min(0.9 * lift.hand.N / 1.5 / abs(lift.hand.T) for lift in swept["usual"][0])
        weak = front_page.weak_lifts(case, swept)
        assert bool(weak) == said and least < 1
        if said:
            assert weak[0].startswith(f"sliding with partial factors 1.5 on friction, 3.6 on cohesion: {least:.2f} in the lift at ")
            swept["usual"][0][0].hand.crack = None  # one lift that finds no equilibrium: both numbers are 0, and say why
            weak = front_page.weak_lifts(case, swept)
            assert ": 0.00 in the lift at" in weak[0] and all(text.endswith(" (no equilibrium)") for text in weak)
            (dam / "stresses.yaml").write_text("guidelines: {ours: {title: t, document: d, conditions: {usual: {lift_strength: {value: 1, place: p, read: document}}}}}")
            case, found, _complaints = assessed(dam / "out", "--guideline", "ours", "--guidelines", str(dam / "stresses.yaml"), "--strength", "30e6")
            assert front_page.weak_lifts(case, swept) == [f"no equilibrium of the lift at {swept['usual'][0][0].level:.2f} m in stage usual"]
            assert "<b>FAIL</b>" in front_page.verdict_box(case, found, 0, swept)
            base = next(a for a in found if a.condition)
            base.hand.crack, base.with_uplift = None, None  # a base without limits that finds none
            said = front_page.verdict_box(case, found, 0, {})
            assert "<b>FAIL</b>" in said and f"no equilibrium on {base.name} in stage usual" in said
