"""Writes pages 2 to 4 of the sheet: loads and materials, figures, the failure, evidence. Tables are cut where a page ends: the annex has them in full."""

import base64
import os

from quoin_tools.assess.assessment import cell
from quoin_tools.base.language import N_, _, numeral
from quoin_tools.base.results import factor_rows, mechanism_rows, trials_of
from quoin_tools.base.solver_sentences import solver_says
from quoin_tools.show import verify
from quoin_tools.show.annex import blocks_of, joint_rows_of, load_rows
from quoin_tools.show.hypertext import esc, file_picture, head, more_rows, small, table
from quoin_tools.show.materials_part import materials_table

ROWS, FEW = 8, 4  # of a table of the main part; of one about how it fails
FIGURES = 4  # of the main part
KINDS = ("mechanism", "pushover", "shaking", "cracks", "plastic", "water", "anchors", "time", "temperature")  # of the main part's pictures, behind those of the governing case
SHAPES = 3  # modes of a stage that are drawn
CAPTIONS = {"mesh": N_("Blocks, deformed, at the end of the last stage."), "stress": N_("Principal stresses, {0}."), "joint": N_("Stress along a joint, {0}."),
            "water": N_("Water in joints, stage {0}: pressure on them; discharge."), "uplift": N_("Water pressure along a joint, {0}."),
            "time": N_("Joint over time, {0}: forces, sliding factor at the time, slip, opening."), "shaking": N_("Motion over time, stage {0}."),
            "spectrum": N_("Response spectra of the record and of the highest point, stage {0}."), "envelope": N_("Largest s1, least s2 and least local failure factor over time, stage {0}."), "energy": N_("Energy over time, stage {0}."),
            "transient": N_("Levels, force of the water in joints and discharge in time, stage {0}."),
            "pushover": N_("Force over displacement of a pushover, stage {0}."),
            "temperature": N_("Change of temperature, stage {0}."), "plastic": N_("Plastic strain, stage {0}."),
            "cracks": N_("Damage; width and way of cracks, stage {0}."),
            "anchors": N_("Anchors, stage {0}."), "anchor": N_("Anchors over the stages: forces."), "bars": N_("Along bonded bars, stage {0}."),
            "mode": N_("Shape of a free vibration, mode {0}."), "history": N_("History: unbalanced ratio, displacement of named points, damping."),
            "mechanism": N_("How it fails: velocity in the collapse, or in the failing trial next to the stable one, stage {0}.")}


def first(rows, most=ROWS):
    """The first rows, and a line about the others."""
    return list(rows)[:most], more_rows(len(rows) - most) if len(rows) > most else ""


# ---- loads and materials


def loads_part(case, stage):
    """Lists the loads, and the blocks on which they act; the forces are those of one stage on the whole model."""
    forces = case.forces(stage)[0]
    acting = case.scene.stage_loads(stage)
    rows = [(name, kind, keys, *((cell(f / 1e3, 1) for f in forces[name][:2]) if name in forces else ("-", "-")))
            for name, kind, keys in sorted(load_rows(case), key=lambda row: row[0] not in acting)]  # fmt: skip
    loads, more = first(rows)
    joints, shown = joint_rows_of(case, stage)
    joints, other = first(joints)
    return (head(_("Loads and materials")) + table((_("load"), _("type"), _("keys (SI)"), "X [kN]", "Y [kN]"), loads, (3, 4)) + more
            + small(_("X, Y: force on the whole model in stage {0}; “-”: it does not act there, or presses both sides of a joint.", stage))
            + materials_table(case, blocks_of, ROWS) + head(_("Joints in stage {0}", stage), 3) + table(shown, joints, range(3, len(shown))) + other)  # fmt: skip


# ---- figures


def caption_of(path):
    """Returns the caption of a picture; None: it is no picture of the sheet."""
    kind, sign, rest = os.path.basename(path).removesuffix(".png").partition("_")
    if kind not in CAPTIONS or (kind == "mode" and int(rest.split("_")[0]) > SHAPES):
        return None
    return _(CAPTIONS[kind], rest.replace("_", " "))


def wanted(stage, base):
    """Returns the beginnings of the names of the pictures that the main part is to show, the most wanted first: the governing case, the failure, the record, the envelope."""
    return [f"stress_{stage}.png", f"joint_{base}_{stage}.png", *(f"{kind}_" for kind in KINDS), "mesh.png"]


def chosen(pictures, beginnings):
    """Returns the pictures of the main part: of each beginning the last one."""
    found = [[path for path in pictures if os.path.basename(path).startswith(beginning)][-1:] for beginning in beginnings]
    return [path for paths in found for path in paths][:FIGURES]


def figures(paths):
    return head(_("Figures")) + "<div class='figures'>" + "".join(file_picture(path, caption_of(path)) for path in paths) + "</div>" if paths else ""


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
        part += table((_("stage"), _("joint"), _("it"), _("sliding [-]"), _("opening [-]")), rows, (3, 4)) + more
    if factors:
        rows, more = first(factors, FEW)
        part += table((_("stage"), _("joint"), "φ [°]", _("factor, last stable"), _("factor, first failing"), _("in the mechanism")), rows, (2, 3, 4)) + more
    return head(_("How it fails")) + part if part else ""


# ---- evidence


def scene_link(case):
    """The scene, to be saved from the page; in print it is attached to the PDF."""
    data = base64.b64encode(case.scene.text.encode("utf-8")).decode("ascii")
    name = os.path.basename(case.scene.path)
    source = _("Every key in force, as the solver wrote it down, the command line included. The loads above were held against those the run applied.")
    scene, saved, attached = map(esc, (_("Scene {0}:", name), _("save it"), _("attached to this PDF.")))
    return (f"<p><small>{scene} <a class='screen' download=\"{esc(name)}\" href=\"data:text/plain;base64,{data}\">{saved}</a> "
            f"<span class='print'>{attached}</span> {esc(source)}</small></p>")  # fmt: skip


def evidence_part(case, caveats):
    rows, more = first([(s["name"], _(s["verdict"]), solver_says(s["evidence"]), s["cycles"], "-" if s["ratio"] is None else numeral(f"{s['ratio']:.2e}"), s["checksum"])
                        for s in case.results.summary["stages"]])  # fmt: skip
    files = [(what if "." in what else _(what), *rest) for what, *rest in verify.rows_of(case.results, case.scene.path, case.mesh_path, case.options.guidelines)]
    return (head(_("Evidence of convergence")) + table((_("stage"), _("verdict"), _("evidence"), _("cycles"), _("unbalanced ratio"), _("checksum")), rows, (3, 4)) + more
            + small(_("How results change with the mesh is not part of a single run: repeat it on a finer mesh and compare."))
            + (head(_("Reservations")) + caveats.main() if caveats.judged else "")
            + head(_("Input")) + table((_("file"), _("name"), "SHA-256"), files) + scene_link(case))  # fmt: skip
