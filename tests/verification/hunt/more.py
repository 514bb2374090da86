"""Scenes with more in them: a dam with cohesion and uplift in its crack under a flood, an anchored one, a slope of columns, an arch, blocks that are shaken."""

import numpy as np
from methods import dam_scene
from quoin_tools.mesh.meshing import join, rectangle, renamed
from quoin_tools.mesh.walls import arch, slope
from runs import Scene, elastic, frame, joint, solved

G = 9.81


def cracked_scene(rng, **shape):
    """Weight, water with uplift, then a flood; joints with and without cohesion, tension, residuals, drains."""
    scene = dam_scene(rng, **shape)
    if rng.random() < 0.5:
        scene.mesh.group_rigid[:] = 1
        scene.condensed = []
        scene.keys["supports"] = {"rock": {"fix": "xy"}}
        scene.keys["relaxation"].pop("groups")
    keys, row = scene.keys, scene.keys["joints"]["base"]
    if rng.random() < 0.6:
        row["cohesion"] = float(10 ** rng.uniform(4, 5.7))
        row["tension"] = float(row["cohesion"] * rng.choice([0.0, rng.uniform(0.1, 0.8)]))
        row["friction_residual"] = float(row["friction"] * rng.uniform(0.7, 1))
    height = float(scene.mesh.vertices[scene.mesh.points["crest_upstream"], 1])
    toe = float(scene.mesh.vertices[scene.mesh.points["toe"], 0])
    level = float(rng.uniform(0.5, 0.9) * height)
    keys["loads"]["water"]["level"] = level
    uplift = {"type": "uplift", "faces": "base", "level": level, "cracked": bool(rng.random() < 0.7)}
    if rng.random() < 0.6:
        uplift |= {"rule": "npb", "drain": float(rng.uniform(0.1, 0.3) * toe)}
    keys["loads"]["uplift"] = uplift
    acts = ["weight", "water", "uplift"]
    keys["stages"] = [{"sw": {"loads": ["weight"]}}, {"full": {"loads": acts}},
                      {"limit": {"type": "flood", "loads": acts, "step": 0.2 * height, "limit": 1.2 * height, "bracket": 0.01 * height}}]
    scene.kind = "cracked"
    return scene


def anchored_scene(rng, **shape):
    """Tendons that are stressed after the weight, then water, whose density a load factor raises."""
    scene = dam_scene(rng, **shape)
    keys = scene.keys
    points = {name: scene.mesh.vertices[at] for name, at in scene.mesh.points.items()}
    crest, height = 0.6 * points["crest_upstream"] + 0.4 * points["crest_downstream"], float(points["crest_upstream"][1])
    lean = float(rng.uniform(0, 0.15))
    pull = float(rng.uniform(0.02, 0.15) * 2400 * G * height * points["toe"][0] * 0.5)
    keys["anchors"] = {"a": {"head": [float(crest[0]), 0.97 * height], "root": [float(crest[0] + lean * height), -0.4 * height], "area": float(pull / 1e9), "young": 195e9, "prestress": pull, "lock": "stressing"}}
    if rng.random() < 0.5:
        keys["anchors"]["b"] = {"head": [float(crest[0]), 0.9 * height], "root": [float(crest[0]), -0.3 * height], "area": float(pull / 1e9), "young": 195e9}
    acts = ["weight", "water"]
    keys["stages"] = [{"sw": {"loads": ["weight"]}}, {"stressing": {"loads": ["weight"]}}, {"full": {"loads": acts}},
                      {"limit": {"type": "load_factor", "loads": acts, "raises": ["water"], "step": 0.25, "limit": 6, "bracket": 0.01}}]
    scene.kind = "anchored"
    scene.condensed = []
    return scene


def toppling_scene(rng):
    """Columns on a stepped base: k_h to the limit."""
    columns, rigid = int(rng.integers(4, 10)), bool(rng.random() < 0.6)
    mesh = slope(columns, int(rng.integers(-(-3 * columns // 4), columns + 1)), 10.0, float(rng.uniform(10, 25)), 1.0, 4.0, 4.0, rigid=rigid)
    row = joint(rng, (9, 10), (38, 50))
    push = {"type": "pseudo_static", "coefficient": [-1.0, 0.0], "groups": ["block"]}
    keys = frame(materials={"base": {"density": 0}, "block": {"density": 2500.0} if rigid else elastic(rng)}, joints={"default": row}, supports={"base": {"fix": "xy"}},
                 loads={"weight": {"type": "self_weight", "groups": ["block"]}, "push": push},
                 stages=[{"sw": {"loads": ["weight"]}}, {"limit": {"type": "load_factor", "loads": ["weight", "push"], "raises": ["push"], "start": 0, "step": 0.05, "limit": 3, "bracket": 0.002}}])
    return Scene("toppling", mesh, keys, condensed=[] if rigid else ["block"])


def arch_scene(rng):
    """An arch under its weight and a force beside its crown, raised to the limit."""
    rigid, span = bool(rng.random() < 0.6), float(rng.uniform(80, 150))
    radius, thick = 10.0, float(rng.uniform(1.0, 2.5))
    mesh = arch(int(rng.integers(5, 14)), radius, thick, span, divide=(1, 1) if rigid else (1, 2), rigid=rigid)
    loads = {"weight": {"type": "self_weight", "groups": ["voussoir"]}, "push": {"type": "point_force", "point": "crown_extrados", "value": [float(rng.uniform(0.5, 3) * 1e4), float(-rng.uniform(0.5, 3) * 1e4)]}}
    groups = [name for name in mesh.group_names if name != "voussoir"]
    keys = frame(materials={name: {"density": 0} for name in groups} | {"voussoir": {"density": 2400.0} if rigid else elastic(rng)}, joints={"default": joint(rng, (9.5, 10.5), (35, 45))},
                 supports={name: {"fix": "xy"} for name in groups}, loads=loads,
                 stages=[{"sw": {"loads": ["weight"]}}, {"limit": {"type": "load_factor", "loads": ["weight", "push"], "raises": ["push"], "step": 1, "limit": 60, "bracket": 0.02}}])
    return Scene("arch", mesh, keys, condensed=[] if rigid else ["voussoir"])


def shaken_scene(rng):
    """Blocks in a column or a row on a base that shakes for a second, with dashpots in their joints: motion, slip, rocking."""
    n, size, rigid = int(rng.integers(1, 4)), float(rng.uniform(0.5, 3)), bool(rng.random() < 0.6)
    slender = float(rng.uniform(0.5, 2.5))
    ground = renamed(rectangle(-2 * size, -size, 6 * size, size, group="base", rigid=True))
    bodies = [renamed(rectangle(0, i * slender * size, size, slender * size, 1 if rigid else 2, 1 if rigid else 2, group="block", rigid=rigid), {}, {f"block_{i}": "top_left"}) for i in range(n)]
    k_n = float(10 ** rng.uniform(8, 9.3))
    t = np.linspace(0, 1, 101)
    wave = float(rng.uniform(1, 5)) * np.sin(2 * np.pi * float(rng.uniform(1, 5)) * t) * np.sin(np.pi * t) ** 2
    stuff = {"density": 2400.0} if rigid else {"density": 2400.0, "young": 1e9, "poisson": 0.2}
    keys = frame(materials={"base": {"density": 0}, "block": stuff}, supports={"base": {"fix": "xy", "motion": "shake.csv", "quantity": "acceleration"}},
                 joints={"default": {"k_n": k_n, "k_s": float(k_n * rng.uniform(0.3, 1)), "friction": float(rng.uniform(15, 40)), "damping": 1e-3}},
                 loads={"weight": {"type": "self_weight", "groups": ["block"]}},
                 stages=[{"rest": {"loads": ["weight"]}}, {"shaken": {"type": "dynamic", "loads": ["weight"], "duration": 1.2, "dt_factor": 0.5, "alpha": 0, "beta": 1e-4}}])
    scene = Scene("shaken", join([ground, *bodies]), keys, files={"shake.csv": "".join(f"{a}, {b}, 0\n" for a, b in zip(t, wave)), "mirrored.csv": "".join(f"{a}, {-b}, 0\n" for a, b in zip(t, wave))})
    scene.newton = False
    return scene


MORE = (cracked_scene, anchored_scene, toppling_scene, arch_scene, shaken_scene)


def more(make):
    def kind(rng):
        scene = make(rng)
        return solved(scene, ranks=(2, 3) if rng.random() < 0.3 else (2,), newton=scene.newton)
    kind.__name__ = make.__name__.removesuffix("_scene")
    return kind


KINDS = tuple(more(make) for make in MORE)
