"""A flood with several waters: the highest reservoir rises alone, silt and tailwater stay, uplift follows the reservoirs it belongs to.

Rigid wall 20 m by 40 m on rock, water 30 m, silt 10 m (250 kg/m3 more), tailwater 8 m, uplift linear between water and tailwater:
N and T of every trial, and the level at which T = N tan(phi), by hand."""

import math

from driver import changed
from quoin_tools.base import scene as scenes
from quoin_tools.mesh.meshing import join, rectangle, renamed

WHAT = "flood with silt and tailwater: what rises, uplift with it, N and T of each trial, limit level"
SOURCE = "statics: T = rho g (h^2 - t^2) / 2 + silt, N = W - rho g (h + t) B / 2; slides at T = N tan(phi)"
BY = "by hand"

B, H, SILT, TAIL, PHI, G = 20.0, 40.0, 10.0, 8.0, 24.0, 9.81
SCENE = {
    "relaxation": {"tolerance": 1e-8},
    "materials": {name: {"density": 2400, "rigid": True} for name in ("dam", "base")},
    "joints": {"default": {"k_n": 10e9, "k_s": 10e9, "friction": PHI}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": {"type": "reservoir", "faces": "upstream", "level": 30},
              "silt": {"type": "reservoir", "faces": "upstream", "level": SILT, "density": 250},
              "tail": {"type": "reservoir", "faces": "downstream", "level": TAIL},
              "uplift": {"type": "uplift", "faces": "joint", "level": 30, "tailwater": TAIL}},
}
LOADS = list(SCENE["loads"])
FLOOD = {"type": "flood", "loads": LOADS, "step": 2, "bracket": 0.05, "limit": 39}


def by_hand(water, tail=TAIL):
    normal = B * H * 2400 * G - 1000 * G * (water + tail) / 2 * B
    shear = 1000 * G * (water**2 - tail**2) / 2 + 250 * G * SILT**2 / 2
    return normal, shear


def run(case):
    ground = renamed(rectangle(-20, -10, 60, 10, group="base", rigid=True), {"joint": "top"})
    mesh = join([ground, renamed(rectangle(0, 0, B, H, group="dam", rigid=True), {"joint": "bottom", "upstream": "left", "downstream": "right"})])
    highest(case, mesh)
    tailwater(case, mesh)
    refused(case, mesh)


def highest(case, mesh):
    result = case.run(mesh, changed(SCENE, ("stages", [{"full": {"loads": LOADS}}, {"flood": FLOOD}])))
    found = result.stage_summary("flood")["flood"]
    for trial in found["trials"][:3]:
        wanted, joint = by_hand(trial["value"]), trial["joints"]["default"]
        case.check(f"water at {trial['value']:g} m: N and T [N]", [joint["N"], joint["T"]], wanted, relative=1e-5)
        levels = {name: list(water.values()) for name, water in trial["waters"].items()}
        case.check("... levels of all waters", levels, {"water": [trial["value"]], "silt": [SILT], "tail": [TAIL], "uplift": [trial["value"], TAIL]})
    low, high = 30.0, 40.0
    while high - low > 1e-9:
        middle = (low + high) / 2
        normal, shear = by_hand(middle)
        low, high = (middle, high) if shear < normal * math.tan(math.radians(PHI)) else (low, middle)
    case.check("highest stable level, T = N tan(phi) [m]", found["stable"], low, absolute=0.06)
    case.check("... lowest failing one", found["failing"], low, absolute=0.06)
    used = scenes.of_run(result.folder, result.summary).stage_loads("flood")
    case.check("levels of the sheet's gravity method", [used[name]["level"] for name in ("water", "silt", "tail", "uplift")],
               [found["stable"], SILT, TAIL, found["stable"]], absolute=1e-12)


def tailwater(case, mesh):
    """What rises is named: the tailwater, and the toe of the uplift with it."""
    flood = FLOOD | {"rises": ["tail"], "limit": 12, "bracket": 0}
    result = case.run(mesh, changed(SCENE, ("stages", [{"full": {"loads": LOADS}}, {"flood": flood}])))
    trials = result.stage_summary("flood")["flood"]["trials"]
    case.check("tailwater rises: values of the trials [m]", [t["value"] for t in trials], [8, 10, 12], absolute=1e-9)
    joint = trials[-1]["joints"]["default"]
    case.check("... N and T at 12 m [N]", [joint["N"], joint["T"]], by_hand(30, 12), relative=1e-5)


def refused(case, mesh):
    """Where it is not plain what rises, the run asks."""
    for changes, words in (((("loads.silt.level", 30),), "rises: 2 reservoirs stand at the highest level, 30 m"),
                           ((("loads.uplift.level", 29),), "loads.uplift has the level 29 m, which no reservoir of this stage has"),
                           ((("stages", [{"flood": FLOOD | {"rises": ["weight"]}}]),), "'weight' is no reservoir, overflow, tailwater, uplift or head of this stage")):
        result = case.run(mesh, changed(SCENE, ("stages", [{"flood": FLOOD}]), *changes))
        case.check(f"refused: {words}", [result.exit_code, words in result.stderr], [2, True])
