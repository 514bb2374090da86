"""Import of meshes written by Gmsh: both versions, text and binary, joints, T-junctions, tips, refusals.

The meshes are made with Gmsh's Python module where it can be loaded, or else those tests are skipped;
the import itself needs meshio only, and the hand-written meshes at the end always run."""

import os
import sys
from pathlib import Path

import meshio
import numpy as np
import pytest

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "..", "tools"))

from quoin_tools.mesh import blockmesh, gmsh_import
from quoin_tools.mesh.blockmesh import MeshError, areas, check, face_ends, macroblocks, read
from quoin_tools.mesh.gmsh_import import import_msh

FORMATS = [(2.2, 0), (2.2, 1), (4.1, 0), (4.1, 1)]


@pytest.fixture
def gmsh():
    try:
        import gmsh as module
    except (ImportError, OSError) as error:  # OSError: a library of the window system is missing
        pytest.skip(f"gmsh cannot be loaded: {error}")
    module.initialize(interruptible=False)
    module.option.setNumber("General.Terminal", 0)
    yield module
    module.finalize()


def test_dam_with_gallery_of_the_documents(gmsh, tmp_path):
    """gallery_dam.geo, the one of docs/generators.md: a hole, a base and a seam."""
    gmsh.open(str(Path(__file__).with_name("gallery_dam.geo")))
    gmsh.model.mesh.generate(2)
    gmsh.write(str(tmp_path / "dam.msh"))
    mesh = import_msh(str(tmp_path / "dam.msh"), ["base", "seam"])
    assert check(mesh).max() + 1 == 3
    of_group = [areas(mesh)[mesh.block_group == row].sum() for row in range(3)]
    assert dict(zip(mesh.group_names, of_group)) == pytest.approx({"dam": 922.5 - 7.5, "rock": 130 * 6, "below": 130 * 34})
    for name, length in (("base", 2 * 36), ("seam", 2 * 130), ("gallery", 11)):  # joints have both sides
        a, b = np.moveaxis(mesh.vertices[face_ends(mesh, mesh.face_sets[name])], 1, 0)
        assert np.hypot(*(b - a).T).sum() == pytest.approx(length), name


def two_layers(gmsh, quads, size=0.5):
    """Dam (x 0..2, y 0..3) on rock (x -2..4, y -2..0), one mesh; the base is a line inside it."""
    xy = {1: (-2, -2), 2: (4, -2), 3: (4, 0), 4: (2, 0), 5: (0, 0), 6: (-2, 0), 7: (2, 3), 8: (0, 3)}
    for tag, (x, y) in xy.items():
        gmsh.model.geo.addPoint(x, y, 0, size, tag)
    gmsh.model.geo.addPoint(1, 20, 0, size, 9)  # a point no element uses
    for tag, (a, b) in enumerate([(1, 2), (2, 3), (3, 4), (4, 5), (5, 6), (6, 1), (4, 7), (7, 8), (8, 5)], 1):
        gmsh.model.geo.addLine(a, b, tag)
    gmsh.model.geo.addCurveLoop([1, 2, 3, 4, 5, 6], 1)
    gmsh.model.geo.addCurveLoop([-9, -8, -7, 4], 2)  # clockwise
    gmsh.model.geo.addPlaneSurface([1], 1)
    gmsh.model.geo.addPlaneSurface([2], 2)
    gmsh.model.geo.synchronize()
    for dimension, tags, name in [(2, [2], "dam"), (2, [1], "rock"), (1, [4], "base"), (1, [9], "upstream"),
                                  (1, [1], "bottom"), (0, [5], "heel"), (0, [8], "crest")]:
        gmsh.model.addPhysicalGroup(dimension, tags, name=name)
    if quads:
        gmsh.option.setNumber("Mesh.RecombineAll", 1)
        gmsh.option.setNumber("Mesh.RecombinationAlgorithm", 2)
    gmsh.model.mesh.generate(2)


def save(gmsh, path, version, binary):
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    gmsh.write(str(path))
    return path


@pytest.mark.parametrize("quads", [False, True])
@pytest.mark.parametrize("version, binary", FORMATS)
def test_dam_on_rock(gmsh, tmp_path, version, binary, quads):
    two_layers(gmsh, quads)
    path = save(gmsh, tmp_path / "model.msh", version, binary)
    mesh = import_msh(path, ["base"], ["rock"])
    assert check(mesh).max() + 1 == 2
    assert mesh.group_names == ["dam", "rock"] and mesh.group_rigid.tolist() == [0, 1]
    area = areas(mesh)
    assert area[mesh.block_group == 0].sum() == pytest.approx(6.0, rel=1e-12)
    assert area[mesh.block_group == 1].sum() == pytest.approx(12.0, rel=1e-12)
    assert (mesh.blocks[:, 3] >= 0).any() == quads
    counts = {name: len(rows) for name, rows in mesh.face_sets.items()}
    assert counts == ({"base": 8, "upstream": 6, "bottom": 12})
    base = mesh.face_sets["base"]
    assert np.bincount(mesh.block_group[base[:, 0]]).tolist() == [4, 4]
    assert mesh.vertices[face_ends(mesh, base)][..., 1] == pytest.approx(0.0)
    assert mesh.vertices[mesh.points["heel"]].tolist() == [0, 0]
    assert mesh.vertices[mesh.points["crest"]].tolist() == [0, 3]
    assert (mesh.vertices[:, 1] <= 3).all()


def test_joint_doubles_just_the_vertices_on_it(gmsh, tmp_path):
    two_layers(gmsh, False)
    path = save(gmsh, tmp_path / "model.msh", 4.1, 0)
    gmsh.model.removePhysicalGroups([(1, 3)])
    closed = import_msh(save(gmsh, tmp_path / "closed.msh", 4.1, 0))
    joint = import_msh(path, ["base"])
    assert len(joint.blocks) == len(closed.blocks)
    assert len(joint.vertices) == len(closed.vertices) + 5
    assert macroblocks(closed).max() == 0


def test_command_line(gmsh, tmp_path, capsys):
    two_layers(gmsh, True)
    path = save(gmsh, tmp_path / "model.msh", 4.1, 1)
    model = str(tmp_path / "m.h5")
    assert gmsh_import.main([str(path), "-o", model, "--interfaces", "base", "--rigid", "rock"]) == 0
    assert "2 macroblocks" in capsys.readouterr().out
    assert blockmesh.main(["check", model]) == 0
    assert read(model).group_rigid.tolist() == [0, 1]
    capsys.readouterr()
    assert gmsh_import.main([str(path), "-o", str(tmp_path / "n.h5"), "--interfaces", "joint"]) == 2
    output = capsys.readouterr()
    assert output.err == ("interface 'joint': no physical curve of that name, "
                          "there are base, bottom, upstream\n")
    assert not (tmp_path / "n.h5").exists()


def refused(path, message, **options):
    with pytest.raises(MeshError) as caught:
        import_msh(path, **options)
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_gmsh_refusals(gmsh, tmp_path):
    two_layers(gmsh, False)
    path = save(gmsh, tmp_path / "model.msh", 4.1, 0)
    refused(path, "physical curve 'base': runs inside a body, name it an interface or leave it out")
    refused(path, "interface 'upstream': 1 blocks along its edge", interfaces=["upstream"])
    refused(path, "rigid group 'ground': no physical surface of that name, there are dam, rock",
            rigid=["ground"])
    gmsh.model.mesh.setOrder(2)
    for version, binary in FORMATS:
        refused(save(gmsh, tmp_path / "second.msh", version, binary),
                "elements of type line3, expected triangles")


@pytest.mark.parametrize("version, binary", FORMATS)
def test_no_physical_groups_are_refused(gmsh, tmp_path, version, binary):
    two_layers(gmsh, False)
    gmsh.model.removePhysicalGroups()
    refused(save(gmsh, tmp_path / "model.msh", version, binary), "no elements in a named physical surface")


def test_elements_outside_the_groups_are_refused(gmsh, tmp_path):
    two_layers(gmsh, False)
    gmsh.model.removePhysicalGroups([(2, 1)])
    gmsh.option.setNumber("Mesh.SaveAll", 1)
    refused(save(gmsh, tmp_path / "model.msh", 4.1, 0), "elements outside the physical groups")
    refused(save(gmsh, tmp_path / "model.msh", 2.2, 0), "no elements in a named physical surface")


@pytest.mark.parametrize("version", [2.2, 4.1])
def test_curve_in_two_groups(gmsh, tmp_path, version):
    two_layers(gmsh, False)
    gmsh.model.addPhysicalGroup(1, [9, 8], name="wet")
    mesh = import_msh(save(gmsh, tmp_path / "model.msh", version, 0), ["base"])
    assert len(mesh.face_sets["upstream"]) == 6 and len(mesh.face_sets["wet"]) == 10


# ---- grids written by hand, so that every vertex is known ------------------------------------------------

def grid_msh(path, curves, points=(), n=4, surfaces=("body",)):
    """A 2.2 text file: n by n unit squares, node (i, j) is j (n + 1) + i + 1; curves: name -> node pairs."""
    def node(i, j):
        return j * (n + 1) + i + 1
    names = [f'2 {tag} "{name}"' for tag, name in enumerate(surfaces, 1)]
    names += [f'1 {tag} "{name}"' for tag, name in enumerate(curves, 11)]
    names += [f'0 {tag} "{name}"' for tag, (name, _) in enumerate(points, 31)]
    elements = []
    for tag, pairs in enumerate(curves.values(), 11):
        elements += [f"1 2 {tag} {tag} {node(*a)} {node(*b)}" for a, b in pairs]
    for tag, (_, at) in enumerate(points, 31):
        elements.append(f"15 2 {tag} {tag} {node(*at)}")
    for j in range(n):
        for i in range(n):
            corners = (node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1))
            elements.append("3 2 1 1 {} {} {} {}".format(*corners))
    nodes = [f"{node(i, j)} {i} {j} 0" for j in range(n + 1) for i in range(n + 1)]
    text = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names)), *names,
            "$EndPhysicalNames", "$Nodes", str(len(nodes)), *nodes, "$EndNodes", "$Elements",
            str(len(elements)), *[f"{number} {element}" for number, element in enumerate(elements, 1)],
            "$EndElements", ""]
    path.write_text("\n".join(text))
    return path


def run(a, b):
    """Node pairs of unit edges from a to b."""
    steps = max(abs(b[0] - a[0]), abs(b[1] - a[1]))
    at = [(a[0] + (b[0] - a[0]) * k // steps, a[1] + (b[1] - a[1]) * k // steps) for k in range(steps + 1)]
    return list(zip(at[:-1], at[1:]))


def copies(mesh, x, y):
    return int((np.hypot(mesh.vertices[:, 0] - x, mesh.vertices[:, 1] - y) < 1e-9).sum())


def test_joint_that_ends_inside_keeps_its_end_single(tmp_path):
    mesh = import_msh(grid_msh(tmp_path / "m.msh", {"crack": run((0, 2), (2, 2))}), ["crack"])
    assert [copies(mesh, x, 2) for x in range(5)] == [2, 2, 1, 1, 1]
    assert check(mesh).max() == 0 and len(mesh.face_sets["crack"]) == 4


def test_joint_inside_a_body_opens_between_its_ends(tmp_path):
    mesh = import_msh(grid_msh(tmp_path / "m.msh", {"crack": run((1, 2), (3, 2))}), ["crack"])
    assert [copies(mesh, x, 2) for x in range(5)] == [1, 1, 2, 1, 1]
    assert len(mesh.vertices) == 26


def test_t_junction_has_three_copies(tmp_path):
    curves = {"bed": run((0, 2), (4, 2)), "head": run((2, 2), (2, 4))}
    mesh = import_msh(grid_msh(tmp_path / "m.msh", curves, [("meet", (2, 2))]), ["bed", "head"])
    assert [copies(mesh, x, 2) for x in range(5)] == [2, 2, 3, 2, 2]
    assert [copies(mesh, 2, y) for y in range(5)] == [1, 1, 3, 2, 2]
    assert check(mesh).max() + 1 == 3
    assert areas(mesh).sum() == pytest.approx(16.0)
    assert {name: len(rows) for name, rows in mesh.face_sets.items()} == {"bed": 8, "head": 4}
    # the named point stays with the lowest block, below the joint
    assert mesh.points["meet"] in mesh.blocks[macroblocks(mesh) == 0]


def test_crossing_has_four_copies(tmp_path):
    curves = {"bed": run((0, 2), (4, 2)), "head": run((2, 0), (2, 4))}
    mesh = import_msh(grid_msh(tmp_path / "m.msh", curves), ["bed", "head"])
    assert copies(mesh, 2, 2) == 4 and check(mesh).max() + 1 == 4
    assert len(mesh.vertices) == 4 * 9


def test_one_of_two_curves_as_interface(tmp_path):
    curves = {"bed": run((0, 2), (4, 2)), "left": run((0, 0), (0, 4))}
    mesh = import_msh(grid_msh(tmp_path / "m.msh", curves), ["bed"])
    assert len(mesh.face_sets["left"]) == 4 and len(mesh.vertices) == 30


REFUSALS = {
    "short joint": ({"curves": {"a": run((1, 2), (2, 2))}}, ["a"],
                    "interface 'a': an edge of it stays closed, both its ends are in one body"),
    "two kinds": ({"curves": {"body": run((0, 0), (4, 0))}}, [],
                  "'body' names a physical surface and a physical curve"),
    "diagonal": ({"curves": {"a": [((0, 0), (1, 1))]}}, [],
                 "physical curve 'a': does not run along the edges"),
    "diagonal joint": ({"curves": {"a": [((0, 0), (1, 1))]}}, ["a"],
                       "interface 'a': 0 blocks along its edge (0, 0) to (1, 1), expected two"),
}


@pytest.mark.parametrize("case", REFUSALS)
def test_refusals(tmp_path, case):
    options, interfaces, message = REFUSALS[case]
    refused(grid_msh(tmp_path / "m.msh", **options), message, interfaces=interfaces)


def edited(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    return path


def test_surface_elements_in_no_group_and_in_two_groups_are_refused(tmp_path):
    path = edited(grid_msh(tmp_path / "m.msh", {}), "\n16 3 2 1 1 ", "\n16 3 2 7 7 ")
    refused(path, "1 surface elements are in no named physical surface")
    path = edited(grid_msh(tmp_path / "m.msh", {}, surfaces=("body", "cap")), "\n16 3 2 1 1 19 20 25 24",
                  "\n16 3 2 2 2 18 19 24 23")
    refused(path, "surface 'body' and surface 'cap' have elements in common")


def test_named_point_of_two_points_is_refused(tmp_path):
    path = grid_msh(tmp_path / "m.msh", {}, [("p", (0, 0)), ("q", (1, 0))])
    refused(edited(path, "15 2 32 32 2", "15 2 31 31 2"), "physical point 'p': has 2 points, expected one")


def test_clockwise_elements_are_turned(tmp_path):
    path = edited(grid_msh(tmp_path / "m.msh", {}), "1 3 2 1 1 1 2 7 6", "1 3 2 1 1 1 6 7 2")
    mesh = import_msh(path)
    assert mesh.blocks[0].tolist() == [0, 1, 6, 5] and check(mesh).max() == 0


def test_bad_files_are_refused(tmp_path):
    refused(tmp_path / "none.msh", "No such file")
    (tmp_path / "text.msh").write_text("this is not a mesh\n")
    refused(tmp_path / "text.msh", "not a .msh file of version 2.2 or 4.1")
    path = grid_msh(tmp_path / "m.msh", {})
    path.write_text(path.read_text()[:400])
    refused(path, "not a .msh file of version 2.2 or 4.1")
    path = edited(grid_msh(tmp_path / "m.msh", {}), "\n7 1 1 0\n", "\n7 1 1 0.5\n")
    refused(path, "the mesh is not plane")


def square_mesh(path, side, z=0):
    path.write_text(f"""$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 1 "dam"\n$EndPhysicalNames\n$Nodes\n4\n1 0 0 {z}\n2 {side} 0 {z}\n3 {side} {side} {z}\n4 0 {side} {z}
$EndNodes\n$Elements\n1\n1 3 2 1 1 1 2 3 4\n$EndElements\n""")
    return str(path)


def test_units_of_a_mesh(tmp_path, capsys):
    """A dam of 20 m drawn in mm is no dam of 20 km: refused without its unit, 400 m2 with it, and reported."""
    path, model = square_mesh(tmp_path / "mm.msh", 20000), str(tmp_path / "m.h5")
    refused(path, "the mesh would be 20000 m across, expected 0.1 to 5000 m: its unit is to be given (--unit mm, cm, dm, m,")
    assert areas(import_msh(path, unit="mm")) == pytest.approx([400])
    assert areas(import_msh(path, unit="m")) == pytest.approx([4e8])
    assert gmsh_import.main([path, "-o", model, "--unit", "mm"]) == 0 and "20 m x 20 m, its coordinates in mm" in capsys.readouterr().out
    assert gmsh_import.main([square_mesh(tmp_path / "cm.msh", 2000), "-o", model]) == 0
    assert "warning: the mesh is 2000 m across; where its coordinates are in mm or cm, give --unit" in capsys.readouterr().err


@pytest.mark.parametrize("old, new", [("$Nodes\n4", "$Nodes\n999999999999"), ("$Elements\n1", "$Elements\n99999999999999999999999999")])
def test_absurd_counts(tmp_path, old, new):
    path = tmp_path / "m.msh"
    text = Path(square_mesh(path, 20)).read_text()
    path.write_text(text.replace(old, new))
    refused(str(path), f", more than a file of {path.stat().st_size} bytes has")


def test_a_reason_in_words(tmp_path, monkeypatch):
    """Numbers that a file refers to and does not have; devices."""
    def read(path):
        raise KeyError(np.int32(9))

    path = square_mesh(tmp_path / "m.msh", 20)
    monkeypatch.setattr(meshio.gmsh, "read", read)
    refused(path, "(it refers to number 9, which is no entity, node or kind of element in it)")
    refused("/dev/zero", "/dev/zero: no regular file")
