"""Computes water that is not at rest at a dam, as the solver does (src/water/wave.c, reservoir.c): waves, levels at the faces.

    for force, point in wave_pushes(load, segments, unit): ...     unit: weight of the water times thickness [N/m2]
"""

import math

import numpy as np

WATERS = ("reservoir", "overflow", "tailwater")  # types of loads that are water with a surface


def level_at_faces(load):
    """Elevation of the surface at the faces: an overflow falls by its velocity head, a tailwater is pushed away."""
    level = float(load["level"])
    if load.get("type") == "overflow":
        return level - float(load["velocity_head"])
    if load.get("type") == "tailwater" and float(load["effective"]) < 1:
        bottom = float(load["bottom"])
        return bottom + float(load["effective"]) * (level - bottom)
    return level


def wave_height(load):
    """Given, or Stevenson's by Molitor's wind factor (1935), km and km/h."""
    if load.get("height") is not None:
        return float(load["height"])
    km = float(load["fetch"]) / 1e3
    return 0.032 * math.sqrt(3.6 * float(load["wind"]) * km) + (0.763 - 0.271 * km**0.25 if km < 32 else 0.0)


def wave_diagram(load):
    """Returns (elevation [m], pressure over the weight of the water [m]) of three places, from above to below; straight lines between them."""
    h, level = wave_height(load), float(load["level"])
    if load["formula"] == "molitor":
        return [(level + 4 * h / 3, 0.0), (level + h / 8, 2.4 * h), (level - h / 3, 0.0)]
    depth, length = level - float(load["bottom"]), float(load["length"])
    kd = 2 * math.pi * depth / length
    middle, below = math.pi * h * h / length / math.tanh(kd), h / math.cosh(kd)
    still = (below + depth) * (h + middle) / (depth + h + middle)
    return [(level + h + middle, 0.0), (level, still), (level - depth, below)]


def wave_pushes(load, segments, unit):
    """Yields (force [N], its point [m]) of each piece of the diagram on each face. segments: ends (n, 2, 2), counter-clockwise round blocks."""
    diagram = wave_diagram(load)
    for (high, over), (low, under) in zip(diagram[:-1], diagram[1:]):
        for a, b in np.asarray(segments, dtype=float):
            rise = b[1] - a[1]
            if rise == 0:
                ends = (0.0, 1.0) if low < a[1] <= high else (0.0, 0.0)
            else:
                ends = sorted(min(1.0, max(0.0, (y - a[1]) / rise)) for y in (low, high))
            points = [a + t * (b - a) for t in ends]
            p, q = (under + (point[1] - low) / (high - low) * (over - under) for point in points)
            if ends[1] > ends[0] and p + q > 0:
                along = points[1] - points[0]
                inward = np.array([-along[1], along[0]])  # times the length of the piece
                yield unit * 0.5 * (p + q) * inward, points[0] + (p + 2 * q) / (3 * (p + q)) * along
