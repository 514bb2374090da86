"""Finds the design point: where failure is most likely, in the space of independent normal numbers. Samples about it find rare failures.

By the rule of Hasofer, Lind, Rackwitz and Fiessler, with slopes by differences, from the mean. It needs a number that fails, at every sample that it asks for.
"""

import numpy as np

from quoin_tools.ensemble.variables import EnsembleError

STEP, ROUNDS, CLOSE = 0.02, 40, 1e-3  # of the differences; most rounds; change of the point at which it ends
FARTHER, BESIDE = 1.25, 0.5  # distance at which other failure modes are searched, over the distance of the point; cosine: one limit that is flat fails there beyond 0.8 only


def design_point(design, model):
    """Returns (point (k,), its distance from the mean, number of samples used)."""
    asked, k = 0, len(design.columns())

    def margins(points):
        nonlocal asked
        found = []
        for values in design.variables.values(np.array(points)):
            outcome, response, why = model.judge(tuple(values), -1 - asked, design.levels[0])
            asked += 1
            if response is None:
                raise EnsembleError(f"method: importance: no number {design.condition.path} ({outcome}{', ' + why if why else ''}) at {dict(zip(design.columns(), values))}")
            found.append(design.condition.margin(response))
        return found

    point = np.zeros(k)
    for _ in range(ROUNDS):
        here, *beside = margins([point, *(point + STEP * row for row in np.eye(k))])
        slope = (np.array(beside) - here) / STEP
        if not np.abs(slope).max() > 0:
            raise EnsembleError("method: importance: the number does not depend on the variables near the mean")
        new = slope * (slope @ point - here) / (slope @ slope)
        close = np.abs(new - point).max() < CLOSE
        point = new
        if close:
            return point, float(np.hypot.reduce(point)), asked
    raise EnsembleError(f"method: importance: no design point in {ROUNDS} rounds; use monte_carlo or sobol")


def elsewhere(design, model, point):
    """Values at which it fails too, each variable alone to both sides, far from the direction of the design point: another way of failing, whose samples are hardly seen."""
    found, distance = [], float(np.hypot.reduce(point))
    for k, row in enumerate((*np.eye(len(point)), *-np.eye(len(point)))):
        if row @ point > BESIDE * distance:
            continue
        values = design.variables.values([FARTHER * distance * row])[0]
        if model.judge(tuple(values), -100000 - k, design.levels[0])[0] == "fails":
            found.append(values)
    return found
