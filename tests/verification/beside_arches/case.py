"""The arch that Lemos and Sarhosis shake (3DEC), and the thinnest half circle of Milankovitch and of Makris and Alexakis."""

import os
from pathlib import Path

import assemblies
import meshes
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


def elastic(case):
    t, u = crown(case.scene_of("arch_elastic"))
    ours = {"largest displacement of the crown [mm]": u.max(), "at [s]": t[u.argmax()]}
    if not case.short:
        ours["largest, dashpots 1.5 times as strong [mm]"] = crown(case.scene_of("arch_elastic", None, ("joints.default.damping", 2.17e-3)))[1].max()
        ours["largest, faces in full contact [mm]"] = crown(case.scene_of("arch_elastic", meshes.arch_of_lemos(), ("joints.default.stress_model", "tptm")))[1].max()
    case.published("arch_elastic", ours)


def pulse(case):
    t, u = crown(case.scene_of("arch_pulse", None, ("stages.1.pulse.duration", 0.6 if case.short else 1.5)))
    times = {f"at {at} s [mm]": float(np.interp(at, t, u)) for at in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0) if at <= t[-1] + 1e-3}
    ours = {"largest displacement of the crown [mm]": u.max(), "at [s]": t[u.argmax()]} | times
    if not case.short:
        ours |= {"least displacement [mm]": u.min(), "at the time of the least [s]": t[u.argmin()]}
        rigid = case.scene_of("arch_pulse", meshes.arch_of_lemos(), ("joints.default", {"k_n": 1e12, "k_s": 1e12, "friction": 35, "damping": 1.447e-5}))
        ours["largest, faces in full contact with 100 times the stiffness [mm]"] = crown(rigid)[1].max()
    case.published("arch_pulse", ours)


def least(cut, stones):
    """Thickness over mean radius at which the arch bears no push at all any more."""
    scene = assemblies.scene_of(yaml.safe_load((PUBLISHED / f"arch_{cut}.yaml").read_text(encoding="utf-8")))
    falls, stands = 0.1, 0.12
    while stands - falls > 1e-5:
        middle = 0.5 * (falls + stands)
        if bound(meshes.least_arch(middle, cut, stones), scene, "push").value:
            stands = middle
        else:
            falls = middle
    return stands


def thinnest(case):
    for cut in ("radial", "vertical"):
        case.published(f"arch_{cut}", {"thickness over radius": least(cut, 120)} | ({} if case.short else {"... of 30 stones": least(cut, 30)}))
