"""Replaces a base that is a broken line, with a shear key or steps, by one plane.

As one rigid body the part above slides along pieces of its base that are parallel, or along one piece beside which others bear that fall by little, where
the rest lets it; else, locked by a key or a step,
along the line from heel to toe, which takes what locks it to be sheared. N, T and M are those on a plane of that direction through the middle between heel and toe; each stretch of it
has the strength of the joint above or below it. Faces across the direction of sliding bear nothing in these numbers, nor has a piece that falls in that direction any cohesion: it parts.

    base = plane_under(case, stage, kind, path, forces)     a Base; GravityError where there is none
    hand = with_water(base, forces, water, others)      hand_method, with the water along the path
"""

import numpy as np

from quoin_tools.assess import wedge
from quoin_tools.assess.gravity import Base, hand_method
from quoin_tools.assess.section_cut import GravityError, force_at
from quoin_tools.assess.strength import contacts_on
from quoin_tools.base.language import _

STEEP = np.radians(60)  # to the direction of sliding: a face across it
FALLS = np.radians(10)  # a piece that falls by more parts as the part above slides level
MOST = 0.25  # of the length may fall: more of it would bear, and drive the part above
PARALLEL = 0.75  # of the length: pieces of one direction that bear together
ALIKE = np.radians(0.1)  # pieces whose directions differ by less are parallel
WHOLE = 0.99  # of a path must be joints
ROUNDS = 50  # of crack and water along the path
SETTLED = 1e-10  # change of the crack over the length of the base


def angles(path, direction):
    """Returns the angles of the pieces of a path to a direction, positive where they rise to the left of it."""
    pieces = np.diff(path, axis=0)
    return np.arctan2(direction[0] * pieces[:, 1] - direction[1] * pieces[:, 0], pieces @ direction)


def direction_of(path, forces, thickness):
    """Returns the direction of parallel pieces on which the part above can slide, where they are most of the base; else the direction from its start to its end."""
    chord = Base(path[0], path[-1], thickness)
    best, most = chord.along, PARALLEL
    for base, sense in wedge.planes(path, thickness):
        if sense * base.resultants(forces)[1] <= 0:
            continue
        along = base.along
        parallel = np.diff(path, axis=0)[np.abs(angles(path, along)) < ALIKE] @ along
        length = (path[-1] - path[0]) @ along
        if length > 0 and parallel.sum() > most * length:
            best, most = along, parallel.sum() / length
    return best


def has_parallel(path, base):
    """Tells whether the part above slides on several parallel pieces of a path, which then bear together."""
    return int((np.abs(angles(path, base.along)) < ALIKE).sum()) > 1


def parts(rises, onward):
    """Tells which pieces bear nothing as the part above slides: those that fall by much, and faces across. onward: 1 towards the end."""
    return onward * rises < -FALLS, np.abs(rises) > STEEP


def bears_beside(path, base, forces):
    """Tells whether much of a path bears beside the piece on which the part above would slide, because it falls by little."""
    rises = angles(path, base.along)
    falls, steep = parts(rises, 1 if base.resultants(forces)[1] >= 0 else -1)
    along = np.abs(np.diff(path, axis=0) @ base.along)
    return along[~falls & ~steep & (np.abs(rises) >= ALIKE)].sum() > (1 - PARALLEL) * along.sum()


def plane(path, forces, thickness=1.0, along=None):
    """The Base that stands for a path under the forces (X, Y, M). along: the direction of sliding, None: that of direction_of."""
    along = direction_of(path, forces, thickness) if along is None else along
    length, middle = (path[-1] - path[0]) @ along, 0.5 * (path[0] + path[-1])
    rises = angles(path, along)
    places = (path - path[0]) @ along
    if length <= 0 or (np.diff(places) < -1e-6 * length).any():
        raise GravityError(_("the path is bent, and runs back on itself: it is no base of one plane: {0}", _(wedge.WAY_OUT)))
    base = Base(middle - 0.5 * length * along, middle + 0.5 * length * along, thickness, path)
    onward = 1 if base.resultants(forces)[1] >= 0 else -1
    falls, steep = parts(rises, onward)
    if np.diff(places)[falls & ~steep].sum() > MOST * length:
        raise GravityError(_("the path is bent, and falls by more than {0:.0f}° over more than a quarter of its length in the direction in which the part above is pushed: it is no base of one plane: {1}", np.degrees(FALLS), _(wedge.WAY_OUT)))
    base.bears = np.column_stack([places[:-1], places[1:]])[~falls & ~steep]
    return base


def plane_under(case, stage, kind, path, forces):
    """Returns the plane on which the part above a bent path stands: a piece of the path on which it can slide, or the whole path in that direction, where much of it bears beside this piece;
    along joints that lock it, or with parallel pieces, one for the whole path."""
    blocks = kind == "path" and not covered(case, stage, path)
    try:
        base = wedge.sliding_plane(path, forces, case.scene.thickness)
        if not blocks and not has_parallel(path, base) and bears_beside(path, base, forces):
            return plane(path, forces, case.scene.thickness, base.along)
        refused = hand_method(base, forces).refused
        if refused:
            raise GravityError(_("the path is bent; on {0}, on which the part above would slide, it does not stand ({1}): {2}", wedge.words(base), refused, _(wedge.WAY_OUT)))
        if blocks or not has_parallel(path, base):
            return base
    except GravityError:
        if blocks:
            raise
    return plane(path, forces, case.scene.thickness)


def covered(case, stage, path):
    """Tells whether joints lie along all of a path."""
    contacts = case.results.stage(stage).contacts
    return contacts.length[contacts_on(path, contacts)].sum() >= WHOLE * np.hypot(*np.diff(path, axis=0).T).sum()


def pressed(base, water, crack):
    """Returns (X, Y, M) of the water along the path of a broken base: the head between its ends, and the depth below the line between them."""
    if water.rule == "none":
        return np.zeros(3)
    x, head = water.line(crack)
    if water.heel == "end":
        x, head = base.length - x[::-1], head[::-1]
    levels = base.path[[0, -1], 1]
    total = np.zeros(3)
    for a, b in zip(base.path[:-1], base.path[1:]):
        s = np.array([(a - base.start) @ base.along, (b - base.start) @ base.along])
        inner = x[(x > s.min()) & (x < s.max())]
        parts = np.unique(np.concatenate([[0.0, 1.0], (inner - s[0]) / (s[1] - s[0]) if s[1] > s[0] else []]))
        for low, high in zip(parts[:-1], parts[1:]):
            ends = np.array([a + t * (b - a) for t in (low, high)])
            eps = 1e-9 * base.length * np.array([1, -1])  # a jump of the head belongs to one side of its place
            along = np.clip((ends - base.start) @ base.along, 0.0, base.length)
            at = np.interp(along + (eps if along[1] > along[0] else 0.0), x, head)
            p = water.unit_weight * np.maximum(at + np.interp(along, [0.0, base.length], levels) - ends[:, 1], 0.0)
            push = np.array([ends[0, 1] - ends[1, 1], ends[1, 0] - ends[0, 0]])
            push = push if water.direction == "normal" else push * [0, 1]
            for share, k in ((p[0] / 2, 0), (p[1] / 2, 1)):  # resultants of the two triangles of a trapezium
                total += force_at(share * push * base.thickness, (2 * ends[k] + ends[1 - k]) / 3)
    return total


def with_water(base, forces, water, others=None):
    """The gravity method on a base; on a broken one the water presses along its path."""
    if base.path is None or water is None:
        return hand_method(base, forces, water, others)
    crack, answer = 0.0, None
    for _round in range(ROUNDS):
        more = pressed(base, water, crack) - water.forces(base, crack)
        answer = hand_method(base, forces, water, more if others is None else others + more)
        found = answer.crack if answer.crack is not None and answer.crack_at == water.heel else 0.0
        if answer.crack is None or abs(found - crack) <= SETTLED * base.length:
            break
        crack = found
    return answer


def words(base):
    (x, y), (u, v) = base.ends()
    rise = np.degrees(np.arctan2(base.along[1], base.along[0]))
    return _("The base is a broken line. It is taken as one plane, from ({0:.2f}, {1:.2f}) to ({2:.2f}, {3:.2f}) m, {4:+.1f}°, with the strength of its joints along it. "
             "A key or step that locks it is taken to be sheared, and its faces across bear nothing in these numbers.", x, y, u, v, rise)  # fmt: skip
