"""Computes the inertia of the water at a dam that shakes, as the solver does (docs/theory.md, earthquake at rest).

    for force, point in pushes(Wall(faces, load), faces): ...      # per density times horizontal inertia; faces: ends (n, 2, 2)
"""

import numpy as np

VERTICAL = np.cos(np.radians(1.0))  # of the outward normal, along x
POINTS, WEIGHTS = (0.5 * (values + shift) for values, shift in zip(np.polynomial.legendre.leggauss(8), (1.0, 0.0)))


def x_at(segment, y):
    """x where a face is at elevation y, at its nearer end outside it."""
    (xa, ya), (xb, yb) = segment
    return xa if ya == yb else xa + np.clip((y - ya) / (yb - ya), 0, 1) * (xb - xa)


class Wall:
    """The faces of a load as one wall: depth to the bottom, lean [degree], x of the direction to the water, Zangar's C_m.

    faces: ends (n, 2, 2), counter-clockwise round their blocks; the solver has refused those that are all dry."""

    def __init__(self, faces, load):
        self.level, self.rule = float(load["level"]), load["rule"]
        faces = [face for face in faces if face[:, 1].min() < self.level]
        tops = np.array([min(self.level, face[:, 1].max()) for face in faces])
        normal = np.array([(face[1, 1] - face[0, 1]) / np.hypot(*(face[1] - face[0])) for face in faces])
        low, high = min(face[:, 1].min() for face in faces), tops.max()
        self.depth = self.level - float(low if load.get("bottom") is None else load["bottom"])
        self.side = -1.0 if -normal.min() > normal.max() else 1.0
        near = 1e-9 * (high - low)
        places = [[x for face in faces if face[:, 1].min() <= y + near and face[:, 1].max() >= y - near
                   for x in (face[:, 0] if np.ptp(face[:, 1]) <= near else [x_at(face, y)])] for y in (low, high)]  # fmt: skip
        top = 0.5 * (min(places[1]) + max(places[1]))
        foot = np.clip(top, min(places[0]), max(places[0]))
        self.lean = float(np.degrees(np.arctan2(self.side * (foot - top), high - low)))
        broken = max(tops[np.abs(normal) < VERTICAL], default=-np.inf)
        if self.rule == "zangar" and high - broken >= 0.5 * (high - low):
            self.lean = 0.0
        self.largest = 0.7412 - 0.0073 * max(0.0, self.lean)

    def pressure(self, z, normal):
        """Over density and horizontal inertia [m], at depths z on a face with this x of its outward normal."""
        s = np.clip(z / self.depth, 0, 1)
        if self.rule == "westergaard":
            return -normal * self.depth * 0.875 * np.sqrt(s)
        return -self.side * self.depth * 0.5 * self.largest * (s * (2 - s) + np.sqrt(s * (2 - s)))


def pushes(wall, faces):
    """Yields (force, point) at points of Gauss's rule over the square root of the depth, which is exact for Westergaard."""
    for a, b in faces:
        depth = wall.level - np.array([a[1], b[1]])
        if (depth <= 0).all():
            continue
        if (depth < 0).any():  # the water line crosses the face
            crossing = a + (b - a) * depth[0] / (depth[0] - depth[1])
            a, b = (crossing, b) if depth[0] < 0 else (a, crossing)
        first, last = np.sqrt(np.maximum(wall.level - np.array([a[1], b[1]]), 0))
        r = first + POINTS * (last - first)
        along, weight = POINTS * (r + first) / (first + last), WEIGHTS * 2 * r / (first + last)
        inward = np.array([a[1] - b[1], b[0] - a[0]])  # normal times length
        for share, at in zip(weight * wall.pressure(r**2, -inward[0] / np.hypot(*inward)), along):
            yield share * inward, a + at * (b - a)
