"""Computes the forces on each body of an assembly from water that flows in joints, with the pressures of a run.

    found = of_run(results, "flood")          None: no water flows in this stage
    found.forces(parts)                       (n, 3) X, Y [N], M [N m] about the centres of the bodies

Of a stage of trials the pressures are those of its last stable trial. They press on the undeformed geometry and stay what they are, whatever the loads.
"""

from dataclasses import dataclass

import numpy as np
import shapely

from quoin_tools.base.language import _
from quoin_tools.base.results import trials_of
from quoin_tools.limit import LimitError
from quoin_tools.mesh.blockmesh import closed_rings, cross

FLOWING = ("head", "drain", "curtain", "inflow")  # types of loads that say how it flows
NAME = "water in joints"  # as a load; no load of a scene can be called so
ALONG = 0.9  # cosine between a piece of a joint and the faces that it lies between
NOTHING = 1e-6  # of the force of all water: a piece that may be nowhere


@dataclass
class JointWater:
    """Pieces of joints and the pressures in them."""

    point: np.ndarray  # (n, 2, 2) [m] their ends
    pressure: np.ndarray  # (n, 2) [Pa] there, straight between
    joint: list  # (n,) row of the joints table
    moved: float  # [m] how far a piece may have moved from where it is in the mesh
    when: str  # of which trial, in words

    def forces(self, parts):
        sizes = self.pressure.mean(axis=1) * np.hypot(*(self.point[:, 1] - self.point[:, 0]).T)
        total, nowhere, joints = np.zeros((parts.n, 3)), 0.0, np.array(parts.contacts.joint)
        for i in np.flatnonzero(sizes > 0):
            at = self.contact_of(parts, joints, i)
            if at is None:
                nowhere += 0.0 if inside_one(parts, self.point[i].mean(axis=0), self.moved) else sizes[i]
                continue
            for body, force, place in self.pushes(parts, i, at):
                total[body] += [*force, cross(place - parts.centre[body], force)]
        if nowhere > NOTHING * sizes.sum():
            raise LimitError(_("the run has water in joints with {0:.3g} N where no two bodies of the mesh meet", parts.thickness * nowhere))
        return total

    def contact_of(self, parts, joints, i):
        """Returns the contact in which a piece lies; None: there is none."""
        contacts, middle, e = parts.contacts, self.point[i].mean(axis=0), self.point[i, 1] - self.point[i, 0]
        along = contacts.q - contacts.p
        length = np.maximum(contacts.length, 1e-300)
        share = np.clip(((middle - contacts.p) * along).sum(axis=1) / length**2, 0.0, 1.0)
        distance = np.hypot(*(middle - contacts.p - share[:, None] * along).T)
        fits = (distance <= parts.gap + self.moved) & (np.abs(along @ e) > ALONG * length * np.hypot(*e)) & (joints == self.joint[i])
        return int(np.flatnonzero(fits)[distance[fits].argmin()]) if fits.any() else None

    def pushes(self, parts, i, at):
        """Returns (body, force [N], place) on both sides of a contact, for the two triangles of a trapezium."""
        contacts, (a, b) = parts.contacts, self.point[i]
        size = 0.5 * parts.thickness * np.hypot(*(b - a)) * self.pressure[i]
        for k, place in enumerate(((2 * a + b) / 3, (a + 2 * b) / 3)):
            for body, sign in ((contacts.b[at], 1.0), (contacts.a[at], -1.0)):
                yield body, sign * size[k] * contacts.normal[at], place


def inside_one(parts, place, moved):
    """Tells whether all blocks around a place belong to one body, where water in a slit moves nothing; or to fixed ones."""
    blocks = shapely.polygons(parts.mesh.vertices[closed_rings(parts.mesh)])
    around = np.unique(parts.body[shapely.distance(blocks, shapely.Point(place)) <= parts.gap + moved])
    return len(around[~parts.ground[around]]) == 0 or len(around) == 1


def of_run(results, stage):
    if stage not in results.stages:
        return None
    found = results.stage(stage)
    if found.flow is None:
        return None
    moved = float(np.nanmax(np.hypot(*found.displacement.T), initial=0.0))
    trials = trials_of(results.stage_summary(stage))
    when = _("in its last stable trial, {0:.6g}", trials["stable"]) if trials and trials.get("stable") is not None else _("at its end")
    names = [results.mesh.joint_names[row] for row in found.flow.joint]
    return JointWater(found.flow.point, found.flow.pressure, names, moved, when)


def flowing(scene, stage):
    """Returns the names of the loads of a stage that drive the flow in joints."""
    return [name for name, load in scene.stage_loads(stage).items() if load.get("type") in FLOWING]
