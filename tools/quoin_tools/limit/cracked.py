"""Finds the limit with water in the crack of a joint, where limit analysis by itself has the joint closed.

    level = limit_with_cracks(found, scene, kept, water)      None: nothing to follow, or it cannot be followed

An uplift of a scene that follows a crack (cracked: true) presses with the full head as far as the joint is open. How far that is, for given loads, the gravity method says (assess/gravity.py): the part above the joint is
rigid and the joint has no tension; crack and uplift are iterated. Where they settle, the water in the crack is added to the loads of the bodies on both sides; where they run away nothing stands.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import shapely

from quoin_tools.assess.gravity import Base, hand_method
from quoin_tools.assess.joint_uplift import heel_in, joined, joint_chord, uplift_loads
from quoin_tools.assess.section_cut import GAP, GravityError, cut
from quoin_tools.base.scene import raised
from quoin_tools.limit.program import STANDS, missing
from quoin_tools.mesh.blockmesh import closed_rings, cross

NARROW = 1e-4  # bracket, over the size
SAME = 1e-3  # of the force of an uplift: the solver and the gravity method agree on it, with the joint closed


def limit_with_cracks(found, scene, kept, water):
    """Returns the largest level or factor, or the least strength, of a Bound whose cracks have water; None where that is not known. nan: the bodies do not stand at its first value."""
    loads = scene.stage_loads(found.stage)
    follow = [name for name, load in loads.items() if load.get("type") == "uplift" and load.get("cracked") is True]
    if not follow or found.value is None or any(load.get("type") == "pseudo_static" for load in loads.values()):
        return None
    try:
        cracks = [Crack.under(found.parts, scene, found.stage, name) for name in follow]
        trial = {"flood": flood, "load_factor": factor, "strength_reduction": reduction}[found.kind](found, scene, kept, water, cracks)
    except GravityError:
        return None
    if trial is None:
        return None
    fails, stands, stand, start = trial
    if not stand(stands):
        return math.nan
    width = NARROW * abs(fails - stands)
    while abs(fails - stands) > width:
        middle = 0.5 * (fails + stands)
        fails, stands = (fails, middle) if stand(middle) else (middle, stands)
    return start + stands


# ---- (value that fails, value that stands, stand(value), what to add to a value) of each kind -------------------


def flood(found, scene, kept, water, cracks):
    start = kept.on_faces(scene, found.stage)
    if math.isinf(found.value):
        return None

    def stand(rise):
        higher = {name: raised(load, {"level": float(load["level"]) + rise}) if name in start.rises and "level" in load else load for name, load in scene.loads.items()}
        return with_cracks(found.parts, replace(scene, loads=higher), found.stage, kept.forces(scene, found.stage, found.parts, water, rise), cracks, {}, None)

    return found.value - start.start, 0.0, stand, start.start


def factor(found, scene, kept, water, cracks):
    loads = kept.forces(scene, found.stage, found.parts, water)
    if math.isinf(found.value):
        return None
    return found.value, found.least or 0.0, lambda times: with_cracks(found.parts, scene, found.stage, loads, cracks, dict.fromkeys(found.raised, times), None), 0.0


def reduction(found, scene, kept, water, cracks):
    loads, keys = kept.forces(scene, found.stage, found.parts, water), scene.stages[found.stage]
    what, only = keys.get("what", "friction"), keys.get("reduce")
    first = max(float(row["friction"]) for row in found.parts.joints.values() if "friction" in row) if what == "friction" else 1.0
    return found.value, first, lambda left: with_cracks(found.parts, scene, found.stage, loads, cracks, {}, (what, left, [only] if isinstance(only, str) else only)), 0.0


def with_cracks(parts, scene, stage, loads, cracks, times, reduction):
    """Tells whether the bodies stand under loads by name (n, 3), some of them multiplied, with the water in their cracks."""
    total = sum(times.get(name, 1.0) * load for name, load in loads.items())
    added = np.zeros_like(total)
    for crack in cracks:
        more = crack.added(parts, scene, stage, total, loads[crack.name], times.get(crack.name, 1.0))
        if more is None:
            return False
        added += more
    return missing(parts, total + added, reduction).short <= STANDS


@dataclass
class Crack:
    """The joint of an uplift that follows its crack."""

    name: str
    base: Base
    region: object  # Part above the joint
    above: np.ndarray  # (n,) bodies of the part
    pieces: list  # (body above, body below, segment (2, 2) with the part to its left)

    @classmethod
    def under(cls, parts, scene, stage, name):
        mesh = parts.mesh
        segments = joined(mesh, mesh.face_sets[scene.loads[name]["faces"]])[1]
        chord = joint_chord(mesh, scene, name, segments)
        ends = chord.ends() if heel_in(chord) == "start" else chord.ends()[::-1]
        region = cut(mesh, ends)
        rings = shapely.polygons(mesh.vertices[closed_rings(mesh)])
        share = np.bincount(parts.body, region.areas, parts.n) / np.bincount(parts.body, shapely.area(rings), parts.n)
        if ((share > 0.01) & (share < 0.99)).any():
            raise GravityError("the joint cuts a body")
        tree, found = shapely.STRtree(rings), []
        uplift = next(one for one in uplift_loads(mesh, scene, stage, region) if one.name == name)
        for segment in uplift.segments:
            along = segment[1] - segment[0]
            left = 2 * GAP * np.array([-along[1], along[0]]) / np.hypot(*along)
            sides = [parts.body[tree.nearest(shapely.Point(segment.mean(axis=0) + side * left))] for side in (1, -1)]
            found.append((*sides, segment))
        meets, strengths = {(above, below) for above, below, _segment in found}, parts.strengths()
        named = {joint for a, b, joint in zip(parts.contacts.a, parts.contacts.b, parts.contacts.joint) if (a, b) in meets or (b, a) in meets}
        if any(strengths[joint].tension > 0 for joint in named):
            raise GravityError("the joint bears tension")
        return cls(name, Base(*ends, scene.thickness), region, share > 0.5, found)

    def added(self, parts, scene, stage, total, closed, times):
        """Returns the forces (n, 3) of the water in the crack that the loads open, beyond those with the joint closed; None: it runs away. closed: the solver's forces of this load."""
        uplift = next(one for one in uplift_loads(parts.mesh, scene, stage, self.region) if one.name == self.name)
        uplift = replace(uplift, unit_weight=times * uplift.unit_weight)
        under = uplift.forces(self.base, 0.0)
        if np.hypot(*(times * closed[self.above, :2].sum(axis=0) - under[:2])) > SAME * max(np.hypot(*under[:2]), 1e-300):
            raise GravityError("the gravity method has another uplift")
        about = total[self.above]
        forces = np.append(about[:, :2].sum(axis=0), (about[:, 2] + cross(parts.centre[self.above], about[:, :2])).sum())
        hand = hand_method(self.base, forces - under, uplift)
        if hand.crack is None:
            return None
        more, crack = np.zeros_like(total), hand.crack if hand.crack_at == uplift.heel else 0.0
        for above, below, segment in self.pieces:
            piece = replace(uplift, segments=segment[None])
            water = piece.forces(self.base, crack) - piece.forces(self.base, 0.0)
            for body, sign in ((above, 1.0), (below, -1.0)):
                more[body] += sign * np.append(water[:2], water[2] - cross(parts.centre[body], water[:2]))
        return more
