"""Applies the gravity method beside the block model: to every joint that is a line, and to any path, in every stage of a run.

    quoin report --terminal FOLDER [--guideline usace] [--condition flood=unusual] [--path lift=0,10,15,10]
        [--uplift npb] ...        tables in the terminal (terminal.py); --help lists all; docs/safety.md explains

Both get the same loads on faces: the gravity method sums the table of the run.
"""

from dataclasses import dataclass, field
from functools import partial

import numpy as np
import shapely

from quoin_tools.assess import (
    base_names,
    base_water,
    broken,
    combinations,
    crack_notes,
    design_spectrum,
    earthquake,
    guidelines,
    load_check,
    merged_anchors,
    method_differences,
    partial_factors,
    section_cut,
    sliding_paths,
    uplift,
    wedge,
)
from quoin_tools.assess.assessment_options import OptionError, Options, check_named
from quoin_tools.assess.base_water import block_uplift, dry_stretches, scene_uplift, uplift_under
from quoin_tools.assess.gravity import Base, GravityError, Hand, Uplift, hand_method
from quoin_tools.assess.judgement import judged
from quoin_tools.assess.strength import (
    NONE,
    ON_PATH,
    bearing_on,
    closed_stretches,
    contacts_on,
    factors,
    row_of,
    rows_of,
    strength_of,
)
from quoin_tools.base import scene
from quoin_tools.base.figures import Figure
from quoin_tools.base.language import N_, _, ngettext, numeral
from quoin_tools.base.results import NO_SHEAR, Results, ResultsError, energy_account
from quoin_tools.mesh import blockmesh
from quoin_tools.mesh.of_run import mesh_of

WHOLE_PATH = 0.99  # of the path's length within the body must be contacts, else the block model gives no number for it
WITHIN = 1e-6  # of the length of a base
SLIDES = {"peak": N_("sliding factor, peak, c on the closed length"), "residual": N_("sliding factor, residual, c on the closed length")}
REFUSED = {"joint": N_("Joint {0}: {1}; --path names a way through several joints."), "joints": N_("Joints {0}: {1}; --path names a way through several joints."),
           "path": N_("Path {0}: {1}."), "way": N_("Way {0}: {1}.")}  # fmt: skip
BY_HAND = ((N_("Gravity method: no equilibrium without tension, {0}."), N_("Gravity method: {0}.")),
           (N_("Gravity method with uplift: no equilibrium without tension, {0}."), N_("Gravity method with uplift: {0}.")))  # fmt: skip
ERRORS = (ResultsError, GravityError, scene.SceneError, blockmesh.MeshError, uplift.UpliftError,
          guidelines.GuidelineError, base_names.UnknownBaseError, OptionError, design_spectrum.SpectrumError)  # fmt: skip


@dataclass
class Line:
    """Returns a row: quantity, unit, numbers to print (None: there is none)."""

    quantity: str
    unit: str
    digits: int
    block: float | None
    hand: float | None
    with_uplift: float | None = None

    @property
    def difference(self):
        return None if self.block is None or self.hand is None else self.block - self.hand


@dataclass
class Assessment:
    """A base in a stage."""

    stage: str
    name: str
    kind: str  # joint, joints, path or way
    base: Base
    path: np.ndarray  # [m] corners, from base.start to base.end
    block: dict | None
    hand: Hand
    strength: dict
    heel: str = "start"  # the end at which the water stands
    with_uplift: Hand | None = None  # by the rule of the options, in place of the scene's
    water: Uplift | None = None  # the governing uplift: of the options, else of the scene
    scene_water: Uplift | None = None  # uplift load of the scene under the base
    other_water: bool = False  # other water on the part: uplift of the scene along a bent path, or as the run has computed it
    computed: np.ndarray | None = None  # (X, Y, M) on the part above of the water that flows in joints
    straight: tuple | None = None  # (Uplift, Hand) of the straight line between the computed pressures at the ends
    yields: list = field(default_factory=list)  # rows of earthquake.py
    shaken: object = None  # function: the governing Hand under (X, Y, M) more, of an earthquake
    anchored: tuple | None = None  # [N] force of anchors across and along the base; (sliding factor, open length) with and without them
    with_anchors: tuple | None = None
    without_anchors: tuple | None = None
    acting: partial_factors.Acting | None = None  # what the gravity method that governs has summed
    notes: list = field(default_factory=list)
    condition: str | None = None
    plane: str = "contact"  # as of guidelines.PLANES
    limits: list = field(default_factory=list)
    complete: bool = True

    @property
    def governing(self):
        return self.with_uplift or self.hand


@dataclass
class Case:
    """A run with its scene, mesh and options."""

    results: Results
    scene: scene.Scene
    mesh: blockmesh.BlockMesh
    mesh_path: str
    options: Options
    body: object = None
    parts: dict = field(default_factory=dict)  # cut parts by name: loads change from stage to stage, cuts do not
    sliding_paths: dict = field(default_factory=dict)  # by joint: the paths that sliding_paths.py has found
    solvers: dict = field(default_factory=dict)  # SceneLoads by the groups that are absent (load_check.py)
    bounds: dict = field(default_factory=dict)  # by stage of trials: its bound by limit analysis, or why there is none (show/limit_part.py)
    planes: dict = field(default_factory=dict)  # by base: its kind (planes.py)
    danger: list = field(default_factory=list)  # its danger level, once it is known (danger_level.py)
    in_part: set = field(default_factory=set)  # joints of several lines, of which sliding_paths.py takes some

    @property
    def conditions(self):
        """Stages that are judged, and as what: those named with --condition; else those whose `condition` the scene says, and of the others the last static one
        of each case, by its pseudo-static loads, else by its name (combinations.by_name), else as usual.

        The stages of trials end at the brink, with strengths or water that are not those of the dam; a stage with partial factors belongs to its case."""
        kinds = {name: self.scene.stages.get(name, {}).get("type", "static") for name in self.results.stages}
        static = [name for name, kind in kinds.items() if kind == "static" and not self.scene.is_design(name)]
        chains = {name: self.scene.stages_before(name) if name in self.scene.stages else [] for name in static}
        passed = {earlier for chain in chains.values() for earlier in chain}
        judged = [name for name in static if name not in passed] or self.results.stages[-1:]
        if self.options.conditions:
            return self.options.conditions
        own = {name: condition for name in self.results.stages if (condition := self.scene.condition(name))}
        found = {name: own.get(name) or self.usual_or_shaken(name, [n for n in chains.get(name, []) if kinds.get(n) == "static"]) for name in self.results.stages if name in judged or name in own}
        return {name: condition for name, condition in found.items() if condition != "none"}

    def usual_or_shaken(self, stage, before):
        """Returns the condition of a stage, by its loads and by the loads of the static stages before it."""
        if earthquake.loads_of(self, stage):
            return "earthquake"
        return "after_earthquake" if any(earthquake.loads_of(self, name) for name in before) else combinations.by_name(self, stage)

    @property
    def whole(self):
        """The body that all blocks are together."""
        self.body = section_cut.body(self.mesh) if self.body is None else self.body
        return self.body

    def forces(self, stage, part=section_cut.WHOLE):
        """Returns (X, Y, M) of each load of a stage on a part, as the run applied them to the mesh as drawn, and the names of loads that the gravity method does not know."""
        return section_cut.stage_forces(self.mesh, self.scene, stage, part, self.results.stage(stage).loads)

    def part(self, name, path):
        if name not in self.parts:
            self.parts[name] = section_cut.cut(self.mesh, path, self.whole)
        return self.parts[name]


def guidelines_of(folder, used):
    """Returns the file of guidelines that the scene names, or None."""
    found = scene.find(folder, used.guidelines)
    if used.guidelines and found is None:
        raise guidelines.GuidelineError(f"{used.path}: guidelines: '{used.guidelines}' is not there")
    return found


def load_case(folder, options):
    options.check()
    results = Results(folder)
    used = scene.of_run(folder, results.summary)
    options.guidelines = options.guidelines or guidelines_of(folder, used)
    check_named(options, dict.fromkeys([*used.stages, *results.stages]))
    if options.ky is not None and not any(stage.get("type") == "dynamic" for stage in used.stages.values()):
        raise OptionError("--ky: it is for stages that are shaken, and the run has none")
    mesh, path = mesh_of(results, used)
    case = Case(results, used, mesh, path, options)
    base_names.check(case)
    combinations.check(case)
    return case


# ---- the block model ------------------------------------------------------------------------------------------

def block_of_joint(summary, length):
    """Numbers of a joint in summary.json."""
    N, M = summary["N"], summary["M"]
    return {
        "N": N, "T": summary["T"], "M": M, "resultant": 0.5 * length - M / N if N > 0 else None,
        "start": summary["sigma_linear_start"], "end": summary["sigma_linear_end"], "crack": summary["open_length"],
        "compression": -summary["sigma_min"]["sigma"], "friction": summary["friction_needed"],
        "peak": summary["sliding_factor_peak"], "residual": summary["sliding_factor_residual"],
    }  # fmt: skip


def block_on_path(case, stage, path, base, strength):
    """Sums of the contact forces along a path; None where the path leaves the joints of the model."""
    contacts = case.results.stage(stage).contacts
    mine = contacts_on(path, contacts)
    inside = section_cut.LineString(path).intersection(case.whole.buffer(ON_PATH)).length
    if not mine.any() or contacts.length[mine].sum() < WHOLE_PATH * inside:
        return None
    sigma = contacts.sigma * case.results.mesh.control(contacts)[:, None]
    normal, on_b, point = contacts.normal[mine], contacts.on_b()[mine], contacts.point[mine]
    pieces = np.diff(path, axis=0)
    nearest = np.argmin(shapely.distance(shapely.points(point.mean(axis=1))[:, None], shapely.linestrings(np.stack([path[:-1], path[1:]], axis=1))), axis=1)
    up = np.stack([-pieces[nearest, 1], pieces[nearest, 0]], axis=1)[:, None]
    below = (normal * up).sum(axis=2, keepdims=True) > 0  # the normal leads from b, the lower side then
    forces = np.where(below, on_b, -on_b)
    system = sum((section_cut.force_at(f, p) for f, p in zip(forces.reshape(-1, 2), point.reshape(-1, 2))), np.zeros(3))
    N, T, M = base.resultants(system)
    hand = Hand(base, N, T, M)
    bearing = mine & bearing_on(base, contacts)  # of a bent path the plane that it slides on
    closed, opened = closed_stretches(base, contacts, bearing)
    values = {"N": N, "T": T, "M": M, "resultant": hand.resultant if N > 0 else None, "start": hand.linear[0],
              "end": hand.linear[1], "crack": opened, "compression": float(-sigma[mine].min()),
              "friction": hand.friction_needed}  # fmt: skip
    if case.results.stage_summary(stage)["verdict"] not in ("converged", "completed"):  # a state that moves has no factors
        return values | {"friction": None} | NONE
    places, pressing = places_along(base, point, contacts.joint[mine]), -(forces @ base.normal).sum(axis=1)
    return values | factors(hand, strength, closed, lambda low, high: pressing[(places >= low) & (places < high)].sum())


def places_along(base, point, joint):
    """Returns distances [m] of contacts from the start of a base; contacts of an upright face of a key or step lie just within the stretch of their own joint. point: ends (n, 2, 2); joint: (n,)."""
    places, ends = (point.mean(axis=1) - base.start) @ base.along, (point - base.start) @ base.along
    for row in np.unique(joint):
        mine = joint == row
        places[mine] = np.clip(places[mine], ends[mine].min() + WITHIN * base.length, ends[mine].max() - WITHIN * base.length)
    return places


# ---- the hand method ------------------------------------------------------------------------------------------

def assess_base(case, stage, name, path, kind, strength):
    """Hand method and block model of one base in one stage; of a bent path on the plane that the part above slides on. strength: keys, or a function of that plane."""
    part = case.part(name, path)
    path = path if kind == "joint" else section_cut.trimmed(path, case.whole)
    base = Base(path[0], path[-1], case.scene.thickness)
    forces, left_out = case.forces(stage, part)
    anchors = merged_anchors.pulls(case, stage, part, path)
    dry = section_cut.total(forces | anchors)
    bent = wedge.is_bent(path)
    flowing = base_water.computed(case, stage, part)
    if bent:
        water, others = None, block_uplift(case, stage, part) + flowing
        base = broken.plane_under(case, stage, kind, path, dry + others)
    else:
        water, others = scene_uplift(case, stage, part, base)
        others = others + flowing
    strength = strength(base) if callable(strength) else strength
    base.opens = None if bent else base_water.opens(case, stage, strength)
    water = base_water.with_crack_before(case, stage, base, water, forces, section_cut.total(anchors), others)
    shock = None if bent else base_water.shock_before(case, stage)
    shaken = assess_base(case, shock, name, path, kind, strength).governing if shock else None
    water, opened = base_water.after_earthquake(case, base, water, shock, shaken)
    hand = hand_method(base, dry, water, others)
    bent = bent and base.path is None
    if case.results.stage_summary(stage)["verdict"] == "diverged":
        block = None
    elif kind == "joint" and not bent and base.path is None:
        block = block_of_joint(case.results.stage_summary(stage)["joints"][name], base.length)
    else:
        block = block_on_path(case, stage, path, base, strength)
    if block:
        block["uplift"] = float(np.hypot(*(block_uplift(case, stage, part) + flowing)[:2])) or None
    load_water = None if bent or base.path is not None else water
    found = Assessment(stage, name, kind, base, path, block, hand, strength, base_water.heel_and_levels(case, stage, base, load_water)[0])
    asked = base_water.with_crack_before(case, stage, base, uplift_under(case, stage, name, base, load_water), forces, section_cut.total(anchors), None)
    asked, opened = base_water.after_earthquake(case, base, asked, shock, shaken) if asked else (asked, opened)
    found.notes += filter(None, [opened])
    under = (asked or water, None if asked else others)
    found.yields = earthquake.yields(case, stage, forces, lambda total: broken.with_water(base, total + section_cut.total(anchors), *under), strength)
    merged_anchors.compare(found, anchors, found.hand, hand_method(base, section_cut.total(forces), water, others), lambda answer: factors(answer, strength)["peak"])
    if flowing.any():
        found.computed = flowing
        found.straight = None if bent or base.path is not None else base_water.straight(case, stage, base, dry)
    if asked and bent:
        asked, found.complete = None, False
        found.notes.append(_("Uplift by a rule is not known on a bent path: an uplift load of the scene is."))
    found.shaken = partial(base_water.shaken_hand, case, base, None if bent or base.path is not None else strength, dry, asked or water, None if asked else others)
    if asked:
        found.with_uplift = broken.with_water(base, dry, asked)
        found.notes += base_water.contradictions(case, stage, name, base, load_water)
    found.acting = partial_factors.acting(case, stage, forces, section_cut.total(anchors), asked or water, None if asked else others)
    found.water, found.scene_water, found.other_water = asked or water, water, bool(others.any()) and not asked
    if found.water:
        rest = dry if asked else dry + others
        found.notes += uplift.remarks(found.water.rule, found.water.heads) + crack_notes.full_head(found, rest) + base_water.in_earthquake(case, found.water, found.governing)
    for (refused, noted), answer in zip(BY_HAND, (hand, found.with_uplift), strict=True):
        if answer and answer.refused:
            found.notes.append(_(refused, answer.refused))
        found.notes += [_(noted, note) for note in answer.notes] if answer else []
    if bent:
        found.notes.insert(0, _("The path is bent. The part above slides on {0}: all numbers are those of this plane; what lies on the rest of the path parts and bears nothing.", wedge.words(base)))
    found.notes += method_differences.notes(case, stage, found)
    if base.path is not None:
        found.notes.insert(0, broken.words(base))
    if left_out:
        found.complete = False
        found.notes.append(_("Loads that the gravity method does not know are left out of it: {0}.", ", ".join(left_out)))
    return found


def joint_path(case, stage, name):
    """Corners of a joint that is a line: its contacts' ends in order, straight runs merged."""
    facts = case.results.stage_summary(stage)["joints"][name]
    start, end = (np.array([facts[at]["x"], facts[at]["y"]]) for at in ("start", "end"))
    contacts = case.results.stage(stage).contacts
    points = contacts.point[contacts.joint == case.results.mesh.joint_names.index(name)].reshape(-1, 2)
    along = (end - start) / np.hypot(*(end - start))
    points = points[np.argsort((points - start) @ along, kind="stable")]
    kept = [start]
    for point in points:
        if (point - kept[-1]) @ along > ON_PATH:
            kept.append(point)
    kept[max(1, len(kept) - 1) :] = [end]  # a joint between blocks that are not written has its two ends only
    return section_cut.straightened(np.array(kept))


# ---- all of a run ---------------------------------------------------------------------------------------------

ACCOUNT_OUT = 0.01  # of the energy moved, as the program's own warning


def account_complaints(facts):
    """Returns complaints where the energy account of a dynamic stage does not hold to a hundredth; none: it holds."""
    account = energy_account(facts)
    if account is None:
        return [_("There is no energy account: nothing says that its motion is that of the model.")]
    made, lost, moved = account
    out = [part > ACCOUNT_OUT * moved for part in (made, lost)]
    if not any(out):
        return []
    parts = (_("{0:.2g} of it made from nothing and {1:.2g} of it lost as contacts were found again", made / moved, lost / moved) if all(out) else
             _("{0:.2g} of it made from nothing", made / moved) if out[0] else _("{0:.2g} of it lost as contacts were found again", lost / moved))  # fmt: skip
    return [_("The energy account is out: of {0:.3g} J moved, {1}. Its motion is not that of the model; forces and displacements of this stage are no basis for a judgement.", moved, parts)]


HINGE_SHORT = 0.02  # of the arm of a rigid hinge, as the program's own warning


def hinge_complaints(facts):
    """Returns a complaint where a free-standing column of a dynamic stage turns over earlier than about a rigid edge, because tptm presses its hinge over a length."""
    hinge = facts.get("rocking_hinge")
    if hinge is None or hinge["missing"] < HINGE_SHORT:
        return []
    return [ngettext("With joints of this stiffness a body that turns over has an arm {1:.0f} % shorter than about a rigid edge, at ({2:.2f}, {3:.2f}) m: "
                     "a slow push succeeds about that much earlier, a blow by less.",
                     "With joints of this stiffness {0} bodies that turn over together have an arm {1:.0f} % shorter than about a rigid edge, at ({2:.2f}, {3:.2f}) m: "
                     "a slow push succeeds about that much earlier, a blow by less.", hinge["macroblocks"], 100 * hinge["missing"], hinge["x"], hinge["y"])]  # fmt: skip


def stage_complaints(case, stage):
    """Lists why numbers of a stage are no basis for a verdict."""
    facts, found = case.results.stage_summary(stage), []
    if facts["verdict"] != "converged":
        found.append(_("The stage ended {0}: the block model's numbers are not those of an equilibrium.", _(facts["verdict"])))
    kind = case.scene.stages.get(stage, {}).get("type", "static")
    if kind == "strength_reduction" and stage in case.conditions:
        found.append(_("The stage is a strength reduction: joints have the lowered strengths of its last stable trial."))
    if kind == "load_factor" and stage in case.conditions:
        found.append(_("The stage is a load factor: its loads are those of its last stable trial."))
    if kind == "anchor_force" and stage in case.conditions:
        found.append(_("The stage is a search for the force of anchors: joints have strengths divided by required."))
    if kind == "dynamic":
        found.append(_("The stage is dynamic: the gravity method knows loads at rest only."))
        found += account_complaints(facts) + hinge_complaints(facts)
    found += dry_stretches(facts) + base_water.complaints(case, stage)
    if facts["verdict"] == "diverged":  # displacements and the loads that follow them are no numbers
        return found
    return found + load_check.complaints(case, stage, np.array([facts["applied"]["x"], facts["applied"]["y"]]))


def assess_named(case, stage, name, kind, names):
    """Assesses a joint, joints in one line, or a path of the options."""
    joints = case.results.stage_summary(stage)["joints"]
    if kind == "path":
        path = section_cut.checked_path(case.options.paths[name])
    else:
        path = section_cut.straightened(np.concatenate([joint_path(case, stage, one) for one in names]))
    if kind == "joint" and wedge.is_bent(path):  # its corners in the order in which they hang together
        path = next((way.path for way in sliding_paths.through(case, stage, name) if way.name == name), path)
    return assess_base(case, stage, name, path, kind, case.options.strengths.get(name) or strength_of(case.scene, stage, names, joints))


def assess(case):
    """Returns assessments of all stages, joints and paths; and by stage the lines about what could not be assessed."""
    all_found, complaints = [], {}
    for stage in case.results.stages:
        if case.scene.stages.get(stage, {}).get("type") == "modes":  # its forces belong to the stage before
            continue
        sentences = complaints[stage] = stage_complaints(case, stage)
        flawed = bool(sentences)
        joints = case.results.stage_summary(stage)["joints"]
        failed = {}
        rows = rows_of({name: facts for name, facts in joints.items() if facts["line"]}, case.options.merged)
        bases = [("+".join(names), "joint" if len(names) == 1 else "joints", names) for names in rows]
        wanted = []  # ways through joints that are no base by themselves
        for name, facts in joints.items():
            if not facts["line"]:
                wanted += (own := sliding_paths.through(case, stage, name))
                sentences += [] if own and name not in case.in_part else [_("Joint {0} is no line: the gravity method needs a plane, and takes the longest of its lines in the ground.", name) if own else _("Joint {0} is no line: the gravity method needs a plane.", name)]
        in_line = []  # rows of joints that are a base together
        for name, kind, names in bases + [(name, "path", ()) for name in case.options.paths]:
            try:
                found = assess_named(case, stage, name, kind, names)
            except GravityError as error:
                row = row_of(name, joints) if kind == "joint" else []
                own = sliding_paths.through(case, stage, name) if len(row) == 1 else []
                in_line += [row] if len(row) > 1 and row not in in_line else []
                wanted += own
                if not own and len(row) < 2:
                    failed.setdefault((kind, str(error)), []).append(name)
                continue
            all_found.append(judged(case, found, flawed))
        for row in in_line:
            try:
                all_found.append(judged(case, assess_named(case, stage, "+".join(row), "joints", row), flawed))
            except GravityError as error:
                wanted += (own := [way for name in row for way in sliding_paths.through(case, stage, name)])
                if not own:
                    failed.setdefault(("joints", str(error)), []).append("+".join(row))
        for way in {way.name: way for way in wanted}.values():
            try:
                found = assess_base(case, stage, way.name, way.path, "way", partial(sliding_paths.strength, case, stage, way))
            except GravityError as error:
                if stage in case.conditions:
                    failed.setdefault(("way", str(error)), []).append(way.name)
                continue
            found.notes = sliding_paths.words(way) + found.notes
            found.complete &= way.intact == 0 or bool(found.strength)
            all_found.append(judged(case, found, flawed))
        sentences += [_(REFUSED[kind], ", ".join(names), why) for (kind, why), names in failed.items()]
    base_names.check_used(case, all_found)
    return all_found, complaints


def lines(found):
    """Rows of the table: block model, gravity method, and the latter with uplift."""
    def numbers(hand):
        if hand is None:
            return {}
        values = {"N": hand.N, "T": hand.T, "M": hand.M, "resultant": hand.resultant if hand.N > 0 else None,
                  "start": hand.linear[0], "end": hand.linear[1], "crack": hand.crack, "compression": hand.compression,
                  "friction": hand.friction_needed if hand.N > 0 else None, "uplift": hand.uplift or None}  # fmt: skip
        return values | (factors(hand, found.strength) if hand.crack is not None else {})

    rows = ((_("N, normal force"), "kN", "N", 1e-3, 1), (_("T, shear force"), "kN", "T", 1e-3, 1),
            (_("M about the middle"), "kN m", "M", 1e-3, 1), (_("U, uplift force"), "kN", "uplift", 1e-3, 1),
            (_("resultant from the start"), "m", "resultant", 1, 3), (_("straight-line stress at the start"), "kPa", "start", 1e-3, 1),
            (_("straight-line stress at the end"), "kPa", "end", 1e-3, 1), (_("crack length, no tension"), "m", "crack", 1, 3),
            (_("largest compression"), "kPa", "compression", 1e-3, 1), ("atan |T| / N", "deg", "friction", 1, 2),
            (_(SLIDES["peak"]), "", "peak", 1, 3), (_(SLIDES["residual"]), "", "residual", 1, 3))  # fmt: skip
    sources = found.block or {}, numbers(found.hand), numbers(found.with_uplift)
    result = []
    for words, unit, key, factor, digits in rows:
        values = [None if s.get(key) is None else factor * s[key] for s in sources]
        if key in ("peak", "residual"):
            values = [np.inf if value is not None and value > NO_SHEAR else value for value in values]
        if any(value is not None for value in values):
            result.append(Line(words, unit, digits, *values))
    for name, which, value, _how, ran in found.yields:
        hand = (None, value) if found.with_uplift else (value, None)
        result.append(Line(_("yield coefficient {0} of {1}", which, name), "", 4, ran[0] if ran else None, *hand))
    return result


def cell(value, digits, sign=""):
    """A number for people: minus zero is zero."""
    if value is None or not np.isfinite(value):
        return "-" if value is None or np.isnan(value) else "∞"
    return Figure(numeral(f"{round(value, digits) + 0.0:{sign}.{digits}f}"), value)


def beside(found):
    """The uplift of a base by BESIDE of base_water.py, as words."""
    return [(words, cell(force, 1), cell(at, 3), *(cell(factor, 3) for factor in factors)) for words, force, at, *factors in base_water.side_by_side(found)]
