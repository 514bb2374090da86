"""Writes the annex of the sheet: every table in full, behind the four pages of its main part."""

from quoin_tools.assess import base_water, combinations, guidelines, uplift
from quoin_tools.assess.assessment import beside, cell, lines
from quoin_tools.base.flow import condition_rows, joint_rows, state_rows
from quoin_tools.base.modes import mode_rows
from quoin_tools.base.results import (
    body_rows,
    effort_rows,
    factor_rows,
    fixed,
    mechanism_rows,
    no_single_factor,
    trials_of,
)
from quoin_tools.show.hypertext import esc, notes, table, verdict_class
from quoin_tools.show.materials_part import cell_of, history_part, materials_table


def without_result(case):
    """Stages of the scene that the run has not come to the end of."""
    done = {s["name"] for s in case.results.summary["stages"]}
    return [name for name in case.scene.stages if name not in done]


def limits_part(case, found):
    """Lists every limit with the number held against it."""
    rows = [(a.stage, (a.condition, "word"), a.name, j.text, j.bound, j.printed(j.value), (j.verdict, verdict_class(j.verdict)),
             j.source + ("; check" if j.check else "")) for a in found for j in a.limits]  # fmt: skip
    if not rows:
        return ""
    note = guidelines.read()[case.options.guideline]["note"]
    return ("<h2>Limits</h2>" + table(("stage", "condition", "base", "limit of", "limit", "number", "verdict", "source"), rows, (4, 5))
            + "<p><small>The number is the less favourable of the block model and of the gravity method, the latter with uplift where a "
              "rule was given; the block model has the loads of the scene. Stress "
              f"limits are held against the gravity method's straight line. {esc(note)}</small></p>")  # fmt: skip


def combinations_part(case):
    """Lists the combinations of the guideline: the cases of each, the loads a case lacks, and combinations without a case."""
    rows, missing = combinations.of_cases(case)
    if rows is None:
        return "<p><small>Load combinations of this guideline are not filled in.</small></p>" if case.options.guideline else ""
    shown = [(stage, (condition, "word"), " or ".join(one["name"] for one in mine) or ("none", "fail"), ", ".join(lacks) or "-", "; ".join(one["loads"] for one in mine) or "-", sources(mine))
             for stage, condition, mine, lacks in rows]  # fmt: skip
    part = "<h2>Load combinations</h2>" + table(("case", "judged as", "combination", "it asks for, the case has not", "its loads", "source"), shown)
    if missing:
        part += "<h3>Without a case</h3>" + table(("combination", "judged as", "its loads", "source"), [(one["name"], " or ".join(one["conditions"]), one["loads"], sources([one])) for one in missing])
    return part + "<p><small>By the kinds of loads of a case and by what it is judged as (--condition); how high the water stands is not looked at.</small></p>"


def sources(combinations_named):
    return "; ".join(dict.fromkeys(one["source"] + ("; check" if one.get("check") else "") for one in combinations_named)) or "-"


def displacements_part(case):
    probes, stresses = [], []
    for s in case.results.summary["stages"]:
        probes += [(s["name"], name, f"({p['x']:.2f}, {p['y']:.2f})", fixed(p["u_x"], 1e3, 3), fixed(p["u_y"], 1e3, 3))
                   for name, p in s["probes"].items()]  # fmt: skip
        for group, ends in s["stress_by_group"].items():
            pair = [ends["s1_max"], ends["s2_min"]]
            if None not in pair:
                stresses.append((s["name"], group, *(x for end in pair for x in (fixed(end["value"], 1e-6, 3), f"({end['x']:.2f}, {end['y']:.2f})"))))
    if not probes and not stresses:  # rigid blocks without named points
        return ""
    part = "<h2>Displacements and stresses of the block model</h2>"
    if probes:
        part += table(("stage", "point", "at [m]", "u_x [mm]", "u_y [mm]"), probes, (3, 4))
    if stresses:
        part += table(("stage", "group", "largest s1 [MPa]", "at [m]", "least s2 [MPa]", "at [m]"), stresses, (2, 4))
    return part + "<p><small>Principal stresses at block centres, tension positive.</small></p>"


def stages_part(case):
    rows = []
    for s in case.results.summary["stages"]:
        loads = ", ".join(case.scene.stages.get(s["name"], {}).get("loads") or ())
        rows.append((s["name"] + (f" (from {s['from']})" if "from" in s else ""), loads, (s["verdict"], "pass" if s["verdict"] in ("converged", "completed") else "fail"), fixed(s["applied"]["x"], 1e-3, 1),
                     fixed(s["applied"]["y"], 1e-3, 1), fixed(s["reaction"]["x"], 1e-3, 1), fixed(s["reaction"]["y"], 1e-3, 1)))  # fmt: skip
    rows += [(name, ", ".join(case.scene.stages[name].get("loads") or ()), ("no result", "fail"), "-", "-", "-", "-") for name in without_result(case)]
    header = ("stage", "loads at its end", "verdict", "applied x [kN]", "applied y [kN]", "supports x [kN]", "supports y [kN]")
    part = "<h2>Stages</h2>" + table(header, rows, (3, 4, 5, 6))
    for s in case.results.summary["stages"]:
        if s["verdict"] == "collapsed":
            part += f"<h3>Stage {esc(s['name'])} has collapsed: its mechanism</h3>" + table(
                ("joint", "it", "sliding [-]", "opening [-]"), mechanism_rows(s), (2, 3)) + (
                "<p><small>Speeds are parts of that of the fastest vertex. A state that moves has no factors.</small></p>")  # fmt: skip
    return part


def changed_by(found):
    """Describes in words what the trials of a stage changed."""
    if "raises" in found:
        return f"factor on {', '.join(found['raises'])} [-]"
    if "forces" in found:
        return f"pull of {', '.join(found['forces'])} over prestress [-], strengths divided by {found['required']:g}"
    if "what" not in found:
        return "water level [m]"
    return "angle of friction [°]" if found["what"] == "friction" else "part of all strengths left [-]"


MATTERS = 1.1  # peak strength over the force in a joint at its last stable trial: larger ratios are reported


def breaks_in_parts(s):
    """Joints that slide in the mechanism of trials though their peak strength on all that is closed would be enough, and how many times
    what they carry it is: brittle cohesion is lost where it is passed first (docs/theory.md, l)."""
    slides = [(name, s["joints"].get(name, {})) for name, m in (s.get("mechanism") or {}).items() if trials_of(s) and m["slides"]]
    return [(name, j["sliding_factor_peak"]) for name, j in slides
            if (j.get("sliding_factor_peak") or 0.0) > MATTERS and j["sliding_factor_residual"] < j["sliding_factor_peak"]]  # fmt: skip


def trials_part(case):
    """Strength reductions, floods and load factors: bracket, factors, every trial with its evidence."""
    part = ""
    for s in case.results.summary["stages"]:
        found = trials_of(s)
        if not found:
            continue
        ends = [cell(found[end], 4) for end in ("stable", "failing", "width")]
        factors = [cell(found.get(f"safety_factor_{end}"), 3) for end in ("stable", "failing")]
        part += f"<h3>Stage {esc(s['name'])}: {esc(changed_by(found))}</h3>" + table(
            ("last stable", "first failing", "width of the bracket", "factor, last stable", "factor, first failing"), [(*ends, *factors)], range(5))  # fmt: skip
        shaken = [(name, k, cell(ends[f"{k}_stable"], 4), cell(ends[f"{k}_failing"], 4)) for name, ends in found.get("raises", {}).items()
                  for k in ("k_h", "k_v") if ends.get(f"{k}_stable")]  # fmt: skip
        if shaken:
            part += table(("pseudo-static load", "yield coefficient", "last stable", "first failing"), shaken, (2, 3))
        needed = [(name, *(cell_of(f[key], 1e-3, 2) for key in ("failing", "stable", "failing_per_metre", "stable_per_metre"))) for name, f in found.get("forces", {}).items()]
        if needed:
            part += table(("anchor", "fails with [kN]", "stands with [kN]", "fails with [kN/m]", "stands with [kN/m]"), needed, (1, 2, 3, 4))
        if no_single_factor(found):
            part += notes(["The joints that slid had different angles of friction: the stage has no single factor. Use what: strengths."])
        if parts := breaks_in_parts(s):
            part += notes([f"{name} slides though its peak strength on all that is closed is {cell(peak, 2)} times what it carries at the last stable trial: "
                           "cohesion is lost where it is passed first, and what is left cannot take over. Gravity method and sliding factors count it whole, "
                           "as a run does with cohesion_residual as large as cohesion." for name, peak in parts])  # fmt: skip
        if rows := factor_rows(s):
            part += table(("joint", "φ [°]", "factor, last stable", "factor, first failing", "in the mechanism"), rows, (1, 2, 3))
        rows = [(cell(t["value"], 4), (t["outcome"], "pass" if t["outcome"] == "stable" else "fail" if t["outcome"] == "fails" else "open"),
                 t["cycles"], fixed(t.get("moved", t["max_displacement"]), 1e3, 2), fixed(sum(j["open_length"] for j in t["joints"].values()), 1, 2),
                 t["evidence"]) for t in found["trials"]]  # fmt: skip
        part += table(("value", "outcome", "cycles", "moved since the stage began [mm]", "open joints [m]", "evidence"), rows, (0, 2, 3, 4))
    note = ("<p><small>A trial is stable when it finds equilibrium, and fails when a mechanism moves on (evidence); trials start from the last "
            "stable state. The factor of a joint is tan φ over the tangent of its angle in the trial, that of the stage is the one of the joints that slide "
            "in the mechanism; or one over the part of the strengths left.</small></p>")  # fmt: skip
    return f"<h2>Trials to failure</h2>{part}{note}" if part else ""


def modes_part(case):
    """Free vibrations, where a stage has looked for them."""
    stages = [s for s in case.results.summary["stages"] if mode_rows(s)]
    rows = [(s["name"], *row) for s in stages for row in mode_rows(s)]
    if not rows:
        return ""
    lost = [f"Stage {s['name']}: slower modes than the last one may be missing." for s in stages if s["modes"]["missed"]]
    return ("<h2>Free vibrations</h2>" + notes(lost)
            + table(("stage", "mode", "f [Hz]", "period [s]", "mass x [%]", "mass y [%]", "participation x", "participation y"), rows, range(1, 8))
            + "<p><small>Small vibrations about the state at the end of the stage before: open joints stay open, closed ones stick. Modal masses are parts "
              "of all mass that can move, water of the stage's loads included; participation is for shapes whose largest displacement is 1.</small></p>")  # fmt: skip


def local_part(case):
    """Least local failure factors, where materials have strengths."""
    rows = [(s["name"], group, fixed(least["value"], 1, 2), least["mode"], f"({least['x']:.2f}, {least['y']:.2f})")
            for s in case.results.summary["stages"] for group, least in (s.get("safety") or {}).items() if least["value"] is not None]  # fmt: skip
    if not rows:
        return ""
    return ("<h2>Local failure of the material</h2>" + table(("stage", "group", "least factor", "governed by", "at [m]"), rows, (2,))
            + "<p><small>Factors (39)-(41) at block centres: tension, compression, shear by Mohr-Coulomb. At a singular corner, such as the "
              "toe, the least factor falls with every refinement of the mesh.</small></p>")  # fmt: skip


def blocks_of(case, name):
    """Describes the blocks of a group; a scene may leave it to the mesh whether they are rigid."""
    material, mesh = case.scene.materials[name], case.results.mesh
    if name in mesh.group_names and mesh.group_rigid[mesh.group_names.index(name)]:
        return "rigid"
    usual = "full" if material.get("law", "elastic") == "elastic" else "bending"
    return "condensed" if material.get("condensed") is True else str(material.get("element", usual))


def words(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    return " ".join(map(words, value)) if isinstance(value, list) else f"{value:g}" if isinstance(value, float) else str(value)


JOINT_COLUMNS = ("joint", "law", "stress model", "k_n [GPa/m]", "k_s [GPa/m]", "φ [°]", "φ residual [°]", "c [kPa]", "c residual [kPa]", "f_t [kPa]", "f_t residual [kPa]", "aperture [mm]", "residual [mm]")


def joint_rows_of(case, stage):
    """Joints as they are in a stage, and the columns that say something of them."""
    joints = []
    for name in case.results.stage_summary(stage)["joints"]:
        j = case.scene.joint(name, stage)
        peak = [j[key] if j["law"] != "elastic" else None for key in ("cohesion", "cohesion_residual", "tension", "tension_residual")]
        joints.append((name, (j["law"], "keys"), (j["stress_model"], "keys"), cell_of(j.get("k_n"), 1e-9, 2), cell_of(j.get("k_s"), 1e-9, 2),
                       cell_of(j.get("friction"), 1, 1), cell_of(j.get("friction_residual"), 1, 1), *(cell_of(value, 1e-3, 1) for value in peak), *(cell_of(j.get(key), 1e3, 3) for key in ("aperture", "aperture_residual"))))  # fmt: skip
    shown = 13 if any(row[-2] != "-" for row in joints) else 11  # apertures where water may flow
    return [row[:shown] for row in joints], JOINT_COLUMNS[:shown]


def load_rows(case):
    return [(name, (load.get("type", ""), "keys"), (", ".join(f"{key} {words(value)}" for key, value in load.items() if key != "type"), "keys"))
            for name, load in case.scene.loads.items()]  # fmt: skip


def inputs_part(case, stage, most):
    """Lists the materials, joints and loads that the main part, about a stage and with tables of `most` rows, leaves out."""
    joints, columns = joint_rows_of(case, stage)
    loads, part = load_rows(case), history_part(case)
    if len(case.scene.materials) > most:
        part += materials_table(case, blocks_of)
    if len(joints) > most:
        part += f"<h3>Joints in stage {esc(stage)}</h3>" + table(columns, joints, range(3, len(columns)))
    if len(loads) > most:
        part += "<h3>Loads</h3>" + table(("load", "type", "keys (SI)"), loads)
    return f"<h2>Materials, joints and loads</h2>{part}" if part else ""


def as_told(value, unit, found, key):
    """Writes a number of the options; else the scene's number under each judged base."""
    if value is not None:
        return f"{value:g}{unit}"
    bases = {}
    for a in found:
        if a.with_uplift and a.condition and getattr(a.water.heads, key) is not None:
            bases.setdefault(getattr(a.water.heads, key), []).append(a.name)
    return "; ".join(f"{number:g}{unit} under {', '.join(dict.fromkeys(names))}, as in the scene" for number, names in bases.items()) or "-"


def uplift_part(case, found):
    o = case.options
    if not o.uplift:
        return "<p>No uplift was asked for besides the scene's: both methods have the same loads.</p>"
    rule = uplift.rule_named(o.uplift)
    gallery = (("gallery", f"{o.gallery:g} m"),) if o.gallery is not None else (("head in the gallery", as_told(None, " m", found, "gallery")),)
    facts = [("rule", f"{rule.name}: {rule.source} ({rule.status})"), ("in the crack at rest", "full" if o.in_crack == "full" else rule.crack),
             ("in a crack that an earthquake opens", o.in_crack or rule.shaken),
             ("pressure", "normal to the base" if o.direction == "normal" else "vertical part only"),
             ("drain from the heel", as_told(o.drain, " m", found, "drain")), ("efficiency", as_told(o.efficiency, "", found, "efficiency")),
             ("measured head at the drain", "-" if o.drain_head is None else f"{o.drain_head:g} m"),
             ("tailwater", "as loads" if o.tailwater is None else f"{o.tailwater:g} m"), *gallery]  # fmt: skip
    return "<h3>Uplift in the gravity method</h3>" + table(("", ""), facts)


def assessment_part(found, caveats):
    rows = [(r.quantity, r.unit, cell(r.block, r.digits), cell(r.hand, r.digits), cell(r.difference, r.digits, "+"), cell(r.with_uplift, r.digits))
            for r in lines(found)]  # fmt: skip
    at = [f"({x:.2f}, {y:.2f}) m" for x, y in found.base.ends()]
    head = f"Stage {found.stage}, {found.kind} {found.name}" + ("" if found.condition else " (stage not judged)")
    text = f"From {at[0]} (start) to {at[1]} (end), {found.base.length:.3f} m."
    header = ("quantity", "unit", "block model", "gravity method", "difference", "with uplift of the options")
    shown = 6 if found.with_uplift else 5
    part = f"<h3>{esc(head)}</h3><p class='soft'>{esc(text)}</p>"
    part += table(header[:shown], [row[:shown] for row in rows], (2, 3, 4, 5))
    return f"<section>{part}{caveats.marks(found.notes)}</section>"


def assessments_part(case, found, caveats):
    part = "<h2>Block model and gravity method</h2>" + uplift_part(case, found)
    part += ("<p><small>N compression positive; T positive towards the end; M about the middle of the base, positive when it pulls at the "
             "end; stress positive in tension. The block model's largest compression is at one contact end, often a singular corner that grows "
             "with the mesh; the gravity method's is that of a straight line.</small></p>")  # fmt: skip
    ordered = sorted(found, key=lambda a: a.condition is None)  # stable: judged stages first
    return part + "".join(assessment_part(a, caveats) for a in ordered)


def water_part(case, found):
    """Describes water that flows in joints, stage by stage: uplift beside the prescribed one, flow through heads and drains."""
    part = ""
    for s in case.results.summary["stages"]:
        if not state_rows(s):
            continue
        flow = state_rows(s)[0]
        part += f"<section><h3>Stage {esc(s['name'])}: {esc(flow[0])} flow</h3>"
        rows = [(a.name, *row) for a in found if a.stage == s["name"] and a.computed is not None for row in beside(a)]
        part += table(("base", *base_water.BESIDE), rows, range(2, 8)) if rows else ""
        part += table(("head or drain", "leaves the joints there [m²/s]", "in litres per minute and metre"), condition_rows(s), (1, 2))
        part += table(("joint", "length [m]", "force of its water [kN]", "centre x [m]", "centre y [m]", "widest [mm]", "part at residual aperture",
                       "part at largest aperture", "Reynolds number"), joint_rows(s), range(1, 9))  # fmt: skip
        part += table(("rounds of flow and openings", "last change of pressure, of the largest", "inflow [m²/s]", "water balance, of the inflow",
                       "cut off from every head [m]"), [flow[1:]], range(5))  # fmt: skip
        part += notes(base_water.remarks(case.results, s["name"])) + "</section>"
    note = ("<p><small>Computed: as the run has found it, in block model and gravity method; the straight line lies between the computed pressures at the "
            "ends of the base; the rule is that of the options, with its drain in stages with one that is not clogged. Discharge: negative enters the "
            "joints. Force of water in a joint that is no line: the sum of the sizes on its pieces.</small></p>")  # fmt: skip
    return f"<h2>Water in joints</h2>{part}{note}" if part else ""


def effort_part(case, most):
    """How stages were solved, bodies that left their place; the evidence of all stages where the main part has only `most` of them."""
    rows = [(s["name"], s["verdict"], s["evidence"], s["cycles"], "-" if s["ratio"] is None else f"{s['ratio']:.2e}", s["checksum"])
            for s in case.results.summary["stages"]]  # fmt: skip
    part = table(("stage", "verdict", "evidence", "cycles", "unbalanced ratio", "checksum"), rows, (3, 4)) if len(rows) > most else ""
    effort = [(s["name"], *row) for s in case.results.summary["stages"] for row in effort_rows(s)]
    left = [(s["name"], *row) for s in case.results.summary["stages"] for row in body_rows(s)]
    if left:
        part += "<h3>Bodies that left their place</h3>" + table(
            ("stage", "macroblock", "group", "at [m]", "overturned [s]", "fallen [s]", "slid [s]", "moved x [m]", "moved y [m]", "turned [degree]"),
            left, tuple(range(4, 10)))  # fmt: skip
    if effort:
        part += table(("stage", "method", "force evaluations", "solves", "factorisations"), effort, (2, 3, 4))
    return f"<h2>How it was solved</h2>{part}" if part else ""
