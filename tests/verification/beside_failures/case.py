"""Failures of real dams, with nothing fitted to them: at which level of the water does which section of Bouzey dam fail (slid in 1884, broke in 1895)?"""

import os
from pathlib import Path

import assemblies
import models
import yaml
from driver import PUBLISHED
from quoin_tools.limit.bounds import bound

WHAT = "Bouzey dam: level and section at which it fails, as it was built and as it was strengthened"
SOURCE = "facts of 1884 and 1895; levels by the gravity method by hand (examples/published/problems.yaml)"
BY = "what happened; the gravity method by hand"

CREST = 22  # m above the foundation


def run(case):
    os.environ["QUOIN_SOLVER"] = str(Path(case.quoin).resolve())
    for name in ("bouzey_1884", "bouzey_1895"):
        dry = (("stages.2.flood.loads", ["weight", "water"]), ("stages.1.filled.loads", ["weight", "water"]))
        ours = {}
        for what, changes in (("level of the water at which it fails [m]", ()), ("... friction of 1.0 [m]", (("joints.default.friction", 45),)),
                              ("... without uplift, as was reckoned in 1880 [m]", dry)):
            if case.short and changes and name == "bouzey_1884":
                continue
            ours[what], joint = failing(case.scene_of(name, None, *changes))
            if not changes:
                ours["depth of the section that fails [m]"] = CREST - models.BOUZEY_LIFTS[int(joint[1:])]
        if name == "bouzey_1895":
            ours["... 5.60 m thick 12 m below the crest [m]"], _ = failing(case.scene_of(name, models.bouzey(4, 10)))
        if not case.short:
            ours["... with dilation (quoin limit) [m]"] = bound(models.MESHES[name](), assemblies.scene_of(scene_of(name)), "flood").value
        case.published(name, ours, {"each section alone": sections(case)} if name == "bouzey_1884" and not case.short else None)


def scene_of(name):
    return yaml.safe_load((PUBLISHED / f"{name}.yaml").read_text(encoding="utf-8"))


def sections(case):
    """Level of the water [m] at which each section fails, and its height [m]: what stands below it is held."""
    levels = []
    for i, height in enumerate(models.BOUZEY_LIFTS[:-1]):
        scene = scene_of("bouzey_1884")
        scene["joints"] = {"default": scene["joints"]["default"], f"j{i}": {}}
        scene["loads"] = {name: load for name, load in scene["loads"].items() if name in ("weight", "water")} | {"u": scene["loads"]["u0"] | {"faces": f"j{i}"}}
        for load in ("water", "u"):
            scene["loads"][load]["level"] = height + 5
        for stage, name in zip(scene["stages"], ("built", "filled", "flood"), strict=True):
            stage[name]["loads"] = ["weight", "water", "u"][: 1 if name == "built" else 3]
        levels.append(failing(case.run(models.bouzey(i), scene))[0])
    return levels, models.BOUZEY_LIFTS[:-1]


def failing(result):
    """Middle of what stands and fails [m above the foundation], and the joint that moves fastest."""
    told = result.stage_summary("flood")
    moves = told["mechanism"]
    return (told["flood"]["stable"] + told["flood"]["failing"]) / 2, max(moves, key=lambda joint: max(moves[joint]["slides"], moves[joint]["opens"]))
