"""Writes the part of the sheet about lifts: the gravity method on level sections over the height."""

from quoin_tools.assess import lifts
from quoin_tools.assess.assessment import cell
from quoin_tools.base.language import N_, _, ngettext, numeral
from quoin_tools.base.results import sliding
from quoin_tools.show.hypertext import esc, head, small, table

COLUMNS = (N_("level [m]"), N_("length [m]"), N_("strength of"), N_("N [kN]"), N_("T [kN]"), N_("sliding factor"), N_("block model"), N_("friction needed [°]"), N_("stress at the heel [kPa]"), N_("stress at the toe [kPa]"), N_("crack [m]"), N_("uplift [kN]"))


def row_of(lift):
    hand, own = lift.hand, lifts.factors(lift.hand, lift.strength)["peak"]
    stands, stress = hand.crack is not None, hand.linear if lift.heel == "start" else hand.linear[::-1]
    return (cell(lift.level, 2), cell(lift.base.length, 2), lift.source, cell(hand.N / 1e3, 0), cell(hand.T / 1e3, 0), sliding(own, 2) if stands else _("no equilibrium"), sliding(lift.block, 2),
            cell(hand.friction_needed, 1), *(cell(s / 1e3, 0) for s in stress), cell(hand.crack, 2), cell(hand.uplift / 1e3, 0))  # fmt: skip


def chosen(found, most):
    """Rows of a table of that length: evenly over the height, with the worst."""
    if len(found) <= most:
        return found
    kept = {round(k * (len(found) - 1) / (most - 1)) for k in range(most)}
    kept = sorted(kept - {min(kept, key=lambda k: abs(k - found.index(lifts.worst(found))))} | {found.index(lifts.worst(found))})
    return [found[k] for k in kept]


def words(stage, found):
    """The lift that counts, named."""
    worst = lifts.worst(found)
    if worst.factor is not None:
        return _("Least sliding factor in stage {0}: {1} at {2:.2f} m ({3}).", stage, sliding(worst.factor, 2), worst.level, worst.source)
    return _("No strength of the lifts is known (--strength-on lifts=PHI,C). In stage {0} most friction, {1:.1f} degrees, is needed at {2:.2f} m.", stage, worst.hand.friction_needed, worst.level)


def uplift_words(found):
    if any(lift.line for lift in found):
        return _("Uplift in the lifts runs straight between the levels of the water, as the base is wet: drains are those of the base.")
    return _("Uplift in the lifts is that of the scene.") if any(lift.hand.uplift for lift in found) else _("There is no uplift in the lifts: --uplift sets it.")


def lifts_part(case, stage, found, left_out, most):
    """A table of at most so many lifts from the highest down; nothing without."""
    if not found:
        return ""
    left = _("Left out, no single piece: {0} m.", "; ".join(numeral(f"{y:.2f}") for y in left_out)) if left_out else ""
    more = ngettext("{0} more lift is in the annex.", "{0} more lifts are in the annex.", len(found) - most) if len(found) > most else ""
    return (head(_("Lifts")) + f"<p><b>{esc(words(stage, found))}</b></p>" + table(map(_, COLUMNS), [row_of(lift) for lift in reversed(chosen(found, most))], (0, 1, *range(3, 12)))
            + small(_("Level sections by the gravity method, as the base; a bed joint has its own strength and the block model's factor beside it."), uplift_words(found), left, more))  # fmt: skip
