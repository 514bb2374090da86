"""A rigid block on one contact under a force N at the eccentricity e (V06).

The force acts as two point forces on the ends of the contact itself, so that its place does not depend on the rotation."""

import numpy as np
from driver import MODELS, changed
from quoin_tools.mesh.stacks import one_contact

WHAT = "one contact under an eccentric force: edge stress, rotation, and where a model has no equilibrium (V06)"
SOURCE = "equilibrium of the control points of section 2.5 of the paper; tptm: linear diagram without tension"
BY = "by hand, from section 2.5 of the paper"

K_N, SMALL, LARGE = 10e9, 1e4, 1e6  # forces [N]: a rotation far below 1e-3, and that of the plan
SCENE = {
    "relaxation": {"tolerance": 1e-10, "velocity_tolerance": 1e-10, "ramp": 1000},
    "materials": {"block": {"density": 1000}, "base": {"density": 0}},
    "joints": {"default": {"k_n": K_N, "k_s": 3e9, "friction": 45}},
    "supports": {"base": {"fix": "xy"}},
    "stages": [{"press": {"loads": ["left", "right"]}}],
}


def diagram(model, e):
    """Edge stress L/N and rotation k_n L^2/N; None: no equilibrium."""
    stiffness = {"pt": 3, "r2pt": 1.5, "r3pt": 1.125}.get(model, 1)  # over k_n L^3/12
    opens = {"pt": 1 / 2, "r2pt": 1 / 4, "r3pt": 3 / 16}.get(model, 1 / 6)
    if e <= opens:
        turn = 12 * e / stiffness
        return 1 + turn / 2, turn
    # the far end is open; middle stress m from N = m/2 + s/4
    if model == "r3pt" and e < 3 / 8:
        s, m = 32 * e / 3, 2 - 16 * e / 3
        return s, 2 * (s - m)
    if model == "t3pt" and e < 1 / 3:
        s, m = 12 * e, 2 - 6 * e
        return s, 2 * (s - m)
    if model == "tptm":
        closed = 3 * (0.5 - e)
        return 2 / closed, 2 / closed**2
    return None


def scene(model, e, force):
    ends = {"left": -force * (0.5 - e), "right": -force * (0.5 + e)}
    loads = {name: {"type": "point_force", "point": f"bottom_{name}", "value": [0, value]} for name, value in ends.items()}
    return changed(SCENE, ("loads", loads), ("joints.default.stress_model", model))


def edge(result):
    """Stress [Pa] at the right end, rotation and opening at the left end."""
    contacts = result.stage().contacts
    left, right = np.argsort(contacts.point[0, :, 0])
    opening = contacts.opening[0]
    return -contacts.sigma[0, right], opening[left] - opening[right], opening[left]


def run(case):
    mesh = one_contact()
    for model in MODELS:
        # r2pt at 0.25 is neutral: any opening of the far end is an equilibrium
        list_e = [e for e in (0.1, 0.2, 0.25, 0.3, 0.4) if (model, e) != ("r2pt", 0.25)]
        results = case.run_all([(mesh, scene(model, e, SMALL)) for e in list_e])
        pairs = [(e, diagram(model, e), result) for e, result in zip(list_e, results)]
        stands = [pair for pair in pairs if pair[1]]
        what = f"{model}, e/L = {', '.join(f'{e:g}' for e, _, _ in stands)}"
        case.check(f"{what}: edge stress L/N", [edge(result)[0] / SMALL for _, _, result in stands],
                   [d[0] for _, d, _ in stands], relative=1e-6)
        case.check(f"{what}: rotation k_n L^2/N", [edge(result)[1] * K_N / SMALL for _, _, result in stands],
                   [d[1] for _, d, _ in stands], relative=1e-6)
        for e, _, result in (pair for pair in pairs if not pair[1]):
            case.check(f"{model}, e/L = {e:g}: no equilibrium", result.verdict, "collapsed")
    linear(case, mesh)
    beyond_apex(case, mesh)
    stress, turn, opening = edge(case.run(mesh, scene("tptm", 0.4, LARGE)))
    case.check("tptm, N = 1 MN, e/L = 0.4: edge stress [Pa]", stress, 2 * LARGE / 0.3, relative=1e-4)
    case.check("... rotation [rad]", turn, 2 * LARGE / 0.3 / (K_N * 0.3), relative=1e-4)
    case.check("... opening of the far edge [m]", opening, 2 * LARGE / 0.3 / (K_N * 0.3) * 0.7, relative=1e-4)


def linear(case, mesh):
    """Small strain is linear for rigid blocks: pushed at the top of a height H the block slides by P/k_s L and turns by 12 P H/(k_n L^3),
    however far, and its weight does nothing to it."""
    k_n, k_s, P, H = 1e7, 5e6, 1e5, 1.0
    loads = {"weight": {"type": "self_weight"}, "push": {"type": "point_force", "point": "top_left", "value": [P, 0]}}
    stages = [{"weight": {"loads": ["weight"]}}, {"push": {"loads": ["weight", "push"]}}]
    pushed = changed(SCENE, ("strain", "small"), ("loads", loads), ("stages", stages),
                     ("joints.default", {"law": "elastic", "k_n": k_n, "k_s": k_s}))
    turn = 12 * P * H / k_n
    for method in ("explicit", "preconditioned"):
        result = case.run(mesh, changed(pushed, ("relaxation.method", method)))
        moved = result.probe("push", "top_left") - result.probe("weight", "top_left")
        case.check(f"small strain, {method}, rigid block turned by {turn:g}: top corner moves by [m]", moved,
                   [P / k_s + turn * H, 0.5 * turn], relative=1e-6)


def beyond_apex(case, mesh):
    """One end pulls beyond c/tan(phi) and bears no shear; the other, pressed by 1.4 MPa, bears more than the resultant may: reported, and so it is."""
    keeps = {"friction": 45, "cohesion": 1e4, "cohesion_residual": 1e4, "stress_model": "t2pt"}
    for tension, push in ((2e6, 6e5), (1e4, 2e5)):
        loads = {"left": {"type": "point_force", "point": "bottom_left", "value": [push / 2, 1e5]}, "right": {"type": "point_force", "point": "bottom_right", "value": [push / 2, -3e5]}}
        joint = SCENE["joints"]["default"] | keeps | {"tension": tension, "tension_residual": tension}
        result = case.run(mesh, changed(SCENE, ("joints.default", joint), ("loads", loads), ("strain", "small")))
        joints = result.stage_summary("press")["joints"]["default"]
        line = "joints.default: tension_residual, 2e+06 Pa, is beyond the apex of the shear strength, cohesion_residual / tan(friction_residual) = 1e+04 Pa"
        case.check(f"eccentric pull, tension of {tension:g} Pa over an apex of 1e4: stands, is reported", [result.verdict == "converged", line in result.stderr], [tension > 1e4] * 2)
        if tension > 1e4:
            case.check("... with a sliding factor of (c L + N tan(phi))/T", joints["sliding_factor_residual"], (1e4 + 2e5) / push, relative=1e-6)
