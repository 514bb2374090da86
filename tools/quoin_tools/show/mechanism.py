"""Draws a failure mechanism: blocks moved along the velocity of the first failing trial of a stage."""

import os

import numpy as np
from matplotlib import pyplot
from matplotlib.collections import LineCollection, PolyCollection

from quoin_tools.base.language import _
from quoin_tools.show.style import STYLE, figure_size, inside, save, set_view, view


def draw_mechanism(axes, results, stage, share=0.05):
    """Blocks moved along the velocity of the first failing trial, the fastest one by `share` of the view; their collection."""
    mesh, velocity = results.mesh, results.stage(stage).mechanism
    box, _ = view(mesh)
    outline = mesh.vertices[mesh.outline()]
    axes.add_collection(LineCollection(outline[inside(outline.mean(axis=1), box)], colors="#b0b0b0", linewidths=0.5))
    if velocity is None:
        velocity = np.zeros_like(mesh.vertices)
    seen = inside(mesh.centres(), box)
    moved = mesh.vertices + share * max(box[1] - box[0], box[3] - box[2]) * velocity
    speed = np.hypot(*np.moveaxis(mesh.rings(velocity).mean(axis=1), 1, 0))
    cells = PolyCollection(mesh.rings(moved)[seen], array=speed[seen], cmap="YlOrRd", edgecolors="black", linewidths=0.3)
    cells.set_clim(0, 1)
    axes.add_collection(cells)
    set_view(axes, box)
    return cells


def plot_mechanisms(results):
    """Draws mechanism_<stage>.png of every stage in which a trial failed. Returns the paths."""
    written = []
    with pyplot.rc_context(STYLE):
        for stage in results.stages:
            if results.stage(stage).mechanism is None:
                continue
            figure, axes = pyplot.subplots(figsize=figure_size(view(results.mesh)[0], extra=1.2))
            cells = draw_mechanism(axes, results, stage)
            axes.set_ylabel("y [m]")
            axes.set_title(_("Stage {0}: how it fails", stage))
            figure.colorbar(cells, ax=axes, label=_("velocity [-], the fastest vertex 1"))
            written.append(os.path.join(results.folder, f"mechanism_{stage}.png"))
            save(figure, written[-1])
    return written
