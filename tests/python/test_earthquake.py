"""The pseudo-static earthquake in the gravity method and on the sheet, against numbers by hand and the run's own."""

import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from quoin_tools.assess import assessment, guidelines, section_cut  # noqa: E402
from quoin_tools.assess.assessment_options import options_from, parser  # noqa: E402
from quoin_tools.assess.scene_loads import SceneLoads  # noqa: E402
from quoin_tools.base import scene as scenes  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh import blockmesh  # noqa: E402
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed  # noqa: E402
from quoin_tools.show import compare, report, style  # noqa: E402

QUOIN = os.environ.get("QUOIN", str(ROOT / "build" / "quoin"))
solver = pytest.mark.skipif(not os.path.exists(QUOIN), reason="the solver is not built")
G, H, PHI = 9.81, 30.0, 35.0
WATER = {"faces": "upstream", "level": 28.0}
QUAKE = {"type": "pseudo_static", "coefficient": [0.1, -0.05], "groups": ["dam"], **WATER}


def mesh():
    """A dam with an upstream face that leans by 20 degrees, on flat ground."""
    foot = -H * math.tan(math.radians(20))
    dam = renamed(quad_patch((foot, 0), (25, 0), (5, H), (0, H), 4, 6, group="dam", rigid=True),
                  {"bottom": "bottom", "upstream": "left", "downstream": "right"})  # fmt: skip
    return join([renamed(rectangle(-60, -10, 120, 10, group="rock", rigid=True), {"joint": "top"}), dam])


SCENE = {
    "title": "Earthquake at rest", "model": "model.h5", "strain": "small", "relaxation": {"tolerance": 1e-8, "groups": ["dam"]},
    "materials": {name: {"density": 2400, "rigid": True} for name in ("dam", "rock")}, "supports": {"rock": {"fix": "xy"}},
    "joints": {"default": {"k_n": 10e9, "k_s": 10e9, "friction": PHI}},
    "loads": {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": {"type": "reservoir", **WATER}, "quake": QUAKE | {"rule": "zangar"},
              "back": {"type": "pseudo_static", "coefficient": [-0.1, 0], "groups": "all", "faces": "upstream", "level": 20},
              "tail": {"type": "pseudo_static", "coefficient": [0.1, 0], "groups": "none", "faces": "downstream", "level": 6}},
    "stages": [{"full": {"loads": ["weight", "water"]}}, {"back": {"loads": ["weight", "water", "back", "tail"]}},
               {"yield": {"type": "load_factor", "loads": ["weight", "water", "quake"], "raises": ["quake"], "start": 0, "limit": 50, "bracket": 1e-3}},
               {"shaken": {"loads": ["weight", "water", "quake"]}}, {"after": {"loads": ["weight", "water"], "joints": {"default": {"friction": 30}}}}],
}  # fmt: skip


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "quake"
    folder.mkdir()
    blockmesh.write(str(folder / "model.h5"), mesh())
    (folder / "scene.yaml").write_text(yaml.safe_dump(SCENE, sort_keys=False), encoding="utf-8")
    done = subprocess.run([QUOIN, "-options_file", "scene.yaml", "-output", "."], cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return folder


def case_of(folder, *words):
    return assessment.load_case(str(folder), options_from(parser("assessment", "").parse_args([str(folder), *words])))


@solver
@pytest.mark.parametrize("rule, force", [("westergaard", 7 / 12), ("zangar", (0.7412 - 0.0073 * 20) * (1 / 3 + math.pi / 8) / math.cos(math.radians(20)))])
def test_pressure_on_a_wall_that_leans(rule, force, monkeypatch):
    monkeypatch.setenv("QUOIN_SOLVER", QUOIN)
    used = scenes.parse(yaml.safe_dump(SCENE | {"loads": SCENE["loads"] | {"quake": QUAKE | {"rule": rule}}}, sort_keys=False), "scene.yaml")
    total = SceneLoads(mesh(), used).of(used, "shaken").table.of("quake").force.sum(axis=(0, 1))
    assert np.hypot(*total) == pytest.approx(force * 1000 * 0.1 * G * WATER["level"] ** 2, rel=1e-8) and math.degrees(math.atan2(-total[1], total[0])) == pytest.approx(20)


@solver
def test_forces_are_those_of_the_run(run):
    case = case_of(run)
    for stage in case.results.stages:
        applied = case.results.stage_summary(stage)["applied"]
        forces, left_out = case.forces(stage)
        assert not left_out and section_cut.total(forces)[:2] == pytest.approx([applied["x"], applied["y"]], rel=1e-9, abs=1e-3), stage
        assert not assessment.stage_complaints(case, stage), stage


@solver
def test_both_methods_agree_on_the_base_and_on_what_it_yields_to(run):
    found, complaints = assessment.assess(case_of(run))
    assert not any(complaints.values())
    by_stage = {a.stage: a for a in found}
    assert set(by_stage) == {"full", "back", "yield", "shaken", "after"}
    for stage, a in by_stage.items():
        assert [a.hand.N, a.hand.T] == pytest.approx([a.block["N"], a.block["T"]], rel=1e-5), stage
        assert a.hand.M == pytest.approx(a.block["M"], abs=1e-5 * a.hand.N * a.base.length), stage
    raised = Results(str(run)).stage_summary("yield")["load_factor"]["raises"]["quake"]
    for stage in ("yield", "shaken"):  # whatever factor the stage has
        (name, which, value, how, ran), = by_stage[stage].yields
        assert (name, which, how) == ("quake", "k_h", "slides") and raised["k_h_stable"] <= value <= raised["k_h_failing"] + 1e-9
        assert ran == (raised["k_h_stable"], raised["k_h_failing"])
    assert by_stage["full"].yields == [] == by_stage["after"].yields
    rows = {line.quantity: line for line in assessment.lines(by_stage["shaken"])}
    assert rows["yield coefficient k_h of quake"].hand == pytest.approx(raised["k_h_stable"], abs=2e-4)


@solver
@pytest.mark.parametrize("words, judged", [
    ((), {"after": "after_earthquake"}),
    (("--condition", "shaken=earthquake", "--condition", "full=usual"), {"shaken": "earthquake", "full": "usual"}),
])  # fmt: skip
def test_conditions(run, words, judged):
    case = case_of(run, "--guideline", "cadam", "--given", "tests=without", *words)
    assert case.conditions == judged
    limits = {a.stage: {limit.quantity: limit.limit for limit in a.limits} for a in assessment.assess(case)[0] if a.limits}
    assert set(limits) == set(judged)
    wanted = {"after_earthquake": (2.0, 1.1), "earthquake": (1.3, 1.0), "usual": (3.0, 1.5)}
    for stage, condition in judged.items():
        assert (limits[stage]["sliding_peak"], limits[stage]["sliding_residual"]) == wanted[condition]


@solver
def test_last_stage_with_an_earthquake_is_no_usual_one(run):
    case = case_of(run)
    del case.scene.stages["after"]
    case.results.summary["stages"].pop()
    case.results.stages.pop()
    assert case.conditions == {"shaken": "earthquake"}


@solver
def test_a_guideline_without_limits_for_the_condition(run):
    case = case_of(run, "--guideline", "ferc", "--condition", "shaken=earthquake")
    found = next(a for a in assessment.assess(case)[0] if a.condition)
    assert not found.complete and not found.limits and "This guideline has no limits for the condition earthquake." in found.notes
    assert guidelines.overall(found.limits, found.complete) == "INCOMPLETE"


@solver
def test_sheet_and_comparison(run, monkeypatch, capsys):
    monkeypatch.setattr(style, "save_figure", lambda figure, path, **options: Path(path).write_bytes(b"no picture"))
    words = ["--guideline", "usace", "--condition", "shaken=earthquake", "--condition", "full=usual", "--condition", "yield=extreme"]
    assert report.main([str(run), *words]) == 0
    sheet = (run / "report.html").read_text(encoding="utf-8")
    raised = Results(str(run)).stage_summary("yield")["load_factor"]["raises"]["quake"]
    assert "Stage yield: factor on quake [-]" in sheet and "yield coefficient k_h of quake" in sheet
    assert f'<td class="n">{raised["k_h_stable"]:.4f}</td>' in sheet and "The stage is a load factor" in sheet
    capsys.readouterr()
    assert compare.main([str(run), str(run)]) == 0


@solver
def test_summary_in_the_terminal(run, capsys):
    from quoin_tools.base import results

    assert results.main([str(run)]) == 0
    assert "factor on loads" in capsys.readouterr().out
