"""Computes the uplift loads of a scene (docs/reference/uplift.md) in the gravity method: water pressure on the part above a base.

    for water in uplift_loads(mesh, scene, stage, part): forces += water.forces(base, crack)

The pressure runs in straight lines along the chord of the joint, from heel to toe, and presses square to each face, where faces of the
load's set have a block across. What lies on both sides of the joint within the part cancels: only faces between the part and the rest
count.
"""

from dataclasses import dataclass, replace

import numpy as np
import shapely

from quoin_tools.assess import uplift
from quoin_tools.assess.gravity import Base, Uplift
from quoin_tools.assess.heel import heel_of
from quoin_tools.assess.section_cut import GAP, GravityError, force_at
from quoin_tools.mesh.blockmesh import all_faces, face_ends

UPRIGHT = 1e-6  # cosine below which a chord stands upright
OPPOSITE = 0.9  # cosine between faces that stand against each other
ALIKE = 0.01  # ends of a chord and of a base no farther apart than this part of its length are the same


@dataclass(frozen=True)
class JointUplift(Uplift):
    """An uplift load; chord: from heel to toe; segments: (n, 2, 2) faces, the part to their left."""

    name: str = ""
    chord: Base | None = None
    segments: np.ndarray | None = None

    def is_under(self, base):
        """Tells whether the crack of the base is the crack of this joint."""
        ends = self.chord.ends() if self.heel == "start" else self.chord.ends()[::-1]
        return np.abs(ends - base.ends()).max() <= ALIKE * base.length

    def forces(self, base, crack):
        """Returns (X, Y, M) on the part above. crack [m]: of the base from the heel; it counts when the base is this joint."""
        return base.thickness * self.pressing(crack if self.is_under(base) else 0.0)

    def pressing(self, crack):
        """Returns (X, Y, M) on the part above per metre of thickness; crack [m] of the joint itself."""
        crack = min(crack, self.chord.length)
        at, head = self.line(crack)
        total = np.zeros(3)
        for a, b in self.segments:
            for p, q in pieces(a, b, self.chord, at):
                total += self.on_piece(p, q, at, head)
        return total

    def on_piece(self, p, q, at, head):
        """Returns (X, Y, M) of pressure that is linear from p to q; per metre of thickness."""
        ends = self.unit_weight * np.interp([self.along(p), self.along(q)], at, head)
        push = np.array([p[1] - q[1], q[0] - p[0]])  # to the left of p to q, times its length
        if self.direction == "vertical":
            push = np.array([0.0, push[1]])
        thirds = (2 * p + q) / 3, (p + 2 * q) / 3  # resultants of the two triangles of a trapezium
        return force_at(0.5 * ends[0] * push, thirds[0]) + force_at(0.5 * ends[1] * push, thirds[1])

    def along(self, point):
        return float((point - self.chord.start) @ self.chord.along)


def pieces(a, b, chord, at):
    """The face a to b, cut where the diagram over the chord has its corners."""
    s = [float((point - chord.start) @ chord.along) for point in (a, b)]
    if abs(s[1] - s[0]) < 1e-9 * chord.length:
        return [(a, b)]
    cuts = sorted((x - s[0]) / (s[1] - s[0]) for x in at)
    t = [0.0, *(x for x in cuts if 1e-12 < x < 1 - 1e-12), 1.0]
    return [(a + u * (b - a), a + v * (b - a)) for u, v in zip(t[:-1], t[1:])]


def chord_of(segments, heel):
    """Returns heel and toe: the outermost ends along the longest spread, which runs to the right, or up; turned for heel: end."""
    points = segments.reshape(-1, 2)
    e = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
    if e[0] < -UPRIGHT or (abs(e[0]) <= UPRIGHT and e[1] < 0):
        e = -e
    if heel == "end":
        e = -e
    order = points @ e
    return Base(points[order.argmin()], points[order.argmax()])


def in_earthquake(load):
    """Returns the rule for the pressure in a crack that an earthquake opens; None: the guideline's rule. A load that does not follow a crack keeps its pressure."""
    if load.get("cracked") is not True:
        return "unchanged"
    pressure = load["in_earthquake"]
    return None if pressure == "rule" else pressure


def joint_chord(mesh, scene, name, segments):
    """From the heel to the toe of the joint of a load. segments: its faces."""
    return chord_of(segments, heel_of(mesh, scene, name, chord_of(segments, "start").ends()))


def heel_in(chord):
    """Returns which end of a base is the heel, along the chord, which runs to the right, or up."""
    leans = chord.along[0] if abs(chord.along[0]) > UPRIGHT else chord.along[1]
    return "start" if leans > 0 else "end"


def joined(mesh, faces):
    """Block, and the part of its face (n, 2, 2), of all faces of a set that have faces of other blocks across; all whole where none has."""
    ends, (rows, vertices) = mesh.vertices[face_ends(mesh, faces)], all_faces(mesh)
    others = mesh.vertices[vertices]
    face, other = shapely.STRtree(shapely.linestrings(others)).query(shapely.linestrings(ends), predicate="dwithin", distance=GAP)
    along, against = ends[face, 1] - ends[face, 0], others[other, 0] - others[other, 1]
    opposite = (along * against).sum(axis=1) > OPPOSITE * np.hypot(*along.T) * np.hypot(*against.T)
    found = []
    for i, j in zip(face[opposite], other[opposite]):
        e = ends[i, 1] - ends[i, 0]
        s = np.clip(np.sort((others[j] - ends[i, 0]) @ e / (e @ e)), 0.0, 1.0)
        if rows[j, 0] != faces[i, 0] and s[1] - s[0] > 1e-9:
            found.append((faces[i, 0], ends[i, 0] + s[:, None] * e))
    if not found:
        return faces[:, 0], ends
    return np.array([block for block, _ in found]), np.array([segment for _, segment in found])


def boundary(part, segments):
    """Returns the faces between the part and the rest, the part to their left; where both sides are named, those of the part."""
    along = segments[:, 1] - segments[:, 0]
    outward = np.column_stack([along[:, 1], -along[:, 0]]) / np.hypot(*along.T)[:, None]  # of the block of the face
    beyond, mine = (shapely.contains_xy(part.region, *(segments.mean(axis=1) + side * 2 * GAP * outward).T) for side in (1, -1))  # by place: a path may cut a block
    own, others = segments[mine & ~beyond], segments[~mine & beyond]
    return own if len(own) else others[:, ::-1]


def heads_of(load, chord):
    level, tail, drain = float(load["level"]), load.get("tailwater"), load.get("drain")
    gallery = load.get("gallery")
    if gallery is not None:
        gallery = max(0.0, gallery - chord.at(drain)[1])
    toe = 0.0 if tail is None else max(0.0, tail - chord.end[1])
    at_drain = 0.0 if tail is None or drain is None else max(0.0, tail - chord.at(drain)[1])
    heads = uplift.Heads(chord.length, max(0.0, level - chord.start[1]), toe, drain, load.get("efficiency"), gallery, fall=max(0.0, float(chord.start[1] - chord.end[1])), tail_at_drain=at_drain)
    if "drain_level" not in load:
        return heads
    before = replace(heads, heel=max(0.0, load["drain_level"] - chord.start[1]))  # a flood that the drain does not feel
    return replace(heads, drain_head=uplift.rule_named(load["rule"]).at_drain(before, 0.0))


def uplift_loads(mesh, scene, stage, part, known=None):
    """JointUplift of every uplift load of a stage that presses on the part. known: {face set: joined()} of calls before, for this mesh."""
    found, known = [], {} if known is None else known
    for name, load in scene.stage_loads(stage).items():
        if load.get("type") != "uplift":
            continue
        if load["faces"] not in mesh.face_sets:
            raise GravityError(f"the mesh has no face set '{load['faces']}'")
        if load["faces"] not in known:
            known[load["faces"]] = joined(mesh, mesh.face_sets[load["faces"]])
        _, joint = known[load["faces"]]
        segments = boundary(part, joint)
        if not len(segments):
            continue
        in_crack = "full" if load.get("cracked") is True else "unchanged"
        chord = joint_chord(mesh, scene, name, joint)
        direction = "vertical" if load.get("component") == "vertical" else "normal"
        found.append(JointUplift(load["rule"], heads_of(load, chord), direction, in_crack,
                                 float(load["density"]) * float(load.get("partial_factor", 1)) * scene.gravity, heel_in(chord), None, in_earthquake(load), name=name, chord=chord, segments=segments))  # fmt: skip
    return found
