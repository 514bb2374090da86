"""Defines the style of all pictures: colours, fonts, the part of the section that they show, numbers as words."""

import re

import matplotlib
import numpy as np
from matplotlib import pyplot
from matplotlib.axes._base import _AxesBase
from matplotlib.axis import Axis
from matplotlib.text import Text
from matplotlib.ticker import (
    Formatter,
    FuncFormatter,
    Locator,
    LogFormatter,
    LogLocator,
    MaxNLocator,
    ScalarFormatter,
)

from quoin_tools.base import language, sheet_units
from quoin_tools.base.files import save_figure
from quoin_tools.base.language import numeral

matplotlib.use("Agg")  # pictures go to files, there may be no screen

FILLS = ("#d9c8a9", "#b5c4cf", "#cfdcb4", "#e3c3c3", "#cfc4e0", "#c2ddd6")
LINES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")  # Okabe and Ito: colour-blind safe
TENSION, COMPRESSION, GREY = "#d55e00", "#0072b2", "#5a5a5a"
FORMULA = r"\mathdefault"  # powers of ten along an axis
DOMINANT = 2.0  # a group this many times larger than all others together is left out of the view
RIM = 0.01  # of a figure: left free round what is drawn
STYLE = {
    "font.family": "DejaVu Sans",  # comes with matplotlib, so no letter looks for another font
    "font.size": 10,
    "axes.titlesize": 11,
    "axes.labelsize": 10,
    "legend.fontsize": 9,
    "figure.dpi": 130,
    "figure.constrained_layout.use": True,
    "axes.titley": 1.0,  # no picture has ticks above, which titles would otherwise look for
}


def view(mesh, whole=False):
    """x_min, x_max, y_min, y_max [m], and the groups the picture is about.

    The largest group is left out when it dwarfs the others, they are together in one place, and deform.
    """
    groups = np.unique(mesh.block_group)
    area = np.bincount(mesh.block_group, mesh.areas(), minlength=len(mesh.group_names))
    rest = groups[groups != area.argmax()]
    low, high = corners_of(mesh, groups)
    margin = 0.08
    dwarfed = len(rest) and area.max() > DOMINANT * area[rest].sum()
    if not whole and dwarfed and not mesh.group_rigid[rest].all():
        part_low, part_high = corners_of(mesh, rest)
        if np.prod(part_high - part_low) < 0.5 * np.prod(high - low):
            low, high, groups, margin = part_low, part_high, rest, 0.16
    margin *= (high - low).max()
    return (low[0] - margin, high[0] + margin, low[1] - margin, high[1] + margin), groups


def corners_of(mesh, groups):
    """Lower left and upper right corner [m] of the box round some groups."""
    points = mesh.rings()[np.isin(mesh.block_group, groups)].reshape(-1, 2)
    return points.min(axis=0), points.max(axis=0)


def inside(points, box):
    return (
        (points[:, 0] > box[0]) & (points[:, 0] < box[1]) & (points[:, 1] > box[2]) & (points[:, 1] < box[3])
    )


class Few(MaxNLocator):
    """Places of the ticks of an axis: six spaces at most, fewer where their numbers would run into each other."""

    def __init__(self):
        super().__init__(6, steps=[1, 2, 5, 10])

    def tick_values(self, vmin, vmax):
        self.set_params(nbins=min(6, max(1, self.axis.get_tick_space())))
        return super().tick_values(vmin, vmax)


def set_view(axes, box):
    axes.set_xlim(box[0], box[1])
    axes.set_ylim(box[2], box[3])
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.xaxis.set_major_locator(Few())


def figure_size(box, panels=1, height=6.0, extra=0.0):
    """[inch] for panels of the shape of the view, side by side, each with room `extra` beside it."""
    width = (height - 1.4) * (box[1] - box[0]) / (box[3] - box[2]) + extra
    return min(18.0, max(5.5, panels * width + 0.6)), height


def placed(figure, left, below, right, above, apart=0.0):
    """Gives the panels of a figure without a layout engine their places: room [inch] at its edges, and between neighbours. An engine takes as long to find them as the drawing itself."""
    width, height = figure.get_size_inches()
    rows, columns = figure.axes[0].get_gridspec().get_geometry()
    across, up = width - left - right - (columns - 1) * apart, height - below - above - (rows - 1) * apart
    figure.subplots_adjust(left / width, below / height, 1 - right / width, 1 - above / height, wspace=apart * columns / across, hspace=apart * rows / up)


def bar_beside(figure, axes, drawn, label, right):
    """A bar of colours beside the one panel of a figure, with its view, that has room for it on the right [inch]."""
    width = figure.get_size_inches()[0]
    axes.set_anchor("E")  # next to the bar where the section is slender
    axes.apply_aspect()
    place = axes.get_position()
    figure.colorbar(drawn, cax=figure.add_axes([1 - (right - 0.2) / width, place.y0 + 0.15 * place.height, 0.2 / width, 0.7 * place.height]), label=label)


def nice(value):
    """The largest of 1, 2, 5, 10, 20, ... not above a value."""
    power = 10.0 ** np.floor(np.log10(value))
    return power * max(step for step in (1.0, 2.0, 5.0) if step * power <= value * (1 + 1e-12))


def plain(value):
    """Writes a number with thousands apart where there are five figures or more; four figures at least."""
    return numeral(f"{value:,.0f}".replace(",", "\u202f" if abs(value) >= 9999.5 else "") if abs(value) >= 1000 else f"{value:.4g}")


class Ticks(Formatter):
    """Labels along an axis, with numbers as the language writes them."""

    def __init__(self, inner):
        self.inner = inner

    def label(self, text):
        if FORMULA in text:
            return re.sub(r"\d+\.\d+", lambda found: numeral(found[0]).replace(",", "{,}"), text)
        return numeral(text)

    def __call__(self, value, position=None):
        return self.label(self.inner(value, position))

    def format_ticks(self, values):
        return [self.label(text) for text in self.inner.format_ticks(values)]

    def get_offset(self):
        return self.label(self.inner.get_offset())

    def set_locs(self, locs):
        self.inner.set_locs(locs)

    def set_axis(self, axis):
        super().set_axis(axis)
        self.inner.set_axis(axis)


def number_axes(figure):
    """Writes the numbers along the axes of a figure as the language writes them; names stay."""
    for axis in figure.findobj(Axis):
        for level in (axis.major, axis.minor):
            if isinstance(level.formatter, (ScalarFormatter, LogFormatter, FuncFormatter)):
                level.formatter = Ticks(level.formatter)
                level.formatter.set_axis(axis)


class InUnit(Locator):
    """Places of the ticks of an axis: round numbers in the unit shown."""

    def __init__(self, inner, size):
        self.inner, self.size = inner, size

    def set_axis(self, axis):
        super().set_axis(axis)
        self.inner.set_axis(axis)

    def __call__(self):
        return self.tick_values(*self.axis.get_view_interval())

    def tick_values(self, vmin, vmax):
        return np.asarray(self.inner.tick_values(vmin / self.size, vmax / self.size)) * self.size


def unit_axes(figure):
    """Gives axes with a unit their numbers in the unit shown, where it is not that of the data: the label of an axis has it, or the title over a bar of colours; y of a section has that of x."""
    below = getattr(figure, "_supxlabel", None)  # of all panels
    words, of_all = sheet_units.column(below.get_text()) if below else ("", None)
    if of_all:
        below.set_text(words)
    for axes in figure.findobj(_AxesBase):  # those beside others too
        bar_unit, x_unit = sheet_units.of(axes.title.get_text()), sheet_units.column(axes.get_xlabel())[1]
        for axis in (axes.xaxis, axes.yaxis):
            label, unit = sheet_units.column(axis.get_label_text())
            if unit:
                axis.set_label_text(label)
            elif not label:
                unit = of_all if axis is axes.xaxis else bar_unit or (x_unit if axes.get_aspect() == 1 else None)
            if unit and isinstance(axis.major.formatter, (ScalarFormatter, LogFormatter, FuncFormatter)):
                inner = LogLocator() if axis.get_scale() == "log" else Few()
                axis.set_major_locator(InUnit(inner, unit.size))
                axis.set_major_formatter(FuncFormatter(lambda value, _, size=unit.size: f"{round(value / size, 12) + 0.0:.6g}".replace("-", "\u2212")))
        if bar_unit:
            axes.set_title(bar_unit.name, fontsize=9, pad=10)
    for text in figure.findobj(Text) if sheet_units.current != sheet_units.SI else ():  # of legends
        text.set_text(sheet_units.column(text.get_text())[0])


def save(figure, path):
    """Writes a picture, and closes the figure. Two things make it fast: spines have no size of their own, for which each would look through all ticks; a rim is left free, so that the picture
    can be trimmed as an image where the layout is some pixels out."""
    if sheet_units.current != sheet_units.SI:
        unit_axes(figure)
    if language.current:
        number_axes(figure)
    for axes in figure.axes:
        axes.spines[:].set_in_layout(False)
    layout = figure.get_layout_engine()
    if layout and layout.get()["rect"] == (0, 0, 1, 1):
        layout.set(rect=(RIM, RIM, 1 - 2 * RIM, 1 - 2 * RIM))
    save_figure(figure, path, margin=0.12)
    pyplot.close(figure)


def legend_below(figure, handles, columns):
    """A legend below all panels, with room of its own."""
    columns, where = min(columns, len(handles)), "outside lower center"
    if matplotlib.__version_info__ < (3, 7):  # Debian 12
        share = (0.15 + 0.22 * -(-len(handles) // columns)) / figure.get_size_inches()[1]
        figure.get_layout_engine().set(rect=(0, share, 1, 1 - share))
        where = "lower center"
    figure.legend(handles=handles, loc=where, ncols=columns, frameon=False)
