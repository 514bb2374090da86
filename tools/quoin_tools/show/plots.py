"""Draws pictures of the results of a run into its output folder.

    quoin show --pictures FOLDER [--whole]

mesh.png                    deformed blocks at the end of the last stage over their undeformed outline
stress_<stage>.png          principal stresses as contours, and as crosses
temperature_<stage>.png     change of temperature, where a load has changed it
plastic_<stage>.png         plastic strain of blocks that have yielded
cracks_<stage>.png          damage of blocks that have cracked, width of cracks
joint_<joint>_<stage>.png   stresses and opening along a joint, beside the gravity method without tension
mode_<k>_<stage>.png        shapes of the slowest free vibrations of a stage of type modes
history.png                 unbalanced ratio, displacement of named points, damping, over the cycles
water_<stage>.png           pressure and discharge of the water in joints, where it flows
uplift_<joint>_<stage>.png  its pressure along a joint against the straight line between the heads of its ends
transient_<stage>.png       levels, forces and discharge of the water in joints over the time of a transient stage
pushover_<stage>.png        force over displacement of a pushover
energy_<stage>.png          where the energy of a dynamic stage is, came from and went, over time
envelope_<stage>.png        largest s1, least s2 and least local failure factor over the time of a dynamic stage
time_<joint>_<stage>.png    forces, sliding factor, slip and opening of a joint over the time of a dynamic stage
shaking_<stage>.png         record, force of the supports and motion of points, over time
spectrum_<stage>.png        response spectra of the record and of the highest point, also as CSV

Where one group is much larger than the rest (the rock under a dam), pictures show the rest with a margin;
--whole shows all.
"""

import contextlib
import os
import sys
from functools import partial

import numpy as np
from matplotlib import pyplot
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from quoin_tools.base import language
from quoin_tools.base.command import Parser
from quoin_tools.base.language import N_, _
from quoin_tools.base.results import Results, ResultsError, trials_of
from quoin_tools.base.shared import sharing
from quoin_tools.show import anchor_pictures, laws, mechanism, modes, seepage, shaking
from quoin_tools.show.joints import plot_joint
from quoin_tools.show.plot_mesh import outline_width
from quoin_tools.show.pushover import plot_pushover
from quoin_tools.show.stress import drawn_outlines, plot_envelope, plot_stress, plot_temperature, standing
from quoin_tools.show.style import (
    COMPRESSION,
    FILLS,
    GREY,
    LINES,
    STYLE,
    figure_size,
    inside,
    legend_below,
    nice,
    placed,
    plain,
    save,
    set_view,
    view,
)

LOST = 1e9  # what is larger is not drawn: a displacement over the size of the model, a ratio, a displacement [m] in the history
FAR = 2.0  # views; blocks that have moved farther are drawn short, or they would leave nothing of the rest to see
NAME_ROWS = 3  # of names of stages above the histories
SHORTEST = 0.35  # of an even share: no stage is narrower on the axis of the histories
CROSSES = 26  # along the longer side of the view


# ---- deformed mesh


def magnification(mesh, displacement, box):
    """Factor of the displacements, and the view [m] for it.

    The largest displacement in view becomes about a twentieth of it. Blocks that move farther than that stand where they are, in a
    view that holds them: on the way there they would overlap. Only what has flown off by more than FAR views is drawn short."""
    seen = inside(mesh.vertices, box)
    largest = np.hypot(*displacement[seen].T).max(initial=0.0)
    size = max(box[1] - box[0], box[3] - box[2])
    factor = nice(0.06 * size / largest) if np.isfinite(largest) and largest > 0 else 1.0
    if factor >= 1.0 or largest > FAR * size:
        return factor, box
    moved, margin = (mesh.vertices + displacement)[seen], 0.04 * size
    low, high = moved.min(axis=0) - margin, moved.max(axis=0) + margin
    return 1.0, (min(box[0], low[0]), max(box[1], high[0]), min(box[2], low[1]), max(box[3], high[1]))


def plot_mesh(results, path, whole=False):
    stage = results.stage()
    mesh = standing(results.mesh, stage)
    factor, box = magnification(mesh, stage.displacement, view(mesh, whole)[0])
    moved = mesh.vertices + factor * stage.displacement
    figure, axes = pyplot.subplots(figsize=figure_size(box, height=6.5, extra=1.0))
    ring = mesh.rings(moved)
    width = outline_width(ring[:, [0, 1]], 0.3, box, 5.1)
    edges = {"edgecolors": "#8a8a8a", "linewidths": width} if width else {}
    handles = []
    for row in np.unique(mesh.block_group):
        fill = FILLS[row % len(FILLS)]
        axes.add_collection(PolyCollection(ring[mesh.block_group == row], facecolors=fill, **edges))
        name = _("{0} (rigid)", mesh.group_names[row]) if mesh.group_rigid[row] else mesh.group_names[row]
        handles.append(Patch(facecolor=fill, edgecolor="#8a8a8a", label=name))
    here, there = drawn_outlines(mesh, moved, box, 5.1)
    axes.add_collection(LineCollection(there, colors="black", linewidths=outline_width(there, 0.7, box, 5.1)))
    axes.add_collection(LineCollection(here, colors=COMPRESSION, linewidths=0.9, linestyles="--"))
    handles += [
        Line2D([], [], color="black", lw=0.9, label=_("deformed")),
        Line2D([], [], color=COMPRESSION, lw=0.9, ls="--", label=_("undeformed")),
    ]
    set_view(axes, box)
    axes.set_ylabel("y [m]")
    axes.set_title(_("Stage {0} ({1}): displacements × {2}", stage.name, _(stage.verdict), plain(factor)))
    legend_below(figure, handles, 4)
    save(figure, path)


# ---- history


def stage_spans(history):
    """Returns (name, first row, row after the last) of each stretch of one stage."""
    names = history["stage"]
    cuts = np.flatnonzero(names[1:] != names[:-1]) + 1
    starts = np.concatenate([[0], cuts])
    return [(names[a], a, b) for a, b in zip(starts, np.append(cuts, len(names)))]


def stage_axis(panels, history):
    """Prepares an axis over cycles on which every stage can be seen: as wide as it ran, at least SHORTEST; a line where it ends, its name above."""
    cycle, spans = history["cycle"], stage_spans(history)
    edges = np.array([cycle[0], *(cycle[after - 1] for _, _, after in spans)])
    widths = np.maximum(np.diff(edges) / max(edges[-1] - edges[0], 1e-300), SHORTEST / len(spans))
    places = np.concatenate([[0.0], np.cumsum(widths / widths.sum())])
    for axes in panels:
        axes.set_xscale("function", functions=(lambda x: np.interp(x, edges, places), lambda place: np.interp(place, places, edges)))
        axes.set_xlim(edges[0], max(edges[-1], edges[0] + 1))
        for end in edges[1:-1]:
            axes.axvline(end, color=GREY, lw=0.9, ls=":")
    even = MaxNLocator(6).tick_values(edges[0], edges[-1])
    panels[-1].set_xticks(ticks_with_room(edges, places) if len(spans) > 1 else even[(even >= edges[0]) & (even <= edges[-1])])
    panels[-1].xaxis.set_major_formatter(lambda value, place: plain(value))
    free = [-1.0] * NAME_ROWS
    for (name, *_rows), left, right in zip(spans, places, places[1:]):
        middle, half = 0.5 * (left + right), 0.006 * len(name) + 0.005
        row = next((row for row in range(NAME_ROWS) if middle - half >= free[row]), None)
        if row is not None:
            panels[0].text(middle, 1.03 + 0.11 * row, name, ha="center", va="bottom", transform=panels[0].transAxes)
            free[row] = middle + half


def ticks_with_room(edges, places):
    """Ends of stages whose numbers do not cover each other; the last one always."""
    kept = [0]
    for i in range(1, len(edges) - 1):
        if places[i] - places[kept[-1]] >= 0.09 and places[-1] - places[i] >= 0.09:
            kept.append(i)
    return edges[[*kept, len(edges) - 1]]


def moving_points(history):
    """Returns named points in the order of the file; at most as many as there are colours, those that move most."""
    points = [column[:-5] for column in history if column.endswith("_ux_m")]
    reach = [np.hypot(history[f"{p}_ux_m"], history[f"{p}_uy_m"]).max() for p in points]
    kept = np.argsort(reach, kind="stable")[::-1][: len(LINES)]
    return [points[i] for i in sorted(kept)]


def cut_runaway(axes, results):
    """Limits the axis where a body slides away, which would flatten the rest: it ends just beyond the bodies that stand."""
    history = results.history
    moving = [f"{p}_{x}_m" for p in moving_points(history) for x in ("ux", "uy")] or ["u_max_m"]
    values = 1e3 * np.array([history[column] for column in moving])
    held = [name for name in results.stages if results.stage(name).verdict in ("converged", "completed")]
    tried = [name for name in held if trials_of(results.stage_summary(name))]
    at_end = [after - 1 for name, first, after in stage_spans(history) if name in tried]  # of trials only where they ended
    kept = np.concatenate([values[:, np.isin(history["stage"], [name for name in held if name not in tried])], values[:, at_end]], axis=1)
    kept = kept[np.isfinite(kept)]
    finite = values[np.isfinite(values)]
    if not len(kept) or np.ptp(finite) <= 4 * np.ptp(kept):
        return
    room = 0.35 * np.ptp(kept)
    axes.set_ylim(kept.min() - room, kept.max() + room)
    axes.text(
        0.99,
        0.95,
        _("cut off: goes on to {0} mm", plain(finite[np.abs(finite).argmax()])),
        ha="right",
        va="top",
        transform=axes.transAxes,
        bbox={"fc": "white", "ec": "none", "alpha": 0.8},
    )


def one_after_another(history):
    """Cycles that run on where a stage goes back to the end of an earlier one, and the rows where it does."""
    cycle, back = np.array(history["cycle"], dtype=float), []
    for _name, first, _after in stage_spans(history)[1:]:
        if cycle[first] <= cycle[first - 1]:
            cycle[first:] += cycle[first - 1] - cycle[first] + np.diff(cycle[first : first + 2]).sum()
            back.append(first)
    return cycle, back


def plot_history(results, path):
    history = results.history
    if not len(history.get("cycle", ())):
        return False
    points = moving_points(history)
    cycles, back = one_after_another(history)
    history = {name: np.insert(np.where(np.abs(column) < LOST, column, np.nan), back, np.nan) if column.dtype.kind == "f" else column for name, column in history.items()}  # lines end where a stage goes back
    history |= {"cycle": np.insert(cycles, back, cycles[np.array(back, dtype=int) - 1] if back else []), "stage": np.insert(results.history["stage"], back, results.history["stage"][back] if back else [])}
    figure, panels = pyplot.subplots(3, 1, figsize=(8.5, 7.5), sharex=True, layout="none")
    cycle = history["cycle"]
    ratio = np.where(history["ratio"] > 0, history["ratio"], np.nan)
    panels[0].semilogy(cycle, ratio, color=LINES[0], lw=1.3)
    panels[0].set_ylabel(_("unbalanced ratio [-]"))
    for number, point in enumerate(points):
        colour = LINES[number % len(LINES)]
        panels[1].plot(cycle, 1e3 * history[f"{point}_ux_m"], color=colour, lw=1.4, label=f"{point} u_x")
        panels[1].plot(
            cycle, 1e3 * history[f"{point}_uy_m"], color=colour, lw=1.1, ls="--", label=f"{point} u_y"
        )
    if not points:
        panels[1].plot(cycle, 1e3 * history["u_max_m"], color=LINES[0], lw=1.4, label=_("largest"))
    panels[1].set_ylabel(_("displacement [mm]"))
    panels[1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    left_out = sum(column.endswith("_ux_m") for column in history) - len(points)
    if left_out:
        panels[1].get_legend().set_title(_("{0} points, {1} more that\nmove less left out", len(points), left_out))
    cut_runaway(panels[1], results)
    panels[2].plot(cycle, history["alpha_dt"], color=LINES[1], lw=1.2)
    panels[2].set_ylabel(_("damping α Δt [-]"))
    panels[2].set_ylim(bottom=0)
    panels[2].set_xlabel(_("cycles of all stages together, at their ends [-]") if back else _("cycle at the ends of stages [-]") if len(stage_spans(history)) > 1 else _("cycle [-]"))
    for axes in panels:
        axes.grid(alpha=0.3)
        axes.margins(x=0.01)
    stage_axis(panels, history)
    figure.align_ylabels(panels)
    place_history(figure, panels)
    save(figure, path)
    return True


def place_history(figure, panels):
    """Gives the panels room for the rows of names above them and for the legend beside them."""
    legend = panels[1].get_legend().get_window_extent().width / figure.dpi
    highest = max(name.get_position()[1] for name in panels[0].texts)  # [-] of the height of a panel, about 2.1 inches
    placed(figure, 0.9, 0.53, legend + 0.14, 0.3 + 2.1 * (highest - 1.0), apart=0.17)


# ---- energy of a dynamic stage


def plot_energy(results, stage, path):
    """False for a stage that has no account: one that is not dynamic."""
    history = results.history
    rows = history.get("stage") == stage if "balance_J" in history else np.zeros(0, dtype=bool)
    if not rows.any() or not np.isfinite(history["balance_J"][rows]).any():
        return False
    time = history["time_s"][rows]
    present = {"kinetic": N_("kinetic"), "strain": N_("strain of blocks"), "joints": N_("stored in joints")}
    flows = {"outside": N_("work of loads"), "supports": N_("work of moving supports"), "friction": N_("lost in joints"), "damping": N_("lost to damping"), "incoming": N_("brought by waves"),
             "radiated": N_("taken by waves"), "detection": N_("changed by verification"), "balance": N_("not accounted for")}  # fmt: skip
    figure, panels = pyplot.subplots(2, 1, figsize=(8.5, 6.4), sharex=True)
    for axes, names, title in zip(panels, (present, flows), (_("energy now [J]"), _("since the start [J]"))):
        for colour, (name, meaning) in zip(LINES, names.items()):
            if name in ("incoming", "radiated") and not history.get(f"{name}_J", np.zeros(1))[rows if f"{name}_J" in history else 0].any():
                continue
            axes.plot(time, history[f"{name}_J"][rows], color=colour, lw=1.4, label=_(meaning))
        axes.set_ylabel(title)
        axes.grid(alpha=0.3)
        axes.margins(x=0.01)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    panels[1].set_xlabel(_("time [s]"))
    figure.suptitle(_("Stage {0}: energy", stage))
    figure.align_ylabels(panels)
    save(figure, path)
    return True


# ---- command line


def in_sight(results, stage):
    """Tells whether a stage can be drawn. A stage that diverged may have displacements that are no numbers, or so large that nothing is left of the model."""
    size = np.ptp(results.mesh.vertices, axis=0).max()
    return bool(np.abs(results.stage(stage).displacement).max() < LOST * size)


def drawings(results, whole=False, shaken=None):
    """Returns functions that draw pictures; each returns the paths that it has written."""

    def path(name):
        return os.path.join(results.folder, name + ".png")

    def one(plot, name, *arguments):
        return lambda: [path(name)] if plot(results, *arguments) else []

    def stress_of(stage):
        found = [path(f"stress_{stage}")] if plot_stress(results, stage, path(f"stress_{stage}"), whole) else []
        return found + ([path(f"temperature_{stage}")] if plot_temperature(results, stage, path(f"temperature_{stage}"), whole) else [])

    def others_of(stage):
        found = laws.plot_stage(results, stage, whole) + seepage.plot_stage(results, stage, whole)
        found += [path(f"pushover_{stage}")] if plot_pushover(results, stage, path(f"pushover_{stage}")) else []
        found += [path(f"envelope_{stage}")] if plot_envelope(results, stage, path(f"envelope_{stage}"), whole) else []
        return found + ([path(f"energy_{stage}")] if plot_energy(results, stage, path(f"energy_{stage}")) else [])

    def mesh():
        plot_mesh(results, path("mesh"), whole)
        return [path("mesh")]

    tasks = [mesh]
    for stage in results.stages:
        if not in_sight(results, stage):
            continue
        if results.stage(stage).modes is not None:  # nothing else there differs from the stage before
            tasks.append(partial(modes.plot_modes, results, stage, whole))
            continue
        tasks.append(partial(stress_of, stage))
        for joint in results.stage_summary(stage)["joints"]:
            name = f"joint_{joint}_{stage}"
            tasks.append(one(plot_joint, name, stage, joint, path(name)))
        tasks.append(partial(others_of, stage))
    return [*tasks, partial(shaking.plot_stages, results, shaken), partial(anchor_pictures.plot_all, results, whole), partial(mechanism.plot_mechanisms, results), one(plot_history, "history", path("history"))]


@contextlib.contextmanager
def drawing(results, whole=False, shaken=None):
    """Draws every picture while this process does other work. Yields a function that waits for them and returns their paths. shaken: the dynamic stages of the run, where they are known already."""
    with pyplot.rc_context(STYLE), sharing(drawings(results, whole, shaken), language.current.missing if language.current else None) as found:
        yield lambda: [path for paths in found() for path in paths]


def plot_all(results, whole=False):
    """Writes every picture; returns their paths."""
    with drawing(results, whole) as paths:
        return paths()


def main(arguments=None):
    parser = Parser(
        prog="quoin show --pictures", description="Pictures of the results of a run."
    )
    parser.add_argument("folder", help="output folder of a run; pictures go there too")
    parser.add_argument(
        "--whole", action="store_true", help="show the whole model, also the large group (rock)"
    )
    options = parser.parse_args(arguments)
    try:
        print("\n".join(plot_all(Results(options.folder), options.whole)))
    except ResultsError as error:
        print(f"show: {error}", file=sys.stderr)
        return 2
    return 0
