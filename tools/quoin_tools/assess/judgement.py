"""Judges a base by a guideline: holds the less favourable number of the block model and of the gravity method against each limit.

    judged(case, found, flawed)     found, an assessment.Assessment, with its limits
"""

import numpy as np
import shapely

from quoin_tools.assess import combinations, crack_notes, guidelines, partial_factors, planes, section_cut
from quoin_tools.assess.base_water import water_levels
from quoin_tools.assess.strength import factors
from quoin_tools.base.language import _
from quoin_tools.mesh import blockmesh

SOME = 0.01  # of a block above a path


def local_factor(facts):
    """Least local failure factor (39)-(41) of a stage's summary; None where no material has strengths."""
    values = [group["value"] for group in (facts.get("safety") or {}).values() if group["value"] is not None]
    return min(values, default=None)


def least_favourable(found, strength, facts):
    """Quantity of guidelines.py to the worse of the block model's number and the gravity method's. facts: summary of the stage."""
    length, block = found.base.length, found.block or {}
    hands = [found.governing, *([found.hand] if found.computed is not None and found.with_uplift else [])]  # computed water counts beside a rule
    refused = [hand.crack is None for hand in hands]
    own = [factors(hand, found.strength) for hand in hands]

    def least(key):
        return [0.0 if none else each[key] for none, each in zip(refused, own)]

    both = {
        "sliding_peak": (min, [*least("peak"), block.get("peak")]),
        "sliding_residual": (min, [*least("residual"), block.get("residual")]),
        "friction_only": (min, [*least("friction_only"), friction_of(block, found.strength)]),
        "flotation": (min, [np.inf if not hand.uplift else (hand.N + hand.uplift) / hand.uplift for hand in hands]),
        "middle": (max, [2 * abs(hand.eccentricity) / length if hand.N > 0 else np.inf for hand in hands]),
        "crack": (max, [1.0 if none else hand.crack / length for none, hand in zip(refused, hands)]),
        "tension": (max, [max(*hand.linear, 0.0) for hand in hands]),
        "local_factor": (min, [local_factor(facts)]),
        "strength": (max, [None if none or not strength else hand.compression / strength for none, hand in zip(refused, hands)]),
    }
    if block and (found.with_uplift is None or found.computed is not None):
        both["crack"][1].append(block["crack"] / length)
        both["middle"][1].append(2 * abs(block["M"] / block["N"]) / length if block["N"] > 0 else np.inf)
        both["flotation"][1].append((block["N"] + block["uplift"]) / block["uplift"] if block.get("uplift") else np.inf)
    if own[0]["peak"] is None:
        both |= {name: (min, []) for name in ("sliding_peak", "sliding_residual", "friction_only")}
    numbers = {name: [x for x in values if x is not None] for name, (_, values) in both.items()}
    shares = [(0.0, 0.0) if none else (each["friction_only"], each["peak"]) for none, each in zip(refused, own)] + [(friction_of(block, found.strength), block.get("peak"))]
    shares = [pair for pair in shares if None not in pair] if own[0]["peak"] is not None else []
    return {name: both[name][0](values) if values else None for name, values in numbers.items()} | {"sliding_partial": partial_factors.least_of(found, shares) if shares else None}


def friction_of(block, strength):
    """The sliding factor of the block model by friction alone; None where the joint has several angles or the state moves."""
    if block.get("friction_only") is not None or block.get("peak") is None:
        return block.get("friction_only")
    one_angle = len({own["friction"] for _, _, own in strength.get("spans") or ()}) < 2
    return float(max(block["N"], 0.0) * np.tan(np.radians(strength["friction"])) / abs(block["T"])) if one_angle and block["T"] else None


def one_sided_uplift(found):
    """Numbers with uplift in one column and without in the other are no basis for a pass."""
    block, hand = ((found.block or {}).get("uplift") or 0.0), found.governing.uplift
    least = 1e-6 * max(abs(found.hand.N), 1.0)
    if found.block and (block > least) != (hand > least):
        found.complete = False
        force = max(block, hand) / 1e3
        found.notes.append(_("Uplift ({0:.1f} kN) acts in the block model only: what is judged of the gravity method is without it.", force) if block > least else
                           _("Uplift ({0:.1f} kN) acts in the gravity method only: what is judged of the block model is without it.", force))  # fmt: skip


def compressive_strength(case, found):
    """[Pa] of the options, else the least of the blocks that stand on the path, where all of them have one."""
    if case.options.strength is not None:
        return case.options.strength
    mesh, part = case.mesh, case.part(found.name, found.path)
    touch = shapely.distance(shapely.polygons(mesh.vertices[blockmesh.closed_rings(mesh)]), section_cut.LineString(found.path)) <= section_cut.GAP
    return weakest(case, touch & (part.share > SOME))


def weakest(case, blocks):
    """[Pa] The least compressive strength of these blocks; None where one of them has none."""
    values = [case.scene.materials.get(case.mesh.group_names[row], {}).get("compression") for row in np.unique(case.mesh.block_group[blocks])]
    return min(values) if values and all(isinstance(value, (int, float)) for value in values) else None


def judge(case, found):
    """Limits of the guideline of the options, in the stages that are to be judged."""
    o, stage = case.options, found.stage
    found.condition = case.conditions.get(stage)
    if not o.guideline or not found.condition:
        return
    if any(level is not None for level in water_levels(case, stage, found.base)) and found.water is None and not found.other_water:
        found.complete = False
        found.notes.append(_("There is water but no uplift in these numbers; the guideline's limits presuppose uplift."))
    one_sided_uplift(found)
    guideline = guidelines.of(o)
    rule = guideline.get("uplift")
    own = found.with_uplift is not None or (found.water is not None and found.water.heads.drain is not None)  # loads of the scene without a drain are one line by any rule
    if found.water is not None and rule and rule != found.water.rule and own:
        found.complete = False
        found.notes.append(_("Uplift follows rule {0}; this guideline goes with rule {1}.", found.water.rule, rule))
    if found.water is None and found.computed is not None and rule:
        found.complete = False
        found.notes.append(_("Uplift is the computed one; this guideline goes with rule {0}: --uplift {0} sets it beside.", rule))
    differing, weaker = crack_notes.of_water(case, found)
    found.notes += crack_notes.of_start(case, found) + differing
    found.complete &= not weaker
    if found.condition not in guideline["conditions"]:
        found.complete = False
        found.notes.append(_("This guideline has no limits for the condition {0}.", _(found.condition)))
    if together := combinations.excluded(case, stage, found.condition):
        found.complete = False
        found.notes.append(_("No load combination of this guideline that is {0} allows {1} with the other loads of this case.", _(found.condition), ", ".join(map(_, together))))
    elif combinations.none_belongs(case, stage, found.condition):
        found.complete = False
        found.notes.append(_("No load combination of this guideline that is {0} has the loads of this case: hold its limits against the combination that has (--condition).", _(found.condition)))
    found.plane = planes.plane_of(case, found.name, found.path) if any(guideline.get("planes", {}).values()) else found.plane
    found.limits = guidelines.judge(guideline, found.condition, least_favourable(found, compressive_strength(case, found), case.results.stage_summary(stage)), o.given, plane=found.plane, sure=not crack_notes.is_unconfirmed(found.governing))
    for row in found.limits:
        if row.quantity == "sliding_partial" and row.value == 0:
            partial_factors.refuse(found, row)


def judged(case, found, flawed):
    """An assessment with its limits; flawed: its stage is no basis for a verdict."""
    found.complete &= not flawed
    judge(case, found)
    return found
