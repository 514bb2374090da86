"""Walls 1 to 3 of Ferris and Tin-Loi (2001) under a horizontal part of their weight: explicit runs, whose joints do not dilate, the bound with dilation, and pushes past the peak."""

import os
from pathlib import Path

import assemblies
import models
import numpy as np
import yaml
from driver import PUBLISHED
from quoin_tools.limit.bounds import bound

WHAT = "walls of Ferris and Tin-Loi: limits with and without dilation"
SOURCE = "Ferris and Tin-Loi 2001 and two independent programmes (examples/published/problems.yaml)"
BY = "literature; independent programmes and explicit runs of this project"

SOFT = ("k_n of 10 GPa/m", {"k_n": 1e10, "k_s": 1e10})
CHANGED = {1: [SOFT], 2: [SOFT], 3: [SOFT, ("forces at the corners (pt)", {"stress_model": "pt"}), ("k_n of 1000 GPa/m", {"k_n": 1e12, "k_s": 1e12})]}


def run(case):
    os.environ["QUOIN_SOLVER"] = str(Path(case.quoin).resolve())
    for number in case.some((1, 3, 2)):
        name = f"wall_{number}"
        scene = yaml.safe_load((PUBLISHED / f"{name}.yaml").read_text(encoding="utf-8"))
        ours = {"limit with dilation, k_h": bound(models.MESHES[name](), assemblies.scene_of(scene), "push").value}
        found = case.scene_of(name, None, ("stages.1.push.bracket", 0.02 if case.short else 0.00125)).stage_summary("push")["load_factor"]
        ours["limit without dilation, middle of what stands and fails, k_h"] = (found["stable"] + found["failing"]) / 2
        for what, changes in () if case.short else CHANGED[number]:
            found = case.scene_of(name, None, ("joints.default", scene["joints"]["default"] | changes), ("stages.1.push.bracket", 0.00125)).stage_summary("push")["load_factor"]
            ours[f"... {what}, k_h"] = (found["stable"] + found["failing"]) / 2
        case.published(name, ours)
    pushed(case)


def pushed(case):
    ours, curves = {}, {}
    for number in case.some((1, 3, 2)):
        crest, factor = curve(case, number, *([("stages.1.push.path", [0.0005, 0.002])] if case.short else []))
        ours[f"wall {number}, largest factor in large strain"], curves[f"wall {number}"] = factor.max(), (crest, factor)
    if not case.short:
        for number in (1, 2, 3):
            ours[f"wall {number}, k_n of 10 GPa/m"] = curve(case, number, ("joints.default.k_n", 1e10), ("joints.default.k_s", 1e10))[1].max()
    case.published("walls_pushed", ours, curves)


def curve(case, number, *changes):
    """Returns displacements of the crest [m] and factors of the weight, of increments that found their equilibrium."""
    result = case.scene_of("walls_pushed", models.wall_with_crest(number), *changes)
    found, history = result.stage_summary("push")["pushover"], result.history
    rows = np.flatnonzero(np.isfinite(history["push_N"]))[np.array(found["equilibrium"]) == 1]
    return history["crest_ux_m"][rows], history["push_N"][rows] / found["load"]
