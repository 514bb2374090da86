"""Equilibrium by Newton's method with a factor of the stiffness (relaxation.method: preconditioned) against references and
the explicit loop: opening and slip, stress models, rigid bodies, history, strength reduction, fallback."""

import itertools
import json

import numpy as np
from driver import MODELS, REFERENCE, changed, load
from quoin_tools.mesh.meshing import join, rectangle, renamed
from quoin_tools.mesh.stacks import block_grid, block_on_plane, patch_test
from quoin_tools.mesh.walls import wall
from reference_mesh import from_reference

WHAT = "preconditioned relaxation: references, explicit relaxation, history of friction, reduction, fallback (V14 with a crack)"
SOURCE = "fig6_elastic_and_no_tension.json and guilhofrei_g1.json (implicit finite elements); the explicit loop"
BY = "independent finite elements of this project; Quoin itself, the explicit loop"

NEWTON = ("relaxation.method", "preconditioned")
ROUGH = {"friction": 45, "cohesion": 1e12, "k_n": 30e9, "k_s": 10e9}
MC45 = {"friction": 45, "k_n": 30e9, "k_s": 10e9}


def run(case):
    fig6_references(case)
    guilhofrei_references(case)
    explicit(case)
    history(case)
    reduction(case)
    guards(case)
    automatic(case)
    in_turn(case)


def fig6_references(case):
    """The joint opens at the heel and slips; tptm, which integrates its diagram exactly, as the 32 points of the reference."""
    with open(REFERENCE / "fig6_elastic_and_no_tension.json", encoding="utf-8") as file:
        reference = json.load(file)
    for name, joint in (("MC45", MC45), ("notension_rough", ROUGH)):
        rows = {row["n"]: row for row in reference[name + "_M"]}
        scene = changed(load("fig6").SCENE, NEWTON, ("joints.default", joint))
        meshes = [from_reference(REFERENCE / f"mesh_fig6_M_n{n}.json") for n in (8, 16, 32)]
        results = case.run_all([(mesh, scene) for mesh in meshes])
        stages = [result.stage_summary("full") for result in results]
        expected = [rows[n] for n in (8, 16, 32)]
        what = f"Fig. 6, {name}, n = 8, 16, 32"
        bases = [stage["joints"]["base"] for stage in stages]
        case.check(f"{what}: toe sigma, tau [MPa]", [[b["end"]["sigma"] * 1e-6, -b["end"]["tau"] * 1e-6] for b in bases],
                   [[row["toe_joint"], row["toe_tau"]] for row in expected], relative=2e-4)
        case.check(f"{what}: crest u_x [mm]", [r.probe("full", "crest")[0] * 1e3 for r in results],
                   [row["crest_ux"] for row in expected], relative=2e-4)
        case.check(f"{what}: open length [m], of 32 points a segment", [b["open_length"] for b in bases],
                   [row["open_len"] for row in expected], absolute=80 / 8 / 32)
        case.check(f"{what}: solves, at most", max(stage["solves"] for stage in stages) <= 60, True)


def guilhofrei_references(case):
    guilhofrei = load("guilhofrei")
    with open(REFERENCE / "guilhofrei_g1.json", encoding="utf-8") as file:
        reference = json.load(file)["24"]
    mesh = from_reference(REFERENCE / "mesh_guilhofrei_g1_n24.json")
    elastic, friction = case.run_all([(mesh, changed(scene, NEWTON)) for scene in (guilhofrei.SCENE, guilhofrei.FRICTION)])
    stages = ((elastic, "SW"), (elastic, "HP"), (elastic, "SWHP_el"), (friction, "SWHP_nl"))
    case.check("G1, n = 24, SW, SW+HP, HP, SW+HP with friction: crest u_x [mm]",
               [result.probe(stage, "crest_upstream")[0] * 1e3 for result, stage in stages],
               [reference[stage]["crest"] for _, stage in stages], relative=1e-6)
    parallel = case.run(mesh, changed(guilhofrei.FRICTION, NEWTON), ranks=2)
    bodies = [(f"materials.{name}.condensed", True) for name in ("dam", "rock")]
    condensed = case.run(mesh, changed(guilhofrei.FRICTION, NEWTON, *bodies))
    case.check("G1 with friction, both bodies condensed: tau along the joint [Pa]", condensed.stage().contacts.tau,
               friction.stage().contacts.tau, absolute=1e-6 * abs(friction.stage().contacts.tau).max())
    case.check("G1 with friction, 1 and 2 ranks: joint stress, to the tolerance [Pa]", parallel.stage().contacts.tau,
               friction.stage().contacts.tau, absolute=1e-4 * abs(friction.stage().contacts.tau).max())


def explicit(case):
    """Both have one answer (see the case false_slip for more)."""
    fig6 = changed(load("fig6").SCENE, ("joints.default", MC45), ("relaxation.tolerance", 1e-9))
    mesh = from_reference(REFERENCE / "mesh_fig6_M_n8.json")
    for model in MODELS:
        scene = changed(fig6, ("joints.default.stress_model", model))
        both = case.run_all([(mesh, scene), (mesh, changed(scene, NEWTON))])
        compare(case, f"Fig. 6, n = 8, friction, {model}", "full", both)
    grid = changed(load("ranks").GRID, ("materials.rigid", {"density": 2400, "rigid": True}), ("relaxation.max_cycles", 200000),
                   ("loads.push.value", [-1e5, -1e6]), ("relaxation.ramp", 4000))
    mesh = block_grid(5, 5, 2, 2, 1.0, 4, 3)
    both = case.run_all([(mesh, grid), (mesh, changed(grid, NEWTON))])
    compare(case, "25 bodies, rigid and deformable, quadrilaterals and triangles, some slip", "push", both)
    case.check("... largest slip is more than [m]", abs(both[1].stage().contacts.slip).max() > 1e-6, True)


def compare(case, what, stage, both):
    sigma, tau = ([getattr(result.stage(stage).contacts, field) for result in both] for field in ("sigma", "tau"))
    case.check(f"{what}: sigma and tau, preconditioned and explicit [Pa]", [sigma[1], tau[1]], [sigma[0], tau[0]],
               absolute=1e-3 * abs(sigma[0]).max())
    methods = [[result.stage_summary(stage)[key] for key in ("method", "ranks_agree")] for result in both]
    case.check("... methods; ranks agree", json.dumps(methods), json.dumps([["explicit", "bit for bit"], ["preconditioned", "to the tolerance"]]))


def history(case):
    """The state does not depend on the number of increments."""
    guilhofrei = load("guilhofrei")
    mesh = from_reference(REFERENCE / "mesh_guilhofrei_g1_n12.json")
    scene = changed(guilhofrei.FRICTION, ("joints.base.friction", 30), ("strain", "large"))
    newton = [changed(scene, NEWTON, ("relaxation.increments", n)) for n in (1, 10)]
    one, ten = (r.stage().contacts.tau for r in case.run_all([(mesh, s) for s in newton]))
    scale = abs(one).max()
    case.check("G1, friction 30: tau with 1 and with 10 increments [Pa]", ten, one, absolute=1e-6 * scale)


CONCRETE = {"density": 2400, "young": 20e9, "poisson": 0.2}


def reduction(case):
    """The same bracket; what has no equilibrium is judged by the explicit loop."""
    stages = [{"rough": {"loads": ["weight"]}},
              {"less": {"loads": ["weight"], "type": "strength_reduction", "step": 6, "limit": 5, "bracket": 0.1}}]
    scene = changed(load("incline").SCENE, ("stages", stages), ("relaxation.tolerance", 1e-7),
                    ("materials", {"block": CONCRETE, "base": CONCRETE}))
    mesh = block_on_plane(rigid=False)
    both = case.run_all([(mesh, scene), (mesh, changed(scene, NEWTON))])
    stable, failing = ([r.stage_summary("less")["strength_reduction"][end] for r in both] for end in ("stable", "failing"))
    case.check("block on an incline of 30 degrees: bracket, preconditioned and explicit [degree]", [stable[1], failing[1]],
               [stable[0], failing[0]], absolute=1e-9)
    case.check("... holds 30 degrees", failing[1] <= 30 <= stable[1], True)


def guards(case):
    """A body that nothing holds has no factor to go by: the explicit loop takes over and finds the equilibrium."""
    patch = load("patch")
    pull = {side: {"type": "traction", "faces": side, "value": [x * 400.0, 0]} for side, x in (("left", -1), ("right", 1))}
    scene = changed(patch.SCENE, NEWTON, ("supports", {}), ("relaxation.allow_floating", True), ("loads", pull),
                    ("stages", [{"pull": {"loads": ["left", "right"]}}]))
    result = case.run(patch_test(), scene)
    case.check("a floating patch: method", result.stage_summary("pull")["method"], "preconditioned, then explicit")
    case.check("... stress [Pa]", result.stage("pull").stress[:, 0], 400.0, relative=1e-6)


WALL = {
    "relaxation": {}, "contact": {},
    "materials": {"block": {"density": 2400, "young": 10e9, "poisson": 0.2}, "base": {"density": 0}},
    "joints": {name: {"law": "elastic", "k_n": 10e9, "k_s": 3e9} for name in ("default", "joint_head")},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}, "push": {"type": "traction", "faces": "top", "value": [1e4, -1e4]}},
    "stages": [{"weight": {"loads": ["weight"]}}, {"push": {"loads": ["weight", "push"]}}],
}
LAST = "chosen: preconditioned: 8167 degrees of freedom, no contact can fail; relaxation.method fixes it"


def automatic(case):
    """relaxation.method: auto: Newton's method where nothing can fail and the model is large, the bits of explicit cycles elsewhere."""
    large = wall(26, 26, rigid=False)
    explicit_too(case, "elastic wall, 1939 degrees of freedom", wall(13, 12, rigid=False), WALL)
    auto, two, asked, cycles = (case.run(large, changed(WALL, ("relaxation.method", method)), ranks=ranks)
                                for method, ranks in (("auto", 1), ("auto", 2), ("preconditioned", 1), ("explicit", 1)))
    case.check("elastic wall, degrees of freedom", auto.summary["n_dofs"], 8167)
    case.check("... methods on 1 and 2 ranks", json.dumps([ways(auto), ways(two)]), json.dumps([[["preconditioned", "to the tolerance"]] * 2] * 2))
    case.check("... reported by a line of each stage", [run.stdout.count(LAST) for run in (auto, asked, cycles)], [2, 0, 0])
    case.check("... the bits of method: preconditioned", sums(auto), sums(asked))
    size = abs(cycles.stage("push").displacement).max()
    case.check("... displacements, auto on 1 and 2 ranks and explicit [m]", [run.stage("push").displacement for run in (auto, two)],
               [cycles.stage("push").displacement] * 2, absolute=1e-4 * size)  # fmt: skip
    short = changed(WALL, ("relaxation.max_cycles", 50), ("relaxation.ramp", 0))
    friction = {"law": "mohr_coulomb", "k_n": 10e9, "k_s": 3e9, "friction": 45}
    for why, *changes in (("friction in one joint set", ("joints.joint_head", friction)), ("variable connectivity", ("contact.connectivity", "variable")),
                          ("damping: paper", ("relaxation.damping", "paper"))):  # fmt: skip
        explicit_too(case, f"... {why}, 50 cycles", large, changed(short, *changes))
    stages = [WALL["stages"][0], {"push": {"loads": ["weight", "push"], "joints": {"joint_head": friction}}}]
    slips = case.run(large, changed(WALL, ("stages", stages)))
    case.check("... friction from the second stage on: methods", json.dumps(ways(slips)),
               json.dumps([["preconditioned", "to the tolerance"], ["explicit", "to the tolerance"]]))  # fmt: skip
    restarts(case, large)


def ways(run):
    return [[stage["method"], stage["ranks_agree"]] for stage in run.summary["stages"]]


def sums(run):
    return [stage["checksum"] for stage in run.summary["stages"]]



def explicit_too(case, what, mesh, scene):
    auto, cycles = case.run_all([(mesh, scene), (mesh, changed(scene, ("relaxation.method", "explicit")))])
    case.check(f"{what}: methods", json.dumps(ways(auto)), json.dumps([["explicit", "bit for bit"]] * len(ways(auto))))
    case.check("... the bits of method: explicit", sums(auto), sums(cycles))


def restarts(case, mesh):
    """From within the first stage, which a factor is made for again, and from behind it: the same way, and who comes later still says so."""
    folder = case.prepare(mesh, changed(WALL, ("relaxation.increments", 3)))
    straight = sums(case.again(folder))
    case.again(folder, "-checkpoint_every", "1", "-checkpoint_keep", "99", "-output", "kept")
    files = sorted((folder / "kept" / "checkpoints").iterdir())
    for file in (files[0], files[len(files) // 2], files[-1]):
        again = case.again(folder, "-restart", file)
        case.check(f"... again from {file.name} of {len(files)}: methods", json.dumps(ways(again)), json.dumps([["preconditioned", "to the tolerance"]] * 2))
        case.check("... the same bits", sums(again), straight)
    again = case.again(folder, "-restart", files[len(files) // 2], "-relaxation_method", "explicit")
    case.check("... explicit from there on: a checkpoint keeps that a factor had a part", json.dumps(ways(again)),
               json.dumps([["preconditioned", "to the tolerance"], ["explicit", "to the tolerance"]]))  # fmt: skip


def bricks(courses, width, height=0.5):
    """A wall of courses of elastic bricks of 1 m, every other one begins and ends with halves."""
    bodies = [renamed(rectangle(-1, -0.5, width + 2, 0.5, group="ground", rigid=True), {})]
    for course in range(courses):
        cuts = np.arange(width + 1.0) if course % 2 == 0 else np.array([0, *(np.arange(width) + 0.5), width])
        bodies += [renamed(rectangle(a, course * height, b - a, height, group="block"), {}) for a, b in itertools.pairwise(cuts)]
    return join(bodies)


def in_turn(case):
    """Walls whose brittle joints fail under k_h W: those that fail first relieve others. One stage by Newton's method breaks those that 40
    stages of the explicit method do; in one increment it broke 5 for 3, 14 for 3 and 5 for 2."""
    walls = ((4, 3, 29866, 9819.46, 0.668614, "r3pt"), (4, 3, 17344.2, 8323.29, 0.720837, "pt"), (5, 2, 39848.8, 7666.23, 0.595553, "pt"))
    for courses, width, cohesion, tension, k_h, model in walls:
        ends, most = [], []
        for method, n in (("preconditioned", 1), ("explicit", 40)):
            loads = {f"push_{i}": {"type": "pseudo_static", "coefficient": [k_h * (i + 1) / n, 0], "groups": ["block"]} for i in range(n)}
            scene = {
                "strain": "small",
                "relaxation": {"method": method, "tolerance": 1e-8},
                "materials": {"block": {"density": 2000, "young": 2e9, "poisson": 0.2}, "ground": {"density": 2000, "rigid": True}},
                "joints": {"default": {"k_n": 5e9, "k_s": 2e9, "friction": 35, "cohesion": cohesion, "tension": tension, "stress_model": model}},
                "supports": {"ground": {"fix": "xy"}},
                "loads": {"weight": {"type": "self_weight", "groups": ["block"]}} | loads,
                "stages": [{"sw": {"loads": ["weight"]}}, *({f"to_{name}": {"loads": ["weight", name]}} for name in loads)],
            }
            result = case.run(bricks(courses, width), scene)
            stage = result.stage(f"to_push_{n - 1}")
            ends.append(int(np.count_nonzero(stage.contacts.broken)))
            most.append(np.abs(stage.displacement).max())
        case.check(f"wall of {courses} courses, {model}, k_h = {k_h:.3f}: ends that break, one stage and 40", *ends)
        case.check("... largest displacement [m]", *most, relative=1e-4)
