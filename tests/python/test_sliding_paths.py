"""Ways through seams that do not come out by themselves (assess/sliding_paths.py): along the joints of the mesh, else through intact rock, with the strength that the scene gives."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from quoin_tools.assess import assessment, broken, section_cut, sliding_paths
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
    way = case.sliding_paths["seam"][0]
    assert way.name == "base+seam+back" and way.intact == 0 and way.path == pytest.approx(np.array([[0, 0], [8, 0], [30, -5], [38, 0]]), abs=1e-6)
    assert [other.name for other in case.sliding_paths["back"]] == ["base+seam+back"]
    assert any(line.startswith("Way base+seam+back: the path is bent") for line in complaints["full"])  # it would have to rise along the joint, where it does not stand
    alone = {name for _, name, _ in matrix.untaken(case, [])}
    assert {"seam", "back"} <= alone, "and the sheet is no pass"


def test_through_intact_rock(tmp_path):
    """A seam that rises downstream and ends below the dam: the way to the heel is through rock, and has no strength but that of --strength-on."""
    seam = "seam: {points: [[3, -4], [40, 0]]}"
    case, found, _ = case_of(tmp_path, seam, "--guideline", "usbr", "--strength", "2e7", rigid="false")  # a slit in a rigid body is no joint
    way = case.sliding_paths["seam"][0]
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
    assert named.sliding_paths["seam"] == [] and "own" in {a.name for a in found}


def test_a_bent_seam_that_comes_out(tmp_path):
    """No line, and no base: it is taken as the path that it is, and not passed over."""
    case, found, complaints = case_of(tmp_path, "seam: {points: [[-12, 0], [0, -8], [12, -8], [30, 0]]}")
    assert not case.results.stage_summary("full")["joints"]["seam"]["line"]
    way = case.sliding_paths["seam"][0]
    assert way.name == "seam" and way.intact == 0 and len(way.path) == 4
    mine = [a for a in found if a.name == "seam"]
    assert mine and sliding_paths.strength(case, "full", way, mine[0].base)["friction"] == 25 or any("Way seam" in line for line in complaints["full"])


# ---- bases that are no plane, or have several rows

KEYED = """size: 6
dam: {upstream: [[0, 0], [0, 24]], downstream: [[20, TOE], [5, 20], [5, 24]], base: BASE, rigid: true}
rock: {upstream: 20, downstream: 20, depth: 15, size: 8, rigid: true}
MORE
"""
KEYED_SCENE = """
model: model.h5
materials: {dam: {density: 2400}, rock: {density: 2600}}
joints: {default: {k_n: 20e9, k_s: 8e9, friction: 45}, ROWS}
supports: {rock: {fix: xy}}
loads:
  weight: {type: self_weight, groups: [dam]}
  water: {type: reservoir, faces: upstream, level: 22}
stages: [{full: {loads: [weight, water]}}]
"""
GAMMA, UNIT = 9.81e3, 2400 * 9.81


def keyed(folder, path, rows, *arguments, more="", stages=""):
    """Assessments of the dam on a base with these corners, in its stage full."""
    text = KEYED.replace("BASE", str(path[1:-1])).replace("TOE", str(path[-1][1])).replace("MORE", more)
    write(folder / "model.h5", meshed(folder, text.replace(", base: []", "")))
    (folder / "scene.yaml").write_text(KEYED_SCENE.replace("ROWS", rows).replace("water]}}]", f"water]}}}}{stages}]"), encoding="utf-8")
    subprocess.run([QUOIN, "-options_file", "scene.yaml", "-output", "out"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    case = assessment.load_case(str(folder / "out"), options_from(parser("assessment", "").parse_args([str(folder / "out"), *arguments])))
    return assessment.assess(case)


def standing_on(path):
    """[N] (X, Y) of the weight above a base with these corners, and of 22 m of water."""
    x, y = np.array([*path, [5, 20], [5, 24], [0, 24]], dtype=float).T
    return np.array([0.5 * GAMMA * 22**2, -0.5 * UNIT * (x @ np.roll(y, -1) - y @ np.roll(x, -1))])


def pressed(path, along):
    """[N] (X, Y) of water along a base from 22 m at its heel to none at its toe: heads straight over the length, and the depth below the line between its ends."""
    total, end = np.zeros(2), np.array(path[-1])
    for a, b in zip(path[:-1], path[1:]):
        p = np.mean([GAMMA * (22 * (1 - t) + end[1] * t - point[1]) for point in (a, b) for t in [point @ along / (end @ along)]])
        total += p * np.array([a[1] - b[1], b[0] - a[0]])
    return total


@pytest.mark.parametrize("path, slope", [
    ([[0, 0], [0, -2], [4, -2], [4, 0], [20, 0]], 0.0),  # a key at the heel
    ([[0, 0], [9, 0], [9, -2], [12, -2], [12.8, 0], [20, 0]], 0.0),  # in the middle, with a side that leans
    ([[0, 0], [8, 0], [8, -1.5], [20, -1.5]], 0.0),  # a step down: both parts slide level
    ([[0, 0], [8, 0], [8, 1], [20, 1]], 0.05),  # a step up, which locks it
])  # fmt: skip
def test_a_broken_base_is_one_plane(tmp_path, path, slope):
    """By hand: (N tan 45 + c L) / T of all that stands on it, without and with the water along its faces. L: its level parts."""
    found, complaints = keyed(tmp_path, path, "base: {friction: 45, cohesion: 2e5, cohesion_residual: 2e5}", "--uplift", "linear")
    (base,) = found
    along = np.array([1.0, slope]) / np.hypot(1.0, slope)
    level = sum(b[0] - a[0] for a, b in zip(path[:-1], path[1:]) if b[1] == a[1]) * along[0]
    assert (base.kind, base.name) == ("joint", "base") and "The base is a broken line" in base.notes[0]
    assert all("and dry: water in it" in said for stage in complaints.values() for said in stage)  # no load lets water in where it opens
    for hand, force in ((base.hand, standing_on(path)), (base.with_uplift, standing_on(path) + pressed(path, along))):
        N, T = force @ [along[1], -along[0]], force @ along
        assert (hand.N, hand.T) == pytest.approx((N, T), rel=1e-6)
        assert assessment.factors(hand, base.strength)["peak"] == pytest.approx((N + 2e5 * level) / T, rel=1e-6)
    assert (base.block["N"], base.block["T"], base.block["peak"]) == pytest.approx((base.hand.N, base.hand.T, assessment.factors(base.hand, base.strength)["peak"]), rel=1e-3)


def test_a_kinked_base_bears_where_it_falls_by_little(tmp_path):
    """The dam slides level, along the middle piece. What falls by 2.9 degrees bears as well, so M, stresses and cracks are those of 20 m, not of 6 m; what falls by 14 degrees has no cohesion."""
    path = [[0, 0], [5, -1.25], [11, -1.25], [20, -1.7]]
    (base,), _ = keyed(tmp_path, path, "base: {friction: 45, cohesion: 2e5, cohesion_residual: 2e5}")
    x, y = np.array([*path, [5, 20], [5, 24], [0, 24]], dtype=float).T
    cross = x * np.roll(y, -1) - y * np.roll(x, -1)
    W, centre, T = UNIT * cross.sum() / 2, cross @ (x + np.roll(x, -1)) / (3 * cross.sum()), 0.5 * GAMMA * 22**2
    assert (base.hand.N, base.hand.T, base.base.length) == pytest.approx((W, T, 20.0), rel=1e-6)
    assert base.hand.M == pytest.approx(-(T * (22 / 3 + 1.7 / 2) + W * (centre - 10)), rel=1e-5)
    assert assessment.factors(base.hand, base.strength)["peak"] == pytest.approx((W + 2e5 * 15) / T, rel=1e-6)
    assert base.hand.crack == 0 and (base.block["N"], base.block["T"]) == pytest.approx((W, T), rel=1e-3)


def test_two_strengths_in_one_line_are_a_base(tmp_path):
    """By hand: N of each by the straight line of stress, (N1 tan 35 + N2 tan 50 + c1 L1 + c2 L2) / T. No row alone cuts through the body."""
    rows = "base_1: {friction: 35, cohesion: 1e5, cohesion_residual: 1e5}, base_2: {friction: 50, cohesion: 3e5, cohesion_residual: 3e5}"
    (base,), complaints = keyed(tmp_path, [[0, 0], [20, 0]], rows, "--guideline", "usbr", more="joints: {base_1: [[0, 0], [8, 0]], base_2: [[8, 0], [20, 0]]}")
    x, y = np.array([[0, 0], [20, 0], [5, 20], [5, 24], [0, 24]], dtype=float).T
    cross = x * np.roll(y, -1) - y * np.roll(x, -1)
    area, T = cross.sum() / 2, 0.5 * GAMMA * 22**2
    N, centre = UNIT * area, (cross @ (x + np.roll(x, -1))) / (6 * area)
    e = centre + T * 22 / 3 / N - 10
    stress = N / 20 * (1 + 6 * e / 20 * (np.array([0.0, 8.0, 20.0]) / 10 - 1))
    parts = 0.5 * (stress[:-1] + stress[1:]) * [8, 12]
    factor = (parts @ np.tan(np.radians([35, 50])) + 1e5 * 8 + 3e5 * 12) / T
    assert stress.min() > 0 and (base.name, base.kind) == ("base_1+base_2", "joints") and not any(complaints.values())
    assert assessment.factors(base.hand, base.strength)["peak"] == pytest.approx(factor, rel=1e-6)
    assert base.block["peak"] == pytest.approx(factor, rel=0.02) and {limit.quantity: limit for limit in base.limits}["sliding_peak"].value is not None


def test_a_key_of_its_own_row_is_one_way_with_the_base(tmp_path):
    """Level rows at both sides of a key, whose faces have a row each: the friction of each under its part of the normal force."""
    path = [[0, 0], [8, 0], [8, -2], [12, -2], [12, 0], [20, 0]]
    rows = "base_1: {friction: 45}, key: {friction: 60, cohesion: 1e6, cohesion_residual: 1e6}, base_2: {friction: 45}"
    more = f"joints: {{base_1: {path[:2]}, key: {path[1:5]}, base_2: {path[4:]}}}"
    found, complaints = keyed(tmp_path, path, rows, "--strength-on", "base_1+key+base_2=45,0", more=more)
    (given,) = found
    N, T = -standing_on(path)[1], standing_on(path)[0]
    assert given.name == "base_1+key+base_2" and assessment.factors(given.hand, given.strength)["peak"] == pytest.approx(N / T, rel=1e-6)
    (own,), _ = keyed(tmp_path, path, rows, more=more)
    key = own.hand.carried(8, 12)
    assert assessment.factors(own.hand, own.strength)["peak"] == pytest.approx((N * (1 - key + key * np.tan(np.radians(60))) + 1e6 * 4) / T, rel=1e-6)


def test_a_fall_that_drives_is_no_plane():
    """Most of the base falls by 12.8 degrees before it rises: on one plane from heel to toe it would bear more than it can."""
    with pytest.raises(section_cut.GravityError, match="falls by more than 10"):
        broken.plane(np.array([[0, 0], [8, 0], [30, -5], [38, 0.0]]), np.array([2e6, -1e7, -1.9e8]))


def test_brittle_joints_are_told_where_the_methods_differ(tmp_path):
    """A level base with 600 kPa of cohesion: brittle, it fails along from where it is stressed most, so the gravity method is far from 1 at the brink of the run; ductile, both agree."""
    stages = ", {less: {type: strength_reduction, what: strengths, loads: [weight, water], factor: 0.9, limit: 0.1, bracket: 0.02}}"
    found = {}
    for name, row in (("brittle", "base: {friction: 20, cohesion: 6e5}"), ("ductile", "base: {friction: 20, cohesion: 6e5, cohesion_residual: 6e5}")):
        (tmp_path / name).mkdir()
        found[name], _ = keyed(tmp_path / name, [[0, 0], [20, 0]], row, stages=stages)
    told = {name: next(a for a in bases if a.stage == "less") for name, bases in found.items()}
    factors = {name: assessment.factors(a.hand, a.strength)["peak"] for name, a in told.items()}
    assert factors["brittle"] > 1.1 and factors["ductile"] == pytest.approx(1.0, abs=0.05)
    (note,) = [note for note in told["brittle"].notes if "brittle" in note]
    assert f"sliding factor of {factors['brittle']:.2f}, where it would be 1" in note and "to 0 kPa at once" in note
    assert not any("differ" in note or "brink" in note for note in told["ductile"].notes)
