"""The arch that Lemos and Sarhosis shake (3DEC), and the thinnest half circle of Milankovitch and of Makris and Alexakis."""

import os
from pathlib import Path

import assemblies
import models
import numpy as np
import yaml
from driver import PUBLISHED
from quoin_tools.limit.bounds import bound

WHAT = "arches: under a pulse beside 3DEC, the least thickness by Milankovitch and by Makris and Alexakis"
SOURCE = "Lemos and Sarhosis 2023, Makris and Alexakis 2013 (examples/published/problems.yaml)"
BY = "3DEC; Milankovitch; Makris and Alexakis"


def run(case):
    os.environ["QUOIN_SOLVER"] = str(Path(case.quoin).resolve())
    elastic(case)
    pulse(case)
    thinnest(case)


def crown(result):
    """t [s] of the pulse and the crown's motion along x since it began, relative to the ground [mm]."""
    told = result.history
    moved = 1e3 * (0.5 * (told["crown_left_ux_m"] + told["crown_right_ux_m"]) - told["ground_ux_m"])
    shaken = told["time_s"] > 0
    return told["time_s"][shaken], moved[shaken] - moved[~shaken][-1]


def linear(damped=True):
    """The elastic arch without Quoin: 17 rigid bodies on springs at three points of each joint, dashpots of the stiffness everywhere; largest motion of the crown, 4.25 m high [mm]."""
    mesh = models.arch_of_lemos()
    stones = [mesh.vertices[block] for block, group in zip(mesh.blocks, mesh.block_group, strict=True) if mesh.group_names[group] == "voussoir"]
    angles, mass, centres = np.linspace(0, np.pi, 18), [], []
    for corner in stones:
        after = np.roll(corner, -1, axis=0)
        cross = corner[:, 0] * after[:, 1] - corner[:, 1] * after[:, 0]
        area = cross.sum() / 2
        centres.append(((corner + after) * cross[:, None]).sum(axis=0) / (6 * area))
        polar = (cross * ((corner**2).sum(axis=1) + (corner * after).sum(axis=1) + (after**2).sum(axis=1))).sum() / 12 - area * (centres[-1] ** 2).sum()
        mass += [2700 * area, 2700 * area, 2700 * polar]
    stiffness = np.zeros((51, 51))
    for joint, angle in enumerate(angles):
        ray = np.array([np.cos(angle), np.sin(angle)])
        for radius, part in ((3.75, 0.25), (4.0, 0.5), (4.25, 0.25)):
            for axis in (ray, np.array([-ray[1], ray[0]])):
                row = np.zeros(51)
                for body, sign in ((joint, 1), (joint - 1, -1)):
                    if 0 <= body < 17:
                        x, y = radius * ray - centres[body]
                        row[3 * body : 3 * body + 3] = sign * np.array([axis[0], axis[1], axis[1] * x - axis[0] * y])
                stiffness += 10e9 * part * 0.5 * np.outer(row, row)
    load, step, beta = np.array(mass) * np.tile([1.5, 0, 0], 17), 1e-4, 1.447e-3 * damped
    inverse = np.linalg.inv(np.diag(mass) + (step / 2 * beta + step**2 / 4) * stiffness)
    u, v, a, most = np.zeros(51), np.zeros(51), np.zeros(51), 0.0
    for k in range(1, 3000):  # Newmark's mean acceleration
        force = load * np.sin(4 * np.pi * k * step) * (k * step < 0.25)
        new = inverse @ (force - stiffness @ (u + step * v + step**2 / 4 * a + beta * (v + step / 2 * a)))
        u, v, a = u + step * v + step**2 / 4 * (a + new), v + step / 2 * (a + new), new
        most = max(most, 1e3 * (u[24] - u[26] * (4.25 - centres[8][1])))
    return most


def elastic(case):
    result = case.scene_of("arch_elastic")
    t, u = crown(result)
    ours = {"largest displacement of the crown [mm]": u.max(), "at [s]": t[u.argmax()]}
    if not case.short:
        told, shaken = result.history, result.history["time_s"] > 0
        turned = (told["crown_right_uy_m"] - told["crown_left_uy_m"]) / (2 * 4.25 * np.sin(np.pi / 34))
        ours["largest, crown 18 mm higher, on the circle [mm]"] = (u - 1e3 * 4.25 * (1 - np.cos(np.pi / 34)) * (turned[shaken] - turned[~shaken][-1])).max()
        case.check("the linear model of the elastic arch, with and without dashpots [mm]", [linear(), linear(False)], [0.29839, 0.31769], relative=1e-4)
        ours["largest, dashpots 1.5 times as strong [mm]"] = crown(case.scene_of("arch_elastic", None, ("joints.default.damping", 2.17e-3)))[1].max()
        ours["largest, faces in full contact [mm]"] = crown(case.scene_of("arch_elastic", models.arch_of_lemos(), ("joints.default.stress_model", "tptm")))[1].max()
    case.published("arch_elastic", ours)


def pulse(case):
    t, u = crown(case.scene_of("arch_pulse", None, ("stages.1.pulse.duration", 0.6 if case.short else 1.5)))
    times = {f"at {at} s [mm]": float(np.interp(at, t, u)) for at in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0) if at <= t[-1] + 1e-3}
    ours = {"largest displacement of the crown [mm]": u.max(), "at [s]": t[u.argmax()]} | times
    curves = {"three points": (t, u)}
    if not case.short:
        ours |= {"least displacement [mm]": u.min(), "at the time of the least [s]": t[u.argmin()]}
        t, u = crown(case.scene_of("arch_pulse", None, ("joints.default.damping", 0.5 * 1.447e-3)))
        ours |= {"largest, dashpots half as strong [mm]": u.max(), "at 0.8 s, dashpots half as strong [mm]": float(np.interp(0.8, t, u))}
        t, u = crown(case.scene_of("arch_pulse", None, ("joints.default.damping", 1.5 * 1.447e-3)))
        ours |= {"at 1.0 s, dashpots 1.5 times as strong [mm]": float(np.interp(1.0, t, u)), "least, dashpots 1.5 times as strong [mm]": u.min()}
        rigid = case.scene_of("arch_pulse", models.arch_of_lemos(), ("joints.default", {"k_n": 1e12, "k_s": 1e12, "friction": 35, "damping": 1.447e-5}))
        curves["full contact, 100 times the stiffness"] = crown(rigid)
        ours["largest, faces in full contact with 100 times the stiffness [mm]"] = curves["full contact, 100 times the stiffness"][1].max()
        falling = case.scene_of("arch_pulse", models.arch_of_lemos(), ("joints.default.stress_model", "tptm"), ("stages.1.pulse.duration", 1.0))
        t, u = crown(falling)
        curves["full contact, the same stiffness"] = t[u < 40], u[u < 40]
        ours["at 0.5 s, faces in full contact [mm]"] = float(np.interp(0.5, t, u))
    case.published("arch_pulse", ours, curves)


def least(cut, stones):
    """Thickness over mean radius at which the arch bears no push at all any more."""
    scene = assemblies.scene_of(yaml.safe_load((PUBLISHED / f"arch_{cut}.yaml").read_text(encoding="utf-8")))
    falls, stands = 0.1, 0.12
    while stands - falls > 1e-5:
        middle = 0.5 * (falls + stands)
        if bound(models.least_arch(middle, cut, stones), scene, "push").value:
            stands = middle
        else:
            falls = middle
    return stands


def thinnest(case):
    for cut in ("radial", "vertical"):
        case.published(f"arch_{cut}", {"thickness over radius": least(cut, 120)} | ({} if case.short else {"... of 30 stones": least(cut, 30)}))
