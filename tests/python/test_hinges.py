"""assess/hinges.py: the limit of rigid hinges from two stiffnesses, against statics. docs/rigid_blocks.md."""

import json
import os
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from quoin_tools.assess import assessment, hinges  # noqa: E402
from quoin_tools.mesh import blockmesh  # noqa: E402
from quoin_tools.mesh.meshing import join, rectangle, renamed  # noqa: E402
from quoin_tools.show import report  # noqa: E402

QUOIN = os.environ.get("QUOIN", str(ROOT / "build" / "quoin"))
SCENE = """model: model.h5
materials: {block: {density: 2400}, base: {density: 2400}}
joints: {default: {k_n: 1e10, k_s: 1e10, friction: 60}}
supports: {base: {fix: xy}}
loads:
  weight: {type: self_weight, groups: [block]}
  water: {type: reservoir, faces: upstream, level: 5}
stages:
  - rest: {loads: [weight, water]}
  - flood: {type: flood, loads: [weight, water], limit: 7, bracket: 0.01}
"""


@pytest.mark.skipif(not os.path.exists(QUOIN), reason="the solver is not built")
def test_limit_of_rigid_hinges(tmp_path, capsys):
    """A column of 2 x 10 m under water tips at (3 W b / (rho g))^(1/3); with 1e10 Pa/m 2.3 % before."""
    body = renamed(rectangle(0.0, 0.0, 2.0, 10.0, group="block", rigid=True), {"upstream": "left"})
    blockmesh.write(tmp_path / "model.h5", join([body, renamed(rectangle(-3.0, -1.0, 9.0, 1.0, group="base", rigid=True))]))
    (tmp_path / "scene.yaml").write_text(SCENE, encoding="utf-8")
    assert hinges.main([str(tmp_path / "scene.yaml"), "--quoin", QUOIN, "-model", str(tmp_path / "model.h5")]) == 0
    row = next(line.split() for line in capsys.readouterr().out.splitlines() if line.split()[:1] == ["flood"])
    exact = np.cbrt(3 * 2400 * 2.0 * 10.0 * 2.0 / 1000)
    once, _, ten, stiffest, rigid, missing, pressed, pressed_ten, times = map(float, row[1:])
    assert stiffest == 10  # it moves the limit by 1.2 %
    assert once < 0.98 * exact and once < ten < 0.992 * exact and rigid == pytest.approx(exact, rel=3e-3)
    assert pressed > 1.5 * pressed_ten > 0.03 and missing == pytest.approx(1 - once / rigid, rel=0.05)
    assert times == pytest.approx(max(1.0, (missing / 0.01) ** 3), rel=0.1)


SHAKEN_WALL = """model: model.h5
strain: small
materials: {{block: {{density: 2400}}, base: {{density: 2400}}}}
joints: {{default: {{k_n: 1e8, k_s: 1e8, friction: {friction}}}}}
supports: {{base: {{fix: xy}}}}
relaxation: {{tolerance: 1e-5}}
loads:
  weight: {{type: self_weight, groups: [block]}}
  shake: {{type: pseudo_static, coefficient: [0.1, 0], groups: [block]}}
stages:
  - rest: {{loads: [weight]}}
  - push: {{type: load_factor, loads: [weight, shake], raises: [shake], start: 5.4, limit: 6.6, bracket: 0.08, displacement_limit: 0.2}}
"""


@pytest.mark.skipif(not os.path.exists(QUOIN), reason="the solver is not built")
def test_wall_of_many_hinges(tmp_path, capsys):
    """Wall 1 of Ferris and Tin-Loi (2001): 0.4 x 0.175 m, six courses, mu 0.65. With 1e8 Pa/m it fails at 0.545 to 0.546 (bracket 0.01). The associated
    limit, a bound from above, is 0.64286, and rigid blocks without dilation fail at 0.62875 to 0.63 (1e10 Pa/m). The least pressed of
    its joints bears next to nothing, over 0.0016 of its face once."""
    parts = [renamed(rectangle(-1.0, -1.0, 4.0, 1.0, group="base", rigid=True))]
    for course in range(6):
        ends = np.r_[0.0, np.arange(0.2, 2.0, 0.4), 2.0] if course % 2 == 0 else np.arange(0.0, 2.1, 0.4)
        parts += [renamed(rectangle(a, course * 0.175, b - a, 0.175, group="block", rigid=True)) for a, b in zip(ends[:-1], ends[1:])]
    blockmesh.write(tmp_path / "model.h5", join(parts))
    (tmp_path / "scene.yaml").write_text(SHAKEN_WALL.format(friction=np.degrees(np.arctan(0.65))), encoding="utf-8")
    assert hinges.main([str(tmp_path / "scene.yaml"), "--quoin", QUOIN, "-model", str(tmp_path / "model.h5")]) == 0
    row = next(line.split() for line in capsys.readouterr().out.splitlines() if line.split()[:1] == ["push"])
    once, _, stiff, times_stiff, rigid, missing, pressed, pressed_stiff, _ = map(float, row[1:])
    assert times_stiff == 1000  # with ten times k_n the limit moves by 10 %, with a hundred by another 4 %
    assert 5.38 < once < 5.47 and 6.2 < stiff < rigid < 6.43 and missing == pytest.approx(1 - once / rigid, abs=0.006)
    assert 0.1 < missing < pressed < 0.4 and pressed_stiff < 0.25 * pressed  # a tenth by the power


@pytest.mark.skipif(not os.path.exists(QUOIN), reason="the solver is not built")
def test_shaken_column_says_that_it_overturns_early(tmp_path):
    """A column of 1 x 10 m in a dynamic stage: its hinge is (12 W h / k_n)^(1/3) long, by weight W and height h of its centre."""
    body = renamed(rectangle(0.0, 0.0, 1.0, 10.0, group="block", rigid=True))
    blockmesh.write(tmp_path / "model.h5", join([body, renamed(rectangle(-3.0, -1.0, 9.0, 1.0, group="base", rigid=True))]))
    scene = SCENE[: SCENE.index("  water")] + "stages:\n  - rest: {loads: [weight]}\n  - shaken: {type: dynamic, loads: [weight], duration: 1e-3, alpha: 0}\n"
    (tmp_path / "scene.yaml").write_text(scene, encoding="utf-8")
    said = []
    for more in ((), ("-joints_default_k_n", "8e10"), ("-joints_default_k_n", "1e13"), ("-joints_default_stress_model", "pt"), ("-thickness", "3")):
        command = [QUOIN, "-options_file", str(tmp_path / "scene.yaml"), "-model", str(tmp_path / "model.h5"), "-output", str(tmp_path / "out"), *more]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        lines = [line for line in done.stdout.splitlines() if "of the arm of a rigid hinge is missing" in line]
        said.append([line.split(" of the arm")[0].split()[-1] for line in lines])
    length = np.cbrt(12 * 2400 * 9.81 * 10.0 * 5.0 / 1e10)
    assert length == pytest.approx(0.1122, abs=1e-4)
    assert said == [[f"{length:.2g}"], [f"{length / 2:.2g}"], [], [], [f"{length:.2g}"]]


STONES = SCENE[: SCENE.index("  water")] + """  push: {type: pseudo_static, coefficient: [0.1, 0], groups: [block]}
stages:
  - rest: {loads: [weight]}
  - shaken: {type: dynamic, loads: [weight], duration: 1e-3, alpha: 0}
  - tilt: {type: load_factor, from: rest, loads: [weight, push], raises: [push], start: 0.1, limit: 6, bracket: 0.002}
"""
COLUMN = [(0.0, 2.0 * i, 1.0, 2.0) for i in range(5)]  # x, y, width, height
LEANING = COLUMN[:1] + [(0.2, y, 1.0, 2.0) for _, y, _, _ in COLUMN[1:]]


def stones(folder, boxes, mirrored=False, ranks=1, text=STONES):
    """Runs stones on a base, the mirror image pushed the other way; returns the stages of the summary and what the run printed."""
    parts = [renamed(rectangle(-30.0, -1.0, 60.0, 1.0, group="base", rigid=True))]
    parts += [renamed(rectangle(-x - width if mirrored else x, y, width, height, group="block", rigid=True)) for x, y, width, height in boxes]
    blockmesh.write(folder / "model.h5", join(parts))
    (folder / "scene.yaml").write_text(text.replace("[0.1, 0]", "[-0.1, 0]") if mirrored else text, encoding="utf-8")
    command = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks)] * (ranks > 1) + [QUOIN, "-options_file", str(folder / "scene.yaml"), "-model", str(folder / "model.h5"), "-output", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
    return {stage["name"]: stage for stage in json.loads((folder / "summary.json").read_text(encoding="utf-8"))["stages"]}, done.stdout


def overturns(boxes, k_n=1e10):
    """By hand: (part of the arm of the right edge that is missing, k_h at which the stones turn over) by statics of a stack: the moment about the middle of
    each joint, with the lean of all joints below; a joint turns by 12 M / (k_n b^3) while it is closed, then by 2 W / (k_n a^2), a three times the way of the
    resultant from the edge. b: width of a joint; the rigid limit is the least of arm over height."""
    x, y, w, h = np.array(boxes).T
    weight, centre, height = 2400 * 9.81 * w * h, x + w / 2, y + h / 2
    left, right = np.r_[x[0], np.maximum(x[1:], x[:-1])], np.r_[x[0] + w[0], np.minimum((x + w)[1:], (x + w)[:-1])]
    b, middle, n = right - left, (left + right) / 2, len(boxes)
    above = [weight[j:].sum() for j in range(n)]
    rigid = min((right[j] - weight[j:] @ centre[j:] / above[j]) / (weight[j:] @ (height[j:] - y[j]) / above[j]) for j in range(n))

    def stands(k):
        turn = np.zeros(n)
        for _ in range(4000):
            new = []
            for j in range(n):
                lean = [sum(turn[i] * (height[s] - y[i]) for i in range(s + 1)) - sum(turn[i] * (y[j] - y[i]) for i in range(j)) for s in range(j, n)]
                e = weight[j:] @ (k * (height[j:] - y[j]) + lean + centre[j:] - middle[j]) / above[j]
                if e >= b[j] / 2:
                    return False
                new.append(12 * above[j] * e / (k_n * b[j] ** 3) if e < b[j] / 6 else 2 * above[j] / (k_n * (3 * (b[j] / 2 - e)) ** 2))
            if np.abs(new - turn).max() < 1e-10:
                return True
            turn = np.array(new)
        return False

    low, high = 0.0, rigid
    while high - low > 1e-4 * rigid:
        low, high = ((low + high) / 2, high) if stands((low + high) / 2) else (low, (low + high) / 2)
    return 1 - low / rigid, low


@pytest.mark.skipif(not os.path.exists(QUOIN), reason="the solver is not built")
@pytest.mark.parametrize("boxes, mirrored, ranks, n, edge", [
    (COLUMN, False, 1, 5, None), pytest.param(COLUMN, True, 2, 5, None, marks=pytest.mark.alone),
    pytest.param(LEANING, False, 2, 5, (1.0, 0.0), marks=pytest.mark.alone), (LEANING, True, 1, 5, (-1.0, 0.0)),
    ([(-1.0, 0.0, 3.0, 2.0)] + [(0.0, 2.0 + 2.0 * i, 1.0, 2.0) for i in range(3)], False, 1, 3, None),
], ids=["column", "column mirrored", "leaning", "leaning mirrored", "on a plinth"])  # fmt: skip
def test_shaken_stones_say_that_they_overturn_early(tmp_path, monkeypatch, boxes, mirrored, ranks, n, edge):
    """A column of stones in time: the joint that opens and what its hinge misses of its arm, which is what a slow push finds missing too."""
    stages, printed = stones(tmp_path, boxes, mirrored, ranks)
    hinge, missing, tilt = stages["shaken"]["rocking_hinge"], *overturns(boxes)
    stable, failing = (0.1 * stages["tilt"]["load_factor"][end] for end in ("stable", "failing"))
    assert stable < 1.003 * tilt and failing > 0.997 * tilt  # the run against statics by hand
    assert hinge["macroblocks"] == n and hinge["missing"] == pytest.approx(missing, rel=0.08) and hinge["missing"] < missing  # the other joints give a little too
    assert edge is None or (hinge["x"], hinge["y"]) == edge
    said = [line for line in printed.splitlines() if "of the arm of a rigid hinge is missing" in line]
    assert len(said) == 1 and f"warning: stage shaken: {n} bodies" in said[0] and f", and {hinge['missing']:.2g} of the arm" in said[0]
    assert "rocking_hinge" not in stages["rest"] and "rocking_hinge" not in stages["tilt"]
    complaint = assessment.hinge_complaints(stages["shaken"])
    words = f"{n} bodies that turn over together have an arm {100 * hinge['missing']:.0f} % shorter than about a rigid edge"
    assert len(complaint) == 1 and words in complaint[0] and not assessment.hinge_complaints(stages["rest"])
    monkeypatch.setattr(report.plots, "drawing", lambda *_, **__: nullcontext(list))
    assert report.main([str(tmp_path), "--guideline", "usace", "--condition", "shaken=extreme"]) == 0
    assert (tmp_path / "report.html").read_text(encoding="utf-8").count(words) == 1


@pytest.mark.skipif(not os.path.exists(QUOIN), reason="the solver is not built")
def test_propped_stones_have_no_hinge(tmp_path):
    """A column between two others turns about neither edge; its outer neighbours do, each away from it."""
    boxes = [(float(x), y, 1.0, 2.0) for x in (0, 1, 2) for _, y, _, _ in COLUMN]
    hinge = stones(tmp_path, boxes)[0]["shaken"]["rocking_hinge"]
    assert (hinge["x"], hinge["y"], hinge["macroblocks"]) in ((0.0, 0.0, 5), (3.0, 0.0, 5))
    wide = [(0.0, 0.0, 4.0, 2.0), (0.0, 2.0, 4.0, 2.0)]
    assert "rocking_hinge" not in stones(tmp_path, wide)[0]["shaken"]
    glued = STONES[: STONES.index("  - tilt")].replace("friction: 60", "law: elastic")  # joints that never open
    assert "rocking_hinge" not in stones(tmp_path, COLUMN, text=glued)[0]["shaken"]


def test_hinges_in_one_line(tmp_path, capsys):
    (tmp_path / "scene.yaml").write_text("title: nothing\n", encoding="utf-8")
    assert hinges.main([str(tmp_path / "scene.yaml")]) == 2
    assert capsys.readouterr().err == f"limit: quoin: error: {tmp_path / 'scene.yaml'}: model: missing\n"


@pytest.mark.parametrize("part", ["0", "-1", "2", "nan"])
def test_part_that_is_none(part, capsys):
    with pytest.raises(SystemExit) as stopped:
        hinges.main(["scene.yaml", "--part", part])
    assert stopped.value.code == 2 and f"--part {part}: expected a number between 0 and 1" in capsys.readouterr().err


def test_options_of_stiffer_joints():
    joints = {"default": {"k_n": 1e10, "k_s": "5e9"}, "base": {"friction": 30}, "top": None}
    assert hinges.stiffer(joints, 10.0) == ["-joints_default_k_n", "1e+11", "-joints_default_k_s", "5e+10"]
