"""Tells what kind of plane a base is: the contact of dam and ground, a lift of the dam, or a plane in the foundation.

    plane_of(case, name, path)      one of guidelines.PLANES; --plane says it where the blocks on both sides do not

The ground are the groups of blocks that supports hold.
"""

import numpy as np
import shapely

from quoin_tools.assess.section_cut import GAP
from quoin_tools.mesh import blockmesh


def held_by(case, name):
    """Tells of each block whether the support of this name holds it."""
    target, mesh = case.scene.supports[name].get("target") or name, case.mesh
    if target in mesh.face_sets:
        return np.isin(np.arange(len(mesh.blocks)), mesh.face_sets[target][:, 0])
    if target in mesh.points:
        return (mesh.blocks == mesh.points[target]).any(axis=1)
    return mesh.block_group == (mesh.group_names.index(target) if target in mesh.group_names else -1)


def ground(case):
    """Tells of each block whether its group is held by a support."""
    group = case.mesh.block_group
    return np.isin(group, [row for name in case.scene.supports for row in group[held_by(case, name)]])


def plane_of(case, name, path):
    """Returns the kind of a base by the blocks above and below it that touch it."""
    if name in case.options.planes:
        return case.options.planes[name]
    if name not in case.planes:
        share, held = case.part(name, path).share, ground(case)
        touch = shapely.distance(shapely.polygons(case.mesh.vertices[blockmesh.closed_rings(case.mesh)]), shapely.LineString(path)) <= GAP
        above, below = (bool(held[touch & side].mean() > 0.5) if (touch & side).any() else False for side in (share > 0.5, share < 0.5))
        case.planes[name] = "foundation" if above and below else "contact" if above or below else "lift"
    return case.planes[name]
