"""Composes a film: the section in each picture, its joints, its water, and charts over time below it."""

from dataclasses import dataclass, field

import numpy as np
from matplotlib import pyplot
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from quoin_tools.assess.surface import WATERS, level_at_faces
from quoin_tools.base.results import OPEN, SLIPPING
from quoin_tools.mesh.blockmesh import face_ends
from quoin_tools.show.plot_mesh import outline_width
from quoin_tools.show.plots import magnification
from quoin_tools.show.style import FILLS, GREY, LINES, figure_size, inside, legend_below, nice, plain, set_view, view

SLIPS, OPENS, WATER, WATER_FILL = "#d5006d", "#ff8c00", "#0b5fa5", "#cfe3f5"
SIDE = 1e-3  # horizontal part of a normal: water on faces flatter than this has no side
BEYOND = 0.1  # of the view: a model that goes on farther behind wet faces holds the water above it
ROW = 1.25  # [inch] of a course
NOTHING = 1e-6  # [m] slip and opening that are none
SEEN = 0.01  # of the largest opening in a film: joints that are open by less are drawn as closed
SWING = 0.05  # of the view: how far a mechanism moves


@dataclass
class Chart:
    """Lines over the time of the stage, below the section: (time, values, words, colour)."""

    label: str
    lines: list


@dataclass
class Film:
    """Displacements [m] are relative to the ground; joints: ends (n, 2, 2) of halves of contacts, and which of them are open, slip."""

    stage: str
    title: str  # with {time}
    mesh: object
    displacement: np.ndarray  # (pictures, vertices, 2)
    joints: list
    factor: float
    box: tuple
    time: np.ndarray | None = None
    water: list = field(default_factory=list)  # (level, vertices (n, 2) of the mesh of results, or of the places below, side)
    charts: list = field(default_factory=list)
    least: float = NOTHING  # [m] joints that are open by less are not drawn as open

    @property
    def n(self):
        return len(self.displacement)

    def open(self, speed):
        return Screen(self, speed)


# ---- of a stage in time


def ground_of(mesh):
    """Vertices at the bottom of the section: they are the ground that a film stands on."""
    y = mesh.vertices[:, 1]
    return np.flatnonzero(y <= y.min() + 1e-6 * max(np.ptp(y), 1e-9))


def halves(ends):
    """Lines (2 n, 2, 2) from ends (n, 2, 2) to the middles between them."""
    middle = ends.mean(axis=1)
    return np.stack([ends[:, 0], middle, middle, ends[:, 1]], axis=1).reshape(-1, 2, 2)


def joints_of(contacts, moved, factor, least):
    """Returns (open, slipping) halves of contacts [m]; open: by more than `least`."""
    ends = halves(contacts.point + factor * moved)
    is_open = (contacts.state & OPEN).ravel() > 0
    slips = (contacts.state & SLIPPING).ravel() > 0
    return ends[is_open & (contacts.opening.ravel() > least)], ends[slips & ~is_open]


def slid(contacts, before):
    """Largest slip [m] since the stage began, where it has the contacts of before; else since the run began."""
    if not len(contacts):
        return 0.0
    same = before is not None and np.array_equal(contacts.face, before.face)
    return np.abs(contacts.slip - (before.slip if same else 0.0)).max()


def stage_film(results, scene, mesh, stage, shakings, most, scale, whole):
    names = [*results.frames(stage), stage]
    names = [names[i] for i in np.unique(np.linspace(0, len(names) - 1, min(most, len(names))).round().astype(int))]
    frames = [results.stage(name) for name in names]
    time = np.array([frame.time for frame in frames])
    bottom = ground_of(results.mesh)
    ground = np.array([frame.displacement[bottom].mean(axis=0) for frame in frames])
    moved = np.array([frame.displacement - base for frame, base in zip(frames, ground)], dtype=np.float32)
    factor, box = common_scale(results.mesh, moved, view(results.mesh, whole)[0], scale)
    earlier = scene.stages_before(stage) if stage in scene.stages else results.stages[: results.stages.index(stage)]
    before = results.stage(earlier[-1]).contacts if earlier else None
    slip = np.array([slid(frame.contacts, before) for frame in frames])
    opening = np.array([frame.contacts.opening.max(initial=0.0) for frame in frames])
    least = nice(max(NOTHING, SEEN * opening.max()))
    joints = [joints_of(frame.contacts, frame.contacts.displacement - base, factor, least) for frame, base in zip(frames, ground)]
    title = f"Stage {stage}: {{time}}\ndisplacements relative to the ground × {plain(factor)}"
    charts = ground_charts(shakings, time) + joint_charts(time, slip, opening)
    return Film(stage, title, results.mesh, moved, joints, factor, box, time, water_of(results, scene, mesh, stage), charts, least)


def common_scale(mesh, moved, box, scale):
    """Factor and view for all pictures: the least factor that one of them asks for."""
    chosen = [magnification(mesh, displacement, box) for displacement in moved]
    factor = scale or min(factor for factor, _ in chosen)
    if factor > 1:
        return factor, box
    boxes = np.array([box for _, box in chosen])
    return factor, (boxes[:, 0].min(), boxes[:, 1].max(), boxes[:, 2].min(), boxes[:, 3].max())


def ground_charts(shakings, time):
    """The records: the strongest along x and along y."""
    lines = []
    for axis, colour in zip("xy", (LINES[0], LINES[2])):
        mine = [shaking for shaking in shakings if shaking.direction == axis]
        if mine:
            strongest = max(mine, key=lambda shaking: shaking.record.pga)
            lines.append((strongest.record.t, strongest.record.a, strongest.words, colour))
    return [Chart("ground\n[m/s$^2$]", lines)] if lines else []


def joint_charts(time, slip, opening):
    lines = [(time, 1e3 * values, words, colour) for values, words, colour in ((slip, "largest slip", SLIPS), (opening, "largest opening", OPENS))
             if values.max() > NOTHING]  # fmt: skip
    return [Chart("joints\n[mm]", lines)] if lines else []


# ---- of a mechanism


def mechanism_film(results, scene, mesh, stage, most, whole):
    """There and back along the velocity of the failing trial."""
    box = view(results.mesh, whole)[0]
    size = max(box[1] - box[0], box[3] - box[2])
    there = np.linspace(0, 1, max(2, min(most, 40) // 2))
    swing = SWING * size * np.concatenate([there, there[::-1]])
    moved = (swing[:, None, None] * results.stage(stage).mechanism).astype(np.float32)
    none = np.zeros((0, 2, 2))
    return Film(stage, f"Stage {stage}: how it fails", results.mesh, moved, [(none, none)] * len(moved), 1.0, box, None,
                water_of(results, scene, mesh, stage))  # fmt: skip


# ---- water


def water_of(results, scene, mesh, stage):
    """Reservoirs of a stage: level, ends of wet faces as rows of the vertices of results (-1: not written) and where they are in the mesh."""
    found = []
    if mesh is None:
        return found
    row = np.full(len(mesh.vertices), -1)
    row[results.mesh.vertex_file] = np.arange(len(results.mesh.vertex_file))
    for load in scene.stage_loads(stage).values():
        if load.get("type") in WATERS and load.get("faces") in mesh.face_sets:
            ends = face_ends(mesh, mesh.face_sets[load["faces"]])
            found.append((level_at_faces(load), row[ends], mesh.vertices[ends]))
    return found


def edge(ends, vertices, box, right):
    """Returns the x to which the water reaches: the edge of the view, or of the model where it extends beyond the faces."""
    x, far = ends[..., 0], vertices[:, 0]
    if right:
        return min(box[1], far.max()) if far.max() > x.max() + BEYOND * (box[1] - box[0]) else box[1]
    return max(box[0], far.min()) if far.min() < x.min() - BEYOND * (box[1] - box[0]) else box[0]


def pools(water, vertices, displacement, box):
    """Quadrilaterals of water between wet faces and the edge of the view, and lines of the surface."""
    quads, surfaces = [], []
    for level, rows, places in water:
        ends = places + np.where(rows[..., None] >= 0, displacement[rows], 0.0)
        along = ends[:, 1] - ends[:, 0]
        normal = along[:, 1] / np.maximum(np.hypot(*along.T), 1e-300)
        wet = (ends[..., 1].min(axis=1) < level) & (np.abs(normal) > SIDE)
        if not wet.any():
            continue
        reach = edge(places[wet], vertices, box, normal[wet].sum() > 0)
        for a, b in ends[wet]:
            low, high = (a, b) if a[1] < b[1] else (b, a)
            if high[1] > level:
                high = low + (high - low) * (level - low[1]) / (high[1] - low[1])
            quads.append([low, high, (reach, high[1]), (reach, low[1])])
        crest = max((quad[1] for quad in quads[-int(wet.sum()) :]), key=lambda place: place[1])
        surfaces.append([(reach, level), (crest[0], level)])
    return quads, surfaces


# ---- on the screen


class Screen:
    """A figure whose parts are moved from picture to picture."""

    def __init__(self, film, speed):
        self.film, self.speed = film, speed
        width, height = figure_size(film.box, height=6.0)
        rows = len(film.charts)
        width = min(10.0, max(6.5, width))
        self.figure = pyplot.figure(figsize=(width, height + ROW * rows))
        grid = self.figure.add_gridspec(1 + rows, 1, height_ratios=[height, *[ROW] * rows])
        self.axes = self.figure.add_subplot(grid[0])
        self.section()
        self.markers = [self.chart(self.figure.add_subplot(grid[1 + i]), chart, i == rows - 1) for i, chart in enumerate(film.charts)]
        self.show(0)
        self.figure.canvas.draw()
        self.figure.set_layout_engine("none")

    def section(self):
        film, axes = self.film, self.axes
        mesh, box = film.mesh, film.box
        ring = mesh.rings()
        width = outline_width(ring[:, [0, 1]], 0.3, box, 4.5)
        edges = {"edgecolors": "#8a8a8a", "linewidths": width} if width else {"edgecolors": "face", "linewidths": 0.2}
        self.pool = axes.add_collection(PolyCollection([], facecolors=WATER_FILL, edgecolors=WATER_FILL, linewidths=0.4))
        self.surface = axes.add_collection(LineCollection([], colors=WATER, linewidths=1.4))
        self.groups = []
        for row in np.unique(mesh.block_group):
            mine = np.flatnonzero(mesh.block_group == row)
            self.groups.append((mine, axes.add_collection(PolyCollection(ring[mine], facecolors=FILLS[row % len(FILLS)], **edges))))
        self.outline = mesh.outline()
        ends = mesh.vertices[self.outline]
        thin = outline_width(ends, 0.8, box, 4.5)
        axes.add_collection(LineCollection(ends[inside(ends.mean(axis=1), box)], colors=GREY, linewidths=0.7 * thin, linestyles=(0, (4, 3))))
        self.edges = axes.add_collection(LineCollection(ends, colors="black", linewidths=thin))
        self.open = axes.add_collection(LineCollection([], colors=OPENS, linewidths=3.0, capstyle="round", zorder=4))
        self.slips = axes.add_collection(LineCollection([], colors=SLIPS, linewidths=3.0, capstyle="round", zorder=5))
        set_view(axes, box)
        axes.set_ylabel("y [m]")
        handles = [Line2D([], [], color=GREY, lw=1.0, ls=(0, (4, 3)), label="undeformed")]
        if any(len(part[0]) for part in film.joints):
            handles.append(Line2D([], [], color=OPENS, lw=3.0, label=f"open by more than {plain(1e3 * film.least)} mm"))
        if any(len(part[1]) for part in film.joints):
            handles.append(Line2D([], [], color=SLIPS, lw=3.0, label="slips"))
        if film.water:
            handles.append(Patch(facecolor=WATER_FILL, edgecolor=WATER, label="water"))
        legend_below(self.figure, handles, len(handles))

    def chart(self, axes, chart, last):
        """A marker that goes along."""
        time = self.film.time
        for t, values, words, colour in chart.lines:
            axes.plot(t, values, color=colour, lw=1.0, label=words)
        axes.set_xlim(0.0 if time[0] < 0.1 * time[-1] else time[0], time[-1] + 0.01 * np.ptp(time))
        axes.set_ylabel(chart.label)
        axes.grid(alpha=0.3)
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 0.95), ncols=4, fontsize=8, frameon=False, borderaxespad=0.1)
        axes.tick_params(labelbottom=last)
        if last:
            axes.set_xlabel("time [s]")
        dots = [axes.plot([], [], "o", ms=5, color=colour, zorder=6)[0] for *_, colour in chart.lines]
        return axes.axvline(time[0], color="black", lw=1.0), dots, chart

    def show(self, frame):
        film = self.film
        displacement = film.factor * film.displacement[frame]
        moved = film.mesh.vertices + displacement
        ring = film.mesh.rings(moved)
        for mine, collection in self.groups:
            collection.set_verts(ring[mine])
        self.edges.set_segments(moved[self.outline])
        self.open.set_segments(film.joints[frame][0])
        self.slips.set_segments(film.joints[frame][1])
        quads, surfaces = pools(film.water, film.mesh.vertices, displacement, film.box)
        self.pool.set_verts(quads)
        self.surface.set_segments(surfaces)
        if film.time is None:
            self.axes.set_title(film.title)
            return
        now = film.time[frame]
        pace = "" if abs(self.speed - 1) < 0.01 else f" (film: {plain(self.speed)} s in a second)"
        self.axes.set_title(film.title.format(time=f"t = {now:.2f} s{pace}"))
        for line, dots, chart in self.markers:
            line.set_xdata([now, now])
            for dot, (t, values, *_) in zip(dots, chart.lines):
                dot.set_data([now], [np.interp(now, t, values)])
