"""Drawings (DXF) as sections: drawings that the tests write, whole ones and broken ones."""

import math
import os
import subprocess
from pathlib import Path

import pytest
from quoin_tools.base.results import Results
from quoin_tools.mesh import section
from quoin_tools.mesh.blockmesh import check, macroblocks
from test_section import group_areas, lengths

pytest.importorskip("gmsh")
ezdxf = pytest.importorskip("ezdxf")

QUOIN = Path(os.environ.get("QUOIN", Path(__file__).resolve().parents[2] / "build/quoin"))
DAM, ROCK = [(0, 0), (9, 0), (4, 10), (1, 10)], [(-20, -15), (29, -15), (29, 0), (9, 0), (0, 0), (-20, 0)]
TABLE = """\
drawing: {file: dam.dxf, units: m}
size: 2
layers:
  Dam: {group: dam}
  ROCK: {group: rock, size: 6, sides: true}
  GALLERY: {hole: gallery}
  BASE: {joint: base}
  SEAM: {joint: seam}
  FACE: {faces: upstream}
  DRAIN: {drain: drain}
  TENDON: {anchor: tendon}
  PROBE: {point: crest}
"""


def drawn(folder, change=None, scale=1.0, units=6, at=(0.0, 0.0)):
    """dam.dxf: a dam in lines, a gallery with an arch, rock as a polyline, a seam that overshoots, and the rest."""
    document = ezdxf.new(units=units)
    space = document.modelspace()

    def xy(*points):
        return [((x + at[0]) * scale, (y + at[1]) * scale) for x, y in points]

    def polyline(layer, points, close=False):
        return space.add_lwpolyline(xy(*points), close=close, dxfattribs={"layer": layer})

    for a, b in zip(DAM, DAM[1:] + DAM[:1]):
        space.add_line(*xy(a, b), dxfattribs={"layer": "DAM"})
    polyline("ROCK", ROCK, close=True)
    for a, b in (((3, 3.5), (3, 2)), ((3, 2), (4, 2)), ((4, 2), (4, 3.5))):
        space.add_line(*xy(a, b), dxfattribs={"layer": "GALLERY"})
    space.add_arc(xy((3.5, 3.5))[0], 0.5 * scale, 0, 180, dxfattribs={"layer": "GALLERY"})
    polyline("BASE", [(0, 0), (9, 0)])
    polyline("SEAM", [(-30, -8), (40, -3)])
    polyline("FACE", [(0, 0), (1, 10)])
    polyline("DRAIN", [(3.5, 2), (3.5, -6)])
    polyline("TENDON", [(2, -12), (2, 10)])
    space.add_point(xy((1, 10))[0], dxfattribs={"layer": "PROBE"})
    space.add_text("Barragem", dxfattribs={"layer": "TEXT"})
    if change:
        change(space, polyline, xy)
    document.saveas(folder / "dam.dxf")


def table(folder, text=TABLE):
    (folder / "dam.yaml").write_text(text)
    return folder / "dam.yaml"


def expect_whole(mesh, made):
    check(mesh)
    gallery = 1.5 + math.pi / 8  # the arch is a half circle within 2 cm
    assert group_areas(mesh)["rock"] == pytest.approx(49 * 15, rel=1e-7)
    assert group_areas(mesh)["dam"] == pytest.approx(60 - gallery, abs=0.02)
    assert macroblocks(mesh).max() + 1 == 3  # dam, rock above and below the seam
    found = lengths(mesh)
    seam = 2 * 49 * math.hypot(70, 5) / 70
    expected = {"base": 18, "seam": seam, "upstream": math.hypot(1, 10), "rock_sides": 30, "rock_bottom": 49}
    assert {name: found[name] for name in expected} == pytest.approx(expected, rel=1e-7)
    assert found["gallery"] == pytest.approx(4 + math.pi / 2, rel=0.01)
    assert mesh.vertices[mesh.points["crest"]] == pytest.approx([1, 10])
    assert made.drains["drain"] == [pytest.approx((3.5, 2)), pytest.approx((3.5, -6))]
    assert made.anchors["tendon"] == [pytest.approx((2, 10)), pytest.approx((2, -12))]  # the head is above


def test_layers_become_groups_joints_faces(tmp_path):
    drawn(tmp_path)
    mesh, made, notes = section.mesh_of(table(tmp_path))
    expect_whole(mesh, made)
    assert notes == ["layers of the drawing that are not in the table: TEXT"]


@pytest.mark.parametrize("unit, metre, code", [("mm", 1000, 4), ("cm", 100, 5), ("ft", 1 / 0.3048, 2)])
def test_units_and_origin(tmp_path, unit, metre, code):
    """The same dam, drawn elsewhere and in another unit, which the drawing says or the table."""
    origin = f"origin: [{500 * metre}, {-200 * metre}]"
    drawn(tmp_path, scale=metre, units=code, at=(500, -200))
    for text in (f"{{file: dam.dxf, {origin}}}", f"{{file: dam.dxf, units: {unit}, {origin}}}"):
        mesh, made, _ = section.mesh_of(table(tmp_path, TABLE.replace("{file: dam.dxf, units: m}", text)))
        expect_whole(mesh, made)


def test_units_that_disagree_or_cannot_be(tmp_path):
    drawn(tmp_path, units=4)
    notes = section.load(table(tmp_path))[1]
    assert notes[0] == "the drawing says that its units are mm; they are taken as m, as the section file says"
    assert fault(tmp_path, TABLE.replace("units: m", "units: mm")).endswith("mm: the drawing would be 0.07 m across: wrong units or scale")
    drawn(tmp_path, units=0)
    assert "the drawing does not say its units, expected units: mm or cm or dm or m or km or in or ft or ft_us or yd" in fault(tmp_path, TABLE.replace(", units: m", ""))
    drawn(tmp_path, units=4, scale=1000)
    assert "the drawing would be 70000 m across: wrong units or scale" in fault(tmp_path)


def fault(folder, text=TABLE):
    with pytest.raises(section.DeclaredError) as raised:
        section.mesh_of(table(folder, text))
    assert len(raised.value.faults) == 1, raised.value.faults
    return raised.value.faults[0]


def remove(layer, n):
    def change(space, *_):
        space.delete_entity([entity for entity in space if entity.dxf.layer == layer][n])
    return change


def moved(layer, n, end, xy):
    def change(space, *_):
        setattr([entity for entity in space if entity.dxf.layer == layer][n].dxf, end, xy)
    return change


BROKEN = [
    (remove("DAM", 1), "layers.Dam: not closed: an end at (9, 0), the next open end, at (4, 10), is 11.2 m away"),
    (moved("DAM", 1, "end", (4, 9.999)), "layers.Dam: not closed: an end at (4, 9.999), the next open end, at (4, 10), is 0.001 m away"),
    (lambda space, line, _: line("DAM", [(9, 0), (9, 5)]), "layers.Dam: 3 lines meet at (9, 0), expected two: an outline is one ring"),
    (lambda space, line, _: line("ROCK", [(40, 0), (50, 10), (50, 0), (40, 10)], True), "layers.ROCK: its outline crosses itself (Self-intersection[45 5])"),
    (lambda space, line, _: line("ROCK", [(20, -20), (50, -20), (50, -10), (20, -10)], True), "layers.ROCK: two of its outlines cross or touch at (2"),
    (lambda space, line, _: line("GALLERY", [(60, 0), (61, 0), (61, 1)], True), "layers.GALLERY: its outline at (60, 0) is not inside a group"),
    (lambda space, line, _: line("BASE", [(0.001, 3), (2, 3)]), None),  # within the dam: a crack from its inside
    (lambda space, line, _: line("SEAM", [(-10, -0.004), (5, -3)]), "joint 'seam': (-10, -0.004) misses group 'rock' by 0.004 m: draw it there"),
    (lambda space, line, _: line("FACE", [(12, 1), (12, 5)]), "faces 'upstream': from (12, 1) to (12, 5) it lies outside all groups"),
    (lambda space, line, _: line("FACE", [(3, 5), (3, 7)]), "faces 'upstream': from (3, 5) to (3, 7) it runs inside a group"),
    (lambda space, line, _: line("ROCK", [(2, 2), (2, 8), (-6, 8), (-6, 2)], True), "group 'dam' and group 'rock': overlap by"),
    (lambda space, line, _: line("ROCK", [(60, 0), (70, 0), (65, 0)], True), "layers.ROCK: its outline at (60, 0) has no area, expected one in the plane of x and y"),
    (lambda space, line, _: line("DRAIN", [(60, 5), (60, -5)]), "layers.DRAIN: from (60, 5) to (60, -5) it lies outside all groups"),
    (lambda space, line, _: line("TENDON", [(60, 5), (60, -5)]), "layers.TENDON: from (60, 5) to (60, -5) it lies outside all groups"),
    (lambda space, *_: space.add_blockref("none", (0, 0)), "on layer 0: there is no block 'none')"),
    (lambda space, *_: space.add_blockref("ring", (0, 0)) and space.doc.blocks.new("ring").add_blockref("ring", (1, 0)), "no drawing that can be read (a block of it holds itself)"),
    (remove("SEAM", 0), "layers.SEAM: no such layer in the drawing, which has BASE, DAM, DRAIN, FACE"),
]


@pytest.mark.parametrize("change, reason", BROKEN, ids=range(len(BROKEN)))
def test_what_is_broken_is_named_with_its_place(tmp_path, change, reason):
    drawn(tmp_path, change)
    if reason:
        assert reason in fault(tmp_path)
    else:
        section.mesh_of(table(tmp_path))


def test_a_gap_that_is_allowed_is_closed(tmp_path):
    """1 mm in the outline of the dam."""
    drawn(tmp_path, moved("DAM", 1, "end", (4, 9.999)))
    mesh, made, _ = section.mesh_of(table(tmp_path, TABLE.replace("units: m", "units: m, gap: 0.002")))
    assert group_areas(mesh)["dam"] == pytest.approx(60 - 1.5 - math.pi / 8, abs=0.03)
    assert lengths(mesh)["base"] == pytest.approx(18, abs=0.01)


@pytest.mark.parametrize("top", [-0.001, 0.001])
def test_a_rock_that_misses_the_dam(tmp_path, top):
    """Its top, without corners at heel and toe, is 1 mm too low or too high: named, or with a gap the dam stands on it."""
    def change(space, polyline, _):
        remove("ROCK", 0)(space)
        polyline("ROCK", [(-20, -15), (29, -15), (29, top), (3, top), (-20, top)], True)

    drawn(tmp_path, change)
    assert "by 0.001 m: draw it there, or give the drawing a gap above 0.001" in fault(tmp_path)
    mesh, _, _ = section.mesh_of(table(tmp_path, TABLE.replace("units: m", "units: m, gap: 0.002")))
    assert lengths(mesh)["base"] == pytest.approx(18, abs=0.01) and macroblocks(mesh).max() + 1 == 3
    base = mesh.face_sets["base"]
    assert sorted(mesh.block_group[base[:, 0]].tolist()) == [0] * (len(base) // 2) + [1] * (len(base) // 2)


ALONE = """\
drawing: {file: dam.dxf}
size: 2
layers:
  DAM: {group: dam}
  GALLERY: {hole: gallery}
  SEAM: {joint: seam}
rock: {heel: [0, 0], toe: [9, 0], upstream: 20, downstream: 20, depth: 15}
"""


def test_rock_below_a_drawn_dam(tmp_path):
    """The outline alone: base, faces, crest and points get the names of a section, rock and supports too."""
    drawn(tmp_path)
    mesh, made, _ = section.mesh_of(table(tmp_path, ALONE))
    check(mesh)
    expected = {"base": 18, "upstream": math.hypot(1, 10), "downstream": math.hypot(5, 10), "crest": 3, "rock_sides": 30, "rock_bottom": 49,
                "seam": 2 * 49 * math.hypot(70, 5) / 70, "rock_top_upstream": 20, "rock_top_downstream": 20}  # fmt: skip
    found = lengths(mesh)
    assert found.pop("gallery") > 0 and found == pytest.approx(expected)
    assert {name: tuple(mesh.vertices[vertex]) for name, vertex in mesh.points.items()} == {
        "heel": (0, 0), "toe": (9, 0), "crest_upstream": (1, 10), "crest_downstream": (4, 10), "rock_heel": (0, 0), "rock_toe": (9, 0)}  # fmt: skip
    assert group_areas(mesh)["rock"] == pytest.approx(49 * 15)


@pytest.mark.parametrize("old, new, reason", [
    ("heel: [0, 0]", "heel: [0, 1]", ":7: rock.heel: [0, 1]: expected a corner of the dam, the nearest is (0, 0)"),
    ("heel: [0, 0], toe: [9, 0]", "heel: [9, 0], toe: [0, 0]", ":7: rock.toe: [0, 0]: expected right of the heel, both below the crest"),
    ("toe: [9, 0]", "toe: [1, 10]", ":7: rock.toe: [1, 10]: expected right of the heel, both below the crest"),
    ("heel: [0, 0], ", "", ":7: rock: 'heel' is missing, expected a point [x, y]"),
    ("depth: 15", "deep: 15", ":7: rock.deep: unknown key"),
    ("  DAM", "  ROCK: {group: ground}\n  DAM", ":8: rock: its outline crosses itself"),
])  # fmt: skip
def test_rock_that_cannot_be(tmp_path, old, new, reason):
    drawn(tmp_path)
    assert reason in fault(tmp_path, ALONE.replace(old, new))


def test_lines_drawn_twice(tmp_path):
    def change(space, polyline, xy):
        space.add_line(*xy(DAM[1], DAM[0]), dxfattribs={"layer": "DAM"})
        polyline("SEAM", [(40, -3), (-30, -8)])

    drawn(tmp_path, change)
    mesh, made, notes = section.mesh_of(table(tmp_path))
    expect_whole(mesh, made)
    assert notes[1:] == ["layer Dam: drawn twice, from (9, 0) to (0, 0); once is used", "layer SEAM: drawn twice, from (40, -3) to (-30, -8); once is used"]


def test_hidden_layers_are_told(tmp_path):
    """Frozen or off: the table names them, so they are read; nobody is left to guess."""

    def change(space, polyline, xy):
        space.doc.layers.add("Seam").freeze()
        space.doc.layers.add("GALLERY").off()
        space.doc.layers.add("TEXT").off()

    drawn(tmp_path, change)
    mesh, made, notes = section.mesh_of(table(tmp_path))
    expect_whole(mesh, made)
    assert sorted(notes[:2]) == [
        "layer GALLERY is off in the drawing; it is read, since the table has it",
        "layer Seam is frozen in the drawing; it is read, since the table has it",
    ]
    assert len(notes) == 3


def test_outlines_drawn_twice_otherwise(tmp_path):
    """By other lines, from another corner: one within another is cut out of it, but not one that is the same."""
    def change(space, polyline, xy):
        polyline("DAM", [DAM[2], DAM[1], DAM[0], DAM[3]], True)
        polyline("ROCK", ROCK[2:] + ROCK[:2], True)

    drawn(tmp_path, change)
    made, notes = section.load(table(tmp_path))
    assert sum(region.shape.area for region in made.regions) == pytest.approx(60 - 1.5 - math.pi / 8 + 49 * 15, abs=0.02)
    assert notes[1:] == ["layer Dam: the outline at (0, 0) is drawn twice; once is used", "layer ROCK: the outline at (29, 0) is drawn twice; once is used"]


def test_blocks_on_layer_0_and_dimensions(tmp_path):
    """What a block has on layer 0 is on the layer of the block, also of one within it; lines of a dimension are no outline; a frame elsewhere says nothing of the size."""
    document = ezdxf.new(units=6)
    document.blocks.new("inner").add_lwpolyline([(0, 0), (12, 0), (12, 6), (0, 6)], close=True, dxfattribs={"layer": "0"})
    document.blocks.new("outer").add_blockref("inner", (0, 0), dxfattribs={"layer": "0"})
    space = document.modelspace()
    space.add_blockref("outer", (0, 0), dxfattribs={"layer": "DAM"})
    space.add_linear_dim(base=(0, -2), p1=(0, 0), p2=(12, 0), dxfattribs={"layer": "DAM"}).render()
    space.add_lwpolyline([(-1e4, -1e4), (1e4, -1e4), (1e4, 1e4)], close=True, dxfattribs={"layer": "FRAME"})
    document.saveas(tmp_path / "dam.dxf")
    text = "drawing: {file: dam.dxf}\nsize: 6\nlayers:\n  DAM: {group: dam}\npoints: {a: [3, 3], b: [3, 3]}\n"
    mesh, _, notes = section.mesh_of(table(tmp_path, text))
    assert group_areas(mesh)["dam"] == pytest.approx(72) and mesh.points["a"] == mesh.points["b"]
    assert notes == ["layers of the drawing that are not in the table: FRAME", "layer DAM: 1 DIMENSION not read"]
    assert "the drawing would be 0.012 m across: wrong units or scale" in fault(tmp_path, text.replace("dam.dxf", "dam.dxf, units: mm"))


def test_a_block_of_the_drawing_and_a_pattern(tmp_path):
    """A dam that is a block inserted twice as large, filled with courses; two probes are numbered."""
    document = ezdxf.new(units=6)
    document.blocks.new("D").add_lwpolyline([(0, 0), (6, 0), (6, 3), (0, 3)], close=True, dxfattribs={"layer": "DAM"})
    space = document.modelspace()
    space.add_blockref("D", (0, 0), dxfattribs={"xscale": 2, "yscale": 2, "layer": "DAM"})
    for x in (2, 4):
        space.add_circle((x, 6), 0.3, dxfattribs={"layer": "PROBE"})
    document.saveas(tmp_path / "dam.dxf")
    text = "drawing: {file: dam.dxf}\nsize: 3\nlayers:\n  DAM: {group: dam, pattern: {courses: 1, stones: 2}}\n  PROBE: {point: probe}\n"
    mesh, _, _ = section.mesh_of(table(tmp_path, text))
    assert macroblocks(mesh).max() + 1 == 39 and lengths(mesh)["joint_bed"] == pytest.approx(2 * 5 * 12)
    assert [mesh.vertices[mesh.points[f"probe_{i}"]].tolist() for i in (1, 2)] == [[2, 6], [4, 6]]


@pytest.mark.skipif(not QUOIN.exists(), reason="the solver is not built")
def test_the_draft_of_a_scene_runs(tmp_path, capsys):
    """With drain and anchor of the drawing; reactions are the weight, and the drain is where its line meets the base."""
    drawn(tmp_path)
    model, scene = tmp_path / "m.h5", tmp_path / "draft.yaml"
    arguments = [str(table(tmp_path)), "-o", str(model), "--scene", str(scene)]
    assert section.main(arguments) == 0
    text = scene.read_text()
    assert "drain: 3.5}" in text and "head: [2, 10], root: [2, -12]" in text and "level: 10}" in text
    subprocess.run([QUOIN, "-options_file", scene, "-output", tmp_path / "out"], check=True, stdout=subprocess.DEVNULL)
    stages = Results(tmp_path / "out").summary["stages"]
    assert [stage["verdict"] for stage in stages] == ["converged"] * 3
    assert stages[0]["reaction"]["y"] == pytest.approx(2400 * 9.81 * (60 - 1.5 - math.pi / 8), rel=1e-3)
    for path, taken in ((model, scene), (model, model)):  # refused before anything is written
        capsys.readouterr()
        before = path.read_bytes()
        path.unlink()
        assert section.main([*arguments[:3], "--scene", str(taken)]) == 2
        words = capsys.readouterr().err
        assert words.count("\n") == 1 and f"{taken}: is " in words and "expected a new file for the draft" in words
        assert not path.exists() and scene.read_text() == text
        path.write_bytes(before)


BAD = [
    ("file: dam.dxf", "file: no.dxf", ":1: drawing.file: no.dxf: no drawing that can be read (No such file or directory)"),
    ("file: dam.dxf", "file: dam.yaml", ":1: drawing.file: dam.yaml: no drawing that can be read ("),
    ("units: m", "units: ells", ":1: drawing.units: ells: expected mm or cm or dm or m or km or in or ft or ft_us or yd"),
    ("units: m", "units: m, gap: -1", ":1: drawing.gap: -1: expected a number [m] at least 0 and at most 0.5"),
    ("{group: dam}", "{group: dam, joint: x}", ":4: layers.Dam.joint: expected only one of group or hole or joint"),
    ("{group: dam}", "{grp: dam}", ":4: layers.Dam: expected group or hole or joint or faces or drain or anchor or point"),
    ("{point: crest}", "{point: 1st}", ":12: layers.PROBE.point: 1st: a name is a letter"),
    ("{faces: upstream}", "{faces: rock}", "'rock' names two things"),
]


@pytest.mark.parametrize("old, new, reason", BAD, ids=range(len(BAD)))
def test_a_mistake_in_the_table_is_one_line(tmp_path, old, new, reason):
    drawn(tmp_path)
    assert TABLE.count(old) == 1
    found = fault(tmp_path, TABLE.replace(old, new)) if "grp" not in new else faults(tmp_path, TABLE.replace(old, new))[0]
    assert reason in found


def faults(folder, text):
    with pytest.raises(section.DeclaredError) as raised:
        section.mesh_of(table(folder, text))
    return raised.value.faults
