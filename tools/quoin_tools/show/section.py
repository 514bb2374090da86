"""Draws the section with its loads for the sheet: SVG of one stage."""

import io
from dataclasses import replace

import numpy as np
import shapely
from matplotlib import pyplot
from matplotlib.collections import LineCollection, PolyCollection

from quoin_tools.assess import section_cut
from quoin_tools.assess.strength import contacts_on
from quoin_tools.assess.surface import WATERS, level_at_faces
from quoin_tools.base import anchors, sheet_units
from quoin_tools.base.language import _, numeral
from quoin_tools.mesh import blockmesh
from quoin_tools.show import section_marks, style
from quoin_tools.show.stress import standing

WATER, WATER_FILL, UPLIFT, LOAD, WEIGHT = "#0b5fa5", "#cfe3f5", "#7a3e9d", "#b3261e", "#222222"
REACH = 0.15  # largest pressure, drawn, over the size of the view
LETTERS, MARGIN = 0.75, 0.7  # size on paper over that of the picture; [inch] of a picture beside its view
LEVEL = 1e-3  # horizontal part of a direction: water on faces flatter than this has no side
LABEL = {"fontsize": 9, "bbox": {"fc": "white", "ec": "none", "alpha": 0.85, "pad": 1.2}}


def arrow(axes, tail, head, colour):
    axes.annotate("", head, tail, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.6, "shrinkA": 0, "shrinkB": 0},
                  annotation_clip=False, zorder=6)  # fmt: skip


def force_text(name, force):
    size = np.hypot(*force[:2]) / 1e3
    return f"{name}  {sheet_units.said(style.plain(size), 'kN')}"


def draw_pressure(axes, segments, pressures, scale, fill, edge):
    """Quadrilaterals from faces outwards, as long as the pressure at their ends."""
    along = segments[:, 1] - segments[:, 0]
    outward = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
    tips = segments + scale * pressures[..., None] * outward[:, None]
    quads = np.concatenate([segments, tips[:, ::-1]], axis=1)
    axes.add_collection(PolyCollection(quads, facecolors=fill, edgecolors="none", alpha=0.75, zorder=3))
    axes.add_collection(LineCollection(tips, colors=edge, linewidths=1.0, zorder=4))
    return tips


def draw_water(axes, case, name, load, force, box, largest):
    """Pressure on the faces in view, level, resultant."""
    level = level_at_faces(load)
    segments, pressures = section_marks.wet_in_view(case, load, box)
    if not len(segments):
        return
    size = max(box[1] - box[0], box[3] - box[2])
    is_water = section_marks.is_water(load)
    colour = WATER if is_water else section_marks.SILT
    draw_pressure(axes, segments, pressures, REACH * size / largest, WATER_FILL if is_water else section_marks.SILT_FILL, colour)
    direction = force[:2] / np.hypot(*force[:2])
    x, y = segments[..., 0].mean(), segments[..., 1].mean()
    if abs(direction[0]) > LEVEL:
        y = (x * force[1] - force[2]) / force[0]
        side, top = box[0] if force[0] > 0 else box[1], segments.reshape(-1, 2)[segments[..., 1].argmax()]
        if is_water:  # silt is no level of water
            stands = float(load["level"]) if float(load.get("effective", 1.0)) < 1 else level  # of tailwater that is pushed away a part presses
            axes.plot([side, top[0]], [stands, stands], color=WATER, lw=1.4)
            axes.text(0.97 * side + 0.03 * top[0], stands, sheet_units.said(numeral(f"{stands:.2f}"), "m") if stands == level else _("{0:.2f} m, presses as {1:.2f} m", stands, level), color=WATER, va="bottom",
                      ha="left" if force[0] > 0 else "right", fontsize=9)  # fmt: skip
    arrow(axes, np.array([x, y]) - 1.1 * REACH * size * direction, (x, y), colour)
    words = force_text(name, force) + ("" if is_water else f" ({style.plain(float(load['density']))} kg/m³)")
    axes.annotate(words, np.array([x, y]) - 0.55 * REACH * size * direction, (0, 5), textcoords="offset points", color=colour, ha="center", va="bottom", zorder=7, **LABEL)


def draw_weight(axes, case, name, load, force, size):
    centres, areas = case.mesh.centres(), blockmesh.areas(case.mesh)
    weights = areas * section_cut.densities(case.mesh, case.scene, load)
    if weights.sum() <= 0 or not force[:2].any():
        return
    at = weights @ centres / weights.sum()
    box, groups = style.view(case.results.mesh)
    if not style.inside(at[None], box)[0]:  # most of it is rock far below: the weight of the part in view
        names = [case.results.mesh.group_names[row] for row in groups]
        mine = np.where(np.isin(case.mesh.block_group, [case.mesh.group_names.index(group) for group in names]), weights, 0.0)
        if mine.sum() <= 0:
            return
        at, force, name = mine @ centres / mine.sum(), np.array(force) * mine.sum() / weights.sum(), _("{0} of {1}", name, ", ".join(names))
    axes.plot(*at, "o", ms=4, color=WEIGHT, zorder=6)
    direction = force[:2] / np.hypot(*force[:2])
    arrow(axes, at, at + 0.16 * size * direction, WEIGHT)
    axes.annotate(force_text(name, force), at + 0.5 * abs(direction[0]) * 0.16 * size * direction, (5, 2), textcoords="offset points", zorder=7, **LABEL)  # an earthquake's beside its arrow


def draw_other(axes, case, name, load, force, size):
    """Tractions, forces at points and along lines: an arrow to the place of the faces that their resultant meets."""
    at = section_cut.meets(case.mesh, load, force)
    if at is None:
        return
    direction = force[:2] / max(np.hypot(*force[:2]), 1e-300)
    arrow(axes, at - 0.12 * size * direction, at, LOAD)
    axes.annotate(force_text(name, force), at - 0.12 * size * direction, (0, 3), textcoords="offset points", color=LOAD, ha="center", zorder=7, **LABEL)


def uplifts_of(case, found):
    """Diagrams below the base: words, segments (n, 2, 2) along it, pressures at their ends [Pa], colours: of the rule or load, and as computed."""
    base, hand, diagrams = found.base, found.governing, []
    if found.water is not None:
        crack = hand.reached if hand.crack is None else hand.crack
        x, head = found.water.line(crack if hand.crack_at == found.water.heel else 0.0)
        points, pressure = np.array([found.water.place(base, distance) for distance in x]), found.water.unit_weight * head
        diagrams.append((_("uplift ({0})  {1} kN", found.water.rule, style.plain(hand.uplift / 1e3)), np.stack([points[:-1], points[1:]], axis=1),
                         np.stack([pressure[:-1], pressure[1:]], axis=1), "#e7d6f2", UPLIFT))  # fmt: skip
    if found.computed is not None:
        flow = case.results.stage(found.stage).flow
        mine = contacts_on(found.path, flow)
        backwards = (flow.point[mine, 1] - flow.point[mine, 0]) @ base.along < 0
        segments, pressure = (np.where(backwards.reshape(-1, *[1] * (array.ndim - 1)), array[:, ::-1], array) for array in (flow.point[mine], flow.pressure[mine]))
        diagrams.append((_("uplift (computed)  {0} kN", style.plain(np.hypot(*found.computed[:2]) / 1e3)), segments, pressure, WATER_FILL, WATER))
    return [diagram for diagram in diagrams if len(diagram[2]) and diagram[2].max() > 0]


def draw_uplift(axes, case, found, size):
    """Uplift below the base, all to one scale, the larger one behind."""
    diagrams = sorted(uplifts_of(case, found), key=lambda diagram: -diagram[2].sum() / len(diagram[2]))
    largest = max((pressure.max() for _, _, pressure, *_ in diagrams), default=0.0)
    for row, (label, segments, pressure, fill, edge) in enumerate(diagrams):
        draw_pressure(axes, segments, pressure, 0.12 * size / largest, fill, edge)
        lowest = found.base.middle - found.base.normal * 0.12 * size * max(d[2].mean() for d in diagrams) / largest
        axes.text(*(lowest - [0, (0.035 + 0.045 * row) * size]), label, color=edge, ha="center", va="top", zorder=7, **LABEL)


def end_in_view(path, box, heel):
    """Returns the last place in view of a path, away from its heel; None: no place of the path is in view."""
    path = np.asarray(path) if heel == "start" else np.asarray(path)[::-1]
    seen = shapely.intersection(shapely.LineString(path), shapely.box(box[0], box[2], box[1], box[3]))
    lines = [np.array(piece.coords) for piece in shapely.get_parts(seen) if piece.length > 0]
    return lines[-1][-1] if lines else None


def draw_bases(axes, assessed, box, size):
    """Joints and paths that are assessed, their resultants and their cracks by the gravity method."""
    for found in assessed:
        base, hand = found.base, found.governing
        axes.plot(*found.path.T, color=LOAD if found.kind.startswith("joint") else "#009e73", lw=2.0, zorder=5)
        end = end_in_view(found.path, box, found.heel)
        if end is None:
            continue
        axes.annotate(found.name, end, (5, 4), textcoords="offset points", color=LOAD if found.kind.startswith("joint") else "#007a5a", zorder=7, **LABEL)
        if hand.crack:
            tip = base.at(hand.crack) if hand.crack_at == "start" else base.at(base.length - hand.crack)
            first = base.start if hand.crack_at == "start" else base.end
            axes.plot(*np.array([first, tip]).T, color="white", lw=2.6, ls=(0, (2, 2)), zorder=6)
        if hand.N > 0 and 0 < hand.resultant < base.length:
            force = -hand.N * base.normal + hand.T * base.along
            at = base.at(hand.resultant)
            arrow(axes, at - 0.11 * size * force / np.hypot(*force), at, LOAD)


def draw_anchors(axes, case, stage):
    """Lines from head to root, the redder the more they carry; force of one and per metre at the head."""
    table = case.results.stage(stage).anchors
    if table is None:
        return
    largest = max(np.abs(table.force).max(), 1e-300)
    for name, head, root, force, each, state in zip(anchors.facts_of(case.results.stage_summary(stage)), table.head, table.root, table.force,
                                                    table.per_metre(), table.state, strict=True):  # fmt: skip
        there = anchors.STATES[state] not in ("absent", "broken")
        colour = pyplot.get_cmap("plasma_r")(0.25 + 0.7 * abs(force) / largest) if there and force else "#777777"
        axes.plot(*np.array([head, root]).T, color=colour, lw=2.2, ls="-" if there else (0, (2, 3)), solid_capstyle="butt", zorder=8)
        axes.plot(*head, "s", ms=5, color=colour, zorder=8)
        words = f"{name}  {sheet_units.said(style.plain(force / 1e3), 'kN')} ({sheet_units.said(style.plain(each / 1e3), 'kN/m')})" if there else f"{name}  {_(anchors.STATES[state])}"
        axes.annotate(words, head, (10, 8), textcoords="offset points", color="#5a1a6b", zorder=9, **LABEL)


def shape_of(box, room):
    """Width and height [inch] of the drawing of a view; room: [mm] that it has on paper, on which its letters stay LETTERS of their size."""
    aspect = (box[1] - box[0]) / (box[3] - box[2])
    if room is None:
        return 8.2, min(8.2, max(4.0, 7.2 / aspect))
    width, height = (side / 25.4 / LETTERS for side in room)
    return min(width, aspect * (height - MARGIN) + MARGIN), min(height, (width - MARGIN) / aspect + MARGIN)


def filled(box, room):
    """A view that is as wide as its room on paper lets it be, so that labels have places beside the dam; at most by half of its height on each side."""
    if room is None:
        return box
    width, height = (side / 25.4 / LETTERS - MARGIN for side in room)
    more = min(0.5 * max(0.0, (box[3] - box[2]) * width / height - (box[1] - box[0])), 0.5 * (box[3] - box[2]))
    return (box[0] - more, box[1] + more, *box[2:])


def section_svg(case, stage, assessed, room=None):
    """Returns SVG text. assessed: bases of this stage; room [mm]: on paper, none: a whole page."""
    mesh = standing(case.results.mesh, case.results.stage(stage))
    box, _ = style.view(case.results.mesh)
    size = max(box[1] - box[0], box[3] - box[2])
    levels = [float(load["level"]) for load in case.scene.stage_loads(stage).values() if load.get("type") in WATERS]  # some stand above the crest
    box = (box[0] - 0.12 * size, box[1] + 0.10 * size, box[2] - 0.06 * size, max([box[3], *levels]) + 0.04 * size)
    box = filled(box, room)
    with pyplot.rc_context(style.STYLE | {"svg.fonttype": "path"}):
        figure, axes = pyplot.subplots(figsize=shape_of(box, room))
        for row in np.unique(mesh.block_group):
            fill = style.FILLS[row % len(style.FILLS)]
            axes.add_collection(PolyCollection(mesh.rings()[mesh.block_group == row], facecolors=fill, edgecolors=fill, linewidths=0.4))
        axes.add_collection(LineCollection(mesh.vertices[mesh.outline()], colors="black", linewidths=0.8))
        forces, _ = case.forces(stage)
        there, in_place = section_cut.standing(case.mesh, case.scene, stage)
        case = replace(case, mesh=there, scene=in_place)
        for name, force in forces.items():
            load = case.scene.stage_loads(stage)[name]
            if load["type"] in ("self_weight", "pseudo_static"):
                draw_weight(axes, case, name, load, force, size)
            elif load["type"] in WATERS:
                draw_water(axes, case, name, load, force, box, section_marks.largest_pressure(case, stage, box))
            else:
                draw_other(axes, case, name, load, force, size)
        draw_anchors(axes, case, stage)
        for found in assessed:
            draw_uplift(axes, case, found, size)
        draw_bases(axes, assessed, box, size)
        style.set_view(axes, box)
        axes.set_ylabel("y [m]")
        section_marks.draw_elevations(axes, mesh, box, assessed[0].heel if assessed else "start")
        section_marks.draw_drains(axes, case, stage, box)
        style.unit_axes(figure)
        style.number_axes(figure)
        section_marks.spread(figure, axes)
        buffer = io.StringIO()
        figure.savefig(buffer, format="svg", bbox_inches="tight", pad_inches=0.08, metadata={"Date": None})
        pyplot.close(figure)
    return buffer.getvalue()
