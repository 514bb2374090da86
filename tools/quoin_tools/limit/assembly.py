"""Finds the rigid bodies of a block mesh and their links: faces that meet, supports, anchors.

    parts = assembly(mesh, scene, stage)

A body is a macroblock. Of two faces that meet, body a has the one that runs from p to q, body b stands on the side of the normal. Forces are
those of the slice, thickness included; geometry is that of the mesh, undeformed.
"""

import math
from dataclasses import dataclass

import numpy as np
import shapely

from quoin_tools.base import joints
from quoin_tools.base.language import _
from quoin_tools.limit import LimitError
from quoin_tools.limit.anchor_limits import Ties, ties_of
from quoin_tools.mesh.blockmesh import areas, closed_rings, cross, face_ends, macroblocks, outer_faces
from quoin_tools.mesh.meshing import without_groups
from quoin_tools.mesh.supports import target_of

OPPOSITE = math.cos(math.radians(20))  # between faces that stand against each other, as in runs
DEEPEST = 0.4  # of the thinner block: a deeper overlap is a block between two faces that point away from each other
LAYER, FRONT = 0.02, 0.5  # parts of a contact behind a block, and behind any face: then it is none, as in runs
LEVEL = 1e-6  # of the shorter face: places that differ by less are the same
SHORTEST = 1e-6  # of the mean face: a shorter piece is a corner


@dataclass(frozen=True)
class Strength:
    """Strength of a contact. elastic: without limits, in tension too."""

    friction: float  # tan of the angle
    cohesion: float  # [Pa]
    tension: float  # [Pa]
    compression: float  # [Pa]
    elastic: bool = False

    def beyond_apex(self):
        """Tells whether the tensile strength exceeds c / tan(phi), where the lines of Mohr and Coulomb meet."""
        return not self.elastic and self.tension * self.friction > self.cohesion * (1 + 1e-9)

    def hull(self):
        """Returns (tan(phi), c) of the least convex strength that encloses this one: a point that pulls beyond the apex bears no shear, but its neighbour all of its own."""
        return self.friction, max(self.cohesion, self.tension * self.friction) if self.beyond_apex() else self.cohesion


@dataclass
class Contacts:
    """Where bodies meet, m of them. A corner on a face has p = q."""

    a: np.ndarray  # (m,) body
    b: np.ndarray  # (m,) body on the side of the normal
    p: np.ndarray  # (m, 2) first end [m]
    q: np.ndarray  # (m, 2) second end [m]
    normal: np.ndarray  # (m, 2) from a to b
    joint: list  # (m,) row of the joints table
    bonded: np.ndarray  # (m,) [m] over which cohesion, tension and compression act: of a corner the shorter face, as runs have it at most

    def __len__(self):
        return len(self.a)

    @property
    def length(self):
        return np.hypot(*(self.q - self.p).T)

    @property
    def along(self):
        """Unit vectors from p to q."""
        return np.column_stack([-self.normal[:, 1], self.normal[:, 0]])


@dataclass
class Assembly:
    mesh: object
    body: np.ndarray  # (n_blocks,) body of each block
    centre: np.ndarray  # (n, 2) [m] about which moments of a body are taken
    ground: np.ndarray  # (n,) whether a support holds the whole body
    contacts: Contacts
    held: np.ndarray  # (h, 3) reactions: body, vertex, direction 0 x, 1 y
    ties: Ties
    joints: dict  # name: keys of the joint in this stage
    thickness: float
    gap: float  # [m] that faces may be apart and meet
    pressed: float = math.inf  # [Pa] largest mean pressure on a contact

    @property
    def n(self):
        return len(self.centre)

    def strengths(self, what="", value=1.0, only=None):
        """Returns the Strength of each joint, by name. In a trial those of `only` (None: all) are reduced."""
        return {name: strength_of(joints.reduced(keys, what, value) if what and (not only or name in only) else keys) for name, keys in self.joints.items()}


def assembly(mesh, scene, stage):
    """Returns the assembly of the bodies built in a stage; its mesh lacks the others (built)."""
    absent, mesh = scene.absent(stage), built(mesh, scene, stage)
    body = macroblocks(mesh)
    n = int(body.max(initial=-1)) + 1
    if n < 2:
        raise LimitError(_("the mesh is one body without joints") if n else f"stage '{stage}' has no blocks")
    size = np.abs(areas(mesh))
    centre = np.column_stack([np.bincount(body, size * mesh.centres()[:, k], n) / np.bincount(body, size, n) for k in (0, 1)])
    contacts, gap = contacts_of(mesh, scene, body)
    if not len(contacts):
        raise LimitError(_("no two bodies of the mesh meet: there is no joint that could fail"))
    ground, held = supports_of(mesh, scene, body, n, bool(absent))
    laws = {name: scene.joint(name, stage) for name in sorted(set(contacts.joint))}
    return Assembly(mesh, body, centre, ground, contacts, held, ties_of(mesh, scene, stage, body), laws, scene.thickness, gap)


def built(mesh, scene, stage):
    """Returns the mesh without the groups that are placed after a stage."""
    absent = scene.absent(stage)
    return without_groups(mesh, absent) if absent else mesh


def strength_of(keys):
    """Returns the Strength of a joint from its keys."""
    if joints.is_elastic(keys):
        return Strength(math.inf, 0.0, math.inf, math.inf, True)
    return Strength(math.tan(math.radians(float(keys["friction"]))), float(keys["cohesion"]), float(keys["tension"]), float(keys["compression"]))


# ---- faces that meet ---------------------------------------------------------------------------------------

def gap_of(scene, ends):
    """[m] that faces may be apart and meet, contact.tolerance of the scene: of each face (n,), where it is relative."""
    tolerance = float(scene.contact.get("tolerance", 0.005))
    return tolerance * (np.hypot(*(ends[:, 1] - ends[:, 0]).T) if scene.contact.get("relative") in (True, 1) else np.ones(len(ends)))


def contacts_of(mesh, scene, body):
    """Returns (Contacts, largest gap of faces that meet [m])."""
    faces = outer_faces(mesh)
    ends = mesh.vertices[face_ends(mesh, faces)]
    gap = gap_of(scene, ends)
    owner, group = body[faces[:, 0]], mesh.block_group[faces[:, 0]]
    order = joint_order(mesh, scene)
    rows = joint_rows(mesh, order, faces)
    mean = float(np.hypot(*(ends[:, 1] - ends[:, 0]).T).mean())
    thick = thickness_of(mesh, faces, ends)
    found = [(owner[i], owner[j], joint_of(order, mesh, rows[i], rows[j], group[i], group[j]), p, q)
             for i, j, p, q in face_pairs(ends, owner, faces[:, 0], thick, gap, SHORTEST * mean)]  # fmt: skip
    pieces = merged(found, gap.max())
    pieces += corners(mesh, order, body, faces, ends, thick, rows, pieces, gap.max())
    a, b = (np.array([piece[k] for piece in pieces], dtype=int) for k in (0, 1))
    p, q = (np.array([piece[k] for piece in pieces], dtype=float).reshape(-1, 2) for k in (3, 4))
    normal = np.array([piece[5] for piece in pieces]).reshape(-1, 2)
    return Contacts(a, b, p, q, normal, [piece[2] for piece in pieces], np.array([piece[6] for piece in pieces])), float(gap.max())


def joint_order(mesh, scene):
    """Names of the scene's joints in the order in which they count for a face of several sets, as joint_turns.c: a set within another one before it, else as in the scene."""
    sets = {name: set(map(tuple, mesh.face_sets[name].tolist())) for name in scene.joints if name in mesh.face_sets}
    order = []
    for name in scene.joints:
        outer = (k for k, other in enumerate(order) if sets.get(name) and sets[name] < sets.get(other, set()))
        order.insert(next(outer, len(order)), name)
    return order


def joint_rows(mesh, order, faces):
    """Returns for each face the first joint in order that is a face set with it; None: none."""
    place = {tuple(face): i for i, face in enumerate(faces.tolist())}
    rows = [None] * len(faces)
    for name in reversed(order):
        for face in mesh.face_sets.get(name, np.empty((0, 2), int)).tolist():
            if tuple(face) in place:
                rows[place[tuple(face)]] = name
    return rows


def joint_of(order, mesh, one, two, group_a, group_b):
    """Returns the joint of a contact as joint_rows.c does: a face set before a pair of groups before `default`; of two face sets the first in order."""
    if one or two:
        return min((name for name in (one, two) if name), key=order.index)
    a, b = mesh.group_names[group_a], mesh.group_names[group_b]
    return next((name for name in order if name in (f"{a}+{b}", f"{b}+{a}")), "default")


def thickness_of(mesh, faces, ends):
    """Returns (n,) [m] how far the block of each face reaches behind it."""
    e = ends[:, 1] - ends[:, 0]
    inward = np.column_stack([-e[:, 1], e[:, 0]]) / np.hypot(*e.T)[:, None]
    ring = mesh.vertices[closed_rings(mesh)[faces[:, 0]]]
    return np.einsum("nkx,nx->nk", ring - ends[:, :1], inward).max(axis=1)


def seen(one, two):
    """Where face two lies opposite face one: (places of its ends along one, 0 to 1; [m] its gap there). None: nowhere, or both look the same way."""
    e, against = one[1] - one[0], two[0] - two[1]
    length = math.hypot(*e)
    if e @ against <= OPPOSITE * length * math.hypot(*against):
        return None
    place, gap = (two[::-1] - one[0]) @ e / length**2, (two[::-1] - one[0]) @ np.array([e[1], -e[0]]) / length
    ends = np.clip(place, 0.0, 1.0)
    return (ends, np.interp(ends, place, gap)) if ends[1] > ends[0] else None


def face_pairs(ends, owner, block, thick, gap, shortest):
    """Returns (i, j, p, q): faces of two bodies that stand against each other with no block between, and their common part, along face i; i < j. gap: (n,) that they may be apart."""
    lines, length = shapely.linestrings(ends), np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    one, two = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=gap * (1 + 1e-9))
    keep = owner[one] != owner[two]
    if np.ptp(gap) > 0:  # of each pair the shorter face counts; pairs are found from both
        keep &= shapely.distance(lines[one], lines[two]) <= np.minimum(gap[one], gap[two]) * (1 + 1e-9)
    views = {}
    for i, j in zip(one[keep], two[keep]):
        view = seen(ends[i], ends[j])
        if view and view[1].max() <= min(gap[i], gap[j]) * (1 + 1e-9) and view[1].min() >= -DEEPEST * min(thick[i], thick[j]):
            views.setdefault(i, {})[j] = view
    mutual = sorted((one, two) for one, view in views.items() for two in view if one < two and one in views.get(two, {}))
    for i, j in mutual:
        s, e = views[i][j][0], ends[i, 1] - ends[i, 0]
        step = LEVEL * min(length[i], length[j])
        if (s[1] - s[0]) * length[i] > shortest and not (screened(views[i], j, block, thick, step) or screened(views[j], i, block, thick, step)):
            yield i, j, ends[i, 0] + s[0] * e, ends[i, 0] + s[1] * e


def screened(view, j, block, thick, step):
    """Tells whether other faces stand before face j, over more of it than LAYER (blocks between) or FRONT. view: the faces that one face sees, from `seen`."""
    s, gap = view[j]
    layer = front = 0.0
    for k, (t, nearer) in view.items():
        low, high = max(s[0], t[0]), min(s[1], t[1])
        if block[k] == block[j] or high <= low:
            continue
        here, there = (np.interp(0.5 * (low + high), *at) for at in ((t, nearer), (s, gap)))
        if here < there - step:
            front += high - low
            layer += (high - low) * (here + 0.5 * thick[k] < there)
    return layer > LAYER * (s[1] - s[0]) or front > FRONT * (s[1] - s[0])


def merged(found, gap):
    """Pieces (a, b, joint, p, q, normal, length) of which those of one line between two bodies are one: a face has one resultant."""
    runs = {}
    for a, b, joint, p, q in found:
        if a > b:
            a, b, p, q = b, a, q, p
        runs.setdefault((a, b, joint), []).append((p, q))
    pieces = []
    for (a, b, joint), segments in runs.items():
        chains = []
        for p, q in segments:
            apart = [other for other in chains if not continues(other, (p, q), gap)]
            for first, last in (other for other in chains if continues(other, (p, q), gap)):
                p, q = (first, q) if np.hypot(*(last - p)) <= gap else (p, last)
            chains = [*apart, (p, q)]
        for p, q in chains:
            length = np.hypot(*(q - p))
            e = (q - p) / length
            pieces.append((a, b, joint, p, q, np.array([e[1], -e[0]]), length))
    return pieces


def continues(one, two, gap):
    """Tells whether a segment begins where the other ends, and goes the same way."""
    e, f = one[1] - one[0], two[1] - two[0]
    meets = min(np.hypot(*(one[1] - two[0])), np.hypot(*(two[1] - one[0]))) <= gap
    return meets and abs(cross(e, f)) < 1e-6 * np.hypot(*e) * np.hypot(*f) and e @ f > 0


def corners(mesh, order, body, faces, ends, thick, rows, pieces, gap):
    """Corners of a body that stand on a face of another where no faces meet: pieces without length. order: of joints, joint_order."""
    lines = shapely.STRtree(shapely.linestrings(ends))
    corner_rows = face_ends(mesh, faces)[:, 0]
    owner = body[faces[:, 0]]
    lengths = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    along = (ends[:, 1] - ends[:, 0]) / lengths[:, None]
    longest = np.zeros(len(mesh.vertices))  # of the faces of a vertex
    np.maximum.at(longest, face_ends(mesh, faces).ravel(), np.repeat(lengths, 2))
    point, line = lines.query(shapely.points(mesh.vertices[corner_rows]), predicate="dwithin", distance=gap)
    from_start = mesh.vertices[corner_rows[point]] - ends[line, 0]
    place = np.einsum("nx,nx->n", from_start, along[line])
    height = cross(from_start, along[line])  # over the face
    keep = (owner[point] != owner[line]) & (height >= -DEEPEST * thick[line])
    point, line, place, height = point[keep], line[keep], place[keep], height[keep]
    over = {}  # faces that a corner stands over
    for at, (i, j) in enumerate(zip(point, line)):
        if -gap <= place[at] <= lengths[j] + gap:
            over.setdefault(i, []).append((j, height[at]))
    covered = {}
    for a, b, __, p, q, *__ in pieces:
        covered.setdefault((min(a, b), max(a, b)), []).append(shapely.LineString([p, q]))
    found = {}
    for i, j, s, h in zip(point, line, place, height):
        a, b, corner = owner[j], owner[i], mesh.vertices[corner_rows[i]]
        key = (min(a, b), max(a, b))
        if not gap < s < lengths[j] - gap:
            continue  # a corner at a corner bears nothing
        if any(shapely.Point(corner).distance(segment) < 2 * gap for segment in covered.get(key, [])):
            continue
        if any(owner[k] != a and other < h - LEVEL * lengths[j] and along[k] @ along[j] > OPPOSITE for k, other in over[i]):
            continue  # another block lies between
        joint = joint_of(order, mesh, rows[i], rows[j], *mesh.block_group[faces[[i, j], 0]])
        at = ends[j, 0] + s * along[j]
        normal = np.array([along[j, 1], -along[j, 0]])
        found.setdefault((a, b, round(at[0], 6), round(at[1], 6)), (a, b, joint, at, at, normal, min(lengths[j], longest[corner_rows[i]])))
    return list(found.values())


# ---- supports of bodies ---------------------------------------------------------------------------------------

def supports_of(mesh, scene, body, n, partly):
    """Returns (whether a body is fixed whole, reactions (h, 3) elsewhere). partly: some of it is not built yet, and supports of that part may be missing."""
    ground, held = np.zeros(n, dtype=bool), set()
    rings = closed_rings(mesh)
    for name, keys in scene.supports.items():
        fix, (kind, target) = str(keys.get("fix", "xy")), target_of(mesh, name, keys)
        if kind == "faces":
            places = [(body[block], vertex) for (block, _), pair in zip(target, face_ends(mesh, target)) for vertex in pair]
        elif kind == "point":
            places = [(body[np.flatnonzero((mesh.blocks == target).any(axis=1))[0]], target)]
        elif kind == "group" and fix == "xy":
            ground[body[target]] = True
            continue
        elif kind == "group":
            places = [(body[block], vertex) for block in target for vertex in rings[block]]
        elif partly:
            continue
        else:
            raise LimitError(f"supports.{name}: the mesh has no '{target}'")
        held |= {(int(b), int(vertex), axis) for b, vertex in places for axis in (0, 1) if "xy"[axis] in fix}
    for b in {row[0] for row in held}:  # two places held in x and y hold a body whole
        both = {vertex for row, vertex, axis in held if row == b and axis == 0} & {vertex for row, vertex, axis in held if row == b and axis == 1}
        ground[b] |= len(both) > 1
    rows = sorted(row for row in held if not ground[row[0]])
    if not ground.any() and not rows:
        raise LimitError(_("nothing is held: the scene has no supports"))
    return ground, np.array(rows, dtype=int).reshape(-1, 3)
