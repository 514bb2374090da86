"""Writes a stage of a run as a drawing (DXF): bodies, joints by their state, anchors, the displaced section or the failure mechanism, each on a layer.

Lengths are in m, as the head of the drawing says. Layers: GROUP_<name>, JOINT_<name>, OPEN, SLIPPING, CRUSHED, ANCHORS, POINTS, DISPLACED or MECHANISM,
and NOTES: what is drawn, how much larger displacements are, those of the points."""

import io
import math
from collections import Counter

import numpy as np

from quoin_tools.base.anchors import facts_of
from quoin_tools.base.results import CRUSHING, OPEN, SLIPPING, VERTEX_FACE
from quoin_tools.show.style import view

SHARE = 0.05  # of the section that pictures show: how far the fastest vertex of a mechanism is drawn
COLOURS = {"OPEN": 1, "SLIPPING": 30, "CRUSHED": 6, "ANCHORS": 210, "POINTS": 3, "DISPLACED": 5, "MECHANISM": 1, "NOTES": 7}


def drawing(results, stage):
    """The drawing as text."""
    import ezdxf  # here: only drawings need it

    document = ezdxf.new(units=6)  # m
    space = document.modelspace()
    for name, colour in COLOURS.items():
        document.layers.add(name, color=colour)
    found, mesh = results.stage(stage), results.mesh
    for group, ring in rings_of(mesh):
        space.add_lwpolyline(mesh.vertices[ring].tolist(), close=True, dxfattribs={"layer": f"GROUP_{mesh.group_names[group]}"})
    draw_contacts(space, mesh, found.contacts)
    box, _ = view(mesh)
    size = max(box[1] - box[0], box[3] - box[2])
    draw_anchors(space, results, found, 0.01 * size)
    layer, factor, moved, words = motion_of(mesh, found, size)
    for _, ring in rings_of(mesh):
        space.add_lwpolyline((mesh.vertices[ring] + factor * moved[ring]).tolist(), close=True, dxfattribs={"layer": layer})
    probes = results.stage_summary(stage).get("probes", {})
    notes = [results.title, f"stage {stage}: {found.verdict}; lengths in m", words]
    notes += [f"{name}: u = ({1e3 * probe['u_x']:.4g}, {1e3 * probe['u_y']:.4g}) mm" for name, probe in probes.items()]
    draw_points(space, probes, 0.008 * size)
    for row, note in enumerate(notes):
        space.add_text(note, height=0.015 * size, dxfattribs={"layer": "NOTES"}).set_placement((box[1] + 0.05 * size, box[3] - (0.02 + 0.025 * row) * size))
    text = io.StringIO()
    document.write(text)
    return text.getvalue()


def motion_of(mesh, stage, size):
    """Returns (layer, factor, motion of the vertices, words) of the mechanism, or of the displacements where no trial failed; size: of the section."""
    if stage.mechanism is not None:
        return "MECHANISM", SHARE * size, stage.mechanism, f"MECHANISM: velocities of the failing trial, the fastest drawn as {SHARE * size:.3g} m"
    largest = np.hypot(*stage.displacement.T).max()
    factor = plain_factor(SHARE * size / largest) if largest > 0 else 1.0
    return "DISPLACED", factor, stage.displacement, f"DISPLACED: displacements {factor:g} times as large"


def plain_factor(value):
    """The largest of 1, 2, 5 times a power of ten that is not above a value."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(m * power for m in (1, 2, 5) if m * power <= value * (1 + 1e-9))


def rings_of(mesh):
    """Returns (group, ring of vertices) of the outlines of all bodies, group by group within a body; holes are rings of their own."""
    following = np.where(np.roll(mesh.blocks, -1, axis=1) < 0, mesh.blocks[:, :1], np.roll(mesh.blocks, -1, axis=1))
    edges = np.stack([mesh.blocks, following], axis=2).reshape(-1, 2)
    part = np.repeat(np.stack([mesh.macroblock, mesh.block_group], axis=1), mesh.blocks.shape[1], axis=0)
    real = (edges[:, 0] >= 0) & (edges[:, 0] != edges[:, 1])
    edges, part = edges[real], part[real]
    key = np.column_stack([part, np.sort(edges, axis=1)])
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    outer = np.sort(first[count == 1])
    ahead = {}
    for (body, group), (a, b) in zip(part[outer].tolist(), edges[outer].tolist()):
        ahead.setdefault((body, group, a), []).append(b)
    rings = []
    for start in list(ahead):
        while ahead.get(start):
            ring, at = [], start
            while ahead.get(at):
                ring.append(at[2])
                at = (*at[:2], ahead[at].pop())
            rings.append((start[1], ring))
    return rings


def draw_contacts(space, mesh, contacts):
    """Draws joints by name, and again on a layer of their state."""
    names = [*mesh.joint_names]
    for i in range(len(contacts)):
        if contacts.klass[i] == VERTEX_FACE:
            continue
        a, b = contacts.point[i].tolist()
        name = names[contacts.joint[i]] if 0 <= contacts.joint[i] < len(names) else "others"
        state = int(np.bitwise_or.reduce(np.atleast_1d(contacts.state[i])))
        layers = [f"JOINT_{name}", *(layer for layer, bit in (("OPEN", OPEN), ("SLIPPING", SLIPPING), ("CRUSHED", CRUSHING)) if state & bit)]
        for layer in layers:
            space.add_line(a, b, dxfattribs={"layer": layer})


def draw_anchors(space, results, stage, height):
    table = stage.anchors
    if table is None:
        return
    for name, head, root, force in zip(facts_of(results.stage_summary(stage.name)), table.head.tolist(), table.root.tolist(), table.force, strict=True):
        space.add_line(head, root, dxfattribs={"layer": "ANCHORS"})
        space.add_text(f"{name} {force / 1e3:.4g} kN", height=height, dxfattribs={"layer": "ANCHORS"}).set_placement(head)


def draw_points(space, probes, height):
    """Points with names, one above the other where they share a place."""
    taken = Counter()
    for name, probe in probes.items():
        place = (probe["x"], probe["y"])
        space.add_point(place, dxfattribs={"layer": "POINTS"})
        label = (place[0] + height, place[1] + (0.5 + 1.5 * taken[place]) * height)
        space.add_text(name, height=height, dxfattribs={"layer": "POINTS"}).set_placement(label)
        taken[place] += 1
