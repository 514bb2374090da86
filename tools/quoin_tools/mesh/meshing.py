"""Pieces for generators: spacing, patches, joining, triangles, doubled vertices, named faces."""

import numpy as np
import scipy

from quoin_tools.mesh.blockmesh import BlockMesh, MeshError, all_faces, closed_rings, edge_keys, face_ends, outer_faces

# ---- spacing and patches ---------------------------------------------------------------------------------

def graded(first, length, n):
    """n + 1 positions from 0 to length; the first interval is `first`, each next one longer by one ratio."""
    if n == 1:
        return np.array([0.0, length])
    if n < 1 or not 0 < first < length:
        raise MeshError(f"graded: {n} intervals over {length:g} m, the first of {first:g} m, is not possible")
    def excess(ratio):
        return first * np.sum(ratio ** np.arange(n)) - length
    # at the upper bound the last interval alone is the whole length
    ratio = scipy.optimize.brentq(excess, 0.0, (length / first) ** (1.0 / (n - 1)), xtol=1e-14)
    positions = np.concatenate([[0.0], np.cumsum(first * ratio ** np.arange(n))])
    positions[-1] = length  # not its rounded sum
    return positions


def structured(xy, group="body", rigid=False, reverse=False):
    """Mesh from nodes xy[j, i]: rows j upwards, blocks row by row from the bottom (from the top: reverse).

    Face sets bottom, right, top, left; vertices row by row."""
    rows, columns = xy.shape[0] - 1, xy.shape[1] - 1
    node = np.arange((rows + 1) * (columns + 1)).reshape(rows + 1, columns + 1)
    blocks = np.stack([node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1]], axis=2)
    index = np.arange(rows * columns).reshape(rows, columns)
    if reverse:
        blocks, index = blocks[::-1], index[::-1].copy()
    sides = {"bottom": (index[0], 0), "right": (index[:, -1], 1),
             "top": (index[-1], 2), "left": (index[:, 0], 3)}
    sets = {name: np.column_stack([block, np.full(len(block), k)]) for name, (block, k) in sides.items()}
    return BlockMesh(xy.reshape(-1, 2), blocks.reshape(-1, 4), np.zeros(rows * columns), [group],
                     [int(rigid)], sets)


def ruled(bottom, top, s):
    """Returns nodes xy[j, i] on the straight lines from bottom[i] to top[i] at the fractions s[j] (0 to 1)."""
    s = np.asarray(s, dtype=float)[:, None, None]
    return (1.0 - s) * np.asarray(bottom, dtype=float) + s * np.asarray(top, dtype=float)


def line(start, end, n):
    """n + 1 points, or rows of points, at equal steps; the ends are kept, and from -4 to 8 a third of the way is 0, no 4e-16."""
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    i = np.arange(1, n).reshape(-1, *[1] * start.ndim)
    return np.concatenate([start[None], (start * (n - i) + end * i) / n, end[None]])


def quad_patch(bottom_left, bottom_right, top_right, top_left, nx, ny, group="body", rigid=False):
    """nx by ny blocks mapped on a quadrilateral; face sets bottom, right, top, left; corner points."""
    xy = line(line(bottom_left, bottom_right, nx), line(top_left, top_right, nx), ny)
    mesh = structured(xy, group, rigid)
    last = len(mesh.vertices) - 1
    mesh.points = {"bottom_left": 0, "bottom_right": nx, "top_left": last - nx, "top_right": last}
    return mesh


def rectangle(x, y, width, height, nx=1, ny=1, group="body", rigid=False):
    """A quad_patch with its lower left corner at (x, y)."""
    right, top = x + width, y + height
    return quad_patch((x, y), (right, y), (right, top), (x, top), nx, ny, group, rigid)


# ---- whole meshes ----------------------------------------------------------------------------------------

def join(meshes):
    """One mesh of several, each its own macroblocks; groups and face sets of one name are united."""
    names, rigid, sets, points = [], [], {}, {}
    vertices, blocks, groups = [], [], []
    vertex_start = block_start = 0
    for mesh in meshes:
        for name, flag in zip(mesh.group_names, mesh.group_rigid):
            if name not in names:
                names.append(name)
                rigid.append(flag)
            elif rigid[names.index(name)] != flag:
                raise MeshError(f"group {name!r}: rigid in one mesh, deformable in another")
        row = np.array([names.index(name) for name in mesh.group_names])
        vertices.append(mesh.vertices)
        blocks.append(np.where(mesh.blocks < 0, -1, mesh.blocks + vertex_start))
        groups.append(row[mesh.block_group])
        for name, rows in mesh.face_sets.items():
            sets.setdefault(name, []).append(rows + [block_start, 0])
        for name, vertex in mesh.points.items():
            if name in points:
                raise MeshError(f"point {name!r}: in two of the meshes to join")
            points[name] = vertex + vertex_start
        vertex_start += len(mesh.vertices)
        block_start += len(mesh.blocks)
    return BlockMesh(np.concatenate(vertices), np.concatenate(blocks), np.concatenate(groups), names, rigid,
                     {name: np.concatenate(rows) for name, rows in sets.items()}, points)


def renamed(mesh, faces=None, points=None):
    """Returns the mesh with only the face sets and points of the dicts (new name: old name)."""
    return BlockMesh(mesh.vertices, mesh.blocks, mesh.block_group, mesh.group_names, mesh.group_rigid,
                     {new: mesh.face_sets[old] for new, old in (faces or {}).items()},
                     {new: mesh.points[old] for new, old in (points or {}).items()})


def without_groups(mesh, names):
    """Returns the mesh without the blocks of these groups; groups and face sets keep their names, though some become empty."""
    there = ~np.isin(mesh.block_group, [row for row, name in enumerate(mesh.group_names) if name in names])
    used = np.zeros(len(mesh.vertices), dtype=bool)
    used[mesh.blocks[there][mesh.blocks[there] >= 0]] = True
    vertex, block = np.cumsum(used) - 1, np.cumsum(there) - 1
    kept = {name: rows[there[rows[:, 0]]] for name, rows in mesh.face_sets.items()}
    return BlockMesh(mesh.vertices[used], np.where(mesh.blocks[there] < 0, -1, vertex[mesh.blocks[there]]), mesh.block_group[there], mesh.group_names, mesh.group_rigid,
                     {name: np.column_stack([block[rows[:, 0]], rows[:, 1]]) for name, rows in kept.items()},
                     {name: vertex[at] for name, at in mesh.points.items() if used[at]})  # fmt: skip


def split_triangles(mesh, select=None):
    """Each quadrilateral (of those selected by a mask) as two triangles along its diagonal 0-2, in place."""
    split = mesh.blocks[:, 3] >= 0
    if select is not None:
        split &= np.asarray(select, dtype=bool)
    first = np.arange(len(mesh.blocks)) + np.concatenate([[0], np.cumsum(split)[:-1]])
    blocks = np.empty((len(mesh.blocks) + split.sum(), 4), dtype=np.int32)
    blocks[first] = mesh.blocks
    blocks[first[split], 3] = -1
    blocks[first[split] + 1, :3] = mesh.blocks[split][:, [0, 2, 3]]
    blocks[first[split] + 1, 3] = -1

    # faces 2 and 3 of the quadrilateral are faces 1 and 2 of the second triangle
    sets = {}
    for name, rows in mesh.face_sets.items():
        second = split[rows[:, 0]] & (rows[:, 1] >= 2)
        sets[name] = np.column_stack([first[rows[:, 0]] + second, rows[:, 1] - second])
    return BlockMesh(mesh.vertices, blocks, np.repeat(mesh.block_group, 1 + split), mesh.group_names,
                     mesh.group_rigid, sets, dict(mesh.points))


# ---- joints ----------------------------------------------------------------------------------------------

def double_vertices(mesh, edges):
    """Open a joint along edges (pairs of vertices): each vertex on them gets one copy per fan of blocks.

    A fan is what can be walked round the vertex without crossing an edge of the joint. A joint that ends
    inside a body leaves one fan there, so its end stays single; a T-junction has three. The fan of the
    lowest block keeps the vertex, and the named points with it."""
    interface = np.unique(edge_keys(mesh, edges))
    inside = np.zeros(len(mesh.vertices), dtype=bool)
    inside[np.asarray(edges).ravel()] = True
    pieces = corner_pieces(mesh, interface)

    # corner by corner in block order: the first piece at a vertex keeps its number, others get new ones
    corner = np.flatnonzero((mesh.blocks >= 0).ravel() & inside[mesh.blocks.ravel()])
    old = mesh.blocks.ravel()[corner]
    _, at, piece = np.unique(pieces[corner], return_index=True, return_inverse=True)
    order = np.argsort(at)
    owner = old[at[order]]
    keeps = np.zeros(len(owner), dtype=bool)
    keeps[np.unique(owner, return_index=True)[1]] = True
    number = np.empty(len(owner), dtype=np.int64)
    number[order] = np.where(keeps, owner, len(mesh.vertices) + np.cumsum(~keeps) - 1)
    blocks = mesh.blocks.ravel().copy()
    blocks[corner] = number[piece]
    vertices = np.concatenate([mesh.vertices, mesh.vertices[owner[~keeps]]])
    return BlockMesh(vertices, blocks.reshape(-1, 4), mesh.block_group, mesh.group_names, mesh.group_rigid,
                     dict(mesh.face_sets), dict(mesh.points))


def separated(mesh, groups):
    """Each block of the groups a macroblock of its own, as `macroblocks: false` of their materials makes it, vertex for vertex.

    A vertex stays with blocks of other groups, or else with the first block that has it; the others get copies behind the rest."""
    mine = np.isin(mesh.block_group, [mesh.group_names.index(name) for name in groups])
    corner = np.flatnonzero((mesh.blocks >= 0).ravel() & np.repeat(mine, 4))
    old = mesh.blocks.ravel()[corner]
    keeps = np.zeros(len(old), dtype=bool)
    keeps[np.unique(old, return_index=True)[1]] = True
    keeps &= ~np.isin(old, mesh.blocks[~mine])
    blocks = mesh.blocks.ravel().copy()
    blocks[corner] = np.where(keeps, old, len(mesh.vertices) + np.cumsum(~keeps) - 1)
    return BlockMesh(np.concatenate([mesh.vertices, mesh.vertices[old[~keeps]]]), blocks.reshape(-1, 4), mesh.block_group,
                     mesh.group_names, mesh.group_rigid, dict(mesh.face_sets), dict(mesh.points))  # fmt: skip


def corner_pieces(mesh, interface):
    """Label of each corner (4 block + k): corners are joined where their blocks share a face, not a joint."""
    faces, ends = all_faces(mesh)
    key = edge_keys(mesh, ends)
    order = np.argsort(key, kind="stable")
    order = order[~np.isin(key[order], interface)]
    one, two = order[:-1], order[1:]
    same = key[one] == key[two]
    one, two = one[same], two[same]
    corners = np.where(mesh.blocks[faces[:, 0], 3] < 0, 3, 4)
    start = 4 * faces[:, 0].astype(np.int64) + faces[:, 1]
    end = 4 * faces[:, 0].astype(np.int64) + (faces[:, 1] + 1) % corners
    # two neighbours run along their face in opposite directions
    rows, columns = np.concatenate([start[one], end[one]]), np.concatenate([end[two], start[two]])
    size = mesh.blocks.size
    graph = scipy.sparse.coo_matrix((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(size, size))
    return scipy.sparse.csgraph.connected_components(graph, directed=False)[1]


def faces_on_edges(mesh, edges):
    """Faces (block, k) that run along the edges, both sides, in block order."""
    faces, ends = all_faces(mesh)
    return faces[np.isin(edge_keys(mesh, ends), edge_keys(mesh, edges))]


# ---- names -----------------------------------------------------------------------------------------------

def face_set_where(mesh, predicate, group=None):
    """Outer faces, both of whose ends satisfy predicate(x, y) (arrays), of one group if given."""
    faces = outer_faces(mesh)
    if group is not None:
        faces = faces[mesh.block_group[faces[:, 0]] == mesh.group_names.index(group)]
    fits = predicate(mesh.vertices[:, 0], mesh.vertices[:, 1])
    return faces[fits[face_ends(mesh, faces)].all(axis=1)]


def face_set_on(mesh, a, b, tolerance=1e-6, group=None):
    """Outer faces on the segment from a to b, of one group if given."""
    a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    length = np.hypot(*(b - a))
    along = (b - a) / length
    def on_segment(x, y):
        t = (x - a[0]) * along[0] + (y - a[1]) * along[1]
        off = (x - a[0]) * along[1] - (y - a[1]) * along[0]
        return (np.abs(off) <= tolerance) & (t >= -tolerance) & (t <= length + tolerance)
    return face_set_where(mesh, on_segment, group)


def vertex_at(mesh, x, y, group=None, tolerance=1e-6):
    """Lowest vertex at (x, y), of one group if given."""
    here = np.hypot(mesh.vertices[:, 0] - x, mesh.vertices[:, 1] - y) <= tolerance
    if group is not None:
        mine = np.zeros(len(mesh.vertices), dtype=bool)
        mine[closed_rings(mesh)[mesh.block_group == mesh.group_names.index(group)]] = True
        here &= mine
    found = np.flatnonzero(here)
    if len(found) == 0:
        raise MeshError(f"no vertex at ({x:g}, {y:g})" + (f" in group {group!r}" if group else ""))
    return int(found[0])
