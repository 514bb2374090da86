"""Water in the base joint of section G1: the diagram of each rule, its forces on the dam.

The water is an external force on both faces, so what the joint carries changes by the water's resultant: N, T and M of the
base with and without it, elastic joint, against the integrals of the diagram. Numbers of the paper: 1015 and 975 kN."""

import json

import numpy as np
from driver import REFERENCE, changed
from quoin_tools.assess.uplift import Heads, head_line
from quoin_tools.mesh.dam import G1
from reference_mesh import from_reference

WHAT = "uplift in the base joint: diagrams of the rules, resultants (V29)"
SOURCE = "integrals of the diagram; quoin_tools.assess.uplift for the rules"
BY = "by hand; Bretas, Lemos and Lourenco 2014 (paper)"

RHO_G = 9810.0
SLOPE = np.arctan2(G1.toe[1], G1.toe[0])
LENGTH = np.hypot(*G1.toe)
DRAIN = 4.70 / np.cos(SLOPE)  # [m] along the joint; 4.70 m from the heel on plan
WATER = {"type": "uplift", "faces": "base", "level": 33}
NPB = WATER | {"rule": "npb", "drain": DRAIN}
SCENE = {
    "strain": "small",
    "relaxation": {"groups": ["dam"], "tolerance": 1e-9, "velocity_tolerance": 1e-9, "history_every": 1000},
    "materials": {name: {"density": 2400, "young": 10e9, "poisson": 0.2} for name in ("dam", "rock")},
    "joints": {"default": {"k_n": 10e9, "k_s": 3e9, "law": "elastic"}, "base": {}},
    "supports": {"rock_sides": {"fix": "x"}, "rock_bottom": {"fix": "y"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["dam"]}, "vertical": NPB | {"component": "vertical"}, "both": NPB},
    "stages": [{"dry": {"loads": ["weight"]}}, {"up": {"loads": ["weight", "vertical"]}}, {"full": {"loads": ["weight", "both"]}}],
}
TAIL = 6.28 - 4.7 * np.sin(SLOPE)  # [m] of tailwater above the drain at 4.7 m: the base rises to the toe
# rule, keys of the load, what quoin_tools.assess.uplift knows them as; base of 22.91 m, 33 m of head: 0.05 H1 = 1.65 m
RULES = [
    ("linear", {"tailwater": 6.28}, {"toe": 4.0}),
    ("npb", {"drain": 4.7, "tailwater": 6.28}, {"drain": 4.7, "toe": 4.0, "tail_at_drain": TAIL}),
    ("usbr", {"drain": 1.5}, {"drain": 1.5}),
    ("usace", {"drain": 1.5, "efficiency": 0.5}, {"drain": 1.5, "efficiency": 0.5}),
    ("usace", {"drain": 4.7, "efficiency": 0.5, "tailwater": 6.28}, {"drain": 4.7, "efficiency": 0.5, "toe": 4.0, "tail_at_drain": TAIL}),
    ("ferc", {"drain": 4.7, "efficiency": 0.25, "gallery": 5.0 + 4.7 * np.sin(SLOPE)},
     {"drain": 4.7, "efficiency": 0.25, "gallery": 5.0}),
]


def resultants(corners):
    """Integrals over the joint of p, p (s - L/2), with the diagram's corners s [m], p [Pa]."""
    s, p = np.array(corners).T
    force = moment = 0.0
    for a, b, pa, pb in zip(s, s[1:], p, p[1:]):
        force += (pa + pb) / 2 * (b - a)
        moment += (b - a) * ((pa + pb) / 2 * (a - LENGTH / 2) + (pa + 2 * pb) / 6 * (b - a))
    return force, moment


def run(case):
    mesh = from_reference(REFERENCE / "mesh_guilhofrei_g1_n12.json")
    forces(case, mesh)
    rules(case, mesh)
    toe_under_water(case, mesh)


def forces(case, mesh):
    one, two = (case.run(mesh, SCENE, ranks=ranks) for ranks in (1, 2))
    dry, up, full = (one.stage_summary(name)["joints"]["base"] for name in ("dry", "up", "full"))
    water = one.stage_summary("up")["uplift"]["vertical"]
    case.check("G1, npb: uplift from heel to drain, from drain to toe, on plan [N]",
               np.cos(SLOPE) * np.array([water["to_drain"], water["beyond_drain"]]),
               [33 * RHO_G * (1 + 1 / 3) / 2 * 4.70, 33 * RHO_G / 3 / 2 * (22.80 - 4.70)], relative=1e-9)
    case.published("guilhofrei", {f"uplift from {part} [kN]": 1e-3 * np.cos(SLOPE) * water[key]
                                  for part, key in (("heel to drain", "to_drain"), ("drain to toe", "beyond_drain"))})  # fmt: skip
    force, moment = resultants(water["diagram"])
    case.check("vertical component only: change of N, T and M of the base [N, N m]",
               [dry["N"] - up["N"], up["T"] - dry["T"], up["M"] - dry["M"]],
               [force * np.cos(SLOPE) ** 2, force * np.cos(SLOPE) * np.sin(SLOPE), moment * np.cos(SLOPE) ** 2], relative=1e-6)
    case.check("normal to the faces: change of N and M [N, N m]", [dry["N"] - full["N"], full["M"] - dry["M"]],
               [force, moment], relative=1e-6)
    case.check("... change of T over that of N", (full["T"] - dry["T"]) / force, 0.0, absolute=1e-6)
    sums = [json.dumps([stage["checksum"] for stage in result.summary["stages"]]) for result in (one, two)]
    case.check("checksums on 1 and 2 ranks", sums[1], sums[0])


def rules(case, mesh):
    """Diagrams in closed joints; those with a crack are in the case cracked_base."""
    jobs = [(mesh, changed(SCENE, ("loads.both", WATER | keys | {"rule": rule}),
                           ("stages", [{"full": {"loads": ["weight", "both"], "max_cycles": 50}}])))
            for rule, keys, _ in RULES]
    for (rule, _, known), result in zip(RULES, case.run_all(jobs)):
        diagram = np.array(result.stage_summary("full")["uplift"]["both"]["diagram"]).T
        wanted = np.array(head_line(rule, Heads(length=LENGTH, heel=33.0, **known)))
        case.check(f"diagram of {rule}, {', '.join(f'{k} {v:g}' for k, v in known.items())}: places and heads [m]",
                   diagram / [[1], [RHO_G]], wanted, absolute=1e-9)


def toe_under_water(case, mesh):
    """Water over the toe presses in the joint there only by the load's tailwater: without it that is reported."""
    level = G1.toe[1] + 6.0
    downstream = {"type": "reservoir", "faces": "downstream", "level": level}
    for what, uplift, loads, told in (("none", WATER, ["weight", "both", "tail"], 1), ("given", WATER | {"tailwater": level}, ["weight", "both", "tail"], 0), ("none, not in one stage", WATER, ["weight", "tail"], 0)):
        one = changed(SCENE, ("loads", {"weight": SCENE["loads"]["weight"], "both": uplift, "tail": downstream}), ("stages", [{"up": {"loads": ["weight", "both"], "max_cycles": 50}}, {"full": {"loads": loads, "max_cycles": 50}}]))
        said = case.run(mesh, one).stderr
        case.check(f"6 m of water over the toe, tailwater {what}: reported", [said.count("loads.both: tailwater is not given"), said.count("lies 6 m under the water of loads.tail")], [told, told])
