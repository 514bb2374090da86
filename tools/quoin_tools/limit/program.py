"""Solves the linear programme of limit analysis (docs/limit_analysis.md): the largest multiplier of live loads under which rigid bodies find equilibrium.

    found = largest(parts, dead, live)
    found.factor, found.normal, found.shear, found.motion

Unknowns are two normal forces at the ends of each contact and one shear force, reactions, ties and the multiplier; HiGHS through scipy. Its dual is the mechanism. HiGHS
takes tolerances as they are, so forces are in units of the heaviest load, lengths of the mean face, and each answer is checked: equilibrium, strength, duality.
"""

import math
from dataclasses import dataclass

import numpy as np
import scipy

from quoin_tools.base.language import N_, _
from quoin_tools.limit import LimitError
from quoin_tools.mesh.blockmesh import cross

TANGENTS = 32  # to the limit of compression under an eccentric force
STANDS = 1e-8  # of the sum of all loads: less is missing where bodies stand
ALLOWED = 1e-6  # of the heaviest load, and of the multiplier: error allowed in checks
SHARP = {"primal_feasibility_tolerance": 1e-9, "dual_feasibility_tolerance": 1e-9}
WAYS = (SHARP | {"presolve": True}, SHARP | {"presolve": False}, {"presolve": True}, {"presolve": False})  # of HiGHS, which has called programmes unbounded that have an end
UNBOUNDED, INFEASIBLE = 3, 2


@dataclass
class Limit:
    """factor inf: no load of this kind moves the bodies, if friction dilates. None: no factor brings them to equilibrium."""

    factor: float | None
    normal: np.ndarray | None = None  # (m, 2) [N] at the ends of the contacts, positive in compression
    shear: np.ndarray | None = None  # (m,) [N] on body b along p to q
    tie: np.ndarray | None = None  # (k,) [N]
    motion: np.ndarray | None = None  # (n, 3) velocity of the centres, rotation [1/m]; the fastest point 1
    gap: float = 0.0  # between the programme and its dual, relative
    residual: float = 0.0  # of equilibrium, over the heaviest load


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
    """Returns (C, d, least of each normal force (m, 2))."""
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
    for more in (compression_rows(p, strengths, area), tie_rows(p)):
        if more:
            blocks.append(more[0]), limits.append(more[1])
    return scipy.sparse.vstack(blocks).tocsr(), np.concatenate(limits), np.column_stack([least, least])


def compression_rows(p, strengths, area):
    """N of a block of stress over a part of the face: end forces n, shifted by the tension t, obey (n1 + n2)^2 <= 2 (s + t) A n_i. Cut by tangents, from outside."""
    use = np.flatnonzero(np.isfinite(strengths[:, 3]) & (strengths[:, 4] == 0) & (area > 0))
    if not len(use):
        return None
    m, i = len(p.parts.contacts), np.arange(len(use))
    tension, most = strengths[use, 2] * area[use], (strengths[use, 2] + strengths[use, 3]) * area[use]
    blocks, limits = [], []
    for k in range(1, TANGENTS + 1):
        touch = most * k / TANGENTS  # N' at which the tangent touches: 2 touch N' - touch^2 <= 2 most n'
        for end in (0, 1):
            own, other = 2 * touch - 2 * most, 2 * touch
            values, columns = np.concatenate([own, other]), np.concatenate([end * m + use, (1 - end) * m + use])
            blocks.append(scipy.sparse.coo_matrix((values / np.tile(most, 2), (np.tile(i, 2), columns)), (len(use), p.equilibrium.shape[1])))
            shift = 0.5 * tension
            limits.append((touch**2 - (own + other) * shift) / most)
    return scipy.sparse.vstack(blocks), np.concatenate(limits)


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


def largest(parts, dead, live, reduction=None, least=False):
    """Returns the Limit of dead + factor live, (n, 3) each, factor >= 0. least: the smallest factor instead."""
    p = programme(parts, dead, live)
    strengths = strengths_of(parts, reduction)
    if not np.abs(p.rows(live)).max() > 0:
        raise LimitError(_("the loads that are raised do not act on a body that is free"))
    rows, limits, least_forces = strength_rows(p, strengths)
    push = p.rows(live)
    scale = np.abs(push).max()  # the column of the multiplier has the size of the others
    equal = with_column(p.equilibrium, push / scale)
    bounds = np.vstack([bounds_of(p, least_forces), [0.0, np.inf]])
    cost = np.zeros(len(bounds))
    cost[-1] = 1.0 if least else -1.0
    wide, right = with_column(rows, np.zeros(rows.shape[0])), -p.rows(dead)
    why = _("HiGHS finds no end of it")
    for done in tried(cost, wide, limits, equal, right, bounds):
        if done.status == UNBOUNDED and has_ray(wide, equal, bounds):
            return Limit(math.inf)
        if done.status == INFEASIBLE and has_gap(wide, limits, equal, right, bounds):
            return Limit(None)
        if done.status == 0:
            found = Limit(float(done.x[-1]) / scale + 0.0, *forces_of(p, done.x))
            found.residual = float(np.abs(equal @ done.x - right).max())
            found.gap = gap_of(done, limits, right, bounds)
            why = missed(found, rows, limits, done.x[:-1])
            if why is None:
                found.motion = motion_of(p, -done.eqlin.marginals)
                return found
    raise LimitError(_("the linear programme is not solved: {0}", why))


def has_ray(rows, equal, bounds):
    """Tells whether the multiplier, the last unknown, can grow without limit: forces of any size are in equilibrium with the live loads alone."""
    cone = np.where(np.isfinite(bounds), 0.0, bounds)
    cone[-1] = 1.0
    return solved(np.zeros(len(bounds)), rows, np.zeros(rows.shape[0]), equal, np.zeros(equal.shape[0]), cone) is not None


def has_gap(rows, limits, equal, right, bounds):
    """Tells whether there is no equilibrium for any multiplier."""
    done = solved(*relaxed(rows, limits, equal, right, bounds))
    return done is not None and done.fun > STANDS * max(np.abs(right).sum(), 1e-300)


def relaxed(rows, limits, equal, right, bounds):
    """Returns the programme of the least forces that must be added for equilibrium."""
    n, f = equal.shape
    added = scipy.sparse.hstack([equal, scipy.sparse.eye(n), -scipy.sparse.eye(n)]).tocsr()
    wide = scipy.sparse.hstack([rows, scipy.sparse.csr_matrix((rows.shape[0], 2 * n))]).tocsr()
    return np.concatenate([np.zeros(f), np.ones(2 * n)]), wide, limits, added, right, np.vstack([bounds, np.tile([0.0, np.inf], (2 * n, 1))])


def tried(*programme):
    """Yields the solutions of HiGHS, one method after the other."""
    for way in WAYS:
        yield scipy.optimize.linprog(*programme, method="highs", options=way)


def solved(*programme):
    """Returns the first solution; None: there is none."""
    return next((done for done in tried(*programme) if done.status == 0), None)


def with_column(matrix, column):
    return scipy.sparse.hstack([matrix, scipy.sparse.csr_matrix(column[:, None])]).tocsr()


def missing(parts, loads, reduction=None):
    """Returns how far the bodies are from equilibrium under loads (least sum of the forces that must be added, over the sum of all loads; 0: they stand), their motion, and the Limit's forces."""
    p = programme(parts, loads)
    rows, limits, least = strength_rows(p, strengths_of(parts, reduction))
    done = solved(*relaxed(rows, limits, p.equilibrium, -p.rows(loads), bounds_of(p, least)))
    if done is None:
        raise LimitError(_("the linear programme is not solved: {0}", _("HiGHS finds no end of it")))
    return float(done.fun) / np.abs(p.rows(loads)).sum(), motion_of(p, -done.eqlin.marginals), forces_of(p, done.x)


def forces_of(p, x):
    """Returns normal forces, shear, ties [N]."""
    m, h, k = len(p.parts.contacts), len(p.parts.held), len(p.parts.ties)
    x = x * p.force
    return np.column_stack([x[:m], x[m : 2 * m]]), x[2 * m : 3 * m], x[3 * m + h : 3 * m + h + k]


def gap_of(done, limits, equal, bounds):
    """Returns the relative gap between the values of the programme and of its dual."""
    finite = np.isfinite(bounds)
    dual = done.eqlin.marginals @ equal + done.ineqlin.marginals @ limits
    dual += done.lower.marginals[finite[:, 0]] @ bounds[finite[:, 0], 0] + done.upper.marginals[finite[:, 1]] @ bounds[finite[:, 1], 1]
    return float(abs(dual - done.fun) / max(abs(done.fun), 1.0))


def missed(found, rows, limits, forces):
    """Returns why a solution that HiGHS calls optimal is wrong (badly scaled units once gave a factor of eight); None: it is right."""
    excess = float((rows @ forces - limits).max(initial=0.0))
    for why, value in ((N_("equilibrium is missed by {0:.1e} (of the heaviest load, or of the multiplier)"), found.residual),
                       (N_("strengths are exceeded by {0:.1e} (of the heaviest load, or of the multiplier)"), excess),
                       (N_("the dual differs by {0:.1e} (of the heaviest load, or of the multiplier)"), found.gap)):  # fmt: skip
        if value > ALLOWED:
            return _(why, value)
    return None


def motion_of(p, dual):
    """Returns (n, 3) velocities of the centres and rotations of all bodies; the fastest corner of a block moves by 1."""
    motion = np.zeros((p.parts.n, 3))
    motion[p.free] = dual.reshape(-1, 3) / np.array([1.0, 1.0, p.length])
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
