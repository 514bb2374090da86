"""Tidies tessellations for generators: polygons on shared nodes, without short edges and slivers, and cuts them into blocks."""

import heapq
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
import shapely

from quoin_tools.mesh.blockmesh import MeshError, cross

INNER, LINE, FIXED = 0, 1, 2  # ranks of nodes: free, on the outline, stays where it is
GOOD = 35.0  # degrees: corners of blocks beyond are as good as any
LEAST = 5.0  # degrees: a convex quadrilateral with better corners is not cut
SHARP = 40.0  # degrees: corners of polygons that merging avoids


@dataclass
class Tessellation:
    """Nodes (n, 2) and polygons as rings of nodes, counter-clockwise; rank says how a node may move.

    While polygons are tidied, those that are gone are empty rings: `change` keeps `owner` and `users` with the rings."""

    nodes: np.ndarray
    rings: list
    rank: np.ndarray

    def polygons(self):
        return [self.nodes[ring] for ring in self.rings]

    @cached_property
    def owner(self):
        """Returns the polygon to the left of each directed edge."""
        return directed_edges(self.rings)

    @cached_property
    def users(self):
        """Returns the polygons at each node."""
        users = [set() for _ in self.nodes]
        for i, ring in enumerate(self.rings):
            for node in ring:
                users[node].add(i)
        return users

    @cached_property
    def changes(self):
        """Counts how often each polygon has been changed."""
        return [0] * len(self.rings)

    def compact(self):
        """Leaves empty rings out."""
        self.rings = [ring for ring in self.rings if ring]
        for kept in ("owner", "users", "changes"):
            self.__dict__.pop(kept, None)
        return self


# ---- building --------------------------------------------------------------------------------------------

def tessellation(polygons, anchors=(), tolerance=1e-6):
    """Nodes of polygons that fill an area without gaps; those of a neighbour on an edge become its nodes too.

    Anchors are nodes that stay; they come first and must lie on edges of the polygons."""
    anchors = np.asarray(anchors, dtype=float).reshape(-1, 2)
    points = np.concatenate([anchors, *polygons])
    pairs = scipy.spatial.cKDTree(points).query_pairs(tolerance, output_type="ndarray")
    graph = scipy.sparse.coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    label = scipy.sparse.csgraph.connected_components(graph, directed=False)[1]
    _, first, index = np.unique(label, return_index=True, return_inverse=True)
    order = np.argsort(first)  # nodes in the order in which they came
    number = np.empty(len(first), dtype=int)
    number[order] = np.arange(len(first))
    nodes, node = points[first[order]], number[index]
    starts = len(anchors) + np.concatenate([[0], np.cumsum([len(polygon) for polygon in polygons])])
    rings = [cleaned(node[a:b].tolist()) for a, b in zip(starts[:-1], starts[1:])]
    rings = with_hanging_nodes(nodes, [ring for ring in rings if ring], tolerance)
    rank = np.full(len(nodes), INNER)
    rank[np.unique(np.array(outline_edges(rings)))] = LINE
    rank[node[:len(anchors)]] = FIXED
    return Tessellation(nodes, rings, rank)


def with_hanging_nodes(nodes, rings, tolerance):
    """Rings with every node that lies on one of their edges."""
    corner, _, ahead = around(rings)
    a, b = nodes[corner], nodes[corner[ahead]]
    tree = shapely.STRtree(shapely.points(nodes))
    edge, near = tree.query(shapely.linestrings(np.stack([a, b], axis=1)), predicate="dwithin", distance=tolerance)
    inside = (near != corner[edge]) & (near != corner[ahead][edge])
    edge, near = edge[inside], near[inside]
    along = ((nodes[near] - a[edge]) * (b - a)[edge]).sum(axis=1)
    hanging = {}
    for at, t, node in zip(edge.tolist(), along.tolist(), near.tolist()):
        hanging.setdefault(at, []).append((t, node))
    result, at = [], 0
    for ring in rings:
        full = []
        for node in ring:
            full += [node] + [other for _, other in sorted(hanging.get(at, []))]
            at += 1
        result.append(full)
    return result


def around(rings):
    """Returns the nodes of all rings one after the other, and the place of the node before and after each."""
    count = np.array([len(ring) for ring in rings], dtype=int)
    start = np.cumsum(count) - count
    corner = np.fromiter((node for ring in rings for node in ring), dtype=int, count=count.sum())
    back, ahead = np.arange(len(corner)) - 1, np.arange(len(corner)) + 1
    back[start[count > 0]] = (start + count - 1)[count > 0]
    ahead[(start + count - 1)[count > 0]] = start[count > 0]
    return corner, back, ahead


def cleaned(ring):
    """Returns a ring without repetitions and spikes (a, b, a); empty when nothing is left of it."""
    ring, k = list(ring), 0
    while len(ring) >= 3 and k < len(ring):
        if ring[k] == ring[k - 1]:
            del ring[k]
            k = 0
        elif ring[k - 2] == ring[k]:
            del ring[k - 1]
            k = 0
        else:
            k += 1
    return ring if len(ring) >= 3 else []


def directed_edges(rings):
    """Edges (from, to) with the polygon on their left, and which one it is."""
    return {edge: i for i, ring in enumerate(rings) for edge in edges_of(ring)}


def edges_of(ring):
    return zip(ring, ring[1:] + ring[:1])


def outline_edges(rings):
    edges = directed_edges(rings)
    return [(a, b) for a, b in edges if (b, a) not in edges]


def inner_edges(rings):
    """Edges between two polygons, each once."""
    edges = directed_edges(rings)
    return sorted((a, b) for a, b in edges if a < b and (b, a) in edges)


def ring_of(polygon):
    """Corners of a polygon of shapely, counter-clockwise."""
    return np.array(shapely.geometry.polygon.orient(polygon).exterior.coords)[:-1]


def area(xy):
    x, y = np.asarray(xy).T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


# ---- tidying ---------------------------------------------------------------------------------------------

def tidy(tess, shortest, smallest, sharp=SHARP):
    """Merge edges shorter than `shortest`, give slivers and polygons below the area `smallest` to neighbours.

    Corners below `sharp` degrees are merged away where that is possible."""
    for _ in range(20):
        before = list(tess.rings)
        absorb(tess, 0.5 * shortest, smallest)
        straighten(tess)
        merge_short_edges(tess, shortest)
        blunt(tess, sharp)
        if tess.rings == before:
            break
    return tess.compact()


def change(tess, rings, moved=None):
    """Replace rings (dict: index to ring) if area is kept and all stay simple polygons; says which, or none."""
    old = sum(area(tess.nodes[tess.rings[i]]) for i in rings)
    place = moved and tess.nodes[moved[0]].copy()
    if moved:
        tess.nodes[moved[0]] = moved[1]
    if not fits(tess, rings, old):
        if moved:
            tess.nodes[moved[0]] = place
        return []
    for i, ring in rings.items():
        before, tess.rings[i] = tess.rings[i], ring
        tess.changes[i] += 1
        for edge in edges_of(before):
            if tess.owner.get(edge) == i:
                del tess.owner[edge]
        for node in before:
            tess.users[node].discard(i)
    for i, ring in rings.items():
        tess.owner.update(dict.fromkeys(edges_of(ring), i))
        for node in ring:
            tess.users[node].add(i)
    return list(rings)


def fits(tess, rings, old):
    """Tells whether the rings, with the nodes at their places, are simple polygons of the area `old`."""
    if any(len(set(ring)) < len(ring) for ring in rings.values()):
        return False
    kept = [tess.nodes[ring] for ring in rings.values() if ring]
    areas = [area(xy) for xy in kept]
    if abs(sum(areas) - old) > 1e-11 * old or min(areas, default=0) <= 0:
        return False
    return all(shapely.Polygon(xy).is_valid for xy in kept)


def merge(tess, choices, above=0.0):
    """The best of the choices (keep, drop, xy) that are possible: node drop becomes keep, which goes to xy.

    The first that leaves no corner sharper than SHARP, else the one with the least sharp corner, beyond `above`."""
    best = None
    for keep, drop, xy in choices:
        touched = {i: cleaned([keep if node == drop else node for node in tess.rings[i]])
                   for i in sorted(tess.users[keep] | tess.users[drop])}
        old, place = sum(area(tess.nodes[tess.rings[i]]) for i in touched), tess.nodes[keep].copy()
        tess.nodes[keep] = xy
        if fits(tess, touched, old):
            angle = min(corner_angles(tess.nodes[ring]).min() for ring in touched.values() if ring)
            if min(angle, SHARP) > (best[0] if best else above):
                best = min(angle, SHARP), touched, (keep, xy)
        tess.nodes[keep] = place
    return change(tess, *best[1:]) if best else []


def corner_angles(xy):
    """Inner angle at each corner of a polygon [degrees], 0 to 360."""
    return angles_between(np.roll(xy, -1, axis=0) - xy, np.roll(xy, 1, axis=0) - xy)


def angles_between(ahead, back):
    return np.degrees(np.arctan2(cross(ahead, back), (ahead * back).sum(axis=1))) % 360


def choices(tess, a, b):
    """Returns the choices to merge two nodes: the one of higher rank stays, two of the same rank meet halfway or at one."""
    keep, drop = (a, b) if tess.rank[a] >= tess.rank[b] else (b, a)
    here, there = tess.nodes[keep].copy(), tess.nodes[drop].copy()
    if tess.rank[drop] == FIXED:
        return []
    same = tess.rank[a] == tess.rank[b]
    return [(keep, drop, xy) for xy in ([0.5 * (here + there), here, there] if same else [here])]


def worst_first(tess, found, cure):
    """Cures what `found` finds in polygons (rows that begin with how bad it is), the least row first, each row once;
    polygons that a cure has changed are looked at again.

    found(polygons): rows (badness, ..., polygon) of these; cure(row): the polygons that it has changed."""
    tried = set()
    queue = [(*row, tess.changes[row[-1]]) for row in found(range(len(tess.rings)))]
    heapq.heapify(queue)
    while queue:
        *row, changes = heapq.heappop(queue)
        key = tuple(row[:-1])
        if changes != tess.changes[row[-1]] or key in tried:
            continue
        tried.add(key)
        for other in found(cure(row)):
            heapq.heappush(queue, (*other, tess.changes[other[-1]]))


def merge_short_edges(tess, shortest):
    """Shortest first."""
    def found(polygons):
        return [(length, min(a, b), max(a, b), i) for i in polygons for a, b in edges_of(tess.rings[i])
                if (length := math.dist(tess.nodes[a], tess.nodes[b])) < shortest]
    worst_first(tess, found, lambda row: merge(tess, choices(tess, *row[1:3])))


def blunt(tess, sharp):
    """Sharp corners go with one of their edges, or their polygon goes to a neighbour."""
    def found(polygons):
        polygons = list(polygons)
        rings = [tess.rings[i] for i in polygons]
        corner, back, ahead = around(rings)
        xy, owner = tess.nodes[corner], np.repeat(polygons, [len(ring) for ring in rings])
        angle = angles_between(xy[ahead] - xy, xy[back] - xy)
        at = np.flatnonzero(angle < sharp)
        return zip(*(row[at].tolist() for row in (angle, corner[back], corner, corner[ahead], owner)))

    def cure(row):
        angle, a, b, c, i = row
        both = choices(tess, a, b) + choices(tess, b, c)
        return merge(tess, both, above=angle) or unite(tess, i, angle)
    worst_first(tess, found, cure)


def absorb(tess, half_width, smallest):
    """Unite thin and small polygons with the neighbour along their longest common line."""
    def found(polygons):
        for i in polygons:
            if tess.rings[i]:
                xy = tess.nodes[tess.rings[i]]
                size = area(xy)
                if size < smallest or 2 * size < half_width * np.hypot(*(np.roll(xy, -1, axis=0) - xy).T).sum():
                    yield size, i, *tess.rings[i], i
    worst_first(tess, found, lambda row: unite(tess, row[-1]))


def unite(tess, i, sharpest=0.0):
    """Give polygon i to a neighbour, so that the corners of both are beyond the sharpest."""
    for j in neighbours(tess, i):
        ring = united(tess.rings[i], tess.rings[j])
        if ring and corner_angles(tess.nodes[ring]).min() > sharpest and (changed := change(tess, {i: [], j: ring})):
            return changed
    return []


def neighbours(tess, i):
    """Polygons beside polygon i, the one with the longest common line first."""
    common = {}
    for a, b in edges_of(tess.rings[i]):
        other = tess.owner.get((b, a))
        if other is not None:
            common[other] = common.get(other, 0.0) + math.dist(tess.nodes[a], tess.nodes[b])
    return sorted(common, key=lambda j: (-common[j], j))


def united(one, two):
    """Ring of two polygons with one common line; empty when there is a hole between them."""
    edges = directed_edges([one]) | directed_edges([two])
    outer = [(a, b) for a, b in edges if (b, a) not in edges]
    following = dict(outer)
    ring = [min(following)]
    while following.get(ring[-1], ring[0]) != ring[0] and len(ring) < len(outer):
        ring.append(following[ring[-1]])
    return ring if len(ring) == len(outer) else []


def straighten(tess):
    """Take out nodes where no third polygon begins: inner ones of two polygons, ones on a line of one."""
    few = [node for node, users in enumerate(tess.users) if (tess.rank[node], len(users)) in ((INNER, 2), (LINE, 1))]
    for node in few:
        touched = {i: cleaned([other for other in tess.rings[i] if other != node]) for i in sorted(tess.users[node])}
        if all(touched.values()):
            change(tess, touched)


# ---- cutting ---------------------------------------------------------------------------------------------

def corner_quality(xy, piece):
    """Returns how far the worst corner of a piece is from 0 and 180 degrees; not positive: not convex."""
    worst, n = 180.0, len(piece)
    for k in range(n):
        (x0, y0), (x, y), (x1, y1) = xy[piece[k - 1]], xy[piece[k]], xy[piece[(k + 1) % n]]
        ax, ay, bx, by = x1 - x, y1 - y, x0 - x, y0 - y
        angle = math.degrees(math.atan2(ax * by - ay * bx, ax * bx + ay * by))
        worst = min(worst, angle, 180.0 - angle)
    return worst


def score(*parts):
    """Returns the quality of a cut of parts: worst corner, few pieces, good corners; the larger the better."""
    return min(p[0] for p in parts), sum(p[1] for p in parts), sum(p[2] for p in parts)


def cut(xy):
    """Triangles and convex quadrilaterals of a polygon as rows of its corners; and a node inside, if they use it.

    A convex quadrilateral stays whole. Else the best cut without another node; if a corner of it is sharp, fans
    round a node inside (number len(xy)) are tried as well."""
    if len(xy) == 4 and corner_quality(xy, range(4)) > LEAST:
        return [(0, 1, 2, 3)], None
    shape = shapely.Polygon(xy)
    xy = [tuple(point) for point in np.asarray(xy).tolist()]
    best, pieces = cut_range(xy, 0, len(xy) - 1, {})
    centre = None
    if best[0] < GOOD and len(xy) > 4:
        widest = shapely.maximum_inscribed_circle(shape, 0.01 * math.sqrt(shape.area)).coords[0]
        for point in (shape.centroid.coords[0], tuple(np.mean(xy, axis=0)), widest):
            found, spokes = best_fan(xy + [point])
            if found > best and found[0] > best[0] + 2.0:
                best, pieces, centre = found, spokes, np.array(point)
    if best[0] <= 0:
        raise MeshError(f"polygon at ({xy[0][0]:.6g}, {xy[0][1]:.6g}): cannot be cut in convex blocks")
    return pieces, centre


def one_piece(xy, piece):
    quality = corner_quality(xy, piece)
    return min(quality, GOOD), -1, quality


def cut_range(xy, i, j, known):
    """Best cut of the corners i to j: the piece on the chord i-j has one or two further corners between."""
    if j - i < 2:
        return (GOOD, 0, 0.0), []
    if (i, j) not in known:
        options = [(i, k, j) for k in range(i + 1, j)]
        options += [(i, k, m, j) for k in range(i + 1, j) for m in range(k + 1, j)]
        found = []
        for piece in options:
            rest = [cut_range(xy, a, b, known) for a, b in zip(piece[:-1], piece[1:])]
            total = score(one_piece(xy, piece), *(value for value, _ in rest))
            found.append((total, [piece] + [p for _, pieces in rest for p in pieces]))
        known[i, j] = max(found, key=lambda option: option[0])
    return known[i, j]


def best_fan(xy):
    """Best fan of quadrilaterals (two edges) and triangles (one) round the last point of xy."""
    n = len(xy) - 1
    found = []
    for start in (0, 1):  # one of the two begins a piece
        at = [(start + k) % n for k in range(n + 1)]
        best = [((GOOD, 0, 0.0), [])]
        for k in range(1, n + 1):
            ends = [(n, *at[k - edges:k + 1]) for edges in (1, 2) if edges <= k]
            options = [(score(best[k + 2 - len(piece)][0], one_piece(xy, piece)), best[k + 2 - len(piece)][1] + [piece])
                       for piece in ends]
            best.append(max(options, key=lambda option: option[0]))
        found.append(best[n])
    return max(found, key=lambda option: option[0])


def blocks_of(tess):
    """Vertices, blocks (ccw, -1 in the fourth column of a triangle) and polygon of each block."""
    vertices, rows, owner = [*tess.nodes], [], []
    for i, ring in enumerate(tess.rings):
        pieces, centre = cut(tess.nodes[ring])
        names = ring + [len(vertices)]
        if centre is not None:
            vertices.append(centre)
        for piece in sorted(pieces):
            rows.append([names[k] for k in piece] + [-1] * (4 - len(piece)))
            owner.append(i)
    return np.array(vertices), np.array(rows), np.array(owner)


def refined(vertices, blocks, edges):
    """Every block in quadrilaterals, one per corner; the edges in halves. Returns all three."""
    vertices, middle, rows = [*vertices], {}, []
    def between(a, b):
        if (a, b) not in middle:
            middle[a, b] = middle[b, a] = len(vertices)
            vertices.append(0.5 * (vertices[a] + vertices[b]))
        return middle[a, b]
    for block in blocks.tolist():
        ring = block[:3] if block[3] < 0 else block
        sides = [between(a, b) for a, b in zip(ring, ring[1:] + ring[:1])]
        centre = len(vertices)
        vertices.append(np.mean([vertices[k] for k in ring], axis=0))
        rows += [[corner, sides[k], centre, sides[k - 1]] for k, corner in enumerate(ring)]
    halves = [pair for a, b in edges for pair in ((a, middle[a, b]), (middle[a, b], b))]
    return np.array(vertices), np.array(rows), halves
