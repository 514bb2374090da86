"""An estimate for joints that slide without dilation, by a sequence of linear programmes with friction that goes by normal forces found before.

The associative limit lets joints that slide open by tan(phi), so it is an upper bound, and may be far off where sliding is confined. Here |T| <= tan(phi) [(1 - a) N_old + a N] + c A, with a from 0.6
down to 0.01 and N_old following slowly: what is left is hardly any dilation. It ends in a small cycle, whose mean and half width are told. It is an estimate, no bound.
"""

import math
from dataclasses import dataclass

import numpy as np

from quoin_tools.limit.program import Limit, largest, least_pressed

FIRST, LAST = 0.6, 0.01  # part of friction that follows the present normal force
FALLING, STEADY = 60, 30  # rounds in which it falls, and over which the mean is taken
FOLLOWS = 0.2  # part of the change that N_old takes over in a round


@dataclass
class Estimate:
    factor: float | None
    spread: float = 0.0  # half width of the cycle
    last: Limit | None = None
    why: str = ""


def estimate(parts, dead, live, bound):
    """bound: the associative Limit of the same loads."""
    if bound.factor is None:
        return Estimate(None, why="the bodies do not stand under the other loads")
    start = least_pressed(parts, dead) if math.isinf(bound.factor) else bound.normal.sum(axis=1)
    if start is None:
        return Estimate(None, why="the loads that stay alone find no equilibrium to start from")
    normal, found, last = start, [], None
    for follow in np.concatenate([np.geomspace(FIRST, LAST, FALLING), np.full(STEADY, LAST)]):
        answer = largest(parts, dead, live, frozen=normal, follow=float(follow))
        if answer.factor is not None and math.isinf(answer.factor):  # confined: only friction that does not follow has a limit
            answer = largest(parts, dead, live, frozen=normal, follow=0.0)
            pressed = least_pressed(parts, dead + answer.factor * (1 - 1e-9) * live) if answer.factor is not None and math.isfinite(answer.factor) else None
            if pressed is None:
                return Estimate(answer.factor, 0.0, answer, "" if answer.factor is None or math.isfinite(answer.factor) else "nothing limits these loads")
            present = pressed
        elif answer.factor is None:
            return Estimate(None, why="a round of the sequence finds no equilibrium")
        else:
            present = answer.normal.sum(axis=1)
        found.append(answer.factor)
        normal, last = normal + FOLLOWS * (present - normal), answer
    cycle = np.array(found[-STEADY:])
    return Estimate(float(cycle.mean()), 0.5 * float(np.ptp(cycle)), last)
