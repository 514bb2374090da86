"""Section G1 of the Guilhofrei dam on its rock: self-weight (SW), hydrostatic pressure (HP) and both.

With friction 45 degrees (SWHP_nl) the joint slips over some 0.1 m at the heel. The reference clips shear at 32 points of
each segment; a contact of Quoin keeps slip at its two ends, linear between, so it relieves shear over its whole length. The
nodes up to 3.8 m from the heel, where tau differs by 1 to 5 %, are therefore reported, not judged."""

import json

import numpy as np
from driver import REFERENCE, changed
from quoin_tools.mesh.dam import G1
from reference_mesh import from_reference

WHAT = "Guilhofrei section G1 on rock: crest, joint stress, resultants (V28, V29 without uplift)"
SOURCE = "guilhofrei_g1.json (implicit finite elements), meshes of tests/data/reference; statics of the polygon"
BY = "independent finite elements of this project; by hand"

GRAVITY, RHO, WATER = 9.81, 2400.0, 1000.0
SCENE = {
    "strain": "small",
    "relaxation": {"tolerance": 1e-8, "velocity_tolerance": 1e-8, "history_every": 1000},
    "materials": {name: {"density": RHO, "young": 10e9, "poisson": 0.2} for name in ("dam", "rock")},
    "joints": {"default": {"k_n": 10e9, "k_s": 3e9, "law": "elastic"}, "base": {}},
    "supports": {"rock_sides": {"fix": "x"}, "rock_bottom": {"fix": "y"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["dam"]},
              "water": {"type": "reservoir", "faces": "upstream", "level": 33, "density": WATER}},
    "stages": [{"SW": {"loads": ["weight"]}}, {"SWHP_el": {"loads": ["weight", "water"]}}, {"HP": {"loads": ["water"]}}],
}
FRICTION = changed(SCENE, ("stages", [{"SWHP_nl": {"loads": ["weight", "water"]}}]),
                   ("joints.base", {"law": "mohr_coulomb", "friction": 45}))


def resultants():
    """Weight, its centroid x, thrust in x and y, and moments [N m] about the middle of the base, positive if they turn downstream."""
    x, y = G1.corners().T
    x2, y2 = np.roll(x, -1), np.roll(y, -1)
    cross = x * y2 - x2 * y
    area = cross.sum() / 2
    centroid = ((x + x2) * cross).sum() / (6 * area)
    weight = RHO * GRAVITY * area
    h = G1.height()
    thrust = WATER * GRAVITY * h**2 / 2
    lean = G1.crest_upstream[0] / h
    down = thrust * lean  # on the battered face
    middle = np.array(G1.toe) / 2
    arm_y, arm_x = h / 3 - middle[1], lean * h / 3 - middle[0]
    return weight, thrust, down, weight * (centroid - middle[0]), thrust * arm_y + down * arm_x


def run(case):
    with open(REFERENCE / "guilhofrei_g1.json", encoding="utf-8") as file:
        reference = json.load(file)
    for n in (12, 24):
        mesh = from_reference(REFERENCE / f"mesh_guilhofrei_g1_n{n}.json")
        elastic, friction = case.run_all([(mesh, SCENE), (mesh, FRICTION)])
        for result, stage in ((elastic, "SW"), (elastic, "HP"), (elastic, "SWHP_el"), (friction, "SWHP_nl")):
            expected = reference[str(n)][stage]
            case.check(f"n = {n}, {stage}: crest u_x, upstream [mm]", result.probe(stage, "crest_upstream")[0] * 1e3,
                       expected["crest"], relative=5e-3)
            case.check(f"n = {n}, {stage}: crest u_y, upstream [mm]", result.probe(stage, "crest_upstream")[1] * 1e3,
                       expected["crest_uy"], relative=5e-3)
            if "joint_sig" in expected:
                _, sigma, tau = result.joint_profile(stage, "base")
                at_nodes = [np.append(array[:, 0], array[-1, 1]) for array in (sigma, tau)]
                slips = 2 * n // 12 + 1 if stage == "SWHP_nl" else 0  # nodes up to 3.8 m from the heel
                for name, values, wanted in zip(("sigma", "tau"), at_nodes, (expected["joint_sig"], expected["joint_tau"])):
                    what = f"n = {n}, {stage}: {name} along the base [Pa]"
                    case.check(what + (", beyond 3.8 m" if slips else ""), values[slips:], wanted[slips:], relative=1e-2)
                    if slips:
                        case.report(what + ", the first 3.8 m", values[:slips], wanted[:slips])
        statics(case, elastic, n)
    crest = {stage: 1e3 * result.probe(stage, "crest_upstream")[0] for result, stage in ((elastic, "SW"), (elastic, "HP"), (friction, "SWHP_nl"))}
    case.published("guilhofrei", {"crest under self-weight, upstream [mm]": -crest["SW"], "crest under the reservoir [mm]": crest["HP"], "crest under both [mm]": crest["SWHP_nl"]})


def statics(case, result, n):
    weight, thrust, down, m_weight, m_water = resultants()
    slope = np.arctan2(G1.toe[1], G1.toe[0])
    sw, both, hp = (result.stage_summary(stage) for stage in ("SW", "SWHP_el", "HP"))
    case.check(f"n = {n}: weight [N]", -sw["applied"]["y"], weight, relative=1e-6)
    case.check(f"n = {n}: thrust in x and y [N]", [hp["applied"]["x"], -hp["applied"]["y"]], [thrust, down], relative=1e-6)
    base = both["joints"]["base"]
    normal = (weight + down) * np.cos(slope) + thrust * np.sin(slope)  # the base rises downstream
    along = thrust * np.cos(slope) - (weight + down) * np.sin(slope)
    case.check(f"n = {n}, SW+HP: N and T on the base [N]", [base["N"], base["T"]], [normal, along], relative=1e-6)
    length = np.hypot(*G1.toe)
    bending = 6 * (m_weight + m_water) / length**2
    case.check(f"n = {n}, SW+HP: linear stress at heel and toe [Pa]", [base["sigma_linear_start"], base["sigma_linear_end"]],
               [-normal / length + bending, -normal / length - bending], relative=1e-6)
