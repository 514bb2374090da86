"""Decides which end of a joint is its heel: the end where the water stands, by the rules of the solver (src/water/heel.c).

    heel_of(mesh, scene, "uplift", ends)          "start" or "end" of the joint whose ends (2, 2) are given
    side_of(segments, level, ends)                the same of one water; None: nobody can tell, or it is dry
"""

import numpy as np
import shapely

from quoin_tools.assess.surface import WATERS
from quoin_tools.mesh.blockmesh import face_ends

ENDS = ("start", "end")
NEAR = 0.1  # of the length of the joint: distances from its ends that differ by less are the same


def wet(segments, level):
    """The parts of faces (n, 2, 2) that are below the water."""
    kept = []
    for a, b in np.asarray(segments, dtype=float):
        over = np.array([a[1], b[1]]) - level
        if (over >= 0).all():
            continue
        if (over > 0).any():
            crossing = a + (b - a) * over[0] / (over[0] - over[1])
            a, b = (crossing, b) if over[0] > 0 else (a, crossing)
        kept.append((a, b))
    return np.array(kept).reshape(-1, 2, 2)


def side_of(segments, level, ends):
    """Returns the end of a joint at which a water stands. segments: ends (n, 2, 2) of the faces on which it presses, counter-clockwise round their blocks; ends (2, 2)."""
    ends = np.asarray(ends, dtype=float)
    faces, chord = wet(segments, level), ends[1] - ends[0]
    length = np.hypot(*chord)
    if not len(faces):
        return None
    along, middle = faces[:, 1] - faces[:, 0], faces.mean(axis=1)
    sizes = np.hypot(*along.T)
    place = (sizes * ((middle - ends[0]) @ chord)).sum() / length / sizes.sum()
    if place < -1e-6 * length or place > (1 + 1e-6) * length:
        return ENDS[int(place > 0)]
    push = (level - middle[:, 1])[:, None] * np.column_stack([-along[:, 1], along[:, 0]])  # inward
    across, up = push.sum(axis=0)
    if abs(chord[0]) > NEAR * length and abs(across) > 0.5 * np.abs(push[:, 0]).sum() and abs(across) > 0.1 * abs(up):
        return ENDS[int((across > 0) != (chord[0] > 0))]
    far = shapely.distance(shapely.multilinestrings(faces), shapely.points(ends))
    return None if abs(far[0] - far[1]) < NEAR * length else ENDS[int(far[0] > far[1])]


def levels_at(mesh, loads, ends, kinds=WATERS):
    """Returns name and level of the highest water at each end that has one. loads: the loads of a stage."""
    found = {}
    for name, load in loads.items():
        if load.get("type") not in kinds or load.get("faces") not in mesh.face_sets:
            continue
        side = side_of(mesh.vertices[face_ends(mesh, mesh.face_sets[load["faces"]])], float(load["level"]), ends)
        if side and (side not in found or found[side][1] < float(load["level"])):
            found[side] = name, float(load["level"])
    return found


def missed(load, ends, levels, heel):
    """[m] Sums the differences between the heads of the waters and the heads of the uplift, if its heel is this end; for a drain the heads at the other end."""
    total = 0.0
    for k, side in enumerate(ENDS):
        head = max(0.0, levels[side][1] - ends[k][1]) if side in levels else 0.0
        if load.get("type") == "drain":
            total += head * (side != heel)
        elif side in levels:
            want = load["level"] if side == heel else load.get("tailwater")
            total += abs(head - (0.0 if want is None else max(0.0, float(want) - ends[k][1])))
    return total


def heel_of(mesh, scene, name, ends):
    """Returns the heel that the load names, else the end where the waters of its stages stand, else the start."""
    load = scene.loads[name]
    if load["heel"] != "auto":
        return load["heel"]
    kinds = (*WATERS, "head") if load.get("type") == "drain" else WATERS
    for stage in scene.stages.values():
        together = [other for other in stage.get("loads") or () if other in scene.loads]
        if name not in together:
            continue
        levels = levels_at(mesh, {other: scene.loads[other] for other in together}, ends, kinds)
        misses = [missed(load, ends, levels, side) for side in ENDS]
        if levels and abs(misses[0] - misses[1]) > 1e-9 * sum(misses):
            return ENDS[int(misses[1] < misses[0])]
    return "start"
