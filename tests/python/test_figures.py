"""Figures, looked at before they are saved: the gravity method without tension, openings of the results, every stage, the rock in an inset that covers nothing."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from quoin_tools.base.results import Results
from quoin_tools.show import joints, plots, stress, style

ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
solver = pytest.mark.skipif(not QUOIN.exists(), reason="the program is not built")


@pytest.fixture(scope="module")
def dam(tmp_path_factory):
    """Tendons and a flood: the base opens over most of its length."""
    folder = tmp_path_factory.mktemp("joints")
    subprocess.run([sys.executable, ROOT / "examples/anchored_dam/mesh.py", folder / "model.h5"], check=True, env=os.environ | {"PYTHONPATH": str(ROOT / "tools")})
    command = [QUOIN, "-options_file", ROOT / "examples/anchored_dam/scene.yaml", "-model", folder / "model.h5", "-output", folder]
    subprocess.run(command, check=True, capture_output=True)
    return Results(folder)


@pytest.fixture
def drawn(monkeypatch):
    """Figures that would be saved."""
    figures = []
    for module in (joints, plots, stress):
        monkeypatch.setattr(module, "save", lambda figure, path: figures.append(figure))
    return figures


def facts(N, M, length=10.0, angle=0.3):
    return {"N": N, "T": 0.2 * N, "M": M, "start": {"x": 1.0, "y": 2.0}, "end": {"x": 1.0 + length * np.cos(angle), "y": 2.0 + length * np.sin(angle)}}


@pytest.mark.parametrize("eccentricity", [0.0, 1.0, -1.6, 2.5, -4.0])
def test_the_gravity_method_bears_no_tension_and_balances(eccentricity):
    """Trapezium or triangle: its force is N, its moment N e, and nothing pulls."""
    N, length, thickness = 6e6, 10.0, 2.0
    (at, stress), words = joints.no_tension(facts(N, -eccentricity * N), thickness)
    x = np.linspace(0, length, 200_001)
    pressed = -thickness * np.interp(x, at, stress)
    middles, pieces = 0.5 * (x[1:] + x[:-1]), np.diff(x) * 0.5 * (pressed[1:] + pressed[:-1])
    assert np.isclose(pieces.sum(), N, rtol=1e-8) and np.isclose(pieces @ (middles - 5), N * eccentricity, rtol=1e-7, atol=1e-3)
    assert stress.max() <= 1e-9 * N
    assert ("crack" in words) == (abs(eccentricity) > length / 6)
    if abs(eccentricity) > length / 6:
        assert words.endswith(f"crack {length - 3 * (length / 2 - abs(eccentricity)):.2f} m")


def test_the_gravity_method_says_why_not():
    assert joints.no_tension(facts(-1.0, 0.0), 1.0) == (None, "nothing presses on the base: the part above is lifted")
    assert joints.no_tension(facts(1.0, 6.0), 1.0) == (None, "the resultant leaves the base: overturning")


def test_open_stretches():
    """An end that is open, an end where it closes on the way, all of it, none of it."""
    distance = np.array([[0.0, 1.0], [1.0, 3.0], [3.0, 4.0], [4.0, 6.0]])
    assert joints.open_stretches(distance, np.array([[2.0, 1.0], [1.0, -1.0], [-1.0, 0.0], [-1.0, 3.0]])) == [(0.0, 1.0), (1.0, 2.0), (4.5, 6.0)]


@solver
def test_an_open_joint_is_drawn_as_open(dam, drawn):
    s = dam.stage_summary("flood")["joints"]["base"]
    assert joints.plot_joint(dam, "flood", "base", "")
    sigma, tau, opening = drawn[0].axes
    assert [axes.get_ylabel().split(" [")[0] for axes in (sigma, tau, opening)] == ["normal stress σ", "shear stress τ", "opening"]
    distance, _, _, opened = dam.joint_profile("flood", "base", "opening")
    points = opening.get_lines()[0].get_xydata()
    assert np.allclose(points, np.column_stack([distance.ravel(), 1e3 * np.maximum(opened, 0).ravel()])) and points[:, 1].max() > 5
    spans = np.array([patch.get_extents().transformed(sigma.transData.inverted()).intervalx for patch in sigma.patches])
    assert np.isclose((spans[:, 1] - spans[:, 0]).sum(), s["open_length"], rtol=1e-6) and spans.min() == pytest.approx(0, abs=1e-9)
    crack = [text.get_text() for text in sigma.get_legend().get_texts()][1]
    assert crack.startswith("gravity method, no tension: crack 18.3") and abs(float(crack.split()[-2]) - s["open_length"]) < 0.3  # the block model's own is near
    assert joints.plot_joint(dam, "full", "lift", "") and len(drawn[1].axes) == 2  # closed: no panel of zeros


@solver
def test_a_joint_without_any_stress_is_one_panel(dam, drawn, monkeypatch):
    """Two panels of zeros would say nothing."""
    profile = dam.joint_profile("flood", "base", "opening")
    monkeypatch.setattr(dam, "joint_profile", lambda *_: (profile[0], 0 * profile[1], 0 * profile[2], np.abs(profile[3]) + 1e-3))
    monkeypatch.setitem(dam.stage_summary("flood")["joints"], "base", dam.stage_summary("flood")["joints"]["base"] | {"open_length": 24.0})
    assert joints.plot_joint(dam, "flood", "base", "")
    (axes,) = drawn[0].axes
    assert axes.get_ylabel() == "opening [mm]" and drawn[0].get_suptitle() == "Joint base, stage flood: it carries nothing, open over 24.00 of 24.00 m"


@solver
def test_the_rock_is_in_an_inset(dam, drawn, tmp_path):
    """Of Guilhofrei, whose rock deforms: all blocks, and beside the dam. A rigid rock has no stresses to show."""
    assert stress.plot_stress(dam, "full", "") and not any(panel.child_axes for panel in drawn[0].axes)
    subprocess.run([sys.executable, ROOT / "examples/guilhofrei/mesh.py", tmp_path / "model.h5"], check=True, env=os.environ | {"PYTHONPATH": str(ROOT / "tools")})
    command = [QUOIN, "-options_file", ROOT / "examples/guilhofrei/scene.yaml", "-model", tmp_path / "model.h5", "-output", tmp_path, "-stages", "sw"]
    subprocess.run(command, check=True, capture_output=True)
    guilhofrei = Results(tmp_path)
    assert stress.plot_stress(guilhofrei, "sw", "")
    figure = drawn[1]
    figure.canvas.draw()
    for panel, values in zip(figure.axes[:2], (guilhofrei.stage("sw").s1, guilhofrei.stage("sw").s2)):
        (inset,) = panel.child_axes
        assert np.allclose(inset.collections[0].get_array(), values / 1e6)
        covered = inset.get_tightbbox().transformed(panel.transData.inverted())
        vertices = guilhofrei.mesh.vertices[style.inside(guilhofrei.mesh.vertices, style.view(guilhofrei.mesh)[0])]
        assert len(vertices) > 100 and not any(covered.contains(x, y) for x, y in vertices)
        low_x, high_x = inset.get_xlim()
        assert low_x < guilhofrei.mesh.vertices[:, 0].min() and high_x > guilhofrei.mesh.vertices[:, 0].max()
    assert not figure.axes[2].child_axes
    assert stress.plot_stress(guilhofrei, "sw", "", whole=True) and not any(panel.child_axes for panel in drawn[2].axes)


@solver
def test_histories_show_every_stage(dam, drawn):
    """The flood takes 95 % of the cycles; each of the five stages before it has room, and a name that covers no other."""
    assert plots.plot_history(dam, "")
    figure = drawn[0]
    figure.canvas.draw()
    top = figure.axes[0]
    names = [text for text in top.texts if text.get_text() in dam.stages]
    assert [text.get_text() for text in names] == dam.stages
    boxes = [text.get_window_extent() for text in names]
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[i + 1 :])
    ends = [top.get_xlim()[0]] + [dam.history["cycle"][dam.history["stage"] == stage][-1] for stage in dam.stages]
    places = top.transAxes.inverted().transform(top.transData.transform([(end, 1) for end in ends]))[:, 0]
    assert np.diff(places).min() > 0.04 and places[0] == pytest.approx(0, abs=1e-6) and places[-1] == pytest.approx(1)
    ticks = [tick.get_text() for tick in figure.axes[2].get_xticklabels()]
    assert ticks[-1].replace("\u202f", "") == f"{ends[-1]:.0f}"
