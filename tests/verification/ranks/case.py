"""The same runs on 1, 2, 3 and 4 ranks, on 3 that send messages as if on several machines, and with every instruction
set: all bits of the state, as its checksum after each stage, are the same. Two rigid bodies leave ranks without anything:
through a stage that finds contacts, a collapse with its mechanism, and a restart between its trials."""

import json

from driver import REFERENCE, changed, load
from quoin_tools.mesh.meshing import face_set_on, join, quad_patch, renamed
from quoin_tools.mesh.stacks import block_grid, column
from reference_mesh import from_reference
from triangle_dam import triangle_dam

WHAT = "checksum of the state on 1, 2, 3 and 4 ranks and with every instruction set"
SOURCE = "the run on one rank"
BY = "Quoin itself, one rank"

WAYS = ((1, "auto"), (2, "auto"), (3, "messages"), (3, "auto"), (4, "auto"))  # the short form has the first three; idle has 4 ranks in both
JOINT = {"k_n": 10e9, "k_s": 3e9, "friction": 35}
GRID = {
    "relaxation": {"max_cycles": 600, "ramp": 200, "tolerance": 1e-9},
    "materials": {"block": {"density": 2400, "young": 10e9, "poisson": 0.2}},
    "joints": {"default": JOINT},
    "supports": {"bottom": {"fix": "xy"}, "left": {"fix": "x"}},
    "loads": {"weight": {"type": "self_weight"}, "push": {"type": "traction", "faces": "top", "value": [3e5, -1e6]}},
    "stages": [{"push": {"loads": ["weight", "push"]}}],
}


def scenes():
    """Name, mesh, scene; all with adaptive damping but one."""
    guilhofrei, fig6, stack = load("guilhofrei"), load("fig6"), load("stack")
    mixed = changed(GRID, ("materials.rigid", {"density": 2400, "rigid": True}))
    dam = from_reference(REFERENCE / "mesh_guilhofrei_g1_n12.json")
    slipping = changed(guilhofrei.FRICTION, ("joints.base.friction", 30), ("strain", "large"))
    yield "rigid column", column(8), stack.SCENE
    yield "rigid blocks, 12 x 12", block_grid(12, 12, 1, 1), changed(GRID, ("materials.block", {"density": 2400, "rigid": True}))
    yield "2025 blocks in 45 x 45 bodies", block_grid(45, 45, 1, 1), GRID
    yield "2048 blocks, rigid, quadrilaterals and triangles mixed", block_grid(16, 16, 2, 3, 1.0, 4, 5), mixed
    yield "2000 blocks of one point, t3pt, small strain, fixed damping", block_grid(10, 10, 4, 5), changed(
        GRID, ("strain", "small"), ("materials.block.element", "reduced"), ("joints.default.stress_model", "t3pt"), ("relaxation.damping", "fixed"))
    yield "Guilhofrei, friction 30 degrees: the base slips", dam, slipping
    yield "Fig. 6, n = 16 with triangles on rigid ground", triangle_dam(16, "G"), fig6.SCENE


def bodies():
    """Dam on rock, both rigid, which slides."""
    sliding = load("sliding")
    rigid = {name: {"density": 2400, "rigid": True} for name in ("dam", "rock")}
    stages = [{"sw": {"loads": ["weight"], "variable": True}}, {"s1": sliding.SCENE["stages"][-1]["s1"] | {"bracket": 2}}]
    return changed(sliding.SCENE, ("materials", rigid), ("supports", {"rock": {"fix": "xy"}}), ("stages", stages), ("strain", "large"),
                   ("checkpoint", {"every": 500, "keep": 100}))


def everything():
    """A block of 2 x 2 pieces on a base of 3 x 2, both rigid: uplift, tendon, grouted bar, water that flows, an earthquake at rest and in time, trials."""
    base, dam = quad_patch((-4, -4), (8, -4), (8, 0), (-4, 0), 3, 2, "rock", True), quad_patch((0, 0), (4, 0), (2, 8), (0, 8), 2, 2, "dam", True)
    mesh = join([renamed(base, {}), renamed(dam, {})])
    mesh.face_sets = {"up": face_set_on(mesh, (0, 0), (0, 8)), "before": face_set_on(mesh, (-4, 0), (0, 0)), "behind": face_set_on(mesh, (4, 0), (8, 0))}
    mesh.face_sets["base"] = [face for face in face_set_on(mesh, (0, 0), (4, 0)) if mesh.group_names[mesh.block_group[face[0]]] == "dam"]
    mesh.points = {}
    steel = {"area": 1e-3, "young": 2e11}
    anchors = {"tendon": steel | {"head": [0.5, 7], "root": [0.5, -3], "prestress": [2e5], "lock": ["own"]},
               "bar": steel | {"head": [1.5, 3], "root": [1.5, -3], "bond_stiffness": 2e9, "bond_strength": 3e5, "dowel_foundation": 1e9}}  # fmt: skip
    loads = {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": {"type": "reservoir", "faces": "up", "level": 6.0},
             "uplift": {"type": "uplift", "faces": "base", "level": 6.0, "cracked": True}, "shake": {"type": "pseudo_static", "coefficient": [0.1, 0], "groups": ["dam"]},
             "heel": {"type": "head", "faces": "before", "level": 6.0}, "toe": {"type": "head", "faces": "behind", "level": 0.5}}  # fmt: skip
    joints = {"default": JOINT, "base": JOINT | {"cohesion": 1e5, "tension": 5e4}}
    scene = {"materials": {name: {"density": 2400, "rigid": True} for name in ("rock", "dam")}, "joints": joints, "supports": {"rock": {"fix": "xy"}},
             "relaxation": {"ramp": 200, "tolerance": 1e-7, "max_cycles": 30000}}  # fmt: skip
    acts, wet = ["weight", "water", "uplift"], ["weight", "water", "heel", "toe"]
    static = [{"own": {"loads": ["weight"]}}, {"full": {"loads": acts}}, {"shaken": {"loads": [*acts, "shake"]}}, {"back": {"from": "own", "loads": ["weight"], "variable": True}},
              {"rises": {"from": "full", "type": "flood", "loads": acts, "step": 1, "limit": 9, "bracket": 0.5}}]  # fmt: skip
    moving = [{"own": {"loads": ["weight"]}}, {"flows": {"loads": wet}}, {"later": {"type": "transient", "loads": wet, "duration": 20, "time_step": 10}},
              {"swings": {"type": "dynamic", "loads": wet, "duration": 0.02, "frames": 2, "envelope_every": 50}}, {"rest": {"loads": wet}}]  # fmt: skip
    used = lambda stages: {name: load for name, load in loads.items() if any(name in keys["loads"] for stage in stages for keys in stage.values())}  # noqa: E731
    open_ = changed(joints, ("base.aperture", 2e-4), ("base.aperture_residual", 1e-5))
    yield "uplift, anchors, trials", mesh, scene | {"anchors": anchors, "loads": used(static), "stages": static}
    yield "flow, motion", mesh, scene | {"joints": open_, "loads": used(moving), "stages": moving}


def idle(case):
    """Ranks that own nothing take part in all that ranks do together."""
    folder = case.prepare(from_reference(REFERENCE / "mesh_guilhofrei_g1_n12.json"), bodies())
    one = case.again(folder)
    sums, mechanism = [stage["checksum"] for stage in one.summary["stages"]], (one.stage("s1").mechanism ** 2).sum(axis=1).max() ** 0.5
    case.check("2 rigid bodies slide; largest velocity of the mechanism", mechanism, 1.0, relative=1e-12)
    for ranks in (3, 4):
        several = case.again(folder, ranks=ranks)
        case.check(f"... on {ranks} ranks", [stage["checksum"] for stage in several.summary["stages"]], sums)
    case.again(folder, "-output", "kept", ranks=3)
    files = sorted((folder / "kept" / "checkpoints").iterdir())
    for file in (files[0], files[-1]):
        restarted = case.again(folder, "-restart", file, ranks=3)
        case.check(f"... again from {file.name} of {len(files)}", [stage["checksum"] for stage in restarted.summary["stages"]], sums)
    for name, mesh, scene in everything():
        sums = [[stage["checksum"] for stage in case.run(mesh, scene, ranks=ranks).summary["stages"]] for ranks in (1, 4)]
        case.check(f"2 rigid bodies, {name}: on 4 ranks as on one", sums[1], sums[0])


def instruction_sets(case):
    """The key isa: every set that this processor has gives the bits of the base one."""
    slipping = changed(GRID, ("materials.rigid", {"density": 2400, "rigid": True}))
    runs = {isa: case.run(block_grid(16, 16, 2, 3, 1.0, 4, 5), slipping, "-isa", isa) for isa in ("base", "v3", "v4")}
    sums = {isa: run.stage_summary("push")["checksum"] for isa, run in runs.items() if run.exit_code != 2}
    case.check(f"2048 blocks, rigid, quadrilaterals and triangles mixed, instruction sets {', '.join(sums)}", sorted(set(sums.values())), [sums["base"]])
    case.check("... named in the summary", [runs[isa].summary["isa"] for isa in sums], list(sums))


def run(case):
    idle(case)
    instruction_sets(case)
    for name, mesh, scene in scenes():
        checksums = {}
        for ranks, exchange in WAYS[:3] if case.short else WAYS:
            result = case.run(mesh, scene, "-exchange", exchange, ranks=ranks)
            stages = result.summary["stages"]
            checksums[ranks, exchange] = " ".join(stage["checksum"] for stage in stages)
            assert result.summary["ranks"] == ranks
        slip = abs(result.stage().contacts.slip).max()
        what = f"{name} ({result.summary['n_blocks']} blocks, {result.summary['n_contacts']} contacts, " \
               f"{sum(stage['cycles'] for stage in stages)} cycles, slip {slip:.1e} m)"
        case.check(what, json.dumps(sorted(set(checksums.values()))), json.dumps([checksums[1, "auto"]]))
