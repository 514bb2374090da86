"""A rigid block 1 m by 0.2 m on a plane of 30 degrees whose friction is lowered, stage by stage (V05, static part)."""

import numpy as np
from driver import changed
from quoin_tools.mesh.stacks import block_on_plane

WHAT = "block on an incline of 30 degrees: stays above, slides below (V05, static part)"
SOURCE = "N = W cos(30), T = W sin(30); slides when the friction angle is less than 30 degrees"

WEIGHT = 2400 * 9.81 * 1.0 * 0.2
SCENE = {
    "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "ramp": 1000},
    "materials": {"block": {"density": 2400}, "base": {"density": 0}},
    "joints": {"default": {"k_n": 10e9, "k_s": 10e9, "friction": 45}, "joint": {}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
}


def run(case):
    mesh = block_on_plane()
    for angles in ((31, 29), (30.01, 29.99)):
        stages = [{"rough": {"loads": ["weight"]}}]
        stages += [{f"phi_{i}": {"loads": ["weight"], "joints": {"joint": {"friction": phi}}}} for i, phi in enumerate(angles)]
        result = case.run(mesh, changed(SCENE, ("stages", stages)))
        joint = result.stage_summary("phi_0")["joints"]["joint"]
        case.check(f"phi = {angles[0]}: stays", result.stage("phi_0").verdict, "converged")
        case.check("... N and T on the plane [N]", [joint["N"], abs(joint["T"])],
                   WEIGHT * np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)]), relative=1e-6)
        case.check(f"phi = {angles[1]}: slides", result.stage("phi_1").verdict, "collapsed")
