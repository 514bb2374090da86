"""Follows rigid blocks step by step as their loads grow, with joints that slide without dilation, until they move.

    path = Path(parts, loads)
    end = follow(path, lambda share: share * loads)
    end.stands, end.fails, end.motion

Of each contact two springs at its ends press and never pull beyond the tensile strength, and one along the face slides at |T| = tan(phi) (n1 + n2) + c A, with no opening. Springs stand in the
very ends, as in rigid hinges. Displacements are small, so the size of the stiffness changes no force, but its ratios may: without dilation several forces are in equilibrium, and the way decides.

A trial of the loads goes on from the state of the last trial that stands. Blocks move against a drag c D (u - u0), D the diagonal of the stiffness; each move is solved by Newton's method, its
slip is kept, and c falls. Either the drag vanishes, so the blocks stand, or they move on and on: then the drag is as small as the loads that are too many, and the motion is a mechanism.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from quoin_tools.limit import program

DRAG, LEAST_DRAG, MOST_DRAG = 1e-2, 1e-10, 1e6  # over the stiffness
LESS, LEAST = 10, 2  # by which the drag falls; half of that each time that a move is not found
REST = 1e-8  # of the heaviest load: less drag is none
FAR, FARTHEST = 3e4, 3e6  # mean faces times k_n over the heaviest load: blocks that have moved so far go on; they may have to go farther until gaps have closed and the motion stays as it is
EXACT = 1e-9  # of the heaviest load: a move is solved
ITERATIONS, EASY, HALVINGS = 30, 15, 6  # of Newton's method; with at most EASY the drag falls
MOVES = 200  # of a trial
STEP, GROWTH, FINE = 0.05, 1.5, 5e-4  # first step of the factor, and bracket; each step beyond 1 is longer
STARTS = (0.0, 0.5, 0.75)  # first factors, until blocks stand
BEYOND = 1e3  # no larger factor is tried
SUPPORT = 1e3  # stiffness of a support over that of a face


@dataclass
class End:
    """begun: share of the way at which the path begins. stands: last at which the blocks stand, None: at none of STARTS. fails: first at which they move, None: none is found."""

    begun: float | None
    stands: float | None
    fails: float | None
    state: tuple | None  # the last that stands
    motions: list  # of free bodies in the trials that failed, in units of the programme; the last one first


class Path:
    """Blocks, their contacts, and the state at the start: displacement (of free bodies, three each) and slip. ratio: k_s over that of the scene."""

    def __init__(self, parts, *loads, ratio=1.0):
        self.p = p = program.programme(parts, *loads)
        self.m = m = len(parts.contacts)
        self.faces, self.held = p.equilibrium[:, : 3 * m].tocsc(), p.equilibrium[:, 3 * m : 3 * m + len(parts.held)].tocsc()
        self.along = self.faces.T.tocsc()  # displacements of bodies to those of contacts
        self.weaken(None)
        normal, along = (np.array([float(parts.joints[name][key]) for name in parts.contacts.joint]) * parts.contacts.bonded / p.length for key in ("k_n", "k_s"))
        self.stiffness = np.concatenate([normal / 2, normal / 2, ratio * along]) / normal.mean()
        self.support = SUPPORT * (self.held @ self.held.T)
        self.elastic = self.faces @ scipy.sparse.diags(self.stiffness) @ self.along + self.support
        self.drag = scipy.sparse.diags(np.maximum(self.elastic.diagonal(), 1e-12)).tocsc()
        self.spread()
        self.start = np.zeros(self.faces.shape[0]), np.zeros(m)

    def weaken(self, reduction):
        """Gives joints the strengths of a trial. reduction: of program.strengths_of."""
        strengths, area = program.strengths_of(self.p.parts, reduction), self.p.parts.contacts.bonded * self.p.parts.thickness / self.p.force
        self.friction, self.cohesion, self.tension = strengths[:, 0], strengths[:, 1] * area, strengths[:, 2] * area / 2

    def forces(self, u, slip):
        """Returns (forces on the ends and along the faces, relative displacements, which springs press, sign of the shear of those that slide)."""
        m, moved = self.m, self.along @ u
        normal = -self.stiffness[: 2 * m] * moved[: 2 * m]
        least = np.tile(-self.tension, 2)
        pressed = normal > least
        normal = np.maximum(normal, least)
        most = np.maximum(self.friction * (normal[:m] + normal[m:]) + self.cohesion, 0.0)
        shear = -self.stiffness[2 * m :] * (moved[2 * m :] - slip)
        return np.concatenate([normal, np.clip(shear, -most, most)]), moved, pressed, np.sign(shear) * (np.abs(shear) > most)

    def missing(self, u, before, slip, load, drag):
        state = self.forces(u, slip)
        return self.faces @ state[0] - self.support @ u + load - drag * (self.drag @ (u - before)), state

    def spread(self):
        """Finds once where entries of the law of contacts go in the tangent, whose pattern stays: (row, column) of an entry times the columns of both in `faces`."""
        m, n, i = self.m, self.faces.shape[0], np.arange(self.m)
        self.entries = np.concatenate([np.arange(3 * m), 2 * m + i, 2 * m + i]), np.concatenate([np.arange(3 * m), i, m + i])
        many = np.diff(self.faces.indptr)
        column, place = np.repeat(np.arange(3 * m), many), np.arange(self.faces.nnz) - np.repeat(self.faces.indptr[:-1], many)
        at, value = np.zeros((3 * m, many.max()), dtype=int), np.zeros((3 * m, many.max()))
        at[column, place], value[column, place] = self.faces.indices, self.faces.data
        one, other = self.entries
        keys = n * at[other][:, None, :] + at[one][:, :, None]
        support, drag = self.support.tocoo(), self.drag.tocoo()
        pattern, where = np.unique(np.concatenate([keys.ravel(), n * support.col + support.row, n * drag.col + drag.row]), return_inverse=True)
        self.rows, self.begins = pattern % n, np.searchsorted(pattern // n, np.arange(n + 1))
        values = (value[one][:, :, None] * value[other][:, None, :]).ravel()
        self.of_law = scipy.sparse.csr_matrix((values, (where[: keys.size], np.repeat(np.arange(len(one)), keys[0].size))), (len(pattern), len(one)))
        fixed = np.split(where[keys.size :], [support.nnz])
        self.of_support, self.of_drag = (np.bincount(row, part.data, len(pattern)) for row, part in zip(fixed, (support, drag)))

    def tangent(self, state, drag):
        m = self.m
        _, _, pressed, slides = state
        normal = -self.stiffness[: 2 * m] * pressed
        rubs = slides * self.friction
        law = np.concatenate([normal, -self.stiffness[2 * m :] * (slides == 0), rubs * normal[:m], rubs * normal[m:]])
        return scipy.sparse.csc_matrix((self.of_law @ law - self.of_support - drag * self.of_drag, self.rows, self.begins), self.drag.shape)

    def moved(self, load, before, slip, drag, guess):
        """Returns (displacement, state, iterations) of one move; None: Newton's method does not find it."""
        u = min((before, guess), key=lambda one: np.linalg.norm(self.missing(one, before, slip, load, drag)[0]))
        missing, state = self.missing(u, before, slip, load, drag)
        for iteration in range(ITERATIONS):
            if np.abs(missing).max() < EXACT:
                return u, state, iteration
            change = -scipy.sparse.linalg.splu(self.tangent(state, drag)).solve(missing)
            tried = []
            for halving in range(HALVINGS):
                part = 0.5**halving
                one = u + part * change
                tried.append((*self.missing(one, before, slip, load, drag), one))
                if np.linalg.norm(tried[-1][0]) < (1 - 0.1 * part) * np.linalg.norm(missing):
                    break
            missing, state, u = min(tried, key=lambda one: np.linalg.norm(one[0]))
        return None

    def trial(self, loads, start, far=FAR):
        """Returns (whether the blocks stand under loads (n, 3), None: open; state; motion)."""
        (u, slip), load, drag, less, motion = start, self.p.rows(loads), DRAG, LESS, None
        guess = u if u.any() else scipy.sparse.linalg.splu((self.elastic + 1e-6 * self.drag).tocsc()).solve(load)
        for _move in range(MOVES):
            found = self.moved(load, u, slip, drag, guess)
            if found is None:
                drag, less, guess = LESS * drag, max(0.5 * less, LEAST), u
                if drag > MOST_DRAG:
                    break
                continue
            after, (force, moved, _, _), iterations = found
            motion, u = after - u, after
            slip = moved[2 * self.m :] + force[2 * self.m :] / self.stiffness[2 * self.m :]
            if np.abs(drag * (self.drag @ motion)).max() < REST:
                return True, (u, slip), motion
            if np.abs(u).max() > far:
                return False, (u, slip), motion
            next_drag = max(drag / less, LEAST_DRAG) if iterations < EASY else drag
            guess, drag = u + motion * drag / next_drag, next_drag
        return None, (u, slip), motion


def follow(path, loads, known=True):
    """Returns the End of a path. loads: function of the share of the way, which ends at about 1, that gives (n, 3); known: it ends there at last. Blocks that need some of the loads begin with that part of them at once."""
    for last in STARTS:
        stands, state, _ = path.trial(loads(last), path.start)
        if stands:
            break
    else:
        return End(None, None, None, None, [])
    begun, step, fails, motions = last, STEP, None, []
    while step > FINE / 2 and last < (1 + FINE if known else BEYOND):
        stands, after, motion = path.trial(loads(last + step), state)
        if stands:
            last, state = last + step, after
            step *= GROWTH if last > 1 and fails is None else 1
        else:
            if stands is False:
                fails = min(last + step, fails or np.inf)
                motions.insert(0, motion)
            step /= 2
    return End(begun, last, fails, state, motions)
