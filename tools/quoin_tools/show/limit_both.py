"""Says in a table and sentences where blocks stand and fail whose joints slide without dilation (limit/both.py), for `quoin limit --both`."""

import math

from quoin_tools.base.terminal import table
from quoin_tools.limit.both import GOAL, SCENE
from quoin_tools.limit.standing import CORNERS

RUNS = {CORNERS: "A run with forces in the corners of the faces (rigid hinges)", SCENE: "A run with the joints of the scene"}
WHAT = {"load_factor": "loads times", "flood": "level", "strength_reduction": "strength"}

HEADER = ("stage", "what", "lower end", "rigid hinges", "upper end", "gap", "of rigid hinges", "bound (joints dilate)")


def text_of(all_ends):
    """Returns lines about some Ends."""
    if not all_ends:
        return []
    rows = [(ends.bound.stage, WHAT[ends.bound.kind], number(ends, ends.lower), number(ends, ends.rigid), number(ends, ends.upper), gap(ends, ends.lower), gap(ends, ends.rigid), number(ends, ends.raised.bound)) for ends in all_ends]
    return ["", "Without dilation:", *table(HEADER, rows), *(f"  {ends.bound.stage}: {line}" for ends in all_ends for line in (*divisors(ends), *upper(ends), *lower(ends), *doubts(ends)))]


def number(ends, measure):
    """Writes a measure (limit/raised.py) as the stage counts, with its unit."""
    return "-" if measure is None else "none" if math.isinf(measure) else f"{ends.raised.value(measure):.5g} {ends.bound.unit}".removesuffix(" -")


def gap(ends, end):
    """Writes how far an end is from the upper one, in the unit of the stage, and over the upper end or the height of the bodies."""
    if ends.gap_to(end) is None:
        return "-"
    part = f"{100 * ends.gap_to(end):.2g} %"
    return part if ends.bound.kind == "load_factor" else f"{abs(ends.raised.value(ends.upper) - ends.raised.value(end)):.2g} {ends.bound.unit} ({part})".replace(" - (", " (")


def divisors(ends):
    """Says in a sentence by what strengths may be divided."""
    if ends.bound.kind != "strength_reduction" or ends.lower is None:
        return []
    what = "The tangent of the largest angle of friction" if ends.raised.what == "friction" else "All strengths"
    return [f"{what} divided by {ends.lower:.4g} stands, by {ends.upper:.4g} fails: the factor of safety."]


def upper(ends):
    """Lists in sentences what the paths of rigid blocks find."""
    sentences, factor = [], ends.bound.kind == "load_factor"

    def at(measure):
        return number(ends, measure)

    for way in ends.ways:
        blocks = "Rigid blocks with k_s as in the scene" if way.ratio == 1 else f"Rigid blocks with {way.ratio:g} of k_s"
        begin = ("from their weight on" if factor else "from the scene's loads and strengths on") if way.begun == ends.raised.least else f"put under {at(way.begun)} times the loads at once" if factor else f"begun at {at(way.begun)}"
        if way.stands is None:
            sentences.append(f"{blocks} do not stand, neither {'under the other loads alone' if factor else 'as the scene begins'} nor with half or three quarters of the way to the bound at once.")
        elif way.fails is None:
            sentences.append(f"{blocks}, {begin}, stand at {at(way.stands)}; farther on no motion was found.")
        elif way.mechanism is None:
            sentences.append(f"{blocks}, {begin}, stand at {at(way.stands)} and move on and on at {at(way.fails)}; their motion is no mechanism that passes its check to 1e-6.")
        else:
            found = way.mechanism
            snap = ": less than where the blocks stood, which lose forces as they begin to move" if factor and way.stands > found.most * (1 + 1e-9) else ""
            last = "any" if math.isinf(found.most) else f"{found.most:.5g}"
            together = f"at factors from {found.least:.5g} to {last}" if factor else f"at {found.least:.5g} to {last} times the loads beside the weight that act at {at(way.fails)}" if found.most > 0 else "there"
            sentences.append(f"{blocks}, {begin}, stand at {at(way.stands)} and fail at {at(way.fails)} (ends of faces that part: {found.parting}, faces that slide: {found.sliding}). Mechanism and forces, checked to"
                             f" {max(found.error, 1e-12):.0e}, go together {together}{snap}.")  # fmt: skip
    return sentences


def lower(ends):
    """Lists in sentences what the runs say."""
    sentences = []
    for which, run in ends.runs.items():
        what = RUNS.get(which) or f"A run with {which:g} of k_n and k_s"
        if run is None:
            sentences.append(f"{what} stands at none of its first trials, or a stage before them does not stand.")
            continue
        below = " (below the lower end, which holds for the joints of the scene)" if run.measure < (ends.lower or 0.0) else ""
        end = "was not decided farther on" if run.fails is None else f"fails at {number(ends, run.fails)}"
        sentences.append(f"{what} stands at {number(ends, run.measure)} and {end}{below}; its forces hold equilibrium and strengths, checked apart, to {run.error:.0e} of the heaviest load.")
    return sentences


def doubts(ends):
    """Lists in sentences what the ends are not."""
    sentences, rigid = [], ends.gap_to(ends.rigid)
    if ends.at_once:
        sentences.append(f"Where the loads come at once, a run stands at {number(ends, ends.at_once.measure)}, beyond what it bears step by step: the upper end is where that run fails.")
    fails = sorted(way.fails for way in ends.ways if way.fails is not None)
    found = [way.mechanism for way in ends.ways if way.mechanism is not None and ends.bound.kind == "load_factor"]
    least, most = min((one.least for one in found), default=None), max((one.most for one in found), default=None)
    if ends.gap is not None and ends.gap > GOAL:
        why = []
        if rigid is not None and rigid <= GOAL:
            why.append("the rest is what joints take whose hinges are pressed over a length (k_n), or what their slow motion leaves undecided")
        if found and ends.gap_to(least) > 0.5 * ends.gap:
            why.append(f"mechanisms go on at factors from {least:.5g} {'on' if math.isinf(most) else f'to {most:.5g}'}: friction has several limits here")
        elif len(fails) > 1 and ends.raised.gap(fails[0], fails[-1]) > 0.5 * ends.gap:
            why.append(f"the paths of rigid blocks end at {number(ends, fails[0])} and {number(ends, fails[-1])}: friction has several limits here")
        why = why or ["joints that lose their cohesion, a run that was not decided, or friction with several limits"]
        hinges = [] if rigid is None else [f"rigid hinges are {100 * rigid:.2g} % below the upper end"]
        sentences.append(f"THE GAP IS LARGER THAN {100 * GOAL:g} %: {'; '.join([*hinges, *why])}.")
    if ends.lower is None:
        sentences.append("THERE IS NO LOWER END: no run stands whose forces pass their check.")
    return [*sentences, f"The bound alone is a theorem: nothing stands beyond it. The lower end holds for blocks that are loaded step by step from {'their weight' if ends.bound.kind == 'load_factor' else 'the loads of the scene'} on; without dilation the limit hangs on the way, and blocks that"
                        " rest under other forces may bear up to the bound."]  # fmt: skip
