"""Ways through seams that do not come out by themselves (assess/ways.py): along the joints of the mesh, else through intact rock, with the strength that the scene gives."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from quoin_tools.assess import assessment, ways
from quoin_tools.assess.assessment_options import options_from, parser
from quoin_tools.mesh.blockmesh import write
from quoin_tools.show import front_page, matrix
from test_section import meshed

pytest.importorskip("gmsh")
ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
pytestmark = pytest.mark.skipif(not QUOIN.exists(), reason="the solver is not built")

DAM = """size: 4
dam: {upstream: [[0, 0], [0, 24]], downstream: [[20, 0], [4, 24]]}
rock: {upstream: 30, downstream: 50, depth: 30, rigid: RIGID, seams: {SEAMS}}
"""
SCENE = """
model: model.h5
materials: {dam: {density: 2400, young: 20e9, poisson: 0.2}, rock: {density: 2600, young: 20e9, poisson: 0.2}}
joints: {default: {k_n: 20e9, k_s: 8e9, friction: 40, cohesion: 2e5}, base: {friction: 40}, seam: {friction: 25, cohesion: 1e5}, back: {friction: 30}}
supports: {rock_bottom: {fix: xy}, rock_sides: {fix: xy}}
loads:
  weight: {type: self_weight}
  water: {type: reservoir, faces: upstream, level: 20}
stages: [{full: {loads: [weight, water]}}]
"""


def case_of(folder, seams, *arguments, rigid="true"):
    if not (folder / "results.h5").exists():
        write(folder / "model.h5", meshed(folder, DAM.replace("SEAMS", seams).replace("RIGID", rigid)))
        (folder / "scene.yaml").write_text(SCENE if "back" in seams else SCENE.replace(", back: {friction: 30}", ""), encoding="utf-8")
        subprocess.run([QUOIN, "-options_file", folder / "scene.yaml", "-model", folder / "model.h5", "-output", folder], check=True, stdout=subprocess.DEVNULL)
    case = assessment.load_case(str(folder), options_from(parser("assessment", "").parse_args([str(folder), *arguments])))
    return case, *assessment.assess(case)


def test_from_the_base_and_out_by_another_joint(tmp_path):
    """The seam falls from below the dam to the foot of a joint that comes up: heel, base, seam, the joint; not up through the toe."""
    case, _, complaints = case_of(tmp_path, "seam: {points: [[8, 0], [30, -5]]}, back: {points: [[30, -5], [38, 0]]}")
    way = case.ways["seam"][0]
    assert way.name == "base+seam+back" and way.intact == 0 and way.path == pytest.approx(np.array([[0, 0], [8, 0], [30, -5], [38, 0]]), abs=1e-6)
    assert [other.name for other in case.ways["back"]] == ["base+seam+back"]
    assert any(line.startswith("Way base+seam+back: the path is bent") for line in complaints["full"])  # it would have to rise along the joint, where it does not stand
    alone = {name for _, name, _ in matrix.untaken(case, [])}
    assert {"seam", "back"} <= alone, "and the sheet is no pass"


def test_through_intact_rock(tmp_path):
    """A seam that rises downstream and ends below the dam: the way to the heel is through rock, and has no strength but that of --strength-on."""
    seam = "seam: {points: [[3, -4], [40, 0]]}"
    case, found, _ = case_of(tmp_path, seam, "--guideline", "usbr", "--strength", "2e7", rigid="false")  # a slit in a rigid body is no joint
    way = case.ways["seam"][0]
    assert way.name == "rock+seam" and way.intact == pytest.approx(5) and way.path == pytest.approx(np.array([[0, 0], [3, -4], [40, 0]]), abs=1e-6)
    mine = next(a for a in found if a.name == way.name)
    assert not mine.complete and mine.strength == {} and any("--strength-on rock+seam=PHI,C" in note for note in mine.notes)
    assert "seam" in {name for _, name, _ in matrix.untaken(case, found)} and "INCOMPLETE" in front_page.verdict_box(case, [mine], 0, {})
    given, found, _ = case_of(tmp_path, seam, "--strength-on", "rock+seam=25,100e3")
    mine = next(a for a in found if a.name == way.name)
    length, factor = np.hypot(37, 4), assessment.factors(mine.hand, mine.strength)["peak"]
    assert mine.complete and factor == pytest.approx((mine.hand.N * np.tan(np.radians(25)) + 1e5 * (length - mine.hand.crack)) / mine.hand.T, rel=1e-6)
    assert not matrix.untaken(given, found)
    named, found, _ = case_of(tmp_path, seam, "--path", "own=0,0,3,-4,40,0")
    assert named.ways["seam"] == [] and "own" in {a.name for a in found}


def test_a_bent_seam_that_comes_out(tmp_path):
    """No line, and no base: it is taken as the path that it is, and not passed over."""
    case, found, complaints = case_of(tmp_path, "seam: {points: [[-12, 0], [0, -8], [12, -8], [30, 0]]}")
    assert not case.results.stage_summary("full")["joints"]["seam"]["line"]
    way = case.ways["seam"][0]
    assert way.name == "seam" and way.intact == 0 and len(way.path) == 4
    mine = [a for a in found if a.name == "seam"]
    assert mine and ways.strength(case, "full", way, mine[0].base)["friction"] == 25 or any("Way seam" in line for line in complaints["full"])
