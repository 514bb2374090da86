"""Generators: areas, counts, face sets and points of every mesh; the reference meshes reproduced."""

import os
import sys

import numpy as np
import pytest

HERE = os.path.dirname(__file__)
sys.path.insert(0, os.path.join(HERE, "..", "..", "tools"))

import triangle_dam as fig6
from quoin_tools.mesh import blockmesh, dam, meshing, stacks
from quoin_tools.mesh.blockmesh import MeshError, areas, check, face_ends, macroblocks, outer_faces, read
from quoin_tools.show import plot_mesh
from reference_mesh import from_reference

REFERENCE = os.path.join(HERE, "..", "data", "reference")


def reference(name):
    return from_reference(os.path.join(REFERENCE, name))


def counts(mesh):
    return {name: len(rows) for name, rows in mesh.face_sets.items()}


def at(mesh, point):
    return mesh.vertices[mesh.points[point]].tolist()


def centroid(mesh, group):
    """By the shoelace formula over the outer faces of the group, not over the blocks."""
    faces = outer_faces(mesh)
    faces = faces[mesh.block_group[faces[:, 0]] == mesh.group_names.index(group)]
    a, b = mesh.vertices[face_ends(mesh, faces)].transpose(1, 0, 2)
    twice = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return ((a + b) * twice[:, None]).sum(axis=0) / (3 * twice.sum())


def assert_same_mesh(mesh, expected, tolerance):
    assert np.abs(mesh.vertices - expected.vertices).max() <= tolerance
    assert np.array_equal(mesh.blocks, expected.blocks)
    assert np.array_equal(mesh.block_group, expected.block_group)
    assert mesh.group_names == expected.group_names
    assert mesh.points == expected.points
    assert counts(mesh) == counts(expected)
    for name, rows in expected.face_sets.items():
        assert sorted(map(tuple, rows)) == sorted(map(tuple, mesh.face_sets[name])), name


# ---- dam -------------------------------------------------------------------------------------------------

@pytest.mark.parametrize("columns", [12, 24])
def test_dam_reproduces_the_reference_mesh(columns):
    expected = reference(f"mesh_guilhofrei_g1_n{columns}.json")
    assert_same_mesh(dam.dam_mesh(columns=columns), expected, 1e-9)


def test_dam_g1():
    mesh = dam.dam_mesh()
    assert check(mesh).max() + 1 == 2
    assert (len(mesh.blocks), len(mesh.vertices)) == (438, 504)
    area = areas(mesh)
    assert area[mesh.block_group == 0].sum() == pytest.approx(411.96, abs=0.005)
    assert centroid(mesh, "dam") == pytest.approx([8.194, 12.919], abs=5e-4)
    assert area[mesh.block_group == 1].sum() == pytest.approx(220.8 * 99 + 2.28 * (99 + 22.8 / 2), rel=1e-12)
    assert counts(mesh) == {"base": 24, "upstream": 17, "downstream": 17, "crest": 12, "rock_sides": 18,
                            "rock_bottom": 26, "rock_top_upstream": 7, "rock_top_downstream": 7}
    assert at(mesh, "heel") == at(mesh, "rock_heel") == [0, 0]
    assert mesh.points["heel"] != mesh.points["rock_heel"]
    assert at(mesh, "toe") == at(mesh, "rock_toe") == pytest.approx([22.8, 2.28])
    assert at(mesh, "crest_upstream") == pytest.approx([1.65, 33])
    assert at(mesh, "crest_downstream") == pytest.approx([6.65, 33])


def test_dam_face_sets_cover_the_boundary_once():
    mesh = dam.dam_mesh(columns=8, rock_columns=11, triangles=True)
    listed = np.concatenate(list(mesh.face_sets.values()))
    assert sorted(map(tuple, listed)) == sorted(map(tuple, outer_faces(mesh)))


@pytest.mark.parametrize("rock_columns, base", [(12, 24), (18, 30), (7, 19)])
def test_dam_with_another_mesh_below_the_joint(rock_columns, base):
    mesh = dam.dam_mesh(rock_columns=rock_columns)
    assert check(mesh).max() + 1 == 2
    assert len(mesh.face_sets["base"]) == base
    assert areas(mesh)[mesh.block_group == 0].sum() == pytest.approx(411.955, abs=1e-3)


def test_dam_in_triangles():
    mesh = dam.dam_mesh(triangles=True)
    check(mesh)
    assert len(mesh.blocks) == 2 * 438 and (mesh.blocks[:, 3] == -1).all()
    assert areas(mesh).sum() == pytest.approx(areas(dam.dam_mesh()).sum(), rel=1e-12)


def test_gravity_section_of_the_flags_is_g1():
    assert dam.gravity_section().corners() == pytest.approx(dam.G1.corners(), abs=1e-12)


def test_dam_command_line(tmp_path, capsys):
    path = str(tmp_path / "model.h5")
    assert dam.main(["-o", path, "--section", "0,0", "60,0", "5,55", "5,60", "0,60", "--columns", "6",
                     "--rows", "5", "2", "--joint-mesh", "finer", "4", "--rock-extent", "2"]) == 0
    assert "dam 1812.50 m2" in capsys.readouterr().out
    mesh = read(path)
    assert check(mesh).max() + 1 == 2
    assert counts(mesh)["base"] == 6 + 10 and counts(mesh)["upstream"] == 7
    assert mesh.vertices.min(axis=0).tolist() == [-120, -120]
    assert blockmesh.main(["check", path]) == 0
    assert dam.main(["-o", path, "--crest-face", "0", "--columns", "5"]) == 0
    assert counts(read(path))["downstream"] == counts(read(path))["upstream"]


@pytest.mark.parametrize("flags, message", [
    (["--joint-mesh", "coarser", "12"], "--joint-mesh coarser 12: expected equal, finer N or coarser N"),
    (["--joint-mesh", "some"], "--joint-mesh some: expected equal, finer N or coarser N"),
    (["--columns", "0"], "expected at least one column"),
    (["--rock-extent", "0"], "a positive rock extent"),
    (["--section", "0,0", "60,0", "0,60", "5,60", "0,60"], "a downstream face that falls to the toe"),
    (["--crest-face", "40"], "the break of the slope between toe and crest"),
])
def test_dam_refusals(tmp_path, capsys, flags, message):
    assert dam.main(["-o", str(tmp_path / "model.h5"), *flags]) == 2
    assert message in capsys.readouterr().err and not os.listdir(tmp_path)


# ---- Fig. 6 ----------------------------------------------------------------------------------------------

@pytest.mark.parametrize("n", [8, 16, 32])
@pytest.mark.parametrize("family", ["G", "M"])
def test_fig6_reproduces_the_reference_mesh(family, n):
    mesh = fig6.triangle_dam(n, family)
    assert_same_mesh(mesh, reference(f"mesh_fig6_{family}_n{n}.json"), 0.0)
    assert macroblocks(mesh).max() + 1 == 2 and check(mesh) is not None
    assert areas(mesh)[mesh.block_group == 0].sum() == pytest.approx(4000)
    assert counts(mesh) == {"base": 2 * n, "upstream": n, "downstream": n, "ground_bottom": n}
    assert (at(mesh, "heel"), at(mesh, "toe"), at(mesh, "crest")) == ([0, 0], [80, 0], [0, 100])
    assert mesh.group_rigid.tolist() == [0, 1]


@pytest.mark.parametrize("family, quads, triangles", [("G", 28, 8), ("M", 56, 8)])
def test_fig6_counts(family, quads, triangles):
    mesh = fig6.triangle_dam(8, family, ground="single")
    check(mesh)
    assert (mesh.blocks[:, 3] >= 0).sum() == quads + 1 and (mesh.blocks[:, 3] < 0).sum() == triangles
    assert counts(mesh) == {"base": 9, "upstream": 8, "downstream": 8, "ground_bottom": 1}


def test_fig6_joint_segments_of_the_reference_match():
    """The faces of both sides lie at equal places, so that each makes one contact over its whole length."""
    mesh = fig6.triangle_dam(16, "M")
    base = mesh.face_sets["base"]
    middle = mesh.vertices[face_ends(mesh, base)].mean(axis=1)[:, 0]
    dam_side = mesh.block_group[base[:, 0]] == 0
    assert np.array_equal(np.sort(middle[dam_side]), np.sort(middle[~dam_side]))


def test_fig6_refuses_unknown_families():
    with pytest.raises(MeshError, match="expected G or M"):
        fig6.triangle_dam(8, "Q")


# ---- stacks ----------------------------------------------------------------------------------------------

def test_column():
    mesh = stacks.column(3, 2.0, 0.5)
    assert check(mesh).tolist() == [0, 1, 2, 3]
    assert counts(mesh) == {"bottom": 1, "joint_0": 2, "joint_1": 2, "joint_2": 2, "joint": 6, "left": 3,
                            "right": 3, "top": 1}
    assert mesh.group_names == ["base", "block"] and mesh.group_rigid.tolist() == [1, 1]
    assert at(mesh, "top_right") == [2, 1.5] and at(mesh, "block_2") == [0, 0.5]
    assert mesh.vertices.min(axis=0).tolist() == [-1, -1]


def test_column_without_base():
    mesh = stacks.column(2, rigid=False, base=False)
    assert check(mesh).tolist() == [0, 1] and mesh.group_names == ["block"]
    assert counts(mesh) == {"bottom": 1, "joint_0": 2, "joint": 2, "left": 2, "right": 2, "top": 1}


def test_one_contact():
    mesh = stacks.one_contact(1.5, 3.0)
    assert check(mesh).tolist() == [0, 1]
    assert areas(mesh).tolist() == [3.0, 4.5] and counts(mesh)["joint"] == 2


@pytest.mark.parametrize("triangles, blocks", [(False, 4 + 9), (True, 8 + 18)])
def test_two_bodies(triangles, blocks):
    mesh = stacks.two_bodies(triangles=triangles)
    assert check(mesh).max() + 1 == 2 and len(mesh.blocks) == blocks
    assert counts(mesh) == {"left": 5, "right": 5, "bottom": 2, "top": 3, "joint": 5}
    assert areas(mesh).sum() == pytest.approx(2.0)
    for name, axis, value in [("left", 0, 0), ("right", 0, 1), ("bottom", 1, 0), ("top", 1, 2),
                              ("joint", 1, 1)]:
        assert mesh.vertices[face_ends(mesh, mesh.face_sets[name])][..., axis] == pytest.approx(value), name


def test_two_bodies_on_a_base():
    mesh = stacks.two_bodies(base=True)
    assert check(mesh).max() + 1 == 3 and mesh.group_names == ["lower", "upper", "base"]
    assert counts(mesh)["joint_base"] == 3 and mesh.group_rigid.tolist() == [0, 0, 1]


@pytest.mark.parametrize("slope", [0.0, 10.0, 30.0, 60.0])
def test_block_on_plane(slope):
    mesh = stacks.block_on_plane(1.0, 0.2, slope)
    assert check(mesh).tolist() == [0, 1]
    assert areas(mesh)[1] == pytest.approx(0.2)
    edge = np.subtract(at(mesh, "bottom_right"), at(mesh, "bottom_left"))
    assert np.degrees(np.arctan2(-edge[1], edge[0])) == pytest.approx(slope)
    assert np.hypot(*edge) == pytest.approx(1)
    plane = mesh.vertices[face_ends(mesh, mesh.face_sets["joint"][:1])][0]
    assert np.hypot(*(plane[1] - plane[0])) == pytest.approx(3.0)


def test_cantilever():
    mesh = stacks.cantilever(8, 2)
    assert check(mesh).max() == 0 and counts(mesh) == {"bottom": 8, "right": 2, "top": 8, "left": 2}
    assert at(mesh, "top_right") == [10, 0.5] and at(mesh, "bottom_left") == [0, -0.5]
    mesh = stacks.cantilever(8, 2, triangles=True)
    assert len(mesh.blocks) == 32 and counts(mesh) == {"bottom": 8, "right": 2, "top": 8, "left": 2}
    assert mesh.vertices[face_ends(mesh, mesh.face_sets["top"])][..., 1] == pytest.approx(0.5)
    assert mesh.vertices[face_ends(mesh, mesh.face_sets["left"])][..., 0] == pytest.approx(0.0)


@pytest.mark.parametrize("triangles, blocks", [(False, 5), (True, 10)])
def test_patch_test(triangles, blocks):
    mesh = stacks.patch_test(triangles)
    assert check(mesh).max() == 0 and len(mesh.blocks) == blocks
    assert areas(mesh).sum() == pytest.approx(0.24 * 0.12)
    assert counts(mesh) == {"bottom": 1, "right": 1, "top": 1, "left": 1}
    assert at(mesh, "inner_2") == [0.16, 0.08]


def test_block_grid():
    mesh = stacks.block_grid(3, 4, 2, 5, size=2.0)
    assert check(mesh).max() + 1 == 12
    assert (len(mesh.blocks), len(mesh.vertices)) == (120, 12 * 18)
    assert counts(mesh) == {"left": 20, "right": 20, "bottom": 6, "top": 6, "joint": 2 * (2 * 20 + 3 * 6)}
    assert at(mesh, "top_right") == [6, 8] and areas(mesh).sum() == pytest.approx(48)


def test_block_grid_with_triangles_and_rigid_bodies():
    mesh = stacks.block_grid(3, 4, 2, 2, triangle_every=4, rigid_every=6)
    component = check(mesh)
    triangle = np.unique(component[mesh.blocks[:, 3] < 0])
    rigid = np.unique(component[mesh.block_group == 1])
    assert triangle.tolist() == [3, 7, 11] and rigid.tolist() == [5, 11]
    assert len(mesh.blocks) == 48 + 12 and mesh.group_rigid.tolist() == [0, 1]
    assert areas(mesh).sum() == pytest.approx(12)


# ---- pieces ----------------------------------------------------------------------------------------------

@pytest.mark.parametrize("first, length, n", [(1.9, 99, 7), (1, 10, 10), (2, 10, 8), (0.001, 1000, 3)])
def test_graded(first, length, n):
    steps = np.diff(meshing.graded(first, length, n))
    assert steps[0] == pytest.approx(first) and steps.sum() == pytest.approx(length)
    assert steps[1:] / steps[:-1] == pytest.approx(np.full(n - 1, steps[1] / steps[0]))


def test_steps_that_meet_zero_give_zero():
    mesh = meshing.rectangle(-4, -1, 12, 3, 3, 3)
    assert mesh.vertices[:4, 0].tolist() == [-4.0, 0.0, 4.0, 8.0]
    assert mesh.vertices[4:8, 1].tolist() == [0.0] * 4
    assert meshing.line((0.1, 0), (0.3, 1), 7)[[0, -1]].tolist() == [[0.1, 0.0], [0.3, 1.0]]


def test_graded_refuses_what_does_not_fit():
    with pytest.raises(MeshError, match="the first of 2 m, is not possible"):
        meshing.graded(2.0, 1.0, 4)


def test_join_refuses_a_group_of_two_kinds():
    with pytest.raises(MeshError, match="group 'body': rigid in one mesh, deformable in another"):
        meshing.join([meshing.renamed(meshing.rectangle(0, 0, 1, 1)),
                      meshing.renamed(meshing.rectangle(0, 1, 1, 1, rigid=True))])


def test_double_vertices_opens_a_joint_across_a_patch():
    mesh = meshing.rectangle(0, 0, 4, 2, 4, 2)
    edges = np.column_stack([np.arange(5, 9), np.arange(6, 10)])
    joint = meshing.double_vertices(mesh, edges)
    assert check(joint).tolist() == [0] * 4 + [1] * 4 and len(joint.vertices) == 20
    assert np.array_equal(joint.vertices[joint.blocks], mesh.vertices[mesh.blocks])


def test_face_sets_and_vertices_by_place():
    mesh = meshing.rectangle(0, 0, 4, 2, 4, 2)
    assert meshing.face_set_on(mesh, (0, 0), (3, 0)).tolist() == [[0, 0], [1, 0], [2, 0]]
    assert len(meshing.face_set_where(mesh, lambda x, y: x > 2.5)) == 4
    assert meshing.vertex_at(mesh, 4, 2, "body") == 14
    with pytest.raises(MeshError, match=r"no vertex at \(9, 2\)"):
        meshing.vertex_at(mesh, 9, 2)


# ---- references and pictures -----------------------------------------------------------------------------

def test_kind_of_reference_mesh():
    source = os.path.join(REFERENCE, "mesh_fig6_G_n8.json")
    mesh = from_reference(source)
    assert (len(mesh.blocks), len(mesh.vertices)) == (44, 63)
    with pytest.raises(MeshError, match=r"is this a guilhofrei mesh\?"):
        from_reference(source, "guilhofrei")


@pytest.mark.parametrize("mesh, joints", [
    (dam.dam_mesh(rock_columns=16), {"base"}),
    (stacks.column(2), {"joint", "joint_0", "joint_1"}),
    (stacks.block_grid(3, 3, 2, 2), {"joint"}),
    (stacks.block_on_plane(), {"joint"}),
    (stacks.patch_test(), set()),
], ids=["dam", "column", "grid", "plane", "patch"])
def test_picture(tmp_path, mesh, joints):
    assert {name for name, rows in mesh.face_sets.items() if plot_mesh.is_joint(mesh, rows)} == joints
    blockmesh.write(tmp_path / "m.h5", mesh)
    assert plot_mesh.main([str(tmp_path / "m.h5"), "-o", str(tmp_path / "m.png")]) == 0
    assert (tmp_path / "m.png").read_bytes()[:4] == b"\x89PNG"
    assert plot_mesh.main([str(tmp_path / "none.h5"), "-o", str(tmp_path / "n.png")]) == 2
