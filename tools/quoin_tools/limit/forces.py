"""Computes the loads of a stage on each body of an assembly, as the gravity method does (assess/section_cut.py), each load by itself.

    loads = body_forces(mesh, scene, "water", parts)     name of the load: (n, 3) X, Y [N], M [N m] about the centres of the bodies
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import shapely

from quoin_tools.assess import section_cut
from quoin_tools.assess.joint_uplift import uplift_loads
from quoin_tools.limit import LimitError
from quoin_tools.limit.water import FLOWING
from quoin_tools.mesh.blockmesh import areas, closed_rings

WITHOUT_FORCE = ("added_mass", "temperature")  # no force on a body at rest as a whole
HEAVY = ("self_weight", "pseudo_static")


class BodyPart(section_cut.Part):
    """One body, seen as the part of a cut."""

    def __init__(self, mesh, mine):
        self.mesh, self.mine, self.share = mesh, mine, mine.astype(float)

    @cached_property
    def pieces(self):
        empty = shapely.from_wkt("POLYGON EMPTY")
        pieces = np.full(len(self.mine), empty, dtype=object)
        pieces[self.mine] = shapely.polygons(self.mesh.vertices[closed_rings(self.mesh)[self.mine]])
        return pieces

    @cached_property
    def region(self):
        region = shapely.union_all(self.pieces[self.mine])
        shapely.prepare(region)
        return region


@dataclass
class Known:
    """Data that do not change with the loads: bodies as parts of a cut, faces across the joints of uplifts."""

    bodies: dict = field(default_factory=dict)
    across: dict = field(default_factory=dict)


def body_forces(mesh, scene, stage, parts, only=None, known=None):
    """only: names of the loads to compute. known: data of earlier calls for this mesh."""
    forces, known = {}, known or Known()
    for name, load in scene.stage_loads(stage).items():
        if only is not None and name not in only:
            continue
        kind = load.get("type")
        if kind in FLOWING or kind in WITHOUT_FORCE:  # water.py has the pressures of a run
            continue
        if kind != "uplift" and kind not in section_cut.KINDS:
            raise LimitError(f"loads.{name}: a load of type {kind} is not known to limit analysis")
        total = inertia(mesh, scene, load, parts) if kind in HEAVY else np.zeros((parts.n, 3))
        for b in touched(mesh, load, parts):
            if b not in known.bodies:
                known.bodies[b] = BodyPart(mesh, parts.body == b)
            part = known.bodies[b]
            total[b] = about(parts.centre[b], pressed(mesh, scene, stage, name, part, known) if kind == "uplift" else section_cut.KINDS[kind](mesh, scene, load, part))
        forces[name] = total
    return forces


def inertia(mesh, scene, load, parts):
    """Computes weight or inertia forces of the blocks, for all bodies at once."""
    coefficient = np.array(load.get("coefficient", (0.0, -1.0)), dtype=float)
    weights = scene.gravity * scene.thickness * section_cut.densities(mesh, scene, load) * np.abs(areas(mesh))
    pieces = shapely.centroid(shapely.polygons(mesh.vertices[closed_rings(mesh)]))
    arm = np.column_stack([shapely.get_x(pieces), shapely.get_y(pieces)]) - parts.centre[parts.body]
    rows = weights[:, None] * np.column_stack([np.broadcast_to(coefficient, arm.shape), arm[:, 0] * coefficient[1] - arm[:, 1] * coefficient[0]])
    return np.column_stack([np.bincount(parts.body, rows[:, k], parts.n) for k in range(3)])


def touched(mesh, load, parts):
    """Returns the bodies on which a load may act, by faces or at a point; water in a joint acts on both sides of it."""
    if load.get("faces"):
        if load["faces"] not in mesh.face_sets:
            raise LimitError(f"the mesh has no face set '{load['faces']}'")
        own = set(parts.body[mesh.face_sets[load["faces"]][:, 0]].tolist())
        if load.get("crest") in mesh.face_sets:
            own |= set(parts.body[mesh.face_sets[load["crest"]][:, 0]].tolist())
        if load.get("type") != "uplift":
            return sorted(own)
        pairs = np.column_stack([parts.contacts.a, parts.contacts.b])
        return sorted(own | set(pairs[np.isin(pairs, list(own)).any(axis=1)].ravel().tolist()))
    if load.get("point"):
        if load["point"] not in mesh.points:
            raise LimitError(f"the mesh has no point '{load['point']}'")
        around = (mesh.blocks == mesh.points[load["point"]]).any(axis=1)
        return sorted(set(parts.body[around].tolist()))
    return [] if load.get("type") in HEAVY else range(parts.n)


def pressed(mesh, scene, stage, name, part, known):
    """Returns (X, Y, M) of an uplift on a body, along the joint as it is: a crack is not followed."""
    return sum((water.forces(water.chord, 0.0) * (scene.thickness / water.chord.thickness)
                for water in uplift_loads(mesh, scene, stage, part, known.across) if water.name == name), np.zeros(3))  # fmt: skip


def about(centre, force):
    """Moves a force system about the origin to a moment about a centre."""
    return force - np.array([0.0, 0.0, centre[0] * force[1] - centre[1] * force[0]])
