"""Writes pages 2 to 4 of the sheet: loads and materials, figures, the failure, evidence. Tables are cut where a page ends: the annex has them in full."""

import base64
import os

from quoin_tools.assess.assessment import cell
from quoin_tools.base.results import factor_rows, mechanism_rows, trials_of
from quoin_tools.show import verify
from quoin_tools.show.annex import blocks_of, joint_rows_of, load_rows
from quoin_tools.show.hypertext import esc, file_picture, table
from quoin_tools.show.materials_part import materials_table

ROWS, FEW = 8, 4  # of a table of the main part; of one about how it fails
FIGURES = 4  # of the main part
SHAPES = 3  # modes of a stage that are drawn
CAPTIONS = {"mesh": "Blocks, deformed, at the end of the last stage.", "stress": "Principal stresses, {}.", "joint": "Stress along a joint, {}.",
            "water": "Water in joints, stage {}: pressure on them; discharge.", "uplift": "Water pressure along a joint, {}.",
            "time": "Joint over time, {}: forces, sliding factor at the time, slip, opening.", "shaking": "Motion over time, stage {}.",
            "spectrum": "Response spectra of the record and of the highest point, stage {}.", "envelope": "Largest s1, least s2 and least local failure factor over time, stage {}.", "energy": "Energy over time, stage {}.",
            "transient": "Levels, force of the water in joints and discharge in time, stage {}.",
            "temperature": "Change of temperature, stage {}.", "plastic": "Plastic strain, stage {}.",
            "cracks": "Damage; width and way of cracks, stage {}.",
            "anchors": "Anchors, stage {}.", "anchor": "Anchors over the stages: {}.", "bars": "Along bonded bars, stage {}.",
            "mode": "Shape of a free vibration, mode {}.", "history": "History: unbalanced ratio, displacement of named points, damping.",
            "mechanism": "How it fails: velocity in the collapse, or in the failing trial next to the stable one, stage {}."}


def first(rows, most=ROWS):
    """The first rows, and a line about the others."""
    return list(rows)[:most], f"<p><small>{len(rows) - most} more rows are in the annex.</small></p>" if len(rows) > most else ""


# ---- loads and materials


def loads_part(case, stage):
    """Lists the loads, and the blocks on which they act; the forces are those of one stage on the whole model."""
    forces, _ = case.forces(stage)
    acting = case.scene.stage_loads(stage)
    rows = [(name, kind, keys, *((cell(f / 1e3, 1) for f in forces[name][:2]) if name in forces else ("-", "-")))
            for name, kind, keys in sorted(load_rows(case), key=lambda row: row[0] not in acting)]  # fmt: skip
    loads, more = first(rows)
    joints, shown = joint_rows_of(case, stage)
    joints, other = first(joints)
    return ("<h2>Loads and materials</h2>" + table(("load", "type", "keys (SI)", "X [kN]", "Y [kN]"), loads, (3, 4)) + more
            + f"<p><small>X, Y: force on the whole model in stage {esc(stage)}; “-”: it does not act there, or presses both sides of a joint.</small></p>"
            + materials_table(case, blocks_of, ROWS) + f"<h3>Joints in stage {esc(stage)}</h3>" + table(shown, joints, range(3, len(shown))) + other)  # fmt: skip


# ---- figures


def caption_of(path):
    """Returns the caption of a picture; None: it is no picture of the sheet."""
    kind, _, rest = os.path.basename(path).removesuffix(".png").partition("_")
    if kind not in CAPTIONS or (kind == "mode" and int(rest.split("_")[0]) > SHAPES):
        return None
    return CAPTIONS[kind].format(rest.replace("_", " "))


def chosen(pictures, stage, base):
    """Chooses the pictures of the main part: the governing case, the failure, the record, the envelope."""
    names = {os.path.basename(path): path for path in pictures}
    wanted = [f"stress_{stage}.png", f"joint_{base}_{stage}.png"]
    for kind in ("mechanism", "shaking", "cracks", "plastic", "water", "anchors", "time", "temperature"):
        wanted += [name for name in names if name.startswith(f"{kind}_")][-1:]
    return [names[name] for name in [*wanted, "mesh.png"] if name in names][:FIGURES]


def figures(paths):
    return "<h2>Figures</h2><div class='figures'>" + "".join(file_picture(path, caption_of(path)) for path in paths) + "</div>" if paths else ""


# ---- how it fails


def mechanism_part(case):
    """Lists the joints of collapsed stages, and of failed trials."""
    moving, factors = [], []
    for s in case.results.summary["stages"]:
        if s["verdict"] == "collapsed":
            moving += [(s["name"], *row) for row in mechanism_rows(s)]
        if trials_of(s):
            factors += [(s["name"], *row) for row in factor_rows(s)]
    part = ""
    if moving:
        rows, more = first(moving, FEW)
        part += table(("stage", "joint", "it", "sliding [-]", "opening [-]"), rows, (3, 4)) + more
    if factors:
        rows, more = first(factors, FEW)
        part += table(("stage", "joint", "φ [°]", "factor, last stable", "factor, first failing", "in the mechanism"), rows, (2, 3, 4)) + more
    return f"<h2>How it fails</h2>{part}" if part else ""


# ---- evidence


def scene_link(case):
    """The scene, to be saved from the page; in print it is attached to the PDF."""
    data = base64.b64encode(case.scene.text.encode("utf-8")).decode("ascii")
    name = os.path.basename(case.scene.path)
    source = "Every key in force, as the solver wrote it down, the command line included."
    return (f"<p><small>Scene {esc(name)}: <a class='screen' download=\"{esc(name)}\" href=\"data:text/plain;base64,{data}\">save it</a> "
            f"<span class='print'>attached to this PDF.</span> {esc(source)} The loads above were held against those the run applied.</small></p>")  # fmt: skip


def evidence_part(case, caveats):
    rows, more = first([(s["name"], s["verdict"], s["evidence"], s["cycles"], "-" if s["ratio"] is None else f"{s['ratio']:.2e}", s["checksum"])
                        for s in case.results.summary["stages"]])  # fmt: skip
    files = verify.rows_of(case.results, case.scene.path, case.mesh_path)
    return ("<h2>Evidence of convergence</h2>" + table(("stage", "verdict", "evidence", "cycles", "unbalanced ratio", "checksum"), rows, (3, 4)) + more
            + "<p><small>How results change with the mesh is not part of a single run: repeat it on a finer mesh and compare.</small></p>"
            + (f"<h2>Reservations</h2>{caveats.main()}" if caveats.judged else "")
            + "<h2>Input</h2>" + table(("file", "name", "SHA-256"), files) + scene_link(case))  # fmt: skip
