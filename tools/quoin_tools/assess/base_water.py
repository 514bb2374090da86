"""Finds the water on a base: levels at its ends, uplift by the rule of the options, by the loads of the scene, and as the run has computed it.

    under, others = scene_uplift(case, stage, part, base)      # of the scene, in both methods
    flowing = computed(case, stage, part)                      # of the water that flows in joints, in both methods
    rule = uplift_under(case, stage, name, base)               # of the options, in the gravity method only
"""

from dataclasses import replace

import numpy as np
import shapely

from quoin_tools.assess import broken, crack_start, earthquake, guidelines, section_cut, surface, uplift
from quoin_tools.assess.gravity import Uplift, hand_method
from quoin_tools.assess.heel import side_of
from quoin_tools.assess.joint_uplift import uplift_loads
from quoin_tools.assess.strength import factors
from quoin_tools.base.flow import CARRIES, STILL, WEDGE, at_end, facts_of
from quoin_tools.base.language import N_, _, ngettext
from quoin_tools.base.results import NO_SHEAR
from quoin_tools.mesh.blockmesh import face_ends

AT_END = 0.01  # [m] faces and joints no farther than this from an end of a base come to it
SAME = 0.005  # two statements of one number may differ by this: rounding of the last figure
TURBULENT, LAMINAR = 2000, 500  # Reynolds numbers: no longer laminar; surely laminar below
BESIDE = (N_("uplift"), N_("force [kN]"), N_("centre from the start [m]"), N_("factor peak, block model"), N_("gravity method"), N_("residual, block model"),
          N_("gravity method"))  # fmt: skip
BALANCED = 1e-8  # of the inflow: imbalance allowed at a node of the network


def water_levels(case, stage, base):
    """Levels of the water at the start and at the end of a base: of reservoirs on its side, of heads whose faces come to it."""
    levels = {"start": None, "end": None}
    for load in case.scene.stage_loads(stage).values():
        if load.get("type") not in (*surface.WATERS, "head"):
            continue
        faces = section_cut.wet_segments(case.mesh, load)
        middle = (faces.reshape(-1, 2).mean(axis=0) - base.middle) @ base.along
        side = side_of(faces, float(load["level"]), base.ends()) or ("start" if middle < 0 else "end")
        if load["type"] in surface.WATERS or shapely.distance(shapely.multilinestrings(faces), shapely.Point(getattr(base, side))) <= AT_END:
            levels[side] = max(float(load["level"]), -np.inf if levels[side] is None else levels[side])
    return levels["start"], levels["end"]


def heel_and_levels(case, stage, base, scene_load=None):
    """Returns (heel, level there, level at the toe) of a base. The heel is the heel of scene_load, the uplift load under it, else the end at which the water stands higher."""
    start, end = water_levels(case, stage, base)
    higher = "end" if end is not None and (start is None or end > start) else "start"
    heel = scene_load.heel if scene_load is not None else higher
    return (heel, start, end) if heel == "start" else (heel, end, start)


def heads_above(base, heel, level, tail):
    """[m] Returns the heads of two levels above the heel and the toe; None: no level."""
    ends = base.meets() if heel == "start" else base.meets()[::-1]
    return tuple(None if y is None else max(0.0, y - end[1]) for y, end in zip((level, tail), ends))


def tail_at_drain(base, heel, tail, drain):
    """[m] Returns the head of the tailwater above a base at its drain, by the distance from the heel; 0 without either."""
    if tail is None or not drain:
        return 0.0
    ends = base.meets() if heel == "start" else base.meets()[::-1]
    return max(0.0, tail - float(ends[0][1] + drain / base.length * (ends[1][1] - ends[0][1])))


def fall_of(base, heel):
    """[m] Returns how much lower the toe of a base is than its heel; 0 where it is higher."""
    start, end = base.meets()
    return max(0.0, float(start[1] - end[1]) * (1 if heel == "start" else -1))


def uplift_under(case, stage, name, base, scene_load=None):
    """Returns the uplift of the options under a base; None: there is none. The scene gives what they leave open. scene_load: its uplift load under this base."""
    o = case.options
    if not o.uplift or (o.uplift_on and name not in o.uplift_on):
        return None
    heel, level, tail = heel_and_levels(case, stage, base, scene_load)
    tail = o.tailwater if o.tailwater is not None else tail
    head, toe = heads_above(base, heel, level, tail)
    if not head:
        return None
    unit, known = water_density(case, stage) * case.scene.gravity, scene_heads(case, stage, name, scene_load)
    keys = in_crack_of(case) | {"unit_weight": unit, "heel": heel}
    toe = known.get("toe", 0.0) if toe is None else toe
    if not has_drain(case, stage):
        return Uplift(o.uplift, uplift.Heads(base.length, head, toe, fall=fall_of(base, heel)), o.direction, **keys)
    own = of_options(o, base, heel)
    drain, efficiency, gallery = (known.get(key) if own[key] is None else own[key] for key in ("drain", "efficiency", "gallery"))
    heads = uplift.Heads(base.length, head, toe, drain, efficiency, gallery if drain else None, o.drain_head, fall_of(base, heel), tail_at_drain(base, heel, tail, drain))
    return Uplift(o.uplift, heads, o.direction, **keys)


def in_crack_of(case):
    """Returns what a rule of uplift does in a crack, as members of Uplift: as the options say, else the guideline that goes with this rule; None: as the rule says."""
    o = case.options
    guideline = of_rule(case, o.uplift) if o.uplift else guidelines.of(o)
    at_rest, entry, _wanting = guidelines.in_crack(guideline, "at_rest", o.given)
    shaken = guidelines.in_crack(guideline, "earthquake", o.given)[0]
    return {"in_crack": "full" if o.in_crack == "full" else at_rest, "drains": (entry or {}).get("drains", "past"), "shaken": o.in_crack or shaken}


def of_rule(case, rule):
    """Returns the guideline of the options where it goes with a rule of uplift, or with any; else None."""
    guideline = guidelines.of(case.options) or {}
    return guideline if guideline.get("uplift") in (None, rule) else None


def opens(case, stage, strength):
    """The criterion by which a crack starts in a judged stage; None: with any tension. strength: keys of the joint."""
    return crack_start.of(guidelines.of(case.options), case.conditions.get(stage), strength)



def with_crack_before(case, stage, base, water, forces, rest, beside):
    """The water with the crack that the same loads open without the earthquake; as it is in a stage without one. forces: (X, Y, M) by load; rest: of all that is
    no load; beside: as in hand_method."""
    shakes = earthquake.loads_of(case, stage)
    if water is None or not shakes:
        return water
    return replace(water, before=crack_at_rest(case, base, sum((force for name, force in forces.items() if name not in shakes), rest), water, beside))


def crack_at_rest(case, base, still, water, beside):
    """[m] The crack from the heel under (X, Y, M) without the earthquake: it starts by the criterion of the usual condition. beside: as in hand_method."""
    usual = base.opens and crack_start.of(guidelines.of(case.options), "usual", base.opens.joint)
    rest = broken.with_water(replace(base, opens=usual), still, water, beside)
    crack = rest.reached if rest.crack is None else rest.crack
    return crack if rest.crack_at == water.heel else 0.0


def shaken_hand(case, base, strength, still, water, beside, more, condition):
    """Returns the Hand under (X, Y, M) more, of an earthquake that is judged as a condition; the crack at rest keeps its uplift. strength: keys of the joint, None: any tension opens
    this base; still: (X, Y, M) without water; beside: as in hand_method."""
    if water is not None and water.before is None:
        water = replace(water, before=crack_at_rest(case, base, still, water, beside))
    criterion = None if strength is None else crack_start.of(guidelines.of(case.options), condition, strength)
    return broken.with_water(replace(base, opens=criterion), still + more, water, beside)


def shock_before(case, stage):
    """Returns the last stage with a pseudo-static earthquake from which a stage without one comes; None: there is none."""
    if stage not in case.scene.stages or earthquake.loads_of(case, stage):
        return None
    return next((name for name in reversed(case.scene.stages_before(stage)) if name in case.results.stages and earthquake.loads_of(case, name)), None)


def after_earthquake(case, base, water, shock, hand):
    """Takes the crack that an earthquake has opened from a base: no cohesion there afterwards, and the full head in it unless the guideline closes it. shock: its stage; hand: the
    gravity method under it, None: there was none. Returns the water and a note; (water, "") where nothing is open."""
    opened = 0.0 if hand is None else base.length if hand.crack is None else hand.crack
    if opened <= SAME:
        return water, ""
    base.bears = np.array([[opened, base.length] if hand.crack_at == "start" else [0.0, base.length - opened]])
    closes = guidelines.in_crack(guidelines.of(case.options), "after_earthquake", case.options.given)[0] == "closed"
    wet = water is not None and water.heel == hand.crack_at and water.follows_crack() and not closes
    note = _("The earthquake of stage {0} has opened {1:.2f} m of the base: it has no cohesion there afterwards, and the full head.", shock, opened) if wet else _(
        "The earthquake of stage {0} has opened {1:.2f} m of the base: it has no cohesion there afterwards.", shock, opened)
    return (replace(water, opened=hand.reached if hand.crack is None else opened) if wet else water), note


def in_earthquake(case, water, hand):
    """Notes about the crack that an earthquake opens."""
    if water is None or water.before is None or not hand.crack or hand.crack_at != water.heel or hand.crack <= water.before + SAME:
        return []
    rule, (asked, entry, _wanting) = uplift.rule_named(water.rule), guidelines.in_crack(of_rule(case, water.rule), "earthquake", case.options.given)
    why = (guidelines.source_of(entry) if asked == (water.shaken or rule.shaken) else _("as asked for") if water.shaken not in (None, rule.shaken) else
           _("as others quote rule {0}, to be checked by the user", water.rule) if rule.status == uplift.CHECK else _("assumed for rule {0}, to be checked by the user", water.rule))  # fmt: skip
    words = {"unchanged": N_("The earthquake opens the base from {0:.2f} to {1:.2f} m from the heel: this part changes no uplift ({2})."),
             "zero": N_("The earthquake opens the base from {0:.2f} to {1:.2f} m from the heel: this part has no uplift ({2})."),
             "full": N_("The earthquake opens the base from {0:.2f} to {1:.2f} m from the heel: this part has the full head ({2}).")}  # fmt: skip
    return [_(words[water.shaken or rule.shaken], water.before, hand.crack, why)]


def of_options(o, base, heel):
    """Returns the water under a base by the options, as the members of Heads."""
    x = o.drain if o.drain else 0.0
    gallery = None if o.gallery is None else max(0.0, o.gallery - base.at(x if heel == "start" else base.length - x)[1])
    return {"drain": o.drain, "efficiency": o.efficiency, "gallery": gallery, "toe": heads_above(base, heel, None, o.tailwater)[1]}


def scene_heads(case, stage, name, scene_load):
    """Returns the water under a base by the scene, as the members of Heads: by its uplift load there, or by a drain in joints with flow."""
    if scene_load is not None:
        return {key: value for key in ("drain", "efficiency", "gallery", "toe") if (value := getattr(scene_load.heads, key)) is not None}
    places = [load["distance"] for load in case.scene.stage_loads(stage).values() if load.get("type") == "drain" and load.get("joint") == name and load.get("distance") is not None and load.get("conductance") != 0]
    return {"drain": float(min(places))} if places else {}


def contradictions(case, stage, name, base, scene_load):
    """Writes notes where the options and the scene contradict each other about the water under a base."""
    known, own = scene_heads(case, stage, name, scene_load), of_options(case.options, base, heel_and_levels(case, stage, base, scene_load)[0])
    words = {"drain": N_("the drain {0:.2f} m from the heel"), "efficiency": N_("an efficiency of {0:.2f}"), "gallery": N_("a head of {0:.2f} m in the gallery"), "toe": N_("a head of {0:.2f} m at the toe")}
    sentences = []
    for key, text in words.items():
        here, there = own[key], known.get(key)
        if here is not None and known and (there is None or abs(here - there) > SAME):
            sentences.append(_("The command line has {0}, the scene does not say it: the numbers of the rule are those of the command line.", _(text, here)) if there is None else
                             _("The command line has {0}, the scene has {1}: the numbers of the rule are those of the command line.", _(text, here), _(text, there)))  # fmt: skip
    return sentences


def has_drain(case, stage):
    """Tells whether the drain of the options works: a stage whose water is computed has it when one of its drains is not clogged."""
    if not facts_of(case.results.stage_summary(stage)):
        return True
    return any(load.get("type") == "drain" and load.get("conductance") != 0 for load in case.scene.stage_loads(stage).values())


def water_density(case, stage):
    loads = case.scene.stage_loads(stage).values()
    return max((float(load["density"]) for load in loads if load.get("type") in surface.WATERS), default=1000.0)


def block_uplift(case, stage, part):
    """Returns (X, Y, M) of uplift on the part above as the run applied it, with the run's cracks; in joints within the part it cancels."""
    pressed, acting = case.results.stage(stage).loads, case.scene.stage_loads(stage)
    if pressed is None:
        return np.zeros(3)
    return sum((section_cut.on_faces(pressed.of(name), part) for name, load in acting.items() if load.get("type") == "uplift"), np.zeros(3))


def dry_joints(facts):
    """Open joints that come out under water and have none by any load, in words."""
    return [_("Joint {0} is open over {1:.2f} m from where it comes out under the water of {2}, and dry: water in it would press with {3:.0f} kN on each side. A load of type uplift on it lets it in.",
              name, dry["length"], dry["water"], 1e-3 * dry["force"]) for name, dry in at_end(facts).get("dry_joints", {}).items()]  # fmt: skip


def dry_stretches(facts):
    """Open stretches of cracked joints that the full head does not reach, in words; runs of older versions have no force. facts: summary of a stage."""
    sentences = dry_joints(facts)
    for name, d in [(name, d) for name, load in at_end(facts).get("uplift", {}).items() for d in load.get("dry", []) if not d["at_toe"]]:
        numbers = name, d["length"], d["from"], d["to"], d["from"] - d["closed_from"], 1e3 * d["closure"]
        sentences.append(_("Uplift {0}: the joint is open over {1:.2f} m, from {2:.2f} to {3:.2f} m from the heel, without the full head: "
                           "{4:.3g} m before it are closed, by {5:.2g} mm at most (reaches: any lets it in).", *numbers) if d.get("force") is None else
                         _("Uplift {0}: the joint is open over {1:.2f} m, from {2:.2f} to {3:.2f} m from the heel, without the full head, which would press with {6:.0f} kN there: "
                           "{4:.3g} m before it are closed, by {5:.2g} mm at most (reaches: any lets it in).", *numbers, 1e-3 * d["force"]))  # fmt: skip
    return sentences


def scene_uplift(case, stage, part, base):
    """Returns the scene's uplift under a base, which may follow its crack, or None; and the force of all other uplift on the part."""
    loads = uplift_loads(case.mesh, case.scene, stage, part)
    under = next((load for load in loads if load.is_under(base)), None)
    return under, sum((load.forces(base, 0.0) for load in loads if load is not under), np.zeros(3))


# ---- water that flows in joints


def pieces_between(flow, part):
    """Returns for each piece of a joint 1 where the part lies to its left and the rest to its right, -1 the other way, else 0."""
    along = flow.point[:, 1] - flow.point[:, 0]
    left = np.column_stack([-along[:, 1], along[:, 0]]) / np.maximum(np.hypot(*along.T), 1e-300)[:, None]
    there = [shapely.contains_xy(part.region, *(flow.point.mean(axis=1) + side * 2 * section_cut.GAP * left).T) for side in (1, -1)]
    return there[0].astype(int) - there[1].astype(int)


def computed(case, stage, part):
    """Returns (X, Y, M) on the part above, of the computed water in the joints between it and the rest."""
    flow = case.results.stage(stage).flow
    if flow is None:
        return np.zeros(3)
    a, b = np.moveaxis(flow.point, 1, 0)
    push = pieces_between(flow, part)[:, None] * np.column_stack([a[:, 1] - b[:, 1], b[:, 0] - a[:, 0]])  # away from the joint, times its length
    total = np.zeros(3)
    for k, at in enumerate(((2 * a + b) / 3, (a + 2 * b) / 3)):  # resultants of the two triangles of a trapezium
        force = 0.5 * flow.pressure[:, [k]] * push
        total += [*force.sum(axis=0), (at[:, 0] * force[:, 1] - at[:, 1] * force[:, 0]).sum()]
    return case.scene.thickness * total


def straight(case, stage, base, dry):
    """The gravity method with the straight line between the computed pressures at the ends of the base."""
    flow = case.results.stage(stage).flow
    points, pressure = flow.point.reshape(-1, 2), flow.pressure.ravel()
    ends = [pressure[np.hypot(*(points - end).T) <= AT_END].max(initial=0.0) / uplift.WATER for end in base.ends()]
    line = Uplift("linear", uplift.Heads(base.length, *sorted(ends, reverse=True)), in_crack="unchanged", heel="start" if ends[0] >= ends[1] else "end")
    return line, hand_method(base, dry, line)


def centre(base, forces):
    """Returns the distance [m] from the start of the base at which a force (X, Y, M) goes through it; None where it does not press on it."""
    N, _, M = base.resultants(forces)
    return 0.5 * base.length - M / N if N else None


def side_by_side(found):
    """Uplift of a base as computed, as a straight line, and by the rule of the options: words, force [kN], its centre from the start [m], sliding
    factor with peak strength of block model and gravity method, with residual strength of both. None where there is no such number."""
    def row(words, forces, hand, block):
        own = factors(hand, found.strength) if hand.crack is not None else {}
        pairs = [source.get(key) for key in ("peak", "residual") for source in (block, own)]
        return (words, 1e-3 * float(np.hypot(*forces[:2])), centre(found.base, forces),
                *(np.inf if factor is not None and factor > NO_SHEAR else factor for factor in pairs))  # fmt: skip

    def under(water, hand):
        return water.forces(found.base, hand.crack if hand.crack and hand.crack_at == water.heel else 0.0)

    rows = [row(_("computed"), found.computed, found.hand, found.block or {})]
    if found.straight:
        rows.append(row(_("straight line between the heads of its ends"), under(*found.straight), found.straight[1], {}))
    if found.with_uplift:
        rows.append(row(_("rule {0}", found.water.rule), under(found.water, found.with_uplift), found.with_uplift, {}))
    return rows


def complaints(case, stage):
    """Lists why the water of a stage is no basis for a judgement."""
    facts, sentences = facts_of(case.results.stage_summary(stage)), []
    if not facts:
        return sentences
    if (facts["reynolds"] or 0.0) >= TURBULENT:
        sentences.append(_("Flow in joints is not laminar: Reynolds number {0:.0f}, from {1} on the cubic law does not hold.", facts["reynolds"], TURBULENT))
    error, inflow = (np.inf if facts[key] is None else facts[key] for key in ("error", "inflow"))
    if error > BALANCED and inflow > STILL:
        sentences.append(_("Water in joints does not balance: a node is out by {0:.1e} of the inflow.", error))
    twice = [(name, length) for name, length in uplift_on_water(case, stage) if length > 0]
    sentences += [_("Water counts twice: load {0} presses on {1:.2f} m of joints in which computed water presses too.", name, length) for name, length in twice]
    return sentences


def uplift_on_water(case, stage):
    """Returns the uplift loads of the stage, with the length [m] of the joints under each in which water flows."""
    flow = case.results.stage(stage).flow
    middles = shapely.points(flow.point.mean(axis=1))
    for name, load in case.scene.stage_loads(stage).items():
        if load.get("type") == "uplift":
            faces = case.mesh.vertices[face_ends(case.mesh, case.mesh.face_sets[load["faces"]])]
            yield name, flow.length[shapely.distance(middles, shapely.multilinestrings(faces)) <= section_cut.GAP].sum()


def remarks(results, stage):
    """Lists what a reader of the numbers of the water must know."""
    facts, flow, sentences = facts_of(results.stage_summary(stage)), results.stage(stage).flow, []
    if facts["state"] == "frozen":
        sentences.append(_("The pressures are those of the stage before: water stands still while the structure moves."))
    if LAMINAR <= (facts["reynolds"] or 0.0) < TURBULENT:
        sentences.append(_("Reynolds number {0:.0f}: from {1} on flow in rough joints may be no longer laminar, and the cubic law gives too much of it.", facts["reynolds"], LAMINAR))
    if facts["cut_off_length"] > 0:
        sentences.append(_("Joints of {0:.2f} m are cut off from every head, inflow and drain under water: they are dry.", facts["cut_off_length"]))
    if coarse := len(flow.too_coarse()):
        sentences.append(ngettext("Apertures differ by more than {1:g} times between the ends of {0} piece of joints in which more than {2:.0f} % of the largest head is lost, the first at "
                                  "({3:.2f}, {4:.2f}) m: the straight line of pressure that presses there can be half its force out. More contacts there make it right.",
                                  "Apertures differ by more than {1:g} times between the ends of {0} pieces of joints in which more than {2:.0f} % of the largest head is lost, the first at "
                                  "({3:.2f}, {4:.2f}) m: the straight line of pressure that presses there can be half its force out. More contacts there make it right.",
                                  coarse, WEDGE, 100 * CARRIES, *flow.point[flow.too_coarse()[0]].mean(axis=0)))  # fmt: skip
    return sentences
