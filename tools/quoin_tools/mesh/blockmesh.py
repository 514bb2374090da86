"""Reads, writes and checks the block mesh `model.h5` (docs/mesh_format.md): the only Python module that knows the format.

    quoin check model.h5          summary, exit 0; or one line on stderr, exit 2
    quoin check model.h5 --info   summary without the checks of the content
"""

import os
import re
import sys
from dataclasses import dataclass, field

import h5py
import numpy as np
import scipy
import shapely

from quoin_tools.base.command import Parser
from quoin_tools.base.files import writing
from quoin_tools.base.integrity import UNREADABLE

FORMAT = b"quoin-mesh"
VERSION = 1
NAME_SIZE = 64
MOST_PACKED = 1100  # bytes that one byte of a compressed dataset may become (deflate: 1032)
TOLERANCE = 0.005  # depth [m] by which two macroblocks may overlap
SLIVER = 1e6  # aspect ratio beyond which a block is refused
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,62}\Z")
DATASETS = {  # name: (kind and size of the type, its name in messages, columns or None)
    "vertices": ("f8", "float64", 2),
    "blocks": ("i4", "int32", 4),
    "block_group": ("i4", "int32", None),
    "groups/name": ("S64", "fixed-length bytes S64", None),
    "groups/rigid": ("i4", "int32", None),
}


class MeshError(ValueError):
    """A mesh or its file is wrong; the message is one line."""


@dataclass
class BlockMesh:
    """Vertices [m], blocks (ccw, -1 in the fourth column of a triangle), groups, named faces and vertices."""

    vertices: np.ndarray  # (nv, 2)
    blocks: np.ndarray  # (nb, 4) vertices of each block
    block_group: np.ndarray  # (nb,) row of group_names
    group_names: list[str]
    group_rigid: np.ndarray  # (n groups,) 1: rigid
    face_sets: dict[str, np.ndarray] = field(default_factory=dict)  # (n, 2) block and its face k, from vertex k to the next
    points: dict[str, int] = field(default_factory=dict)  # vertex of each name

    def __post_init__(self):
        self.vertices = np.asarray(self.vertices, dtype=np.float64).reshape(-1, 2)
        self.blocks = np.asarray(self.blocks, dtype=np.int32).reshape(-1, 4)
        self.block_group = np.asarray(self.block_group, dtype=np.int32).reshape(-1)
        self.group_names = [str(name) for name in self.group_names]
        self.group_rigid = np.asarray(self.group_rigid, dtype=np.int32).reshape(-1)
        self.face_sets = {name: np.asarray(rows, dtype=np.int32).reshape(-1, 2)
                          for name, rows in self.face_sets.items()}
        self.points = {name: int(vertex) for name, vertex in self.points.items()}

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes model.h5. MeshError: what docs/mesh_format.md refuses; nothing is written then."""
        check(self)
        write(path, self)

    def centres(self):
        """Mean of the vertices of each block."""
        ring, triangle = closed_rings(self), self.blocks[:, 3] < 0
        total = self.vertices[ring].sum(axis=1)
        total[triangle] -= self.vertices[ring[triangle, 3]]
        return total / np.where(triangle, 3, 4)[:, None]


# ---- topology ----------------------------------------------------------------------------------------------

def closed_rings(mesh):
    """Blocks as four vertices: a triangle repeats its first one."""
    return np.where(mesh.blocks < 0, mesh.blocks[:, :1], mesh.blocks)


def all_faces(mesh):
    """Every face of every block: rows (block, k) and their (first, second) vertex, in block order."""
    ring = closed_rings(mesh)
    ends = np.stack([ring, np.roll(ring, -1, axis=1)], axis=2)
    # the fourth face of a triangle would run from its first vertex to itself
    real = np.ones(mesh.blocks.shape, dtype=bool)
    real[:, 3] = mesh.blocks[:, 3] >= 0
    block, k = np.nonzero(real)
    return np.column_stack([block, k]).astype(np.int32), ends[real]


def edge_keys(mesh, ends):
    """One integer per edge, the same for both directions."""
    ends = np.sort(np.asarray(ends, dtype=np.int64).reshape(-1, 2), axis=1)
    return ends[:, 0] * len(mesh.vertices) + ends[:, 1]


def outer_faces(mesh):
    """Returns rows (block, k) of the faces that only one block uses: the boundaries of the macroblocks."""
    faces, ends = all_faces(mesh)
    _, index, count = np.unique(edge_keys(mesh, ends), return_inverse=True, return_counts=True)
    return faces[count[index] == 1]


def face_ends(mesh, faces):
    """First and second vertex of the faces (block, k)."""
    faces = np.asarray(faces, dtype=np.int64).reshape(-1, 2)
    ring = closed_rings(mesh)
    corners = np.where(mesh.blocks[faces[:, 0], 3] < 0, 3, 4)
    following = (faces[:, 1] + 1) % corners
    return np.column_stack([ring[faces[:, 0], faces[:, 1]], ring[faces[:, 0], following]])


def macroblocks(mesh):
    """Component of each block: blocks that share a vertex are one macroblock; numbered in block order."""
    ring = closed_rings(mesh)
    rows, columns = np.repeat(ring[:, 0], 3), ring[:, 1:].ravel()
    size = len(mesh.vertices)
    graph = scipy.sparse.coo_matrix((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(size, size))
    label = scipy.sparse.csgraph.connected_components(graph, directed=False)[1][ring[:, 0]]
    _, first, index = np.unique(label, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int32)
    rank[np.argsort(first)] = np.arange(len(first), dtype=np.int32)
    return rank[index]


def areas(mesh):
    """Signed area of each block [m2], positive when counter-clockwise."""
    xy = mesh.vertices[closed_rings(mesh)]
    d1, d2 = xy[:, 2] - xy[:, 0], xy[:, 3] - xy[:, 1]
    return 0.5 * cross(d1, d2)


def cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


# ---- file --------------------------------------------------------------------------------------------------

def write(path, mesh):
    """Writes a block mesh; makes its folder where it is missing, as for results."""
    check_names(mesh)  # a slash in a name would make a group of its own
    with writing(path) as file:
        fill(file, mesh)


def fill(file, mesh):
    file.attrs["format"] = np.bytes_(FORMAT)
    file.attrs["version"] = np.int32(VERSION)
    put(file, "vertices", mesh.vertices)
    put(file, "blocks", mesh.blocks)
    put(file, "block_group", mesh.block_group)
    put(file, "groups/name", np.array([name.encode() for name in mesh.group_names], dtype=f"S{NAME_SIZE}"))
    put(file, "groups/rigid", mesh.group_rigid)
    for name in sorted(mesh.face_sets):
        put(file, f"face_sets/{name}", np.asarray(mesh.face_sets[name], dtype=np.int32).reshape(-1, 2))
    for name in sorted(mesh.points):
        put(file, f"points/{name}", np.array([mesh.points[name]], dtype=np.int32))


def put(file, name, data):
    """A dataset with a checksum, which every reader checks."""
    data = np.asarray(data)
    file.create_dataset(name, data=data, fletcher32=data.size > 0)


def read(path):
    """Read a file; refuses what is not a block mesh of version 1. The content is for `check`."""
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        missing = not os.path.exists(path)
        reason = "no such file" if missing else f"not a whole HDF5 file ({' '.join(str(error).split())})"
        raise MeshError(f"{path}: {reason}") from None
    try:
        with file:
            return parse(file)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from None
    except UNREADABLE as error:  # damaged inside
        raise MeshError(f"{path}: cannot be read ({type(error).__name__}: {' '.join(str(error).split())})") from None


def parse(file):
    check_header(file)
    rows = {name: len(inspected(file, name, *expected)) for name, expected in DATASETS.items()}  # before anything large is read
    for one, other in (("block_group", "blocks"), ("groups/rigid", "groups/name")):
        if rows[one] != rows[other]:
            raise MeshError(f"/{one} has {rows[one]} rows, /{other} has {rows[other]}")
    if rows["vertices"] // 4 > rows["blocks"]:
        raise MeshError(f"{rows['vertices']} vertices are too many for {rows['blocks']} blocks: some vertex is in no block")
    data = {name: dataset(file, name, *expected) for name, expected in DATASETS.items()}
    face_sets = {name: dataset(file, f"face_sets/{name}", "i4", "int32", 2)
                 for name in members(file, "face_sets")}
    points = {}
    for name in members(file, "points"):
        vertex = dataset(file, f"points/{name}", "i4", "int32", None)
        if len(vertex) != 1:
            raise MeshError(f"/points/{name} has shape {vertex.shape}, expected (1,)")
        points[name] = vertex[0]
    names = [name.decode("ascii", "replace") for name in data["groups/name"]]
    return BlockMesh(data["vertices"], data["blocks"], data["block_group"], names, data["groups/rigid"],
                     face_sets, points)


def check_header(file):
    found, version = file.attrs.get("format"), file.attrs.get("version")
    if not isinstance(found, bytes) or found != FORMAT:
        raise MeshError(f"attribute format is {found!r}, expected {FORMAT!r} in fixed-length bytes")
    if not np.issubdtype(np.asarray(version).dtype, np.integer) or np.any(np.asarray(version) != VERSION):
        raise MeshError(f"attribute version is {version!r}, expected the integer {VERSION}")


def dataset(file, name, kind, kind_name, columns):
    return inspected(file, name, kind, kind_name, columns)[()]


def inspected(file, name, kind, kind_name, columns):
    """A dataset of the right type and shape, not yet read."""
    item = file.get(name)
    if not isinstance(item, h5py.Dataset):
        raise MeshError(f"dataset /{name} is missing")
    wanted = np.dtype(kind)
    if (item.dtype.kind, item.dtype.itemsize) != (wanted.kind, wanted.itemsize):
        raise MeshError(f"/{name} is of type {item.dtype}, expected {kind_name}")
    shape = item.shape or ()
    if len(shape) != (1 if columns is None else 2) or (columns is not None and shape[1] != columns):
        expected = "(n,)" if columns is None else f"(n, {columns})"
        raise MeshError(f"/{name} has shape {shape}, expected {expected}")
    if item.nbytes > MOST_PACKED * item.id.get_storage_size():
        raise MeshError(f"/{name}: its data are not in the file")
    return item


def members(file, name):
    group = file.get(name)
    if group is None:
        return []
    if not isinstance(group, h5py.Group):
        raise MeshError(f"/{name} is not a group")
    return list(group)


# ---- check -------------------------------------------------------------------------------------------------

def check(mesh, tolerance=TOLERANCE):
    """Raise MeshError for the first thing mesh_format.md refuses; return the macroblock of each block."""
    check_names(mesh)
    check_vertices(mesh)
    check_blocks(mesh)
    check_shapes(mesh)
    check_sets(mesh)
    component = macroblocks(mesh)
    check_overlap(mesh, component, tolerance)
    return component


def check_names(mesh):
    named = ([("group", name) for name in mesh.group_names] + [("face set", name) for name in mesh.face_sets]
             + [("point", name) for name in mesh.points])
    for kind, name in named:
        if not NAME.match(name):
            raise MeshError(f"{kind} {name!r}: a name is a letter, then letters, digits, _ or -, "
                            "at most 63 characters")
    for row, name in enumerate(mesh.group_names):
        if mesh.group_names.index(name) < row:
            raise MeshError(f"group {row}: the name {name!r} is taken by "
                            f"group {mesh.group_names.index(name)}")
    if len(mesh.group_rigid) != len(mesh.group_names):
        raise MeshError(f"{len(mesh.group_names)} group names but {len(mesh.group_rigid)} rigid flags")
    for name, flag in zip(mesh.group_names, mesh.group_rigid):
        if flag not in (0, 1):
            raise MeshError(f"group {name!r}: rigid is {flag}, expected 0 or 1")


def first(mask):
    """Index of the first true entry, None when there is none."""
    found = np.flatnonzero(mask)
    return int(found[0]) if len(found) else None


def check_vertices(mesh):
    bad = first(~np.isfinite(mesh.vertices).all(axis=1))
    if bad is not None:
        raise MeshError(f"vertex {bad}: coordinates {xy_text(mesh.vertices[bad])} are not finite")


def check_blocks(mesh):
    blocks, size, groups = mesh.blocks, len(mesh.vertices), len(mesh.group_names)
    if len(blocks) == 0:
        raise MeshError("the mesh has no blocks")
    if len(mesh.block_group) != len(blocks):
        raise MeshError(f"{len(blocks)} blocks but {len(mesh.block_group)} entries in block_group")
    lowest = np.array([0, 0, 0, -1])
    bad = first(((blocks < lowest) | (blocks >= size)).any(axis=1))
    if bad is not None:
        raise MeshError(f"block {bad}: vertices {blocks[bad].tolist()} are not all in 0..{size - 1} "
                        "(-1 only in the fourth column)")
    bad = first((np.diff(np.sort(blocks, axis=1), axis=1) == 0).any(axis=1))
    if bad is not None:
        raise MeshError(f"block {bad}: a vertex is repeated in {blocks[bad].tolist()}")
    bad = first((mesh.block_group < 0) | (mesh.block_group >= groups))
    if bad is not None:
        raise MeshError(f"block {bad}: group row {mesh.block_group[bad]} does not exist, "
                        f"expected 0..{groups - 1}")
    used = np.zeros(size, dtype=bool)
    used[closed_rings(mesh)] = True
    bad = first(~used)
    if bad is not None:
        raise MeshError(f"vertex {bad} at {xy_text(mesh.vertices[bad])}: no block uses it")


@np.errstate(over="ignore", invalid="ignore")  # absurd coordinates: refused, without a warning
def check_shapes(mesh):
    area = areas(mesh)
    xy = mesh.vertices[closed_rings(mesh)]
    edge = np.roll(xy, -1, axis=1) - xy
    smallest = 1e-12 * (edge ** 2).sum(axis=2).max(axis=1)  # rounding, relative to the block's own size
    bad = first(~(np.abs(area) > smallest))
    if bad is not None:
        raise MeshError(f"block {bad} at {xy_text(xy[bad, 0])}: its area is zero")
    bad = first(area < 0)
    if bad is not None:
        raise MeshError(f"block {bad} at {xy_text(xy[bad, 0])}: inverted, its vertices run clockwise "
                        f"(area {area[bad]:.6g} m2)")
    turn = cross(np.roll(edge, 1, axis=1), edge)
    corner = first((turn < -smallest[:, None]).ravel())  # a straight corner is convex still
    if corner is not None:
        block, k = divmod(corner, 4)
        raise MeshError(f"block {block}: not convex at its vertex {mesh.blocks[block, k]} "
                        f"{xy_text(xy[block, k])}")
    length = np.hypot(edge[..., 0], edge[..., 1])
    closing = mesh.blocks[:, 3] < 0  # of a triangle: no edge
    shortest = np.where(np.arange(4) < np.where(closing, 3, 4)[:, None], length, np.inf).min(axis=1)
    longest = length.max(axis=1)
    ratio = np.maximum(longest ** 2 / np.where(closing, 2 * area, area), longest / shortest)
    bad = first(ratio > SLIVER)
    if bad is not None:
        raise MeshError(f"block {bad} at {xy_text(xy[bad, 0])}: a sliver of aspect ratio {ratio[bad]:.3g}, "
                        f"expected at most {SLIVER:g}")
    check_edges(mesh)


def check_edges(mesh):
    """Neighbours run along a shared edge in opposite directions, or they lie on top of each other."""
    faces, ends = all_faces(mesh)
    directed = ends[:, 0].astype(np.int64) * len(mesh.vertices) + ends[:, 1]
    order = np.argsort(directed, kind="stable")
    twice = first(directed[order[1:]] == directed[order[:-1]])
    if twice is not None:
        one, two = faces[order[twice], 0], faces[order[twice + 1], 0]
        a, b = ends[order[twice]]
        raise MeshError(f"block {two}: lies on the same side of the face {a}-{b} as block {one}")


def check_sets(mesh):
    outer = outer_faces(mesh)
    boundary = np.zeros((len(mesh.blocks), 4), dtype=bool)
    boundary[outer[:, 0], outer[:, 1]] = True
    corners = np.where(mesh.blocks[:, 3] < 0, 3, 4)
    for name, rows in mesh.face_sets.items():
        bad = first((rows[:, 0] < 0) | (rows[:, 0] >= len(mesh.blocks)))
        if bad is not None:
            raise MeshError(f"face set {name!r}, row {bad}: block {rows[bad, 0]} does not exist, "
                            f"expected 0..{len(mesh.blocks) - 1}")
        bad = first((rows[:, 1] < 0) | (rows[:, 1] >= corners[rows[:, 0]]))
        if bad is not None:
            block, k = rows[bad]
            raise MeshError(f"face set {name!r}, row {bad}: block {block} has no face {k}, "
                            f"expected 0..{corners[block] - 1}")
        key = rows[:, 0].astype(np.int64) * 4 + rows[:, 1]
        order = np.argsort(key, kind="stable")
        bad = first(key[order[1:]] == key[order[:-1]])
        if bad is not None:
            block, k = rows[order[bad]]
            raise MeshError(f"face set {name!r}: face {k} of block {block} is listed twice")
        bad = first(~boundary[rows[:, 0], rows[:, 1]])
        if bad is not None:
            block, k = rows[bad]
            raise MeshError(f"face set {name!r}, row {bad}: face {k} of block {block} is inside "
                            "its macroblock, expected a face on the boundary")
    for name, vertex in mesh.points.items():
        if not 0 <= vertex < len(mesh.vertices):
            raise MeshError(f"point {name!r}: vertex {vertex} does not exist, "
                            f"expected 0..{len(mesh.vertices) - 1}")


def check_overlap(mesh, component, tolerance):
    """Refuse blocks of two macroblocks that interpenetrate deeper than the tolerance."""
    if component.max() == 0:
        return
    one, two = near_pairs(mesh, component, tolerance)
    for start in range(0, len(one), 500_000):  # in pieces, to bound the memory
        a, b = one[start:start + 500_000], two[start:start + 500_000]
        depth = overlap_depth(mesh, a, b)
        bad = first(depth > tolerance)
        if bad is not None:
            raise MeshError(f"block {a[bad]} and block {b[bad]}: their macroblocks overlap by "
                            f"{depth[bad]:.4g} m at {xy_text(mesh.centres()[a[bad]])}, "
                            f"expected at most {tolerance:g} m")


def near_pairs(mesh, component, tolerance):
    """Pairs of blocks of different macroblocks whose boxes overlap by more than the tolerance in x and in y.

    One of two bodies that overlap has an outer block in the other, so only outer blocks ask."""
    xy = mesh.vertices[closed_rings(mesh)]
    low, high = xy.min(axis=1), xy.max(axis=1)
    shrink = np.minimum(0.5 * tolerance, 0.49 * (high - low))
    boxes = shapely.box(*(low + shrink).T, *(high - shrink).T)
    outer = np.unique(outer_faces(mesh)[:, 0])
    asking, found = shapely.STRtree(boxes).query(boxes[outer])
    asking = outer[asking]
    other = component[asking] != component[found]
    return np.unique(np.sort(np.column_stack([asking[other], found[other]]), axis=1), axis=0).T


def overlap_depth(mesh, one, two):
    """Separating axes: the least overlap over the face normals of both convex blocks (negative: a gap)."""
    ring = closed_rings(mesh)
    depth = np.full(len(one), np.inf)
    for first_blocks in (one, two):
        corners = mesh.vertices[ring[first_blocks]]
        for k in range(4):
            edge = corners[:, (k + 1) % 4] - corners[:, k]
            length = np.hypot(edge[:, 0], edge[:, 1])
            normal = np.column_stack([edge[:, 1], -edge[:, 0]]) / np.where(length > 0, length, 1)[:, None]
            a = np.einsum("nij,nj->ni", mesh.vertices[ring[one]], normal)
            b = np.einsum("nij,nj->ni", mesh.vertices[ring[two]], normal)
            overlap = np.minimum(a.max(axis=1), b.max(axis=1)) - np.maximum(a.min(axis=1), b.min(axis=1))
            # a triangle closes with an edge of no length
            depth = np.where(length > 0, np.minimum(depth, overlap), depth)
    return depth


# ---- command line ------------------------------------------------------------------------------------------

def xy_text(xy):
    return f"({xy[0]:.6g}, {xy[1]:.6g})"


def quality(mesh):
    """Smallest angle [degrees], largest ratio of the sides of a block, and the vertex with that angle."""
    _, ends = all_faces(mesh)
    length = np.hypot(*(mesh.vertices[ends[:, 1]] - mesh.vertices[ends[:, 0]]).T)
    counts = np.where(mesh.blocks[:, 3] < 0, 3, 4)
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    aspect = np.maximum.reduceat(length, starts) / np.minimum.reduceat(length, starts)
    angles, where = [], []
    for corners in (3, 4):
        where.append(mesh.blocks[counts == corners][:, :corners].ravel())
        xy = mesh.vertices[where[-1]].reshape(-1, corners, 2)
        ahead, back = np.roll(xy, -1, axis=1) - xy, np.roll(xy, 1, axis=1) - xy
        angles.append(np.arctan2(cross(ahead, back), (ahead * back).sum(axis=2)).ravel())
    angles = np.degrees(np.concatenate(angles))
    return angles.min(), aspect.max(), np.concatenate(where)[angles.argmin()]


def summary(mesh):
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    triangles = int((mesh.blocks[:, 3] < 0).sum())
    angle, aspect, _ = quality(mesh)
    quads = len(mesh.blocks) - triangles
    lines = [f"blocks       {len(mesh.blocks)} ({quads} quadrilaterals, {triangles} triangles)",
             f"vertices     {len(mesh.vertices)}",
             f"macroblocks  {macroblocks(mesh).max() + 1}"]
    area = areas(mesh)
    for row, name in enumerate(mesh.group_names):
        mine = mesh.block_group == row
        kind = "rigid" if mesh.group_rigid[row] else "deformable"
        lines.append(f"group        {name}: {mine.sum()} blocks, {kind}, {area[mine].sum():.6g} m2")
    lines += [f"face set     {name}: {len(rows)} faces" for name, rows in sorted(mesh.face_sets.items())]
    lines += [f"point        {name}: vertex {vertex} at {xy_text(mesh.vertices[vertex])} m"
              for name, vertex in sorted(mesh.points.items())]
    lines += [f"bounding box {xy_text(low)} to {xy_text(high)} m",
              f"worst block  smallest angle {angle:.1f} degrees, longest side / shortest {aspect:.2f}"]
    return "\n".join(lines)


def main(arguments):
    words = ["--info" if word == "info" else word for word in arguments if word != "check"]  # `check FILE` and `info FILE` of earlier versions
    parser = Parser(prog="quoin check", description="Checks a block mesh and prints a summary of it.")
    parser.add_argument("file", help="block mesh")
    parser.add_argument("--info", action="store_true", help="only the summary, without the checks of the content")
    parser.add_argument("--tolerance", type=float, default=TOLERANCE,
                        help="overlap allowed [m] (%(default)s)")
    options = parser.parse_args(words)
    try:
        mesh = read(options.file)
        if options.info:  # a summary needs indices it can follow
            check_blocks(mesh)
        else:
            check(mesh, options.tolerance)
    except MeshError as error:
        print(error, file=sys.stderr)
        return 2
    print(summary(mesh))
    return 0
