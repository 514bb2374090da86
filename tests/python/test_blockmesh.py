"""The block mesh file: round trip, every refusal of docs/mesh_format.md with its message, command line."""

import os
import sys

import h5py
import numpy as np
import pytest

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "..", "tools"))

from quoin_tools.mesh import blockmesh, stacks
from quoin_tools.mesh.blockmesh import BlockMesh, MeshError, check, macroblocks, outer_faces, read, write
from quoin_tools.mesh.meshing import join, rectangle, renamed


@pytest.fixture
def mesh():
    """A triangle and two squares as one body, a rigid square on top of it."""
    vertices = [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1), (3, 0), (0, 1), (1, 1), (1, 2), (0, 2)]
    blocks = [(0, 1, 4, 3), (1, 2, 5, 4), (2, 6, 5, -1), (7, 8, 9, 10)]
    return BlockMesh(vertices, blocks, [0, 0, 0, 1], ["body", "cap"], [0, 1],
                     {"joint": [(0, 2), (3, 0)], "slope": [(2, 1)]}, {"tip": 6})


def refused(mesh, message, **options):
    with pytest.raises(MeshError) as caught:
        check(mesh, **options)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_round_trip(mesh, tmp_path):
    path = tmp_path / "model.h5"
    write(path, mesh)
    back = read(path)
    for name in ("vertices", "blocks", "block_group", "group_rigid"):
        assert np.array_equal(getattr(back, name), getattr(mesh, name)), name
        assert getattr(back, name).dtype == getattr(mesh, name).dtype, name
    assert back.group_names == ["body", "cap"]
    assert {name: rows.tolist() for name, rows in back.face_sets.items()} == {
        "joint": [[0, 2], [3, 0]], "slope": [[2, 1]]}
    assert back.points == {"tip": 6}
    assert os.listdir(tmp_path) == ["model.h5"]


def test_types_in_the_file_are_those_of_the_contract(mesh, tmp_path):
    write(tmp_path / "model.h5", mesh)
    with h5py.File(tmp_path / "model.h5") as file:
        assert file.attrs["format"] == b"quoin-mesh" and isinstance(file.attrs["format"], np.bytes_)
        assert file.attrs["version"] == 1
        types = {name: (file[name].dtype.str, file[name].shape) for name in (
            "vertices", "blocks", "block_group", "groups/name", "groups/rigid", "face_sets/joint",
            "points/tip")}
    assert types == {"vertices": ("<f8", (11, 2)), "blocks": ("<i4", (4, 4)), "block_group": ("<i4", (4,)),
                     "groups/name": ("|S64", (2,)), "groups/rigid": ("<i4", (2,)),
                     "face_sets/joint": ("<i4", (2, 2)), "points/tip": ("<i4", (1,))}


def test_topology(mesh):
    assert macroblocks(mesh).tolist() == [0, 0, 0, 1]
    assert check(mesh).tolist() == [0, 0, 0, 1]
    assert outer_faces(mesh).tolist() == [[0, 0], [0, 2], [0, 3], [1, 0], [1, 2], [2, 0], [2, 1],
                                          [3, 0], [3, 1], [3, 2], [3, 3]]
    assert blockmesh.areas(mesh) == pytest.approx([1, 1, 0.5, 1])
    assert mesh.centres()[2] == pytest.approx([7 / 3, 1 / 3])


def test_blocks_that_share_one_vertex_are_one_macroblock():
    vertices = [(0, 0), (1, 0), (1, 1), (0, 1), (2, 1), (2, 2), (1, 2)]
    corner = BlockMesh(vertices, [(0, 1, 2, 3), (2, 4, 5, 6)], [0, 0], ["body"], [0])
    assert check(corner).tolist() == [0, 0]


def change_blocks(mesh, row, values):
    mesh.blocks[row] = values


def raise_vertex(mesh, row, xy):
    mesh.vertices[row] = xy


CONTENT = {
    "nan": (lambda m: raise_vertex(m, 4, (np.nan, 1)), "vertex 4: coordinates (nan, 1) are not finite"),
    "infinite": (lambda m: raise_vertex(m, 4, (1, np.inf)), "vertex 4: coordinates (1, inf) are not finite"),
    "index too large": (lambda m: change_blocks(m, 1, (1, 2, 11, 4)), "block 1: vertices [1, 2, 11, 4]"),
    "negative index": (lambda m: change_blocks(m, 1, (1, -1, 5, 4)), "block 1: vertices [1, -1, 5, 4]"),
    "fourth index": (lambda m: change_blocks(m, 2, (2, 6, 5, -2)), "block 2: vertices [2, 6, 5, -2]"),
    "repeated": (lambda m: change_blocks(m, 1, (1, 2, 5, 1)),
                 "block 1: a vertex is repeated in [1, 2, 5, 1]"),
    "unused vertex": (lambda m: change_blocks(m, 2, (2, 4, 5, -1)), "vertex 6 at (3, 0): no block uses it"),
    "inverted": (lambda m: change_blocks(m, 0, (0, 3, 4, 1)),
                 "block 0 at (0, 0): inverted, its vertices run clockwise (area -1 m2)"),
    "inverted triangle": (lambda m: change_blocks(m, 2, (2, 5, 6, -1)), "block 2 at (2, 0): inverted"),
    "no area": (lambda m: raise_vertex(m, 6, (2, 0.5)), "block 2 at (2, 0): its area is zero"),
    "huge": (lambda m: raise_vertex(m, 9, (1e300, 1e300)), "block 3 at (0, 1): its area is zero"),
    "bow tie": (lambda m: change_blocks(m, 3, (7, 9, 8, 10)), "block 3 at (0, 1): its area is zero"),
    "not convex": (lambda m: raise_vertex(m, 9, (0.3, 1.3)),
                   "block 3: not convex at its vertex 9 (0.3, 1.3)"),
    "same side": (lambda m: change_blocks(m, 2, (1, 2, 6, -1)) or raise_vertex(m, 6, (2, 0.5)),
                  "block 2: lies on the same side of the face 1-2 as block 1"),
    "group row": (lambda m: m.block_group.__setitem__(3, 2),
                  "block 3: group row 2 does not exist, expected 0..1"),
    "rigid flag": (lambda m: m.group_rigid.__setitem__(1, 2), "group 'cap': rigid is 2, expected 0 or 1"),
    "set block": (lambda m: m.face_sets["slope"].__setitem__(0, (4, 0)),
                  "face set 'slope', row 0: block 4 does not exist, expected 0..3"),
    "set face": (lambda m: m.face_sets["slope"].__setitem__(0, (2, 3)),
                 "face set 'slope', row 0: block 2 has no face 3, expected 0..2"),
    "set twice": (lambda m: m.face_sets["joint"].__setitem__(1, (0, 2)),
                  "face set 'joint': face 2 of block 0 is listed twice"),
    "set inside": (lambda m: m.face_sets["slope"].__setitem__(0, (2, 2)),
                   "face set 'slope', row 0: face 2 of block 2 is inside its macroblock"),
    "point": (lambda m: m.points.__setitem__("tip", 11),
              "point 'tip': vertex 11 does not exist, expected 0..10"),
    "point name": (lambda m: m.points.__setitem__("2nd", 1), "point '2nd': a name is a letter"),
    "set name": (lambda m: m.face_sets.__setitem__("a/b", m.face_sets["joint"]), "face set 'a/b': a name is"),
    "long name": (lambda m: m.group_names.__setitem__(0, "a" * 64), "at most 63 characters"),
    "group twice": (lambda m: m.group_names.__setitem__(1, "body"),
                    "group 1: the name 'body' is taken by group 0"),
}


@pytest.mark.parametrize("case", CONTENT)
def test_content_is_refused(mesh, case):
    spoil, message = CONTENT[case]
    spoil(mesh)
    refused(mesh, message)


def test_no_blocks_is_refused():
    refused(BlockMesh(np.zeros((0, 2)), np.zeros((0, 4)), [], ["a"], [0]), "the mesh has no blocks")


@pytest.mark.parametrize("depth, tolerance, passes", [
    (0.0, 0.005, True), (0.004, 0.005, True), (0.006, 0.005, False), (0.004, 0.003, False),
    (0.5, 0.005, False)])
def test_overlap_of_macroblocks(mesh, depth, tolerance, passes):
    mesh.vertices[7:, 1] -= depth
    if passes:
        check(mesh, tolerance)
    else:
        refused(mesh, f"block 0 and block 3: their macroblocks overlap by {depth:.4g} m", tolerance=tolerance)


def test_small_body_inside_a_large_one_is_refused():
    large, small = rectangle(0, 0, 10, 10, 5, 5), rectangle(4.5, 4.5, 1, 1)
    refused(join([renamed(large), renamed(small)]), "block 12 and block 25: their macroblocks overlap by 1 m")


def test_neighbours_of_oblique_joints_do_not_overlap():
    assert check(stacks.block_on_plane(slope_degrees=33.0)).tolist() == [0, 1]


@pytest.fixture
def path(mesh, tmp_path):
    write(tmp_path / "model.h5", mesh)
    return tmp_path / "model.h5"


def replaced(name, value):
    def spoil(file):
        del file[name]
        file[name] = value
    return spoil


FILES = {
    "format": (lambda f: f.attrs.__setitem__("format", np.bytes_(b"other")), "attribute format is"),
    "format text": (lambda f: f.attrs.__setitem__("format", "quoin-mesh"), "in fixed-length bytes"),
    "no version": (lambda f: f.attrs.__delitem__("version"),
                   "attribute version is None, expected the integer 1"),
    "version": (lambda f: f.attrs.__setitem__("version", 2), "expected the integer 1"),
    "no blocks": (lambda f: f.__delitem__("blocks"), "dataset /blocks is missing"),
    "no groups": (lambda f: f.__delitem__("groups"), "dataset /groups/name is missing"),
    "float32": (replaced("vertices", np.zeros((11, 2), "f4")),
                "/vertices is of type float32, expected float64"),
    "int64": (replaced("blocks", np.zeros((4, 4), "i8")), "/blocks is of type int64, expected int32"),
    "columns": (replaced("blocks", np.zeros((4, 3), "i4")), "/blocks has shape (4, 3), expected (n, 4)"),
    "group rows": (replaced("block_group", np.zeros(3, "i4")), "/block_group has 3 rows, /blocks has 4"),
    "rigid rows": (replaced("groups/rigid", np.zeros(3, "i4")),
                   "/groups/rigid has 3 rows, /groups/name has 2"),
    "set type": (replaced("face_sets/joint", np.zeros((2, 2))), "/face_sets/joint is of type float64"),
    "set shape": (replaced("face_sets/joint", np.zeros(2, "i4")), "/face_sets/joint has shape (2,)"),
    "point shape": (replaced("points/tip", np.zeros(2, "i4")), "/points/tip has shape (2,), expected (1,)"),
}


@pytest.mark.parametrize("case", FILES)
def test_file_is_refused(path, case):
    spoil, message = FILES[case]
    with h5py.File(path, "a") as file:
        spoil(file)
    with pytest.raises(MeshError) as caught:
        read(path)
    assert message in str(caught.value) and str(path) in str(caught.value)


@pytest.mark.parametrize("keep", [0.0, 0.1, 0.5, 0.99])
def test_file_cut_off_is_refused(path, keep):
    whole = path.read_bytes()
    path.write_bytes(whole[:int(keep * len(whole))])
    with pytest.raises(MeshError, match="not a whole HDF5 file"):
        read(path)


def test_missing_file_is_refused(tmp_path):
    with pytest.raises(MeshError, match="no such file"):
        read(tmp_path / "none.h5")


def test_unknown_objects_in_the_file_are_ignored(path):
    with h5py.File(path, "a") as file:
        file["notes/made_by"] = np.bytes_(b"a generator")
        del file["face_sets"], file["points"]
    assert read(path).face_sets == {} and read(path).points == {}


def test_writing_refuses_bad_names_and_leaves_the_old_file(mesh, path):
    before = path.read_bytes()
    mesh.face_sets["a/b"] = mesh.face_sets["joint"]
    with pytest.raises(MeshError, match="a name is a letter"):
        write(path, mesh)
    assert path.read_bytes() == before and os.listdir(path.parent) == ["model.h5"]


def test_command_line(mesh, path, capsys):
    assert blockmesh.main(["check", str(path)]) == 0
    text = capsys.readouterr().out
    for line in ("blocks       4 (3 quadrilaterals, 1 triangles)", "vertices     11", "macroblocks  2",
                 "group        body: 3 blocks, deformable, 2.5 m2", "group        cap: 1 blocks, rigid, 1 m2",
                 "face set     joint: 2 faces", "point        tip: vertex 6 at (3, 0) m",
                 "bounding box (0, 0) to (3, 2) m",
                 "smallest angle 45.0 degrees, longest side / shortest 1.41"):
        assert line in text, line
    mesh.vertices[7:, 1] -= 0.1
    write(path, mesh)
    assert blockmesh.main(["info", str(path)]) == 0
    capsys.readouterr()
    assert blockmesh.main(["check", str(path)]) == 2
    output = capsys.readouterr()
    assert output.out == "" and output.err.count("\n") == 1 and "overlap by 0.1 m" in output.err
    assert blockmesh.main(["check", "--tolerance", "0.2", str(path)]) == 0


@pytest.mark.parametrize("name, reason", [("vertices", "5000000 vertices are too many for 1 blocks: some vertex is in no block"), ("blocks", "/block_group has 1 rows, /blocks has 5000000")])
def test_counts_are_compared_before_anything_large_is_read(tmp_path, monkeypatch, name, reason):
    """Millions of rows of zeros take a few kilobytes of a file."""
    path = str(tmp_path / "m.h5")
    write(path, BlockMesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2, 3]], [0], ["body"], [0]))
    with h5py.File(path, "a") as file:
        kind, columns = file[name].dtype, file[name].shape[1]
        del file[name]
        file.create_dataset(name, data=np.zeros((5_000_000, columns), dtype=kind), compression="gzip")
    monkeypatch.setattr(blockmesh, "dataset", None)
    with pytest.raises(MeshError, match=reason):
        read(path)
