"""Two bodies with faces that do not match on their joint: uniform pressure, and pressure with shear (V02)."""

import numpy as np
from driver import MODELS, changed
from quoin_tools.mesh.stacks import two_bodies

WHAT = "patch test across a joint with non-matching faces, six stress models (V02)"
SOURCE = "uniform stress: sigma = -1 MPa, closure sigma/k_n; tau = 0.2 MPa, sliding tau/k_s"
BY = "by hand"

E, NU, K_N, K_S, P, SHEAR = 10e9, 0.25, 10e9, 3e9, 1e6, 0.2e6

SCENE = {
    "strain": "small",
    "relaxation": {"tolerance": 1e-10, "velocity_tolerance": 1e-10, "ramp": 500},
    "materials": {name: {"density": 0, "young": E, "poisson": NU} for name in ("lower", "upper")},
    # strong enough not to slip in the first cycles, when shear can arrive before pressure
    "joints": {"default": {"k_n": K_N, "k_s": K_S, "friction": 35, "cohesion": 1e6, "tension": 1e6}, "joint": {}},
}
# rollers on the sides and below: s_xx = nu/(1-nu) s_yy
PRESS = changed(SCENE, ("supports", {"left": {"fix": "x"}, "right": {"fix": "x"}, "bottom": {"fix": "y"}}),
                ("loads", {"top": {"type": "traction", "faces": "top", "value": [0, -P]}}),
                ("stages", [{"press": {"loads": ["top"]}}]))
# tractions on four sides, three dofs held: s_xx = 0
SIDES = {"top": (SHEAR, -P), "bottom": (-SHEAR, P), "right": (0, SHEAR), "left": (0, -SHEAR)}
PUSH = changed(SCENE, ("supports", {"lower_bottom_left": {"fix": "xy"}, "lower_bottom_right": {"fix": "y"}}),
               ("loads", {name: {"type": "traction", "faces": name, "value": value} for name, value in SIDES.items()}),
               ("stages", [{"push": {"loads": list(SIDES)}}]))


def run(case):
    for kind, triangles in (("quadrilaterals", False), ("triangles", True)):
        mesh = two_bodies(triangles=triangles)
        for what, scene, sxx, sxy in (("pressure", PRESS, -P * NU / (1 - NU), 0), ("pressure and shear", PUSH, 0, SHEAR)):
            results = case.run_all([(mesh, changed(scene, ("joints.joint.stress_model", model))) for model in MODELS])
            contacts = [result.stage().contacts for result in results]
            profiles = [result.joint_profile(result.stages[-1], "joint") for result in results]
            what = f"{kind}, {what}, six models"
            case.check(f"{what}: sigma at every sub-contact [Pa]", [c.sigma for c in contacts], -P, relative=1e-6)
            case.check(f"{what}: closure [m]", [-c.opening for c in contacts], P / K_N, relative=1e-6)
            if sxy:
                case.check(f"{what}: tau [Pa]", [tau for _, _, tau in profiles], SHEAR, relative=1e-6)
                case.check(f"{what}: sliding [m]", np.abs([c.sliding for c in contacts]), SHEAR / K_S, relative=1e-6)
            stress = np.array([result.stage().gauss_stress for result in results])
            stress = stress[~np.isnan(stress)].reshape(-1, 3)
            case.check(f"{what}: stress in both bodies [Pa], of 1e6", stress, [sxx, -P, sxy], absolute=1.0)
