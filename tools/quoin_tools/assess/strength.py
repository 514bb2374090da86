"""Returns the strength of a base in the gravity method and in sums of contact forces: of one joint, of joints in one line, of a path."""

import numpy as np
import shapely

from quoin_tools.assess.section_cut import GravityError
from quoin_tools.base.joints import is_elastic
from quoin_tools.base.results import OPEN

ON_PATH = 0.01  # [m] contacts no farther than this from a path lie on it
ACROSS = 0.5  # cosine to the base: a contact of a broken base with less stands across it
IN_LINE = 0.01  # [m] between the end of a joint and the start of the next one
NONE = {"peak": None, "residual": None, "friction_only": None}


def factors(hand, strength, closed=None, carried=None):
    """Sliding factors, cohesion on the closed length; None without strengths. closed: (n, 2) stretches of the base, by default the
    ligament; carried(low, high): part of the normal force on a stretch, by default by the straight line."""
    if strength.get("friction") is None or is_elastic(strength):
        return dict(NONE)
    closed = ligament(hand) if closed is None else closed
    closed = closed if hand.base.bears is None else shared(closed, hand.base.bears)
    peak, residual = (hand.sliding_factor(friction_on(strength, "friction" + kind, carried or hand.carried), 1.0, cohesion_on(strength, "cohesion" + kind, closed))
                      for kind in ("", "_residual"))  # fmt: skip
    return {"peak": peak, "residual": residual, "friction_only": hand.sliding_factor(friction_on(strength, "friction", carried or hand.carried))}


def shared(one, other):
    """Returns the (n, 2) stretches that are in both lists."""
    low, high = np.maximum(one[:, None, 0], other[None, :, 0]).ravel(), np.minimum(one[:, None, 1], other[None, :, 1]).ravel()
    return np.column_stack([low, high])[high > low]


def ligament(hand):
    if hand.crack is None:
        return np.zeros((0, 2))
    return np.array([[hand.crack, hand.base.length] if hand.crack_at == "start" else [0.0, hand.base.length - hand.crack]])


def friction_on(strength, key, carried):
    """[degree] Friction of a base. Joints in a row with different friction get the angle of the sum of N tan(friction) over them."""
    spans = strength.get("spans") or []
    if len({own[key] for _, _, own in spans}) < 2:
        return strength[key]
    parts = [(carried(low, high), np.tan(np.radians(own[key]))) for low, high, own in spans]
    whole = sum(part for part, _ in parts)
    return float(np.degrees(np.arctan(sum(part * tangent for part, tangent in parts) / whole))) if whole > 0 else strength[key]


def cohesion_on(strength, key, closed):
    """[N/m] of the closed stretches: each joint in a row has its own."""
    spans = strength.get("spans") or [(-np.inf, np.inf, strength)]
    return float(sum(own[key] * np.maximum(0.0, np.minimum(closed[:, 1], b) - np.maximum(closed[:, 0], a)).sum() for a, b, own in spans))


def contacts_on(path, contacts):
    """Selects the contacts that lie on a path with both ends."""
    near = np.zeros(contacts.point.shape[:2], dtype=bool)
    for a, b in zip(path[:-1], path[1:]):
        along = (b - a) / np.hypot(*(b - a))
        off = contacts.point - a
        s, across = off @ along, np.abs(off @ np.array([-along[1], along[0]]))
        near |= (across <= ON_PATH) & (s >= -ON_PATH) & (s <= np.hypot(*(b - a)) + ON_PATH)
    return near.all(axis=1)


def bearing_on(base, contacts):
    """Selects the contacts that bear as the part above slides on a base: those along the base; of a broken base those along its path that are not across."""
    if base.path is None:
        return contacts_on(base.ends(), contacts)
    along = np.diff(contacts.point, axis=1)[:, 0] @ base.along
    return contacts_on(base.path, contacts) & (np.abs(along) > ACROSS * contacts.length)


def lies_on(path, point):
    return shapely.distance(shapely.LineString(path), shapely.Point(point)) <= ON_PATH


def closed_stretches(base, contacts, mine):
    """Returns (n, 2) places along a base where the contacts (rows mine) are closed, and the length [m] over which they are open."""
    place = (contacts.point[mine] - base.start) @ base.along
    length, is_open = contacts.length[mine], contacts.state[mine] & OPEN > 0
    part = contacts.open[mine] / length
    low, high = place.min(axis=1), place.max(axis=1)
    first_is_open = np.take_along_axis(is_open, place.argmin(axis=1)[:, None], axis=1)[:, 0]
    length = length if base.path is None else high - low
    cut = np.where(first_is_open, low + part * (high - low), high - part * (high - low))
    return np.stack([np.where(first_is_open, cut, low), np.where(first_is_open, high, cut)], axis=1), float(part @ length)


def ends_of(facts):
    return tuple(np.array([facts[at]["x"], facts[at]["y"]]) for at in ("start", "end"))


def go_on(first, second):
    """Tells whether a joint begins where another ends, in the same straight line. Facts of summary.json."""
    (a, b), (c, d) = ends_of(first), ends_of(second)
    along, after = (b - a) / np.hypot(*(b - a)), (d - c) / np.hypot(*(d - c))
    return bool(np.hypot(*(c - b)) < IN_LINE and along @ after > 1 - 1e-6)


def in_order(names, joints):
    """Names of joints that are to be one base, from start to end; joints: facts by name."""
    missing = [name for name in names if not joints.get(name, {}).get("line")]
    if missing:
        raise GravityError(f"--merge: no joint '{missing[0]}' that is a line")
    names = sorted(names, key=lambda name: tuple(ends_of(joints[name])[0]))
    for one, other in zip(names[:-1], names[1:]):
        if not go_on(joints[one], joints[other]):
            raise GravityError(f"--merge: joint {other} does not go on where {one} ends, in the same straight line")
    return names


def rows_of(joints, merged):
    """Names of the joints of each base: each its own, but for those merged. joints: facts by name, of lines only."""
    together = [in_order(names, joints) for names in merged]
    taken = {name for names in together for name in names}
    rows = together + [[name] for name in joints if name not in taken]
    return sorted(rows, key=lambda names: tuple(ends_of(joints[names[0]])[0]))


def row_of(name, joints):
    """Returns the joints in one line with this one, in order: as one base they may cut through the body where this one does not."""
    row, lines = [name], {other: facts for other, facts in joints.items() if facts["line"]}
    while before := next((other for other in lines if other not in row and go_on(lines[other], lines[row[0]])), None):
        row.insert(0, before)
    while after := next((other for other in lines if other not in row and go_on(lines[row[-1]], lines[other])), None):
        row.append(after)
    return row


def strength_of(scene, stage, names, joints):
    """Strength of joints in a row, each with its own. None where one of them is elastic."""
    keys = [scene.joint(name, stage) for name in names]
    if len(names) < 2:
        return keys[0] if names else {}
    if any(is_elastic(k) for k in keys):
        return {}
    ends = np.concatenate([[0.0], np.cumsum([joints[name]["chord"] for name in names])])
    return keys[0] | {"spans": list(zip(ends[:-1], ends[1:], keys))}
