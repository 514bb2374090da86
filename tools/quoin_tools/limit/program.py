"""Solves the linear programme of limit analysis (docs/limit_analysis.md): the largest multiplier of live loads under which rigid bodies find equilibrium.

    found = largest(parts, dead, live)
    found.factor, found.normal, found.shear, found.motion

Unknowns are two normal forces at the ends of each contact and one shear force, reactions, ties and the multiplier. The dual is the mechanism. Solvers take tolerances as
they are, so forces are in units of the heaviest load, lengths of the mean face.
"""

import math
from dataclasses import dataclass

import numpy as np
import scipy

from quoin_tools.base.language import _
from quoin_tools.limit import LimitError
from quoin_tools.limit.solvers import INFEASIBLE, SOLVED, UNBOUNDED, Standard, answers, solved
from quoin_tools.mesh.blockmesh import cross

TANGENTS, ROUND = 32, 64  # to the limit of compression under an eccentric force (0.02 % outside), to the ellipse of a bar and its dowel (0.1 %): for HiGHS, which takes no cones
STANDS = 1e-8  # of the sum of all loads: less is missing where bodies stand


class Unsolved(LimitError):
    """No solver ends with a solution that holds."""


@dataclass
class Limit:
    """factor inf: no load of this kind moves the bodies, if friction dilates. None: no factor brings them to equilibrium."""

    factor: float | None
    normal: np.ndarray | None = None  # (m, 2) [N] at the ends of the contacts, positive in compression
    shear: np.ndarray | None = None  # (m,) [N] on body b along p to q
    tie: np.ndarray | None = None  # (k,) [N]
    motion: np.ndarray | None = None  # (n, 3) velocity of the centres, rotation [1/m]; the fastest point 1
    gap: float = 0.0  # between the programme and its dual, relative
    residual: float = 0.0  # of equilibrium and strengths, over the heaviest load
    dual_residual: float = 0.0  # of the flow rule of the mechanism
    wedged: int = 0  # contacts that hold themselves with forces of any size, without which the loads would not be borne; `normal` and `shear` leave these out


@dataclass
class Programme:
    """The part of the programme without loads: A f = - loads (rows of free bodies), C f <= d; f in columns n1, n2, shear, reactions, ties."""

    parts: object
    free: np.ndarray  # bodies that are not held
    equilibrium: "scipy.sparse.csr_matrix"
    force: float  # [N] unit
    length: float  # [m] unit

    def rows(self, loads):
        """Scales loads (n, 3) to the rows of equilibrium."""
        return (loads[self.free] / self.force / np.array([1.0, 1.0, self.length])).ravel()


def programme(parts, *loads):
    free = np.flatnonzero(~parts.ground)
    if not len(free):
        raise LimitError(_("all bodies are held: nothing could fail"))
    contacts = parts.contacts
    length = float(contacts.length[contacts.length > 0].mean()) if (contacts.length > 0).any() else 1.0
    size = np.array([1.0, 1.0, length])
    force = max(float(np.abs(load[free] / size).max()) for load in loads)
    if not force > 0:
        raise LimitError(_("no load acts on a body that is free"))
    row_of = np.full(parts.n, -1)
    row_of[free] = 3 * np.arange(len(free))
    entries = []  # (row of the body, column, force (2), place)
    m, along = len(contacts), contacts.along
    for column, vector, place in ((0, contacts.normal, contacts.p), (m, contacts.normal, contacts.q), (2 * m, along, contacts.p)):
        for body, sign in ((contacts.b, 1.0), (contacts.a, -1.0)):
            entries.append((body, column + np.arange(m), sign * vector, place))
    h, k = len(parts.held), len(parts.ties)
    if h:
        entries.append((parts.held[:, 0], 3 * m + np.arange(h), np.eye(2)[parts.held[:, 2]], parts.mesh.vertices[parts.held[:, 1]]))
    for body, sign in ((parts.ties.head, 1.0), (parts.ties.root, -1.0)):
        entries.append((body, 3 * m + h + np.arange(k), sign * parts.ties.along, parts.ties.place))
    rows, columns, values = [], [], []
    for body, column, vector, place in entries:
        seen = row_of[body] >= 0
        moment = cross(place - parts.centre[body], vector) / length
        for d, value in enumerate((vector[:, 0], vector[:, 1], moment)):
            rows.append(row_of[body][seen] + d), columns.append(column[seen]), values.append(value[seen])
    shape = (3 * len(free), 3 * m + h + k)
    matrix = scipy.sparse.coo_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape).tocsr()
    return Programme(parts, free, matrix, force, length)


def strengths_of(parts, reduction=None):
    """Returns columns friction, cohesion, tension, compression, elastic (m, 5) of the contacts; reduction: (what, value, joints or None for all)."""
    table = parts.strengths(*(reduction or ()))
    return np.array([[*s.hull(), s.tension, s.compression, s.elastic] for s in (table[name] for name in parts.contacts.joint)], dtype=float)


def strength_rows(p, strengths):
    """Returns (C, d, least of each normal force (m, 2), (rows, right, tangents) of cones)."""
    parts, m = p.parts, len(p.parts.contacts)
    rigid = strengths[:, 4] == 0
    use = np.flatnonzero(rigid)
    area = parts.contacts.bonded * parts.thickness / p.force  # [m2/N]
    tan, i = strengths[use, 0], np.arange(len(use))
    blocks, limits = [], []
    for sign in (1.0, -1.0):
        values = np.concatenate([-tan, -tan, np.full(len(use), sign)])
        blocks.append(scipy.sparse.coo_matrix((values, (np.tile(i, 3), np.concatenate([use, m + use, 2 * m + use]))), (len(use), p.equilibrium.shape[1])))
        limits.append(strengths[use, 1] * area[use])
    with np.errstate(invalid="ignore"):  # no face times no limit: a corner
        least = np.where(rigid, np.where(area > 0, -strengths[:, 2] * area / 2, 0.0), -np.inf)
    for more in (pressure_rows(p, use, area), tie_rows(p)):
        if more:
            blocks.append(more[0]), limits.append(more[1])
    one, other = compression_cones(p, strengths, area), dowel_cones(p)
    cones = scipy.sparse.vstack([one[0], other[0]]).tocsr(), np.concatenate([one[1], other[1]]), one[2] + other[2]
    return scipy.sparse.vstack(blocks).tocsr(), np.concatenate(limits), np.column_stack([least, least]), cones


def compression_cones(p, strengths, area):
    """N of a block of stress over a part of the face: end forces n, shifted by the tension t, obey (n1 + n2)^2 <= 2 (s + t) A n_i: with forces over (s + t) A, |N, n_i - 1/2| <= n_i + 1/2.
    Returns (rows, right, tangents) of two cones a contact."""
    use = np.flatnonzero(np.isfinite(strengths[:, 3]) & (strengths[:, 4] == 0) & (area > 0))
    m, i = len(p.parts.contacts), 6 * np.arange(len(use))
    tension, most = strengths[use, 2] * area[use], (strengths[use, 2] + strengths[use, 3]) * area[use]
    rows, columns, right = [], [], np.zeros((len(use), 2, 3))
    for end in (0, 1):
        rows += [i + 3 * end + row for row in (0, 2, 1, 1)]
        columns += [end * m + use, end * m + use, use, m + use]
        right[:, end] = np.column_stack([0.5 * tension / most + 0.5, tension / most, 0.5 * tension / most - 0.5])
    matrix = scipy.sparse.coo_matrix((np.tile(-1 / most, 8), (np.concatenate(rows), np.concatenate(columns))), (6 * len(use), p.equilibrium.shape[1]))
    u = np.arange(1, TANGENTS + 1) / TANGENTS  # N at which a tangent touches
    return matrix, right.ravel(), 2 * len(use) * (np.column_stack([2 * u, u**2 - 1]) / (u**2 + 1)[:, None],)


def dowel_cones(p):
    """Returns (rows, right, tangents) of the ellipses of bars and their dowels."""
    ties, before = p.parts.ties, p.equilibrium.shape[1] - len(p.parts.ties)
    rows, columns, values, right = [], [], [], np.zeros((len(ties.ellipses), 3))
    for k, pair in enumerate(ties.ellipses):
        right[k, 0] = small = min(most for _, most in pair) / p.force  # coefficients no larger than 1
        for row, (tie, most) in enumerate(pair, start=1):
            rows.append(3 * k + row), columns.append(before + tie), values.append(-small * p.force / most)
    angle = 2 * math.pi * np.arange(ROUND) / ROUND
    matrix = scipy.sparse.coo_matrix((values, (rows, columns)), (3 * len(ties.ellipses), p.equilibrium.shape[1]))
    return matrix, right.ravel(), len(ties.ellipses) * (np.column_stack([np.cos(angle), np.sin(angle)]),)


def pressure_rows(p, use, area):
    """Returns the limit on the mean pressure, of contacts in use."""
    if not math.isfinite(p.parts.pressed):
        return None
    m, most = len(p.parts.contacts), p.parts.pressed * area[use]
    values, columns = np.tile(1 / most, 2), np.concatenate([use, m + use])
    return scipy.sparse.coo_matrix((values, (np.tile(np.arange(len(use)), 2), columns)), (len(use), p.equilibrium.shape[1])), np.ones(len(use))


def tie_rows(p):
    """Returns the limits on several ties together."""
    ties = p.parts.ties
    before = scipy.sparse.csr_matrix((ties.rows.shape[0], p.equilibrium.shape[1] - len(ties)))
    return (scipy.sparse.hstack([before, ties.rows]), ties.limits / p.force) if len(ties.limits) else None


def bounds_of(p, least):
    """Returns the lower and upper bound of each force."""
    free = np.full(len(p.parts.contacts) + len(p.parts.held), np.inf)
    low = np.concatenate([least.T.ravel(), -free, p.parts.ties.least / p.force])
    return np.column_stack([low, np.concatenate([np.full(least.size, np.inf), free, p.parts.ties.most / p.force])])


def standard(p, right, strengths, multiplied=None):
    """Returns the Standard, without cost, of forces in equilibrium with `right` within the strengths. multiplied: column of the multiplier, the last unknown."""
    rows, limits, least, (cone_rows, cone_right, cones) = strength_rows(p, strengths)
    low, high = bounds_of(p, least).T
    wide = p.equilibrium
    if multiplied is not None:
        low, high, wide = np.append(low, 0.0), np.append(high, np.inf), with_column(wide, multiplied)
        rows, cone_rows = (with_column(matrix, np.zeros(matrix.shape[0])) for matrix in (rows, cone_rows))
    one, fixed = scipy.sparse.eye(len(low), format="csr"), low == high
    rise, fall = np.isfinite(low) & ~fixed, np.isfinite(high) & ~fixed
    matrix = scipy.sparse.vstack([wide, one[fixed], rows, -one[rise], one[fall], cone_rows]).tocsc()
    return Standard(np.zeros(len(low)), matrix, np.concatenate([right, low[fixed], limits, -low[rise], high[fall], cone_right]), len(right) + int(fixed.sum()), cones)


def relaxed(asked, n):
    """Returns the programme of the least forces that must be added for equilibrium, the first n rows."""
    k, one, matrix = asked.plain, scipy.sparse.eye(n), asked.matrix.tocsr()
    added = scipy.sparse.eye(k, n)
    matrix = scipy.sparse.bmat([[matrix[:k], added, -added], [None, -one, None], [None, None, -one], [matrix[k:], None, None]]).tocsc()
    return Standard(np.concatenate([np.zeros_like(asked.cost), np.ones(2 * n)]), matrix, np.insert(asked.right, k, np.zeros(2 * n)), asked.equal, asked.cones)


def largest(parts, dead, live, reduction=None, least=False):
    """Returns the Limit of dead + factor live, (n, 3) each, factor >= 0. least: the smallest factor instead."""
    p = programme(parts, dead, live)
    push = p.rows(live)
    scale = np.abs(push).max()  # the column of the multiplier has the size of the others
    if not scale > 0:
        raise LimitError(_("the loads that are raised do not act on a body that is free"))
    asked = standard(p, -p.rows(dead), strengths_of(parts, reduction), push / scale)
    asked.cost[-1] = 1.0 if least else -1.0
    why = []
    for done in answers(asked, limited=math.isfinite(parts.pressed)):
        if done.status == UNBOUNDED and has_ray(asked):
            return Limit(math.inf)
        if done.status == INFEASIBLE and has_gap(asked, len(push)):
            return Limit(None)
        if done.status == SOLVED:
            return Limit(max(float(done.x[-1]), 0.0) / scale, *forces_of(p, done.x), motion_of(p, done.dual), done.gap, done.residual, done.dual_residual, wedged_contacts(p, asked, done))
        why.append(done.why)
    raise Unsolved(_("the linear programme is not solved: {0}", "; ".join(dict.fromkeys(why))))


def has_ray(asked):
    """Tells whether the multiplier, the last unknown, can grow without limit: forces of any size are in equilibrium with the live loads alone."""
    grows = scipy.sparse.eye(1, len(asked.cost), len(asked.cost) - 1)
    return solved(Standard(0 * asked.cost, scipy.sparse.vstack([grows, asked.matrix]).tocsc(), np.append(1.0, 0 * asked.right), asked.equal + 1, asked.cones)) is not None


def has_gap(asked, n):
    """Tells whether there is no equilibrium, the first n rows, for any multiplier."""
    stands = STANDS * max(np.abs(asked.right[:n]).sum(), 1e-300)
    done = solved(relaxed(asked, n), stands)
    return done is not None and done.value > stands


def with_column(matrix, column):
    return scipy.sparse.hstack([matrix, scipy.sparse.csr_matrix(column[:, None])]).tocsr()


@dataclass
class Missing:
    """How far bodies are from equilibrium."""

    short: float  # least sum of the forces that must be added, over the sum of all loads; 0: they stand
    slope: float  # change of `short` to the loads and strengths near by
    limit: Limit  # forces, and the mechanism


def missing(parts, loads, reduction=None, near=None):
    """near: other (loads, reduction), little different."""
    p = programme(parts, loads)
    size = np.abs(p.rows(loads)).sum()

    def asked(loads, reduction):
        right = -p.rows(loads)
        return relaxed(standard(p, right, strengths_of(parts, reduction)), len(right))

    here, why = asked(loads, reduction), []
    for done in answers(here, STANDS * size, math.isfinite(parts.pressed)):
        if done.status == SOLVED:
            break
        why.append(done.why)
    else:
        raise Unsolved(_("the linear programme is not solved: {0}", "; ".join(dict.fromkeys(why))))
    slope = (asked(*near).lagrangian(done) - here.lagrangian(done)) / size if near else 0.0  # errors of the solution cancel
    return Missing(done.value / size, slope, Limit(1.0, *forces_of(p, done.x), motion_of(p, done.dual), done.gap, done.residual, done.dual_residual, wedged_contacts(p, here, done)))


def forces_of(p, x):
    """Returns normal forces, shear, ties [N]."""
    m, h, k = len(p.parts.contacts), len(p.parts.held), len(p.parts.ties)
    x = x * p.force
    return np.column_stack([x[:m], x[m : 2 * m]]), x[2 * m : 3 * m], x[3 * m + h : 3 * m + h + k]


def wedged_contacts(p, asked, done):
    """Counts the contacts with a strength that a solution leaves to forces of any size."""
    m = len(p.parts.contacts)
    columns = asked.matrix.tocsr()[np.flatnonzero(done.wedged)].indices if done.wedged is not None else np.empty(0, int)
    return len(np.unique(columns[columns < 3 * m] % m))


def motion_of(p, dual):
    """Returns (n, 3) velocities of the centres and rotations of all bodies; the fastest corner of a block moves by 1."""
    motion = np.zeros((p.parts.n, 3))
    motion[p.free] = dual[: 3 * len(p.free)].reshape(-1, 3) / np.array([1.0, 1.0, p.length])
    fastest = np.hypot(*velocities(p.parts, motion).T).max()
    return motion / fastest if fastest > 0 else motion


def velocities(parts, motion):
    """Returns (n_vertices, 2) velocities of the vertices; a vertex moves with its body."""
    owner = np.zeros(len(parts.mesh.vertices), dtype=int)
    for corner in range(4):
        used = parts.mesh.blocks[:, corner] >= 0
        owner[parts.mesh.blocks[used, corner]] = parts.body[used]
    arm = parts.mesh.vertices - parts.centre[owner]
    return motion[owner, :2] + motion[owner, 2:] * np.column_stack([-arm[:, 1], arm[:, 0]])
