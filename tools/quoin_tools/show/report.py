"""The sheet: one self-contained HTML page (and PDF) about a run, with the gravity method and a guideline's limits.

    quoin report FOLDER [--guideline usace] [--uplift npb --drain 4.72] [--pdf] ...

writes FOLDER/report.html; --help lists all options, docs/safety.md explains them. Everything taken from files is escaped, and nothing
is loaded from elsewhere.
"""

import datetime
import os
import sys

import quoin_tools
from quoin_tools.assess import base_water, guidelines, uplift
from quoin_tools.assess.assessment import ERRORS, account_complaints, assess, beside, cell, gathered, lines, load_case
from quoin_tools.assess.assessment_options import options_from, parser
from quoin_tools.base import scene
from quoin_tools.base.files import write_file
from quoin_tools.base.flow import condition_rows, joint_rows, state_rows
from quoin_tools.base.modes import mode_rows
from quoin_tools.base.results import (
    body_rows,
    condensed_words,
    effort_rows,
    factor_rows,
    fixed,
    mechanism_rows,
    no_single_factor,
    trials_of,
)
from quoin_tools.ensemble.variables import EnsembleError
from quoin_tools.show import browser, plots, section, verify
from quoin_tools.show.anchors_part import anchors_part
from quoin_tools.show.ensemble_part import ensemble_part
from quoin_tools.show.hypertext import esc, file_picture, notes, picture, table
from quoin_tools.show.limit_part import limit_part
from quoin_tools.show.materials_part import cell_of, history_part, laws_part, materials_table
from quoin_tools.show.mechanism import plot_mechanisms
from quoin_tools.show.shaken_part import shaken_part
from quoin_tools.show.shaking import Shaken

STYLE = """
:root { --ink: #1b1f24; --soft: #5b6570; --rule: #c9d0d6; --accent: #12456b }
* { box-sizing: border-box }
body { font: 14px/1.45 "DejaVu Sans", "Segoe UI", Arial, sans-serif; color: var(--ink); max-width: 960px; margin: 0 auto; padding: 28px }
h1 { font-size: 24px; margin: 0 0 4px } h2 { font-size: 17px; margin: 30px 0 8px; padding-bottom: 3px; border-bottom: 2px solid var(--accent);
color: var(--accent); break-after: avoid } h3 { font-size: 14px; margin: 20px 0 6px; break-after: avoid }
p, ul { margin: 6px 0 } .soft { color: var(--soft) } small { color: var(--soft) }
table { border-collapse: collapse; width: 100%; margin: 6px 0 12px; font-size: 12.5px; break-inside: avoid }
th { text-align: left; font-weight: 600; border-bottom: 1.5px solid var(--ink); padding: 4px 8px; vertical-align: bottom }
td { border-bottom: 1px solid var(--rule); padding: 3px 8px; vertical-align: top; overflow-wrap: break-word }
section { break-inside: avoid }
.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap } th.n { white-space: normal }
.verdict { border: 1.5px solid; border-left-width: 9px; padding: 8px 14px; margin: 14px 0; break-inside: avoid }
.verdict b { font-size: 19px } .verdict span { color: var(--ink) } .pass { color: #10692e } .fail { color: #a81919 } .open { color: #8a5a00 }
td.pass, td.fail, td.open { font-weight: 600; white-space: nowrap }
.note { background: #fff6dd; border-left: 5px solid #d9a400; padding: 5px 12px; margin: 6px 0; break-inside: avoid; color: var(--ink) }
figure { margin: 10px 0 16px; break-inside: avoid; text-align: center } figure img { max-width: 100%; max-height: 215mm }
figcaption { font-size: 12px; color: var(--soft); text-align: left }
pre { font: 11.5px/1.4 "DejaVu Sans Mono", Consolas, monospace; white-space: pre-wrap; overflow-wrap: anywhere; background: #f4f6f8;
border: 1px solid var(--rule); padding: 10px }
code { font: 11.5px "DejaVu Sans Mono", Consolas, monospace; overflow-wrap: anywhere }
.sign { table-layout: fixed } .sign th, .sign td { border: 1px solid var(--ink); width: 30% } .sign td { height: 40px } .sign .d { width: 20% }
@page { size: A4; margin: 15mm 14mm 17mm; @bottom-left { font: 9px Arial, sans-serif; color: #5b6570; content: "Quoin, state STATE" }
@bottom-right { font: 9px Arial, sans-serif; color: #5b6570; content: "page " counter(page) " of " counter(pages) } }
@media print { body { max-width: none; padding: 0; font-size: 11.5px } table { font-size: 10.5px }
figure img[src^="data:image/png"] { max-height: 116mm } .note, .verdict, pre { print-color-adjust: exact; -webkit-print-color-adjust: exact } }
"""


def verdict_class(text):
    return "pass" if text.lower().startswith("pass") else "fail" if text.startswith("FAIL") else "open"


# ---- parts of the sheet, in order


def heading(case):
    summary = case.results.summary
    rows = [("Model", summary["model"]), ("Scene", case.scene.path if not summary["scene"] else summary["scene"]),
            ("Program", f"Quoin {summary['quoin']}, {summary['ranks']} rank{'s' * (summary['ranks'] != 1)}; "
                        f"sheet by quoin_tools {quoin_tools.__version__}"),
            ("Model size", f"{summary['n_blocks']} blocks in {summary['n_macroblocks']} bodies, {summary['n_contacts']} contacts, "
                           f"{summary['n_dofs']} degrees of freedom"),
            *([("Condensed", condensed_words(summary))] if summary.get("condensed") else []),
            ("Slice", f"{summary['thickness']:g} m thick; forces are those of the slice"),
            ("State checksum", f"{summary['stages'][-1]['checksum']} (stage {summary['stages'][-1]['name']})"),
            ("Sheet written", datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"))]  # fmt: skip
    title = summary["title"] or summary["model"]
    return f"<h1>{esc(title)}</h1><p class='soft'>Safety of a masonry dam: block model and gravity method</p>" + table(("", ""), rows)


def verdict_box(case, found, complaints):
    """What the limits say, in one word and one sentence."""
    o = case.options
    if not o.guideline:
        names = ", ".join(guidelines.read())
        return f'<div class="verdict open"><b>Not judged</b><br><span>No guideline was named (--guideline: {esc(names)}).</span></div>'
    judged = [a for a in found if a.condition]
    named = set(case.conditions)
    there = {(a.stage, a.name) for a in judged}
    refused = [name for name in o.paths if any((stage, name) not in there for stage in named)]
    missing = not judged or not named <= {a.stage for a in judged} or bool(refused)
    rows = [limit for a in judged for limit in a.limits]
    word = guidelines.overall(rows, not missing and all(a.complete for a in judged))
    failed = [f"{limit.text} in stage {a.stage} on {a.name}" for a in judged for limit in a.limits if limit.verdict == guidelines.FAIL]
    stages = ", ".join(dict.fromkeys(f"{a.stage} as {a.condition}" for a in judged))
    text = f"{guidelines.read()[o.guideline]['title']}. Judged: {stages or 'no stage'}."
    if failed:
        text += " Fails: " + "; ".join(failed) + "."
    if refused:
        text += f" No numbers for path {', '.join(refused)}."
    open_ones = sum(limit.verdict == guidelines.OPEN for limit in rows)
    if open_ones:
        text += f" Limits not judged for want of a number: {open_ones}."
    if any(limit.check for limit in rows):
        text += " Limits marked “check” were written from memory and must be held against the document."
    flaws = [f"{stages}: {line}" for stages, line in gathered({s: said for s, said in complaints.items() if s in named})]
    flaws += [f"Stage {a.stage}, {a.name}: {note}" for a in judged for note in a.notes]
    return f'<div class="verdict {verdict_class(word)}"><b>{esc(word)}</b><br><span>{esc(text)}</span></div>' + notes(flaws)


def account_boxes(case):
    """A box above all others for each stage in time whose energy account is out, judged or not."""
    return "".join(f'<div class="verdict fail"><b>Energy account out: stage {esc(s["name"])}</b><br><span>{esc(" ".join(said))}</span></div>'
                   for s in case.results.summary["stages"] if "balance" in s["energy"] and (said := account_complaints(s)))


def without_result(case):
    """Stages of the scene that the run has not come to the end of."""
    done = {s["name"] for s in case.results.summary["stages"]}
    return [name for name in case.scene.stages if name not in done]


def unfinished_note(case):
    """What happens in these stages may be what matters."""
    names, not_run = without_result(case), case.results.summary.get("not_run", [])
    said = [f"Not run, because the stage from which they start has failed: {', '.join(not_run)}."] if not_run else []
    names = [name for name in names if name not in not_run]
    return notes(said + [f"No result of stage{'s' * (len(names) != 1)} {', '.join(names)}: the run was refused, stopped or broke off before, or goes "
                  "on. The sheet knows nothing of it."] * bool(names)) if names or said else ""  # fmt: skip


def limits_part(case, found):
    """Every limit with the number held against it."""
    rows = [(a.stage, a.condition, a.name, j.text, j.bound, j.printed(j.value), (j.verdict, verdict_class(j.verdict)),
             j.source + ("; check" if j.check else "")) for a in found for j in a.limits]  # fmt: skip
    if not rows:
        return ""
    note = guidelines.read()[case.options.guideline]["note"]
    return ("<h2>Limits</h2>" + table(("stage", "condition", "base", "limit of", "limit", "number", "verdict", "source"), rows, (4, 5))
            + "<p><small>The number is the less favourable of the block model and of the gravity method, the latter with uplift where a "
              "rule was given; the block model has the loads of the scene. Stress "
              f"limits are held against the gravity method's straight line. {esc(note)}</small></p>")  # fmt: skip


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
    """What the trials of a stage changed, in words."""
    if "raises" in found:
        return f"factor on {', '.join(found['raises'])} [-]"
    if "forces" in found:
        return f"pull of {', '.join(found['forces'])} over prestress [-], strengths divided by {found['required']:g}"
    if "what" not in found:
        return "water level [m]"
    return "angle of friction [°]" if found["what"] == "friction" else "part of all strengths left [-]"


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
    """What the blocks of a group are: a scene may leave it to the mesh whether they are rigid."""
    material, mesh = case.scene.materials[name], case.results.mesh
    if name in mesh.group_names and mesh.group_rigid[mesh.group_names.index(name)]:
        return "rigid"
    usual = "full" if material.get("law", "elastic") == "elastic" else "bending"
    return "condensed" if material.get("condensed") is True else str(material.get("element", usual))


def inputs_part(case):
    """Materials, and joints as they are in the last stage."""
    last = case.results.stages[-1]
    joints = []
    for name in case.results.stage_summary(last)["joints"]:
        j = case.scene.joint(name, last)
        peak = (j["cohesion"], j["tension"]) if j["law"] != "elastic" else (None, None)
        joints.append((name, j["law"], j["stress_model"], cell_of(j.get("k_n"), 1e-9, 2), cell_of(j.get("k_s"), 1e-9, 2),
                       cell_of(j.get("friction"), 1, 1), cell_of(j.get("friction_residual"), 1, 1), cell_of(peak[0], 1e-3, 1),
                       cell_of(peak[1], 1e-3, 1), *(cell_of(j.get(key), 1e3, 3) for key in ("aperture", "aperture_residual"))))  # fmt: skip
    shown = 11 if any(row[-2] != "-" for row in joints) else 9  # apertures where water may flow
    loads = [(name, load.get("type", ""), ", ".join(f"{key} {words(value)}" for key, value in load.items() if key != "type"))
             for name, load in case.scene.loads.items()]  # fmt: skip
    return ("<h2>Materials, joints and loads</h2>" + materials_table(case, blocks_of)
            + f"<h3>Joints in stage {esc(last)}</h3>"
            + table(("joint", "law", "stress model", "k_n [GPa/m]", "k_s [GPa/m]", "φ [°]", "φ residual [°]", "c [kPa]", "f_t [kPa]", "aperture [mm]",
                     "residual [mm]")[:shown], [row[:shown] for row in joints], range(3, shown))
            + "<h3>Loads</h3>" + table(("load", "type", "keys (SI)"), loads) + history_part(case))  # fmt: skip


def words(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    return " ".join(map(words, value)) if isinstance(value, list) else f"{value:g}" if isinstance(value, float) else str(value)


def uplift_part(case):
    o = case.options
    if not o.uplift:
        return "<p>No uplift was asked for besides the scene's: both methods have the same loads.</p>"
    rule = uplift.rule_named(o.uplift)
    facts = [("rule", f"{rule.name}: {rule.source} ({rule.status})"), ("in the crack", o.in_crack or rule.crack),
             ("pressure", "normal to the base" if o.direction == "normal" else "vertical part only"),
             ("drain from the heel", "none" if o.drain is None else f"{o.drain:g} m"),
             ("efficiency", "-" if o.efficiency is None else o.efficiency),
             ("measured head at the drain", "-" if o.drain_head is None else f"{o.drain_head:g} m"),
             ("tailwater", "as loads" if o.tailwater is None else f"{o.tailwater:g} m"),
             ("gallery", "-" if o.gallery is None else f"{o.gallery:g} m")]  # fmt: skip
    return "<h3>Uplift in the gravity method</h3>" + table(("", ""), facts)


def assessment_part(found):
    rows = [(r.quantity, r.unit, cell(r.block, r.digits), cell(r.hand, r.digits), cell(r.difference, r.digits, "+"), cell(r.with_uplift, r.digits))
            for r in lines(found)]  # fmt: skip
    at = [f"({x:.2f}, {y:.2f}) m" for x, y in found.base.ends()]
    head = f"Stage {found.stage}, {found.kind} {found.name}" + ("" if found.condition else " (stage not judged)")
    text = f"From {at[0]} (start) to {at[1]} (end), {found.base.length:.3f} m."
    header = ("quantity", "unit", "block model", "gravity method", "difference", "with uplift of the options")
    shown = 6 if found.with_uplift else 5
    part = f"<h3>{esc(head)}</h3><p class='soft'>{esc(text)}</p>"
    part += table(header[:shown], [row[:shown] for row in rows], (2, 3, 4, 5))
    return f"<section>{part}{notes(found.notes)}</section>"


def assessments_part(case, found, complaints):
    part = "<h2>Block model and gravity method</h2>" + uplift_part(case)
    part += ("<p><small>N compression positive; T positive towards the end; M about the middle of the base, positive when it pulls at the "
             "end; stress positive in tension. The block model's largest compression is at one contact end, often a singular corner that grows "
             "with the mesh; the gravity method's is that of a straight line.</small></p>")  # fmt: skip
    ordered = sorted(found, key=lambda a: a.condition is None)  # stable: judged stages first
    part += "".join(assessment_part(a) for a in ordered)
    said = [f"{stages}: {line}" for stages, line in gathered(complaints)]
    return part + (("<h3>Reservations</h3>" + notes(said)) if said else "")


def water_part(case, found):
    """Water that flows in joints, stage by stage: uplift beside the prescribed one, what heads and drains give and take."""
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


def convergence_part(case, pictures):
    rows = [(s["name"], s["verdict"], s["evidence"], s["cycles"], "-" if s["ratio"] is None else f"{s['ratio']:.2e}", s["checksum"])
            for s in case.results.summary["stages"]]  # fmt: skip
    part = "<h2>Evidence of convergence</h2>" + table(
        ("stage", "verdict", "evidence", "cycles", "unbalanced ratio", "checksum"), rows, (3, 4))  # fmt: skip
    effort = [(s["name"], *row) for s in case.results.summary["stages"] for row in effort_rows(s)]
    left = [(s["name"], *row) for s in case.results.summary["stages"] for row in body_rows(s)]
    if left:
        part += "<h3>Bodies that left their place</h3>" + table(
            ("stage", "macroblock", "group", "at [m]", "overturned [s]", "fallen [s]", "slid [s]", "moved x [m]", "moved y [m]", "turned [degree]"),
            left, tuple(range(4, 10)))  # fmt: skip
    if effort:
        part += table(("stage", "method", "force evaluations", "solves", "factorisations"), effort, (2, 3, 4))
    for path in pictures:
        if os.path.basename(path) == "history.png":
            part += file_picture(path, "History: unbalanced ratio, displacement of named points, damping.")
    return part + "<p><small>How results change with the mesh is not part of a single run: repeat it on a finer mesh and compare.</small></p>"


SHAPES = 3  # modes of a stage that are drawn
CAPTIONS = {"mesh": "Blocks, deformed, at the end of the last stage.", "stress": "Principal stresses, {}.", "joint": "Stress along a joint, {}.",
            "water": "Water in joints, stage {}: pressure on them; discharge.", "uplift": "Water pressure along a joint, {}.",
            "time": "Joint over time, {}: forces, sliding factor at the time, slip, opening.", "shaking": "Motion over time, stage {}.",
            "spectrum": "Response spectra of the record and of the highest point, stage {}.", "envelope": "Largest s1, least s2 and least local failure factor over time, stage {}.", "energy": "Energy over time, stage {}.",
            "transient": "Levels, force of the water in joints and discharge in time, stage {}.",
            "temperature": "Change of temperature, stage {}.", "plastic": "Plastic strain, stage {}.",
            "cracks": "Damage; width and way of cracks, stage {}.",
            "anchors": "Anchors, stage {}.", "anchor": "Anchors over the stages: {}.", "bars": "Along bonded bars, stage {}.",
            "mode": "Shape of a free vibration, mode {}.",
            "mechanism": "How it fails: velocity in the collapse, or in the failing trial next to the stable one, stage {}."}


def figures_part(pictures):
    part = "<h2>Figures</h2>"
    for path in pictures:
        kind, _, rest = os.path.basename(path).removesuffix(".png").partition("_")
        if kind in CAPTIONS and not (kind == "mode" and int(rest.split("_")[0]) > SHAPES):
            part += file_picture(path, CAPTIONS[kind].format(rest.replace("_", " ")))
    return part


def sections_part(case, found):
    stages = [stage for stage in case.results.stages if stage in case.conditions]
    part = "<h2>Section and loads</h2>"
    for stage in stages:
        mine = [a for a in found if a.stage == stage]
        drawing = section.section_svg(case, stage, mine)
        caption = f"Stage {stage}. Forces of the slice; red arrows at bases: resultants by the gravity method; dashed: its crack."
        part += picture(drawing.encode("utf-8"), "svg+xml", caption)
    return part


def echo_part(case):
    rows = verify.rows_of(case.results, case.scene.path, case.mesh_path)
    echoed = os.path.basename(case.scene.path) == scene.ECHO
    source = ("Every key in force, as the solver wrote it down, the command line included." if echoed else
              "The scene as read from its file; keys given on the solver's command line are not in it.")  # fmt: skip
    return ("<h2>Input</h2>" + table(("file", "name", "SHA-256"), rows)
            + f"<p><small>{esc(source)} The loads above were held against those the run applied.</small></p>"
            + f"<pre>{esc(case.scene.text)}</pre>")  # fmt: skip


SIGNATURES = ("<table class='sign'><thead><tr><th>Prepared by</th><th class='d'>Date</th><th>Checked by</th><th class='d'>Date</th></tr>"
              "</thead><tbody><tr><td></td><td></td><td></td><td></td></tr></tbody></table>")  # fmt: skip


def style(case):
    """The style sheet; every page of the PDF carries the checksum of the state (hexadecimal figures only, whatever the file says)."""
    state = "".join(c for c in str(case.results.summary["stages"][-1]["checksum"]) if c in "0123456789abcdef")
    return STYLE.replace("STATE", state)


def page(case, pictures, shaken, ensemble=None):
    found, complaints = assess(case)
    title = case.results.summary["title"] or case.results.summary["model"]
    body = "".join((
        heading(case), account_boxes(case), verdict_box(case, found, complaints), unfinished_note(case), SIGNATURES, limits_part(case, found), sections_part(case, found),
        stages_part(case), inputs_part(case), assessments_part(case, found, complaints), water_part(case, found), anchors_part(case, found), trials_part(case), limit_part(case), ensemble_part(ensemble), modes_part(case), shaken_part(case, shaken), laws_part(case), local_part(case),
        displacements_part(case), figures_part(pictures), convergence_part(case, pictures), echo_part(case)))  # fmt: skip
    return (f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{esc(title)}</title>'
            f'<meta name="viewport" content="width=device-width"><style>{style(case)}</style></head><body>{body}</body></html>\n')  # fmt: skip


def write(folder, options, with_pdf=False, with_xlsx=False, ensemble=None):
    """Paths of what was written."""
    case = load_case(folder, options)
    shaken = Shaken(case.results, options.ky)
    text = verify.signed(page(case, plots.plot_all(case.results, shaken=shaken) + plot_mechanisms(case.results), shaken, ensemble))
    path = os.path.join(folder, "report.html")
    write_file(path, text)
    written = [path]
    if with_xlsx:
        from quoin_tools.show import spreadsheet

        written.append(os.path.join(folder, "report.xlsx"))
        spreadsheet.write(written[-1], text)
    if with_pdf:
        written.append(os.path.join(folder, "report.pdf"))
        browser.pdf(path, os.path.abspath(written[-1]))
    return written


def main(arguments=None):
    options = parser("report", "One self-contained HTML sheet about a run, FOLDER/report.html.")
    options.add_argument("--pdf", action="store_true", help="also FOLDER/report.pdf, printed by headless Chromium")
    options.add_argument("--xlsx", action="store_true", help="also FOLDER/report.xlsx: its tables, a tab for each chapter")
    options.add_argument("--ensemble", metavar="FOLDER", help="a page about an ensemble (quoin ensemble): probability of failure, what it hangs on")
    given = options.parse_args(arguments)
    try:
        print("\n".join(write(given.folder, options_from(given), given.pdf, given.xlsx, given.ensemble)))
    except browser.BrowserError as error:
        print(f"report: report.html is written, report.pdf is not: {error}", file=sys.stderr)
        return 3
    except (*ERRORS, EnsembleError, OSError) as error:
        print(f"report: {error}", file=sys.stderr)
        return 2
    return 0
