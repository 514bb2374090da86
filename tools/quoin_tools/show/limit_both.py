"""Says in a table and sentences where blocks stand and fail whose joints slide without dilation (limit/both.py), for `quoin limit --both`."""

import math

from quoin_tools.base.terminal import table
from quoin_tools.limit.both import BRACKET, GOAL, ROUNDING, SCENE
from quoin_tools.limit.standing import AS_IS, CORNERS

RUNS = {CORNERS: "A run with forces in the corners of the faces", SCENE: "A run with the joints of the scene", AS_IS: "The run as the scene is, with its own method,"}
WHAT = {"load_factor": "loads times", "flood": "level", "strength_reduction": "strength"}

AT_ONCE = "A run with forces in the corners whose loads come at once"
SAME = 2e-3  # of the upper end: runs that stand and fail as near to each other do not show two limits

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
        blocks = ("Rigid blocks with k_s as in the scene" if way.ratio == 1 else f"Rigid blocks with {way.ratio:g} of k_s") + ("" if way.points == 2 else f" and forces at {way.points} points of each face")
        begin = ("from their weight on" if factor else "from the scene's loads and strengths on") if way.begun == ends.raised.least else f"put under {at(way.begun)} times the loads at once" if factor else f"begun at {at(way.begun)}"
        if way.stands is None:
            sentences.append(f"{blocks} do not stand, neither {'under the other loads alone' if factor else 'as the scene begins'} nor with half or three quarters of the way to the bound at once.")
        elif way.fails is None:
            sentences.append(f"{blocks}, {begin}, stand at {at(way.stands)}; farther on no motion was found.")
        elif way.mechanism is None and way.fails == ends.raised.bound:
            sentences.append(f"{blocks}, {begin}, stand at {at(way.stands)}, up to the bound.")
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
        what = name(which)
        if run is None:
            sentences.append(f"{what} stands at none of its first trials, or a stage before them does not stand.")
            continue
        short = run.measure < (1 - ROUNDING) * (ends.lower or 0.0)
        below = " (below the lower end, which holds for stiffer joints)" if short and run.fails else ""
        at_end = run.fails is None and not short and (which == AS_IS or which == SCENE and AS_IS in ends.runs or at_bound(ends, run))
        end = "goes no farther" if at_end else "was not decided farther on" if run.fails is None else f"fails at {number(ends, run.fails)}"
        sentences.append(f"{what} stands at {number(ends, run.measure)} and {end}{below}; its forces hold equilibrium and strengths, checked apart, to {run.error:.0e} of the heaviest load.")
    return sentences


def doubts(ends):
    """Lists in sentences what the ends are not."""
    sentences = []
    if ends.at_once:
        sentences.append(f"Where the loads come at once, a run stands at {number(ends, ends.at_once.measure)}, beyond what it bears step by step: the upper end is where that run fails.")
    if ends.gap is not None and ends.gap > GOAL:
        sentences += wide(ends)
    if ends.lower is None:
        sentences.append("THERE IS NO LOWER END: no run stands whose forces pass their check.")
    return [*sentences, f"The bound alone is a theorem: nothing stands beyond it. The lower end holds for blocks that are loaded step by step from {'their weight' if ends.bound.kind == 'load_factor' else 'the loads of the scene'} on, in small displacements: in large strain walls with soft joints fail sooner. "
                        "Without dilation the limit hangs on the way, and blocks that rest under other forces may bear up to the bound."]  # fmt: skip


def wide(ends):
    """Says in sentences what a gap is made of that is larger than GOAL, by the paths and runs that have been made."""
    own, pressed, rigid = ends.runs.get(SCENE), ends.pressed, ends.gap_to(ends.rigid)
    sentences = [f"THE GAP IS LARGER THAN {100 * GOAL:g} %: {percent(ends.gap)}{'' if rigid is None else f', {percent(rigid)} of it between the least and the most that blocks bear whose hinges stand at edges'}."]
    if own and pressed:
        hinges = max(ends.gap_to(own.measure) - ends.gap_to(pressed.stands), 0.0)
        sentences.append(f"The joints of the scene bear {number(ends, own.measure)}, the path of rigid blocks that are pressed over the length of their faces {number(ends, pressed.stands)}: hinges take the difference, {percent(hinges)}.")
    if shown := both_true(ends):
        stands, fails, one, other = shown
        apart = ends.gap_to(fails) - ends.gap_to(stands)
        sentences.append(f"{one} stands at {number(ends, stands)}, {small(other)} fails at {number(ends, fails)}: both are true, and no solver can close this part of the gap, {percent(apart)}.")
        if pressed and pressed.fails is not None and (way := min(ends.gap_to(pressed.fails) - ends.gap_to(stands), apart)) > SAME:
            sentences.append(f"Rigid blocks that are pressed over the length of their faces fail at {number(ends, pressed.fails)}: the way takes {percent(way)} of it.")
    else:
        sentences.append("No run has been found that stands where another one fails.")
    if undecided := [name(which) for which, run in ends.runs.items() if run and run.fails is None and which != AS_IS and not at_bound(ends, run)]:
        sentences.append(f"Not decided beyond where they stand: {', '.join(map(small, undecided))}.")
    if any(strength.cohesion or strength.tension for strength in ends.bound.parts.strengths().values()):
        sentences.append("Runs may lose cohesion and tension, as the scene says; paths and bound keep them.")
    return sentences


def both_true(ends):
    """Returns (measure at which a run stands, at which another one fails, names of both), the farthest apart; None: there is no such pair."""
    joints = {which: ends.runs.get(which) for which in (CORNERS, SCENE, AS_IS)}
    stand = [(run.measure, name(which)) for which, run in joints.items() if run] + ([(ends.at_once.measure, AT_ONCE)] if ends.at_once else [])
    fail = [(run.fails, name(which)) for which, run in joints.items() if run and run.fails]
    apart, *pair = max(((stands - fails, stands, fails, one, other) for stands, one in stand for fails, other in fail), default=(-math.inf,))
    return pair if apart > SAME * abs(ends.upper) else None


def at_bound(ends, run):
    """Tells whether the trials of a run end at the bound, beyond which nothing stands."""
    return ends.raised.gap(run.measure, ends.raised.bound) <= 2 * BRACKET


def name(which):
    return RUNS.get(which) or f"A run with {which:g} times k_n and k_s"


def small(words):
    return words[0].lower() + words[1:]


def percent(part):
    return f"{100 * part:.2g} %"
