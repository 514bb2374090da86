"""Finds what a support of a scene holds in a mesh.

    kind, held = target_of(mesh, "rock", scene.supports["rock"])
"""

import numpy as np


def target_of(mesh, name, keys):
    """("faces", (n, 2) block and face), ("point", its vertex) or ("group", its blocks) of a support, in the order in which the solver looks; (None, name of the target) where the mesh has none."""
    target = keys.get("target") or name
    if target in mesh.face_sets:
        return "faces", mesh.face_sets[target]
    if target in mesh.points:
        return "point", mesh.points[target]
    if target in mesh.group_names:
        return "group", np.flatnonzero(mesh.block_group == mesh.group_names.index(target))
    return None, target
