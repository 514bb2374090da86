"""Imports a Gmsh mesh (.msh 2.2 or 4.1, ASCII or binary) as a block mesh.

    quoin import model.msh -o model.h5 --interfaces base crack --rigid ground --unit mm

Physical surfaces become groups, physical curves face sets, physical points named vertices. The curves named
as interfaces become joints: the vertices on them are doubled, their face sets hold both sides."""

import os
import re
import stat
import struct
import sys

import numpy as np

from quoin_tools.base.command import Parser, words_of
from quoin_tools.mesh.blockmesh import BlockMesh, MeshError, all_faces, areas, check, edge_keys, outer_faces, write, xy_text
from quoin_tools.mesh.lengths import UNITS
from quoin_tools.mesh.meshing import double_vertices, faces_on_edges

DIMENSION = {"vertex": 0, "line": 1, "triangle": 2, "quad": 2}
LARGEST, SMALLEST = 5000.0, 0.1  # m: a section beyond these limits is in another unit, unless its unit is given
LARGE = 1000.0  # m: larger sections bring a warning
KIND = ("point", "curve", "surface", "volume")


def import_msh(path, interfaces=(), rigid=(), unit=None):
    """Block mesh of a .msh file; interfaces: names of curves to open as joints; rigid: names of groups; unit: of its coordinates, of UNITS. Without one they are
    in m, and a mesh that is no section in m is refused."""
    msh = read_msh(path)
    check_names_of(path, msh)
    msh.points = msh.points * UNITS[unit or "m"]
    extent = size_of(msh.points).max(initial=0.0)
    if unit is None and not SMALLEST <= extent <= LARGEST:
        raise MeshError(f"{path}: the mesh would be {extent:g} m across, expected {SMALLEST:g} to {LARGEST:g} m: its unit is to be given (--unit {', '.join(UNITS)})")
    mesh = bodies(msh, rigid)
    edges = {name: np.concatenate(cells) for name, cells in members(msh, 1).items()}
    unknown = [name for name in interfaces if name not in edges]
    if unknown:
        raise MeshError(f"interface {unknown[0]!r}: no physical curve of that name, "
                        f"there are {', '.join(sorted(edges)) or 'none'}")
    points = {name: single_vertex(name, cells) for name, cells in members(msh, 0).items()}
    mesh, edges, points = without_unused(mesh, edges, points)
    mesh.points = points
    mesh.face_sets = {name: faces_on_edges(mesh, pairs) for name, pairs in edges.items()}
    if interfaces:
        for name in interfaces:
            check_interface(mesh, name, edges[name])
        mesh = double_vertices(mesh, np.concatenate([edges[name] for name in interfaces]))
    check_outer(mesh, interfaces)
    return mesh


def size_of(points):
    """[m] Width and height."""
    return np.ptp(points[:, :2], axis=0) if len(points) else np.zeros(2)


# ---- reading ---------------------------------------------------------------------------------------------

def read_msh(path):
    """meshio's general reader ends the program on a bad file, its Gmsh reader raises."""
    import meshio  # here: only files of Gmsh need it

    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise MeshError(f"{path}: no regular file")
        check_counts(path)
        msh = meshio.gmsh.read(path)
    except MeshError:
        raise
    except OSError as error:
        raise MeshError(f"{path}: {error.strerror or error}") from None
    except (MemoryError, OverflowError):
        raise MeshError(f"{path}: it announces more nodes or elements than it has") from None
    except (meshio.ReadError, ValueError, KeyError, IndexError, TypeError, AssertionError, AttributeError, struct.error) as error:
        reason = str(error).splitlines()[0] if str(error) else "it ends too early, or a number in it is wrong"
        if isinstance(error, KeyError):
            reason = f"it refers to number {re.sub(r'int[0-9]*|[^0-9, ]', '', reason) or reason}, which is no entity, node or kind of element in it"
        raise MeshError(f"{path}: not a .msh file of version 2.2 or 4.1, or it has elements outside the "
                        f"physical groups ({reason})") from None
    for block in msh.cells:
        if len(block.data) and block.type not in DIMENSION:
            raise MeshError(f"{path}: elements of type {block.type}, expected triangles, quadrilaterals, "
                            "lines and points of first order (Mesh.ElementOrder = 1)")
    return msh


def check_counts(path):
    """Refuses counts of nodes and elements that the file cannot hold: a reader would make room for all of them, or wait for lines that never come."""
    size = os.path.getsize(path)
    with open(path, "rb") as file:
        text = file.read()
    for section in (b"$Nodes", b"$Elements", b"$Entities", b"$PhysicalNames"):
        start = text.find(b"\n", text.find(section)) + 1 if section in text else -1
        line = text[start:text.find(b"\n", start)].split() if start > 0 else []
        if all(word.isdigit() for word in line):
            counts = [int(word[:30]) for word in line]
            counts = counts[:2] if section == b"$Nodes" or section == b"$Elements" else counts
        else:  # binary, of version 4
            counts = struct.unpack("<QQ", text[start:start + 16]) if len(text) >= start + 16 else []
        if counts and max(counts) > size:
            raise MeshError(f"{path}: {section.decode()} announces {max(counts):.6g}, more than a file of {size} bytes has")


def check_names_of(path, msh):
    """meshio keeps names in a dict: one name for a curve and a surface would lose one of them."""
    seen = {}
    for dimension, name in physical_names(path):
        if seen.setdefault(name, dimension) != dimension:
            raise MeshError(f"{path}: {name!r} names a physical {KIND[seen[name]]} and a physical "
                            f"{KIND[dimension]}, each needs a name of its own")
    if not members(msh, 2):
        raise MeshError(f"{path}: no elements in a named physical surface, so there are no groups "
                        '(in Gmsh: Physical Surface("dam") = {...};)')


def physical_names(path):
    """Returns (dimension, name) from the section $PhysicalNames, which is text in binary files too."""
    with open(path, "rb") as file:
        text = file.read()
    start = text.find(b"$PhysicalNames")
    lines = text[start:text.find(b"$EndPhysicalNames")].decode("utf-8", "replace").splitlines()[2:]
    words = [line.split(None, 2) for line in lines if line.strip()]
    return [(int(word[0]), word[2].strip().strip('"')) for word in words]


def members(msh, dimension):
    """Connectivity arrays of each named physical group of a dimension, in the order of the tags."""
    named = sorted((tag, name) for name, (tag, found) in msh.field_data.items() if found == dimension)
    found = {name: [block.data[cells] for block, cells in zip(msh.cells, chosen(msh, name, tag, dimension))
                    if len(cells)] for tag, name in named}
    return {name: cells for name, cells in found.items() if cells}


def chosen(msh, name, tag, dimension):
    """Per cell block the rows in a physical group: 4.1 has several to an entity, 2.2 repeats elements."""
    if name in msh.cell_sets:
        return msh.cell_sets[name]
    tags = msh.cell_data.get("gmsh:physical", [np.zeros(len(block.data)) for block in msh.cells])
    return [np.flatnonzero(tag == block_tags) if DIMENSION.get(block.type) == dimension else []
            for block, block_tags in zip(msh.cells, tags)]


# ---- the parts of the mesh -------------------------------------------------------------------------------

def bodies(msh, rigid):
    groups = members(msh, 2)
    unknown = [name for name in rigid if name not in groups]
    if unknown:
        raise MeshError(f"rigid group {unknown[0]!r}: no physical surface of that name, "
                        f"there are {', '.join(groups)}")
    if np.ptp(msh.points[:, 2]) > 1e-9 * np.ptp(msh.points[:, :2], axis=0).max():
        raise MeshError("the mesh is not plane: z varies, expected all nodes in one x, y plane")
    blocks, row = [], []
    for index, cells in enumerate(groups.values()):
        for data in cells:
            data = np.asarray(data, dtype=np.int64)
            blocks.append(np.pad(data, ((0, 0), (0, 4 - data.shape[1])), constant_values=-1))
            row.append(np.full(len(data), index))
    blocks, row = np.concatenate(blocks), np.concatenate(row)
    check_membership(msh, blocks, row, list(groups))
    mesh = BlockMesh(msh.points[:, :2], blocks, row, list(groups), [name in rigid for name in groups])
    turn_counter_clockwise(mesh)
    return mesh


def check_membership(msh, blocks, row, names):
    """Every surface element is in one named surface."""
    order = np.lexsort(np.sort(blocks, axis=1).T)
    same = np.flatnonzero((np.diff(np.sort(blocks, axis=1)[order], axis=0) == 0).all(axis=1))
    if len(same):
        one, two = row[order[same[0]]], row[order[same[0] + 1]]
        raise MeshError(f"surface {names[one]!r} and surface {names[two]!r} have elements in common")
    total = sum(len(block.data) for block in msh.cells if DIMENSION[block.type] == 2)
    if total > len(blocks):
        raise MeshError(f"{total - len(blocks)} surface elements are in no named physical surface")


def turn_counter_clockwise(mesh):
    """Surfaces may run either way in Gmsh; keep the first vertex, reverse the others."""
    turned = areas(mesh) < 0
    triangle = mesh.blocks[:, 3] < 0
    mesh.blocks[turned & triangle] = mesh.blocks[turned & triangle][:, [0, 2, 1, 3]]
    mesh.blocks[turned & ~triangle] = mesh.blocks[turned & ~triangle][:, [0, 3, 2, 1]]


def single_vertex(name, cells):
    vertices = np.unique(np.concatenate(cells))
    if len(vertices) != 1:
        raise MeshError(f"physical point {name!r}: has {len(vertices)} points, expected one")
    return int(vertices[0])


def without_unused(mesh, edges, points):
    """Drop nodes that no block uses (centres of arcs, say) and renumber what refers to them."""
    used = np.zeros(len(mesh.vertices), dtype=bool)
    used[mesh.blocks[mesh.blocks >= 0]] = True
    number = np.where(used, np.cumsum(used) - 1, -1)
    for name, vertex in points.items():
        if not used[vertex]:
            raise MeshError(f"physical point {name!r} at {xy_text(mesh.vertices[vertex])}: no block uses it")
    for name, pairs in edges.items():
        if not used[pairs].all():
            raise MeshError(f"physical curve {name!r}: does not lie on the blocks")
    mesh.vertices = mesh.vertices[used]
    mesh.blocks = np.where(mesh.blocks < 0, -1, number[mesh.blocks]).astype(np.int32)
    return (mesh, {name: number[pairs] for name, pairs in edges.items()},
            {name: int(number[vertex]) for name, vertex in points.items()})


def check_interface(mesh, name, pairs):
    """An interface has blocks on both sides, or there is nothing to open."""
    _, ends = all_faces(mesh)
    key, count = np.unique(edge_keys(mesh, ends), return_counts=True)
    wanted = edge_keys(mesh, pairs)
    sides = np.zeros(len(wanted), dtype=int)
    known = np.isin(wanted, key)
    sides[known] = count[np.searchsorted(key, wanted[known])]
    bad = np.flatnonzero(sides < 2)
    if len(bad):
        a, b = mesh.vertices[pairs[bad[0]]]
        raise MeshError(f"interface {name!r}: {sides[bad[0]]} blocks along its edge {xy_text(a)} to "
                        f"{xy_text(b)}, expected two (an outline is a boundary already)")


def check_outer(mesh, interfaces):
    """Curves inside a body cannot be face sets, nor can joints too short to open."""
    outer = {tuple(row) for row in outer_faces(mesh).tolist()}
    for name, rows in mesh.face_sets.items():
        if len(rows) == 0:
            raise MeshError(f"physical curve {name!r}: does not run along the edges of the blocks")
        if all(tuple(row) in outer for row in rows.tolist()):
            continue
        if name in interfaces:
            raise MeshError(f"interface {name!r}: an edge of it stays closed, both its ends are in one body")
        raise MeshError(f"physical curve {name!r}: runs inside a body, name it an interface or leave it out")


# ---- command line ----------------------------------------------------------------------------------------

def main(arguments=None):
    parser = Parser(prog="quoin import",
                                     description="Import a Gmsh .msh file (2.2, 4.1) as a block mesh.")
    parser.add_argument("msh")
    parser.add_argument("-o", "--output", required=True, help="block mesh to write")
    parser.add_argument("--interfaces", nargs="+", default=[], metavar="CURVE",
                        help="physical curves along which the vertices are doubled: joints")
    parser.add_argument("--unit", choices=list(UNITS), help="of its coordinates; default: m, where that makes a section of 0.1 to 5000 m")
    parser.add_argument("--rigid", nargs="+", default=[], metavar="SURFACE", help="groups of rigid blocks")
    options = parser.parse_args(arguments)
    try:
        mesh = import_msh(options.msh, options.interfaces, options.rigid, options.unit)
        component = check(mesh)
        write(options.output, mesh)
    except (MeshError, OSError) as error:
        print(words_of(error), file=sys.stderr)
        return 2
    width, height = size_of(mesh.vertices)
    print(f"wrote {options.output}: {len(mesh.blocks)} blocks, {len(mesh.vertices)} vertices, "
          f"{component.max() + 1} macroblocks; {width:.6g} m x {height:.6g} m{f', its coordinates in {options.unit}' if options.unit else ''}")
    if options.unit is None and max(width, height) > LARGE:
        print(f"warning: the mesh is {max(width, height):g} m across; where its coordinates are in mm or cm, give --unit", file=sys.stderr)
    return 0
