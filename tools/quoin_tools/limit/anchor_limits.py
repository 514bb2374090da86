"""Describes the links between bodies beside their joints: anchors fixed at their ends, bars grouted into the bodies they run through, dowels.

    ties = ties_of(mesh, scene, stage, body)

A tie is one unknown force between two bodies along a line, positive in tension. A bar has one wherever it goes from one body to the next and, where it is a dowel, one along the face there. Steel limits each
of them; the bond limits by how much the force changes within a body; steel and dowel share an ellipse. A prestress changes no limit of bodies that are rigid.
"""

import math
from dataclasses import dataclass, field

import numpy as np
import scipy

from quoin_tools.base.scene import SceneError
from quoin_tools.limit import LimitError
from quoin_tools.mesh.blockmesh import closed_rings

SAME = 1e-9  # of the size of the mesh: places no farther apart are one
OVERLAP = 0.01  # of a bar's part in a block, by which the one before may reach into it


@dataclass
class Ties:
    """k unknown forces [N] of the slice, and the limits on several together: rows @ forces <= limits."""

    names: list  # (k,) of the anchor
    head: np.ndarray  # (k,) body that tension pulls along `along`
    root: np.ndarray  # (k,) body that it pulls the other way
    place: np.ndarray  # (k, 2) [m] on the line
    along: np.ndarray  # (k, 2)
    least: np.ndarray  # (k,)
    most: np.ndarray  # (k,)
    dowel: np.ndarray  # (k,) whether it acts along a face
    rows: "scipy.sparse.csr_matrix"  # (r, k)
    limits: np.ndarray  # (r,)
    ellipses: list  # ((bar, its strength), (dowel, its strength)) [N] that share one
    lines: dict  # (2, 2) [m] head and root of each anchor that is there
    breaks: list  # names of those that break at some force

    def __len__(self):
        return len(self.names)

    def unlimited(self):
        """Returns (names of anchors, of dowels) whose force has no limit."""
        bound = np.zeros(len(self), dtype=bool)
        bound[self.rows.tocoo().col] = True
        never = np.isinf(self.most) & ~bound
        return tuple(sorted({name for name, is_it in zip(self.names, never & kind) if is_it}) for kind in (~self.dowel, self.dowel))


@dataclass
class Builder:
    """Collects ties and rows of limits."""

    ties: list = field(default_factory=list)  # (name, head, root, place, along, least, most, whether a dowel)
    rows: list = field(default_factory=list)  # ({tie: coefficient}, limit)
    ellipses: list = field(default_factory=list)

    def add(self, *tie):
        self.ties.append(tie)
        return len(self.ties) - 1

    def limit(self, coefficients, most):
        self.rows.append((coefficients, most))


def ties_of(mesh, scene, stage, body):
    """Returns the anchors that are there in a stage."""
    rings = mesh.vertices[closed_rings(mesh)]
    same = SAME * float(np.hypot(*np.ptp(mesh.vertices, axis=0)))
    made, lines, breaks = Builder(), {}, []
    chain = [*scene.stages_before(stage), stage]
    for name, keys in scene.anchors.items():
        if not set(first_stages(scene, name, keys)) & set(chain):
            continue
        ends = np.array([keys["head"], keys["root"]], dtype=float)
        share = scene.thickness / float(keys.get("spacing", 1.0))
        (grouted if keys.get("bond_stiffness") else tied)(made, name, keys, ends, share, (rings, body, same))
        lines[name] = ends
        if any(math.isfinite(float(keys.get(key, math.inf))) for key in ("breaking_force", "strain_limit")):
            breaks.append(name)
    columns = list(zip(*made.ties)) if made.ties else [[]] * 8
    entries = [(row, tie, value) for row, (coefficients, _) in enumerate(made.rows) for tie, value in coefficients.items()]
    row, tie, value = zip(*entries) if entries else ((), (), ())
    matrix = scipy.sparse.csr_matrix((np.array(value, float), (np.array(row, int), np.array(tie, int))), (len(made.rows), len(made.ties)))
    return Ties(list(columns[0]), np.array(columns[1], int), np.array(columns[2], int), np.array(columns[3], float).reshape(-1, 2), np.array(columns[4], float).reshape(-1, 2),
                np.array(columns[5], float), np.array(columns[6], float), np.array(columns[7], bool), matrix, np.array([most for _, most in made.rows], float), made.ellipses, lines, breaks)  # fmt: skip


def first_stages(scene, name, keys):
    """Returns the stages from which an anchor may be there: those that stress it or ask for its force; for a passive one the stage that it names, or the first."""
    order, lock = list(scene.stages), keys.get("lock") or []
    names = [lock] if isinstance(lock, str) else list(lock)
    names += [stage for stage, of in scene.stages.items() if of.get("type") == "anchor_force" and name in (of.get("anchors") or [])]
    if not keys.get("prestress"):
        names = [keys.get("from") or order[0]]
    for stage in names:
        if stage not in order:
            raise SceneError(f"no stage '{stage}', which an anchor names")
    return names


def steel(keys):
    """[N] Returns the yield force of one anchor, and the largest tension that it bears."""
    yields = float(keys.get("yield", math.inf)) * float(keys["area"])
    most = min(yields, float(keys.get("breaking_force", math.inf)))
    if not keys.get("compression"):  # a bar that has yielded in compression may be stretched further
        most = min(most, float(keys.get("strain_limit", math.inf)) * float(keys["young"]) * float(keys["area"]))
    return yields, most


def tied(made, name, keys, ends, share, where):
    """Adds an anchor that is fixed at its ends."""
    yields, most = steel(keys)
    bodies = [body_at(name, what, place, where) for what, place in zip(("head", "root"), ends)]
    made.add(name, *bodies, ends[0], unit(ends[1] - ends[0]), -share * yields if keys.get("compression") else 0.0, share * most, False)


def body_at(name, what, place, where):
    """Returns the body whose block contains a place."""
    rings, body, same = where
    outside = np.maximum(depths(rings, place).max(axis=1), 0.0)  # of the half-planes of a convex block
    if outside.min() > same:
        raise LimitError(f"anchors.{name}: its {what} is in no block")
    return int(body[outside.argmin()])


def depths(rings, place):
    """[m] (n, 4) Returns by how much a place is outside the line of each face of each block; -inf: no face."""
    edges = np.roll(rings, -1, axis=1) - rings
    length = np.hypot(edges[..., 0], edges[..., 1])
    away = place - rings
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(length > 0, (edges[..., 1] * away[..., 0] - edges[..., 0] * away[..., 1]) / length, -np.inf)


def unit(vector):
    return vector / np.hypot(*vector)


# ---- bars in grout -----------------------------------------------------------------------------------------

def grouted(made, name, keys, ends, share, where):
    """Adds a bar that is bonded from the end of its free length to its root. It carries compression where it is bonded."""
    yields, most = (share * force for force in steel(keys))
    stretches = stretches_of(name, keys, ends, where)
    along, bond = unit(ends[1] - ends[0]), share * float(keys.get("bond_strength", math.inf))
    before = None
    if float(keys.get("free_length", 0.0)) > 0 or keys.get("plate"):
        free = keys.get("free_length") and not keys.get("compression")
        before = made.add(name, body_at(name, "head", ends[0], where), stretches[0][0], ends[0], along, 0.0 if free else -yields, most, False)
    for k, (inside, a, b, face) in enumerate(stretches):
        behind = None
        if k + 1 < len(stretches):
            at = ends[0] + 0.5 * (b + stretches[k + 1][1]) * along
            behind = made.add(name, inside, stretches[k + 1][0], at, along, -yields, most, False)
            dowel(made, name, keys, share, behind, unit(face))
        if math.isfinite(bond):
            for sign in (1.0, -1.0):
                coefficients = {tie: value for tie, value in ((behind, sign), (before, -sign)) if tie is not None}
                if coefficients:
                    made.limit(coefficients, bond * (b - a))
        before = behind


def dowel(made, name, keys, share, bar, face):
    """Adds a dowel where a bar crosses a joint: a force along the face, and the ellipse of both forces."""
    stiffness, strength = dowel_of(keys)
    if not stiffness:
        return
    _, head, root, at, _, least, _, _ = made.ties[bar]
    T, V = -least, share * strength
    across = made.add(name, head, root, at, face, -V, V, True)
    if math.isfinite(T) and math.isfinite(V):
        made.ellipses.append(((bar, T), (across, V)))


def dowel_of(keys):
    """Returns (whether the bar is a dowel, strength [N]) as anchor_shape.c: given, or of a round bar on an elastic foundation whose outer fibre yields."""
    strength, foundation = float(keys.get("dowel_strength", math.inf)), float(keys.get("dowel_foundation") or 0.0)
    if not foundation > 0:
        return bool(keys.get("dowel_stiffness")), strength
    diameter = math.sqrt(4 * float(keys["area"]) / math.pi)
    section, yields = math.pi / 32 * diameter**3, float(keys.get("yield", math.inf))
    beta = (foundation / (4 * float(keys["young"]) * 0.5 * section * diameter)) ** 0.25
    if math.isinf(strength) and math.isfinite(yields):
        strength = yields * section * beta / (math.exp(-math.pi / 4) * math.sin(math.pi / 4))
    return True, strength


def stretches_of(name, keys, ends, where):
    """Returns (body, from, to [m] from the head, direction of the face behind which the bar leaves it) of the bonded parts, in order."""
    rings, body, same = where
    length, free, stretches = float(np.hypot(*(ends[1] - ends[0]))), float(keys.get("free_length", 0.0)), []
    start, end, leaves = passages(rings, ends, same)
    for block in sorted(np.flatnonzero((end - start) * length > same), key=lambda block: (start[block], block)):
        a, b = max(free, start[block] * length), end[block] * length
        if b - a <= same:
            continue
        face = rings[block, (leaves[block] + 1) % 4] - rings[block, leaves[block]]
        last = stretches[-1] if stretches else None
        if last and a < last[2] + same and body[block] == last[0]:
            stretches[-1] = (last[0], last[1], b, face) if b > last[2] else last
        elif last and a < last[2] - max(same, OVERLAP * (b - a)):
            raise LimitError(f"anchors.{name}: {a:g} m from its head the bar runs along a joint, in two bodies")
        else:
            stretches.append((int(body[block]), a, b, face))
    if not stretches:
        raise LimitError(f"anchors.{name}: no block holds its bonded length")
    return stretches


def passages(rings, ends, same):
    """Returns for each block (from, to, face): the parts of a line, 0 to 1, that lie in it, and the face by which the line leaves it."""
    out, back = depths(rings, ends[0]), depths(rings, ends[1])
    real = np.isfinite(out)
    with np.errstate(invalid="ignore", divide="ignore"):
        met, beside = out / (out - back), np.abs(back - out) <= same  # where the line crosses the line of the face; whether it runs along it
    enters, exits = real & ~beside & (back < out), real & ~beside & (back > out)
    start = np.where(enters, met, 0.0).max(axis=1, initial=0.0)
    leaving = np.where(exits, met, np.inf)
    end = np.minimum(leaving.min(axis=1), 1.0)
    end[(real & beside & (out > same)).any(axis=1)] = -1.0
    return start, end, leaving.argmin(axis=1)
