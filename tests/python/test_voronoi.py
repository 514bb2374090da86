"""Voronoi dams: areas, matching faces, shapes, names and reproducibility for several seeds and sections."""

import os
import sys
from dataclasses import replace

import numpy as np
import pytest
import shapely

HERE = os.path.dirname(__file__)
sys.path.insert(0, os.path.join(HERE, "..", "..", "tools"))

from quoin_tools.mesh import polygons, voronoi
from quoin_tools.mesh.blockmesh import all_faces, areas, check, face_ends, outer_faces, quality, read
from quoin_tools.mesh.dam import G1
from quoin_tools.mesh.voronoi import Options, voronoi_mesh

TRIANGLE = [(0, 0), (80, 0), (0, 100)]
WALL = [(0, 0), (12, 0), (12, 9), (0, 9)]
FLARED = [(-3, 1), (30, 0), (31, 6), (12, 20), (10, 32), (4, 32), (5, 15)]  # corners in and out on both faces
CASES = [(None, Options(seed=seed)) for seed in (1, 2, 3, 7, 123)] + [
    (None, Options(facing=(0.0, 0.0), lloyd=0)), (None, Options(side=1.0, course=0.6, seed=4)),
    (None, Options(facing=(0.0, 1.2), lloyd=4)), (TRIANGLE, Options(side=6.0, facing=(2.0, 2.0), course=4.0)),
    (None, Options(seed=3, square=True)), (FLARED, Options(seed=5, square=True)),
    (WALL, Options(side=1.0, facing=(0.5, 0.8), course=0.5)), (FLARED, Options(seed=5)), (FLARED, Options(seed=6, lloyd=0)),
    ([(0, 0), (20, 0), (5, 25), (5, 30), (0, 30)], Options(side=1.5, facing=(0.0, 1.0)))]


@pytest.fixture(scope="module", params=range(len(CASES)))
def model(request):
    section, options = CASES[request.param]
    section = np.array(G1.corners() if section is None else section, dtype=float)
    tess, facing = voronoi.tessellate(voronoi.checked_section(section, options), options)
    return section, options, tess, facing, voronoi_mesh(section, options)


def lengths(mesh, faces):
    return np.hypot(*np.diff(mesh.vertices[face_ends(mesh, faces)], axis=1)[:, 0].T)


def test_areas(model):
    """Of the polygons, of the blocks, and polygon by polygon of their blocks."""
    section, _, tess, _, mesh = model
    whole = polygons.area(section)
    of_polygons = np.array([polygons.area(xy) for xy in tess.polygons()])
    assert of_polygons.sum() == pytest.approx(whole, rel=1e-12)
    assert areas(mesh).sum() == pytest.approx(whole, rel=1e-12)
    assert np.bincount(check(mesh), areas(mesh)) == pytest.approx(of_polygons, rel=1e-12)


def test_one_macroblock_per_polygon(model):
    _, _, tess, facing, mesh = model
    component = check(mesh)
    assert component.max() + 1 == len(tess.rings)
    group = [set(mesh.block_group[component == i]) for i in range(len(tess.rings))]
    assert group == [{int(face)} for face in facing]
    quads = np.bincount(component)[facing]
    assert (quads == 1).all() and (mesh.blocks[mesh.block_group == 1, 3] >= 0).all()


def test_every_inner_edge_is_matched_twice(model):
    """As two faces in opposite directions on the same two places, of two macroblocks, both in the set."""
    _, _, tess, _, mesh = model
    ends = mesh.vertices[face_ends(mesh, mesh.face_sets["joint"])].round(9).reshape(-1, 4) + 0.0
    there, back = ({tuple(row) for row in rows.tolist()} for rows in (ends, ends[:, [2, 3, 0, 1]]))
    edges = polygons.inner_edges(tess.rings)
    assert len(ends) == len(there) == 2 * len(edges) and there == back
    component = check(mesh)[mesh.face_sets["joint"][:, 0]]
    owner = {tuple(row): part for row, part in zip(ends.tolist(), component)}
    assert all(owner[row] != owner[row[2:] + row[:2]] for row in owner)


def test_sets_are_the_whole_boundary_once(model):
    section, _, _, _, mesh = model
    listed = sorted(tuple(row) for rows in mesh.face_sets.values() for row in rows)
    assert listed == sorted(map(tuple, outer_faces(mesh)))
    around = np.hypot(*(np.roll(section, -1, axis=0) - section).T)
    found = dict.fromkeys(voronoi.FACES, 0.0)
    for name, length in zip(voronoi.face_names(section), around):
        found[name] += length
    for name, length in found.items():
        rows = mesh.face_sets.get(name, np.empty((0, 2), int))
        assert lengths(mesh, rows).sum() == pytest.approx(length, rel=1e-12), name


def test_shapes(model):
    """No short sides, no sharp corners, no slivers; the mean side is the one asked for."""
    _, options, tess, facing, mesh = model
    inside = [xy for xy, face in zip(tess.polygons(), facing) if not face]
    shortest = min(np.hypot(*(np.roll(xy, -1, axis=0) - xy).T).min() for xy in inside)
    assert shortest > min(options.least(), 0.7 * options.course) - 1e-9
    corner = min(polygons.corner_angles(xy).min() for xy in inside)
    assert corner > 30.0  # the toe of the triangle has 39 degrees after its facing
    angle, aspect, _ = quality(mesh)
    assert angle > 12.0 and aspect < 12.0
    _, ends = all_faces(mesh)
    assert np.hypot(*(mesh.vertices[ends[:, 0]] - mesh.vertices[ends[:, 1]]).T).min() > 0.1 * options.side
    inner = polygons.Tessellation(tess.nodes, [ring for ring, face in zip(tess.rings, facing) if not face], tess.rank)
    assert voronoi.mean_side(inner) == pytest.approx(options.side, rel=0.1)


def test_points(model):
    section, _, _, _, mesh = model
    at = {name: mesh.vertices[vertex].tolist() for name, vertex in mesh.points.items()}
    assert (at["heel"], at["toe"]) == (section[0].tolist(), section[1].tolist())
    top = section[section[:, 1] == section[:, 1].max()]
    assert at["crest_upstream"] == top[np.argmin(top[:, 0])].tolist()
    assert at["crest_downstream"] == top[np.argmax(top[:, 0])].tolist()


def test_same_seed_same_bytes(tmp_path):
    files = [tmp_path / name for name in ("a.h5", "b.h5", "c.h5")]
    for file, seed in zip(files, ("3", "3", "4")):
        assert voronoi.main(["-o", str(file), "--seed", seed, "--side", "3"]) == 0
    a, b, c = (file.read_bytes() for file in files)
    assert a == b and a != c
    assert check(read(str(files[0]))).max() > 20


def test_continuum_and_refinement():
    """The same blocks in one macroblock; refined, each block has one quadrilateral per corner."""
    jointed, welded = voronoi_mesh(), voronoi_mesh(options=Options(joints=False))
    assert check(welded).max() == 0 and "joint" not in welded.face_sets
    assert np.array_equal(areas(jointed), areas(welded))
    fine = voronoi_mesh(options=Options(refine=1))
    corners = np.where(jointed.blocks[:, 3] < 0, 3, 4)
    assert len(fine.blocks) == corners.sum() and (fine.blocks[:, 3] >= 0).all()
    assert check(fine).max() == check(jointed).max()
    assert len(fine.face_sets["joint"]) == 2 * len(jointed.face_sets["joint"])
    assert areas(fine).sum() == pytest.approx(areas(jointed).sum(), rel=1e-12)


@pytest.mark.parametrize("section, options", [
    (None, Options(side=3.0, course=1.5, square=True, coping=1.0)), (None, Options(side=3.0, seed=2, coping=4.85)), (None, Options(side=3.0, facing=(0.0, 0.0), coping=2.0)),
    (WALL, Options(side=1.0, facing=(0.5, 0.8), course=0.5, coping=0.6)), (TRIANGLE, Options(side=6.0, facing=(2.0, 2.0), course=4.0, coping=30.0))])
def test_coping(section, options):
    """One stone over the whole crest on a level bed; stones that do not come near it are those of the same seed without it."""
    mesh, bare = (voronoi_mesh(section, o) for o in (options, replace(options, coping=0.0)))
    outline = np.array(G1.corners() if section is None else section, dtype=float)
    component, level = check(mesh), outline[:, 1].max() - options.coping
    above = mesh.centres()[:, 1] > level
    assert len(set(component[above])) == 1 and not set(component[above]) & set(component[~above])
    assert areas(mesh)[above].sum() == pytest.approx(shapely.Polygon(outline).intersection(shapely.box(-99, level, 99, 999)).area, rel=1e-9)
    assert areas(mesh).sum() == pytest.approx(polygons.area(outline), rel=1e-12) and (mesh.block_group[above] == 0).all()
    ends = mesh.vertices[face_ends(mesh, mesh.face_sets["joint"])].round(9).reshape(-1, 4) + 0.0
    there, back = ({tuple(row) for row in rows.tolist()} for rows in (ends, ends[:, [2, 3, 0, 1]]))
    assert there == back and quality(mesh)[0] > 5.0
    stones = [{tuple(shapely.bounds(shapely.MultiPoint(m.vertices[np.unique(m.blocks[part == i][m.blocks[part == i] >= 0])])).round(6)) for i in range(part.max() + 1)}
              for m, part in ((mesh, component), (bare, check(bare)))]  # fmt: skip
    below = [{stone for stone in found if stone[3] < level - 3 * options.side} for found in stones]
    assert below[0] == below[1] and len(below[0]) > 10


def test_bonded():
    """The same blocks; what has its centre in the uppermost metres is one body, and only the joints between those stones are gone."""
    bare, mesh = (voronoi_mesh(options=Options(side=3.0, bonded=height)) for height in (0.0, 4.85))
    assert np.array_equal(bare.centres(), mesh.centres()) and np.array_equal(bare.block_group, mesh.block_group)
    old, new, size = check(bare), check(mesh), areas(bare)
    centre = np.bincount(old, size * bare.centres()[:, 1]) / np.bincount(old, size)
    upper = centre[old] > 33 - 4.85
    assert len(set(new[upper])) == 1 and new.max() == old.max() - len(set(old[upper])) + 1
    joints = [{tuple(row) for row in m.vertices[face_ends(m, m.face_sets["joint"])].round(9).reshape(-1, 4).tolist()} for m in (bare, mesh)]
    assert joints[1] < joints[0] and len({tuple(sorted((row[:2], row[2:]))) for row in joints[0] - joints[1]}) * 2 == len(joints[0] - joints[1])


@pytest.mark.parametrize("section, options", [
    (WALL, Options(side=0.3)), (None, Options(side=0.45, seed=2))])
def test_small_polygons_behind_large_stones(section, options):
    """Several polygons along one stone of the facing: the stone keeps its size and is cut in blocks, faces still match."""
    mesh = voronoi_mesh(section, options)
    component = check(mesh)
    whole = polygons.area(G1.corners() if section is None else section)
    assert areas(mesh).sum() == pytest.approx(whole, rel=1e-12)
    facing = np.unique(component[mesh.block_group == 1])
    assert (np.bincount(component)[facing] > 1).any()
    large = np.bincount(component, areas(mesh))[facing]
    assert large.min() > 0.5 and large.mean() == pytest.approx(1.0, rel=0.1)
    ends = mesh.vertices[face_ends(mesh, mesh.face_sets["joint"])].round(9).reshape(-1, 4) + 0.0
    there, back = ({tuple(row) for row in rows.tolist()} for rows in (ends, ends[:, [2, 3, 0, 1]]))
    assert there == back and quality(mesh)[0] > 5.0


def test_work_of_a_polygon_does_not_grow(monkeypatch):
    """With four times the polygons, four times the areas are asked for: thousands of stones are made in seconds."""
    asked, area = [], polygons.area
    monkeypatch.setattr(polygons, "area", lambda xy: asked.append(1) or area(xy))
    each = []
    for side in (1.0, 0.5):
        asked.clear()
        tess, _ = voronoi.tessellate(np.array(WALL, dtype=float), Options(side=side, facing=(0.0, 0.0)))
        each.append(len(asked) / len(tess.rings))
    assert each[1] < 1.5 * each[0], each


def test_told_and_refused_before_the_work(tmp_path, capsys, monkeypatch):
    """A line for each part of the work; a file that cannot be written is refused at once."""
    assert voronoi.main(["-o", str(tmp_path / "a.h5"), "--side", "4"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [" s  tessellation" in line for line in lines] == [True, True, True, False, False]
    assert "polygons to be cut in blocks" in lines[3]
    monkeypatch.setattr(voronoi, "voronoi_mesh", None)
    assert voronoi.main(["-o", str(tmp_path)]) == 2
    assert "cannot be written" in capsys.readouterr().err


def test_rock_matches_the_base():
    mesh = voronoi_mesh(options=Options(rock=2.0))
    check(mesh)
    ends = mesh.vertices[face_ends(mesh, mesh.face_sets["base"])].round(6).reshape(-1, 4)
    assert {tuple(row) for row in ends.tolist()} == {tuple(row) for row in ends[:, [2, 3, 0, 1]].tolist()}
    rock = mesh.block_group == mesh.group_names.index("rock")
    assert areas(mesh)[rock].sum() == pytest.approx(154.8 * 66 + 2.28 * (66 + 22.8 / 2), rel=1e-9)
    assert areas(mesh)[~rock].sum() == pytest.approx(polygons.area(G1.corners()), rel=1e-12)
    listed = [tuple(row) for rows in mesh.face_sets.values() for row in rows]
    assert sorted(listed) == sorted(map(tuple, outer_faces(mesh)))


@pytest.mark.parametrize("arguments, message", [
    (["--section", "0,0", "0,30", "20,0"], "counter-clockwise"), (["--section", "0,0", "5,0"], "three corners"),
    (["--section", "0,0", "9,0", "0,9", "9,9"], "cross"), (["--side", "-1"], "positive"),
    (["--facing", "3", "3"], "too thick"), (["--shortest", "1.5"], "half"),
    (["--section", "0,9", "9,9", "4,0"], "counter-clockwise"), (["--lloyd", "-1"], "negative"), (["--coping", "31"], "coping: 31: expected less than the 30.72 m"),
    (["--section", "0,0", "20,0", "20,10", "12,10", "12,6", "8,6", "8,10", "0,10", "--facing", "0", "0", "--coping", "2"], "no single bed"), (["--side", "0.005"], "at most 1e+06")])
def test_refused(arguments, message, tmp_path, capsys):
    assert voronoi.main(["-o", str(tmp_path / "model.h5"), *arguments]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "model.h5").exists()


@pytest.mark.parametrize("option", ["--side", "--bonded"])
def test_what_is_no_number_is_refused(option, tmp_path, capsys):
    with pytest.raises(SystemExit, match="2"):
        voronoi.main(["-o", str(tmp_path / "model.h5"), option, "nan"])
    assert f"argument {option}: 'nan': expected a number, alone [m] or with a unit" in capsys.readouterr().err


# ---- polygons --------------------------------------------------------------------------------------------

def test_cut():
    """Convex pieces that fill the polygon, of a square, a hexagon, a polygon with straight corners, an L."""
    hexagon = [(np.cos(a), np.sin(a)) for a in np.arange(6) * np.pi / 3]
    straight = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    ell = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    for xy, most in (([(0, 0), (1, 0), (1, 1), (0, 1)], 1), (hexagon, 2), (straight, 4), (ell, 4)):
        pieces, centre = polygons.cut(np.array(xy, dtype=float))
        nodes = np.array(xy if centre is None else [*xy, centre], dtype=float)
        assert len(pieces) <= most
        assert sum(polygons.area(nodes[list(piece)]) for piece in pieces) == pytest.approx(polygons.area(xy))
        assert min(polygons.corner_quality(nodes, piece) for piece in pieces) > 20


def test_tidy_merges_and_absorbs():
    """A short edge goes, a sliver goes to its neighbour, and the outline stays."""
    left = np.array([(0, 0), (1, 0), (1, 0.99), (0.98, 1), (1, 2), (0, 2)])
    sliver = np.array([(1, 0), (1.02, 0), (1.02, 0.9), (1, 0.99)])
    right = np.array([(1.02, 0), (2, 0), (2, 2), (1, 2), (0.98, 1), (1, 0.99), (1.02, 0.9)])
    tess = polygons.tessellation([left, sliver, right], [(0, 0), (2, 0), (2, 2), (0, 2)])
    polygons.tidy(tess, 0.3, 0.01)
    assert len(tess.rings) == 2
    assert sum(polygons.area(xy) for xy in tess.polygons()) == pytest.approx(4.0, rel=1e-14)
    edges = polygons.directed_edges(tess.rings)
    assert min(np.hypot(*(tess.nodes[a] - tess.nodes[b])) for a, b in edges) >= 0.3
