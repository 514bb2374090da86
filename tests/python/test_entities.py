"""Entities of a drawing: curves by their right areas, what is passed over, and drawings that would never end."""

import math
import os
from pathlib import Path

import numpy as np
import pytest
import shapely
from quoin_tools.mesh import curves, section
from quoin_tools.mesh.blockmesh import areas, macroblocks

pytest.importorskip("gmsh")
ezdxf = pytest.importorskip("ezdxf")
from ezdxf.math import BSpline
from ezdxf.xclip import XClip

DRAWINGS = Path(__file__).resolve().parents[1] / "data" / "drawings"


def declared(folder, layers, drawing="dam.dxf", more="", size=2):
    rows = "".join(f"  {layer}: {{{role}}}\n" for layer, role in layers.items())
    (folder / "dam.yaml").write_text(f"drawing: {{file: {drawing}, units: m{more}}}\nsize: {size}\nlayers:\n{rows}")
    return folder / "dam.yaml"


def bodies_of(folder, layers, drawing="dam.dxf", more="", size=2):
    """Areas [m2] of the bodies, the largest first, and the notes."""
    mesh, _, notes = section.mesh_of(declared(folder, layers, drawing, more, size))
    return sorted(np.bincount(macroblocks(mesh), areas(mesh)).tolist(), reverse=True), notes


def fault(folder, layers, drawing="dam.dxf", more=""):
    with pytest.raises(section.DeclaredError) as raised:
        section.load(declared(folder, layers, drawing, more))
    assert len(raised.value.faults) == 1
    return raised.value.faults[0]


DAM, JOINT, HOLE = {"DAM": "group: dam"}, {"DAM": "group: dam", "JOINT": "joint: crack"}, {"DAM": "group: dam", "GALLERY": "hole: gallery"}


@pytest.mark.parametrize("name, layers, right, note", [
    ("cub_plain", DAM, [800], None),
    ("cub_rational", DAM, [800], None),
    ("ogee_mix100", DAM, [906.283], None),
    ("joint_mix", JOINT, [200, 200], None),
    ("open_unclamped", JOINT, [213.96, 186.04], None),
    ("per_wrapped", HOLE, [336.178], None),
    ("splinefit_mixed", JOINT, [60 - 2 * 5**3 / 36, 40 + 2 * 5**3 / 36], None),
    ("invisible", DAM, [100], "layer DAM: 1 invisible LWPOLYLINE not read"),
    ("dynamic", HOLE, [84], "layer GALLERY: 1 invisible LWPOLYLINE not read"),
    ("frozen_insert", JOINT, [50, 50], "layer JOINT: 1 LINE in block B on the frozen layer OLD not read"),
    ("n_out0", HOLE, [96], None),
    ("nohead_spline", HOLE, [100 - 4 * math.pi], None),
    ("r12_viewport", DAM, [100], "layers of the drawing that are not in the table: 0"),
])  # fmt: skip
def test_drawings_of_others(tmp_path, name, layers, right, note):
    """Areas by closed forms or integrals of the curves; polylines are within 2 mm of them, over some 10 to 40 m."""
    found, notes = bodies_of(tmp_path, layers, DRAWINGS / f"{name}.dxf", ", chord: 0.002")
    assert found == pytest.approx(right, abs=0.05)
    assert notes == ([note] if note else [])


def spline_points(document, points, knots, degree, weights=None):
    entity = document.modelspace().add_spline()
    entity.dxf.degree, entity.control_points, entity.knots = degree, points, knots
    entity.weights = weights if weights is not None else []
    return curves.points_of(entity, 0.01)


@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5, 7])
@pytest.mark.parametrize("rational", [False, True])
def test_splines_lie_within_the_chord(degree, rational):
    """Uneven knots, clamped or not, single and double ones: every point that ezdxf gives on the valid range is within the chord, and every corner on the curve."""
    draw, document = np.random.default_rng(10 * degree + rational), ezdxf.new()
    for clamped in (True, False):
        count = degree + 6
        points = np.column_stack([draw.uniform(0, 20, (count, 2)), np.zeros(count)])
        weights = draw.uniform(0.2, 5, count).tolist() if rational else None
        knots = np.cumsum(draw.uniform(0.05, 3, count + degree + 1))
        if degree > 1:
            knots[degree + 2] = knots[degree + 3]
        if clamped:
            knots = np.clip(knots, knots[degree], knots[count])
        xy = spline_points(document, points, knots.tolist(), degree, weights)[:, :2]
        zero = knots - knots[0]  # ezdxf maps others to 0 to 1
        inside = np.unique(np.concatenate([np.linspace(a, b, 60) for a, b in zip(zero[degree:count], zero[degree + 1:count + 1])]))
        right = np.array([(p.x, p.y) for p in BSpline(points, degree + 1, zero.tolist(), weights).points(inside.tolist())])
        assert shapely.distance(shapely.LineString(xy), shapely.points(right)).max() < 0.0101
        assert shapely.distance(shapely.LineString(right), shapely.points(xy)).max() < 0.02


@pytest.mark.parametrize("change, reason", [
    ({"knots": [0, 0, 0, 0, 1, 1, 1]}, "7 knots, expected 8 for 4 control points and degree 3"),
    ({"knots": [0, 0, 0, 0, 1, 1, 1, 0.5]}, "expected knots that ascend"),
    ({"weights": [1, 1, -1, 1]}, "expected 4 weights above 0, one for each control point"),
    ({"control_points": [(0, 0), (1, 1)]}, "2 control points, expected more than its degree, 3"),
    ({"control_points": []}, "neither control points nor fit points"),
    ({"control_points": [(0, 0), (1, 1), (2, math.nan), (3, 0)]}, "it has coordinates that are no numbers"),
])  # fmt: skip
def test_a_wrong_spline_is_named(tmp_path, change, reason):
    document = ezdxf.new(units=6)
    document.modelspace().add_lwpolyline([(0, 0), (9, 0), (9, 9)], close=True, dxfattribs={"layer": "DAM"})
    entity = document.modelspace().add_spline(dxfattribs={"layer": "JOINT"})
    entity.dxf.degree, entity.control_points, entity.knots = 3, [(0, 0), (1, 1), (2, 0), (3, 0)], [0, 0, 0, 0, 1, 1, 1, 1]
    for name, value in change.items():
        setattr(entity, name, value)
    document.saveas(tmp_path / "dam.dxf")
    assert fault(tmp_path, JOINT).endswith(f"dam.dxf: no drawing that can be read (SPLINE #{entity.dxf.handle} on layer JOINT: {reason})")
    assert section.load(declared(tmp_path, DAM))[1] == ["layers of the drawing that are not in the table: JOINT"]


def test_fit_points_alone(tmp_path):
    """A closed spline through 24 points of a circle of 3 m is that circle within a millimetre, as smooth at its seam as elsewhere; an open one passes through its points."""
    document = ezdxf.new(units=6)
    space = document.modelspace()
    space.add_lwpolyline([(-9, -9), (9, -9), (9, 9), (-9, 9)], close=True, dxfattribs={"layer": "DAM"})
    ring = space.add_spline([(3 * math.cos(a), 3 * math.sin(a)) for a in np.arange(24) * math.pi / 12], dxfattribs={"layer": "GALLERY"})
    ring.closed = True
    places = [(0, 0, 0), (2, 1, 0), (5, 1.5, 0), (9, 0, 0)]
    found = curves.points_of(space.add_spline(places), 1e-3)
    assert shapely.distance(shapely.LineString(found[:, :2]), shapely.points([p[:2] for p in places])).max() < 1e-3
    document.saveas(tmp_path / "dam.dxf")
    assert bodies_of(tmp_path, HOLE, more=", chord: 0.0005")[0] == pytest.approx([324 - 9 * math.pi], abs=0.01)


# ---- arcs, blocks ----------------------------------------------------------------------------------------

def shapes_of(space, xyz=None, **attributes):
    """A ring of an arc, bulges and half an ellipse about (5, 3), 2 m wide: half a disk on a rectangle, half an ellipse below. Area pi / 2 + 2 + pi / 4."""
    space.add_arc((5, 4), 1, 0, 180, dxfattribs=attributes)
    space.add_line((6, 4), (6, 3), dxfattribs=attributes)
    space.add_line((4, 4), (4, 3), dxfattribs=attributes)
    space.add_ellipse((5, 3), (1, 0), 0.5, math.pi, 2 * math.pi, dxfattribs=attributes)


def square(space):
    space.add_lwpolyline([(0, 0), (10, 0), (10, 10), (0, 10)], close=True, dxfattribs={"layer": "DAM"})


@pytest.mark.parametrize("insert, right", [
    ({}, 100 - math.pi / 2 - 2 - math.pi / 4),
    ({"xscale": -1, "insert": (10, 0)}, 100 - math.pi / 2 - 2 - math.pi / 4),
    ({"yscale": -1, "insert": (0, 8)}, 100 - math.pi / 2 - 2 - math.pi / 4),
    ({"extrusion": (0, 0, -1), "insert": (-10, 0)}, 100 - math.pi / 2 - 2 - math.pi / 4),
    ({"rotation": 90, "insert": (9, 0)}, 100 - math.pi / 2 - 2 - math.pi / 4),
    ({"xscale": 1.5, "yscale": 0.5, "insert": (-2.5, 3)}, 100 - 0.75 * (math.pi / 2 + 2 + math.pi / 4)),
    ({"xscale": 1.5, "yscale": 0.5, "rotation": 30, "zscale": 0, "insert": (0, 0)}, 100 - 0.75 * (math.pi / 2 + 2 + math.pi / 4)),
])  # fmt: skip
def test_mirrored_turned_and_stretched_blocks(tmp_path, insert, right):
    document = ezdxf.new(units=6)
    shapes_of(document.blocks.new("SHAPE"), layer="0")
    inner = document.blocks.new("INNER")
    inner.add_blockref("SHAPE", (0, 0), dxfattribs={"layer": "GALLERY"})  # its layer, not that of the block around it, counts
    square(document.modelspace())
    document.modelspace().add_blockref("INNER", insert.pop("insert", (0, 0)), dxfattribs=insert | {"layer": "OTHER"})
    document.saveas(tmp_path / "dam.dxf")
    assert bodies_of(tmp_path, HOLE, more=", chord: 0.001")[0] == pytest.approx([right], abs=0.02)


@pytest.mark.parametrize("turned", [1, -1])
def test_a_large_arc_stays_within_the_chord(tmp_path, turned):
    """A face of radius 1000 m, by a bulge and by an ARC, also with its extrusion down: 30 m of it rise by 0.1125 m."""
    document, radius, half = ezdxf.new(units=6), 1000.0, 15.0
    angle = math.asin(half / radius)
    rise = radius * (1 - math.cos(angle))
    space = document.modelspace()
    rows = [(turned * -half, 0, 0), (turned * half, 0, 0), (turned * half, 10, math.tan(angle / 2) * turned), (turned * -half, 10, 0)]
    space.add_lwpolyline(rows, format="xyb", close=True, dxfattribs={"layer": "DAM"})
    space.add_arc((0, 10 - radius * math.cos(angle) + 20), radius, 90 - math.degrees(angle), 90 + math.degrees(angle), dxfattribs={"layer": "ARC", "extrusion": (0, 0, turned)})
    for a, b in (((-half, 30), (-half, 20)), ((-half, 20), (half, 20)), ((half, 20), (half, 30))):
        space.add_line(a, b, dxfattribs={"layer": "ARC"})
    document.saveas(tmp_path / "dam.dxf")
    right = 300 + radius**2 * (angle - math.sin(2 * angle) / 2)
    made, _ = section.load(declared(tmp_path, {"DAM": "group: dam", "ARC": "group: arc"}, more=", chord: 0.001, gap: 0.0001"))
    assert [region.shape.area for region in made.regions] == pytest.approx([right, right], abs=0.02)
    assert [region.shape.bounds[3] for region in made.regions] == pytest.approx([10 + rise, 30 + rise], abs=0.001)


def test_a_fitted_polyline(tmp_path):
    """Curve-fit: all its vertices, also those that the fit has made, are on arcs of circles. A half disk."""
    document = ezdxf.new("R12", units=6)
    quarter = math.tan(math.pi / 8)
    curve = document.modelspace().add_polyline2d([(8, 0, quarter), (5, 3, quarter), (2, 0, 0)], format="xyb", close=True, dxfattribs={"layer": "DAM"})
    curve.dxf.flags |= 2
    curve.vertices[1].dxf.flags = 1
    document.saveas(tmp_path / "dam.dxf")
    assert bodies_of(tmp_path, DAM, more=", chord: 0.0005", size=1)[0] == pytest.approx([4.5 * math.pi], abs=0.01)


def test_what_is_passed_over_is_named(tmp_path):
    """Hatches, faces, files of others, clipped blocks; widths and heights that a plane section does not have."""
    document = ezdxf.new(units=6)
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (10, 0), (10, 10), (0, 10)], close=True, dxfattribs={"layer": "DAM", "const_width": 0.1})
    space.add_hatch(dxfattribs={"layer": "DAM"}).paths.add_polyline_path([(0, 0), (1, 0), (1, 1)])
    space.add_3dface([(0, 0), (1, 0), (1, 1)], dxfattribs={"layer": "DAM"})
    space.add_line((2, 2), (2, 2), dxfattribs={"layer": "DAM"})
    space.add_point((5, 5), dxfattribs={"layer": "DAM"})
    space.add_point((6, 5), dxfattribs={"layer": "dam"})
    space.add_line((-1, 5, 0), (11, 5, 3), dxfattribs={"layer": "JOINT"})
    document.add_xref_def("rock.dxf", "ROCK")
    document.blocks.new("SEAM").add_line((-1, 8), (11, 8))
    XClip(space.add_blockref("SEAM", (0, 0), dxfattribs={"layer": "JOINT"})).set_block_clipping_path([(0, 0), (5, 9)])
    space.add_blockref("ROCK", (0, 0), dxfattribs={"layer": "JOINT"})
    document.saveas(tmp_path / "dam.dxf")
    found, notes = bodies_of(tmp_path, JOINT)
    assert found == pytest.approx([50, 30, 20])
    assert notes == [
        "layer JOINT: its curves are not level (z varies by up to 3 m); x and y are read",
        "layer DAM: 1 polylines have a width; their centre lines are read",
        "block SEAM is clipped in the drawing (XCLIP); it is read whole",
        "layer DAM: 1 3DFACE not read",
        "layer DAM: 1 HATCH not read",
        "layer DAM: 1 LINE without length not read",
        "layer JOINT: 1 INSERT of ROCK, which is another file (XREF), not read",
        "layer DAM: 2 POINT not read",
    ]
    assert "layers.DAM: expected lines on this layer, there are only 1 HATCH and 1 POINT" in fault(tmp_path, {"DAM": "group: dam"}, hatched(tmp_path))


def hatched(folder):
    document = ezdxf.new(units=6)
    document.modelspace().add_hatch(dxfattribs={"layer": "DAM"}).paths.add_polyline_path([(0, 0), (9, 0), (9, 9)])
    document.modelspace().add_point((1, 1), dxfattribs={"layer": "DAM"})
    document.saveas(folder / "hatch.dxf")
    return "hatch.dxf"


@pytest.mark.parametrize("code, metre", [(14, 0.1), (7, 1000), (10, 0.9144), (21, 1200 / 3937)])
def test_more_units(tmp_path, code, metre):
    document = ezdxf.new(units=code)
    document.modelspace().add_lwpolyline([(0, 0), (9 / metre, 0), (9 / metre, 9 / metre)], close=True, dxfattribs={"layer": "DAM"})
    document.saveas(tmp_path / "dam.dxf")
    (tmp_path / "dam.yaml").write_text("drawing: {file: dam.dxf}\nsize: 2\nlayers: {DAM: {group: dam}}\n")
    assert section.load(tmp_path / "dam.yaml")[0].regions[0].shape.area == pytest.approx(40.5)


def test_units_that_no_section_has(tmp_path):
    document = ezdxf.new(units=13)
    square(document.modelspace())
    document.saveas(tmp_path / "dam.dxf")
    (tmp_path / "dam.yaml").write_text("drawing: {file: dam.dxf}\nsize: 2\nlayers: {DAM: {group: dam}}\n")
    with pytest.raises(section.DeclaredError, match="the drawing says that its units are microns, expected units: mm or cm or dm or m"):
        section.load(tmp_path / "dam.yaml")


# ---- drawings that would never end -----------------------------------------------------------------------

def doubling(document):
    """40 blocks, each twice in the next one: 10^12 squares."""
    square(document.blocks.new("B0"))
    for k in range(40):
        block = document.blocks.new(f"B{k + 1}")
        block.add_blockref(f"B{k}", (0, 0))
        block.add_blockref(f"B{k}", (0, 0))
    document.modelspace().add_blockref("B40", (0, 0), dxfattribs={"layer": "DAM"})


def grid(document):
    square(document.blocks.new("B"))
    document.modelspace().add_blockref("B", (0, 0), dxfattribs={"layer": "DAM", "row_count": 30000, "column_count": 30000, "row_spacing": 20, "column_spacing": 20})


def deep(document):
    square(document.blocks.new("B0"))
    for k in range(300):
        document.blocks.new(f"B{k + 1}").add_blockref(f"B{k}", (0, 0))
    document.modelspace().add_blockref("B300", (0, 0), dxfattribs={"layer": "DAM"})


def fine(document):
    document.modelspace().add_circle((0, 0), 1e9, dxfattribs={"layer": "DAM"})


@pytest.mark.parametrize("bomb, reason", [
    (doubling, "it has 3.3e+12 entities once its blocks are taken apart, expected at most 500000"),
    (grid, "it has 9e+08 entities once its blocks are taken apart, expected at most 500000"),
    (deep, "its blocks are nested more than 100 deep"),
    (fine, "it would have 7e+06 points within 0.0001 of the curve, expected at most 200000: a larger chord"),
])  # fmt: skip
def test_bombs(tmp_path, bomb, reason):
    document = ezdxf.new(units=6)
    bomb(document)
    document.saveas(tmp_path / "dam.dxf")
    assert reason in fault(tmp_path, DAM, more=", chord: 0.0001")


def test_a_grid_without_distance_is_one(tmp_path):
    """30000 rows and columns at one place: the block is there once."""
    document = ezdxf.new(units=6)
    square(document.blocks.new("B"))
    document.modelspace().add_blockref("B", (0, 0), dxfattribs={"layer": "DAM", "row_count": 30000, "column_count": 30000})
    document.saveas(tmp_path / "dam.dxf")
    assert bodies_of(tmp_path, DAM) == ([pytest.approx(100)], [])


def test_no_file_of_its_kind(tmp_path):
    """Devices, pipes, zeros, huge files."""
    os.mkfifo(tmp_path / "pipe.dxf")
    with open(tmp_path / "huge.dxf", "wb") as file:
        file.truncate(10**12)
    (tmp_path / "zero.dxf").write_bytes(bytes(1000))
    assert "(it is no regular file)" in fault(tmp_path, DAM, "/dev/zero")
    assert "(it is no regular file)" in fault(tmp_path, DAM, "pipe.dxf")
    assert "(it has 1000000 MB, expected at most 200 MB" in fault(tmp_path, DAM, "huge.dxf")
    assert "(it is no DXF file)" in fault(tmp_path, DAM, "zero.dxf")
