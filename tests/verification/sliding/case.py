"""Sliding of section G1 on its base (the paper's S1 and S3): friction reduced until the dam moves.

On a plane of one slope with ductile strength the limit is statics: S1 tan(phi) = T/N, S3 r = T/(N + c L). Sections of the
paper are not known; its numbers are reported."""

import json
import math

import numpy as np
import yaml
from driver import REFERENCE, ROOT, changed
from quoin_tools.mesh.blockmesh import face_ends
from quoin_tools.mesh.dam import G1, dam_mesh
from quoin_tools.mesh.meshing import join, quad_patch, renamed
from reference_mesh import from_reference

WHAT = "strength reduction on G1: friction alone (S1), all strengths with a key (S3), mechanism, ranks"
SOURCE = "equilibrium on the plane of the base: W = 9699 kN, H = 5342 kN, uplift 1014 + 977 kN, no key"
BY = "by hand; Bretas, Lemos and Lourenco 2014 (paper)"

SLOPE = np.arctan2(G1.toe[1], G1.toe[0])
UPLIFT = {"type": "uplift", "faces": "base", "level": 33, "rule": "npb", "drain": 4.70 / np.cos(SLOPE), "component": "vertical"}
ALL = ["weight", "water", "uplift"]
INELASTIC = {"law": "mohr_coulomb", "friction": 45}
SCENE = {
    "strain": "small",
    "relaxation": {"method": "explicit", "groups": ["dam"], "tolerance": 1e-7, "velocity_tolerance": 1e-6, "history_every": 1000},
    "materials": {name: {"density": 2400, "young": 10e9, "poisson": 0.2} for name in ("dam", "rock")},
    "joints": {"default": {"k_n": 10e9, "k_s": 3e9, "law": "elastic"}, "base": {}},
    "supports": {"rock_sides": {"fix": "x"}, "rock_bottom": {"fix": "y"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": {"type": "reservoir", "faces": "upstream", "level": 33},
              "uplift": UPLIFT},
    "stages": [{"sw": {"loads": ["weight"]}}, {"swhp": {"loads": ["weight", "water"]}},
               {"s1": {"type": "strength_reduction", "loads": ALL, "bracket": 0.05, "joints": {"base": INELASTIC}}}],
}


def plane_forces():
    """N and T on the base [N], by hand."""
    x, y = G1.corners().T
    area = 0.5 * (x * np.roll(y, -1) - np.roll(x, -1) * y).sum()
    thrust = 9810 * 33**2 / 2
    down = 2400 * 9.81 * area + thrust * 1.65 / 33 - 33 * 9810 * (2 / 3 * 4.70 + 18.10 / 6)
    return (down * math.cos(SLOPE) + thrust * math.sin(SLOPE), thrust * math.cos(SLOPE) - down * math.sin(SLOPE))


def holds(reduction, exact):
    return min(reduction["stable"], reduction["failing"]) <= exact <= max(reduction["stable"], reduction["failing"])


def run(case):
    normal, shear = plane_forces()
    exact = math.degrees(math.atan2(shear, normal))
    case.check("S1 by hand: atan(T/N) [degree]", exact, 28.102, absolute=5e-4)
    s1(case, exact)
    by_auto(case, exact)
    beside(case)
    s3(case, normal, shear)


def s1(case, exact):
    mesh = from_reference(REFERENCE / "mesh_guilhofrei_g1_n12.json")
    sums = {}
    for ranks in case.ranks(*((1, 2, 3) if case.full else (1, 2))):
        result = case.run(mesh, SCENE, ranks=ranks)
        sums[ranks] = json.dumps([[stage["checksum"] for stage in result.summary["stages"]],
                                  result.stage("s1").mechanism.tolist()])
    found = result.stage_summary("s1")["strength_reduction"]
    case.check("S1: exit code, although trials collapse", result.exit_code, 0)
    case.check("S1: the bracket holds the exact angle", holds(found, exact), True)
    case.check("... its width [degree], at most 0.05", found["width"], 0.0, absolute=0.05)
    case.check("... middle of the bracket [degree]", (found["stable"] + found["failing"]) / 2, exact, absolute=0.025)
    case.published("guilhofrei", {"sliding S1, friction of 45 degrees": found["safety_factor_stable"]})
    case.check("... checksums and mechanism on several ranks", len(set(sums.values())), 1)
    mechanism, group = result.stage("s1").mechanism, result.mesh.block_group
    dam = np.unique(result.mesh.blocks[group == result.mesh.group_names.index("dam")])
    case.check("... mechanism: all of the dam moves along the base", mechanism[dam[dam >= 0]],
               np.array([math.cos(SLOPE), math.sin(SLOPE)]), absolute=0.02)


def beside(case):
    """A block on a block, pushed by 0.3 of their weight. Friction of the lower joint is reduced; that the upper one would lose its cohesion is no reason for explicit cycles."""
    rock, lower, upper = (quad_patch((0, y), (4, y), (4, y + 1), (0, y + 1), n, n, group, not n > 1) for y, n, group in ((0, 1, "rock"), (1, 10, "lower"), (2, 10, "upper")))
    keys = {"relaxation": {"tolerance": 1e-7}, "strain": "small", "materials": {"rock": {"density": 0}} | {name: {"density": 2400, "young": 10e9, "poisson": 0.2} for name in ("lower", "upper")},
            "joints": {"default": {"k_n": 10e9, "k_s": 4e9, "friction": 45}, "lower+upper": {"k_n": 10e9, "k_s": 4e9, "friction": 45, "cohesion": 1e6, "tension": 1e6}},
            "supports": {"rock": {"fix": "xy"}}, "loads": {"weight": {"type": "self_weight"}, "push": {"type": "pseudo_static", "coefficient": [0.3, 0.0]}},
            "stages": [{"less": {"type": "strength_reduction", "loads": ["weight", "push"], "reduce": ["default"], "step": 10, "limit": 5, "bracket": 0.1}}]}  # fmt: skip
    stage = case.run(join([renamed(mesh, {}) for mesh in (rock, lower, upper)]), keys).stage_summary("less")
    case.check("a joint that weakens above the one that is reduced: method", stage["method"], "preconditioned")
    case.check("... the bracket holds atan(0.3)", holds(stage["strength_reduction"], math.degrees(math.atan(0.3))), True)


def by_auto(case, exact):
    """The default takes Newton's method for the trials. Where that may do next to nothing (effort), two trials hand over and the others are
    explicit; from the checkpoint of the second hand-over on a run ends with the same bits."""
    mesh = from_reference(REFERENCE / "mesh_guilhofrei_g1_n12.json")
    stages = [*SCENE["stages"][:2], {"s1": SCENE["stages"][2]["s1"] | {"bracket": 0.5, "step": 10}}]
    trials = changed(SCENE, ("relaxation.method", "auto"), ("stages", stages))
    short = changed(trials, ("relaxation.effort", 1e3), ("checkpoint", {"every": 1000000000, "keep": 99}))
    stage = case.run(mesh, trials).stage_summary("s1")
    case.check("S1, auto: methods", stage["method"], "preconditioned")
    case.check("... the bracket holds the exact angle", holds(stage["strength_reduction"], exact), True)
    folder = case.prepare(mesh, short)
    straight = case.again(folder)
    stage = straight.stage_summary("s1")
    case.check("S1, auto, with hardly any effort: method", stage["method"], "preconditioned, then explicit")
    case.check("... why", stage["method_choice"].split(" in the work")[0].split(" or ")[0],
               "preconditioned: the trials that were left by explicit cycles; 2 times it found no equilibrium")  # fmt: skip
    case.check("... the bracket holds the exact angle", holds(stage["strength_reduction"], exact), True)
    files = sorted((folder / "out" / "checkpoints").iterdir())
    again = case.again(folder, "-restart", files[-2], "-output", "again")
    case.check("... again from the second hand-over: checksum", again.stage_summary("s1")["checksum"], stage["checksum"])


def s3(case, normal, shear):
    """The first two contacts are a key with cohesion 1 MPa: 15 % less of all strengths at a step, then bisection."""
    mesh = from_reference(REFERENCE / "mesh_guilhofrei_g1_n12.json")
    ends = mesh.vertices[mesh.blocks[mesh.face_sets["base"][:, 0]]]
    near = ends.mean(axis=1)[:, 0] < G1.toe[0] * 2 / 12
    mesh.face_sets["key"] = mesh.face_sets["base"][near]
    key_length = np.hypot(*G1.toe) * 2 / 12
    key = INELASTIC | {"cohesion": 1e6, "cohesion_residual": 1e6, "tension": 1e6, "tension_residual": 1e6}
    stage = {"type": "strength_reduction", "what": "strengths", "factor": 0.85, "bracket": 0.002, "loads": ALL,
             "joints": {"base": INELASTIC, "key": key}}
    scene = changed(SCENE, ("joints", {"default": SCENE["joints"]["default"], "key": {}, "base": {}}),
                    ("stages", SCENE["stages"][:2] + [{"s3": stage}]))
    result = case.run(mesh, scene)
    found = result.stage_summary("s3")["strength_reduction"]
    exact = shear / (normal + 1e6 * key_length)
    case.check("S3, key of 3.82 m: the bracket of what is left of the strengths holds T/(N + c L)", holds(found, exact), True)
    case.check("... safety factor", found["safety_factor_stable"], 1 / exact, relative=5e-3)
    sixth, ours = {"... key of 3.8 m": found["safety_factor_stable"]}, {}
    for what, brittle in (("sliding S3, key of 3 m that yields", {}), ("... key that breaks", {"cohesion_residual": 0.0, "tension_residual": 0.0})):
        scene = yaml.safe_load((ROOT / "examples" / "guilhofrei_sliding" / "scene.yaml").read_text(encoding="utf-8"))
        stages = {name: stage for entry in scene["stages"] for name, stage in entry.items()}
        stages["swhpuk"]["joints"]["key"] |= brittle
        result = case.run(key_mesh(), changed(scene, ("output", "out"), ("stages", [{name: stages[name]} for name in ("sw", "swhp", "swhpuk", "s3")])))
        ours[what] = result.stage_summary("s3")["strength_reduction"]["safety_factor_stable"]
    case.published("guilhofrei", ours | sixth)


def key_mesh():
    """Section G1 with the key of the example, the 3.04 m of its base at the heel."""
    mesh = dam_mesh(G1, 15)
    base = mesh.face_sets["base"]
    mesh.face_sets["key"] = base[mesh.vertices[face_ends(mesh, base)][:, :, 0].max(axis=1) < G1.toe[0] * 2 / 15 + 1e-6]
    return mesh
