"""Says what the criteria of a guideline about cracks do on a base: where a crack starts, and where the run's own uplift in it is another one.

    found.notes += crack_notes.of_start(case, found)
    notes, weaker = crack_notes.of_water(case, found)      weaker: the run has less water in the crack than the guideline asks for, or nobody knows
"""

from dataclasses import replace

from quoin_tools.assess import broken, guidelines, uplift
from quoin_tools.assess.strength import factors
from quoin_tools.base.flow import at_end
from quoin_tools.base.language import N_, _

SAME = 0.005  # [m] shorter cracks are none
WATER = {"unchanged": N_("unchanged"), "zero": N_("zero"), "full": N_("full")}
DRAINS = {"past": N_("lost once the crack has passed them"), "lost": N_("lost in any cracked base"), "work": N_("never lost")}


def of_start(case, found):
    """Lines about the criterion by which a crack starts, where a base is in tension."""
    hand, guideline = found.governing, guidelines.of(case.options) or {}
    if hand.start is not None:
        have, least = (1e-3 * stress for stress in hand.start)
        entry = hand.base.opens.entry
        stress = _("compression without uplift") if hand.base.opens.without_uplift else _("compression with uplift")
        numbers = stress, have, least, guidelines.source_of(entry), hand.closed_by
        return [_("By the criterion of this guideline no crack starts: {0} {1:.1f} kPa, asked for at least {2:.1f} kPa ({3}). Without tension {4:.2f} m of the base would be open.", *numbers) if hand.closed_by else
                _("By the criterion of this guideline a crack starts: {0} {1:.1f} kPa, asked for at least {2:.1f} kPa ({3}).", *numbers[:4])]  # fmt: skip
    if not hand.crack or "crack_start" not in guideline or found.water and (found.water.opened or found.water.before):
        return []
    if hand.base.opens is None and hand.base.path is None:
        return [_("Where a crack starts is to be filled in for this guideline: here any tension opens the base.")]
    return [] if hand.base.opens and not hand.base.opens.without_uplift else [_("The criterion of this guideline for the start of a crack is not known on this base: here any tension opens it.")]


def is_unconfirmed(hand):
    """Tells whether a base stays closed by a criterion that was not read in its document."""
    return bool(hand.closed_by) and hand.base.opens.entry["read"] != "document"


def of_water(case, found):
    """(lines, whether the run is weaker) about the uplift load of the scene in the crack of a base, against what the guideline asks for."""
    water, guideline, given = found.scene_water, guidelines.of(case.options), case.options.given
    if water is None:
        return [], False
    crack = max(found.hand.reached if found.hand.crack is None else found.hand.crack if found.hand.crack_at == water.heel else 0.0, (found.block or {}).get("crack") or 0.0)
    rule = uplift.rule_named(water.rule)
    if water.before is None:
        asked, entry, wanting = guidelines.in_crack(guideline, "at_rest", given)
        mine, there = water.in_crack or rule.crack, crack > SAME
    else:
        asked, entry, wanting = guidelines.in_crack(guideline, "earthquake", given)
        mine, there = water.shaken or rule.shaken, max(crack, opened_in_run(case, found)) > water.before + SAME
    if there and wanting:
        return [_("The uplift in a crack that an earthquake opens depends on {0}, which is not given.", wanting)], True
    if there and asked not in (None, mine):
        return [_("Uplift of the run in the crack: {0}; this guideline asks for: {1} ({2}).", _(WATER[mine]), _(WATER[asked]), guidelines.source_of(entry))], uplift.SHAKEN_RANK[mine] < uplift.SHAKEN_RANK[asked]
    return drains(water, crack, entry) if there and asked == mine == "full" and water.before is None else ([], False)


def opened_in_run(case, found):
    """[m] The crack that the run's uplift keeps from the earthquake, though the joint may have closed again."""
    load = at_end(case.results.stage_summary(found.stage)).get("uplift", {}).get(found.scene_water.name, {})
    return load.get("opened_by_earthquake", 0.0)


def drains(water, crack, entry):
    """The same of the drains, which in a run are lost once the crack has passed them."""
    asked, drain = entry.get("drains", "past"), water.heads.drain if water.has_drain() else None
    if drain is None or asked == "past" or (asked == "lost") != (crack < drain):
        return [], False
    return [_("Drains of the run in a cracked base: {0}; this guideline asks for: {1} ({2}).", _(DRAINS["past"]), _(DRAINS[asked]), guidelines.source_of(entry))], asked == "lost"


def full_head(found, forces):
    """Describes in a note the crack that the full head would open, where this uplift ignores it."""
    if not found.governing.crack or found.governing.crack_at != found.water.heel or found.water.follows_crack():
        return []
    hand = broken.with_water(found.base, forces, replace(found.water, in_crack="full", before=None))
    if hand.crack is None:
        return [_("If the full head followed the crack, there would be no equilibrium: {0}.", hand.refused)]
    factor, more = factors(hand, found.strength)["peak"], "".join(f"; {note}" for note in hand.notes)
    return [_("If the full head followed the crack, it would be {0:.2f} m long{1}.", hand.crack, more) if factor is None else
            _("If the full head followed the crack, it would be {0:.2f} m long, sliding factor {1:.2f}{2}.", hand.crack, factor, more)]  # fmt: skip
