"""Holds the limit of a stage from both sides, with joints that slide without dilation: where blocks fail, and where they stand.

    ends = both(mesh, scene, answer)        answer: bounds.bound of the stage
    ends.lower, ends.upper, ends.gap

Above: the bound (joints that slide dilate), above which nothing stands; and paths of rigid blocks from their weight on (path.py), which end in a mechanism without dilation whose motion and forces are
checked (mechanism.py). Below: runs of the solver, with the joints of the scene and with softer ones, whose forces are checked (standing.py).
"""

import math
from dataclasses import dataclass

import numpy as np

from quoin_tools.base import joints
from quoin_tools.limit import LimitError
from quoin_tools.limit.bounds import Bound, dead_and_live
from quoin_tools.limit.mechanism import Mechanism, mechanism
from quoin_tools.limit.path import FARTHEST, Path, follow
from quoin_tools.limit.standing import SURE, standing
from quoin_tools.limit.water import flowing

RATIOS = (1.0, 0.1)  # k_s of the paths, over that of the scene
MARGIN = 2e-3  # of the upper end over the last path that fails: runs with forces in corners (pt) end up to that much above their path, one of 23 by 0.3 %
BRACKET, FINE = 2.5e-3, 1e-3  # of the run as the scene is, and of the others, over the factor
SOFT = (0.125, 0.25, 0.5)  # k_n and k_s of a second run, over those of the scene
GOAL = 0.03  # of the upper end
MOST = 1500  # contacts


@dataclass
class Way:
    """A path: last factor at which blocks stand, first at which they fail (None: none is found), and the mechanism there (None: none is exact)."""

    ratio: float
    begun: float | None
    stands: float | None
    fails: float | None
    mechanism: Mechanism | None


@dataclass
class Ends:
    """lower: runs stand there whose forces are checked, with the joints of the scene and with softer ones as far as GOAL allows; None: there is none. upper: none of the paths stands above."""

    bound: Bound
    ways: list
    runs: dict  # k_n over that of the scene: Standing, or None
    lower: float | None
    upper: float

    @property
    def gap(self):
        """Difference of the ends over the upper one; None: it is not known."""
        return None if self.lower is None or math.isinf(self.upper) else 1 - self.lower / self.upper


def refusal(scene, answer):
    """Returns in a line why a stage is none for paths without dilation; None: it is one."""
    stage, parts = answer.stage, answer.parts
    kind, strengths = scene.stages[stage].get("type", "static"), parts.strengths()
    crushing = [name for name, strength in strengths.items() if math.isfinite(strength.compression)]
    if kind != "load_factor":
        return f"stage '{stage}' is of type {kind}: --both is for load_factor"
    if len(parts.ties):
        return f"stage '{stage}' has anchors: --both follows blocks and joints alone"
    for name in strengths:
        if joints.is_elastic(parts.joints[name]):
            return f"joints.{name}: law elastic has no limit: --both is for joints with friction"
    if crushing:
        return f"joints.{crushing[0]}.compression: --both is for joints without a limit in compression"
    if flows := flowing(scene, stage):
        return f"loads.{flows[0]}: water that flows in joints follows their openings: --both has none"
    if cracked := [name for name, load in scene.stage_loads(stage).items() if load.get("cracked") is True]:
        return f"loads.{cracked[0]}.cracked: water follows the crack: --both has loads that do not change as joints open"
    if len(parts.contacts) > MOST:
        return f"{len(parts.contacts)} contacts: --both is for at most {MOST}"
    return None


def both(mesh, scene, answer):
    """Returns the Ends of a stage of type load_factor."""
    if why := refusal(scene, answer):
        raise LimitError(why)
    if answer.value is None:
        raise LimitError(f"stage '{answer.stage}': no factor brings the blocks to equilibrium")
    dead, live = dead_and_live(answer)
    known = math.isfinite(answer.value)
    size = answer.value if known else np.abs(dead).max() / np.abs(live).max()
    ways = [way(answer.parts, dead, live, ratio, size, known) for ratio in RATIOS]
    fails = [one.fails for one in ways if one.fails is not None]
    most = min(answer.value, (1 + MARGIN) * max(fails)) if len(fails) == len(ways) else answer.value
    near, runs = min(fails) if fails else size, {}

    def ran(times, bracket):
        runs[times] = found = standing(mesh, scene, answer.stage, answer.parts, near, lambda factor: dead + factor * live, times, bracket)
        return found if found is not None and found.error < SURE else None

    own = ran(1.0, BRACKET)
    if own and own.value > most:  # a way that no path goes
        most = min(answer.value, own.fails or answer.value)
    lower = min(own.value, *(one.stands for one in ways if one.stands is not None)) if own else None
    times = softest(own.value, near, most) if own else None
    soft = ran(times, FINE) if times else None
    if soft and soft.value >= (1 - GOAL) * most:
        lower = min(lower, soft.value)
    return Ends(answer, ways, runs, lower, most)


def softest(own, near, most):
    """Returns the softest joints, of SOFT, with which the gap is expected to be within GOAL; None: none are. What hinges take from the limit goes as k_n^(-1/3)."""
    return next((times for times in SOFT if near - max(near - own, 0.0) * times ** (-1 / 3) >= (1 - GOAL) * most), None)


def way(parts, dead, live, ratio, size, known):
    """Returns the Way of one path. size: of the factor."""
    path = Path(parts, dead, size * live, ratio)
    end = follow(path, lambda factor: dead + factor * size * live, known)
    begun, stands, fails = (None if one is None else float(one * size) for one in (end.begun, end.stands, end.fails))
    found = fails and mechanism(path, end.motions, dead, live, fails)
    if fails and found is None:
        found = mechanism(path, [path.trial(dead + fails * live, end.state, FARTHEST)[2]], dead, live, fails)
    return Way(ratio, begun, stands, fails, found or None)
