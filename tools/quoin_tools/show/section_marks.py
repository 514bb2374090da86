"""Draws marks beside the loads of the section (section.py): elevations, drains; moves labels off each other."""

import numpy as np

from quoin_tools.assess import section_cut, surface
from quoin_tools.assess.joint_uplift import joined, joint_chord
from quoin_tools.base.language import _
from quoin_tools.show import style

DRAIN = "#0a7d4f"
LABEL = {"fontsize": 8, "bbox": {"fc": "white", "ec": "none", "alpha": 0.85, "pad": 1.0}}
WATER = 1000.0  # [kg/m3]
THIN_WATER = 0.05  # of that: what a load of type reservoir of another density stands for (silt) is no water
SILT, SILT_FILL = "#7a4f1d", "#e6d3b8"
APART = 4  # [px] between labels
FARTHEST = 9  # heights of a label: farther from its place it is not moved


def is_water(load):
    return abs(float(load["density"]) / WATER - 1) <= THIN_WATER


def wet_in_view(case, load, box):
    """Wet faces (n, 2, 2) of a reservoir in view, and density times depth at their ends."""
    segments = section_cut.wet_segments(case.mesh, load)
    pressures = float(load["density"]) * np.maximum(surface.level_at_faces(load) - segments[..., 1], 0.0)
    shown = (pressures.max(axis=1, initial=0.0) > 0) & style.inside(segments.mean(axis=1), box)
    return segments[shown], pressures[shown]


def largest_pressure(case, stage, box):
    """Density times depth, over all reservoirs of a stage: they are drawn to one scale."""
    loads = [load for load in case.scene.stage_loads(stage).values() if load.get("type") in surface.WATERS]
    return max((wet_in_view(case, load, box)[1].max(initial=0.0) for load in loads), default=0.0)


def draw_elevations(axes, mesh, box, heel="start"):
    """Marks the highest and lowest elevation of the groups in view, at the side downstream; y of the mesh [m]. heel: end of the base at which the water stands."""
    low, high = style.corners_of(mesh, style.view(mesh)[1])
    side, onward = (box[1], -1) if heel == "start" else (box[0], 1)
    onward *= box[1] - box[0]
    for y, words in ((high[1], _("crest {0:.2f} m", high[1])), (low[1], _("lowest {0:.2f} m", low[1]))):
        axes.plot([side + 0.16 * onward, side], [y, y], color=style.GREY, lw=0.8, ls=(0, (6, 2, 1, 2)), zorder=5)
        axes.annotate(words, (side + 0.01 * onward, y), (0, 2), textcoords="offset points", color=style.GREY, ha="right" if heel == "start" else "left", va="bottom", zorder=7, **LABEL)


def drains_of(case, stage):
    """Name and ends (2, 2) of each drain of a stage; a drain of an uplift load is a place on its joint."""
    found = []
    for name, load in case.scene.stage_loads(stage).items():
        faces = load.get("faces") if load.get("type") == "uplift" else load.get("joint")
        distance = load.get("drain") if load.get("type") == "uplift" else load.get("distance") if load.get("type") == "drain" else None
        if distance is not None and faces in case.mesh.face_sets:
            place = joint_chord(case.mesh, case.scene, name, joined(case.mesh, case.mesh.face_sets[faces])[1]).at(float(distance))
            found.append((name, np.array([place, place])))
        elif load.get("type") == "drain" and load.get("from") and load.get("to"):
            found.append((name, np.array([load["from"], load["to"]], dtype=float)))
    return found


def draw_drains(axes, case, stage, box):
    for name, ends in drains_of(case, stage):
        if style.inside(ends, box).any():
            axes.plot(*ends.T, color=DRAIN, lw=1.8, ls=(0, (4, 2)), marker="o", ms=5, mfc="white", zorder=8)
            words = _("drain of {0}", name) if (ends[0] == ends[1]).all() else name
            axes.annotate(words, ends[0], (7, 4), textcoords="offset points", color=DRAIN, va="bottom", zorder=8, **LABEL)


# ---- labels


def overlap(a, b):
    """Tells whether two boxes [px] cover each other, or come closer than labels may."""
    return a.x0 < b.x1 + APART and b.x0 < a.x1 + APART and a.y0 < b.y1 + APART and b.y0 < a.y1 + APART


def places_round(height):
    """Shifts [px], the nearest first."""
    steps = np.arange(-FARTHEST, FARTHEST + 1)
    shifts = np.array([(2.0 * i * height, 0.55 * j * height) for i in steps for j in steps])
    return shifts[np.argsort(np.hypot(*shifts.T), kind="stable")]


def shift_text(text, shift, dpi):
    """Moves a label by [px], whether it stands at a place or beside one."""
    if getattr(text, "anncoords", None) == "offset points":
        text.set_position(np.array(text.get_position()) + np.array(shift) * 72 / dpi)
        return
    transform = text.get_transform()
    text.set_position(transform.inverted().transform(transform.transform(text.get_position()) + shift))


def along_arrows(axes):
    """Returns places (n, 2) [px] along the arrows of a picture, which labels should not cover."""
    ends = [axes.transData.transform([text.xy, text.xyann]) for text in axes.texts if getattr(text, "arrowprops", None) and not text.get_text()]
    return np.concatenate([a + np.linspace(0.0, 1.0, 15)[:, None] * (b - a) for a, b in ends]) if ends else np.zeros((0, 2))


def covers(box, places):
    return ((places > box.min) & (places < box.max)).all(axis=1).any()


def room_for(box, taken, inside, arrows):
    """The least shift [px] to where a label covers neither another one nor an arrow; no other label, where that cannot be."""
    for places in (arrows, np.zeros((0, 2))):
        for shift in places_round(box.height):
            there = box.translated(*shift)
            if inside.x0 <= there.x0 and there.x1 <= inside.x1 and inside.y0 <= there.y0 and there.y1 <= inside.y1 and not any(overlap(there, other) for other in taken) and not covers(there, places):
                return shift
    return np.zeros(2)


def spread(figure, axes):
    """Moves labels that would cover others or arrows to the nearest room within the picture; a thin line leads back from where one had to go far."""
    figure.canvas.draw()
    renderer, inside, taken, arrows = figure.canvas.get_renderer(), axes.get_window_extent(), [], along_arrows(axes)
    for text in [text for text in axes.texts if text.get_text()]:
        box = (text.get_bbox_patch() or text).get_window_extent(renderer)
        shift = room_for(box, taken, inside, arrows)
        there = box.translated(*shift)
        taken.append(there)
        if shift.any():
            shift_text(text, shift, figure.dpi)
            if np.hypot(*shift) > 1.6 * box.height:
                back = axes.transData.inverted()
                of = axes.transData.transform(text.xy) if hasattr(text, "xy") else 0.5 * (box.min + box.max)  # the marked point
                ends = [back.transform(place) for place in (of, np.clip(of, there.min, there.max))]
                axes.plot(*np.transpose(ends), color=text.get_color(), lw=0.6, zorder=6)
