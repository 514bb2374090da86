"""A block of 1 m slides over two fixed blocks of 1 m, from the first onto the second (V24): pushed, and by its weight.

On two ranks, cut in stripes, the two fixed blocks belong to different ranks: the slider crosses their border."""

import numpy as np
from driver import changed
from quoin_tools.mesh.meshing import join, rectangle, renamed

WHAT = "a slider crosses from one block to the next: no jump in its forces (V24)"
SOURCE = "N = sigma L = 1 MN and T = N tan(phi) all the way; the lengths of the contacts add up to 1 m"
BY = "by hand"

N, PHI, K_N = 1e6, 30.0, 10e9
SCENE = {
    "partition": "stripes",
    "contact": {"connectivity": "variable", "tolerance": 0.002},
    "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9},
    "materials": {"slider": {"density": 2400}, "left": {"density": 0}, "right": {"density": 0}},
    "joints": {"default": {"k_n": K_N, "k_s": 1e11, "friction": PHI}},
    "supports": {"left": {"fix": "xy"}, "right": {"fix": "xy"}},
    "loads": {"press": {"type": "traction", "faces": "top", "value": [0, -N]}},
    "stages": [{"press": {"loads": ["press"]}},
               {"cross": {"type": "dynamic", "loads": ["press"], "duration": 1.0, "dt_factor": 0.2, "alpha": 500.0,
                          "frames": 199}}],
}


def three_blocks(height):
    fixed = [renamed(rectangle(x, -1, 1, 1, group=name, rigid=True), {}) for x, name in ((0, "left"), (1, "right"))]
    return join([*fixed,
                 renamed(rectangle(0, 0, 1, height, group="slider", rigid=True), {"top": "top"}, {"corner": "bottom_left"})])


def forces(result):
    """Of every frame: N, T, sum of lengths, number of contacts below the slider, mean opening over its ends."""
    rows = []
    for name in [*result.frames("cross"), "cross"]:
        c = result.stage(name).contacts
        below = np.abs(c.normal[:, 0, 1]) > 0.6  # not the sides of the two fixed blocks
        force = c.force[below].sum(axis=(0, 1))
        opening = (c.opening[below].mean(axis=1) @ c.length[below]) / c.length[below].sum()
        rows.append([-force[0], abs(force[1]), c.length[below].sum(), below.sum(), opening])
    return np.array(rows)


def run(case):
    for model in case.some(("pt", "t2pt", "tptm")):
        pushed(case, model)
        free(case, model)


def pushed(case, model):
    """Pushed at 1 m/s and held level, under 1 MPa."""
    scene = changed(SCENE, ("joints.default.stress_model", model),
                    ("supports.rail", {"fix": "x", "target": "slider", "motion": "motion.csv"}))
    folder = case.prepare(three_blocks(1.0), scene)
    (folder / "motion.csv").write_text("0, 1, 0\n2, 1, 0\n")
    result = case.again(folder)
    name = f"{model}, pushed"
    check_forces(case, name, forces(result), N, PHI)
    case.check(f"{name}: moved [m]", result.probe("cross", "corner")[0], 1.0, relative=1e-6)
    case.check(f"{name}: work of the support: T 1 m, nothing catches [J]", result.stage_summary("cross")["energy"]["supports"],
               N * np.tan(np.radians(PHI)), relative=0.005)
    across_ranks(case, name, folder, result, N, PHI, (2, 3) if model == "tptm" else (2,))


def free(case, model):
    """Slides down a plane of 30 degrees by its own weight, free to turn."""
    slope, phi, v, g = np.radians(30), 20.0, 1.0, 9.81
    down = np.array([np.cos(slope), -np.sin(slope)])
    mesh = three_blocks(0.2)
    mesh.vertices = mesh.vertices @ np.array([down, [np.sin(slope), np.cos(slope)]])
    a = g * (np.sin(slope) - np.cos(slope) * np.tan(np.radians(phi)))
    t = (np.sqrt(v**2 + 2 * a) - v) / a  # to slide 1 m
    stages = [{"rest": {"loads": ["weight"]}},
              {"cross": {"type": "dynamic", "loads": ["weight"], "duration": t, "dt_factor": 0.1, "frames": 199,
                         "joints": {"default": {"friction": phi}}}}]
    scene = changed(SCENE, ("loads", {"weight": {"type": "self_weight", "groups": ["slider"]}}), ("stages", stages),
                    ("joints.default", {"k_n": K_N, "k_s": K_N, "friction": 45, "stress_model": model, "damping": 1e-4}),
                    ("materials.slider.velocity", (v * down).tolist()))
    folder = case.prepare(mesh, scene)
    result = case.again(folder)
    name, normal = f"{model}, free", 2400 * 0.2 * g * np.cos(slope)
    check_forces(case, name, forces(result), normal, phi)
    moved = result.probe("cross", "corner") - result.probe("rest", "corner")
    case.check(f"{name}: slid down the plane, and off it [m]", [moved @ down, moved @ [-down[1], down[0]]], [1.0, 0.0],
               absolute=5e-4)
    energy = result.stage_summary("cross")["energy"]
    case.check(f"{name}: lost in friction: N tan(phi) 1 m [J]", energy["friction"], normal * np.tan(np.radians(phi)),
               relative=0.005)
    case.check(f"{name}: energy balance over the work of the weight", energy["balance"] / energy["outside"], 0.0, absolute=1e-4)
    across_ranks(case, name, folder, result, normal, phi, (2,))


def across_ranks(case, name, folder, one, normal, phi, all_ranks):
    """The same run with the border of two ranks under the slider; `one`: on one rank."""
    for ranks in case.ranks(*all_ranks):
        checksum = one.stage_summary("cross")["checksum"]
        result = case.again(folder, ranks=ranks)
        owner = {result.mesh.group_names[g]: int(rank) for g, rank in zip(result.mesh.block_group, result.mesh.rank)}
        case.check(f"{name}, {ranks} ranks: left and right block on different ranks", owner["left"] != owner["right"], True)
        check_forces(case, f"{name}, {ranks} ranks", forces(result), normal, phi)
        case.check(f"{name}: same bits on {ranks} ranks", result.stage_summary("cross")["checksum"], checksum)


def check_forces(case, name, rows, normal, phi):
    rows = rows[1:]
    assert rows[50:150, 3].max() == 2, "the slider never stood on both"
    case.check(f"{name}: N [N]", rows[:, 0], normal, relative=0.005)
    case.check(f"{name}: T [N]", rows[:, 1], normal * np.tan(np.radians(phi)), relative=0.005)
    case.check(f"{name}: sum of the lengths [m]", rows[:, 2], 1.0, absolute=1e-3)
    case.check(f"{name}: mean opening [m]", rows[:, 4], -normal / K_N, relative=0.005)
