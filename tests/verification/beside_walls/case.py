"""Walls 1 to 3 of Ferris and Tin-Loi (2001) under a horizontal part of their weight: explicit runs, whose joints do not dilate, and the bound with dilation."""

import os
from pathlib import Path

import assemblies
import models
import yaml
from driver import PUBLISHED
from quoin_tools.limit.bounds import bound

WHAT = "walls of Ferris and Tin-Loi: limits with and without dilation"
SOURCE = "Ferris and Tin-Loi 2001 and two independent programmes (examples/published/problems.yaml)"
BY = "literature; independent programmes and explicit runs of this project"


def run(case):
    os.environ["QUOIN_SOLVER"] = str(Path(case.quoin).resolve())
    for number in case.some((1, 3, 2)):
        name = f"wall_{number}"
        scene = yaml.safe_load((PUBLISHED / f"{name}.yaml").read_text(encoding="utf-8"))
        ours = {"limit with dilation, k_h": bound(models.MESHES[name](), assemblies.scene_of(scene), "push").value}
        found = case.scene_of(name, None, ("stages.1.push.bracket", 0.02 if case.short else 0.00125)).stage_summary("push")["load_factor"]
        ours["limit without dilation, middle of what stands and fails, k_h"] = (found["stable"] + found["failing"]) / 2
        if number == 3 and not case.short:
            for what, changes in (("forces at the corners (pt)", {"stress_model": "pt"}), ("k_n of 1000 GPa/m", {"k_n": 1e12, "k_s": 1e12})):
                found = case.scene_of(name, None, ("joints.default", scene["joints"]["default"] | changes), ("stages.1.push.bracket", 0.00125)).stage_summary("push")["load_factor"]
                ours[f"... {what}, k_h"] = (found["stable"] + found["failing"]) / 2
        case.published(name, ours)
