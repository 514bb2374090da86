"""Writes the part of the sheet about anchors: forces, bonded bars along their length, dowels, bases with and without them, the force that a factor needs."""

import numpy as np

from quoin_tools.assess.assessment import cell
from quoin_tools.base import anchors
from quoin_tools.base.flow import printed
from quoin_tools.base.language import N_, _
from quoin_tools.base.results import sliding
from quoin_tools.show.hypertext import head, notes, small, table

BAR_COLUMNS = (N_("bar"), N_("largest force [kN]"), N_("per metre [kN/m]"), N_("at [m] from the head"), N_("largest use of the bond [-]"), N_("slip in the grout [mm]"), N_("slipped [m]"),
               N_("yielded [m]"), N_("stored [J]"), N_("lost in yield, bond, dowels [J]"))  # fmt: skip
DOWEL_COLUMNS = (N_("bar"), N_("x [m]"), N_("y [m]"), N_("force across [kN]"), N_("slip of the joint [mm]"), N_("plastic [mm]"), N_("use [-]"))


def bar_rows(case, s):
    """Each bonded bar at the end of a stage; where along it the force is largest."""
    stage, rows = case.results.stage(s["name"]), []
    if stage.bars is None:
        return rows
    for row, (name, a) in enumerate((s.get("anchors") or {}).items()):
        mine = stage.bars.of(row)
        if len(mine):
            top = mine[np.abs(stage.bars.force[mine]).argmax()]
            lost = _("{0}, {1}, {2}", *(printed(a.get(key), ".3g") for key in ("lost_yield", "lost_bond", "lost_dowel")))
            rows.append((name, cell(stage.bars.force[top] / 1e3, 2), cell(stage.bars.force[top] / stage.anchors.spacing[row] / 1e3, 2), cell(stage.bars.from_head[top], 2),
                         cell(stage.bars.bond_use[mine].max(), 3), cell(1e3 * a["slip"], 3), cell(a["slipped_length"], 2), cell(a["yielded_length"], 2), printed(a["stored"], ".4g"), lost))  # fmt: skip
    return rows


def base_rows(found):
    """Bases that anchors cross, with and without them, by the gravity method; the block model has them."""
    rows = []
    for a in found:
        if a.without_anchors is not None:
            with_, bare, (pull, across) = a.with_anchors, a.without_anchors, a.anchored
            block = (a.block or {}).get("peak")
            factors = (sliding(x) if x is not None else "-" for x in (block, with_[0], bare[0]))
            rows.append((a.stage, a.name, cell(pull / 1e3, 1), cell(across / 1e3, 1), *factors, *(cell(x, 2) for x in (with_[1], bare[1]))))
    return rows


def needed_rows(s):
    """Returns rows on a stage of anchor_force: factor, and the force of each anchor that gives it."""
    return [(s["name"], *row) for row in anchors.needed_rows(s)]


def anchors_part(case, found):
    part = ""
    for s in case.results.summary["stages"]:
        rows = anchors.rows(s)
        if rows:
            part += "<section>" + head(_("Stage {0}", s["name"]), 3) + table(map(_, anchors.COLUMNS), rows, range(2, 8))
            bars, dowels = bar_rows(case, s), anchors.dowel_rows(s)
            part += table(map(_, BAR_COLUMNS), bars, range(1, 10)) if bars else ""
            part += table(map(_, DOWEL_COLUMNS), dowels, range(1, 7)) if dowels else ""
            part += notes(anchors.remarks(s)) + "</section>"
    if not part:
        return ""
    rows = base_rows(found)
    if rows:
        part += head(_("Bases with and without anchors"), 3) + table(
            (_("stage"), _("base"), _("pull across it [kN]"), _("along it [kN]"), _("sliding factor, block model"), _("gravity method, with"), _("without"), _("open length, with [m]"), _("without [m]")),
            rows, range(2, 9))  # fmt: skip
        part += small(_("Pull: what the anchors that cross the base do to the part above, in the slice: across positive where it presses the base, along positive towards the end. "
                 "Without: the same loads and no anchors, by the gravity method; “-”: without them there is no equilibrium without tension."))  # fmt: skip
    needed = [row for s in case.results.summary["stages"] for row in needed_rows(s)]
    if needed:
        part += head(_("Force that a factor takes"), 3) + table(
            (_("stage"), _("anchor"), _("required factor"), _("fails with [kN]"), _("stands with [kN]"), _("fails with [kN/m]"), _("stands with [kN/m]")), needed, range(2, 7))  # fmt: skip
    return (head(_("Anchors")) + part + small(_("Forces of one anchor, and of all in a metre of thickness. A force that a jack holds is that of its stage. Of a bonded bar the force "
            "is the largest along it; use of the bond is over its strength; figures show both along the bar.")))  # fmt: skip
