"""Applies a design spectrum to the planes of a dam, three ways beside each other: as a coefficient, by Fenves and Chopra's first mode, by all modes of the block model.

    found = study(case, design_spectrum.read("spectrum.yaml"), assessments, lifts)
    found.rows      Row of each plane and way: largest T, M, N of the earthquake alone, and with the state at rest
    found.first     FirstMode, None: the run has no modes without water
    found.why       sentences on what is missing
    found.unheld    those of them for which not each plane is held against the limits of the guideline: no basis for a pass
    found.judged    pairs of a Row and a limit: each of a base; of lifts that of the worst, by way and quantity

coefficient   blocks and water follow the ground: A/g
first mode    modes of a stage `modes` without water, water that can be compressed (fenves_chopra.py), no vertical motion
all modes     modes of a stage `modes`, with the water of its loads (added_mass), by CQC or SRSS; what follows the ground adds up with its signs (modal_sums.py)

Largest responses have no signs. A plane is judged with each sign of T and M, which belong together as those of the coefficient do, and of N; the worst counts. Vertical
and horizontal motion are combined by the root of the sum of squares. The crack at rest keeps its uplift; what an earthquake opens has that of the rule.
"""

from dataclasses import dataclass, field
from functools import partial

import numpy as np
import shapely

from quoin_tools.assess import crack_notes, fenves_chopra, guidelines, lifts, modal_sums, partial_factors, section_cut
from quoin_tools.assess.compressible_water import Reservoir
from quoin_tools.assess.design_spectrum import SpectrumError
from quoin_tools.assess.judgement import compressive_strength
from quoin_tools.assess.modal_parts import Swing
from quoin_tools.assess.planes import plane_of
from quoin_tools.assess.strength import factors
from quoin_tools.base.language import N_, _
from quoin_tools.mesh.blockmesh import closed_rings

WAYS = (N_("coefficient"), N_("first mode"), N_("all modes"))
LEFT_OUT = {
    "coefficient": N_("Coefficient: blocks and water follow the ground. It leaves out that the dam amplifies the motion, most at its crest."),
    "first mode": N_("First mode (Fenves and Chopra): linear, without vertical motion. It leaves out signs in time, joints that open or slide, and uplift that follows them."),
    "all modes": N_("All modes: linear, joints as they were at rest, water that cannot be compressed. They leave out signs in time, joints that open or slide, and uplift that follows them."),
    "record": N_("Record: what this record does to this dam, with joints that open and slide. It leaves out all other records."),
}
FUNDAMENTAL = 0.5  # of the largest effective mass along x: the slowest mode with as much is the first one
ROCK = 0.1  # of the mass that moves: more in the rock, and its box swings as no ground does
NAMED = 3  # planes without equilibrium in a sentence
LIGHT = 100.0  # [kg/m3] no stone has less
NEAR = 0.99  # of the reservoir's own frequency, up to which Fenves and Chopra give pressures
UNLIKE = 0.02  # of the participation: by more the mass seen here is not that of the run


@dataclass
class Row:
    """A plane by one way: name, level; T, M, N [N, N m] of the earthquake; factor: least sliding factor (None: no strength), stands; tension [Pa] at an end; crack [m]."""

    plane: str
    level: float
    way: str
    T: float
    M: float
    N: float
    factor: float | None
    stands: bool
    tension: float
    crack: float | None
    is_base: bool = True  # no lift
    limits: list = field(default_factory=list)  # guidelines.Judged


@dataclass
class Plane:
    name: str
    base: object
    strength: dict
    part: object
    shaken: object  # the Hand under (X, Y, M) more
    is_base: bool = False  # no lift
    kind: str = ""  # of guidelines.PLANES
    crushes: float | None = None  # [Pa] compressive strength of the blocks on it


@dataclass
class Study:
    spectrum: object
    stage: str
    rows: list = field(default_factory=list)
    first: object = None
    reservoir: object = None
    acceleration: float = 0.0  # [m/s2] of the first mode
    stage_of_modes: str = ""
    modes: dict | None = None  # of that stage in summary.json
    with_water: bool = False
    why: list = field(default_factory=list)
    unheld: list = field(default_factory=list)

    def lacks(self, sentence):
        self.why.append(sentence)
        self.unheld.append(sentence)

    @property
    def judged(self):
        of_bases, of_lifts = [], {}
        for row in self.rows:
            for limit in row.limits:
                (of_bases if row.is_base else of_lifts.setdefault((row.way, limit.quantity), [])).append((row, limit))
        return of_bases + [min(pairs, key=lambda pair: guidelines.worst_first(pair[1])) for pairs in of_lifts.values()]


# ---- what the run has

def state_at_rest(case):
    """Returns the stage to which the earthquake is added: a usual one, else the last static one that is judged and not shaken."""
    usual = [stage for stage, condition in case.conditions.items() if condition == "usual" and stage in case.results.stages]
    rest = [stage for stage, condition in case.conditions.items() if condition not in ("earthquake", "after_earthquake") and stage in case.results.stages]
    return (usual or rest or [None])[-1]


def stages_of_modes(case):
    """Returns the last stage of modes without water, and the last one with water; None: there is none."""
    dry = wet = None
    for facts in case.results.summary["stages"]:
        if not any((mode["omega2"] or 0.0) > 0 for mode in facts.get("modes", {}).get("list", ())):
            continue
        if facts.get("added_mass"):
            wet = facts["name"]
        else:
            dry = facts["name"]
    return dry, wet


def shapes_of(case, stage):
    rows = case.results.mesh.vertex_file
    if len(rows) != len(case.mesh.vertices):
        raise SpectrumError(f"stage {stage}: groups with output: false have no shapes in results.h5, and a spectrum needs those of all")
    shapes = np.zeros((len(case.results.stage(stage).modes), len(rows), 2))
    shapes[:, rows] = case.results.stage(stage).modes
    return shapes


def standing(case, stage, shapes):
    mesh, scene = section_cut.standing(case.mesh, case.scene, stage)
    return Swing(mesh, scene, shapes)


def over_of(load, facts, points):
    """[kg/m2] Returns the pressure at points of an added_mass load for the acceleration 1 along the normal (src/water/hydrodynamic.c)."""
    s = np.clip(points.depth / facts["depth"], 0, 1)
    density = float(load.get("density", 1000.0)) * facts["depth"]
    if load.get("rule", "westergaard") == "westergaard":
        return density * 0.875 * np.sqrt(s)
    lean = max(0.0, facts["lean"])
    return density * 0.5 * (0.7412 - 0.0073 * lean) * (s * (2 - s) + np.sqrt(s * (2 - s))) / np.cos(np.radians(lean))


# ---- the ways

class Inertia:
    """Inertia of a stage's modes, and of 1 along x and y, on parts of the dam, with the water of its added_mass loads."""

    def __init__(self, case, stage):
        self.facts, shapes = case.results.stage_summary(stage), shapes_of(case, stage)
        swings = [k for k, mode in enumerate(self.facts["modes"]["list"]) if (mode["omega2"] or 0.0) > 0]
        self.modes = [self.facts["modes"]["list"][k] for k in swings]
        self.still = len(shapes) - len(swings)  # motions without a frequency
        self.swing = standing(case, stage, shapes[swings])
        self.water = []
        for name, facts in (self.facts.get("added_mass") or {}).items():
            load = case.scene.loads[name]
            points = self.swing.points(load["faces"], float(load["level"]))
            self.water.append((points, over_of(load, facts, points)))

    def on(self, part):
        return self.swing.blocks(part) + sum((self.swing.water(part, *of) for of in self.water), 0.0)

    def complaints(self):
        """Says which motions have no frequency, and by how much participations differ from those of the run; nothing where they agree."""
        name, contacts = self.facts["name"], self.facts["modes"]
        found = [_("Stage {0}: {1} motions have no frequency and are left out.", name, self.still)] if self.still else []
        if contacts["open"]:
            found.append(_("Stage {0}: {1} of {2} contacts are open in part or whole, and its modes are softer for it.", name, contacts["open"], contacts["contacts"]))
        return found + list(filter(None, [self.unlike()]))

    def unlike(self):
        ours = self.on(section_cut.WHOLE)[: len(self.modes), 0]
        theirs = np.array([mode["factor_x"] * mode["modal_mass"] for mode in self.modes])
        off = abs(ours - theirs).max(initial=0) / abs(theirs).max(initial=1e-300)
        return _("Inertia summed here differs from that of the run by {0:.1f} % of the largest: forces of the modes are that much off.", 100 * off) if off > UNLIKE else ""


def rock_part(inertia, planes):
    """[-] Returns the part of the mass that can move along x which stands above no base: rock with mass. 0 where the dam has no base, only lifts."""
    swing, bases = inertia.swing, [plane.part.share > 0.5 for plane in planes if plane.is_base]
    if not bases:
        return 0.0
    dam = (swing.density * swing.thickness * areas_of(swing.mesh))[np.any(bases, axis=0)].sum()
    return 1 - (dam + sum(swing.water(section_cut.WHOLE, *of)[-2, 0] for of in inertia.water)) / inertia.facts["modes"]["mass_x"]


def has_light_rock(swing, plane):
    """Tells whether a part of what stands above a plane has hardly any mass: its weight is missing there."""
    light = swing.density < LIGHT
    return plane.part.areas[light].sum() > UNLIKE * plane.part.areas.sum()


def areas_of(mesh):
    return shapely.area(shapely.polygons(mesh.vertices[closed_rings(mesh)]))


def vector(base, systems):
    """(..., 5) Returns N, T, M, and stress at start and end by the straight line [Pa], of forces (..., 3) on the part above."""
    systems = np.asarray(systems, float)
    N = -systems[..., :2] @ base.normal
    T = systems[..., :2] @ base.along
    M = systems[..., 2] - (base.middle[0] * systems[..., 1] - base.middle[1] * systems[..., 0])
    mean, bend = -N / (base.length * base.thickness), 6 * M / (base.length**2 * base.thickness)
    return np.stack([N, T, M, mean - bend, mean + bend], axis=-1)


def row_of(plane, way, sizes, sign, held):
    """Row of a plane under the sizes (5,) of the earthquake's responses. sign: of M where T is positive; held: judges quantities of guidelines.py on a plane."""
    base, hands = plane.base, []
    for push in (1, -1):
        for lift in (1, -1):
            N, T, M = lift * sizes[0], push * sizes[1], sign * push * sizes[2]
            force = T * base.along - N * base.normal
            hands.append(plane.shaken(np.array([*force, M + base.middle[0] * force[1] - base.middle[1] * force[0]])))
    still = plane.shaken(np.zeros(3))
    tension = float(max(stress + size for stress, size in zip(still.linear, sizes[3:], strict=True)))
    values = worst_of(hands, plane.strength, plane.crushes) | {"tension": max(tension, 0.0)}
    if not plane.is_base:
        values["sliding_partial"] = values["sliding_partial"] and partial(values["sliding_partial"], of_lift=True)
        squeezed = max([hand.compression or 0.0 for hand in hands] + [float(size - stress) for stress, size in zip(still.linear, sizes[3:], strict=True)])
        values |= {"lift_strength": squeezed / plane.crushes, "lift_tension": values["tension"] / plane.crushes} if plane.crushes else {}
    stands = all(hand.crack is not None for hand in hands)
    return Row(plane.name, float(base.middle[1]), way, float(sizes[1]), float(sizes[2]), float(sizes[0]), values["sliding_peak"] if stands else None, stands,
               tension, values["crack"] * base.length if stands else None, plane.is_base, held(plane, values, not any(map(crack_notes.is_unconfirmed, hands))))  # fmt: skip


def worst_of(hands, strength, crushes=None):
    """Quantities of guidelines.py to the worst of several hands; factors are 0 and the crack is 1 where one finds no equilibrium, None without strength. crushes: [Pa] compressive strength."""
    refused = any(hand.crack is None for hand in hands)
    each = [factors(hand, strength) for hand in hands]
    found = {"sliding_peak": "peak", "sliding_residual": "residual", "friction_only": "friction_only"}
    found = {name: None if each[0][key] is None else 0.0 if refused else min(one[key] for one in each) for name, key in found.items()}
    length = hands[0].base.length
    found["sliding_partial"] = None if each[0]["peak"] is None else partial(by_partial_factors, [(0.0, 0.0) if hand.crack is None else (one["friction_only"], one["peak"]) for hand, one in zip(hands, each, strict=True)])
    found["strength"] = None if not crushes else np.inf if refused else max(hand.compression for hand in hands) / crushes
    found["flotation"] = min(np.inf if not hand.uplift else (hand.N + hand.uplift) / hand.uplift for hand in hands)
    return found | {"crack": 1.0 if refused else max(hand.crack for hand in hands) / length, "middle": max(2 * abs(hand.eccentricity) / length if hand.N > 0 else np.inf for hand in hands)}


def by_partial_factors(shares, entry, of_lift=False):
    """The number of a limit sliding_partial of a base, of shares as in partial_factors.py; None where the limit has factors on actions, which largest responses do not have by load."""
    return None if entry.get("actions") and not of_lift else partial_factors.with_factors(shares, entry["friction"], entry["cohesion"])


def by_coefficient(spectrum, base, whole):
    """Sizes (5,) of responses of what follows the ground. whole: (2, 3), under 1 m/s2 along x and along y."""
    return np.hypot(spectrum.ground * vector(base, whole[0]), spectrum.ground_vertical * vector(base, whole[1]))


def by_modes(spectrum, base, parts, whole, modes):
    """Sizes (5,) by all modes. parts: (n, 3) inertia of the shapes; modes: of summary.json."""
    omega = np.sqrt([mode["omega2"] for mode in modes])
    sizes, rule = np.zeros(5), spectrum.dam.get("combine", "cqc")
    for axis, of, ground in ((0, spectrum.horizontal, spectrum.ground), (1, spectrum.vertical, spectrum.ground_vertical)):
        factor = np.array([mode[("factor_x", "factor_y")[axis]] for mode in modes])
        sizes = np.hypot(sizes, modal_sums.combine(vector(base, factor[:, None] * parts), vector(base, whole[axis]), of(2 * np.pi / omega), ground, omega, spectrum.damping, rule))
    return sizes


def reservoir_at(case, stage, swing, spectrum):
    """Returns (Reservoir, FacePoints, elevation of its bottom) of the highest reservoir of a stage; Nones: there is none."""
    loads = [load for load in case.scene.stage_loads(stage).values() if load.get("type") == "reservoir"]
    if not loads:
        return None, None, 0.0
    load = max(loads, key=lambda load: float(load["level"]))
    points = swing.points(load["faces"], float(load["level"]))
    if not len(points.place):
        return None, None, 0.0
    bottom = min(float(y) for y in section_cut.wet_segments(case.mesh, load)[..., 1].ravel())
    keys = {"sound": spectrum.dam["sound"]} if "sound" in spectrum.dam else {}
    return Reservoir(float(load["level"]) - bottom, float(load.get("density", 1000.0)), reflection=float(spectrum.dam.get("reflection", 1.0)), **keys), points, bottom


def first_mode(case, found, inertia):
    """Puts the first mode into a study. inertia: of the modes of the empty dam. Returns a function: plane to sizes (5,)."""
    spectrum, modes = found.spectrum, inertia.modes
    largest = max(mode["mass_x"] for mode in modes)
    k = next(k for k, mode in enumerate(modes) if mode["mass_x"] >= FUNDAMENTAL * largest)
    found.reservoir, points, bottom = reservoir_at(case, found.stage, inertia.swing, spectrum)
    order = np.argsort(points.place[:, 1]) if points else []

    def shape(y):
        return np.interp(y + bottom, points.place[order, 1], points.phi[k, order, 0])

    mode = modes[k]
    found.first = fenves_chopra.first_mode(np.sqrt(mode["omega2"]), mode["modal_mass"], mode["factor_x"] * mode["modal_mass"], shape, found.reservoir, spectrum.damping,
                                           float(spectrum.dam.get("rock_period", 1.0)), float(spectrum.dam.get("rock_damping", 0.0)), case.scene.thickness)  # fmt: skip
    found.acceleration = float(spectrum.horizontal(found.first.period, found.first.damping))
    own = np.sqrt(mode["omega2"]) / found.first.lengthening / found.reservoir.cutoff if found.reservoir else 0.0
    if own > NEAR:
        found.why.append(_("First mode: dam and water swing at {0:.3f} of the reservoir's own frequency ({1:.2f} Hz; reflection {2:.2f}). Near it and beyond it pressures hang on what the bottom takes up, and the tables of Fenves and Chopra end at {3:.2f}: hold it against all modes.",
                           own, found.reservoir.cutoff / (2 * np.pi), found.reservoir.reflection, NEAR))  # fmt: skip
    height = points.place[:, 1] - bottom if points else None

    def sizes(plane):
        blocks = inertia.swing.blocks(plane.part)
        swings, rigid = (np.zeros(3), np.zeros(3)) if points is None else (inertia.swing.pressed(plane.part, points, p(height)) for p in (found.first.pressure, found.first.rigid))
        f1 = found.first.forces(found.acceleration, blocks[k], swings)
        fsc = found.first.static(spectrum.ground, blocks[-2], rigid, blocks[k])
        return np.hypot(vector(plane.base, f1), vector(plane.base, fsc))

    return sizes


# ---- all of it

def planes_of(case, stage, condition, assessments, swept):
    """Planes of a stage: its bases, and those of its lifts that are no base, from the lowest up. condition: as which the earthquake is judged, by which a crack starts."""
    found = [Plane(a.name, a.base, a.strength, case.part(a.name, a.path), partial(a.shaken, condition=condition), True, plane_of(case, a.name, a.path), compressive_strength(case, a))
             for a in assessments if a.stage == stage and a.shaken is not None]  # fmt: skip
    own = [plane.base.ends() for plane in found]
    swept = [lift for lift in swept if not any(np.allclose(lift.base.ends(), ends, atol=section_cut.GAP) for ends in own)]
    return found + [Plane(_("lift at {0:.2f} m", lift.level), lift.base, lift.strength, case.part(f"lift at {lift.level:.4f}", lift.base.ends()), partial(lift.shaken, condition=condition), kind="lift", crushes=lifts.crushes(case, lift)) for lift in swept]


def held_by(case, spectrum):
    """Returns a function (plane, values, sure) to the limits of the guideline of the options on a base or a lift, by the condition that the file names; sure: as in guidelines.judge. A lift is
    held against what lifts at rest are: sliding where its strength is known, with the actions as they are, and the stresses of lifts."""
    guideline, judge = guidelines.of(case.options), partial(guidelines.judge, given=case.options.given)

    def held(plane, values, sure):
        if guideline is None:
            return []
        rows = judge(guideline, spectrum.condition, values, plane=plane.kind, sure=sure)
        if plane.is_base:
            return rows
        sliding = [row for row in rows if row.quantity in lifts.SLIDING and None not in (row.limit, row.value)]
        return sliding + judge(guideline, spectrum.condition, values, lifts=True)

    return held


def study(case, spectrum, assessments, swept=()):
    """Returns the Study of a run; rows are empty, and `why` says what is missing, where there is nothing to apply a spectrum to. swept: lifts of the stage at rest."""
    found = Study(spectrum, state_at_rest(case))
    dry, wet = stages_of_modes(case)
    if found.stage is None:
        found.lacks(_("There is no stage at rest to which an earthquake could be added."))
        return found
    if dry is None and wet is None:
        found.lacks(_("The run has no modes: add a stage {type: modes} behind that of the weight, and one with an added_mass load behind the usual one."))
        return found
    planes = planes_of(case, found.stage, spectrum.condition, assessments, swept)
    ways = {}
    found.stage_of_modes, found.with_water = wet or dry, wet is not None
    inertia = Inertia(case, found.stage_of_modes)
    found.modes = inertia.facts["modes"]
    found.why += inertia.complaints()
    left_out = [plane.name for plane in planes if has_light_rock(inertia.swing, plane)]
    if left_out:
        (found.lacks if any(plane.is_base for plane in planes if plane.name in left_out) else found.why.append)(_("Left out, because rock without mass stands above them: {0}.", ", ".join(left_out)))
    rock, planes = rock_part(inertia, planes), [plane for plane in planes if plane.name not in left_out]
    on = {plane.name: inertia.on(plane.part) for plane in planes}
    ways["coefficient"] = lambda plane: by_coefficient(spectrum, plane.base, on[plane.name][-2:])
    if rock > ROCK:
        found.lacks(_("{0:.0f} % of the mass that can move is below all bases. Rock with mass swings as no ground does, and a spectrum is that of the ground at the dam: only the coefficient is shown. "
                           "Take a scene of its own for the modes, whose rock has a density of 1 kg/m3; or name the foot of the dam with --path.", 100 * rock))  # fmt: skip
    elif dry:
        try:
            empty = Inertia(case, dry) if found.with_water else inertia
            ways["first mode"] = first_mode(case, found, empty)
            found.why += empty.complaints() if found.with_water else []
        except fenves_chopra.NoRootError as error:
            found.why.append(_("First mode: {0}.", str(error)))
    else:
        found.why.append(_("The first mode needs the modes of the empty dam: add a stage {type: modes} without loads behind that of the weight."))
    if rock <= ROCK:
        ways["all modes"] = lambda plane: by_modes(spectrum, plane.base, on[plane.name][:-2], on[plane.name][-2:], inertia.modes)
    if not found.with_water and any(load.get("type") == "reservoir" for load in case.scene.stage_loads(found.stage).values()):
        found.lacks(_("No stage of modes has the water (an added_mass load): coefficient and all modes are those of the dam without it."))
    if case.options.guideline and spectrum.condition not in guidelines.of(case.options)["conditions"]:
        found.lacks(_("This guideline has no limits for the condition {0}.", _(spectrum.condition)))
    held = held_by(case, spectrum)
    for plane in planes:
        pull = vector(plane.base, on[plane.name][-2])
        sign = float(np.sign(pull[1] * pull[2])) or 1.0
        found.rows += [row_of(plane, way, sizes(plane), sign, held) for way, sizes in ways.items()]
    fallen = [f"{row.plane} ({_(row.way)})" for row in found.rows if not row.stands and guidelines.FAIL not in {limit.verdict for limit in row.limits}]
    if fallen and case.options.guideline:
        found.lacks(_("No equilibrium at the peak, and no limit that says what follows: {0}.", ", ".join(fallen[:NAMED]) + (", " + _("{0} more", len(fallen) - NAMED) if len(fallen) > NAMED else "")))
    return found
