"""Describes what the trials of a stage raise, by one measure that grows until blocks fail: the factor of loads, the rise of a level [m], or the divisor of strengths.

    raised = raised_of(mesh, scene, answer)          answer: bounds.bound of the stage
    raised.value(1.2)                                as the stage counts: -, m, degree or -
    raised.loads(1.2), raised.reduction(1.2)         (n, 3) on the bodies; as program.strengths_of takes it
"""

import functools
import math

import numpy as np

from quoin_tools.base import joints
from quoin_tools.limit import LimitError
from quoin_tools.limit.bounds import Kept, dead_and_live
from quoin_tools.mesh.blockmesh import closed_rings

FIRST = (0.4, 0.0)  # first trials of runs, over the measure near which the limit is expected: the next run where one does not stand. Loads that grow at once to most of it may bear more than loads that grow step by step
STEP = 0.05  # over that measure
FARTHER = 1.1  # last trial of a run that begins at a measure, over that measure
RISE = 0.25  # step of a level, over the rise that is expected


class Factor:
    """Loads times a factor."""

    least = 0.0  # measure of the stage as the scene has it, or without what is raised

    def __init__(self, answer):
        self.dead, self.live = dead_and_live(answer)
        self.bound = answer.value
        self.size = answer.value if math.isfinite(answer.value) else np.abs(self.dead).max() / np.abs(self.live).max()

    def value(self, measure):
        return measure

    def measure(self, value):
        return value

    def loads(self, measure):
        return self.dead + measure * self.live

    def reduction(self, measure):
        return None

    def kept_and_pushed(self, measure):
        """Returns loads that stay, loads by which a mechanism goes on, and the multiple of those."""
        return self.dead, self.live, measure

    def gap(self, lower, upper):
        return 1 - lower / upper

    def beyond(self, measure, part):
        return (1 + part) * measure

    def trials(self, near, bracket, last):
        """Yields keys of the stage for runs, until one stands. near: measure at which the limit is expected; bracket, last: of the trials, over that. Trials that go beyond `near` end a bracket below the bound."""
        last = min(last * near, (1 - bracket) * self.bound) if last > 1 else near
        for part in FIRST:
            yield {"start": part * near, "step": STEP * near, "limit": last, "bracket": bracket * near}

    def at_once(self, measure, bracket):
        """Returns keys of the stage for a run whose first trial is at a measure."""
        return {"start": measure, "step": 2 * bracket * measure, "limit": FARTHER * measure, "bracket": bracket * measure}


class Level:
    """The level of a flood, by its rise above that of the scene. Gaps are over the height of the bodies that are free."""

    least = 0.0
    reduction = Factor.reduction

    def __init__(self, mesh, scene, answer):
        self.scene, self.stage, self.parts, self.kept = scene, answer.stage, answer.parts, Kept()
        self.kept.assembly(mesh, scene, self.stage)
        self.start = self.kept.on_faces(scene, self.stage).start
        self.bound = self.size = answer.value - self.start
        corners = self.parts.mesh.vertices[closed_rings(self.parts.mesh)[~self.parts.ground[self.parts.body]]]
        self.height = float(np.ptp(corners[..., 1]))

    def value(self, measure):
        return self.start + measure

    def measure(self, value):
        return value - self.start

    @functools.cache  # noqa: B019
    def forces(self, measure):
        return self.kept.forces(self.scene, self.stage, self.parts, None, measure)

    def loads(self, measure):
        return sum(self.forces(float(measure)).values())

    def kept_and_pushed(self, measure):
        return split(self.scene, self.forces(float(measure)))

    def gap(self, lower, upper):
        return (upper - lower) / self.height

    def beyond(self, measure, part):
        return measure + part * self.height

    def trials(self, near, bracket, last):
        width = bracket * self.height
        yield {"step": max(RISE * near, width), "limit": self.value(near + (max((last - 1) * near, 2 * width) if last > 1 else 0.0)), "bracket": width}

    def at_once(self, measure, bracket):
        """Returns keys of a run whose only trial is at a measure: trials of a flood begin at the level of the scene."""
        return {"step": measure, "limit": self.value(measure), "bracket": measure}


class Divisor:
    """Strengths over a divisor; of friction alone the angle whose tangent is the largest one over it."""

    least = 1.0
    gap, beyond = Factor.gap, Factor.beyond

    def __init__(self, scene, answer):
        keys = scene.stages[answer.stage]
        self.scene, self.all, self.what, self.only = scene, answer.loads, keys.get("what", "friction"), keys.get("reduce")
        self.only = [self.only] if isinstance(self.only, str) else self.only
        angles = {row["friction"] for name, row in answer.parts.joints.items() if not joints.is_elastic(row) and (not self.only or name in self.only)}
        self.tangent = math.tan(math.radians(max(angles)))
        self.bound = self.size = math.inf if answer.value <= 0 else self.measure(answer.value)

    def value(self, measure):
        return math.degrees(math.atan(self.tangent / measure)) if self.what == "friction" else 1 / measure

    def measure(self, value):
        return self.tangent / math.tan(math.radians(value)) if self.what == "friction" else 1 / value

    def loads(self, measure):
        return sum(self.all.values())

    def reduction(self, measure):
        return self.what, self.value(measure), self.only

    def kept_and_pushed(self, measure):
        return split(self.scene, self.all)

    def trials(self, near, bracket, last):
        for first in sorted({max(self.least, part * near) for part in FIRST}, reverse=True):
            start, next_one, last, width = (self.value(one) for one in (first, first + STEP * near, max(last * near, first), near))
            way = {"step": start - next_one} if self.what == "friction" else {"factor": next_one / start}
            yield way | {"start": start, "limit": min(last, next_one), "bracket": width - self.value((1 + bracket) * near)}

    def at_once(self, measure, bracket):
        """Returns keys of the stage for a run whose first trial is at a measure."""
        start, next_one, width = (self.value((1 + times * bracket) * measure) for times in (0, 2, 1))
        way = {"step": start - next_one} if self.what == "friction" else {"factor": next_one / start}
        return way | {"start": start, "limit": self.value(FARTHER * measure), "bracket": start - width}


def split(scene, loads):
    """Returns the weight, all other loads, and 1; of weight alone nothing and the weight."""
    none = np.zeros_like(next(iter(loads.values())))
    heavy = sum((load for name, load in loads.items() if scene.loads[name].get("type") == "self_weight"), none)
    pushed = sum((load for name, load in loads.items() if scene.loads[name].get("type") != "self_weight"), none)
    return (heavy, pushed, 1.0) if np.abs(pushed).max() > 0 else (none, heavy, 1.0)


def raised_of(mesh, scene, answer):
    """Returns the Factor, Level or Divisor of a stage."""
    if answer.kind == "load_factor":
        return Factor(answer)
    raised = Level(mesh, scene, answer) if answer.kind == "flood" else Divisor(scene, answer)
    if not math.isfinite(raised.bound):
        raise LimitError(f"stage '{answer.stage}': {'no level' if answer.kind == 'flood' else 'no reduction of the strengths'} moves the blocks, there is no end to look for")
    return raised
