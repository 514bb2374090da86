"""Says in a table and sentences where blocks stand and fail whose joints slide without dilation (limit/both.py), for `quoin limit --both`."""

import math

from quoin_tools.base.terminal import table
from quoin_tools.limit.both import GOAL

HEADER = ("stage", "lower end", "upper end", "gap", "bound (joints dilate)")


def text_of(all_ends):
    """Returns lines about some Ends."""
    if not all_ends:
        return []
    rows = [(ends.bound.stage, number(ends.lower), number(ends.upper), "-" if ends.gap is None else f"{100 * ends.gap:.2g} %", number(ends.bound.value)) for ends in all_ends]
    return ["", "Without dilation, loads times:", *table(HEADER, rows), *(f"  {ends.bound.stage}: {line}" for ends in all_ends for line in (*upper(ends), *lower(ends), *doubts(ends)))]


def number(value):
    return "-" if value is None else "none" if math.isinf(value) else f"{value:.5g}"


def upper(ends):
    """Lists in sentences what the paths of rigid blocks find."""
    sentences = []
    for way in ends.ways:
        blocks = "Rigid blocks with k_s as in the scene" if way.ratio == 1 else f"Rigid blocks with {way.ratio:g} of k_s"
        begin = "from their weight on" if not way.begun else f"put under {number(way.begun)} times the loads at once"
        if way.stands is None:
            sentences.append(f"{blocks} do not stand, neither under the other loads alone nor with half or three quarters of the bound at once.")
        elif way.fails is None:
            sentences.append(f"{blocks}, {begin}, stand at {number(way.stands)}; farther on no motion was found.")
        elif way.mechanism is None:
            sentences.append(f"{blocks}, {begin}, stand at {number(way.stands)} and move on and on at {number(way.fails)}; their motion is no mechanism that passes its check to 1e-6.")
        else:
            found = way.mechanism
            snap = ": less than where the blocks stood, which lose forces as they begin to move" if way.stands > found.most * (1 + 1e-9) else ""
            sentences.append(f"{blocks}, {begin}, stand at {number(way.stands)} and fail at {number(way.fails)}: {found.parting} ends of faces part, {found.sliding} faces slide. Mechanism and forces, checked to"
                             f" {max(found.error, 1e-12):.0e}, go together at factors from {number(found.least)} to {number(found.most)}{snap}.")  # fmt: skip
    return sentences


def lower(ends):
    """Lists in sentences what the runs say."""
    sentences = []
    for times, run in ends.runs.items():
        what = "A run with the joints of the scene" if times == 1 else f"A run with {times:g} of k_n and k_s"
        if run is None:
            sentences.append(f"{what} stands at no factor.")
            continue
        end = "was not decided farther on" if run.fails is None else f"fails at {number(run.fails)}"
        below = " (below the lower end, which holds for the joints of the scene)" if run.value < (ends.lower or 0.0) else ""
        sentences.append(f"{what} stands at {number(run.value)} and {end}{below}; its forces hold equilibrium and strengths, checked apart, to {run.error:.0e} of the heaviest load.")
    return sentences


def doubts(ends):
    """Lists in sentences what the ends are not."""
    sentences = []
    if ends.gap is not None and ends.gap > GOAL:
        sentences.append(f"THE GAP IS LARGER THAN {100 * GOAL:g} %: hinges that are pressed over a length, joints that lose their cohesion, a run that was not decided, or friction with several limits.")
    if ends.lower is None:
        sentences.append("THERE IS NO LOWER END: no run stands whose forces pass their check.")
    return [*sentences, "The bound alone is a theorem: nothing stands above it. Both ends hold for blocks that are loaded from their weight on; without dilation the limit hangs on the way, and blocks that"
                        " rest under other forces may bear up to the bound."]  # fmt: skip
