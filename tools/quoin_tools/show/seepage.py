"""Draws the water in joints, for plots.py: only stages in which water flows.

water_<stage>.png              pressures on the joints of the section, and how much flows through which joint
uplift_<joint>_<stage>.png     pressure along a joint that is a line, against the straight line between the heads of its ends
transient_<stage>.png          levels, force of the water in joints that are lines, and discharge over the time of a transient stage
"""

import os

import numpy as np
from matplotlib import pyplot
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from quoin_tools.assess.uplift import WATER as UNIT_WEIGHT
from quoin_tools.base import scene
from quoin_tools.base.flow import LITRES, STILL, at_end, facts_of
from quoin_tools.base.language import _, numeral
from quoin_tools.show import style
from quoin_tools.show.plot_mesh import outline_width, silhouette

WATER, DRY, UPLIFT, STRAIGHT = "#0b5fa5", "#9a8f80", "#7a3e9d", "#d55e00"
BLUES = LinearSegmentedColormap.from_list("water", ("#dcebf7", "#6fb0dd", "#0b5fa5", "#062d57"))
REACH = 0.13  # the largest pressure, drawn, over the size of the view
APART = 0.8  # the same, over the distance between joints
WIDEST, THINNEST, COVER = 5.0, 0.5, 0.4  # [pt] of the lines of discharge; the widest over the distance between joints
A_NET = 4.0  # length of joints, over the width of their extent, from which they are a net
INCHES = 4.5  # about the height of a panel
FLOWS, STANDS = 0.02, 1e-6  # of the largest discharge: less has no arrow; less is none
ARROWS = 18  # along the longer side of the view
WIDE = 1.25  # width over height of a view from which the panels stand one above the other
NAMED, IN_LINE = 6, 3  # heads and drains that are named with their discharge; of them in a line
AT_END = 1e-3  # [-] of a joint: water that ends so near to its end reaches it


# ---- the section


def box_of(mesh, flow, whole):
    """Returns the view of the other pictures, widened on each side by at most its own size to the joints in which water flows."""
    box, _ = style.view(mesh, whole)
    if whole:
        return box
    points = flow.point.reshape(-1, 2)
    low, high = np.array(box[::2]), np.array(box[1::2])
    margin = 0.03 * (high - low).max()
    lower = np.clip(points.min(axis=0) - margin, low - (high - low), low)
    upper = np.clip(points.max(axis=0) + margin, high, high + (high - low))
    return lower[0], upper[0], lower[1], upper[1]


def draw_body(axes, mesh, box):
    """Groups in light colours and their outlines; joints thin and grey."""
    rings = mesh.rings()
    for row in np.unique(mesh.block_group):
        fill = style.FILLS[row % len(style.FILLS)]
        axes.add_collection(PolyCollection(rings[mesh.block_group == row], facecolors=fill, edgecolors=fill, linewidths=0.3, alpha=0.45))
    outline = mesh.vertices[mesh.outline()]
    width = outline_width(outline, 0.5, box, 5.0)
    if width:
        axes.add_collection(LineCollection(outline, colors="#a8a8a8", linewidths=width))
    axes.add_collection(LineCollection(outline[silhouette(outline)], colors="black", linewidths=0.8))
    style.set_view(axes, box)


def seen_in(flow, box):
    """Rows of the pieces in view."""
    return np.flatnonzero(style.inside(flow.point.mean(axis=1), box))


def apart(flow, rows):
    """[m] How far joints are from each other where they are two sets all over the water; infinite where they are a few lines."""
    extent, length = np.ptp(flow.point[rows].reshape(-1, 2), axis=0), flow.length[rows].sum()
    return 2 * extent.prod() / length if length > A_NET * extent.max(initial=0.0) else np.inf


def longest_bar(flow, rows, box):
    """[m] How long the largest pressure is drawn."""
    return min(REACH * max(box[1] - box[0], box[3] - box[2]), APART * apart(flow, rows))


def widest_line(flow, rows, box, most, part):
    """[pt] Returns a width of at most a part of the distance between joints."""
    return min(most, part * apart(flow, rows) * 72.0 * INCHES / (box[3] - box[2]))


def bars(flow, rows, box):
    """Quadrilaterals (n, 4, 2) from joints downwards, or to the left, as high as the pressure at their ends."""
    ends = flow.point[rows]
    metres_per_pascal = longest_bar(flow, rows, box) / max(flow.pressure[rows].max(initial=0.0), 1e-300)
    along = ends[:, 1] - ends[:, 0]
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.maximum(np.hypot(*along.T), 1e-300)[:, None]
    up = (normal[:, 1] > 1e-6) | ((np.abs(normal[:, 1]) <= 1e-6) & (normal[:, 0] > 0))
    normal = np.where(up[:, None], -normal, normal)
    tips = ends + metres_per_pascal * flow.pressure[rows][..., None] * normal[:, None]
    return np.concatenate([ends, tips[:, ::-1]], axis=1)


def free_surface(flow):
    """Places (n, 2) where the pressure has come down to nothing in a piece that is wet below and not above."""
    low = np.argmin(flow.point[:, :, 1], axis=1)
    rows = np.arange(len(flow))
    below, above = flow.point[rows, low], flow.point[rows, 1 - low]
    rise = above[:, 1] - below[:, 1]
    reach = flow.pressure_head[rows, low]
    crosses = (rise > 1e-9) & (reach > 0) & (flow.pressure[rows, 1 - low] <= 0) & ~flow.wet()
    part = np.clip(reach[crosses] / rise[crosses], 0, 1)[:, None]
    return below[crosses] + part * (above - below)[crosses]


def room_for(flow, box):
    """The view with room for the bars."""
    points = np.concatenate([bars(flow, seen_in(flow, box), box).reshape(-1, 2), np.reshape(box, (2, 2)).T])
    (left, low), (right, high) = points.min(axis=0), points.max(axis=0)
    margin = 0.02 * (high - low)
    return left - margin * (left < box[0]), right, low - margin * (low < box[2]), high


def draw_surface(axes, flow, box):
    """Triangles at the free surface; their handle for the legend, if there are any."""
    places = free_surface(flow)
    places = places[style.inside(places, box)]
    if not len(places):
        return []
    marks = {"marker": "v", "markersize": 5.5, "markerfacecolor": "white", "markeredgecolor": WATER, "linestyle": "none"}
    axes.plot(*(places + [0, 0.006 * (box[3] - box[2])]).T, zorder=6, **marks)
    return [Line2D([], [], label=_("free surface"), **marks)]


def unit_weight(flow):
    """[N/m3] Returns the weight of the water, from pressures and heads; of clean water where there is no pressure."""
    heads = flow.pressure_head[flow.pressure > 0].sum()
    return flow.pressure.sum() / heads if heads > 0 else UNIT_WEIGHT


def draw_pressures(axes, flow, box):
    """Bars on the joints in view, in the colours of their pressure; handles of the legend."""
    rows, wet = seen_in(flow, box), flow.wet()
    largest = flow.pressure[rows].max(initial=0.0)
    width = widest_line(flow, rows, box, 0.9, 0.12)
    axes.add_collection(LineCollection(flow.point[rows][~wet[rows]], colors=DRY, linewidths=width, linestyles=(0, (3, 2)), zorder=3))
    axes.add_collection(LineCollection(flow.point[rows][wet[rows]], colors=WATER, linewidths=width, zorder=5))
    if largest > 0:
        filled = PolyCollection(bars(flow, rows, box), array=flow.pressure[rows].mean(axis=1) / 1e3, cmap=BLUES, norm=Normalize(0, largest / 1e3),
                                edgecolors="none", zorder=4)  # fmt: skip
        axes.add_collection(filled)
        axes.figure.colorbar(filled, ax=axes, shrink=0.85, aspect=28, pad=0.02, label=_("pressure [kPa]"))
    axes.set_title(_("pressure: longest bar {0} kPa, {1:.2f} m of water", style.plain(largest / 1e3), largest / unit_weight(flow)))
    handles = [Line2D([], [], color=WATER, lw=1.2, label=_("joint full of water"))]
    if not wet[rows].all():
        handles.append(Line2D([], [], color=DRY, lw=1.2, ls=(0, (3, 2)), label=_("not full, or cut off from every head")))
    return handles


def arrows(flow, rows, box):
    """Rows of the pieces with an arrow: that with the most water of each cell of a grid over the view."""
    rows = rows[np.abs(flow.discharge[rows]) > FLOWS * np.abs(flow.discharge).max()]
    size = max(box[1] - box[0], box[3] - box[2]) / ARROWS
    cell = np.floor((flow.point[rows].mean(axis=1) - [box[0], box[2]]) / size).astype(int)
    order = np.argsort(-np.abs(flow.discharge[rows]), kind="stable")
    _, first = np.unique(cell[order], axis=0, return_index=True)
    return rows[order[first]]


def draw_discharge(axes, flow, box):
    """Lines as wide as what flows, with arrows; handles of the legend."""
    rows = seen_in(flow, box)
    size = np.abs(flow.discharge) * LITRES
    largest = size[rows].max(initial=0.0)
    if largest < STILL * LITRES:
        axes.set_title(_("discharge: the water stands still"))
        axes.add_collection(LineCollection(flow.point[rows], colors=WATER, linewidths=THINNEST, zorder=4))
        return []
    axes.set_title(_("discharge in litres per minute and metre: widest line {0:.3g}", largest))

    widest = widest_line(flow, rows, box, WIDEST, COVER)
    thinnest = min(THINNEST, 0.3 * widest)

    def width(value):
        return thinnest + (widest - thinnest) * value / largest

    moves = rows[size[rows] > STANDS * largest]
    axes.add_collection(LineCollection(flow.point[np.setdiff1d(rows, moves)], colors=DRY, linewidths=thinnest, linestyles=(0, (1, 2)), zorder=3))
    axes.add_collection(LineCollection(flow.point[moves], colors=WATER, linewidths=width(size[moves]), capstyle="round", zorder=4))
    chosen = arrows(flow, rows, box)
    way = (flow.point[chosen, 1] - flow.point[chosen, 0]) * np.sign(flow.discharge[chosen])[:, None]
    way /= np.maximum(np.hypot(*way.T), 1e-300)[:, None]
    axes.quiver(*flow.point[chosen].mean(axis=1).T, *way.T, angles="xy", pivot="mid", units="inches", scale_units="inches", scale=8.0, width=0.02,
                headwidth=6, headlength=6, headaxislength=5.4, color="#062d57", zorder=6)  # fmt: skip
    handles = [Line2D([], [], color=WATER, lw=width(value), label=numeral(f"{value:g} l/(min m)"))
               for value in dict.fromkeys(style.nice(part * largest) for part in (1.0, 0.3, 0.1))]  # fmt: skip
    return handles + [Line2D([], [], color=DRY, lw=1.0, ls=(0, (1, 2)), label=_("no water moves"))] * (len(moves) < len(rows))


def what_flows(facts):
    """Discharge of heads and drains in lines, the largest first."""
    known = {name: c["discharge"] * LITRES for name, c in facts["conditions"].items() if abs(c["discharge"] or 0.0) >= STILL}
    names = sorted(known, key=lambda name: -abs(known[name]))
    words = [_("{0} takes {1:.3g}", name, known[name]) if known[name] > 0 else _("{0} gives {1:.3g}", name, -known[name]) for name in names[:NAMED]]
    words += [_("{0} more", len(names) - NAMED)] if len(names) > NAMED else []
    return [", ".join(words[i : i + IN_LINE]) for i in range(0, len(words), IN_LINE)]


def panels_of(box):
    """Two panels, side by side, or one above the other where the view is wide."""
    wide = (box[1] - box[0]) / (box[3] - box[2]) > WIDE
    width, height = style.figure_size(box, 1 if wide else 2, height=5.0 if wide else 6.8, extra=1.2)
    figure, panels = pyplot.subplots(*((2, 1) if wide else (1, 2)), figsize=(width, 2 * height if wide else height))
    for axes in panels if wide else panels[:1]:
        axes.set_ylabel("y [m]")
    return figure, panels


def plot_water(results, name, path, whole=False):
    """Pressure, and discharge. False for a stage without flow."""
    stage = results.stage(name)
    flow = stage.flow
    facts = facts_of(results.stage_summary(name))
    if flow is None or not facts:
        return False
    box = room_for(flow, box_of(results.mesh, flow, whole))
    figure, panels = panels_of(box)
    handles = {}
    for axes, draw in zip(panels, (draw_pressures, draw_discharge)):
        draw_body(axes, results.mesh, box)
        handles |= {handle.get_label(): handle for handle in draw(axes, flow, box) + draw_surface(axes, flow, box)}
    panels[1].set_title("\n".join([panels[1].get_title(), *what_flows(facts)]))
    style.legend_below(figure, [*handles.values()], 3)
    figure.suptitle(_("Stage {0} ({1}): water in joints, {2}", stage.name, _(stage.verdict), _(facts["state"])))
    style.save(figure, path)
    return True


# ---- uplift along a joint


def resultant(distance, pressure):
    """Force per metre of thickness [N/m] of straight pieces, and its distance from the start [m]."""
    length = np.diff(distance, axis=-1)[..., 0]
    force = (0.5 * length * pressure.sum(axis=-1)).sum()
    moment = (length * (distance[:, 0] * (2 * pressure[:, 0] + pressure[:, 1]) + distance[:, 1] * (pressure[:, 0] + 2 * pressure[:, 1])) / 6).sum()
    return force, moment / force if force > 0 else 0.0


def end_pressures(distance, pressure, length):
    """[Pa] at start and end of the joint; none where no water comes."""
    first = pressure[0, 0] if distance[0, 0] <= AT_END * length else 0.0
    last = pressure[-1, 1] if distance[-1, 1] >= (1 - AT_END) * length else 0.0
    return np.array([first, last])


def prescribed(results, stage, joint, length):
    """Diagrams of the stage's uplift loads on the joint: name, distance from the start [m], pressure [Pa]."""
    uplift = at_end(results.stage_summary(stage)).get("uplift", {})
    try:
        loads = scene.of_run(results.folder, results.summary).loads if uplift else {}
    except scene.SceneError:
        return []
    found = []
    for name, facts in uplift.items():
        if loads.get(name, {}).get("faces") != joint:
            continue
        distance, pressure = np.array(facts["diagram"], dtype=float).T
        if facts.get("heel", loads[name].get("heel")) == "end":
            distance, pressure = length - distance[::-1], pressure[::-1]
        found.append((name, distance, pressure))
    return found


def draw_line(axes, distance, pressure, words, thickness, **how):
    """A prescribed diagram with its force and centre in the legend."""
    force, centre = resultant(np.stack([distance[:-1], distance[1:]], axis=1), np.stack([pressure[:-1], pressure[1:]], axis=1))
    axes.plot(distance, pressure / 1e3, lw=1.6, label=_("{0}: {1} kN at {2:.2f} m", words, style.plain(force * thickness / 1e3), centre), **how)


def draw_uplift(axes, results, stage, joint, pieces, length):
    """Pressure as computed, as the straight line, and as prescribed, each with its force."""
    distance, pressure = pieces[:2]
    line = np.stack([distance, pressure / 1e3], axis=2)
    quads = np.concatenate([line * [1, 0], line[:, ::-1]], axis=1)
    axes.add_collection(PolyCollection(quads, facecolors="#cfe3f5", edgecolors="face", linewidths=0.3))
    axes.add_collection(LineCollection(line, colors=WATER, linewidths=2.0))
    force, centre = resultant(distance, pressure)
    label = _("computed: {0} kN at {1:.2f} m", style.plain(force * results.thickness / 1e3), centre)
    handle = Patch(facecolor="#cfe3f5", edgecolor=WATER, linewidth=1.5, label=label)
    draw_line(axes, np.array([0.0, length]), end_pressures(distance, pressure, length), _("straight line between the heads of the ends"),
              results.thickness, color=STRAIGHT, ls="--")  # fmt: skip
    for name, at, values in prescribed(results, stage, joint, length):
        draw_line(axes, at, values, _("prescribed, load {0}", name), results.thickness, color=UPLIFT, ls="-.")
    axes.axvline(centre, color=WATER, lw=0.9, ls=":")
    axes.legend(handles=[handle, *axes.get_legend_handles_labels()[0]], loc="lower left", bbox_to_anchor=(0.0, 1.02), frameon=False)


def plot_uplift(results, stage, joint, path):
    """False where no water flows in the joint, or where it is no line."""
    facts, flow = results.stage_summary(stage)["joints"].get(joint), results.stage(stage).flow
    row = results.mesh.joint_names.index(joint)
    if not facts or not facts["line"] or flow is None or not (flow.joint == row).any():
        return False
    start, end = (np.array([facts[at]["x"], facts[at]["y"]]) for at in ("start", "end"))
    pieces = flow.along(row, start, end)
    figure, (above, below) = pyplot.subplots(2, 1, figsize=(8.0, 6.4), sharex=True, height_ratios=(2.2, 1))
    draw_uplift(above, results, stage, joint, pieces, facts["chord"])
    above.set_ylabel(_("water pressure [kPa]"))
    above.set_ylim(bottom=0)
    metres = 1e3 / unit_weight(flow)
    above.secondary_yaxis("right", functions=(lambda kPa: kPa * metres, lambda m: m / metres)).set_ylabel(_("pressure head [m of water]"))
    below.add_collection(LineCollection(np.stack([pieces[0], pieces[2] * 1e3], axis=2), colors=style.LINES[2], linewidths=1.8))
    below.set_ylim(0, 1.1 * 1e3 * pieces[2].max())
    below.set_ylabel(_("aperture [mm]"))
    below.set_xlim(-0.02 * facts["chord"], 1.02 * facts["chord"])
    below.set_xlabel(_("distance along the joint from ({0:.2f}, {1:.2f}) m to ({2:.2f}, {3:.2f}) m [m]", *start, *end))
    for axes in (above, below):
        axes.grid(alpha=0.3)
    figure.suptitle(_("Joint {0}, stage {1}: water pressure; dotted: centre of the computed force", joint, stage), fontsize=11)
    style.save(figure, path)
    return True


# ---- history of a transient stage


def plot_transient(results, stage, path):
    """False for a stage without steps in time."""
    facts = results.stage_summary(stage)
    steps = facts.get("steps")
    if not steps:
        return False
    time = [step["value"] for step in steps]
    lines = {name for name, joint in facts["joints"].items() if joint["line"]}
    panels = (
        (_("level [m]"), "waters", "level", 1.0, None),
        (_("force of the water [kN]"), "joints", "uplift", 1e-3, lines),
        (_("leaves the joints\n[litres per minute and metre]"), "conditions", "discharge", LITRES, None),
    )
    figure, rows = pyplot.subplots(3, 1, figsize=(8.5, 7.5), sharex=True)
    for axes, (words, member, key, factor, chosen) in zip(rows, panels):
        for number, name in enumerate(name for name in facts_at(steps[-1], member) if chosen is None or name in chosen):
            values = [facts_at(step, member).get(name, {}).get(key) for step in steps]
            axes.plot(time, [np.nan if value is None else factor * value for value in values], marker=".", ms=3, lw=max(1.2, 3.0 - number), label=name,
                      color=style.LINES[number % len(style.LINES)], ls="-" if number < len(style.LINES) else "--")  # fmt: skip
        axes.set_ylabel(words)
        axes.grid(alpha=0.3)
        axes.margins(x=0.01)
        if axes.lines:
            axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    rows[-1].set_xlabel(_("time since the stage began [s]"))
    figure.suptitle(_("Stage {0} ({1}): water in joints, {2} steps", stage, _(facts["verdict"]), len(steps)), fontsize=11)
    figure.align_ylabels(rows)
    style.save(figure, path)
    return True


def facts_at(step, member):
    """Levels of the waters of a step, or a member of its flow."""
    return step.get("waters", {}) if member == "waters" else (step.get("flow") or {}).get(member, {})


def plot_stage(results, stage, whole=False):
    """Pictures of a stage; their paths."""

    def path(name):
        return os.path.join(results.folder, name + ".png")

    joints = facts_of(results.stage_summary(stage)).get("joints", {})
    written = [path(f"water_{stage}")] if plot_water(results, stage, path(f"water_{stage}"), whole) else []
    written += [path(f"transient_{stage}")] if plot_transient(results, stage, path(f"transient_{stage}")) else []
    return written + [path(f"uplift_{joint}_{stage}") for joint in joints if plot_uplift(results, stage, joint, path(f"uplift_{joint}_{stage}"))]
