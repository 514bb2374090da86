"""Finds and checks a mechanism without dilation, and the range of factors at which forces keep it going.

    found = mechanism(path, motions, dead, live, fails)
    found.least, found.most

Of a motion that is nearly a mechanism: which ends of contacts part, which faces slide, which way. A linear programme finds the nearest motion in which all others are closed and stick, exactly. Another
one finds the least and the largest factor with forces in equilibrium, within the strengths, nothing at ends that part beyond the tensile strength, and all of the friction, against the motion, on faces that slide.
Motion and forces are what Coulomb friction without dilation asks of blocks that begin to move: a complete solution (Ferris and Tin-Loi 2001). Below `least` and above `most` this mechanism cannot go on; others may.
"""

from dataclasses import dataclass

import numpy as np
import scipy

MOVES = (1e-3, 1e-2, 1e-4, 1e-5)  # of the fastest contact: slower ones do not move
SURE = 1e-6  # of the heaviest load, or of the fastest contact: largest error of a check
SHARP = {"primal_feasibility_tolerance": 1e-9, "dual_feasibility_tolerance": 1e-9}


@dataclass
class Mechanism:
    least: float
    most: float  # inf: friction grows with the loads
    motion: np.ndarray  # (3 k,) of the free bodies, the fastest contact 1
    parting: int  # ends of contacts
    sliding: int  # contacts
    error: float  # of all checks


def mechanism(path, motions, dead, live, fails):
    """Returns the Mechanism of the first of some motions that is near one; None: none is. dead, live: loads (n, 3). fails: factor at which the blocks move, so it must do there or below."""
    dead, live = path.p.rows(dead), path.p.rows(live)
    for motion in motions:
        for slow in MOVES:
            found = exact(path, motion, slow, dead, live)
            if found and found.error < SURE and found.least <= (1 + SURE) * fails:
                return found
    return None


def exact(path, motion, slow, dead, live):
    m, along = path.m, path.faces.T.tocsr()
    motion = motion / np.abs(along @ motion).max()
    speed = along @ motion
    parts, slides = speed[: 2 * m] > slow, np.sign(speed[2 * m :]) * (np.abs(speed[2 * m :]) > slow)
    moves = nearest(path, motion, parts, slides, along)
    if moves is None or not live @ moves > SURE * np.abs(live).max():
        return None
    moves /= np.abs(along @ moves).max()
    ends = [forces(path, parts, slides, dead, live, sign) for sign in (1.0, -1.0)]
    if ends[0] is None:
        return None
    error = max(checks(path, moves, x, dead, live) for x in ends if x is not None)
    return Mechanism(float(ends[0][-1]), float(ends[1][-1]) if ends[1] is not None else np.inf, moves, int(parts.sum()), int(np.abs(slides).sum()), error)


def nearest(path, motion, parts, slides, along):
    """Returns the motion nearest to one, in sum, with given ends that part and faces that slide; None: there is none."""
    n, m = len(motion), path.m
    still = scipy.sparse.vstack([along[: 2 * m][~parts], along[2 * m :][slides == 0], path.held.T])
    goes = scipy.sparse.vstack([along[: 2 * m][parts], scipy.sparse.diags(slides[slides != 0]) @ along[2 * m :][slides != 0]])
    one = scipy.sparse.eye(n)
    equal = scipy.sparse.bmat([[still, None, None], [one, -one, one]]) if still.shape[0] else scipy.sparse.hstack([one, -one, one])
    over = scipy.sparse.hstack([-goes, scipy.sparse.csr_matrix((goes.shape[0], 2 * n))])
    done = scipy.optimize.linprog(np.repeat([0.0, 1.0, 1.0], n), over, np.zeros(goes.shape[0]), equal, np.concatenate([np.zeros(still.shape[0]), motion]),
                                  [(None, None)] * n + [(0, None)] * 2 * n, options=SHARP)  # fmt: skip
    return done.x[:n] if done.status == 0 else None


def forces(path, parts, slides, dead, live, sign):
    """Returns (forces, reactions, factor) with the least (sign 1) or the largest (-1) factor; None: there are none."""
    m, h = path.m, path.held.shape[1]
    most = scipy.sparse.hstack([scipy.sparse.diags(path.friction)] * 2)
    shear = [scipy.sparse.hstack([-most, way * scipy.sparse.eye(m), scipy.sparse.csr_matrix((m, h + 1))]).tocsr() for way in (1.0, -1.0)]
    against = [slides < 0, slides > 0]  # the shear force is all of its strength
    equal = scipy.sparse.vstack([scipy.sparse.hstack([path.faces, path.held, scipy.sparse.csr_matrix(live[:, None])]), *(rows[full] for rows, full in zip(shear, against))])
    over = scipy.sparse.vstack([rows[~full] for rows, full in zip(shear, against)])
    low, high = np.full(3 * m + h + 1, -np.inf), np.full(3 * m + h + 1, np.inf)
    low[: 2 * m], low[-1] = np.tile(-path.tension, 2), 0.0
    high[: 2 * m][parts] = low[: 2 * m][parts]
    done = scipy.optimize.linprog(sign * np.eye(1, 3 * m + h + 1, 3 * m + h)[0], over, np.concatenate([path.cohesion[~full] for full in against]), equal,
                                  np.concatenate([-dead, *(path.cohesion[full] for full in against)]), np.column_stack([low, high]), options=SHARP)  # fmt: skip
    return done.x if done.status == 0 else None


def checks(path, motion, x, dead, live):
    """Returns the largest error of a motion and forces: equilibrium, strengths, ends that overlap, forces at ends that part, friction that does not go against the sliding. It knows nothing of how they were found."""
    m, h = path.m, path.held.shape[1]
    normal, shear, speed = x[: 2 * m], x[2 * m : 3 * m], path.faces.T @ motion
    most = path.friction * (normal[:m] + normal[m:]) + path.cohesion
    opening, sliding = speed[: 2 * m], speed[2 * m :]
    return float(max(np.abs(path.faces @ x[: 3 * m] + path.held @ x[3 * m : 3 * m + h] + dead + x[-1] * live).max(), -(normal + np.tile(path.tension, 2)).min(), (np.abs(shear) - most).max(), -opening.min(),
                     np.minimum(opening, normal + np.tile(path.tension, 2)).max(), np.minimum(np.abs(sliding), most + shear * np.sign(sliding)).max(), 0.0))  # fmt: skip
