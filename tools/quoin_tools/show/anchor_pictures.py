"""Draws anchors, for plots.py: only scenes that have some.

anchors_<stage>.png    their lines on the section, coloured by force; beside bonded bars the diagram of the force along them
bars_<stage>.png       force along each bonded bar, and how much of the bond's strength is used
anchor_forces.png      force of each over the stages, and over the trials of a flood or load factor
"""

import os

import numpy as np
from matplotlib import pyplot
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.lines import Line2D

from quoin_tools.base import sheet_units
from quoin_tools.base.anchors import STATES, facts_of
from quoin_tools.base.language import _, numeral
from quoin_tools.show import style

FORCES = LinearSegmentedColormap.from_list("forces", ("#f2c14e", "#d1495b", "#5a1a6b"))
DIAGRAM = "#3b6ea5"
ROUND = (0.75, 0.53, 1.2, 0.3)  # [inch] left of the section, below, right with the bar of colours, above
MOST_NAMED = 12  # anchors whose forces are written beside them


def box_of(mesh, anchors, whole):
    """The view of the other pictures, and the anchors."""
    box, _ = style.view(mesh, whole)
    points = np.concatenate([anchors.head, anchors.root])
    margin = 0.04 * max(box[1] - box[0], box[3] - box[2])
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    return min(box[0], low[0]), max(box[1], high[0]), min(box[2], low[1]), max(box[3], high[1])


def draw_diagrams(axes, bars, names, facts, box):
    """The force along each bonded bar, off its line; black where it slips in its grout; a cross where it is a dowel that carries."""
    width = 0.06 * max(box[1] - box[0], box[3] - box[2]) / max(np.abs(bars.force).max(), 1e-300)
    for row, name in enumerate(names):
        at = bars.of(row)
        if len(at) == 0:
            continue
        place, along = bars.place[at], bars.place[at[-1]] - bars.place[at[0]]
        normal = np.array([-along[1], along[0]]) / np.hypot(*along)
        edge = place + width * bars.force[at, None] * normal
        axes.add_collection(PolyCollection([np.concatenate([place, edge[::-1]])], facecolors=DIAGRAM, edgecolors=DIAGRAM, linewidths=0.8, alpha=0.45, zorder=3))
        slips = np.flatnonzero(bars.slip[at[:-1], 1] != 0)
        axes.add_collection(LineCollection([place[i : i + 2] for i in slips], colors="black", linewidths=1.2, zorder=6))
        dowels = [dowel["place"] for dowel in facts[name].get("dowels", []) if dowel["force"] != 0]
        if dowels:
            axes.plot(*np.transpose(dowels), "x", ms=6, color="black", zorder=7)


def plot_section(results, stage, path, whole=False):
    """False: there are none, or none yet."""
    anchors, mesh = results.stage(stage).anchors, results.mesh
    if anchors is None or all(STATES[state] == "absent" for state in anchors.state):
        return False
    box, names = box_of(mesh, anchors, whole), list(facts_of(results.stage_summary(stage)))
    figure, axes = pyplot.subplots(figsize=style.figure_size(box, height=6.5, extra=ROUND[0] + ROUND[2] - 0.6), layout="none")
    style.placed(figure, *ROUND)
    for row in np.unique(mesh.block_group):
        fill = style.FILLS[row % len(style.FILLS)]
        axes.add_collection(PolyCollection(mesh.rings()[mesh.block_group == row], facecolors=fill, edgecolors=fill, linewidths=0.3, alpha=0.6))
    axes.add_collection(LineCollection(mesh.vertices[mesh.outline()], colors="black", linewidths=0.6))
    norm = Normalize(min(anchors.force.min() / 1e3, 0), max(anchors.force.max() / 1e3, 1e-9))
    there = np.array([STATES[state] not in ("absent", "broken") for state in anchors.state])
    lines = np.stack([anchors.head, anchors.root], axis=1)
    axes.add_collection(LineCollection(lines[there], colors=FORCES(norm(anchors.force[there] / 1e3)), linewidths=2.6))
    axes.add_collection(LineCollection(lines[~there], colors=style.GREY, linewidths=1.4, linestyles=(0, (2, 3))))
    bars = results.stage(stage).bars
    if bars is not None:
        draw_diagrams(axes, bars, names, facts_of(results.stage_summary(stage)), box)
    axes.plot(*anchors.head.T, "s", ms=4, color="black", zorder=5)
    if len(anchors) <= MOST_NAMED:
        for row, order in enumerate(np.lexsort((anchors.head[:, 0], anchors.head[:, 1]))):
            force = sheet_units.said(style.plain(anchors.force[order] / 1e3), "kN") if there[order] else _(STATES[anchors.state[order]])
            axes.annotate(f"{names[order]}: {force}", anchors.head[order], (14, 6 + 13 * row), textcoords="offset points", fontsize=8,
                          arrowprops={"arrowstyle": "-", "lw": 0.5, "color": style.GREY}, bbox={"fc": "white", "ec": "none", "alpha": 0.8, "pad": 0.8})  # fmt: skip
    style.set_view(axes, box)
    style.bar_beside(figure, axes, ScalarMappable(norm, FORCES), _("force of one anchor [kN]"), ROUND[2])
    axes.set_ylabel("y [m]")
    axes.set_title(_("Stage {0}: anchors", stage) if bars is None else _("Stage {0}: anchors; in bonded bars up to {1} kN", stage, style.plain(np.abs(bars.force).max() / 1e3)))
    style.save(figure, path)
    return True


def plot_bars(results, stage, path):
    """Force and use of the bond over the distance from the head; False: no bar is bonded."""
    bars = results.stage(stage).bars
    if bars is None or not len(bars.anchor):
        return False
    facts = facts_of(results.stage_summary(stage))
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(9.5, 5.2), sharey=True)
    for row, name in enumerate(facts):
        at = bars.of(row)
        if not len(at):
            continue
        line = {"color": style.LINES[row % len(style.LINES)], "ls": ("-", "--", ":")[row // len(style.LINES) % 3], "lw": 1.5}
        left.plot(bars.force[at] / 1e3, bars.from_head[at], label=name, **line)
        right.plot(bars.bond_use[at], bars.from_head[at], **line)
        for dowel in facts[name].get("dowels", []):
            left.plot(np.interp(dowel["from_head"], bars.from_head[at], bars.force[at] / 1e3), dowel["from_head"], "x", color="black", ms=7, zorder=5)
    handles, labels = left.get_legend_handles_labels()
    if any(facts[name].get("dowels") for name in facts):
        handles.append(Line2D([], [], color="black", ls="none", marker="x", label=_("crosses a joint")))
    left.invert_yaxis()
    left.axvline(0, color=style.GREY, lw=0.8)
    right.axvline(1, color=style.GREY, lw=0.8, ls="--")
    left.set_ylabel(_("distance from the head [m]"))
    left.set_xlabel(_("force of one bar [kN], tension positive"))
    right.set_xlabel(_("bond over its strength [-]; 1: it slips"))
    right.set_xlim(left=0)
    for axes in (left, right):
        axes.grid(alpha=0.3)
    style.legend_below(figure, handles, 6)
    figure.suptitle(_("Stage {0}: bonded bars, largest force {1} kN", stage, style.plain(np.abs(bars.force).max() / 1e3)))
    style.save(figure, path)
    return True


def places_of(summary):
    """Words and members `anchors`, a place for each stage, or for each of its trials that was stable."""
    places = []
    for s in summary["stages"]:
        raised = s.get("flood") or s.get("load_factor")
        if raised:
            stable = sorted((t for t in raised["trials"] if t["outcome"] == "stable"), key=lambda t: t["value"])
            places += [(f"{s['name']} {numeral(format(t['value'], '.4g'))}", t.get("anchors") or {}) for t in stable]
        else:
            places.append((s["name"], s.get("anchors") or {}))
    return places


def plot_forces(results, path):
    places = places_of(results.summary)
    names = list(dict.fromkeys(name for _, found in places for name in found))
    if not names:
        return False
    figure, axes = pyplot.subplots(figsize=(max(6.0, 1.5 + 0.6 * len(places)), 4.2))
    for row, name in enumerate(names):
        forces = [found[name]["force"] / 1e3 if name in found and found[name]["state"] != "absent" else np.nan for _, found in places]
        axes.plot(forces, marker="o", ms=4, color=style.LINES[row % len(style.LINES)], ls=("-", "--", ":")[row // len(style.LINES) % 3], label=name)
    axes.set_xticks(range(len(places)), [words for words, _ in places], rotation=40, ha="right")
    axes.set_ylabel(_("force of one anchor [kN]"))
    low, high = axes.get_ylim()
    axes.set_ylim(min(0, low), max(0, high) + 0.12 * (max(0, high) - min(0, low)))
    axes.grid(alpha=0.3)
    axes.legend(frameon=False, ncols=min(4, len(names)))
    style.save(figure, path)
    return True


def plot_all(results, whole=False):
    """Writes the pictures there are; returns their paths."""
    def path(name):
        return os.path.join(results.folder, name + ".png")

    written = [path(f"anchors_{stage}") for stage in results.stages if plot_section(results, stage, path(f"anchors_{stage}"), whole)]
    written += [path(f"bars_{stage}") for stage in results.stages if plot_bars(results, stage, path(f"bars_{stage}"))]
    if plot_forces(results, path("anchor_forces")):
        written.append(path("anchor_forces"))
    return written
