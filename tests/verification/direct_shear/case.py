"""Direct shear of a joint of 1 m (V07).

The shear force acts in the plane of the joint, so the block does not turn. An elastic joint beside the one that is tested, half
on each side, stands for the machine: with it the block comes to rest after the joint has failed. The ramp is long, because
relaxation overshoots by about 1/ramp: a peak may be approached no closer than that, and slip comes to rest as far past it."""

import numpy as np
from driver import changed
from quoin_tools.mesh.meshing import join, rectangle, renamed
from quoin_tools.mesh.stacks import one_contact

WHAT = "direct shear: peak, residual, tension, memory of the gap, eccentric normal force, false slip (V07, V10)"
SOURCE = "Mohr-Coulomb with tension cut-off; the machine is a spring in parallel"
BY = "by hand"

K_N, K_S, COHESION, PHI, TENSION = 10e9, 3e9, 0.1e6, 35.0, 0.05e6
M_N, M_S = 1e9, 3e9  # [Pa/m] of the machine, over 1 m in all
SCENE = {
    "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "ramp": 50000},
    "materials": {"block": {"density": 1000}, "base": {"density": 0}},
    "joints": {"default": {"k_n": K_N, "k_s": K_S, "friction": PHI},
               "joint": {"cohesion": COHESION, "tension": TENSION},
               "machine": {"law": "elastic", "k_n": M_N, "k_s": M_S}},
    "supports": {"base": {"fix": "xy"}},
}


def tan(degrees):
    return np.tan(np.radians(degrees))


def block_on_machine():
    """Block from x = -0.5 to 1.5 on a wider base, whose face from 0 to 1 is the joint."""
    def part(x, width):
        return rectangle(x, -1, width, 1, group="base", rigid=True)
    block = rectangle(-0.5, 0, 2, 0.5, group="block", rigid=True)
    return join([renamed(part(-1, 1), {"machine": "top"}), renamed(part(0, 1), {"joint": "top"}),
                 renamed(part(1, 1), {"machine": "top"}),
                 renamed(block, {"top": "top"}, {"plane": "bottom_left"})])


def steps(*forces):
    """Loads and stages from pairs of (normal force, shear force) [N], upward and to the right."""
    loads, stages = {}, []
    for i, (normal, shear) in enumerate(forces):
        loads[f"n{i}"] = {"type": "traction", "faces": "top", "value": [0, normal / 2]}
        loads[f"t{i}"] = {"type": "point_force", "point": "plane", "value": [shear, 0]}
        stages.append({f"s{i}": {"loads": [f"n{i}", f"t{i}"]}})
    return ("loads", loads), ("stages", stages)


def joint(result, i):
    """Mean sigma, |tau|, sliding and opening of the joint after stage i."""
    contacts = result.stage(f"s{i}").contacts
    mine = contacts.joint == result.mesh.joint_names.index("joint")
    return (contacts.sigma[mine].mean(), np.abs(contacts.tau[mine]).mean(), np.abs(contacts.sliding[mine]).mean(),
            contacts.opening[mine].mean())


def run(case):
    mesh = block_on_machine()
    peak_and_residual(case, mesh)
    pull(case, mesh)
    memory(case, mesh)
    eccentric(case)
    spurious_slip(case)


def peak_and_residual(case, mesh):
    sigma, phi_r = 0.5e6, 30.0
    normal = -sigma * (1 + M_N / K_N)
    peak, residual = COHESION + sigma * tan(PHI), sigma * tan(phi_r)
    limit = peak * (1 + M_S / K_S)
    scene = changed(SCENE, ("joints.joint.friction_residual", phi_r),
                    *steps((normal, 0), (normal, 0.999 * limit), (normal, 1.001 * limit), (normal, 1.5 * limit)))
    result = case.run(mesh, scene)
    case.check("a) normal stress [Pa]", joint(result, 0)[0], -sigma, relative=1e-6)
    case.check("a) just below the peak: tau [Pa], sliding 0.15 mm [m]", joint(result, 1)[1:3],
               [0.999 * peak, 0.999 * peak / K_S], relative=1e-6)
    case.check("a) just above the peak: no more than the residual strength", joint(result, 2)[1] <= residual * (1 + 1e-6), True)
    case.check("a) sheared further: tau [Pa]", joint(result, 3)[1], residual, relative=1e-4)
    case.check("a) ... sliding [m]", joint(result, 3)[2], (1.5 * limit - residual) / M_S, relative=1e-4)


def pull(case, mesh):
    sigma = 0.5e6
    limit, normal = TENSION * (1 + M_N / K_N), -sigma * (1 + M_N / K_N)
    shear = 2 * sigma * tan(PHI) * (1 + M_S / K_S)
    result = case.run(mesh, changed(SCENE, *steps((0.999 * limit, 0), (1.001 * limit, 0), (normal, 0), (normal, shear))))
    case.check("b) just below the tensile strength: sigma [Pa], opening 0.005 mm [m]", joint(result, 0)[::3],
               [0.999 * TENSION, 0.999 * TENSION / K_N], relative=1e-6)
    case.check("b) just above: opening [m]", joint(result, 1)[3], 1.001 * limit / M_N, relative=1e-6)
    case.check("b) ... sigma [Pa]", joint(result, 1)[0], 0.0, absolute=1e-6)
    case.check("b) closed and sheared: tau without cohesion [Pa]", joint(result, 3)[1], sigma * tan(PHI), relative=1e-4)
    case.check("b) ... sliding [m]", joint(result, 3)[2], (shear - sigma * tan(PHI)) / M_S, relative=1e-4)


def memory(case, mesh):
    close = -0.5e6 * (1 + M_N / K_N)
    result = case.run(mesh, changed(SCENE, *steps((1e-3 * M_N, 0), (0.4e-3 * M_N, 0), (1e-6 * M_N, 0), (close, 0))))
    gaps = np.array([joint(result, i)[3] for i in range(3)])
    case.check("c) opened to 1 mm, closed to 0.4 and 0.001 mm: opening [m]", gaps, [1e-3, 0.4e-3, 1e-6], relative=1e-6)
    case.check("c) ... sigma [Pa]", [joint(result, i)[0] for i in range(3)], 0.0, absolute=1e-6)
    case.check("c) pressed again: sigma [Pa]", joint(result, 3)[0], -0.5e6, relative=1e-6)


def eccentric(case):
    """e = 0.3 L without tension: 0.6 m closed with tptm, the whole length bears shear with pt."""
    force, e = 1e5, 0.3
    for model, length in (("tptm", 3 * (0.5 - e)), ("pt", 1.0)):
        limit = COHESION * length + force * tan(PHI)
        loads = {side: {"type": "point_force", "point": f"bottom_{side}", "value": [0, -force * (0.5 + sign * e)]}
                 for side, sign in (("left", -1), ("right", 1))}
        loads |= {f"shear_{i}": {"type": "point_force", "point": "bottom_left", "value": [part * limit, 0]}
                  for i, part in enumerate((0.999, 1.001))}
        both = ["left", "right"]
        stages = [{"press": {"loads": both}}, {"below": {"loads": [*both, "shear_0"]}}, {"above": {"loads": [*both, "shear_1"]}}]
        row = {"k_n": K_N, "k_s": K_S, "friction": PHI, "cohesion": COHESION, "cohesion_residual": COHESION,
               "stress_model": model}
        result = case.run(one_contact(), changed(SCENE, ("joints", {"default": row}), ("loads", loads), ("stages", stages)))
        verdicts = [result.stage(name).verdict for name in result.stages]
        case.check(f"d) {model}: T = 0.999 and 1.001 (c {length:g} m + N tan(phi))", ", ".join(verdicts[1:]), "converged, collapsed")
        case.check("d) ... T carried [N]", abs(result.stage_summary("below")["joints"]["default"]["T"]), 0.999 * limit,
                   relative=1e-6)


def spurious_slip(case):
    """A shear force of 0.9 of what friction bears, with the default ramp, must not leave slip (V10)."""
    force = 1e6
    loads = {"press": {"type": "traction", "faces": "top", "value": [0, -force]},
             "shear": {"type": "point_force", "point": "bottom_left", "value": [0.9 * force * tan(PHI), 0]}}
    scene = changed(SCENE, ("joints", {"default": SCENE["joints"]["default"]}), ("loads", loads), ("relaxation", {}),
                    ("stages", [{"press": {"loads": ["press"]}}, {"shear": {"loads": ["press", "shear"]}}]))
    slip = case.run(one_contact(), scene).stage("shear").contacts.slip
    case.check("e) T = 0.9 N tan(phi) with default ramp: slip k_s/T_max", slip * K_S / (force * tan(PHI)), 0.0, absolute=1e-3)
