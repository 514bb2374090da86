"""Writes the annex of the sheet: every table in full, behind the four pages of its main part."""

from quoin_tools.assess import base_water, combinations, crack_notes, guidelines, lifts, partial_factors, uplift
from quoin_tools.assess.assessment import beside, cell, lines
from quoin_tools.base import sheet_units
from quoin_tools.base.flow import condition_rows, joint_rows, state_rows
from quoin_tools.base.language import N_, _, numeral
from quoin_tools.base.modes import mode_rows
from quoin_tools.base.results import (
    body_rows,
    effort_rows,
    factor_rows,
    fixed,
    mechanism_rows,
    no_single_factor,
    place,
    trials_of,
)
from quoin_tools.base.solver_sentences import solver_says
from quoin_tools.show.hypertext import esc, head, notes, small, soft, table, verdict_class
from quoin_tools.show.materials_part import cell_of, history_part, materials_table


def without_result(case):
    """Stages of the scene that the run has not come to the end of."""
    done = {s["name"] for s in case.results.summary["stages"]}
    return [name for name in case.scene.stages if name not in done]


def limits_part(case, found, swept):
    """Lists every limit with the number held against it. swept: lifts of the judged stages."""
    by_plane = any((guidelines.of(case.options) or {}).get("planes", {}).values())
    judged = [(a.stage, f"{a.name} ({_(a.plane)})" if by_plane else a.name, a.limits) for a in found] + [(stage, _("lifts"), lifts.judged(case, stage, answer[0])) for stage, answer in swept.items()]
    judged += [(stage, _("the run"), partial_factors.judged(case, stage)) for stage in swept]
    rows = [(stage, _(case.conditions[stage]), name, j.words, j.bound, j.printed(j.value), (_(j.verdict), verdict_class(j.verdict)),
             j.source) for stage, name, limits in judged for j in limits]  # fmt: skip
    if not rows:
        return ""
    note = guidelines.of(case.options)["note"]
    return (head(_("Limits")) + table((_("stage"), _("condition"), _("base"), _("limit of"), _("limit"), _("number"), _("verdict"), _("source")), rows, (4, 5))
            + small(*design_words(case), _("The number is the less favourable of the block model and of the gravity method, the latter with uplift where a rule was given; the block model has the loads of the scene. "
                      "Stress limits are held against the gravity method's straight line."), _(note) if note else ""))  # fmt: skip


def design_words(case):
    """Says in a list which judged cases with partial factors no stage of the run tries with design strengths; empty where there is none."""
    limits = guidelines.of(case.options)["conditions"]
    names = [stage for stage, condition in case.conditions.items() if "sliding_partial" in limits.get(condition, {}) and not partial_factors.of_case(case, stage)]
    return [_("The block model does not try design strengths in {0}: a stage from it with friction_factor and cohesion_factor does.", ", ".join(names))] if names else []


def combinations_part(case):
    """Lists the combinations of the guideline: the cases of each, the loads a case lacks, and combinations without a case."""
    rows, missing = combinations.of_cases(case)
    if rows is None:
        return small(_("Load combinations of this guideline are not filled in.")) if case.options.guideline else ""
    shown = [(stage, _(condition), combinations.either(one["name"] for one in mine) if mine else (_("none"), "fail"), ", ".join(map(_, lacks)) or "-",
              "; ".join(_(one["loads"]) for one in mine) or "-", sources(mine)) for stage, condition, mine, lacks in rows]  # fmt: skip
    part = head(_("Load combinations")) + table((_("case"), _("judged as"), _("combination"), _("it asks for, the case has not"), _("its loads"), _("source")), shown)
    if missing:
        part += head(_("Without a case"), 3) + table((_("combination"), _("judged as"), _("its loads"), _("source")), [(_(one["name"]), combinations.either(one["conditions"]), _(one["loads"]), sources([one])) for one in missing])
    return part + small(_("By the kinds of loads of a case and by what it is judged as (--condition); how high the water stands is not looked at."))


def sources(combinations_named):
    return "; ".join(dict.fromkeys(guidelines.source_of(one) for one in combinations_named)) or "-"


def displacements_part(case):
    probes, stresses = [], []
    for s in case.results.summary["stages"]:
        probes += [(s["name"], name, place(p), fixed(p["u_x"], 1e3, 3), fixed(p["u_y"], 1e3, 3))
                   for name, p in s["probes"].items()]  # fmt: skip
        for group, ends in s["stress_by_group"].items():
            pair = [ends["s1_max"], ends["s2_min"]]
            if None not in pair:
                stresses.append((s["name"], group, *(x for end in pair for x in (fixed(end["value"], 1e-6, 3), place(end)))))
    if not probes and not stresses:  # rigid blocks without named points
        return ""
    part = head(_("Displacements and stresses of the block model"))
    if probes:
        part += table((_("stage"), _("point"), _("at [m]"), "u_x [mm]", "u_y [mm]"), probes, (3, 4))
    if stresses:
        part += table((_("stage"), _("group"), _("largest s1 [MPa]"), _("at [m]"), _("least s2 [MPa]"), _("at [m]")), stresses, (2, 4))
    return part + small(_("Principal stresses at block centres, tension positive."))


def stages_part(case):
    rows = []
    for s in case.results.summary["stages"]:
        loads = ", ".join(case.scene.stages.get(s["name"], {}).get("loads") or ())
        rows.append((_("{0} (from {1})", s["name"], s["from"]) if "from" in s else s["name"], loads, (_(s["verdict"]), "pass" if s["verdict"] in ("converged", "completed") else "fail"), fixed(s["applied"]["x"], 1e-3, 1),
                     fixed(s["applied"]["y"], 1e-3, 1), fixed(s["reaction"]["x"], 1e-3, 1), fixed(s["reaction"]["y"], 1e-3, 1)))  # fmt: skip
    rows += [(name, ", ".join(case.scene.stages[name].get("loads") or ()), (_("no result"), "fail"), "-", "-", "-", "-") for name in without_result(case)]
    header = (_("stage"), _("loads at its end"), _("verdict"), _("applied x [kN]"), _("applied y [kN]"), _("supports x [kN]"), _("supports y [kN]"))
    part = head(_("Stages")) + table(header, rows, (3, 4, 5, 6))
    for s in case.results.summary["stages"]:
        if s["verdict"] == "collapsed":
            part += (head(_("Stage {0} has collapsed: its mechanism", s["name"]), 3) + table((_("joint"), _("it"), _("sliding [-]"), _("opening [-]")), mechanism_rows(s), (2, 3))
                     + small(_("Speeds are parts of that of the fastest vertex. A state that moves has no factors.")))  # fmt: skip
    return part


def changed_by(found):
    """Describes in words what the trials of a stage changed."""
    if "raises" in found:
        return _("factor on {0} [-]", ", ".join(found["raises"]))
    if "forces" in found:
        return _("pull of {0} over prestress [-], strengths divided by {1:g}", ", ".join(found["forces"]), found["required"])
    if "what" not in found:
        return sheet_units.column(_("water level [m]"))[0]
    return _("angle of friction [°]") if found["what"] == "friction" else _("part of all strengths left [-]")


MATTERS = 1.1  # peak strength over the force in a joint at its last stable trial: larger ratios are reported


def breaks_in_parts(s):
    """Joints that slide in the mechanism of trials though their peak strength on all that is closed would be enough, and how many times
    what they carry it is: brittle cohesion is lost where it is passed first (docs/deviations.md, l)."""
    slides = [(name, s["joints"].get(name, {})) for name, m in (s.get("mechanism") or {}).items() if trials_of(s) and m["slides"]]
    return [(name, j["sliding_factor_peak"]) for name, j in slides
            if (j.get("sliding_factor_peak") or 0.0) > MATTERS and j["sliding_factor_residual"] < j["sliding_factor_peak"]]  # fmt: skip


def value_of(found, value, digits):
    """Returns what the trials of a stage changed as a number in the unit shown."""
    text = cell(value, digits)
    return sheet_units.number(text, "m") if not {"raises", "forces", "what"} & found.keys() else text


def trials_part(case):
    """Strength reductions, floods and load factors: bracket, factors, every trial with its evidence."""
    part = ""
    for s in case.results.summary["stages"]:
        found = trials_of(s)
        if not found:
            continue
        ends = [value_of(found, found[end], 4) for end in ("stable", "failing", "width")]
        factors = [cell(found.get(f"safety_factor_{end}"), 3) for end in ("stable", "failing")]
        part += head(_("Stage {0}: {1}", s["name"], changed_by(found)), 3) + table(
            (_("last stable"), _("first failing"), _("width of the bracket"), _("factor, last stable"), _("factor, first failing")), [(*ends, *factors)], range(5))  # fmt: skip
        shaken = [(name, k, cell(ends[f"{k}_stable"], 4), cell(ends[f"{k}_failing"], 4)) for name, ends in found.get("raises", {}).items()
                  for k in ("k_h", "k_v") if ends.get(f"{k}_stable")]  # fmt: skip
        if shaken:
            part += table((_("pseudo-static load"), _("yield coefficient"), _("last stable"), _("first failing")), shaken, (2, 3))
        needed = [(name, *(cell_of(f[key], 1e-3, 2) for key in ("failing", "stable", "failing_per_metre", "stable_per_metre"))) for name, f in found.get("forces", {}).items()]
        if needed:
            part += table((_("anchor"), _("fails with [kN]"), _("stands with [kN]"), _("fails with [kN/m]"), _("stands with [kN/m]")), needed, (1, 2, 3, 4))
        if no_single_factor(found):
            part += notes([_("The joints that slid had different angles of friction: the stage has no single factor. Use what: strengths.")])
        if parts := breaks_in_parts(s):
            part += notes([_("{0} slides though its peak strength on all that is closed is {1:.2f} times what it carries at the last stable trial: "
                             "cohesion is lost where it is passed first, and what is left cannot take over. Gravity method and sliding factors count it whole, "
                             "as a run does with cohesion_residual as large as cohesion.", name, peak) for name, peak in parts])  # fmt: skip
        if rows := factor_rows(s):
            part += table((_("joint"), "φ [°]", _("factor, last stable"), _("factor, first failing"), _("in the mechanism")), rows, (1, 2, 3))
        rows = [(value_of(found, t["value"], 4), (_(t["outcome"]), "pass" if t["outcome"] == "stable" else "fail" if t["outcome"] == "fails" else "open"),
                 t["cycles"], fixed(t.get("moved", t["max_displacement"]), 1e3, 2), fixed(sum(j["open_length"] for j in t["joints"].values()), 1, 2),
                 solver_says(t["evidence"])) for t in found["trials"]]  # fmt: skip
        part += table((_("value"), _("outcome"), _("cycles"), _("moved since the stage began [mm]"), _("open joints [m]"), _("evidence")), rows, (0, 2, 3, 4))
    note = _("A trial is stable when it finds equilibrium, and fails when a mechanism moves on (evidence); trials start from the last "
             "stable state. The factor of a joint is tan φ over the tangent of its angle in the trial, that of the stage is the one of the joints that slide "
             "in the mechanism; or one over the part of the strengths left.")  # fmt: skip
    return head(_("Trials to failure")) + part + small(note) if part else ""


def modes_part(case):
    """Free vibrations, where a stage has looked for them."""
    stages = [s for s in case.results.summary["stages"] if mode_rows(s)]
    rows = [(s["name"], *row) for s in stages for row in mode_rows(s)]
    if not rows:
        return ""
    lost = [_("Stage {0}: slower modes than the last one may be missing.", s["name"]) for s in stages if s["modes"]["missed"]]
    return (head(_("Free vibrations")) + notes(lost)
            + table((_("stage"), _("mode"), "f [Hz]", _("period [s]"), _("mass x [%]"), _("mass y [%]"), _("participation x"), _("participation y")), rows, range(1, 8))
            + small(_("Small vibrations about the state at the end of the stage before: open joints stay open, closed ones stick. Modal masses are parts "
                      "of all mass that can move, water of the stage's loads included; participation is for shapes whose largest displacement is 1.")))  # fmt: skip


def local_part(case):
    """Least local failure factors, where materials have strengths."""
    rows = [(s["name"], group, fixed(least["value"], 1, 2), _(least["mode"]), place(least))
            for s in case.results.summary["stages"] for group, least in (s.get("safety") or {}).items() if least["value"] is not None]  # fmt: skip
    if not rows:
        return ""
    return (head(_("Local failure of the material")) + table((_("stage"), _("group"), _("least factor"), _("governed by"), _("at [m]")), rows, (2,))
            + small(_("Factors (39)-(41) at block centres: tension, compression, shear by Mohr-Coulomb. At a singular corner, such as the "
                      "toe, the least factor falls with every refinement of the mesh.")))  # fmt: skip


ELEMENTS = (N_("full"), N_("bending"), N_("reduced"))  # of blocks, as the scene has them


def blocks_of(case, name):
    """Describes the blocks of a group; a scene may leave it to the mesh whether they are rigid."""
    material, mesh = case.scene.materials[name], case.results.mesh
    if name in mesh.group_names and mesh.group_rigid[mesh.group_names.index(name)]:
        return _("rigid")
    usual = "full" if material.get("law", "elastic") == "elastic" else "bending"
    return _("condensed") if name in case.results.summary.get("condensed_groups", []) or material.get("condensed") is True else _(str(material.get("element", usual)))


def words(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    return " ".join(map(words, value)) if isinstance(value, list) else f"{value:g}" if isinstance(value, float) else str(value)


def joint_rows_of(case, stage):
    """Joints as they are in a stage, and the columns that say something of them."""
    joints = []
    for name in case.results.stage_summary(stage)["joints"]:
        j = case.scene.joint(name, stage)
        peak = [j[key] if j["law"] != "elastic" else None for key in ("cohesion", "cohesion_residual", "tension", "tension_residual")]
        joints.append((name, (j["law"], "keys"), (j["stress_model"], "keys"), cell_of(j.get("k_n"), 1e-9, 2), cell_of(j.get("k_s"), 1e-9, 2),
                       cell_of(j.get("friction"), 1, 1), cell_of(j.get("friction_residual"), 1, 1), *(cell_of(value, 1e-3, 1) for value in peak), *(cell_of(j.get(key) or None, 1, 2) for key in ("fracture_energy", "fracture_energy_shear")), *(cell_of(j.get(key), 1e3, 3) for key in ("aperture", "aperture_residual"))))  # fmt: skip
    shown = [i for i in range(15) if i < 11 or any(row[i] != "-" for row in joints)]  # energies where joints soften, apertures where water may flow
    columns = (_("joint"), _("law"), _("stress model"), "k_n [GPa/m]", "k_s [GPa/m]", "φ [°]", _("φ residual [°]"), "c [kPa]", _("c residual [kPa]"), "f_t [kPa]", _("f_t residual [kPa]"), "G_I [N/m]", "G_II [N/m]", _("aperture [mm]"), _("residual [mm]"))
    return [[row[i] for i in shown] for row in joints], [columns[i] for i in shown]


def load_rows(case):
    return [(name, (load.get("type", ""), "keys"), (", ".join(f"{key} {words(value)}" for key, value in load.items() if key != "type" and (key, value) != ("partial_factor", 1)), "keys"))
            for name, load in case.scene.loads.items()]  # fmt: skip


def inputs_part(case, stage, most):
    """Lists the materials, joints and loads that the main part, about a stage and with tables of `most` rows, leaves out."""
    joints, columns = joint_rows_of(case, stage)
    loads, part = load_rows(case), history_part(case)
    if len(case.scene.materials) > most:
        part += materials_table(case, blocks_of)
    if len(joints) > most:
        part += head(_("Joints in stage {0}", stage), 3) + table(columns, joints, range(3, len(columns)))
    if len(loads) > most:
        part += head(_("Loads"), 3) + table((_("load"), _("type"), _("keys (SI)")), loads)
    return head(_("Materials, joints and loads")) + part if part else ""


def measured(value, unit):
    text = numeral(f"{value:g}")
    return sheet_units.said(text, unit) if unit else text


def as_told(value, unit, found, key):
    """Writes a number of the options; else the scene's number under each judged base."""
    if value is not None:
        return measured(value, unit)
    bases = {}
    for a in found:
        if a.with_uplift and a.condition and getattr(a.water.heads, key) is not None:
            bases.setdefault(getattr(a.water.heads, key), []).append(a.name)
    return "; ".join(_("{0} under {1}, as in the scene", measured(number, unit), ", ".join(dict.fromkeys(names))) for number, names in bases.items()) or "-"


def uplift_part(case, found):
    o = case.options
    if not o.uplift:
        text = _("No uplift was asked for besides the scene's: both methods have the same loads.")
        return f"<p>{esc(text)}</p>"
    rule, cracked = uplift.rule_named(o.uplift), base_water.in_crack_of(case)
    facts = [(_("rule"), f"{rule.name}: {_(rule.source)} ({_(rule.status)})"), (_("in the crack at rest"), _(cracked["in_crack"] or rule.crack)),
             (_("in a crack that an earthquake opens"), _(cracked["shaken"] or rule.shaken)), (_("drains in a cracked base"), _(crack_notes.DRAINS[cracked["drains"]])),
             (_("pressure"), _("normal to the base") if o.direction == "normal" else _("vertical part only")),
             (_("drain from the heel"), as_told(o.drain, "m", found, "drain")), (_("efficiency"), as_told(o.efficiency, "", found, "efficiency")),
             (_("measured head at the drain"), "-" if o.drain_head is None else measured(o.drain_head, "m")),
             (_("tailwater"), _("as loads") if o.tailwater is None else measured(o.tailwater, "m")),
             (_("head in the gallery") if o.gallery is None else _("gallery"), as_told(o.gallery, "m", found, "gallery"))]  # fmt: skip
    return head(_("Uplift in the gravity method"), 3) + table(("", ""), facts)


BASES = {"joint": N_("Stage {0}, joint {1}"), "joints": N_("Stage {0}, joints {1}"), "path": N_("Stage {0}, path {1}"), "way": N_("Stage {0}, way {1}")}


def assessment_part(found, caveats):
    rows = [(r.quantity, *sheet_units.in_unit(r.unit, cell(r.block, r.digits), cell(r.hand, r.digits), cell(r.difference, r.digits, "+"), cell(r.with_uplift, r.digits)))
            for r in lines(found)]  # fmt: skip
    base = _(BASES[found.kind], found.stage, found.name)
    text = _("From ({0:.2f}, {1:.2f}) m (start) to ({2:.2f}, {3:.2f}) m (end), {4:.3f} m.", *(x for end in found.base.ends() for x in end), found.base.length)
    header = (_("quantity"), _("unit"), _("block model"), _("gravity method"), _("difference"), _("with uplift of the options"))
    shown = 6 if found.with_uplift else 5
    part = head(base if found.condition else _("{0} (stage not judged)", base), 3) + soft(text)
    part += table(header[:shown], [row[:shown] for row in rows], (2, 3, 4, 5))
    return f"<section>{part}{caveats.marks(found.notes)}</section>"


def assessments_part(case, found, caveats):
    part = head(_("Block model and gravity method")) + uplift_part(case, found)
    part += small(_("N compression positive; T positive towards the end; M about the middle of the base, positive when it pulls at the "
                    "end; stress positive in tension. The block model's largest compression is at one contact end, often a singular corner that grows "
                    "with the mesh; the gravity method's is that of a straight line."))  # fmt: skip
    ordered = sorted(found, key=lambda a: a.condition is None)  # stable: judged stages first
    return part + "".join(assessment_part(a, caveats) for a in ordered)


FLOWS = {"steady": N_("Stage {0}: steady flow"), "transient": N_("Stage {0}: transient flow"), "frozen": N_("Stage {0}: frozen flow")}
OTHER_FLOW = N_("Stage {0}: flow")  # a word that no run writes


def water_part(case, found):
    """Describes water that flows in joints, stage by stage: uplift beside the prescribed one, flow through heads and drains."""
    part = ""
    for s in case.results.summary["stages"]:
        if not state_rows(s):
            continue
        flow = state_rows(s)[0]
        part += "<section>" + head(_(FLOWS.get(flow[0], OTHER_FLOW), s["name"]), 3)
        rows = [(a.name, *row) for a in found if a.stage == s["name"] and a.computed is not None for row in beside(a)]
        part += table((_("base"), *map(_, base_water.BESIDE)), rows, range(2, 8)) if rows else ""
        part += table((_("head or drain"), _("leaves the joints there [m²/s]"), _("in litres per minute and metre")), condition_rows(s), (1, 2))
        part += table((_("joint"), _("length [m]"), _("force of its water [kN]"), _("centre x [m]"), _("centre y [m]"), _("widest [mm]"), _("part at residual aperture"),
                       _("part at largest aperture"), _("Reynolds number")), joint_rows(s), range(1, 9))  # fmt: skip
        part += table((_("rounds of flow and openings"), _("last change of pressure, of the largest"), _("inflow [m²/s]"), _("water balance, of the inflow"),
                       _("cut off from every head [m]")), [flow[1:]], range(5))  # fmt: skip
        part += notes(base_water.remarks(case.results, s["name"])) + "</section>"
    note = _("Computed: as the run has found it, in block model and gravity method; the straight line lies between the computed pressures at the "
             "ends of the base; the rule is that of the options, with its drain in stages with one that is not clogged. Discharge: negative enters the "
             "joints. Force of water in a joint that is no line: the sum of the sizes on its pieces.")  # fmt: skip
    return head(_("Water in joints")) + part + small(note) if part else ""


def effort_part(case, most):
    """How stages were solved, bodies that left their place; the evidence of all stages where the main part has only `most` of them."""
    rows = [(s["name"], _(s["verdict"]), solver_says(s["evidence"]), s["cycles"], "-" if s["ratio"] is None else numeral(f"{s['ratio']:.2e}"), s["checksum"])
            for s in case.results.summary["stages"]]  # fmt: skip
    part = table((_("stage"), _("verdict"), _("evidence"), _("cycles"), _("unbalanced ratio"), _("checksum")), rows, (3, 4)) if len(rows) > most else ""
    effort = [(s["name"], _(method), _(contacts), *counts, solver_says(s["method_choice"]) if "method_choice" in s else "-") for s in case.results.summary["stages"] for method, contacts, *counts in effort_rows(s)]
    left = [(s["name"], *row) for s in case.results.summary["stages"] for row in body_rows(s)]
    if left:
        part += head(_("Bodies that left their place"), 3) + table(
            (_("stage"), _("macroblock"), _("group"), _("at [m]"), _("overturned [s]"), _("fallen [s]"), _("slid [s]"), _("moved x [m]"), _("moved y [m]"), _("turned [degree]")),
            left, tuple(range(4, 10)))  # fmt: skip
    if effort:
        part += table((_("stage"), _("method"), _("contacts"), _("force evaluations"), _("solves"), _("factorisations"), _("why this method")), effort, (3, 4, 5))
    return head(_("How it was solved")) + part if part else ""
