"""Finds the danger level: from which level of the water a limit of the guideline is broken at a base, and from which the gravity method finds no safety left.

    danger = danger_level(case, found)       case: assessment.Case; found: its assessments
    danger.broken, danger.missing            [m], and the limit that is broken there; None: none is, up to the highest level looked at

Of a flood the waters rise that its trials have raised, uplift to the drain alone where the scene says so; of another stage the highest reservoir and
the uplift at its level. The loads at each level are asked of the solver; anchors keep their forces.
"""

from dataclasses import dataclass, replace

import numpy as np

from quoin_tools.assess import crack_start, guidelines, judgement, merged_anchors, partial_factors, section_cut
from quoin_tools.assess.base_water import scene_uplift, uplift_under
from quoin_tools.assess.combinations import closest, words_of
from quoin_tools.assess.gravity import hand_method
from quoin_tools.assess.scene_loads import SceneLoads
from quoin_tools.assess.strength import factors
from quoin_tools.assess.surface import WATERS
from quoin_tools.base.scene import raised

STEPS = 16  # levels looked at between the least and the highest
FINE = 0.005  # [m] bracket of a level
ABOVE = 0.5  # of the dam's height: how far above the crest levels are looked at
SAME = 1e-6  # [m] loads at one level rise together


@dataclass
class Danger:
    """Levels [m]; base: its name. broken None: no limit is broken up to `highest`; fails None: likewise. missing: the broken limit."""

    stage: str
    base: str
    condition: str
    start: float
    highest: float
    broken: float | None = None
    fails: float | None = None
    missing: guidelines.Judged | None = None


def stage_of(case):
    """Returns the stage whose water rises: the last flood of the run, else the first judged case with water that does not shake; None without one."""
    floods = [name for name in case.results.stages if case.scene.stages.get(name, {}).get("type") == "flood"]
    still = [name for name in case.conditions if name in case.results.stages and case.conditions[name] not in ("earthquake", "after_earthquake") and rising(case, name)]
    return floods[-1] if floods else next(iter(still), None)


def rising(case, stage):
    """Returns the loads of a stage that rise, the highest reservoir first: name to the keys that have a level."""
    trials = [trial["waters"] for trial in case.scene.trials.get(stage, {}).get("trials", ()) if "waters" in trial]
    by_run = {name: [key for key, level in water.items() if level != trials[0][name][key]] for name, water in (trials[-1] if trials else {}).items()}
    if any(by_run.values()):
        return {name: keys for name, keys in by_run.items() if keys}
    loads = {name: load for name, load in case.scene.stage_loads(stage).items() if load.get("type") in (*WATERS, "uplift") and isinstance(load.get("level"), (int, float))}
    highest = max((load["level"] for load in loads.values() if load["type"] in WATERS and load["type"] != "tailwater"), default=None)
    return {name: ["level"] for name, load in loads.items() if highest is not None and abs(load["level"] - highest) <= SAME}


def level_of(case, stage, waters):
    """Returns the level [m] of the highest reservoir of a stage. waters: as of rising(), not empty."""
    return case.scene.stage_loads(stage)[next(iter(waters))]["level"]


def failing_below(case, found, danger):
    """Lists the judged stages that break a limit of theirs though their water is below the danger level."""
    failing = dict.fromkeys(a.stage for a in found if any(limit.verdict == guidelines.FAIL for limit in a.limits))
    levels = {stage: level_of(case, stage, waters) for stage in failing if (waters := rising(case, stage))}
    return [stage for stage, level in levels.items() if danger.broken is None or level < danger.broken - FINE]


def condition_of(case, stage):
    """Returns the condition by which rising water is judged: the most that the guideline allows a flood with the drains that the stage has (ice goes with
    a flood, and decides nothing); None without a guideline."""
    guideline = guidelines.of(case.options) or {}
    limits = guideline.get("conditions", {})
    known = [name for name in ("extreme", "unusual", "usual") if any(guidelines.is_filled(limit) for limit in limits.get(name, {}).values())]
    fitting = [name for name in known if closest(guideline.get("combinations") or (), name, words_of(case, stage, name) - {"ice"})]
    return next(iter(fitting or known), None)


class Levels:
    """The gravity method of a base at any level of the water. waters: as of rising(); condition: by which it is judged; rise [m]: above the level of the scene."""

    def __init__(self, case, found, waters, condition):
        self.case, self.found, self.waters, self.hands, self.actings = case, found, waters, {}, {}
        self.part = case.part(found.name, found.path)
        self.base = replace(found.base, opens=crack_start.of(guidelines.of(case.options), condition, found.strength))
        self.anchors = merged_anchors.pulls(case, found.stage, self.part, found.path)
        self.asked = SceneLoads(section_cut.standing(case.mesh, case.scene, found.stage)[0], self.scene(0.0), floods=False)

    def scene(self, rise):
        scene, stage = self.case.scene, self.found.stage
        loads = scene.stage_loads(stage)
        higher = {name: raised(loads[name], {key: float(loads[name][key] + rise) for key in keys}) for name, keys in self.waters.items()}
        return replace(scene, loads=scene.loads | higher, stages=scene.stages | {stage: scene.stages[stage] | {"type": "static"}}, trials={})

    def hand(self, rise):
        if rise not in self.hands:
            self.hands[rise] = self.computed(rise)
        return self.hands[rise]

    def computed(self, rise):
        scene, stage, base = self.scene(rise), self.found.stage, self.base
        other = replace(self.case, scene=scene)
        forces, _left = section_cut.stage_forces(self.case.mesh, scene, stage, self.part, self.asked.of(scene, stage).table)
        water, others = scene_uplift(other, stage, self.part, base)
        rule = uplift_under(other, stage, self.found.name, base, water)
        under = rule or water, None if rule else others
        self.actings[rise] = partial_factors.acting(other, stage, forces, section_cut.total(self.anchors), *under)
        return hand_method(base, section_cut.total(forces | self.anchors), *under)

    def fails(self, rise):
        hand = self.hand(rise)
        peak = None if hand.crack is None else factors(hand, self.found.strength)["peak"]
        return hand.crack is None or (peak is not None and peak < 1.0)

    def broken(self, rise, condition):
        """Returns the limits that the base breaks at this level."""
        bare = replace(self.found, base=self.base, hand=self.hand(rise), acting=self.actings[rise], with_uplift=None, block=None, computed=None)
        values = judgement.least_favourable(bare, judgement.compressive_strength(self.case, self.found), {})
        return [row for row in guidelines.judge(guidelines.of(self.case.options), condition, values, self.case.options.given, plane=self.found.plane) if row.verdict == guidelines.FAIL]


def first(bad, start, low, high):
    """[m] Returns the rise from which `bad` holds: between the last level where it does not and the next; low where it holds at all levels below the start, None where at none."""
    if bad(start):
        levels = np.linspace(start, low, STEPS).tolist()
        good = next((rise for rise in levels[1:] if not bad(rise)), None)
        if good is None:
            return low
        worse = good + (start - low) / (STEPS - 1)
    else:
        levels = np.linspace(start, high, STEPS).tolist()
        worse = next((rise for rise in levels[1:] if bad(rise)), None)
        if worse is None:
            return None
        good = worse - (high - start) / (STEPS - 1)
    while worse - good > FINE:
        middle = 0.5 * (good + worse)
        good, worse = (good, middle) if bad(middle) else (middle, worse)
    return worse


def of_base(case, found, waters, condition):
    """The danger level of one base."""
    levels = Levels(case, found, waters, condition)
    start = level_of(case, found.stage, waters)
    bottom, crest = float(found.base.ends()[:, 1].min()), case.whole.bounds[3]
    low, high = bottom - start, max(crest + ABOVE * (crest - bottom) - start, 0.0)
    danger = Danger(found.stage, found.name, condition or "", start, start + high)
    rise = first(levels.fails, 0.0, low, high)
    danger.fails = None if rise is None else start + rise
    rise = first(lambda rise: bool(levels.broken(rise, condition)), 0.0, low, high) if condition else None
    if rise is not None:
        danger.broken, danger.missing = start + rise, levels.broken(rise, condition)[0]
    return danger


def danger_level(case, found):
    """The danger level of a run, which is worked out once: as of least_level. found: its assessments."""
    if not case.danger:
        case.danger.append(least_level(case, found))
    return case.danger[0]


def least_level(case, found):
    """The base whose limit is broken at the lowest level, else the one that fails first; None without water that rises, or where nobody asks: without a
    guideline and a flood. Without a name where it is not known: water flows in joints, or no base is one straight joint with friction."""
    stage = stage_of(case)
    asked = stage and (case.options.guideline or case.scene.stages.get(stage, {}).get("type") == "flood")
    waters = rising(case, stage) if asked else {}
    case = replace(case, scene=replace(case.scene, trials={}))  # levels as the scene has them, not those of the last stable trial
    if not waters:
        return None
    condition, flows = condition_of(case, stage), case.results.stage(stage).flow is not None
    mine = [] if flows else [of_base(case, a, waters, condition) for a in found if a.stage == stage and a.kind in ("joint", "joints") and a.base.path is None and a.strength.get("friction") is not None]
    return min(mine, key=lambda danger: (danger.broken if danger.broken is not None else np.inf, danger.fails if danger.fails is not None else np.inf), default=Danger(stage, "", "", 0.0, 0.0))
