"""A scene and what must have the same answer: its mirror image, its model in another scale, other numbers of its blocks and vertices, other units, rounded coordinates,
a layer thinner than the tolerance of contacts, loads in stages and at once."""

import copy

import numpy as np
from methods import PLAIN, any_of, column_scene, dam_scene, rounded, slope_scene, wall_scene, with_vertices
from more import MORE, anchored_scene, cracked_scene
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import join, quad_patch, renamed
from runs import Scene, Way, changed, elastic, frame, joint, solved

VARIABLE = ("-contact_connectivity", "variable")


# ---- mirror images ---------------------------------------------------------------------------------------

def mirrored_mesh(mesh):
    """x -> -x; blocks counter-clockwise again: corners 1, 0, 3, 2, of a triangle 1, 0, 2, so faces 0, 3, 2, 1 and 0, 2, 1."""
    triangle = mesh.blocks[:, 3] < 0
    blocks = mesh.blocks[:, [1, 0, 3, 2]].copy()
    blocks[triangle] = mesh.blocks[triangle][:, [1, 0, 2, 3]]
    sets = {}
    for name, rows in mesh.face_sets.items():
        k = np.where(triangle[rows[:, 0]], np.array([0, 2, 1, 0])[rows[:, 1]], np.array([0, 3, 2, 1])[rows[:, 1]])
        sets[name] = np.column_stack([rows[:, 0], k])
    return BlockMesh(mesh.vertices * [-1, 1], blocks, mesh.block_group, mesh.group_names, mesh.group_rigid, sets, dict(mesh.points))


def mirrored_keys(keys):
    keys = copy.deepcopy(keys)
    for load in keys["loads"].values():
        for name in ("value", "coefficient", "from", "to"):
            if name in load:
                load[name] = [-load[name][0], load[name][1]]
    for anchor in keys.get("anchors", {}).values():
        for name in ("head", "root"):
            anchor[name] = [-anchor[name][0], anchor[name][1]]
    for support in keys["supports"].values():
        if "motion" in support:
            support["motion"] = "mirrored.csv"
    return keys


def mirror(scene):
    return Way(mesh=mirrored_mesh(scene.mesh), keys=mirrored_keys(scene.keys), image=lambda u: u * [-1, 1], unsigned=True)


def images(rng):
    """Mirrored, with the methods and connectivities too."""
    scene = any_of(rng, PLAIN + MORE)
    scene.kind = "mirror image"
    for name, options in (("mirrored", ()), ("mirrored, variable", VARIABLE), ("mirrored, Newton", ("-relaxation_method", "preconditioned"))):
        if scene.newton or "Newton" not in name:
            scene.ways[name] = mirror(scene)
            scene.ways[name].options = options
    return scene


# ---- numbers and units -----------------------------------------------------------------------------------

def renumbered(mesh, rng):
    """Blocks and vertices in another order, each block from another corner; (mesh, order of its vertices)."""
    order, place = rng.permutation(len(mesh.vertices)), rng.permutation(len(mesh.blocks))
    new = np.empty(len(order), dtype=int)
    new[order] = np.arange(len(order))
    turn = rng.integers(0, 4, len(mesh.blocks))
    size = np.where(mesh.blocks[:, 3] < 0, 3, 4)
    turn %= size
    blocks = mesh.blocks.copy()
    for b, (n, t) in enumerate(zip(size, turn)):
        blocks[b, :n] = new[np.roll(mesh.blocks[b, :n], -t)]
    where = np.empty(len(place), dtype=int)
    where[place] = np.arange(len(place))
    sets = {name: np.column_stack([where[rows[:, 0]], (rows[:, 1] - turn[rows[:, 0]]) % size[rows[:, 0]]])[rng.permutation(len(rows))] for name, rows in mesh.face_sets.items()}
    return BlockMesh(mesh.vertices[order], blocks[place], mesh.block_group[place], mesh.group_names, mesh.group_rigid, sets, {name: new[v] for name, v in mesh.points.items()}), order


PER_LENGTH = {"young", "cohesion", "tension", "compression", "cohesion_residual", "tension_residual"}  # Pa: grow with the size of a model of one density


def scaled_keys(keys, s):
    """Of a model s times as large of the same density: stresses s times, stiffnesses of joints (Pa/m) and angles the same."""
    keys = copy.deepcopy(keys)
    for row in (*keys["materials"].values(), *keys["joints"].values()):
        row.update({name: value * s for name, value in row.items() if name in PER_LENGTH})
    for load in keys["loads"].values():
        load.update({name: load[name] * s for name in ("level", "drain") if name in load})
        if "value" in load:  # of a traction [Pa], of a force [N/m]
            load["value"] = [value * (s if load["type"] == "traction" else s * s) for value in load["value"]]
        if load["type"] == "uplift":
            load["crack_tolerance"] = 0.01 * s
    for anchor in keys.get("anchors", {}).values():
        anchor.update({name: [value * s for value in anchor[name]] for name in ("head", "root")})
        anchor["area"] *= s  # the same modulus: E A / length grows with s, as forces over displacements s^2 / s do
        anchor["young"] *= s
        if "prestress" in anchor:
            anchor["prestress"] *= s * s
    for stage in keys["stages"]:
        for row in stage.values():
            if row.get("type") == "flood":
                row.update({name: row[name] * s for name in ("step", "limit", "bracket")})
    keys["contact"] = keys.get("contact", {}) | {"tolerance": 0.005 * s, "overlap": 0.005 * s}
    return keys


def text(value, factor, unit):
    return f"{value / factor!r} {unit}"


def united(keys):
    """The same numbers in other units."""
    keys = copy.deepcopy(keys)
    words = {"young": (1e9, "GPa"), "k_n": (1e9, "MPa/mm"), "k_s": (1e6, "MN/m3"), "friction": (1, "deg"), "cohesion": (1e3, "kPa"), "tension": (1e6, "N/mm2"), "level": (1e-3, "mm")}
    for row in (*keys["materials"].values(), *keys["joints"].values(), *keys["loads"].values()):
        for name, (factor, unit) in words.items():
            if name in row:
                row[name] = text(row[name], factor, unit)
        if row.get("type") is None and "density" in row and row["density"]:
            row["density"] = text(row["density"], 1000 / 9.81, "kN/m3")
        if row.get("type") in ("traction", "point_force"):
            row["value"] = [text(value, 1e3, "kPa" if row["type"] == "traction" else "kN/m") for value in row["value"]]
    keys["contact"] = {"tolerance": "5 mm"}
    return keys


def numbers(rng):
    """Renumbered, with materials and joints in the opposite order; in another scale; in other units."""
    scene = any_of(rng, PLAIN + MORE)
    scene.kind = "numbers and units"
    mesh, order = renumbered(scene.mesh, rng)
    backwards = {name: dict(reversed(rows.items())) if name in ("materials", "joints") else rows for name, rows in scene.keys.items()}
    for name, options in (("renumbered", ()), ("renumbered, variable", VARIABLE)):
        scene.ways[name] = Way(mesh=mesh, keys=backwards, image=lambda u: u[order], options=options)
    if "shake.csv" in scene.files:  # time would have to be scaled too
        return scene
    s = float(10 ** rng.uniform(-2, 1))
    small = with_vertices(scene.mesh, scene.mesh.vertices * s)
    for name, options in (("in another scale", ()), ("in another scale, variable", VARIABLE)):
        scene.ways[name] = Way(mesh=small, keys=scaled_keys(scene.keys, s), image=lambda u: u * s**2 / s, forces=s * s, levels=s, options=options)
    scene.ways["in other units"] = Way(keys=united(scene.keys))
    return scene


# ---- rounding --------------------------------------------------------------------------------------------

def turned(scene, angle):
    """Its mesh turned about the origin, with gravity as it was."""
    c, s = np.cos(angle), np.sin(angle)
    return with_vertices(scene.mesh, scene.mesh.vertices @ np.array([[c, s], [-s, c]]))


def rounds(rng):
    """Nodes that do not match on a slanting base; walls and columns on ground that leans; coordinates to 1 mm."""
    dams = (dam_scene, cracked_scene, anchored_scene)
    make = (*dams, slope_scene, wall_scene, column_scene)[int(rng.integers(6))]
    scene = make(rng, unmatched=True) if make in dams else make(rng)
    if make in (wall_scene, column_scene):
        scene.mesh = turned(scene, float(rng.uniform(-0.1, 0.1)))
    scene.kind, mesh = "rounded", rounded(scene.mesh)
    scene.by_hand = None  # rounded, the plane has another dip
    if make is column_scene and rng.random() < 0.3:
        scene.keys["joints"]["default"] |= {"cohesion": 1e5, "tension": 5e4, "friction_residual": 30.0}
    for name, options in (("to 1 mm", ()), ("to 1 mm, variable", VARIABLE), ("to 1 mm, Newton", ("-relaxation_method", "preconditioned"))):
        scene.ways[name] = Way(mesh=mesh, options=options)
    scene.ways["variable"] = Way(options=VARIABLE)
    return scene


# ---- layers ----------------------------------------------------------------------------------------------

def layer(rng):
    """Bodies on beds of mortar of 1 to 8 mm: the tolerance of contacts (5 mm) makes no difference against one of 0.1 mm."""
    rigid, width = bool(rng.random() < 0.5), float(rng.uniform(1, 10))
    beds, slant, y = int(rng.integers(1, 4)), float(rng.uniform(-0.1, 0.1)), 0.0
    n = [int(k) for k in rng.integers(1, 6, 3)]
    def band(low, high, nx, ny, group, stiff):
        left, right = -0.5 * width, 0.5 * width
        return quad_patch((left, low + slant * left), (right, low + slant * right), (right, high + slant * right), (left, high + slant * left), nx, ny, group, stiff)
    bodies, height = [band(-width, 0.0, n[0], 1, "base", True)], 0.0
    for _ in range(beds):
        thick, tall = float(rng.uniform(1e-3, 8e-3)), float(rng.uniform(0.3, 1.0) * width)
        bodies += [band(y, y + thick, n[1], 1, "mortar", rigid), band(y + thick, y + thick + tall, n[2], 1 if rigid else 2, "block", rigid)]
        y += thick + tall
        height += tall
    mesh = join([renamed(body, {"pushed": "left"} if i == len(bodies) - 1 else {}, {"top": "top_left"} if i == len(bodies) - 1 else {}) for i, body in enumerate(bodies)])
    stuff = ({"density": 2000.0}, {"density": 2400.0}) if rigid else (elastic(rng, 2000.0), elastic(rng))
    row = joint(rng, (9, 10.5), (30, 45))
    push = float(rng.uniform(0.02, 0.2) * 2400 * 9.81 * width * min(1.0, width / height))
    loads = {"weight": {"type": "self_weight", "groups": ["block", "mortar"]}, "push": {"type": "traction", "faces": "pushed", "value": [push, 0.0]}}
    keys = frame(materials={"base": {"density": 2000}, "mortar": stuff[0], "block": stuff[1]}, joints={"default": row}, supports={"base": {"fix": "xy"}}, loads=loads,
                 stages=[{"sw": {"loads": ["weight"]}}, {"pushed": {"loads": ["weight", "push"]}}])
    keys["contact"] = {"tolerance": 1e-4}
    scene = Scene("layers", mesh, keys)
    for name, options in (("tolerance 5 mm", ()), ("tolerance 5 mm, variable", VARIABLE), ("tolerance 5 mm, Newton", ("-relaxation_method", "preconditioned"))):
        scene.ways[name] = Way(keys=changed(keys, contact={"tolerance": 5e-3}), options=options)
    return scene


# ---- stages ----------------------------------------------------------------------------------------------

def at_once(rng):
    """Weight before the push and both at once, joints with and without cohesion; where joints slip on the way the answer may hang on it."""
    make = (dam_scene, wall_scene, column_scene)[int(rng.integers(3))]
    scene = make(rng)
    scene.keys["stages"] = scene.keys["stages"][:2]
    row = scene.keys["joints"]["base" if make is dam_scene else "default"]
    if rng.random() < 0.7:
        row["cohesion"] = float(10 ** rng.uniform(3, 5.5))
        row["tension"] = 0.0 if rng.random() < 0.5 else float(row["cohesion"] * rng.uniform(0.2, 0.9))
    row["friction"] = float(rng.uniform(50, 65))
    scene.kind = "stages"
    once = changed(scene.keys, stages=scene.keys["stages"][1:])
    fifth = copy.deepcopy(scene.keys)  # a part of the second load first
    second = list(fifth["loads"])[1]
    part = copy.deepcopy(fifth["loads"][second])
    if part["type"] == "reservoir":
        part["level"] *= 0.5
    else:
        part["value"] = [0.5 * value for value in part["value"]]
    fifth["loads"]["half"] = part
    name, last = next(iter(fifth["stages"][1].items()))
    fifth["stages"] = [{"own": {"loads": ["weight"]}}, {"part": {"loads": ["weight", "half"]}}, {name: last}]
    for way, keys, options in (("at once", once, ()), ("in three", fifth, ()), ("at once, variable", once, VARIABLE), ("in three, variable", fifth, VARIABLE)):
        scene.ways[way] = Way(keys=keys, options=options, last=True, slipped=False)
    return solved(scene, ranks=())


KINDS = (images, numbers, rounds, layer, at_once)
