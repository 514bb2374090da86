"""Tells what kind of plane a base is: the contact of dam and ground, a lift of the dam, or a plane in the foundation.

    plane_of(case, name, path)      one of guidelines.PLANES; --plane says it where the blocks on both sides do not

The ground are the groups of blocks that supports hold whole, or by their faces; a support at a point, as of a dam's crest, makes no ground.
"""

import numpy as np
import shapely

from quoin_tools.assess.section_cut import GAP
from quoin_tools.mesh import blockmesh
from quoin_tools.mesh.supports import target_of


def held_by(case, name):
    """Tells of each block whether the support of this name holds it."""
    mesh, (kind, target) = case.mesh, target_of(case.mesh, name, case.scene.supports[name])
    if kind == "point":
        return (mesh.blocks == target).any(axis=1)
    blocks = target[:, 0] if kind == "faces" else target if kind == "group" else []
    return np.isin(np.arange(len(mesh.blocks)), blocks)


def ground(case):
    """Tells of each block whether its group is held by a support that is no point."""
    group, supports = case.mesh.block_group, case.scene.supports
    broad = [name for name, keys in supports.items() if target_of(case.mesh, name, keys)[0] != "point"]
    return np.isin(group, [row for name in broad for row in group[held_by(case, name)]])


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
