"""Follows rigid blocks step by step as their loads grow, with joints that slide without dilation, until they move.

    path = Path(parts, loads)
    end = follow(path, lambda share: share * loads)
    end.stands, end.fails, end.motion

Of each contact some points from end to end have a spring each that presses, and never pulls beyond the tensile strength, and one along the face that slides at |t| = tan(phi) n + c a, n the force of the same
point, with no opening. With two points these are blocks whose stress model is `pt`; with many, blocks whose joints are pressed over a length (`tptm`), so stiff that their hinges stand at edges.
Displacements are small, so the size of the stiffness changes no force. Its ratios may, and the number of points, for a point that parts forgets its slip: without dilation several forces are in
equilibrium, and the way decides.

A trial of the loads goes on from the state of the last trial that stands. Blocks move against a drag c D (u - u0), D the diagonal of the stiffness; each move is solved by Newton's method, its
slip is kept, and c falls. Either the drag vanishes, so the blocks stand, or they move on and on: then the drag is as small as the loads that are too many, and the motion is a mechanism.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from quoin_tools.limit import program

DRAG, LEAST_DRAG, MOST_DRAG = 1e-2, 1e-10, 1e6  # over the stiffness
LESS, LEAST = 10, 2  # by which the drag falls; half of that each time that a move is not found
REST = 1e-8  # of the heaviest load: less drag is none
FAR, FARTHEST = 3e4, 3e6  # mean faces times k_n over the heaviest load, the first one times the gaps between points of a face, each of which a hinge has to close: blocks that have moved so far go on; they may have to go farther until gaps have closed and the motion stays as it is
EXACT = 1e-9  # of the heaviest load: a move is solved
ITERATIONS, EASY, HALVINGS = 30, 15, 6  # of Newton's method; with at most EASY the drag falls
MOVES = 200  # of a trial
STEP, GROWTH, FINE = 0.05, 1.5, 5e-4  # first step of the factor, and bracket; each step beyond 1 is longer
PARTS = 10  # of a step at whose end blocks fail: a trial that fails takes as long as ten that stand
NEAR = 4e-3  # before an expected end steps are short
STARTS = (0.0, 0.5, 0.75)  # first factors, until blocks stand
ROUNDING = 1e-9
OPEN = 2  # trials with steps of at most NEAR that are not decided, after which a path ends that has found no end
SMALL = 400  # unknowns up to which a factor of a band is faster than a sparse one
BEYOND, OVER = 1e3, 5e-3  # no larger factor is tried; nor one farther over a bound, beyond which nothing stands
SUPPORT = 1e3  # stiffness of a support over that of a face


@dataclass
class End:
    """begun: share of the way at which the path begins. stands: last at which the blocks stand, None: at none of STARTS. fails: first at which they move, None: none is found."""

    begun: float | None
    stands: float | None
    fails: float | None
    state: tuple | None  # the last that stands
    motions: list  # of free bodies in the trials that failed, in units of the programme; the last one first


class State(NamedTuple):
    force: np.ndarray  # (3 m,) normal forces at both ends, forces along the faces
    moved: np.ndarray  # (3, m) displacements of the ends that open them, and along the faces
    shear: np.ndarray  # (points, m)
    pressed: np.ndarray  # which points are
    slides: np.ndarray  # sign of the shear of those that do


class Path:
    """Blocks, their contacts, and the state at the start: displacement (of free bodies, three each) and slip (points, m). ratio: k_s over that of the scene. points: of each contact."""

    def __init__(self, parts, *loads, ratio=1.0, points=2):
        self.p = p = program.programme(parts, *loads)
        self.m = m = len(parts.contacts)
        self.share = np.linspace([1.0, 0.0], [0.0, 1.0], points, axis=1)  # of the force at a point that goes to each end
        self.faces, self.held = p.equilibrium[:, : 3 * m].tocsc(), p.equilibrium[:, 3 * m : 3 * m + len(parts.held)].tocsc()
        self.weaken(None)
        normal, along = (np.array([float(parts.joints[name][key]) for name in parts.contacts.joint]) * parts.contacts.bonded / p.length for key in ("k_n", "k_s"))
        self.normal, self.shear = normal / (points * normal.mean()), ratio * along / (points * normal.mean())  # stiffness at a point
        self.support = SUPPORT * (self.held @ self.held.T)
        self.spread()
        n = self.faces.shape[0]
        self.on_bodies, self.at_ends = self.faces.tocsr(), self.faces.T.tocsr()
        sticks = State(None, None, None, np.ones((points, m)), np.zeros((points, m)))
        self.drag = np.zeros(n)
        self.drag = np.maximum(-self.tangent(sticks, 0.0)[self.diagonal], 1e-12)  # its stiffness
        self.elastic = self.tangent(sticks, 1e-6)
        self.start = np.zeros(n), np.zeros((points, m))

    def weaken(self, reduction):
        """Gives joints the strengths of a trial. reduction: of program.strengths_of."""
        strengths, area = program.strengths_of(self.p.parts, reduction), self.p.parts.contacts.bonded * self.p.parts.thickness / self.p.force
        self.friction, self.cohesion, self.tension = strengths[:, 0], strengths[:, 1] * area, strengths[:, 2] * area / 2

    def forces(self, u, slip):
        """Returns the State under displacements."""
        points, moved = slip.shape[0], (self.at_ends @ u).reshape(3, self.m)
        normal = -self.normal * (self.share.T @ moved[:2])
        least = -2 / points * self.tension
        pressed = normal > least
        normal = np.maximum(normal, least)
        most = np.maximum(self.friction * normal + self.cohesion / points, 0.0)
        trial = self.shear * (slip - moved[2])
        shear = np.maximum(np.minimum(trial, most), -most)
        return State(np.concatenate([*(self.share @ normal), shear.sum(axis=0)]), moved, shear, pressed, np.sign(trial - shear))

    def missing(self, u, before, slip, load, drag):
        state = self.forces(u, slip)
        return self.on_bodies @ state.force - self.support @ u + load - drag * self.drag * (u - before), state

    def spread(self):
        """Finds once where entries of the law of contacts go in the tangent, whose pattern stays: (row, column) of an entry, n1 n1, n1 n2, n2 n1, n2 n2, t t, t n1, t n2 of each contact, times the columns of both in `faces`."""
        m, n = self.m, self.faces.shape[0]
        one, other = ((np.array(ends)[:, None] * m + np.arange(m)).ravel() for ends in ((0, 0, 1, 1, 2, 2, 2), (0, 1, 0, 1, 2, 0, 1)))
        many = np.diff(self.faces.indptr)
        column, place = np.repeat(np.arange(3 * m), many), np.arange(self.faces.nnz) - np.repeat(self.faces.indptr[:-1], many)
        at, value = np.zeros((3 * m, many.max()), dtype=int), np.zeros((3 * m, many.max()))
        at[column, place], value[column, place] = self.faces.indices, self.faces.data
        keys = n * at[other][:, None, :] + at[one][:, :, None]
        support = self.support.tocoo()
        pattern, where = np.unique(np.concatenate([keys.ravel(), n * support.col + support.row, (n + 1) * np.arange(n)]), return_inverse=True)
        rows, columns = pattern % n, pattern // n
        self.rows, self.begins, self.small = rows, np.searchsorted(columns, np.arange(n + 1)), n <= SMALL
        self.order = scipy.sparse.csgraph.reverse_cuthill_mckee(scipy.sparse.csc_matrix((np.ones(len(rows)), rows, self.begins), (n, n)))
        place = np.argsort(self.order)
        self.width = int(np.abs(place[rows] - place[columns]).max())
        self.in_band = np.ravel_multi_index((2 * self.width + place[rows] - place[columns], place[columns]), (3 * self.width + 1, n))
        values = (value[one][:, :, None] * value[other][:, None, :]).ravel()
        self.of_law = scipy.sparse.csr_matrix((values, (where[: keys.size], np.repeat(np.arange(len(one)), keys[0].size))), (len(pattern), len(one)))
        self.of_support, self.diagonal = np.bincount(where[keys.size : -n], support.data, len(pattern)), where[-n:]

    def tangent(self, state, drag):
        """Returns the change of what is missing with the displacements: values of the matrix, column by column."""
        normal = -self.normal * state.pressed
        rubs = state.slides * self.friction * normal
        pairs = self.share[[0, 0, 1, 1]] * self.share[[0, 1, 0, 1]]
        values = self.of_law @ np.concatenate([*(pairs @ normal), -(self.shear * (state.slides == 0)).sum(axis=0), *(self.share @ rubs)]) - self.of_support
        values[self.diagonal] -= drag * self.drag
        return values

    def solve(self, tangent, right):
        n = len(right)
        if not self.small:
            return scipy.sparse.linalg.splu(scipy.sparse.csc_matrix((tangent, self.rows, self.begins), (n, n))).solve(right)
        band = np.zeros((3 * self.width + 1) * n)
        band[self.in_band] = tangent
        found, done = np.empty(n), scipy.linalg.lapack.dgbsv(self.width, self.width, band.reshape(-1, n), right[self.order], overwrite_ab=True)
        if done[-1]:
            raise np.linalg.LinAlgError("the tangent is singular")
        found[self.order] = done[2]
        return found

    def moved(self, load, before, slip, drag, guess):
        """Returns (displacement, state, iterations) of one move; None: Newton's method does not find it."""
        missing, state, u = min(((*self.missing(one, before, slip, load, drag), one) for one in (before, guess)), key=lambda one: np.linalg.norm(one[0]))
        for iteration in range(ITERATIONS):
            if np.abs(missing).max() < EXACT:
                return u, state, iteration
            change = -self.solve(self.tangent(state, drag), missing)
            tried = []
            for halving in range(HALVINGS):
                part = 0.5**halving
                one = u + part * change
                tried.append((*self.missing(one, before, slip, load, drag), one))
                if np.linalg.norm(tried[-1][0]) < (1 - 0.1 * part) * np.linalg.norm(missing):
                    break
            missing, state, u = min(tried, key=lambda one: np.linalg.norm(one[0]))
        return None

    def trial(self, loads, start, far=None):
        """Returns (whether the blocks stand under loads (n, 3), None: open; state; motion)."""
        (u, slip), load, drag, less, motion = start, self.p.rows(loads), DRAG, LESS, None
        guess = u if u.any() else -self.solve(self.elastic, load)
        for _move in range(MOVES):
            found = self.moved(load, u, slip, drag, guess)
            if found is None:
                drag, less, guess = LESS * drag, max(0.5 * less, LEAST), u
                if drag > MOST_DRAG:
                    break
                continue
            after, state, iterations = found
            motion, u = after - u, after
            slip = state.moved[2] + state.shear / self.shear
            if np.abs(drag * self.drag * motion).max() < REST:
                return True, (u, slip), motion
            if np.abs(u).max() > (far or FAR * (self.share.shape[1] - 1)):
                return False, (u, slip), motion
            next_drag = max(drag / less, LEAST_DRAG) if iterations < EASY else drag
            guess, drag = u + motion * drag / next_drag, next_drag
        return None, (u, slip), motion


def follow(path, loads, known=True, near=math.inf):
    """Returns the End of a path. loads: function of the share of the way, which ends at about 1, that gives (n, 3); known: nothing stands beyond 1. near: share at which the end is expected, for
    trials that fail take longest; a path with one is not tried at 1, where it ends if nothing stands beyond. Blocks that need some of the loads begin with that part of them at once."""
    for last in STARTS:
        stands, state, _ = path.trial(loads(last), path.start)
        if stands:
            break
    else:
        return End(None, None, None, None, [])
    begun, step, fails, motions, opened, grows = last, STEP, None, [], 0, True
    most = BEYOND if not known else 1 + OVER if math.isinf(near) else 1 - FINE / 10
    while step > 0 and (fails or opened < OPEN) and last < (1 - FINE if known and fails else most):
        ahead = near - NEAR - last if last < near - NEAR else math.inf
        step = min(step, most - last, ahead)
        stands, after, motion = path.trial(loads(last + step), state)
        if stands:
            last, state = last + step, after
            if fails is not None and last >= fails:  # in smaller steps they stand there
                fails, motions = None, []
            step = NEAR / 2 if step == ahead else step * (GROWTH if last > min(near, 1) and grows else 1)
        else:
            if stands is False:
                fails = min(last + step, fails or np.inf)
                motions.insert(0, motion)
            else:
                opened += step <= NEAR
            step, grows = max(step / PARTS, FINE) if step > (1 + ROUNDING) * FINE else 0.0, False
    return End(begun, last, fails, state, motions)
