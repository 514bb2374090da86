"""Computes the limit of a stage by limit analysis: a load factor, the level of a flood, a reduction of strengths; and compares it with a run.

    answer = bound(mesh, scene, "flood")
    answer.value, answer.unit        an upper bound, if joints slide with dilation or not
"""

import math
import time
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from quoin_tools.assess.scene_loads import SceneLoads
from quoin_tools.base import joints, sheet_units
from quoin_tools.base.language import _, ngettext, numeral
from quoin_tools.base.scene import SceneError
from quoin_tools.base.solver import SolverError
from quoin_tools.limit import LimitError, program
from quoin_tools.limit.assembly import Assembly, assembly, built
from quoin_tools.limit.cracked import limit_with_cracks
from quoin_tools.limit.forces import body_forces
from quoin_tools.limit.program import STANDS, Limit, Unsolved, missing
from quoin_tools.limit.solvers import WEDGE_SECONDS, WEDGES, clarabel, seconds
from quoin_tools.limit.water import FLOWING, NAME, flowing

NARROW = 1e-7  # bracket of a level or a strength, over its size
NEAR = 1e-7  # step of a derivative, over the size
DOUBLINGS = 40
PROGRAMMES = 12  # of a search, about
CRUSHING_COST = 1.5 if clarabel else 8  # times the other work of a programme, where all joints have a strength in compression: cones, or tangents
PRESSED = 1e8  # [Pa] more than any masonry bears: mean pressure on joints of wedged blocks, for comparison
LONG = 10  # s: what takes longer says so
SLOW = 2  # trials that fail one after the other, with more than half missing of what was missing before: then the bracket is halved once


@dataclass
class Bound:
    stage: str
    kind: str  # load_factor, flood, strength_reduction
    value: float | None  # largest factor or level, or least strength, at which the bodies can stand; inf: there is none
    unit: str  # -, m, degree
    parts: Assembly
    loads: dict  # of the stage: (n, 3)
    raised: list  # names of the loads that are raised
    limit: Limit | None = None  # forces and mechanism there
    least: float | None = None  # factor below which the bodies do not stand either; None: there is none, or not asked for
    cracked: float | None = None  # value with water in the cracks of uplift that follows them; nan: nothing stands; None: not known
    notes: list = field(default_factory=list)


class Kept:
    """Data that samples of one mesh share: bodies and contacts, the solver that is asked for loads on faces (by groups that are absent), water of a run."""

    def __init__(self, asked=None):
        self.parts, self.wet, self.asked, self.watch = None, None, {} if asked is None else asked, None

    def assembly(self, mesh, scene, stage):
        absent = frozenset(scene.absent(stage))
        if absent not in self.asked:
            self.asked[absent] = SceneLoads(built(mesh, scene, stage), scene, uplift=True)
        if self.parts is None:
            self.parts = assembly(mesh, scene, stage)
        return replace(self.parts, joints={name: scene.joint(name, stage) for name in self.parts.joints})

    def on_faces(self, scene, stage, rise=0.0):
        """Returns the StageLoads of a stage, whose flood has risen by `rise` [m]."""
        try:
            return self.asked[frozenset(scene.absent(stage))].of(scene, stage, rise)
        except SolverError as error:
            raise LimitError(str(error)) from None

    def forces(self, scene, stage, parts, water=None, rise=0.0):
        """Returns the forces of body_forces. water: JointWater of a run, which does not change."""
        found = body_forces(parts, scene, stage, self.on_faces(scene, stage, rise).table)
        if water:
            self.wet = water.forces(parts) if self.wet is None else self.wet
            found[NAME] = self.wet
        return found


def bound(mesh, scene, stage, raises=None, largest=None, kept=None, water=None, asked=None, watch=None):
    """raises: names of the loads that are raised, in place of what the stage says. largest: number of contacts beyond which it is refused.
    kept: of samples before, whose mesh, supports and anchors are the same. water: that a run has found in joints (water.of_run). asked: {absent groups: SceneLoads} of other stages of the scene.
    watch: receives sentences about a long search. KeyboardInterrupt ends a search at once, with the bracket so far as its message."""
    scene, one, kept = replace(scene, trials={}), kept is None, kept or Kept(asked)  # the scene as it was written, whatever trials of a run have found
    flows = flowing(scene, stage)
    if flows and water is None:
        raise LimitError(_("loads.{0}: water that flows in joints presses as a run finds it: run it first, then quoin limit on the folder of the run", flows[0]))
    parts = kept.assembly(mesh, scene, stage)
    if largest and len(parts.contacts) > largest:
        raise LimitError(_("{0} contacts, more than {1}: run quoin limit by itself", len(parts.contacts), largest))
    keys = scene.stages[stage]
    kind = keys.get("type", "static")
    crushing = np.isfinite([strength.compression for strength in map(parts.strengths().get, parts.contacts.joint)]).mean()
    one_programme, at_once = seconds(len(parts.contacts)) * (1 + CRUSHING_COST * crushing), bool(raises or kind in ("static", "load_factor"))
    expected, capped = (one_programme * times for times in ((2, 4) if at_once else (PROGRAMMES, 4 * PROGRAMMES)))
    kept.watch = watch
    tells = watch if watch and expected > LONG else None
    if tells:
        tells(f"{stage}: {len(parts.contacts)} joints, about {rounded(expected)}")
    more = expected + capped + seconds(len(parts.contacts), WEDGE_SECONDS)
    WEDGES.watch = (lambda: watch(f"{stage}: joints may be wedged: they are looked for, about {rounded(more)} more")) if watch and more > LONG else None
    if raises or kind in ("static", "load_factor"):
        find = partial(factor_of, raises=raises or keys.get("raises"))
    elif kind in ("flood", "strength_reduction"):
        find = level_of if kind == "flood" else reduction_of
    else:
        raise LimitError(f"stages.{stage} is of type {kind}: limit analysis is for static stages and trials (load_factor, flood, strength_reduction)")
    find = partial(find, scene, stage, kept=kept, water=water)
    try:
        found, within = find(parts), []
    except Unsolved:  # as where blocks are wedged, many of them
        if watch and capped > LONG:
            watch(f"{stage}: not solved, as where joints are wedged; once more, with at most {PRESSED / 1e6:g} MPa on each joint, about {rounded(capped)}")
        parts = replace(parts, pressed=PRESSED)
        found, within = find(parts), [_("Without a limit on the pressure in joints the linear programme is not solved, as where blocks are wedged. The bound is for a mean pressure of at most {0:g} MPa on each joint.", PRESSED / 1e6)]
    found.notes = within + notes(scene, stage, parts) + (water_notes(found, water) if flows else [])
    if one and found.kind == "load_factor" and found.value is not None:
        dead, live = dead_and_live(found)
        found.least = program.largest(parts, dead, live, least=True).factor if missing(parts, dead).short > STANDS else None
    if any(load.get("cracked") is True for load in scene.stage_loads(stage).values()):
        found.cracked = further(found, "water in cracks", lambda: limit_with_cracks(found, scene, kept, water), tells) if one and found.value is not None else None
        found.notes.append(cracked_note(found, found.cracked))
    if one and found.value is not None and not within and (math.isinf(found.value) or found.limit and found.limit.wedged):
        found.notes += pressed_notes(found, further(found, f"at most {PRESSED / 1e6:g} MPa on each joint", lambda: find(replace(parts, pressed=PRESSED)), tells))
    if found.least:
        found.notes.append(_("Below {0:.6g} times the loads nothing stands either: the other loads need them.", found.least))
    return found


def rounded(expected):
    """Returns seconds in words, to one digit or so."""
    return f"{round(expected, -1):g} s" if expected < 600 else f"{expected / 60:.0f} min"


def further(found, what, search, tells):
    """Returns search(), a search beside the bound that has been found. tells: receives a sentence before."""
    if tells:
        tells(f"{found.stage}: the bound is {said(found.value, found.unit)}; once more, with {what}")
    try:
        return search()
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"stopped after the bound, {said(found.value, found.unit)}, with {what}") from None


def factor_of(scene, stage, parts, kept, water, raises):
    loads = kept.forces(scene, stage, parts, water)
    flows = flowing(scene, stage)
    names = list(dict.fromkeys(NAME if name in flows else name for name in raises)) if raises else [name for name in loads if name == NAME or scene.loads[name].get("type") != "self_weight"]
    for name in names:
        if name not in loads:
            raise SceneError(f"stage '{stage}' has no load '{name}' that presses on bodies, there are: {', '.join(loads)}")
    if not names:
        raise LimitError(_("stage '{0}': its loads are weight alone: name those to be raised (--raises)", stage))
    found = Bound(stage, "load_factor", None, "-", parts, loads, names)
    found.limit = program.largest(parts, *dead_and_live(found))
    return replace(found, value=found.limit.factor)


def dead_and_live(found):
    """Returns the loads (n, 3) that stay, and those that are raised."""
    sums = (sum((found.loads[name] for name in found.loads if (name in found.raised) == raised), np.zeros((found.parts.n, 3))) for raised in (False, True))
    return tuple(sums)


def level_of(scene, stage, parts, kept, water):
    """Finds the limit by trials of the level of a flood."""
    loads, given = scene.stage_loads(stage), scene.stages[stage].get("rises")
    rising = [given] if isinstance(given, str) else given or loads
    if not any(loads[name].get("type") not in FLOWING for name in rising):
        raise LimitError(_("stages.{0}: a flood that raises heads alone: the pressures in the joints are those of the run", stage))
    flood = kept.on_faces(scene, stage)
    loads, rising = kept.forces(scene, stage, parts, water), list(flood.rises)

    def total(rise):
        return sum(kept.forces(scene, stage, parts, water, rise).values())

    size = float(np.ptp(parts.mesh.vertices[:, 1]))
    trials = Trials(lambda rise: missing(parts, total(rise), near=(total(rise + NEAR * size), None)), NEAR * size, lambda rise: f"{flood.start + rise:.6g} m", kept.watch)
    if trials(0.0).short > STANDS:
        return Bound(stage, "flood", None, "m", parts, loads, rising)
    low, high = 0.0, 0.01 * size
    for __ in range(DOUBLINGS):
        if trials(high).short > STANDS:
            break
        low, high = high, 2 * high
    else:
        return Bound(stage, "flood", math.inf, "m", parts, loads, rising)
    high, low = closed_in(trials, high, low, NARROW * size)
    return Bound(stage, "flood", flood.start + high, "m", parts, loads, rising, trials.at(low, high))


def reduction_of(scene, stage, parts, kept, water):
    """Finds the limit by trials of the angle of friction, or of the remaining part of the strengths."""
    keys, loads = scene.stages[stage], kept.forces(scene, stage, parts, water)
    what, only, total = keys.get("what", "friction"), keys.get("reduce"), sum(loads.values())
    only = [only] if isinstance(only, str) else only
    reducible = [keys for name, keys in parts.joints.items() if not joints.is_elastic(keys) and (not only or name in only)]
    if not reducible:
        raise LimitError(_("stages.{0}: all joints that would be reduced are elastic", stage))
    unit = "degree" if what == "friction" else "-"
    high = max(keys["friction"] for keys in reducible) if what == "friction" else 1.0
    low = 0.0 if what == "friction" else NARROW  # joints that bear no compression at all have no shape
    near = NEAR * (high or 1.0)
    trials = Trials(lambda left: missing(parts, total, (what, left, only), (total, (what, left + near, only))), near, lambda left: f"{left:.6g} {unit}".removesuffix(" -"), kept.watch)
    if trials(high).short > STANDS:
        return Bound(stage, "strength_reduction", None, unit, parts, loads, [])
    if trials(low).short <= STANDS:
        return Bound(stage, "strength_reduction", 0.0, unit, parts, loads, [])
    low, high = closed_in(trials, low, high, NARROW * high)
    return Bound(stage, "strength_reduction", low, unit, parts, loads, [], trials.at(high, low))


class Trials:
    """Programmes of one search: what is missing at a value, and how much less beside it."""

    def __init__(self, solve, near, words, watch=None):
        self.solve, self.near, self.words, self.watch, self.known, self.began = solve, near, words, watch, {}, time.monotonic()

    def __call__(self, value):
        """Returns Missing, with the derivative as its slope."""
        if value not in self.known:
            try:
                found = self.solve(value)
            except KeyboardInterrupt:
                raise KeyboardInterrupt(f"stopped after {self.bracket()}") from None
            self.known[value] = replace(found, slope=found.slope / self.near)
            if self.watch and time.monotonic() - self.began > LONG:
                self.watch(self.bracket())
        return self.known[value]

    def bracket(self):
        """Says in words what the programmes so far have found."""
        short = sorted((found.short, value) for value, found in self.known.items())
        stands, fails = [value for missing, value in short if missing <= STANDS], [value for missing, value in short if missing > STANDS]
        if stands and fails:
            stands = [min(stands, key=lambda value: abs(value - fails[0]))]
        words = [f"{what} at {self.words(values[0])}" for what, values in (("stands", stands), ("fails", fails)) if values]
        return f"{len(self.known)} programme{'s' * (len(self.known) != 1)}: {', '.join(words) or 'no bracket yet'}"

    def at(self, stands, fails):
        """Returns the forces of the last loads that stand, and the mechanism of the first that do not."""
        one, other = self(stands).limit, self(fails).limit
        return replace(one, motion=other.motion, dual_residual=other.dual_residual, gap=max(one.gap, other.gap))


def closed_in(trials, fails, stands, width):
    """(one that fails, one that stands), no farther apart than width. What is missing falls to nothing where bodies begin to stand, and nearly straight just before: its derivative, which the
    dual gives, says where, and both sides of that place are tried. Where that does not help the bracket is halved. Six to twelve programmes, where halving alone takes 26."""
    beside, slow = math.copysign(0.25 * width, stands - fails), 0
    while abs(stands - fails) > width:
        found, at = trials(fails), 0.5 * (fails + stands)
        if slow < SLOW and found.slope * beside < 0:
            place = fails - (found.short - STANDS) / found.slope
            before = place - max(beside, (place - fails) * abs(place - fails) * NARROW / width, key=abs)
            at = next((guess for guess in (place + beside, before) if (guess - fails) * (stands - guess) > 0), at)
        new = trials(at).short
        if new > STANDS:
            slow, fails = (slow % SLOW + 1 if new > 0.5 * found.short else 0), at
        else:
            slow, stands = 0, at
    return fails, stands


def notes(scene, stage, parts):
    """Lists in sentences the effects that the number leaves out."""
    sentences, strengths = [], parts.strengths()
    elastic = [name for name, keys in parts.joints.items() if joints.is_elastic(keys)]
    if elastic:
        sentences.append(_("Joints without limits (law elastic) hold whatever comes, tension too: {0}.", ", ".join(elastic)))
    beyond = [name for name, s in strengths.items() if s.beyond_apex()]
    if beyond:
        sentences.append(_("Tensile strength beyond c / tan(phi): {0}. Points that pull so hard bear no shear, others all of theirs; the bound takes c = tension tan(phi), which may be far too high.", ", ".join(beyond)))
    brittle = [name for name, keys in parts.joints.items() if joints.is_brittle(keys)]
    if brittle:
        sentences.append(_("Cohesion and tensile strength are taken as if joints kept them when they fail, runs take them away: {0}.", ", ".join(brittle)))
    yielding = [name for name, keys in scene.materials.items() if keys.get("law", "elastic") != "elastic"]
    if yielding:
        sentences.append(_("Blocks that yield or crack are taken as rigid: {0}.", ", ".join(yielding)))
    if any(0 < s.compression < math.inf for s in strengths.values()):
        sentences.append(_("Compression: a block of stress over the pressed part of a face.") if clarabel else _("Compression: a block of stress over the pressed part of a face, cut by tangents from outside."))
    without, dowels = parts.ties.unlimited()
    if without:
        sentences.append(_("Anchors without yield or breaking_force bear whatever comes: {0}.", ", ".join(without)))
    if dowels:
        sentences.append(_("Dowels without strength keep joints from sliding whatever comes: {0}.", ", ".join(dowels)))
    if parts.ties.breaks:
        sentences.append(_("Anchors that break are taken as if they kept the force at which they do, runs take it away: {0}.", ", ".join(parts.ties.breaks)))
    points = int((parts.contacts.length == 0).sum())
    if points:
        sentences.append(ngettext("{0} corner on faces is a point that presses and rubs; runs have it under variable connectivity only.", "{0} corners on faces are points that press and rub; runs have them under variable connectivity only.", points))
    return sentences


def cracked_note(found, limit):
    """Says in a sentence by how much the crack matters. limit: with water in it, None: not known."""
    closed = _("Water that follows a crack (cracked: true) is taken along the joint as it is, closed: with the crack less would be borne.")
    if limit is None:
        return closed
    if math.isnan(limit):
        return _("The bound has the joint closed. With the full head in the crack, as far as the gravity method opens the joint (cracked: true), nothing stands.")
    return _("The bound has the joint closed. With the full head in the crack, as far as the gravity method opens the joint (cracked: true), the limit is: {0}.", said(limit, found.unit, 4))


def said(value, unit, digits=6):
    text = numeral(f"{value:.{digits}g}")
    return text if unit == "-" else sheet_units.said(text, unit)


def pressed_notes(found, pressed):
    """Says what forces of any size in joints are worth. pressed: the Bound where the mean pressure on each joint is no more than PRESSED."""
    sentences = []
    if wedged := found.limit.wedged if found.limit else 0:
        sentences.append(_("{0} of {1} joints are wedged: they hold themselves with forces of any size, and the bound counts on that.", wedged, len(found.parts.contacts)))
    if pressed.value is None:
        sentences.append(_("With a mean pressure of at most {0:g} MPa on each joint nothing stands.", PRESSED / 1e6))
    elif not math.isinf(pressed.value):
        sentences.append(_("With a mean pressure of at most {0:g} MPa on each joint the limit is: {1}.", PRESSED / 1e6, said(pressed.value, pressed.unit)))
    return sentences


def water_notes(found, water):
    """Lists in sentences the assumptions on water that flows in joints."""
    sentences = [_("Water in joints presses as in the run {0}; how it changes as joints open and as loads change is not followed.", water.when)]
    if NAME in found.raised:
        sentences.append(_("Its pressures are multiplied with the loads."))
    if found.kind == "flood":
        sentences.append(_("So the level is a bound with these pressures, which would rise with it."))
    return sentences


# ---- beside a run ------------------------------------------------------------------------------------------

def stood(found):
    """Returns (last value that stood, first that failed) of the trials of a run in summary.json."""
    return found["stable"], found["failing"]


def contradicts(answer, stable, tolerance=2e-3):
    """Tells whether a simulation stands where no distribution of forces could: then one of the two is wrong."""
    if answer.value is None:
        return stable is not None
    if stable is None or math.isinf(answer.value):
        return False
    slack = tolerance * max(abs(answer.value), 1e-30)
    return stable < answer.value - slack if answer.kind == "strength_reduction" else stable > answer.value + slack
