"""Holds the limit of a stage from both sides, with joints that slide without dilation: where blocks fail, and where they stand.

    ends = both(mesh, scene, answer)        answer: bounds.bound of the stage
    ends.lower, ends.rigid, ends.upper, ends.gap

Above: the bound (joints that slide dilate), above which nothing stands; and paths of rigid blocks from their weight on (path.py), which end in a mechanism without dilation whose motion and forces are
checked (mechanism.py). A run whose loads come at once, at that end, stands at times, since forces without dilation hang on the way: then the end is where it fails. Below: runs of the solver whose forces
are checked (standing.py): with forces in the corners of the faces, with joints as soft as the gap allows, and as the scene is. Where the gap stays wide, the path with many points of each face tells ways from hinges.
"""

import math
from dataclasses import dataclass
from functools import partial

from quoin_tools.base import joints
from quoin_tools.limit import LimitError
from quoin_tools.limit.beside import Beside
from quoin_tools.limit.bounds import Bound
from quoin_tools.limit.mechanism import Mechanism, mechanism
from quoin_tools.limit.path import FARTHEST, Path, follow
from quoin_tools.limit.path import FINE as FINEST
from quoin_tools.limit.raised import Divisor, Factor, Level, raised_of
from quoin_tools.limit.standing import AS_IS, CORNERS, SURE, Standing, checked, last_of
from quoin_tools.limit.water import flowing

PATHS = ((1.0, 2), (0.1, 2), (1.0, 17))  # k_s of the paths, over that of the scene, and points of each face; the last one where joints are pressed over a length
FEWER = (1.0, 9)  # in place of the last one, where that finds no end
MARGIN = 2e-3  # of the upper end over the last path that fails, for ways between those of the paths
SCENE = 1.0  # k_n and k_s of the run, over those of the scene
SOFT = (0.125, 0.25, 0.5)  # of the softer joints
FINE, BRACKET, COARSE = 1e-3, 1.25e-3, 5e-3  # of the run with forces in corners, of runs with joints of some stiffness, and of the run as the scene is, over the measure near which the limit is expected
WIDE = 0.06  # in place of COARSE until that run fails: wider than its step, so nothing is tried again where a trial is not decided
LAST, CLOSE = 1.05, 1.01  # last trials over that measure, and those with forces in corners, which paths foretell
GOAL = 0.03  # gap
AT_ONCE = 2.5e-3  # half of the step of runs whose loads come at once, over the first trial
JUMPS = 5  # runs whose loads come at once, each where the one before has failed
ROUNDING = 1e-9
MOST = 1500  # contacts
KINDS = ("load_factor", "flood", "strength_reduction")


@dataclass
class Way:
    """A path: last measure (raised.py) at which blocks stand, first at which they fail (the bound where they stand up to it, None: none is found), and the mechanism there (None: none is exact, or they stand up to the bound)."""

    ratio: float
    points: int
    begun: float | None
    stands: float | None
    fails: float | None
    mechanism: Mechanism | None


@dataclass
class Ends:
    """lower: a run as the scene is stands there, and one with joints as soft as GOAL allows. rigid: one with forces in corners does. Their forces are checked, and all paths stand there too; None: there is none.
    upper: none of the paths and runs stands above. So the way decides between `rigid` and `upper`, and hinges take what is between `lower` and `rigid`. All as the measure of `raised`."""

    bound: Bound
    raised: Factor | Level | Divisor
    ways: list
    runs: dict  # CORNERS, softer ones, SCENE where those leave the gap wide, AS_IS (up to `lower` only; undecided there: SCENE too): Standing, or None
    at_once: Standing | None  # a run that stood at the upper end of the paths when its loads came at once
    lower: float | None
    rigid: float | None
    upper: float

    def gap_to(self, end):
        """Returns the difference of an end and the upper one, over that one or over the height of the bodies; None: it is not known."""
        return None if end is None or math.isinf(self.upper) else self.raised.gap(end, self.upper)

    @property
    def gap(self):
        return self.gap_to(self.lower)

    @property
    def pressed(self):
        """The path of blocks that are pressed over the length of their faces; None: there is none, or they do not stand where it begins."""
        return next((one for one in self.ways if one.points > 2 and one.stands is not None), None)


def refusal(scene, answer):
    """Returns in a line why a stage is none for paths without dilation; None: it is one."""
    stage, parts = answer.stage, answer.parts
    kind, strengths = scene.stages[stage].get("type", "static"), parts.strengths()
    crushing = [name for name, strength in strengths.items() if math.isfinite(strength.compression)]
    if kind not in KINDS:
        return f"stage '{stage}' is of type {kind}: --both is for {', '.join(KINDS)}"
    if len(parts.ties):
        return f"stage '{stage}' has anchors: --both follows blocks and joints alone"
    for name in strengths:
        if joints.is_elastic(parts.joints[name]):
            return f"joints.{name}: law elastic has no limit: --both is for joints with friction"
    if crushing:
        return f"joints.{crushing[0]}.compression: --both is for joints without a limit in compression"
    if flows := flowing(scene, stage):
        return f"loads.{flows[0]}: water that flows in joints follows their openings: --both has none"
    if cracked := [name for name, load in scene.stage_loads(stage).items() if load.get("cracked") is True]:
        return f"loads.{cracked[0]}.cracked: water follows the crack: --both has loads that do not change as joints open"
    if len(parts.contacts) > MOST:
        return f"{len(parts.contacts)} contacts: --both is for at most {MOST}"
    return None


def both(mesh, scene, answer):
    """Returns the Ends of a stage of trials."""
    if why := refusal(scene, answer):
        raise LimitError(why)
    if answer.value is None:
        raise LimitError(f"stage '{answer.stage}': {'no factor brings the blocks to equilibrium' if answer.kind == 'load_factor' else 'there is no equilibrium where its trials begin'}")
    raised = raised_of(mesh, scene, answer)
    with Beside() as side:
        return ends_of(answer, raised, Runs(mesh, scene, answer, raised, side))


class Runs:
    """Runs of a stage near its limit, beside each other and beside the paths; what they find does not hang on how many run at a time."""

    def __init__(self, mesh, scene, answer, raised, side):
        self.parts, self.raised, self.side, self.found = answer.parts, raised, side, {}
        self.last_of = partial(last_of, mesh, scene, answer.stage)

    def begin(self, what, ways):
        return self.side.begin(lambda running: self.last_of(ways, what, running))

    def near(self, what, *how):
        """Begins a run. how: of raised.trials."""
        return self.begin(what, self.raised.trials(*how))

    def sure(self, what, begun):
        """Returns the Standing of a run that was begun; None: it stands at none of the first trials, or its forces are not sure."""
        self.found[what] = found = checked(self.parts, self.raised, begun.result())
        return found if found is not None and found.error < SURE else None

    def ran(self, what, *how):
        return self.sure(what, self.near(what, *how))

    def way(self, path, near):
        with self.side.turn():
            return way(self.parts, self.raised, *path, near=near)

    def beyond(self, most):
        """Returns the measure at which a run fails whose loads come at once, from an upper end `most` on, and the Standing of the last such run that stood; None: none did."""
        raised, last = self.raised, None
        for _ in range(JUMPS):
            if not most < raised.bound:
                break
            found = checked(self.parts, raised, self.begin(CORNERS, [raised.at_once(most, AT_ONCE)]).result())
            if found is None or found.error >= SURE or found.measure < (1 - ROUNDING) * most:
                break
            most, last = min(raised.bound, found.fails or raised.bound), found
        return most, last


def ends_of(answer, raised, runs):
    points = all(row.get("stress_model") == "pt" for row in answer.parts.joints.values())
    ways, soft, corners, early = [], None, None, {}
    for path in PATHS[: 2 if points else None]:
        ways.append(runs.way(path, ways[-1].fails if ways else None))
        if soft is None and not points and ways[-1].fails is not None:
            soft = runs.near(SOFT[0], ways[-1].fails, BRACKET, LAST)
        if len(ways) == 2:
            edges = min((one.fails for one in ways if one.fails is not None), default=raised.size)
            corners = runs.near(CORNERS, edges, FINE, CLOSE)
    if ways[-1].points > 2 and ways[-1].fails is None:  # fewer points are decided sooner
        ways[-1] = runs.way(FEWER, ways[-2].fails)
    fails, on_paths = ([end for end in ends if end is not None] for ends in zip(*((one.fails, one.stands) for one in ways)))
    most = min(raised.bound, raised.beyond(max(fails), MARGIN)) if len(fails) == len(ways) else raised.bound
    near = min(fails) if fails else raised.size
    if not points:
        soft = soft or runs.near(SOFT[0], near, BRACKET, LAST)
        hinged = runs.sure(SOFT[0], soft)
        if hinged and raised.gap(hinged.measure, most) <= GOAL:  # mostly no other run changes that
            lower = min(hinged.measure, *on_paths)
            early[lower] = runs.near(AS_IS, lower, WIDE, 1.0)
    corners = runs.sure(CORNERS, corners)
    if corners and corners.fails is None and raised.gap(corners.measure, raised.bound) > 2 * BRACKET:
        corners = runs.ran(CORNERS, edges, FINE, LAST)
    if corners and corners.measure > most:  # a way that no path goes
        most = min(raised.bound, corners.fails or raised.bound)
    most, jump = runs.beyond(most)
    left, hinged = [] if points else [*SOFT, SCENE], corners
    while left:
        times = left.pop(0)
        hinged = runs.sure(times, soft) if times == SOFT[0] else runs.ran(times, near, BRACKET, LAST)
        if hinged and raised.gap(hinged.measure, most) <= GOAL:
            break
        left = [one for one in left if one == SCENE or (hinged and raised.gap(near - max(near - hinged.measure, 0.0) * (times / one) ** (1 / 3), most) <= GOAL)]
    if hinged and hinged.measure > most:
        most, jump = runs.beyond(min(raised.bound, hinged.fails or raised.bound))
    lower, rigid = (min(found.measure, *on_paths) if found else None for found in (hinged, corners))
    if hinged and not points:  # the scene's own method may go another way
        found = runs.sure(AS_IS, early.get(lower) or runs.near(AS_IS, lower, WIDE, 1.0))
        if found and found.fails is not None:
            found = runs.ran(AS_IS, lower, COARSE, 1.0)
        if found is None or found.fails is not None:
            lower = found and min(lower, found.measure)
        elif SCENE not in runs.found and found.measure < (1 - ROUNDING) * lower:  # one that was not decided says nothing
            own = runs.ran(SCENE, lower, COARSE, 1.0)
            lower = own and min(lower, own.measure)
    if not points and SCENE not in runs.found and (lower is None or raised.gap(lower, most) > GOAL):
        runs.ran(SCENE, near, BRACKET, LAST)
    return Ends(answer, raised, ways, {CORNERS: None} | runs.found, jump, lower, rigid, most)


def way(parts, raised, ratio, points, near=None):
    """Returns the Way of one path. near: measure at which it is expected to fail."""
    least, rest = raised.least, raised.size - raised.least
    stays, goes, times = raised.kept_and_pushed(raised.size)
    path = Path(parts, stays, times * goes, ratio=ratio, points=points)

    def put(measure):
        path.weaken(raised.reduction(measure))
        return raised.loads(measure)

    end = follow(path, lambda share: put(least + share * rest), math.isfinite(raised.bound), math.inf if near is None else (near - least) / rest)
    begun, stands, fails = (None if one is None else float(least + one * rest) for one in (end.begun, end.stands, end.fails))
    if fails is None:
        whole = math.isfinite(raised.bound) and stands is not None and end.stands >= 1 - FINEST
        return Way(ratio, points, begun, stands, raised.bound if whole else None, None)
    loads, there = put(fails), raised.kept_and_pushed(fails)
    found = mechanism(path, end.motions, *there) or mechanism(path, [path.trial(loads, end.state, FARTHEST)[2]], *there)
    return Way(ratio, points, begun, stands, fails, found)
