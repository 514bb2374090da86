"""Scenes of the limit analysis cases: block on a slope, dam in lifts, arch, pier, block under a ceiling, weir on water that flows, block on a grouted bar."""

import json
import math
from pathlib import Path

import numpy as np
from quoin_tools.base import scene as scenes
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed

SCHEMA = Path(__file__).resolve().parents[2] / "tools/quoin_tools/front/scene.schema.json"
HELD = {"ground": {"target": "ground", "fix": "xy"}}
RAISED = [{"push": {"type": "load_factor", "loads": ["weight", "push"], "raises": ["push"], "start": 0, "step": 0.1, "limit": 100, "bracket": 1e-4}}]


def scene_of(keys):
    """Reads a scene as a tool does, with the defaults of the solver for joints and loads."""
    import yaml

    sections = json.loads(SCHEMA.read_text(encoding="utf-8"))["definitions"]
    of_loads = {row["if"]["properties"]["type"]["const"]: row["then"] for row in sections["loads"]["allOf"]}
    scene = scenes.parse(yaml.safe_dump(keys, sort_keys=False), "scene.yaml")
    scene.joints = {name: preset(sections["joints"]) | scene.joints.get("default", {}) | row for name, row in scene.joints.items()}
    scene.loads = {name: preset(of_loads[load["type"]]) | load for name, load in scene.loads.items()}
    return scene


def preset(section):
    return {key: scenes.number(about["default"]) for key, about in section["properties"].items() if "default" in about}


def basic(density, friction, loads, stages=RAISED, gravity=10.0, joints=None, k_n=1e11):
    return {
        "gravity": gravity,
        "relaxation": {"tolerance": 1e-7},
        "materials": {"block": {"density": density, "rigid": True}, "ground": {"density": 2000, "rigid": True}},
        "joints": joints or {"default": {"k_n": k_n, "k_s": k_n, "friction": math.degrees(math.atan(friction))}},
        "supports": HELD,
        "loads": {"weight": {"type": "self_weight", "groups": ["block"]}} | loads,
        "stages": stages,
    }


def slope(height, friction=0.5, degrees=10.0):
    """L01: a block 2 m x h on a plane; the push acts downslope, horizontally, at its centre."""
    angle = math.radians(degrees)
    e, n = np.array([math.cos(angle), -math.sin(angle)]), np.array([math.sin(angle), math.cos(angle)])
    plane = [np.array([-5.0, 0.0]), np.array([-5.0, 0.0]) + 12 * e]
    ground = quad_patch(plane[0] - 2 * n, plane[1] - 2 * n, plane[1], plane[0], 1, 1, "ground", True)
    start = plane[0] + 5 * e
    block = quad_patch(start, start + 2 * e, start + 2 * e + height * n, start + height * n, 1, 1, "block", True)
    mesh = join([renamed(ground, {}), renamed(block, {})])
    return mesh, basic(2000, friction, {"push": {"type": "pseudo_static", "coefficient": [1, 0], "groups": ["block"]}})


def dam(friction, cohesion=0.0, lifts=5, base=30.0, height=40.0):
    """L02: triangle in lifts, vertical upstream face, water to its crest."""
    lift = height / lifts
    width = lambda y: base * (1 - y / height)  # noqa: E731
    blocks = [quad_patch((0, y), (width(y), y), (width(y + lift), y + lift), (0, y + lift), 1, 1, "block", True) for y in np.arange(lifts - 1) * lift]
    tip = BlockMesh([(0, height - lift), (width(height - lift), height - lift), (0, height)], [(0, 1, 2, -1)], [0], ["block"], [1], {"left": [(0, 2)]}, {})
    rock = rectangle(-10, -5, base + 20, 5, group="ground", rigid=True)
    mesh = join([renamed(rock, {}), *(renamed(block, {"upstream": "left"}) for block in [*blocks, tip])])
    joints = {"default": {"k_n": 1e11, "k_s": 1e11, "friction": math.degrees(math.atan(friction)), "cohesion": cohesion}}
    keys = basic(2300, friction, {"push": {"type": "reservoir", "faces": "upstream", "level": height}}, joints=joints, gravity=9.81)
    return mesh, keys


def cracked_dam(friction, stage, lifts=1, level=20.0, height=26.0, base=20.0, crest=4.0):
    """A trapezium in lifts on a base whose uplift follows the crack, under water at a level [m]."""
    rock, lift = rectangle(-10, -5, base + 20, 5, group="ground", rigid=True), height / lifts
    width = lambda y: base + (crest - base) * y / height  # noqa: E731
    blocks = [quad_patch((0, y), (width(y), y), (width(y + lift), y + lift), (0, y + lift), 1, 1, "block", True) for y in np.arange(lifts) * lift]
    mesh = join([renamed(rock, {}), *(renamed(block, {"upstream": "left"} | ({"base": "bottom"} if k == 0 else {})) for k, block in enumerate(blocks))])
    loads = {"push": {"type": "reservoir", "faces": "upstream", "level": level}, "up": {"type": "uplift", "faces": "base", "level": level, "rule": "linear", "cracked": True}}
    return mesh, basic(2300, friction, loads, [{"push": stage | {"loads": ["weight", "push", "up"]}}], gravity=9.81)


def arch(n, friction, thickness=0.7, span=12.0, rise=3.0):
    """L03: N equal voussoirs, a vertical force at the extrados at half the half-angle. Springing of the centre line at y = 0."""
    radius = (span**2 / 4 + rise**2) / (2 * rise)
    half, middle = math.asin(span / 2 / radius), np.array([0.0, rise - radius])
    at = lambda r, angle: tuple(middle + r * np.array([math.sin(angle), math.cos(angle)]))  # noqa: E731
    inner, outer, angles = radius - thickness / 2, radius + thickness / 2, np.linspace(-half, half, n + 1)
    bodies, points = [], None
    for i in range(n):
        a, b = angles[i], angles[i + 1]
        body = quad_patch(at(inner, a), at(inner, b), at(outer, b), at(outer, a), 1, 1, "block", True)
        body.points = {}
        if abs(b - half / 2) < 1e-9:
            body.points = {"load": 2}  # top right
        bodies.append(renamed(body, {}))
    for angle, sign in ((-half, -1), (half, 1)):
        p, q = np.array(at(inner, angle)), np.array(at(outer, angle))
        back = sign * thickness * np.array([math.cos(angle), -math.sin(angle)])
        corners = (p + back, p, q, q + back) if sign < 0 else (p, p + back, q + back, q)
        bodies.append(renamed(quad_patch(*corners, 1, 1, "ground", True), {}))
    mesh = join(bodies)
    if "load" not in mesh.points:
        points = [k for k, v in enumerate(mesh.vertices) if np.hypot(*(v - at(outer, half / 2))) < 1e-9]
        mesh.points = {"load": points[0]}
    return mesh, basic(2200, friction, {"push": {"type": "point_force", "point": "load", "value": [0, -1e3]}})


def pier():
    """L04: 10 courses of 0.5 m, 3 m wide, of blocks of 1 m, courses 2, 4, ... begin and end with halves; a beam of 3 x 0.5 m with 150 kN."""
    bodies = [rectangle(-1, -1, 5, 1, group="ground", rigid=True)]
    for course in range(10):
        cuts = [0, 1, 2, 3] if course % 2 == 0 else [0, 0.5, 1.5, 2.5, 3]
        bodies += [rectangle(a, 0.5 * course, b - a, 0.5, group="block", rigid=True) for a, b in zip(cuts[:-1], cuts[1:])]
    beam = quad_patch((0, 5), (3, 5), (3, 5.5), (0, 5.5), 2, 2, "block", True)
    beam.points = {"left": 3, "top": 7}
    bodies.append(beam)
    mesh = join([renamed(body, {}) for body in bodies])
    mesh.points = {name: next(k for k, v in enumerate(mesh.vertices) if np.allclose(v, at) and k >= len(mesh.vertices) - 9) for name, at in (("left", (0, 5.25)), ("top", (1.5, 5.5)))}
    loads = {"dead": {"type": "point_force", "point": "top", "value": [0, -150e3]}, "push": {"type": "point_force", "point": "left", "value": [1e3, 0]}}
    stages = [{"push": RAISED[0]["push"] | {"loads": ["weight", "dead", "push"], "step": 20, "limit": 200, "bracket": 0.25}}]
    return mesh, basic(2000, 0.75, loads, stages)


def ceiling():
    """L05: a block between floor and a rigid ceiling that just touches."""
    floor, block, top = rectangle(-2, -1, 8, 1, group="ground", rigid=True), rectangle(0, 0, 2, 1, group="block", rigid=True), rectangle(-2, 1, 8, 1, group="ground", rigid=True)
    mesh = join([renamed(body, {}) for body in (floor, block, top)])
    return mesh, basic(2000, 0.5, {"push": {"type": "pseudo_static", "coefficient": [1, 0], "groups": ["block"]}})


def notch(half, friction=0.5, depth=1.0):
    """A wedge stone in a notch whose walls lean by `half` degrees from the vertical, and a stone of 2 x 1 m on it that is pushed; both weigh 20 kN/m3."""
    lean, side = depth * math.tan(math.radians(half)), 0.2
    top = side + lean
    left, right = ((-3, 0), (-side, 0), (-top, depth), (-3, depth)), ((side, 0), (3, 0), (3, depth), (top, depth))
    walls = [quad_patch(*corners, 1, 1, "ground", True) for corners in (left, right)]
    wedge, stone = quad_patch((-side, 0), (side, 0), (top, depth), (-top, depth), 1, 1, "block", True), rectangle(-1, depth, 2, 1, group="stone", rigid=True)
    mesh = join([renamed(body, {}) for body in (*walls, wedge, stone)])
    keys = basic(2000, friction, {"push": {"type": "pseudo_static", "coefficient": [1, 0], "groups": ["stone"]}, "lift": {"type": "pseudo_static", "coefficient": [0, 1], "groups": ["block"]}})
    keys["materials"]["stone"] = {"density": 2000, "rigid": True}
    keys["loads"]["weight"]["groups"] = ["block", "stone"]
    return mesh, keys


def mortared(beds, friction=0.364, thick=0.004, tilt=0.0):
    """Blocks of 2 x 1 m on beds of mortar, each as many layers as `beds` says; on the mortar they slide, on each other they would not. tilt: rise of the uppermost block over its width [m]."""
    bodies, y = [rectangle(-1, -1, 4, 1, group="ground", rigid=True)], 0.0
    for layers in beds:
        for _ in range(layers):
            bodies.append(rectangle(0, y, 2, thick / layers, group="mortar", rigid=True))
            y += thick / layers
        bodies.append(quad_patch((0, y), (2, y + tilt), (2, y + 1), (0, y + 1), 1, 1, "block", True))
        y += 1
    mesh = join([renamed(body, {}) for body in bodies])
    mesh.face_sets, mesh.points = {}, {}
    bed = {"k_n": 1e11, "k_s": 1e11, "friction": math.degrees(math.atan(friction))}
    joints = {"default": bed | {"friction": 45}, "ground+mortar": bed, "block+mortar": bed, "mortar+mortar": bed}
    keys = basic(2000, friction, {"push": {"type": "pseudo_static", "coefficient": [1, 0], "groups": ["block", "mortar"]}}, joints=joints)
    keys["materials"]["mortar"] = {"density": 2000, "rigid": True}
    keys["loads"]["weight"]["groups"] = ["block", "mortar"]
    return mesh, keys


def weir(friction=0.5, length=6.0, height=8.0):
    """A block under water to its crest, which flows through a base joint whose width nothing changes: a straight line of pressure, from all of the head to nothing. The water on the face is raised."""
    rock = rectangle(-2, -2, length + 4, 2, group="ground", rigid=True)
    block = rectangle(0, 0, length, height, group="block", rigid=True)
    mesh = join([renamed(rock, {}), renamed(block, {"base": "bottom", "upstream": "left", "downstream": "right"})])
    angle, width = math.degrees(math.atan(friction)), 1e-3
    joints = {"default": {"k_n": 1e11, "k_s": 1e11, "friction": angle}, "base": {"aperture": width, "aperture_residual": width, "aperture_max": width}}
    loads = {"push": {"type": "reservoir", "faces": "upstream", "level": height}, "up": {"type": "head", "faces": "upstream", "level": height}, "down": {"type": "head", "faces": "downstream", "level": 0}}
    acts = ["weight", *loads]
    stages = [{"full": {"loads": acts}}, {"push": RAISED[0]["push"] | {"loads": acts, "start": 1, "step": 0.25, "limit": 4, "bracket": 2e-3}}]
    return mesh, basic(2400, friction, loads, stages, gravity=9.81, joints=joints)


def barred(direction, friction=0.5, **bar):
    """A block, 2 x 2 m and 96 kN, on ground, with a bar upright in its middle: 1.5 m in the block, 1 m in the ground. The push is 1 kN along `direction`, through the middle of the joint."""
    ground = rectangle(-2, -2, 4, 2, group="ground", rigid=True)
    block = quad_patch((-1, 0), (1, 0), (1, 2), (-1, 2), 2, 1, "block", True)
    block.points = {"foot": 1}
    mesh = join([renamed(ground, {}), block])
    mesh.face_sets = {}
    keys = basic(2400, friction, {"push": {"type": "point_force", "point": "foot", "value": [1e3 * x for x in direction]}}, k_n=1e10)
    return mesh, keys | {"anchors": {"bar": {"head": [0, 1.5], "root": [0, -1], "area": 1e-3, "young": 200e9, "bond_stiffness": 2e9} | bar}}
