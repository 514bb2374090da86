"""Sliding by hand: the friction that the worst plane through the section needs for a given cohesion.

A plane goes from the upstream to the downstream face; what lies above it slides as one piece, under its weight and the water on its
upstream face. A continuum can fail on any plane, and on worse surfaces, so it needs at least this friction."""

import numpy as np
from quoin_tools.mesh.dam import G1

DENSITY, WATER, LEVEL, GRAVITY = 2400.0, 1000.0, 33.0, 9.81
POINTS = 60  # on each face


def along(corners, n):
    """Points (n, 2) at equal distances along a line of straight pieces."""
    corners = np.asarray(corners, dtype=float)
    at = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    where = np.linspace(0, at[-1], n)
    return np.stack([np.interp(where, at, corners[:, axis]) for axis in (0, 1)], axis=1), where, at


def area(ring):
    x, y = np.asarray(ring).T
    return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def forces(section=G1, full=True):
    """Of every plane: length [m], force across [N/m], positive where it presses, and along [N/m]."""
    heel, toe, break_, right, left = section.corners()
    upstream, _, _ = along([heel, left], POINTS + 1)
    downstream, where, at = along([toe, break_, right], POINTS + 1)
    rows = []
    for a in upstream[:-1]:
        for b, s in zip(downstream[:-1], where[:-1]):
            ring = [a, b, *[corner for corner, place in zip((break_, right), at[1:]) if place > s], left]
            weight = DENSITY * GRAVITY * area(ring)
            depth = max(LEVEL - a[1], 0.0) if full else 0.0
            face = left - a
            push = 0.5 * WATER * GRAVITY * depth**2 / face[1] * np.array([face[1], -face[0]])  # normal to the face, inwards
            length = np.hypot(*(b - a))
            t = (b - a) / length
            n = np.array([-t[1], t[0]])
            load = push - [0, weight]
            rows.append((length, -load @ n, load @ t))
    return np.array(rows).T


def friction_needed(cohesion, found):
    """[degree] by the worst plane; found: of `forces`."""
    length, across, shear = found
    rest = np.abs(shear) - cohesion * length
    return float(np.degrees(np.arctan2(np.maximum(rest, 0), np.maximum(across, 1e-9))).max())
