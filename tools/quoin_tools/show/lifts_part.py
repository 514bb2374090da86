"""Writes the part of the sheet about lifts: the gravity method on level sections over the height."""

from quoin_tools.assess import lifts
from quoin_tools.assess.assessment import cell
from quoin_tools.base.results import sliding
from quoin_tools.show.hypertext import esc, table

COLUMNS = ("level [m]", "length [m]", "strength of", "N [kN]", "T [kN]", "sliding factor", "block model", "friction needed [°]", "stress at the heel [kPa]", "stress at the toe [kPa]", "crack [m]", "uplift [kN]")


def row_of(lift):
    hand, own = lift.hand, lifts.factors(lift.hand, lift.strength)["peak"]
    stands, stress = hand.crack is not None, hand.linear if lift.heel == "start" else hand.linear[::-1]
    return (cell(lift.level, 2), cell(lift.base.length, 2), lift.source, cell(hand.N / 1e3, 0), cell(hand.T / 1e3, 0), sliding(own, 2) if stands else "no equilibrium", sliding(lift.block, 2),
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
        return f"Least sliding factor in stage {stage}: {sliding(worst.factor, 2)} at {worst.level:.2f} m ({worst.source})."
    return f"No strength of the lifts is known (--strength-on lifts=PHI,C). In stage {stage} most friction, {worst.hand.friction_needed:.1f} degrees, is needed at {worst.level:.2f} m."


def uplift_words(found):
    if any(lift.line for lift in found):
        return "Uplift in the lifts runs straight between the levels of the water, as the base is wet: drains are those of the base. "
    return "Uplift in the lifts is that of the scene. " if any(lift.hand.uplift for lift in found) else "There is no uplift in the lifts: --uplift sets it. "


def lifts_part(case, stage, found, left_out, most):
    """A table of at most so many lifts from the highest down; nothing without."""
    if not found:
        return ""
    left = f"Left out, no single piece: {', '.join(f'{y:.2f}' for y in left_out)} m. " if left_out else ""
    more = f"{len(found) - most} more lifts are in the annex. " if len(found) > most else ""
    return (f"<h2>Lifts</h2><p><b>{esc(words(stage, found))}</b></p>" + table(COLUMNS, [row_of(lift) for lift in reversed(chosen(found, most))], (0, 1, *range(3, 12)))
            + f"<p><small>Level sections by the gravity method, as the base; a bed joint has its own strength and the block model's factor beside it. {esc(uplift_words(found) + left + more)}</small></p>")  # fmt: skip
