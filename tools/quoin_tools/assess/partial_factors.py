"""Holds partial factors of a guideline against a base: on friction and cohesion, on actions by their kind; and the run with design strengths.

    least = least_of(found, shares)           function of a limit sliding_partial: (N tan(phi) / F_phi + c L / F_c) / T with factored actions
    judged(case, stage)                       whether the block model stands with design strengths, for each stage that tries it

A stage of the run has design strengths where it has friction_factor, cohesion_factor or loads with a partial_factor; it belongs to the case from
which it starts. A judged stage that has factors itself lacks only what the guideline has beyond them.
"""

from dataclasses import dataclass, replace

import numpy as np

from quoin_tools.assess import guidelines
from quoin_tools.assess.broken import with_water
from quoin_tools.assess.gravity import Uplift
from quoin_tools.assess.guidelines import Judged
from quoin_tools.assess.strength import factors
from quoin_tools.base.language import _, numeral
from quoin_tools.base.results import NO_SHEAR

ACTIONS = {"self_weight": "self_weight", "reservoir": "water", "overflow": "water", "wave": "water", "tailwater": "tailwater", "uplift": "uplift", "silt": "silt", "ice": "ice", "pseudo_static": "earthquake"}  # types of loads; any other: other
ALIKE = 1e-3  # relative: two factors are the same
FAVOURABLE = ("self_weight", "tailwater")  # as quoin new takes actions, before it knows the dam


@dataclass
class Acting:
    """What acts on the part above a base. forces: (X, Y, M) of each load; kinds: its action; own: the partial factor that it has in the run; rest: (X, Y, M)
    without factors, of anchors; water, beside: as in hand_method, with `wet`, the partial factor that they have; strengths: partial factors on friction and cohesion of the stage."""

    forces: dict
    kinds: dict
    own: dict
    rest: np.ndarray
    water: Uplift | None = None
    beside: np.ndarray | None = None
    wet: float = 1.0
    strengths: tuple = (1.0, 1.0)


def acting(case, stage, forces, rest, water, beside):
    loads = {name: case.scene.loads.get(name, {}) for name in case.scene.stages.get(stage, {}).get("loads") or ()}
    own = {name: float(load.get("partial_factor", 1)) for name, load in loads.items()}
    wet = next((own[name] for name, load in loads.items() if load.get("type") == "uplift" and not case.options.uplift), 1.0)
    return Acting(forces, {name: kind_of(load) for name, load in loads.items()}, own, rest, water, beside, wet, case.scene.strength_factors(stage))


def kind_of(load):
    return ACTIONS.get(load.get("type"), "other")


def pair(actions, kind):
    """Returns the factors (favourable, unfavourable) on a kind of actions."""
    value = actions.get(kind, 1.0)
    return (value["favourable"], value["unfavourable"]) if isinstance(value, dict) else (value, value)


def hand_with(found, entry):
    """Returns (the gravity method with factored actions, whether a factor changes one): of each load the factor for what it does to N tan(phi) / F_phi - T."""
    base, all_of, actions = found.base, found.acting, entry["actions"]
    under = all_of.water.forces(base, 0.0) if all_of.water else np.zeros(3)
    beside = np.zeros(3) if all_of.beside is None else all_of.beside
    way = np.sign(base.resultants(sum(all_of.forces.values(), all_of.rest + under + beside))[1])
    slope = np.tan(np.radians(found.strength["friction"])) * all_of.strengths[0] / entry["friction"]

    def factor(force, kind, own):
        N, T, _moment = base.resultants(force)
        favourable, unfavourable = pair(actions, kind)
        return (favourable if N * slope - way * T >= 0 else unfavourable) / own

    on = {name: factor(force, all_of.kinds.get(name, "other"), all_of.own.get(name, 1.0)) for name, force in all_of.forces.items()}
    on_water, on_beside = factor(under, "uplift", all_of.wet), factor(beside, "uplift", all_of.wet)
    used = [x for name, x in on.items() if np.any(all_of.forces[name])] + [on_water] * (all_of.water is not None) + [on_beside] * (all_of.beside is not None)
    dry = sum((on[name] * force for name, force in all_of.forces.items()), all_of.rest)
    water = all_of.water and replace(all_of.water, unit_weight=all_of.water.unit_weight * on_water)
    return with_water(base, dry, water, None if all_of.beside is None else on_beside * beside), any(abs(x - 1) > ALIKE for x in used)


def with_factors(shares, on_friction, on_cohesion):
    """Least (N tan phi / F_phi + c L / F_c) / T. shares: (factor by friction alone, factor with cohesion) of each method."""
    return min(np.inf if np.isinf(peak) else friction / on_friction + (peak - friction) / on_cohesion for friction, peak in shares)


def least_of(found, shares):
    """Returns the function of a limit sliding_partial to the number held against it: the worse of the shares of block model and gravity method; where
    factors change actions of the gravity method alone, as the run has the actions as they are."""
    def least(entry):
        rows = shares
        if entry.get("actions"):
            hand, changed = hand_with(found, entry)
            if changed:
                own = factors(hand, found.strength)
                rows = [(0.0, 0.0) if hand.crack is None else (own["friction_only"], own["peak"])]
        return with_factors(rows, *(asked / mine for asked, mine in zip((entry["friction"], entry["cohesion"]), found.acting.strengths if found.acting else (1.0, 1.0))))

    return least


def refuse(found, judged):
    """Gives a judged limit the reason why the gravity method finds no equilibrium, with its factors on actions or without, and the base a note where they are the reason."""
    hand, changed = hand_with(found, judged.entry) if judged.entry.get("actions") else (found.governing, False)
    judged.refused = hand.refused
    if changed and hand.refused:
        found.notes.append(_("Gravity method with factored loads: no equilibrium without tension, {0}; the sliding factor with partial factors counts as 0.", hand.refused))


def of_lift(lift, entry):
    """The number of a limit sliding_partial at a lift, by the gravity method with the actions as they are: 0 without equilibrium."""
    own = factors(lift.hand, lift.strength)
    return 0.0 if lift.hand.crack is None or own["peak"] is None else with_factors([(own["friction_only"], own["peak"])], entry["friction"], entry["cohesion"])


# ---- the run with design strengths


def of_case(case, stage):
    """Returns the stages with partial factors that start from the end of a stage."""
    return [name for name in case.scene.stages if case.scene.stages[name].get("type", "static") == "static" and case.scene.is_design(name) and case.scene.stages_before(name)[-1:] == [stage]]


def evidence(case, design, entry):
    """What a stage says about a limit: 1, it stands with its factors or larger ones on strengths; 0, it does not with its factors or smaller ones; None: nothing."""
    def fits(load):
        own = float(load.get("partial_factor", 1))
        return any(abs(own - asked) <= ALIKE * own for asked in pair(entry.get("actions") or {}, kind_of(load)))

    if not all(fits(case.scene.loads[name]) for name in case.scene.stages[design].get("loads") or () if name in case.scene.loads):
        return None
    ratios, value = [own / asked for own, asked in zip(case.scene.strength_factors(design), (entry["friction"], entry["cohesion"]))], stands(case, design)
    says = {1.0: min(ratios) >= 1 - ALIKE, 0.0: max(ratios) <= 1 + ALIKE, None: False}
    return value if says[value] else None


def stands(case, design):
    """Whether a stage has found its equilibrium: 1, 0, or None without a result."""
    verdict = case.results.stage_summary(design)["verdict"] if design in case.results.stages else None
    return {"converged": 1.0, "collapsed": 0.0}.get(verdict)


def judged(case, stage):
    """Limits of the guideline on the run with design strengths of a judged stage: what each stage that tries it says, not judged where they say nothing; none where no stage tries it."""
    guideline, condition = guidelines.of(case.options), case.conditions.get(stage)
    entry = (guideline or {"conditions": {}})["conditions"].get(condition, {}).get("sliding_partial")
    if entry is None or None in guidelines.partial_numbers(entry):
        return []
    designs = of_case(case, stage)
    said = [(value, dict(zip(("friction", "cohesion"), case.scene.strength_factors(design)))) for design in designs if (value := evidence(case, design, entry)) is not None]
    return [Judged("stands", 1.0, value, guidelines.verdict_of("stands", 1.0, value, entry["read"] == "document"), entry | mine) for value, mine in said or [(None, {})] * bool(designs)]


def by_hand(found, design):
    """Returns the least sliding factor of the gravity method in a stage with partial factors; None without strengths."""
    own = [factors(a.governing, a.strength)["peak"] if a.governing.crack is not None else 0.0 for a in found if a.stage == design]
    return min((factor for factor in own if factor is not None), default=None)


def words(case, found, design):
    """Says what the run and the gravity method find with the factors of a stage."""
    answer, least = {1.0: _("stands"), 0.0: _("does not stand"), None: _("no result")}, by_hand(found, design)
    run = _("design strengths, {0:g} on friction, {1:g} on cohesion: {2}", *case.scene.strength_factors(design), answer[stands(case, design)])
    if least is None:
        return run
    return _("{0}; gravity method {1}: {2}", run, "∞" if least > NO_SHEAR else numeral(f"{least:.2f}"), answer[float(least >= 1)])


def summary(case, found):
    """Says in a line how many stages with partial factors stand, and which do not; "" without any."""
    designs = [s["name"] for s in case.results.summary["stages"] if s["name"] not in case.conditions and case.scene.is_design(s["name"])]
    if not designs:
        return ""
    fallen, weak = [name for name in designs if stands(case, name) != 1], [name for name in designs if (least := by_hand(found, name)) is not None and least < 1]
    text = _("With design strengths {0} of {2} cases stand in the run, {1} of {2} by the gravity method.", len(designs) - len(fallen), len(designs) - len(weak), len(designs))
    named = ", ".join(dict.fromkeys(fallen + weak))
    return text + (" " + _("Not so: {0}.", named) if named else "")
