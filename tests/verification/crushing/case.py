"""A joint that is crushed stays crushed: one contact under a force that moves to its middle, and a block that is dropped."""

import numpy as np
from driver import changed
from quoin_tools.mesh.stacks import one_contact

WHAT = "a joint pressed past its compressive strength: closure kept, contact pressed at the edge and then in the middle, block dropped"
SOURCE = "closed form (below); a mass on an elastic-plastic spring"
BY = "by hand"

K_N, C, N = 10e9, 4e6, 1e6
E = 0.35  # [m] eccentricity
SCENE = {
    "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "ramp": 500},
    "strain": "small",
    "materials": {"block": {"density": 1000}, "base": {"density": 0}},
    "joints": {"default": {"k_n": K_N, "k_s": 3e9, "friction": 45, "compression": C}},
    "supports": {"base": {"fix": "xy"}},
}


def pressed(method, model="tptm"):
    loads = {f"{name}_{stage}": {"type": "point_force", "point": f"bottom_{name}", "value": [0, -N * (0.5 + side * e)]}
             for stage, e in (("edge", E), ("middle", 0)) for name, side in (("left", -1), ("right", 1))}
    stages = [{stage: {"loads": [f"left_{load}", f"right_{load}"]}}
              for stage, load in (("edge", "edge"), ("middle", "middle"), ("again", "middle"))]
    return changed(SCENE, ("loads", loads), ("stages", stages), ("relaxation.method", method),
                   ("joints.default.stress_model", model))


def closures(result, stage):
    """Of the left and the right end [m]."""
    contacts = result.stage(stage).contacts
    return -contacts.opening[0][np.argsort(contacts.point[0, :, 0])]


def run(case):
    statics(case)
    dropped(case)


def statics(case):
    a = (0.5 - np.sqrt(2.25 - 6 * E)) / 2  # 0.056 m; N (1/2 - E) is the moment of a at C and b = 1/2 - 2 a of a triangle
    b = 0.5 - 2 * a
    w = a * C / (K_N * b)  # the toe is set back by w at the edge, linearly to nothing over a
    mean, turn = N / K_N + w * a / 2, 6 * w * a * (0.5 - a / 3)
    mesh = one_contact()
    for method in ("explicit", "preconditioned"):
        result = case.run(mesh, pressed(method))
        joint = {stage: result.stage_summary(stage)["joints"]["default"] for stage in ("edge", "middle")}
        case.check(f"tptm, {method}, 1 MN at e = 0.35 m, C = 4 MPa: crushing length [m]", joint["edge"]["crushing_length"], a,
                   relative=1e-5)
        case.check("... open length [m]", joint["edge"]["open_length"], 1 - a - b, relative=1e-5)
        case.check("... closure of the edge [m]", closures(result, "edge")[1], C / K_N + w, relative=1e-5)
        case.check("... then in the middle: closures of the edges [m]", closures(result, "middle"),
                   [mean - turn / 2, mean + turn / 2], relative=1e-5)
        case.check("... and with nothing changed", closures(result, "again"), [mean - turn / 2, mean + turn / 2], relative=1e-5)
        case.check("... crushing length [m]", joint["middle"]["crushing_length"], 0.0, absolute=0)
        case.check("... plastic closure at the right edge [m]", result.stage("again").contacts.closure.min(), -w, relative=1e-5)


def dropped(case):
    """A block hits a joint flat at v, without weight: the springs store C^2/(2 k) a metre, the rest crushes the joint by s at C. It leaves
    with what the springs give back."""
    v, C_drop, mass = 0.5, 1e6, 2400.0
    hit, stored = 0.5 * mass * v**2, C_drop**2 / (2 * K_N)
    scene = changed(SCENE, ("strain", "large"), ("relaxation", {"allow_floating": True}),
                    ("joints.default.compression", C_drop), ("materials.block", {"density": mass, "velocity": [0.0, -v]}),
                    ("loads", {"none": {"type": "point_force", "point": "top_left", "value": [0, 0]}}),
                    ("stages", [{"hit": {"type": "dynamic", "loads": ["none"], "duration": 0.02, "dt_factor": 0.01}}]))
    runs = [(one_contact(), changed(scene, ("joints.default.stress_model", model))) for model in ("pt", "tptm")]
    for model, result in zip(("pt", "tptm"), case.run_all(runs)):
        energy = result.stage_summary("hit")["energy"]
        case.check(f"{model}, block dropped at 0.5 m/s on C = 1 MPa: speed after it [m/s]", np.sqrt(2 * energy["kinetic"] / mass),
                   v * np.sqrt(stored / hit), relative=1e-3)
        case.check("... lost in crushing [J]", energy["friction"], hit - stored, relative=1e-3)
        case.check("... plastic closure [m]", result.stage("hit").contacts.closure[0], [-(hit - stored) / C_drop] * 2, relative=1e-3)
        case.check("... energy balance over the energy of the block", energy["balance"] / hit, 0.0, absolute=1e-4)
    results = [case.run(*runs[1], ranks=ranks).stage_summary("hit")["checksum"] for ranks in (1, 2)]
    case.check("... same bits on 2 ranks", results[1], results[0])
