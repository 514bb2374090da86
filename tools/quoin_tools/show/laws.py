"""Draws blocks that yield or crack, for plots.py: only stages in which some have.

plastic_<stage>.png    plastic strain, one colour a block
cracks_<stage>.png     damage; width of the cracks that are open now, each drawn along the way it runs
"""

import os

import numpy as np
from matplotlib import pyplot
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LogNorm, Normalize

from quoin_tools.base import sheet_units
from quoin_tools.base.language import _, numeral
from quoin_tools.base.laws import open_cracks
from quoin_tools.show.stress import outline_panels, standing
from quoin_tools.show.style import GREY, figure_size, inside, save, view

WHOLE = "#efece4"  # blocks that have neither yielded nor cracked
DECADES = 1e-3  # of the largest plastic strain: smaller strains have the lightest colour


def shown(mesh, values, box):
    """Blocks with a value above 0, and how many of them the picture does not hold."""
    with np.errstate(invalid="ignore"):
        some = values > 0
    outside = some & ~inside(mesh.centres(), box)
    return some, int(outside.sum())


def panel(axes, mesh, values, box, norm, colours, unit):
    """Blocks coloured by a value; the largest has a ring, wherever it is."""
    some, outside = shown(mesh, values, box)
    axes.add_collection(PolyCollection(mesh.rings()[~some], facecolors=WHOLE, edgecolors=WHOLE, linewidths=0.3))
    drawn = PolyCollection(mesh.rings()[some], array=values[some], cmap=colours, norm=norm, edgecolors="face", linewidths=0.3)
    axes.add_collection(drawn)
    bar = axes.figure.colorbar(drawn, ax=axes, shrink=0.85, aspect=28, pad=0.02)
    bar.ax.set_title(unit, fontsize=9, pad=10)
    if some.any():
        block = np.flatnonzero(some)[values[some].argmax()]
        x, y = mesh.centres()[block]
        for colour, thick in (("white", 3.0), ("black", 1.4)):
            axes.plot(x, y, "o", ms=9, mfc="none", mec=colour, mew=thick, zorder=6)
        axes.annotate(_("at ({0:.2f}, {1:.2f}) m", x, y) + ("\n" + _("{0} more outside the picture", outside) if outside else ""), (0.98, 0.98), xycoords="axes fraction",
                      ha="right", va="top", fontsize=8, color=GREY)  # fmt: skip
    return some


def largest(values, unit=""):
    most = np.nanmax(values, initial=0.0)
    text = numeral(f"{most:.3g}") if most > 0 else "0"
    return sheet_units.said(text, unit) if unit else text


def drawn_box(results, stage, values, whole):
    """Returns the view of the other pictures; the whole model where all values lie outside of it."""
    box, _ = view(results.mesh, whole)
    some, outside = shown(results.mesh, values, box)
    return view(results.mesh, True)[0] if some.any() and outside == some.sum() else box


def plot_plastic(results, name, path, whole=False):
    """False: no block has yielded."""
    mesh, stage = results.mesh, results.stage(name)
    strain = stage.plastic_strain
    if strain is None or not np.nanmax(strain, initial=0.0) > 0:
        return False
    box = drawn_box(results, name, strain, whole)
    figure, axes = pyplot.subplots(figsize=figure_size(box, height=5.8, extra=1.1))
    most = np.nanmax(strain)
    some = panel(axes, mesh, strain, box, LogNorm(DECADES * most, most, clip=True), "YlOrRd", "-")
    outline_panels([axes], standing(mesh, stage), box)
    axes.set_title(_("Stage {0} ({1}): plastic strain\nlargest {2} (ring), {3:.4g} m² have yielded", name, _(stage.verdict), largest(strain), mesh.areas()[some].sum()), fontsize=10)
    save(figure, path)
    return True


def crack_lines(mesh, stage):
    """Returns (n, 2, 2) the lines of open cracks in blocks that are mostly cracked, and these blocks."""
    length = open_cracks(mesh, stage)
    blocks = np.flatnonzero(length)
    half = 0.5 * length[blocks, None] * np.stack([-np.sin(stage.angle[blocks]), np.cos(stage.angle[blocks])], axis=1)
    centres = mesh.centres()[blocks]
    return np.stack([centres - half, centres + half], axis=1), length.sum()


def plot_cracks(results, name, path, whole=False):
    """False: no block has cracked."""
    mesh, stage = results.mesh, results.stage(name)
    if stage.damage is None or stage.crack_width is None or not np.nanmax(stage.damage, initial=0.0) > 0:
        return False
    box = drawn_box(results, name, stage.damage, whole)
    width = np.where(np.nan_to_num(stage.damage) > 0, 1e3 * stage.crack_width, 0.0)
    figure, (left, right) = pyplot.subplots(1, 2, figsize=figure_size(box, 2, height=5.8, extra=1.1), sharey=True)
    panel(left, mesh, stage.damage, box, Normalize(0, 1), "YlOrBr", "-")
    panel(right, mesh, width, box, Normalize(0, width.max() or 1.0), "YlGnBu", "mm")
    lines, length = crack_lines(mesh, stage)
    right.add_collection(LineCollection(lines, colors="black", linewidths=1.4, zorder=5))
    outline_panels([left, right], standing(mesh, stage), box)
    cracked = mesh.areas()[np.nan_to_num(stage.damage) > 0].sum()
    left.set_title(_("Stage {0} ({1}): damage\nlargest {2} (ring), {3:.4g} m² have some", name, _(stage.verdict), largest(stage.damage), cracked), fontsize=10)
    words = _("width of cracks now: largest {0} (ring)\nlines: open, damage above 0.5, {1:.4g} m together", largest(width, "mm"), length)
    right.set_title(words if width.any() else _("width of cracks now:\nall are closed"), fontsize=10)
    save(figure, path)
    return True


def plot_stage(results, stage, whole=False):
    """Writes the pictures there are of a stage; returns their paths."""
    pictures = ((plot_plastic, "plastic"), (plot_cracks, "cracks"))
    paths = [(plot, os.path.join(results.folder, f"{word}_{stage}.png")) for plot, word in pictures]
    return [path for plot, path in paths if plot(results, stage, path, whole)]
