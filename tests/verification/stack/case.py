"""Columns of blocks: two rigid ones under their weight (V04), ten deformable ones under weight, pressure and shear (V21)."""

import numpy as np
from driver import MODELS, changed
from quoin_tools.mesh.stacks import column

WHAT = "columns of rigid and of deformable blocks with joints (V04, V21)"
SOURCE = "closure = load above / k_n; settlement = sum of closures + rho g H^2 / 2E; 1/E_eff = 1/E + 1/(k_n s)"
BY = "by hand"

RHO, GRAVITY, E, K_N, K_S = 2400.0, 9.81, 10e9, 10e9, 3e9
P = 1e6  # [Pa] on the top, and shear on all sides

SCENE = {
    "strain": "small",
    "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "ramp": 500},
    "materials": {"block": {"density": RHO, "young": E, "poisson": 0.0}, "base": {"density": 0, "rigid": True}},
    "joints": {"default": {"k_n": K_N, "k_s": K_S, "friction": 45}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
    "stages": [{"weight": {"loads": ["weight"]}}],
}


def run(case):
    rigid_stack(case)
    jointed_column(case)


def rigid_stack(case):
    mesh = column(2)
    jobs = [(mesh, changed(SCENE, ("strain", strain), ("joints.default.stress_model", model)))
            for strain in ("small", "large") for model in MODELS]
    results = case.run_all(jobs)
    sigma = RHO * GRAVITY * np.array([2.0, 1.0])  # [Pa] below two blocks, below one
    contacts = [result.stage().contacts for result in results]
    case.check("two rigid blocks, all models, small and large strain: closure at both ends [m]",
               [-c.opening for c in contacts], sigma[:, None] / K_N, relative=1e-6)
    case.check("... contact stress [Pa]", [c.sigma for c in contacts], -sigma[:, None], relative=1e-6)
    case.check("... force at the base [N]", [r.stage_summary("weight")["reaction"]["y"] for r in results], sigma[0],
               relative=1e-6)


def jointed_column(case):
    n, mesh = 10, column(10, rigid=False)
    loads = SCENE["loads"] | {
        "pressure": {"type": "traction", "faces": "top", "value": [0, -P]},
        "shear": {"type": "traction", "faces": "top", "value": [P, 0]},
        "shear_left": {"type": "traction", "faces": "left", "value": [0, -P]},
        "shear_right": {"type": "traction", "faces": "right", "value": [0, P]}}
    stages = [{"weight": {"loads": ["weight"]}}, {"pressure": {"loads": ["pressure"]}},
              {"shear": {"loads": ["shear", "shear_left", "shear_right"]}}]
    result = case.run(mesh, changed(SCENE, ("loads", loads), ("stages", stages), ("joints.default.law", "elastic")))
    top = {stage: result.probe(stage, "top_right") for stage in result.stages}
    settlement = RHO * GRAVITY * (n * (n + 1) / 2 / K_N + n**2 / 2 / E)
    case.check("ten deformable blocks under weight: settlement of the top [m]", -top["weight"][1], settlement, relative=1e-6)
    base = result.stage("weight").contacts
    lowest = base.point[:, :, 1].max(axis=1) < 1e-9
    case.check("... stress of the joint on the base [Pa]", base.sigma[lowest], -n * RHO * GRAVITY, relative=1e-6)
    case.check("ten blocks under pressure: settlement [m]", -top["pressure"][1], n * P * (1 / E + 1 / K_N), relative=1e-6)
    case.check("ten blocks under uniform shear: displacement of the top [m]", top["shear"][0], n * P * (2 / E + 1 / K_S),
               relative=1e-6)
