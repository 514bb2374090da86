"""Sweeps lift joints over the height: the gravity method on level sections of a dam, at its bed joints where it has some, else at even steps.

    for lift in sweep(case, "full", paths): print(lift.level, lift.factor)

Uplift in a lift is the scene's, where it has some there; else, where the base is wet, a straight line between the levels of the water: no
drain, as the drain of the options is that of the base.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
import shapely

from quoin_tools.assess import guidelines, merged_anchors, section_cut
from quoin_tools.assess.assessment import block_on_path
from quoin_tools.assess.base_water import (
    computed,
    heads_above,
    heel_and_levels,
    in_crack_of,
    opens,
    scene_uplift,
    shaken_hand,
    water_density,
    with_crack_before,
)
from quoin_tools.assess.gravity import Base, GravityError, Hand, Uplift, hand_method
from quoin_tools.assess.judgement import weakest
from quoin_tools.assess.strength import contacts_on, factors
from quoin_tools.assess.uplift import Heads, UpliftError
from quoin_tools.base.language import _

SLIDING = ("sliding_peak", "sliding_partial")  # limits of guidelines.py against which a lift of known strength is held
LEVEL = 1e-3  # [m] ends of a contact that is level differ by no more
COVERED = 0.99  # of a section must be contacts, else it is no bed joint
MOST = 30  # bed joints that are taken: of more, evenly chosen ones
SOUND = 0.02  # of the height: how near the ends of the range a section may be


@dataclass
class Lift:
    """A level section: strength by what; hand: the gravity method there; block: sliding factor of the block model, where it is a bed joint."""

    level: float
    base: Base
    hand: Hand
    strength: dict
    source: str
    block: float | None = None
    line: bool = False  # its uplift is the straight line
    heel: str = "start"  # the end at which the water stands
    shaken: object = None  # function: the Hand under (X, Y, M) more, of an earthquake

    @property
    def factor(self):
        """The lesser sliding factor of both methods; None without strengths, 0 without equilibrium."""
        own = 0.0 if self.hand.crack is None and self.strength else factors(self.hand, self.strength)["peak"]
        return min((x for x in (own, self.block) if x is not None), default=None)


def feet(case, found):
    """Returns the paths of bases on which a dam may stand; a path through joints counts where it parts groups, and not within a dam. found: assessments of a stage."""
    def parts_groups(a):
        share, group = case.part(a.name, a.path).share, case.mesh.block_group
        return bool(set(group[share <= 0.5]) - set(group[share > 0.5]))

    return [a.path for a in found if a.kind != "way" or parts_groups(a)]


def range_of(case, paths):
    """From the higher end of the lowest base, or from where the body ends, to the crest [m]. paths: corners of the bases."""
    _, bottom, _, crest = case.whole.bounds
    return min((max(path[0][1], path[-1][1]) for path in paths), default=bottom), crest


def bed_levels(case, stage, low, high):
    """Returns the levels [m] of level contacts, from the lowest to the highest."""
    contacts = case.results.stage(stage).contacts
    y = contacts.point[:, :, 1]
    flat = (np.abs(np.diff(y, axis=1)[:, 0]) < LEVEL) & (y.mean(axis=1) > low) & (y.mean(axis=1) < high)
    return np.unique(np.round(y[flat].mean(axis=1) / LEVEL)) * LEVEL


def section_at(case, level):
    """The section of the body at a level, from left to right (2, 2); None where it is no single piece."""
    left, _, right, _ = case.whole.bounds
    inside = shapely.intersection(shapely.LineString([(left - 1, level), (right + 1, level)]), case.whole)
    pieces = [np.array(piece.coords) for piece in shapely.get_parts(inside) if piece.length > section_cut.GAP]
    return np.array([pieces[0].min(axis=0), pieces[0].max(axis=0)]) if len(pieces) == 1 else None


def strength_at(case, stage, path):
    """Returns (keys, words, whether contacts cover it) of the strength: of the joint there, as the options say, else of the blocks."""
    contacts = case.results.stage(stage).contacts
    mine = contacts_on(path, contacts)
    covered = contacts.length[mine].sum() >= COVERED * np.hypot(*(path[1] - path[0]))
    names = [case.results.mesh.joint_names[row] for row in np.unique(contacts.joint[mine])] if covered else []
    if given := case.options.strengths.get("lifts"):
        return given, _("given"), covered
    keys = [case.scene.joint(name, stage) for name in names]
    if keys and all({k: v for k, v in key.items() if k != "damping"} == {k: v for k, v in keys[0].items() if k != "damping"} for key in keys):
        return keys[0], _("joint {0}", ", ".join(names)), covered
    return ({}, _("different joints"), covered) if keys else (*of_blocks(case, path), covered)


def of_blocks(case, path):
    """Friction and cohesion of the group that the section runs through, where it has them."""
    groups = {case.mesh.group_names[row] for row in np.unique(case.mesh.block_group[crossed(case, path)])}
    own = case.scene.materials.get(next(iter(groups)), {}) if len(groups) == 1 else {}
    if own.get("friction") is None or own.get("cohesion") is None:
        return {}, _("unknown")
    return {"friction": own["friction"], "cohesion": own["cohesion"], "friction_residual": own["friction"], "cohesion_residual": 0.0}, _("blocks of {0}", next(iter(groups)))


def crossed(case, path):
    corners = case.mesh.vertices[case.mesh.blocks][:, :, 1]
    centres = case.mesh.centres()[:, 0]
    return (corners.min(axis=1) < path[0, 1] + LEVEL) & (corners.max(axis=1) > path[0, 1] - LEVEL) & (centres > path[0, 0]) & (centres < path[1, 0])


def is_wet(case, stage):
    """Tells whether there is water under the base: by a rule of the options, by an uplift load or a head of the scene."""
    rule = case.options.uplift
    return rule != "none" if rule else any(load.get("type") in ("uplift", "head") for load in case.scene.stage_loads(stage).values())


def line_uplift(case, stage, base):
    """The straight line between the levels of the water where the base is wet, too; None above the water."""
    heel, level, tail = heel_and_levels(case, stage, base)
    head, toe = heads_above(base, heel, level, tail if case.options.tailwater is None else case.options.tailwater)
    if not head or not is_wet(case, stage):
        return None
    loads = case.scene.stage_loads(stage).values()
    keys = {"unit_weight": water_density(case, stage) * case.scene.gravity, "heel": heel} | in_crack_of(case)
    if not (case.options.uplift or any(load.get("cracked") in (True, 1) for load in loads)):
        keys["in_crack"] = "unchanged"  # as the scene has it under the base
    return Uplift("linear", Heads(base.length, head, toe or 0.0), case.options.direction, **keys)


def assess_lift(case, stage, level):
    path = section_at(case, level)
    if path is None:
        raise GravityError("no single piece: an opening, or several bodies")
    part = case.part(f"lift at {level:.4f}", path)
    base = Base(path[0], path[1], case.scene.thickness)
    forces, _ = case.forces(stage, part)
    dry = section_cut.total(forces | merged_anchors.pulls(case, stage, part, path))
    under, others = scene_uplift(case, stage, part, base)
    others = others + computed(case, stage, part)
    known = (under is not None or others.any()) and not case.options.uplift
    line = None if known else line_uplift(case, stage, base)
    beside = None if line else others
    strength, source, covered = strength_at(case, stage, path)
    base.opens = opens(case, stage, strength)
    water = with_crack_before(case, stage, base, line or under, forces, section_cut.total(merged_anchors.pulls(case, stage, part, path)), beside)
    hand = hand_method(base, dry, water, beside)
    block = block_on_path(case, stage, path, base, strength) if covered else None
    return Lift(level, base, hand, strength, source, (block or {}).get("peak"), line is not None, heel_and_levels(case, stage, base)[0], partial(shaken_hand, case, base, strength, dry, water, beside))


def sweep(case, stage, paths):
    """Returns (lifts from the lowest up, levels left out) of a stage; none of one that diverged, whose loads are no numbers. paths: corners of its bases."""
    found, left_out = [], []
    if case.options.lifts < 1 or case.results.stage_summary(stage)["verdict"] == "diverged":
        return found, left_out
    low, crest = range_of(case, paths)
    margin = SOUND * (crest - low)
    levels = bed_levels(case, stage, low + margin, crest - margin)
    beds = [y for y in levels if (path := section_at(case, y)) is not None and strength_at(case, stage, path)[2]]
    if len(beds) > MOST:
        beds = [beds[k] for k in np.linspace(0, len(beds) - 1, MOST).round().astype(int)]
    steps = beds or list(low + (crest - low) * np.arange(1, case.options.lifts) / case.options.lifts)
    for level in steps:
        try:
            found.append(assess_lift(case, stage, float(level)))
        except (GravityError, UpliftError):
            left_out.append(float(level))
    return found, left_out


def crushes(case, lift):
    """[Pa] Returns the compressive strength at a lift: of the options, else the least of the blocks there; None where one of them has none."""
    return case.options.strength or weakest(case, crossed(case, np.array(lift.base.ends())))


def judged(case, stage, found):
    """Limits of the guideline on the stresses of lifts, each held against the worst lift. found: lifts of a stage."""
    guideline, condition = guidelines.of(case.options), case.conditions.get(stage)
    if guideline is None or condition is None:
        return []
    worst_of = {"lift_strength": [], "lift_tension": []}
    for lift in found:
        strength = crushes(case, lift)
        if strength:
            worst_of["lift_strength"].append(max(lift.hand.compression or 0.0, -min(lift.hand.linear)) / strength)
            worst_of["lift_tension"].append(max(*lift.hand.linear, 0.0) / strength)
    values = {name: max(numbers) if len(numbers) == len(found) > 0 else None for name, numbers in worst_of.items()}
    return guidelines.judge(guideline, condition, values, case.options.given, lifts=True) if found else []


def worst(found):
    """The lift with the least sliding factor, else the one that needs most friction; None without any."""
    strong = [lift for lift in found if lift.factor is not None]
    return min(strong, key=lambda lift: lift.factor) if strong else max(found, key=lambda lift: lift.hand.friction_needed, default=None)
