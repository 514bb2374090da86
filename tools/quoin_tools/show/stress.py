"""Draws stress: principal stresses at the end of a stage as contours and as crosses, and their extremes over the time of a dynamic stage.

stress_<stage>.png     principal stresses
temperature_<stage>.png  change of temperature
envelope_<stage>.png   largest s1, least s2, least local failure factor over time
"""

from dataclasses import replace

import numpy as np
from matplotlib import pyplot
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from quoin_tools.base.language import _
from quoin_tools.show.plot_mesh import outline_width, silhouette
from quoin_tools.show.style import COMPRESSION, TENSION, figure_size, inside, placed, save, set_view, view

INSET = (0.43, 0.27)  # parts of width and height of a panel
CROSSES = 26  # along the longer side of the view
BESIDE = 0.95  # [inch] right of a panel, for its bar of colours
TITLED = 4.1  # [inch] of a panel with its bar, for the longest title: those of a slender section are apart
LEFT, RIGHT, BELOW, ABOVE = 0.7, 0.2, 0.6, 0.7  # [inch] round the three panels of principal stresses
FACTORS = (0, 0.5, 1, 1.5, 2, 3, 5, 10)  # contours of the least local failure factor
FACTOR_FILLS = ("#7f0000", "#d7301f", "#fc8d59", "#fdcc8a", "#c7e9b4", "#7fcdbb", "#41b6c4")  # red below 1


def standing(mesh, stage):
    """The mesh without the blocks that are not built yet."""
    if stage.built is None:
        return mesh
    there = stage.built > 0
    return replace(mesh, **{name: getattr(mesh, name)[there] for name in ("blocks", "block_group", "macroblock", "block_file", "rank")})


def drawn_outlines(mesh, moved, box, inches):
    """Outlines (n, 2, 2) of the bodies where they were and where they have moved; of bodies so small that their outlines
    would cover them, that of all together."""
    outline = mesh.outline()
    here, there = mesh.vertices[outline], moved[outline]
    if outline_width(here, 0.7, box, inches) == 0.7:
        return here, there
    alone = silhouette(here)
    return here[alone], there[alone]


def triangles(mesh, chosen):
    """Triangles (n, 3) of chosen blocks; a quadrilateral gives two."""
    blocks = mesh.blocks[chosen]
    four = blocks[blocks[:, 3] >= 0]
    return np.concatenate([blocks[:, :3], four[:, [0, 2, 3]]])


def at_vertices(mesh, values, chosen):
    """Mean over the chosen blocks round each vertex; joints have two vertices: nothing smears across."""
    blocks = mesh.blocks[chosen]
    used = blocks >= 0
    area = np.repeat(mesh.areas()[chosen][:, None], 4, axis=1)[used]
    weighted = np.repeat(values[chosen][:, None], 4, axis=1)[used] * area
    n = len(mesh.vertices)
    total = np.bincount(blocks[used], area, minlength=n)
    return np.bincount(blocks[used], weighted, minlength=n) / np.where(total > 0, total, 1.0)


def levels_of(values):
    """Contour levels over all but the most extreme values, with one at zero if zero is among them or near."""
    low, high = np.percentile(values, [0.5, 99.5])
    if not high - low > 1e-9 * max(abs(low), abs(high), 1e-9):
        low, high = low - 1e-3, high + 1e-3
    return MaxNLocator(12).tick_values(low, high)


def contour_panel(axes, mesh, values, chosen, box, kind):
    """Filled contours [MPa] of a field at block centres; s1 in two hues that meet at zero."""
    deformable = chosen & np.isfinite(values)
    field = at_vertices(mesh, np.nan_to_num(values), deformable) / 1e6
    corners = triangles(mesh, deformable)
    seen = np.unique(corners)
    levels = levels_of(field[seen[inside(mesh.vertices[seen], box)]])
    largest = np.abs(levels).max()
    norm = Normalize(-largest, largest) if kind == "s1" else Normalize(levels[0], levels[-1])
    colours = pyplot.get_cmap("RdYlBu_r" if kind == "s1" else "viridis")
    colours = colours.with_extremes(under=colours(norm(levels[0])), over=colours(norm(levels[-1])))
    grid = Triangulation(*mesh.vertices.T, corners)
    filled = axes.tricontourf(grid, field, levels=levels, norm=norm, extend="both", cmap=colours)
    bar = axes.figure.colorbar(filled, cax=axes.inset_axes([1.02, 0.075, 0.035, 0.85]))
    bar.ax.set_title("MPa", fontsize=9, pad=10)
    extreme_mark(axes, mesh, values, deformable, box, kind)


def whole_inset(axes, mesh, stage, kind, box):
    """The whole section with its rock, small in an upper corner that is free, in colours of its own range; a frame is what the picture shows."""
    values = getattr(stage, kind)
    there, left = np.isfinite(values), free_corner(mesh, box)
    if left is None or there.sum() == np.isfinite(values[np.isin(mesh.block_group, view(mesh)[1])]).sum():
        return  # no room, or the rock is rigid and has no stresses
    all_of_it = view(mesh, whole=True)[0]
    inset = axes.inset_axes([left, 1 - INSET[1] - 0.01, *INSET])
    low, high = np.percentile(values[there], [2, 98]) / 1e6
    inset.add_collection(PolyCollection(mesh.rings()[there], array=values[there] / 1e6, cmap="RdYlBu_r" if kind == "s1" else "viridis",
                                        norm=Normalize(-max(abs(low), abs(high)), max(abs(low), abs(high))) if kind == "s1" else Normalize(low, high), edgecolors="face", linewidths=0.2))  # fmt: skip
    inset.add_patch(Rectangle((box[0], box[2]), box[1] - box[0], box[3] - box[2], fill=False, ec="black", lw=0.8))
    inset.set_xlim(all_of_it[:2])
    inset.set_ylim(all_of_it[2:])
    inset.set_aspect("equal", anchor="NE")
    inset.set_xticks([])
    inset.set_yticks([])
    inset.set_xlabel(_("{0:.2f} to {1:.2f} MPa", low, high).replace("-", "−"), fontsize=7, labelpad=2)


def free_corner(mesh, box):
    """Returns the left end, as a part of the width, of an inset in an upper corner of the view that covers no block; None: there is none."""
    at = (mesh.vertices - [box[0], box[2]]) / [box[1] - box[0], box[3] - box[2]]
    low = 1 - INSET[1] - 0.09  # its words are below it
    for left in (1 - INSET[0] - 0.01, 0.01):
        if not ((at[:, 0] > left - 0.01) & (at[:, 0] < left + INSET[0] + 0.01) & (at[:, 1] > low) & (at[:, 1] < 1)).any():
            return left
    return None


def extreme_mark(axes, mesh, values, chosen, box, kind):
    """Ring at the block with the largest s1 or the least s2 in view; the number stands in the title."""
    centres = mesh.centres()
    candidates = np.flatnonzero(chosen & inside(centres, box))
    block = candidates[(np.argmax if kind == "s1" else np.argmin)(values[candidates])]
    for colour, width in (("white", 3.0), ("black", 1.4)):
        axes.plot(*centres[block], "o", ms=9, mfc="none", mec=colour, mew=width, clip_on=False, zorder=5)
    extreme = values[block] / 1e6
    axes.set_title((_("{0}: largest {1:+.3f} MPa (ring)", kind, extreme) if kind == "s1" else _("{0}: least {1:+.3f} MPa (ring)", kind, extreme)).replace("-", "−"))


def thinned(points, chosen, box):
    """At most one chosen point per cell of a grid over the view: the nearest to the middle of its cell."""
    size = max(box[1] - box[0], box[3] - box[2]) / CROSSES
    rows = np.flatnonzero(chosen & inside(points, box))
    at = (points[rows] - [box[0], box[2]]) / size
    cell = np.floor(at).astype(int)
    order = np.argsort(((at - cell - 0.5) ** 2).sum(axis=1), kind="stable")
    _, first = np.unique(cell[order], axis=0, return_index=True)
    return rows[order[first]], size


def cross_panel(axes, mesh, stage, chosen, box):
    """Principal stresses as crosses: length by size, colour by sign."""
    centres = mesh.centres()
    rows, size = thinned(centres, chosen & np.isfinite(stage.s1), box)
    largest = np.percentile(np.abs(np.concatenate([stage.s1[rows], stage.s2[rows]])), 98)
    scale = size / largest if largest > 0 else 0.0
    for values, turn in ((stage.s1[rows], 0.0), (stage.s2[rows], np.pi / 2)):
        angle = stage.angle[rows] + turn
        arm = (
            0.5
            * scale
            * np.clip(np.abs(values), 0, 1.3 * largest)[:, None]
            * np.c_[np.cos(angle), np.sin(angle)]
        )
        lines = np.stack([centres[rows] - arm, centres[rows] + arm], axis=1)
        colours = np.where(values > 0, TENSION, COMPRESSION)
        axes.add_collection(LineCollection(lines, colors=colours, linewidths=1.1))
    handles = [
        Line2D([], [], color=TENSION, label=_("tension")),
        Line2D([], [], color=COMPRESSION, label=_("compression")),
    ]
    axes.legend(handles=handles, loc="upper right", frameon=True, framealpha=0.9, handlelength=1.2)
    axes.set_title(_("Principal directions, longest {0:.2f} MPa", largest / 1e6))


def outline_panels(panels, mesh, box):
    """Bodies' outlines and the view, in all panels."""
    outline, _ = drawn_outlines(mesh, mesh.vertices, box, 4.2)
    for axes in panels:
        axes.add_collection(LineCollection(outline, colors="black", linewidths=0.6))
        set_view(axes, box)
    panels[0].set_ylabel("y [m]")


def plot_stress(results, name, path, whole=False):
    mesh, stage = results.mesh, results.stage(name)
    box, groups = view(mesh, whole)
    chosen = np.ones(len(mesh.blocks), dtype=bool) if whole else np.isin(mesh.block_group, groups)
    if not np.isfinite(stage.s1[chosen]).any():
        return False
    width, height = figure_size(box, 3, height=5.6, extra=BESIDE)
    figure, panels = pyplot.subplots(1, 3, figsize=(max(width, 3 * TITLED), height), sharey=True, layout="none")
    placed(figure, LEFT, BELOW, RIGHT, ABOVE, apart=BESIDE)
    for axes, kind in zip(panels, ("s1", "s2")):
        contour_panel(axes, mesh, getattr(stage, kind), chosen, box, kind)
    cross_panel(panels[2], mesh, stage, chosen, box)
    outline_panels(panels, standing(mesh, stage), box)
    for axes, kind in zip(panels, ("s1", "s2") if not chosen.all() else ()):
        whole_inset(axes, mesh, stage, kind, box)
    figure.suptitle(_("Stage {0} ({1}): principal stresses, tension positive", stage.name, _(stage.verdict)))
    save(figure, path)
    return True


def plot_temperature(results, name, path, whole=False):
    """Filled contours of the change of temperature; False where there is none."""
    mesh, stage = results.mesh, results.stage(name)
    box, groups = view(mesh, whole)
    if stage.temperature is None:
        return False
    chosen = np.isfinite(stage.temperature) & (whole | np.isin(mesh.block_group, groups))
    if not np.abs(stage.temperature[chosen]).max(initial=0.0):
        return False
    figure, axes = pyplot.subplots(figsize=figure_size(box, height=5.6, extra=BESIDE))
    rings = mesh.rings()[chosen]
    largest = np.abs(stage.temperature[chosen]).max()
    drawn = PolyCollection(rings, array=stage.temperature[chosen], cmap="RdBu_r", norm=Normalize(-largest, largest), edgecolors="face", linewidths=0.2)
    axes.add_collection(drawn)
    bar = figure.colorbar(drawn, ax=axes, shrink=0.85, aspect=28, pad=0.02)
    bar.ax.set_title("K", fontsize=9, pad=10)
    outline_panels([axes], standing(mesh, stage), box)
    axes.set_title(_("Stage {0}: change of temperature, {1:.3g} to {2:.3g} K", stage.name, stage.temperature[chosen].min(), stage.temperature[chosen].max()))
    save(figure, path)
    return True


# ---- envelope over the time of a dynamic stage


def factor_panel(axes, mesh, values, chosen, box):
    """Least local failure factor as filled contours."""
    known = chosen & ~np.isnan(values)
    field = at_vertices(mesh, np.nan_to_num(np.clip(values, 0, FACTORS[-1])), known)
    grid = Triangulation(*mesh.vertices.T, triangles(mesh, known))
    filled = axes.tricontourf(grid, field, levels=FACTORS, colors=FACTOR_FILLS)
    axes.figure.colorbar(filled, ax=axes, shrink=0.85, aspect=28, pad=0.02, ticks=FACTORS)
    candidates = np.flatnonzero(known & inside(mesh.centres(), box))
    if len(candidates):
        block = candidates[np.argmin(values[candidates])]
        axes.plot(*mesh.centres()[block], "o", ms=9, mfc="none", mec="black", mew=1.4, clip_on=False, zorder=5)
        axes.set_title(_("local failure factor: least {0:.2f} (ring)", values[block]))


def plot_envelope(results, name, path, whole=False):
    """Largest s1, least s2 and least local failure factor that blocks have had; False where the stage kept none."""
    mesh, stage = results.mesh, results.stage(name)
    box, groups = view(mesh, whole)
    chosen = np.ones(len(mesh.blocks), dtype=bool) if whole else np.isin(mesh.block_group, groups)
    kept = stage.envelope
    if kept is None or not np.isfinite(kept.s1_max[chosen]).any():
        return False
    factor = getattr(kept, "safety_factor_min", None)
    n = 2 + (factor is not None and bool((chosen & ~np.isnan(factor)).any()))
    figure, panels = pyplot.subplots(1, n, figsize=figure_size(box, n, height=5.6, extra=BESIDE), sharey=True)
    contour_panel(panels[0], mesh, kept.s1_max, chosen, box, "s1")
    contour_panel(panels[1], mesh, kept.s2_min, chosen, box, "s2")
    if n > 2:
        factor_panel(panels[2], mesh, factor, chosen, box)
    outline_panels(panels, mesh, box)
    figure.suptitle(_("Stage {0}: largest s1 and least s2 over time, {1} looks, one every {2} steps", stage.name, kept.samples, kept.every))
    save(figure, path)
    return True
