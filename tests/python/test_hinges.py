"""quoin_tools.hinges: the limit of rigid hinges from two stiffnesses, against statics. docs/rigid_blocks.md."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from quoin_tools.assess import hinges  # noqa: E402
from quoin_tools.mesh import blockmesh  # noqa: E402
from quoin_tools.mesh.meshing import join, rectangle, renamed  # noqa: E402

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
    once, _, ten, rigid, missing, pressed, pressed_ten, times = map(float, row[1:])
    assert once < 0.98 * exact and once < ten < 0.992 * exact and rigid == pytest.approx(exact, rel=3e-3)
    assert pressed > 1.5 * pressed_ten > 0.03 and missing == pytest.approx(1 - once / rigid, rel=0.05)
    assert times == pytest.approx(max(1.0, (missing / 0.01) ** 3), rel=0.1)


def test_hinges_in_one_line(tmp_path, capsys):
    (tmp_path / "scene.yaml").write_text("title: nothing\n", encoding="utf-8")
    assert hinges.main([str(tmp_path / "scene.yaml")]) == 2
    assert capsys.readouterr().err == f"hinges: quoin: error: {tmp_path / 'scene.yaml'}: model: missing\n"


def test_options_of_stiffer_joints():
    joints = {"default": {"k_n": 1e10, "k_s": "5e9"}, "base": {"friction": 30}, "top": None}
    assert hinges.stiffer(joints, 10.0) == ["-joints_default_k_n", "1e+11", "-joints_default_k_s", "5e+10"]
