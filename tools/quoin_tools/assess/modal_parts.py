"""Sums the inertia of modes over the part of a dam above a plane: (X, Y, M) of blocks and of water on faces for accelerations that are known at the vertices.

    swing = Swing(mesh, scene, shapes)            shapes (n, vertices, 2) at the vertices of the mesh
    swing.blocks(part)                            (n, 3): int rho phi dA
    swing.water(part, points, along)              (n, 3): int rho q n (n.phi) dl
    swing.pressed(part, points, pressure)         (3,): of a pressure towards x, with the sign of a push along +x

The last two rows of `blocks` and `water` are those of accelerations 1 along x and along y of everything. Within a block phi is taken to be linear, which it is in
triangles and rigid blocks.
"""

from dataclasses import dataclass

import numpy as np
import shapely

from quoin_tools.assess import section_cut
from quoin_tools.mesh.blockmesh import closed_rings, face_ends

GAUSS = 8  # places on a face


@dataclass
class FacePoints:
    """Places of integration on wet faces. phi: (n, m, 2) of the modes, and of 1 along x and y; normal: out of the dam."""

    place: np.ndarray
    normal: np.ndarray
    weight: np.ndarray  # [m2] length times thickness
    phi: np.ndarray
    level: float

    @property
    def depth(self):
        return self.level - self.place[:, 1]


class Swing:
    def __init__(self, mesh, scene, shapes):
        self.mesh, self.thickness = mesh, scene.thickness
        self.density = section_cut.densities(mesh, scene, {})
        n = len(mesh.vertices)
        along = [np.tile(axis, (n, 1)) for axis in ((1.0, 0.0), (0.0, 1.0))]
        self.phi = np.concatenate([np.asarray(shapes, float).reshape(-1, n, 2), along])
        ring = closed_rings(mesh)
        weight = np.where(mesh.blocks[:, 3:] < 0, [[0.5, 1, 1, 0.5]], 1.0)  # a triangle has its first vertex twice
        weight = weight / weight.sum(axis=1, keepdims=True)
        at = mesh.vertices[ring]
        self.centre = np.einsum("bk,bkc->bc", weight, at)
        off = at - self.centre[:, None]
        spread = np.linalg.inv(np.einsum("bk,bki,bkj->bij", weight, off, off))
        of_block = self.phi[:, ring]  # (n, blocks, 4, 2)
        self.mean = np.einsum("bk,nbkc->nbc", weight, of_block)
        self.slope = np.einsum("bk,nbkc,bki,bij->nbcj", weight, of_block, off, spread)

    def blocks(self, part):
        pieces = part.pieces if part is not section_cut.WHOLE else shapely.polygons(self.mesh.vertices[closed_rings(self.mesh)])
        area, first, second = moments(pieces, self.centre)
        mass = self.density * self.thickness
        force = (self.mean * area[:, None] + np.einsum("nbcj,bj->nbc", self.slope, first)) * mass[:, None]
        turn = self.centre[:, 0] * force[..., 1] - self.centre[:, 1] * force[..., 0]
        a, s, (xx, xy, yy) = self.mean, self.slope, second.T
        turn = turn + mass * (first[:, 0] * a[..., 1] - first[:, 1] * a[..., 0] + s[..., 1, 0] * xx + (s[..., 1, 1] - s[..., 0, 0]) * xy - s[..., 0, 1] * yy)
        return np.column_stack([force.sum(axis=1), turn.sum(axis=1)])

    def points(self, faces, level):
        """FacePoints of a face set below a level, at Gauss's places in the root of the depth, in which pressures are smooth."""
        ends = face_ends(self.mesh, self.mesh.face_sets[faces])
        x = self.mesh.vertices[ends]
        z = level - x[..., 1]
        wet = (z > 0).any(axis=1)
        ends, x, z = ends[wet], x[wet], z[wet]
        rise = z[:, 0] - z[:, 1]
        rise = np.where(rise == 0, 1.0, rise)
        low, high = np.where(z[:, 0] < 0, z[:, 0] / rise, 0.0), np.where(z[:, 1] < 0, z[:, 0] / rise, 1.0)
        a, b = np.sqrt(np.maximum(z, 0)).T
        place, weight = np.polynomial.legendre.leggauss(GAUSS)
        s, weight = (place + 1) / 2, weight / 2
        root = a[:, None] + s * (b - a)[:, None]
        along, span = s * (root + a[:, None]) / (a + b)[:, None], weight * 2 * root / (a + b)[:, None]
        along = low[:, None] + (high - low)[:, None] * along
        direction = x[:, 1] - x[:, 0]
        length = np.hypot(*direction.T)
        normal = np.column_stack([direction[:, 1], -direction[:, 0]]) / length[:, None]
        places = x[:, :1] + along[..., None] * direction[:, None]
        phi = self.phi[:, ends[:, 0], None] * (1 - along)[..., None] + self.phi[:, ends[:, 1], None] * along[..., None]
        weights = (span * ((high - low) * length)[:, None]).ravel() * self.thickness
        return FacePoints(places.reshape(-1, 2), np.repeat(normal, GAUSS, axis=0), weights, phi.reshape(len(phi), -1, 2), level)

    def water(self, part, points, over):
        """over: [kg/m2] pressure at the points for the acceleration 1 along the normal."""
        push = over * points.weight * inside(part, points) * np.einsum("nmc,mc->nm", points.phi, points.normal)
        return systems(points, push)

    def pressed(self, part, points, pressure):
        """pressure: [Pa] at the points, of water that a motion along +x makes push: on a face that looks to the left, towards +x."""
        push = pressure * points.weight * inside(part, points) * np.sign(points.normal[:, 0])
        return systems(points, push[None])[0]


def inside(part, points):
    """Selects the points whose face belongs to the part."""
    if part is section_cut.WHOLE:
        return np.ones(len(points.place))
    return shapely.contains_xy(part.region, points.place - section_cut.GAP * points.normal)


def systems(points, push):
    """Returns (n, 3) sums (X, Y, M) of forces push (n, m) [N] along the normals."""
    force = push[..., None] * points.normal
    return np.column_stack([force.sum(axis=1), (points.place[:, 0] * force[..., 1] - points.place[:, 1] * force[..., 0]).sum(axis=1)])


def moments(pieces, centres):
    """Returns areas (n,), first moments (n, 2) and second ones xx, xy, yy (n, 3) of polygons about points (n, 2)."""
    n = len(pieces)
    parts, owner = shapely.get_parts(pieces, return_index=True)
    keep = shapely.get_dimensions(parts) == 2
    block_of = owner[keep]
    points, row = shapely.get_coordinates(shapely.get_exterior_ring(parts[keep]), return_index=True)
    p = points - centres[block_of[row]]
    same = row[:-1] == row[1:]
    a, b, row = p[:-1][same], p[1:][same], row[:-1][same]
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    cross = cross * np.sign(np.bincount(row, cross))[row]  # rings may run either way
    block = block_of[row]
    first = cross[:, None] * (a + b) / 6
    second = cross[:, None] * np.column_stack([
        a[:, 0] ** 2 + a[:, 0] * b[:, 0] + b[:, 0] ** 2, (2 * a[:, 0] * a[:, 1] + 2 * b[:, 0] * b[:, 1] + a[:, 0] * b[:, 1] + b[:, 0] * a[:, 1]) / 2,
        a[:, 1] ** 2 + a[:, 1] * b[:, 1] + b[:, 1] ** 2]) / 12  # fmt: skip

    def summed(values):
        out = np.zeros((n, *values.shape[1:]))
        np.add.at(out, block, values)
        return out

    return summed(cross / 2), summed(first), summed(second)
