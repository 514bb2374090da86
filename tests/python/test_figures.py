"""Figures, looked at before they are saved: the gravity method without tension, openings of the results, every stage, the rock in an inset that covers nothing."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from matplotlib import pyplot
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from PIL import Image
from quoin_tools.assess.assessment import assess, load_case
from quoin_tools.assess.assessment_options import options_from, parser
from quoin_tools.base import files, sheet_units
from quoin_tools.base.results import Results
from quoin_tools.mesh import blockmesh
from quoin_tools.mesh.meshing import quad_patch
from quoin_tools.show import anchor_pictures, joints, plots, section, section_marks, stress, style

ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
DENSITY = 2400  # [kg/m3] of the dam of examples/engineers_dam
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
    crack = " ".join([text.get_text() for text in sigma.get_legend().get_texts()][1].split())  # of two lines
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


def insets(panel):
    """What stands in a panel but its bar of colours."""
    return [axes for axes in panel.child_axes if axes.get_xlabel()]


@solver
def test_the_rock_is_in_an_inset(dam, drawn, tmp_path):
    """Of Guilhofrei, whose rock deforms: all blocks, and beside the dam. A rigid rock has no stresses to show."""
    assert stress.plot_stress(dam, "full", "") and not any(insets(panel) for panel in drawn[0].axes)
    subprocess.run([sys.executable, ROOT / "examples/guilhofrei/mesh.py", tmp_path / "model.h5"], check=True, env=os.environ | {"PYTHONPATH": str(ROOT / "tools")})
    command = [QUOIN, "-options_file", ROOT / "examples/guilhofrei/scene.yaml", "-model", tmp_path / "model.h5", "-output", tmp_path, "-stages", "sw"]
    subprocess.run(command, check=True, capture_output=True)
    guilhofrei = Results(tmp_path)
    assert stress.plot_stress(guilhofrei, "sw", "")
    figure = drawn[1]
    figure.canvas.draw()
    for panel, values in zip(figure.axes[:2], (guilhofrei.stage("sw").s1, guilhofrei.stage("sw").s2)):
        (inset,) = insets(panel)
        assert np.allclose(inset.collections[0].get_array(), values / 1e6)
        covered = inset.get_tightbbox().transformed(panel.transData.inverted())
        vertices = guilhofrei.mesh.vertices[style.inside(guilhofrei.mesh.vertices, style.view(guilhofrei.mesh)[0])]
        assert len(vertices) > 100 and not any(covered.contains(x, y) for x, y in vertices)
        low_x, high_x = inset.get_xlim()
        assert low_x < guilhofrei.mesh.vertices[:, 0].min() and high_x > guilhofrei.mesh.vertices[:, 0].max()
    assert not figure.axes[2].child_axes
    assert stress.plot_stress(guilhofrei, "sw", "", whole=True) and not any(insets(panel) for panel in drawn[2].axes)


def free(axis):
    """Whether numbers of its ticks are seen, and keep clear of each other."""
    low, high = sorted(axis.get_view_interval())
    boxes = [tick.label1.get_window_extent() for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
    return boxes and not any(a.overlaps(b) for a, b in zip(boxes, boxes[1:]))


@pytest.mark.parametrize("unit", ["si", "us"])
@pytest.mark.parametrize("box", [(-0.5, 7.5, -1, 41), (-0.4, 4.4, -20, 45), (0, 0.8, 0, 8), (-10, 50, -5, 40), (-70, 90, -40, 45)])
def test_numbers_along_a_view_keep_clear_of_each_other(box, unit, monkeypatch):
    monkeypatch.setattr(sheet_units, "current", unit)
    figure, axes = pyplot.subplots(figsize=style.figure_size(box, height=6.5), layout="none")
    style.placed(figure, *anchor_pictures.ROUND)
    style.set_view(axes, box)
    if unit != sheet_units.SI:
        style.unit_axes(figure)
    figure.canvas.draw()
    assert free(axes.xaxis)
    pyplot.close(figure)


@solver
def test_titles_of_slender_panels_keep_clear_of_each_other(drawn, tmp_path):
    blockmesh.write(tmp_path / "model.h5", quad_patch((0, 0), (8, 0), (4, 36), (0, 36), 4, 12, group="dam"))
    scene = {"model": "model.h5", "output": "out", "materials": {"dam": {"density": DENSITY, "young": 1e10, "poisson": 0.2}}, "supports": {"bottom": {"fix": "xy"}},
             "loads": {"weight": {"type": "self_weight", "groups": ["dam"]}}, "stages": [{"own": {"loads": ["weight"]}}]}
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(scene), encoding="utf-8")
    subprocess.run([QUOIN, "-options_file", "scene.yaml"], cwd=tmp_path, check=True, capture_output=True)
    assert stress.plot_stress(Results(tmp_path / "out"), "own", "")
    figure = drawn[0]
    figure.canvas.draw()
    boxes = [axes.title.get_window_extent() for axes in figure.axes]
    assert not any(a.overlaps(b) for a, b in zip(boxes, boxes[1:])) and boxes[0].x0 > 0 and boxes[-1].x1 < figure.bbox.x1
    assert all(free(axes.xaxis) for axes in figure.axes)


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
    words = [text for axes in figure.axes for text in (*axes.texts, axes.yaxis.label, *(axes.get_legend().get_texts() if axes.get_legend() else ())) if text.get_text()]
    boxes = [text.get_window_extent() for text in (*words, figure.axes[2].xaxis.label)]
    assert all(figure.bbox.x0 < box.x0 and box.x1 < figure.bbox.x1 and figure.bbox.y0 < box.y0 and box.y1 < figure.bbox.y1 for box in boxes)


@solver
def test_cycles_of_one_stage_stand_at_their_places(dam, drawn, monkeypatch):
    """No number beyond the last cycle, which would stand at its place."""
    rows = dam.history["stage"] == dam.stages[0]
    monkeypatch.setattr(type(dam), "history", {name: column[rows] for name, column in dam.history.items()})
    assert plots.plot_history(dam, "")
    bottom = drawn[0].axes[2]
    ticks, cycle = bottom.get_xticks(), dam.history["cycle"]
    assert len(ticks) > 3 and cycle[0] <= ticks.min() and ticks.max() <= cycle[-1]
    places = bottom.transData.transform([(tick, 0) for tick in ticks])[:, 0]
    assert np.allclose(np.diff(places), np.diff(places).mean())


# ---- the section of the sheet


SILTED = (("  water: {type: reservoir", "  silt: {type: reservoir, faces: upstream, level: 14, density: 950}\n  drained: {type: uplift, faces: base, level: 33, rule: npb, drain: 4.72}\n"
           "  water: {type: reservoir"), ("loads: [weight, water]", "loads: [weight, water, silt, drained]"))  # fmt: skip


@pytest.fixture
def section_of(monkeypatch):
    """The figure of a section, before it is text."""
    figures = []
    monkeypatch.setattr(section.pyplot, "close", figures.append)

    def made(folder, stage):
        case = load_case(folder, options_from(parser("report", "").parse_args([str(folder)])))
        found, _ = assess(case)
        section.section_svg(case, stage, [one for one in found if one.stage == stage])
        return figures[-1]

    return made


def label_boxes(figure):
    figure.canvas.draw()
    renderer = figure.canvas.get_renderer()
    return {text.get_text(): (text.get_bbox_patch() or text).get_window_extent(renderer) for text in figure.axes[0].texts if text.get_text()}


def assert_apart(figure):
    boxes, inside = list(label_boxes(figure).values()), figure.axes[0].get_window_extent()
    assert not any(section_marks.overlap(a, b) for i, a in enumerate(boxes) for b in boxes[i + 1 :])
    assert all(inside.x0 <= box.x0 and box.x1 <= inside.x1 and inside.y0 <= box.y0 and box.y1 <= inside.y1 for box in boxes)


@solver
def test_silt_is_no_level_of_water(section_of, tmp_path):
    """Guilhofrei with silt to 14 m and a drain: one level, that of the water; the silt named with its density, in another colour; drain, crest and toe drawn; no label covers another."""
    subprocess.run([sys.executable, ROOT / "examples/guilhofrei/mesh.py", tmp_path / "model.h5"], check=True, env=os.environ | {"PYTHONPATH": str(ROOT / "tools")})
    text = (ROOT / "examples/guilhofrei/scene.yaml").read_text(encoding="utf-8")
    for old, new in SILTED:
        assert text.count(old) == 1
        text = text.replace(old, new)
    (tmp_path / "scene.yaml").write_text(text, encoding="utf-8")
    command = [QUOIN, "-options_file", tmp_path / "scene.yaml", "-model", tmp_path / "model.h5", "-output", tmp_path / "out", "-stages", "sw,swhp"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    figure = section_of(str(tmp_path / "out"), "swhp")
    words = list(label_boxes(figure))
    assert [word for word in words if word.endswith(" m") and word[0].isdigit()] == ["33.00 m"]
    assert [word for word in words if word.startswith("silt ")] == [f"silt  {np.hypot(1, 0.05) * 9.81 * 0.95 * 14**2 / 2:.1f} kN (950 kg/m³)"]
    assert {"crest 33.00 m", "lowest 0.00 m", "drain of drained"} <= set(words)
    levels = [line for line in figure.axes[0].get_lines() if np.ptp(line.get_ydata()) == 0 and line.get_color() == section.WATER]
    assert [line.get_ydata()[0] for line in levels] == [33.0]
    reach = {colour: max(-np.array(lines.get_segments())[..., 0].min() for lines in figure.axes[0].collections if isinstance(lines, LineCollection)
                         and to_hex(lines.get_colors()[0]) == colour) for colour in (section.WATER, section_marks.SILT)}  # fmt: skip
    assert reach[section_marks.SILT] / reach[section.WATER] == pytest.approx(950 * 14 / (1000 * 33), rel=0.05)  # one scale
    drain = next(line for line in figure.axes[0].get_lines() if line.get_color() == section_marks.DRAIN).get_xydata()
    assert np.allclose(drain, 4.72 * np.array([22.8, 2.28]) / np.hypot(22.8, 2.28))
    assert_apart(figure)


@solver
def test_labels_of_the_anchored_dam_are_apart(dam, section_of):
    figure = section_of(dam.folder, "back")
    assert {"crest 36.00 m", "lift", "base"} <= set(label_boxes(figure))
    assert_apart(figure)


@solver
def test_section_in_feet(dam, section_of):
    with sheet_units.shown("us"):
        axes = section_of(dam.folder, "back").axes[0]
    axes.figure.canvas.draw()
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [ft]", "y [ft]")
    for axis in (axes.xaxis, axes.yaxis):
        places = [(place, float(label.get_text().replace("\u2212", "-"))) for place, label in zip(axis.get_ticklocs(), axis.get_ticklabels())]
        assert len(places) > 3 and all(place == pytest.approx(0.3048 * feet, abs=1e-9) for place, feet in places)


def test_labels_on_one_place_part():
    """Ten on one place, some at the edge: all are read, and stay in the picture."""
    figure, axes = joints.pyplot.subplots(figsize=(6, 4))
    axes.set_xlim(0, 10)
    axes.set_ylim(0, 10)
    for number in range(10):
        axes.text(5 if number < 6 else 9.9, 5, f"label {number}", bbox={"fc": "white"})
    axes.annotate("beside a place", (5, 5), (4, 4), textcoords="offset points")
    section_marks.spread(figure, axes)
    assert len(label_boxes(figure)) == 11 and axes.get_lines()
    assert_apart(figure)
    joints.pyplot.close(figure)


@solver
def test_weight_of_what_is_in_view(section_of, tmp_path):
    """Where rock has weight too its centre is far below the picture: the weight of the dam is drawn."""
    for name in ("section.yaml", "scene.yaml"):
        shutil.copy(ROOT / "examples/engineers_dam" / name, tmp_path)
    subprocess.run([sys.executable, "-m", "quoin_tools", "import", "section.yaml", "-o", "model.h5"], check=True, cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT / "tools")}, capture_output=True)
    subprocess.run([QUOIN, "-options_file", "scene.yaml", "-stages", "empty,full"], check=True, cwd=tmp_path, capture_output=True)
    figure = section_of(str(tmp_path / "out"), "full")
    mesh, words = Results(tmp_path / "out").mesh, list(label_boxes(figure))
    of_dam = mesh.areas()[mesh.block_group == mesh.group_names.index("dam")].sum() * DENSITY * 9.81
    drawn = next(word for word in words if " of dam " in word)
    assert abs(float(drawn.split(" ")[-2].replace("\u202f", "")) - of_dam / 1e3) < 1e-3 * of_dam / 1e3
    assert sum(word.startswith("drain of ") for word in words) == 2
    assert_apart(figure)


def test_a_picture_is_what_is_drawn_and_a_margin(tmp_path):
    """Its pixels are those of the figure; a figure drawn up to its edge is saved by matplotlib, with room beside it."""
    figure, axes = joints.pyplot.subplots(figsize=(4, 3), dpi=100, facecolor="#fff7e0")
    axes.plot([0, 1], color="#d55e00")
    files.save_figure(figure, tmp_path / "inner.png", margin=0.12)
    figure.canvas.draw()
    whole = np.asarray(figure.canvas.buffer_rgba())[:, :, :3]
    with Image.open(tmp_path / "inner.png") as image:
        assert image.mode == "RGB" and image.info["dpi"] == pytest.approx((100, 100), abs=0.01)
        seen = np.asarray(image)
    assert (seen[:12] == whole[0, 0]).all() and (seen[-12:] == whole[0, 0]).all() and (seen[:, :12] == whole[0, 0]).all() and (seen[:, -12:] == whole[0, 0]).all()
    inner = seen[12:-12, 12:-12]
    assert all((edge != whole[0, 0]).any() for edge in (inner[0], inner[-1], inner[:, 0], inner[:, -1]))
    rows, columns = (np.flatnonzero((whole != whole[0, 0]).any(axis=(other, 2))) for other in (1, 0))
    assert np.array_equal(inner, whole[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1])
    figure.text(0.99, 0.5, "beyond the edge")
    files.save_figure(figure, tmp_path / "outer.png", margin=0.12)
    with Image.open(tmp_path / "outer.png") as image:
        assert image.size[0] > 400
    joints.pyplot.close(figure)


@solver
def test_the_bar_of_forces_is_beside_the_section(dam, monkeypatch):
    """As high as most of it, right of it, where it is slender or wide too; no word goes beyond the figure."""
    figures = []
    monkeypatch.setattr(style, "save", lambda figure, path: figures.append(figure))
    for box in (None, (-2.0, 14.0, -16.0, 42.0), (-160.0, 190.0, -16.0, 42.0)):
        if box:
            monkeypatch.setattr(anchor_pictures, "box_of", lambda *_, box=box: box)
        assert anchor_pictures.plot_section(dam, "flood", "")
        figures[-1].canvas.draw()
        section_, bar = (axes.get_window_extent() for axes in figures[-1].axes)
        assert section_.y0 < bar.y0 and bar.y1 < section_.y1 and 0.65 < bar.height / section_.height < 0.75
        assert 0.15 < (bar.x0 - section_.x1) / figures[-1].dpi < 0.25
        label = figures[-1].axes[1].yaxis.label.get_window_extent()
        assert all(label.x0 > text.get_window_extent().x1 for text in figures[-1].axes[1].get_yticklabels()) and label.x1 < figures[-1].bbox.x1
