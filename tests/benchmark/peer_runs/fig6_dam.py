"""The dam of Fig. 6 as every peer gets it: nodes, elements, nodal loads, the joint, and what is compared.

Family M of examples/fig6/triangle_dam.py, n by n: quadrilaterals, a row of triangles at the apex. Loads are consistent nodal forces of
self-weight and 100 m of water, equal for all. Compared are the crest's u_x and the normal stress at the toe, the mean over
the last eighth of the base (at the corner itself it grows with the logarithm of the mesh). There the joint is closed, so
that the stress is k_n u_y in every peer."""

import argparse
import json
import resource
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "examples" / "fig6")]

from triangle_dam import BASE, HEIGHT, mapped_dam  # noqa: E402

YOUNG, POISSON, DENSITY = 30e9, 0.2, 2400.0  # [Pa], [-], [kg/m3]
K_N, K_S, FRICTION = 30e9, 10e9, 1.0  # [Pa/m], [Pa/m], tan 45 degrees
GRAVITY, WATER = 9.81, 1000.0  # [m/s2], [kg/m3]


class Dam:
    """xy (nodes, 2) [m], quads (q, 4) and triangles (t, 3) counter-clockwise, base: nodes from heel to toe, crest: node,
    loads (nodes, 2) [N/m], share: length of the base that each of its nodes carries [m]."""

    def __init__(self, n):
        xy, quads, triangles = mapped_dam(n)
        self.n, self.xy, self.quads, self.triangles = n, xy, np.array(quads).reshape(-1, 4), np.array(triangles)
        self.base, self.crest = np.arange(n + 1), len(xy) - 1
        upstream = np.append(np.arange(n) * (n + 1), self.crest)
        self.loads = self.weight() + self.pressure(upstream)
        length = np.diff(xy[self.base, 0])
        self.share = np.append(length, 0) / 2 + np.append(0, length) / 2

    def weight(self):
        """Shape functions times density times g, integrated; a quadrilateral with 2 x 2 points."""
        loads = np.zeros_like(self.xy)
        for _, shape, gradient in gauss_points():
            measure = np.linalg.det(gradient @ self.xy[self.quads])
            np.add.at(loads[:, 1], self.quads, -DENSITY * GRAVITY * measure[:, None] * shape)
        a, b = (self.xy[self.triangles[:, k]] - self.xy[self.triangles[:, 0]] for k in (1, 2))
        area = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
        np.add.at(loads[:, 1], self.triangles, -DENSITY * GRAVITY * area[:, None] / 3)
        return loads

    def pressure(self, face):
        """Linear pressure on the vertical face, pushing in x."""
        loads, y = np.zeros_like(self.xy), self.xy[face, 1]
        p, length = WATER * GRAVITY * (HEIGHT - y), np.diff(y)
        loads[face[:-1], 0] += length * (2 * p[:-1] + p[1:]) / 6
        loads[face[1:], 0] += length * (p[:-1] + 2 * p[1:]) / 6
        return loads

    def toe_stress(self, u_y):
        """Mean of k_n u_y over the last eighth of the base [Pa]; u_y (base nodes) [m], linear between them."""
        x = self.xy[self.base, 0]
        start = BASE * 7 / 8
        x, u_y = np.append(start, x[x > start]), np.append(np.interp(start, x, u_y), u_y[x > start])
        return K_N * np.trapezoid(u_y, x) / (BASE - start)


def gauss_points():
    """(xi, eta), shape functions (4), their gradients (2, 4) at the four points of weight 1."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    for point in corners / np.sqrt(3):
        one = 1 + corners * point
        yield point, one.prod(axis=1) / 4, np.array([corners[:, 0] * one[:, 1], corners[:, 1] * one[:, 0]]) / 4


class Clock:
    """Processor seconds (user and system) and wall seconds since it was made."""

    def __init__(self, who=resource.RUSAGE_SELF):
        self.who = who
        self.start, self.wall = self.cpu(), time.perf_counter()

    def cpu(self):
        usage = resource.getrusage(self.who)
        return usage.ru_utime + usage.ru_stime

    def read(self):
        return {"cpu_s": self.cpu() - self.start, "wall_s": time.perf_counter() - self.wall}


def arguments(*more):
    """--n and --friction, and what a peer adds: (flags, settings) pairs."""
    parser = argparse.ArgumentParser(description=sys.modules["__main__"].__doc__.splitlines()[0])
    parser.add_argument("--n", type=int, default=16, help="columns and rows of the dam")
    parser.add_argument("--friction", action="store_true", help="no tension and 45 degrees of friction in the joint")
    for flag, settings in more:
        parser.add_argument(flag, **settings)
    return parser.parse_args()


def report(**values):
    """The last line of a peer's output is its result."""
    print(json.dumps(values))
