"""Computes the loads of a stage on each body of an assembly: forces on faces from the solver (assess/scene_loads.py), weight, inertia and forces at points.

    loads = body_forces(parts, scene, "water", table)     name of the load: (n, 3) X, Y [N], M [N m] about the centres of the bodies

table: FaceLoads of the stage; uplift presses along the joint as it is: a crack is not followed.
"""

import numpy as np

from quoin_tools.assess.section_cut import HEAVY, densities
from quoin_tools.base.language import _
from quoin_tools.limit import LimitError
from quoin_tools.limit.water import FLOWING
from quoin_tools.mesh.blockmesh import areas, closed_rings, cross

WITHOUT_FORCE = ("added_mass", "temperature")  # no force on a body at rest as a whole


def body_forces(parts, scene, stage, table):
    forces = {}
    for name, load in scene.stage_loads(stage).items():
        kind = load.get("type")
        if kind in FLOWING or kind in WITHOUT_FORCE:  # water.py has the pressures of a run
            continue
        if kind not in (*HEAVY, "point_force") and not load.get("faces"):
            raise LimitError(_("loads.{0}: a load of type {1} is not known to limit analysis", name, kind))
        forces[name] = inertia(parts, scene, load) if kind in HEAVY else np.zeros((parts.n, 3))
        if kind == "point_force":
            body, place = at_point(parts, load)
            force = scene.thickness * np.array(load["value"], dtype=float)
            forces[name][body] = [*force, cross(place - parts.centre[body], force)]
        elif load.get("faces") and load["faces"] not in parts.mesh.face_sets:
            raise LimitError(f"the mesh has no face set '{load['faces']}'")
        elif table is not None:
            forces[name] += on_bodies(parts, table.of(name))
    return forces


def on_bodies(parts, table):
    """Sums the rows of FaceLoads on each body."""
    body, systems = parts.body[table.face[:, 0]], table.systems()
    systems[:, 2] -= cross(parts.centre[body], systems[:, :2])
    return summed(parts, body, systems)


def summed(parts, body, rows):
    return np.column_stack([np.bincount(body, rows[:, k], parts.n) for k in range(3)])


def inertia(parts, scene, load):
    """Computes weight or inertia forces of the blocks."""
    mesh, coefficient = parts.mesh, np.array(load.get("coefficient", (0.0, -1.0)), dtype=float)
    weights = scene.gravity * scene.thickness * densities(mesh, scene, load) * np.abs(areas(mesh))
    arm = middles(mesh) - parts.centre[parts.body]
    return summed(parts, parts.body, weights[:, None] * np.column_stack([np.broadcast_to(coefficient, arm.shape), cross(arm, np.broadcast_to(coefficient, arm.shape))]))


def middles(mesh):
    """Returns the centroids (n_blocks, 2) of the blocks [m]."""
    ring = mesh.vertices[closed_rings(mesh)]
    arms = ring - ring[:, :1]
    double = cross(arms[:, :-1], arms[:, 1:])
    return ring[:, 0] + (double[:, :, None] * (arms[:, :-1] + arms[:, 1:])).sum(axis=1) / (3 * double.sum(axis=1))[:, None]


def at_point(parts, load):
    """Returns the body at the named point of a load, and the place of the point."""
    vertex = parts.mesh.points.get(load["point"])
    if vertex is None:
        raise LimitError(f"the mesh has no point '{load['point']}'")
    return parts.body[(parts.mesh.blocks == vertex).any(axis=1).argmax()], parts.mesh.vertices[vertex]
