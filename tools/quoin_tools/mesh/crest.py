"""Holds the crest of a dam of polygons together: by a coping over its whole width, or by bonded stones.

    tess, facing = coped(tess, facing, section, height, finest)
    edges = between_bodies(tess, edges, height)

All other stones stay where they are, so that the crest is the only thing that changes."""

import numpy as np
import shapely

from quoin_tools.mesh import polygons
from quoin_tools.mesh.blockmesh import MeshError

NEAR = 1e-9  # m: nodes that are one
WIDE = 0.7  # of the height of a coping: no piece of it is narrower


def coped(tess, facing, section, height, finest):
    """Returns the tessellation under a coping: one stone from face to face on a level bed. Stones that the bed cuts are tidied, with those next to them.

    finest: shortest side [m] and smallest area [m2] of what may be left of a stone."""
    level = section[:, 1].max() - height
    cap, bed = above(section, level)
    rings, shapes = tess.polygons(), [shapely.Polygon(xy) for xy in tess.polygons()]
    top = np.array([xy[:, 1].max() for xy in rings])
    cut = np.flatnonzero(top > level + NEAR)
    reached = {node for i in cut for node in tess.rings[i]}
    beside = [i for i in np.flatnonzero(top <= level + NEAR) if not reached.isdisjoint(tess.rings[i])]
    others = sorted(set(range(len(rings))) - set(cut) - set(beside))
    under = shapely.box(*(section.min(axis=0) - 1), section[:, 0].max() + 1, level)
    left = [polygons.ring_of(part) for i in cut for part in shapely.get_parts(shapely.intersection(shapes[i], under)) if part.area > NEAR]
    part = polygons.tessellation(left + [rings[i] for i in beside], fixed(tess, [*cut, *beside], others, section, bed, level))
    polygons.tidy(part, *finest)
    old = shapely.union_all([shapes[i] for i in np.flatnonzero(facing)])
    tidied = part.polygons()
    new = [shapely.Polygon(xy) for xy in tidied]
    outside = shapely.area(shapely.intersection(new, old)) > 0.5 * shapely.area(new)
    pieces = columns(cap, bed, np.concatenate(tidied), height)
    whole = polygons.tessellation([rings[i] for i in others] + tidied + pieces)
    return whole, np.concatenate([facing[others], outside, np.zeros(len(pieces), dtype=bool)])


def columns(cap, bed, nodes, height):
    """Returns the coping in upright pieces about as wide as high, which `between_bodies` joins to one body: cut where stones meet below it, so that its bed has no other nodes."""
    left, right = np.sort(bed[:, 0])
    at = np.unique(nodes[np.abs(nodes[:, 1] - bed[0, 1]) < NEAR, 0])
    cuts = []
    for x in at:
        if x - (cuts[-1] if cuts else left) > WIDE * height and right - x > WIDE * height:
            cuts.append(x)
    upright = [shapely.LineString([(x, cap[:, 1].min() - 1), (x, cap[:, 1].max() + 1)]) for x in cuts]
    parts = shapely.polygonize([shapely.union_all([shapely.Polygon(cap).exterior, *upright])])
    return [polygons.ring_of(part) for part in parts.geoms if shapely.Polygon(cap).contains(part.representative_point())]


def above(section, level):
    """Returns (ring of the part of a section above a level, the two ends of this part at the level)."""
    frame = shapely.box(section[:, 0].min() - 1, level, *(section.max(axis=0) + 1))
    found = shapely.intersection(shapely.Polygon(section), frame)
    xy = polygons.ring_of(found) if found.geom_type == "Polygon" else np.empty((0, 2))
    bed = xy[xy[:, 1] < level + NEAR]
    if len(bed) != 2:
        raise MeshError(f"coping: the section has no single bed at the level {level:g} m")
    return xy, bed


def fixed(tess, mine, others, section, bed, level):
    """Places that tidying leaves: the ends of the bed, corners of the section, nodes of stones that are not tidied."""
    own = {node for i in mine for node in tess.rings[i]}
    shared = own & {node for i in others for node in tess.rings[i]}
    corners = {node for node in own if np.hypot(*(section - tess.nodes[node]).T).min() < NEAR}
    places = tess.nodes[sorted(shared | corners)]
    return np.concatenate([bed, places[places[:, 1] < level - NEAR]])


def between_bodies(tess, edges, height):
    """Returns the edges that are joints where all stones with a centre in the uppermost `height` metres are one body, as the pieces of a coping are."""
    level = tess.nodes[:, 1].max() - height
    bonded = shapely.get_y(shapely.centroid([shapely.Polygon(xy) for xy in tess.polygons()])) > level
    owner = tess.owner
    return [(a, b) for a, b in edges if not (bonded[owner[a, b]] and bonded[owner[b, a]])]
