"""Draws a block mesh: groups in colours, joints in bold, other face sets in colours, named points.

    quoin show model.h5 -o model.png --zoom -10 40 -10 40
"""

import sys

import matplotlib
import numpy as np
import shapely

from quoin_tools.base.command import Parser, words_of
from quoin_tools.base.files import save_figure
from quoin_tools.mesh.blockmesh import TOLERANCE, MeshError, check_blocks, closed_rings, face_ends, read

matplotlib.use("Agg")  # pictures go to files, there may be no screen
from matplotlib import pyplot  # noqa: E402
from matplotlib.collections import LineCollection, PolyCollection  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402

FILLS = ("#d9c8a9", "#b5c4cf", "#cfdcb4", "#e3c3c3", "#cfc4e0", "#c2ddd6")
LINES = ("#1f77b4", "#2ca02c", "#9467bd", "#17becf", "#e377c2", "#bcbd22", "#8c564b", "#ff7f0e")
JOINT = "#c01818"
COVER = 0.2  # part of a picture that outlines may cover: they get thinner
WIDTH = 0.35  # [pt] of outlines of blocks; where they are thinner, blocks are too small to be hatched
THINNEST = 0.08  # [pt] thinner ones are left out


def outline_width(ends, widest, box, inches):
    """[pt] of lines with these ends (n, 2, 2), so that they cover no more than COVER of what they lie in; 0: leave them out.

    box: x_min, x_max, y_min, y_max [m] of the picture, which is `inches` high."""
    middle = ends.mean(axis=1)
    seen = ends[(middle[:, 0] > box[0]) & (middle[:, 0] < box[1]) & (middle[:, 1] > box[2]) & (middle[:, 1] < box[3])]
    if not len(seen):
        return widest
    points = 72.0 * inches / (box[3] - box[2])  # a metre
    area = np.prod(np.ptp(seen.reshape(-1, 2), axis=0)) * points**2
    length = np.hypot(*(seen[:, 1] - seen[:, 0]).T).sum() * points
    width = min(widest, COVER * area / length) if length > 0 and area > 0 else widest
    return width if width >= THINNEST else 0.0


def silhouette(ends):
    """Selects the faces (n, 2, 2) on which no other face lies."""
    place = np.round(ends.mean(axis=1) / TOLERANCE).astype(np.int64)
    _, index, count = np.unique(place, axis=0, return_inverse=True, return_counts=True)
    return count[index.ravel()] == 1


def is_joint(mesh, rows):
    """A set with both sides of a joint: the middle of a face lies on another one that runs the other way."""
    ends = mesh.vertices[face_ends(mesh, rows)]
    tree = shapely.STRtree(shapely.linestrings(ends))
    one, two = tree.query(shapely.points(ends.mean(axis=1)), predicate="dwithin", distance=TOLERANCE)
    edge = ends[:, 1] - ends[:, 0]
    return bool(((edge[one] * edge[two]).sum(axis=1) < 0).any())


def draw(mesh, axes, zoom=None, names=True):
    """Draw the mesh on matplotlib axes; zoom: x_min, x_max, y_min, y_max [m]; names of points on request."""
    ring = mesh.vertices[closed_rings(mesh)]
    box, inches = limits(mesh, zoom), 7.0 * axes.get_position().height
    width = outline_width(ring[:, [0, 1]], WIDTH, box, inches)
    edges = {"edgecolors": "#6b6b6b", "linewidths": width} if width else {}
    handles = []
    for row, name in enumerate(mesh.group_names):
        fill = FILLS[row % len(FILLS)]
        hatch = "////" if mesh.group_rigid[row] and width == WIDTH else None
        mine = ring[mesh.block_group == row]
        axes.add_collection(PolyCollection(mine, facecolors=fill, hatch=hatch, **edges))
        label = f"{name} (rigid)" if mesh.group_rigid[row] else name
        handles.append(Patch(facecolor=fill, edgecolor="#6b6b6b", hatch=hatch, label=label))
    handles += draw_sets(mesh, axes, box, inches)
    axes.set_xlim(box[0], box[1])
    axes.set_ylim(box[2], box[3])
    if names:
        draw_points(mesh, axes)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.legend(handles=handles, loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=8, frameon=False)


def draw_sets(mesh, axes, box, inches):
    """Draws joints first and thick, so that a set of part of a joint shows on top of it."""
    joints = {name: is_joint(mesh, rows) for name, rows in mesh.face_sets.items()}
    handles, colour = [], 0
    for name in sorted(mesh.face_sets, key=lambda name: (not joints[name], name)):
        ends = mesh.vertices[face_ends(mesh, mesh.face_sets[name])]
        label = name if name.startswith("joint") else f"{name} (joint)"
        style = {"colors": JOINT, "linewidths": outline_width(ends, 2.4, box, inches), "label": label}
        if not joints[name]:
            style = {"colors": LINES[colour % len(LINES)], "linewidths": 1.6, "label": name}
            colour += 1
        lines = LineCollection(ends, capstyle="round", **style)
        axes.add_collection(lines)
        handles.append(Line2D([], [], color=style["colors"], lw=max(style["linewidths"], 1.2), label=label if joints[name] else name))
    return handles


def limits(mesh, zoom):
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    margin = 0.1 * (high - low).max()
    return zoom or (low[0] - margin, high[0] + margin, low[1] - margin, high[1] + margin)


def draw_points(mesh, axes):
    """Names at one place (both sides of a joint) share a label, on the outer side of points of its level."""
    places = {}
    for name, vertex in sorted(mesh.points.items()):
        places.setdefault(tuple(np.round(mesh.vertices[vertex], 6)), []).append(name)
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    for (x, y), names in places.items():
        if not (left <= x <= right and bottom <= y <= top):
            continue
        axes.plot(x, y, "o", color="black", markersize=3.5, zorder=5)
        level = [u for u, v in places if abs(v - y) < 0.05 * (top - bottom)]
        on_right = x > (np.mean(level) if len(level) > 1 else 0.5 * (left + right))
        axes.annotate("\n".join(names), (x, y), xytext=(4 if on_right else -4, 4), fontsize=7, zorder=6,
                      textcoords="offset points", ha="left" if on_right else "right",
                      bbox={"facecolor": "white", "alpha": 0.7, "edgecolor": "none", "pad": 0.6})


def plot(mesh, path, zoom=None, title=None, names=True):
    """Write the picture; its format follows from the name (png, pdf, svg)."""
    low, high = (np.array(zoom)[[0, 2]], np.array(zoom)[[1, 3]]) if zoom else (mesh.vertices.min(axis=0),
                                                                             mesh.vertices.max(axis=0))
    width, height = np.maximum(high - low, 0.1 * (high - low).max())
    figure, axes = pyplot.subplots(figsize=(9.0, np.clip(7.0 * height / width + 0.8, 2.5, 9.0)))
    draw(mesh, axes, zoom, names)
    if title:
        axes.set_title(title, fontsize=10)
    save_figure(figure, path, dpi=150, bbox_inches="tight")
    pyplot.close(figure)


def main(arguments=None):
    parser = Parser(prog="quoin show",
                                     description="Picture of a block mesh.")
    parser.add_argument("file")
    parser.add_argument("-o", "--output", required=True, help="picture to write (.png, .pdf, .svg)")
    parser.add_argument("--zoom", nargs=4, type=float, metavar=("XMIN", "XMAX", "YMIN", "YMAX"), help="[m]")
    parser.add_argument("--title")
    parser.add_argument("--no-names", action="store_true", help="leave the named points out")
    options = parser.parse_args(arguments)
    try:
        mesh = read(options.file)
        check_blocks(mesh)
        plot(mesh, options.output, options.zoom, options.title, not options.no_names)
    except (MeshError, OSError, ValueError) as error:
        print(words_of(error), file=sys.stderr)
        return 2
    print(f"wrote {options.output}")
    return 0
