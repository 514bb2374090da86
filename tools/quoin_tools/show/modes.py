"""Draws free vibrations: the section moved by the shape of each mode."""

import os

import numpy as np
from matplotlib import pyplot
from matplotlib.collections import LineCollection, PolyCollection

from quoin_tools.base.language import _
from quoin_tools.base.modes import modes_of, number, parts
from quoin_tools.show.plot_mesh import outline_width
from quoin_tools.show.style import GREY, STYLE, figure_size, inside, save, set_view, view

MOST = 12  # pictures of a stage
SHARE = 0.08  # of the view that the largest displacement in it becomes


def title_of(s, mode, index):
    """Frequency, period and effective mass of a mode in words."""
    mass = ", ".join(_("{0:.0f} % along {1}", 100 * part, x) for part, x in zip(parts(s, mode), "xy", strict=True))
    return _("Stage {0}, mode {1}: f = {2} Hz, T = {3} s\nmodal mass {4}", s["name"], index + 1, number(mode["f"], ".4g"), number(mode["period"], ".4g"), mass)


def draw_mode(axes, results, shape, whole=False):
    """Blocks moved by a shape over where they are, their colour how far; their collection."""
    mesh = results.mesh
    box, _ = view(mesh, whole)
    size = np.hypot(*shape.T)
    largest = size[inside(mesh.vertices, box)].max(initial=0.0) or size.max(initial=0.0) or 1.0
    moved = mesh.vertices + SHARE * max(box[1] - box[0], box[3] - box[2]) / largest * shape
    ring = mesh.rings(moved)
    width = outline_width(ring[:, [0, 1]], 0.3, box, 5.1)
    cells = PolyCollection(ring, array=mesh.rings(size[:, None]).mean(axis=(1, 2)) / largest, cmap="YlGnBu",
                           **({"edgecolors": "#8a8a8a", "linewidths": width} if width else {"edgecolors": "face"}))  # fmt: skip
    cells.set_clim(0, 1)
    axes.add_collection(cells)
    outline = mesh.outline()
    for vertices, colour, style in ((mesh.vertices, GREY, "--"), (moved, "black", "-")):
        lines = vertices[outline]
        axes.add_collection(LineCollection(lines, colors=colour, linewidths=outline_width(lines, 0.7, box, 5.1), linestyles=style))
    ends = moved[inside(mesh.vertices, box)]
    low, high = (ends.min(axis=0), ends.max(axis=0)) if len(ends) else (box[::2], box[1::2])
    margin = 0.02 * max(box[1] - box[0], box[3] - box[2])
    set_view(axes, (min(box[0], low[0] - margin), max(box[1], high[0] + margin), min(box[2], low[1] - margin), max(box[3], high[1] + margin)))
    return cells


def plot_modes(results, stage, whole=False):
    """mode_<k>_<stage>.png of the slowest modes of a stage; their paths."""
    shapes, s, written = results.stage(stage).modes, results.stage_summary(stage), []
    with pyplot.rc_context(STYLE):
        for index, mode in enumerate(modes_of(s)[:MOST] if shapes is not None else []):
            figure, axes = pyplot.subplots(figsize=figure_size(view(results.mesh, whole)[0], extra=1.2))
            cells = draw_mode(axes, results, shapes[index], whole)
            axes.set_ylabel("y [m]")
            axes.set_title(title_of(s, mode, index), fontsize=10)
            figure.colorbar(cells, ax=axes, label=_("displacement [-], the largest in view 1"))
            written.append(os.path.join(results.folder, f"mode_{index + 1}_{stage}.png"))
            save(figure, written[-1])
    return written
