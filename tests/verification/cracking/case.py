"""Blocks that crack: the crack-band bar (M04) on three meshes, blocks that are wider than long, bending, refusals, ranks, restart.

The law at a point, its energy and its unloading (M05) are tested in tests/unit/blocks/test_laws.c."""

import numpy as np
from driver import changed, check_restarts, checksums
from quoin_tools.mesh.meshing import join, rectangle, renamed, split_triangles
from quoin_tools.mesh.stacks import quad_patch

WHAT = "blocks that crack: bar with one weak block, energy and softening whatever the blocks (M04), ranks, restarts, refusals"
SOURCE = "sigma = (1 - d) E eps, crack band: B = Gf/(h ft) - e0/2, in closed form for a bar of n blocks of which one cracks"
BY = "closed form by hand; a program apart, not named there"

E, FT, GF = 10e9, 1e6, 100.0
BAR = {"density": 240, "young": E, "poisson": 0, "law": "damage", "tension": FT, "fracture_energy": GF}


def bar(nx, ny=1, triangles=False):
    """1 m by 1 m in nx by ny blocks; those of the middle column are 0.1 % weaker."""
    mesh = rectangle(0, 0, 1, 1, nx, ny, group="bar")
    mesh.group_names, mesh.group_rigid = ["bar", "weak"], np.zeros(2, dtype=np.int32)
    middle = mesh.vertices[mesh.blocks[:, :4]][..., 0].mean(axis=1)
    mesh.block_group[np.abs(middle - (nx // 2 + 0.5) / nx) < 1e-9] = 1
    return split_triangles(mesh) if triangles else mesh


def pulled(case, mesh, way, ranks=1, strain="small", **more):
    """The right end moves by `way` in 1 s, thousands of times as slow as waves."""
    v = way / 0.95
    scene = {"strain": strain, "materials": {"bar": BAR | more, "weak": BAR | {"tension": 0.999 * FT} | more},
             "supports": {"left": {"fix": "x"}, "bottom": {"fix": "y"}, "right": {"fix": "x", "motion": "way.csv", "quantity": "velocity"}},
             "stages": [{"pull": {"type": "dynamic", "loads": [], "duration": 1.0, "alpha": 600, "dt_factor": 0.4}}], "relaxation": {"history_every": 20}}  # fmt: skip
    folder = case.prepare(mesh, scene)
    (folder / "way.csv").write_text(f"0, 0, 0\n0.1, {v!r}, 0\n1, {v!r}, 0\n")
    return case.again(folder, ranks=ranks)


def end_at(stress, h, length=1.0):
    """End displacement [m] of the bar where the weak block, on its way down, bears this part of ft."""
    e0 = 0.999 * FT / E
    B = GF / (h * 0.999 * FT) - e0 / 2
    kappa = e0 - B * np.log(stress / 0.999)
    return (length - h) * stress * FT / E + h * kappa


def run(case):
    meshes(case)
    others(case)
    refused(case)
    ramps(case)
    newton(case)
    chosen(case)
    ranks_and_restart(case)
    both_laws(case)


def told(result, stage="pull"):
    return result.stage_summary(stage)["laws"]["weak"]


def meshes(case):
    """M04: 5, 10, 20 blocks. Numbers of another program beside the closed form."""
    published = {5: (104.083, 122.383, 180.849, 293.616), 10: (103.199, 120.849, 180.897, 299.095), 20: (102.757, 120.082, 180.920, 301.834)}
    levels = np.array([0.8, 0.5, 0.2, 0.05])
    for n, numbers in published.items():
        h = 1 / n
        case.check(f"{n} blocks: closed form of the end displacement at 0.8, 0.5, 0.2, 0.05 ft against published numbers [um]", 1e6 * end_at(levels, h), numbers, relative=2e-3)
        result = pulled(case, bar(n), 900e-6)
        history = result.history
        force, u = -history["left_fx_N"], history["bottom_right_ux_m"]
        down = np.argmax(np.abs(force))
        way = np.interp(-levels * FT, -np.abs(force[down:]), u[down:])
        case.check(f"{n} blocks: end displacement at these stresses, on the way down [um]", 1e6 * way, 1e6 * end_at(levels, h), relative=3e-3)
        case.check("... energy lost in the crack [J/m2]", told(result)["lost"], GF, relative=0.01)
        case.check("... in the other blocks, which have hardly cracked", result.stage_summary("pull")["laws"]["bar"]["lost"], 0.0, absolute=0.1)
        stage = result.stage("pull")
        case.check("... crack width: end displacement less what the bar is stretched [um]", 1e6 * told(result)["crack_width"], 1e6 * (u[-1] - np.abs(force[-1]) / E), absolute=0.05)
        weak = result.mesh.block_group == 1
        case.check("... the same in the results, by block", [stage.damage[weak].max(), stage.crack_width[weak].max(), stage.lost[weak].sum()],
                   [told(result)[key] for key in ("damage", "crack_width", "lost")], relative=1e-12)
        energy = result.stage_summary("pull")["energy"]
        case.check("... balance of the account over the work of the support", energy["balance"] / energy["supports"], 0, absolute=1e-5)


def others(case):
    """Blocks four times as wide as across the crack, or as long; four points; triangles; Poisson's ratio; large strain."""
    for name, mesh, more in (("wide blocks", bar(11, 3), {}), ("long blocks", bar(3, 8), {}), ("four points", bar(5), {"element": "full"}), ("triangles", bar(5, triangles=True), {}),
                             ("Poisson's ratio 0.2", bar(5), {"poisson": 0.2}), ("linear softening", bar(5), {"softening": "linear"})):  # fmt: skip
        result = pulled(case, mesh, 1200e-6, **more)
        case.check(f"{name}: energy lost in the crack [J/m2]", told(result)["lost"], GF, relative=0.02)
    history = result.history
    force, u = -history["left_fx_N"], history["bottom_right_ux_m"]
    down, levels = np.argmax(np.abs(force)), np.array([0.8, 0.5, 0.2, 0.05])
    e0, last = 0.999 * FT / E, 2 * GF / (0.2 * 0.999 * FT)
    case.check("linear softening: end displacement at 0.8, 0.5, 0.2, 0.05 ft on the way down, by hand [um]", 1e6 * np.interp(-levels * FT, -np.abs(force[down:]), u[down:]),
               1e6 * (0.8 * levels * FT / E + 0.2 * (last - levels / 0.999 * (last - e0))), relative=3e-3)
    large = pulled(case, bar(5), 900e-6, strain="large")
    case.check("large strain: energy lost in the crack [J/m2]", told(large)["lost"], GF, relative=0.02)


def refused(case):
    """A block of 2 E Gf/ft^2 = 2 m across a crack gives back as much as the crack takes."""
    scene = {"materials": {"bar": BAR}, "supports": {"left": {"fix": "xy"}}, "loads": {"pull": {"type": "traction", "faces": "right", "value": [1e4, 0]}}, "stages": [{"pull": {"loads": ["pull"]}}]}
    case.check("a block of 1.99 m by 1.99 m is taken", case.run(rectangle(0, 0, 1.99, 1.99, 1, 1, group="bar"), scene).exit_code, 0)
    for sides in ((2.01, 1.0), (1.0, 2.01)):
        result = case.run(rectangle(0, 0, *sides, 1, 1, group="bar"), scene)
        case.check(f"a block of {sides[0]} m by {sides[1]} m: refused in one line with the number",
                   [result.exit_code, result.stderr.count("\n"), "block 0 is 2.01 m wide across a crack" in result.stderr, "less than 2 m" in result.stderr], [2, 1, True, True])


# ---- ranks, restart


def wall():
    """A wall that water cracks at its heel, on elastic ground; then shaken."""
    mesh = join([renamed(rectangle(-2, -2, 8, 2, 8, 3, group="ground"), {"bottom": "bottom"}, {}),
                 renamed(quad_patch((0, 0), (3, 0), (2, 6), (0, 6), 8, 8, group="block"), {"upstream": "left"}, {})])  # fmt: skip
    weak = {"density": 2400, "young": 10e9, "poisson": 0.2, "law": "damage", "tension": 1e4, "fracture_energy": 10}
    return mesh, {
        "strain": "large", "materials": {"ground": {"density": 2400, "young": 10e9, "poisson": 0.2}, "block": weak},
        "joints": {"default": {"k_n": 2e10, "k_s": 1e10, "friction": 60, "cohesion": 1e6, "tension": 1e6}},
        "supports": {"bottom": {"fix": "xy"}}, "relaxation": {"max_cycles": 40000, "ramp": 1000},
        "loads": {"weight": {"type": "self_weight"}, "water": {"type": "reservoir", "faces": "upstream", "level": 6}},
        "stages": [{"own": {"loads": ["weight"]}}, {"full": {"loads": ["weight", "water"]}}, {"empty": {"loads": ["weight"]}},
                   {"shaken": {"type": "dynamic", "loads": ["weight", "water"], "duration": 0.02}}]}  # fmt: skip


def ramps(case):
    """A bar at 0.98 of its strength stands when it is pulled slowly; pulled at once it breaks, and that is reported."""
    scene = {"materials": {"bar": BAR, "weak": BAR | {"tension": 0.999 * FT}}, "supports": {"left": {"fix": "x"}, "bottom": {"fix": "y"}},
             "loads": {"pull": {"type": "traction", "faces": "right", "value": [0.98 * FT, 0]}}, "stages": [{"pull": {"loads": ["pull"]}}]}
    for ramp, verdict in ((1000, True), (0, False)):
        result = case.run(bar(20), scene | {"relaxation": {"ramp": ramp, "max_cycles": 5000}})
        case.check(f"bar at 0.98 of its strength, ramp of {ramp} cycles: stands, nothing is reported",
                   [result.stage_summary("pull")["verdict"] == "converged", "blocks crack while loads rise in 0 cycles" not in result.stderr], [verdict] * 2)


def chosen(case):
    """By default a wall that cracks on an elastic joint takes stiffness_mass, whose ramp hurries while nothing cracks; a joint with cohesion stays explicit."""
    mesh, scene = wall()
    scene = changed(scene, ("stages", scene["stages"][:3]), ("joints.default", {"law": "elastic", "k_n": 2e10, "k_s": 1e10}), ("relaxation", {"tolerance": 1e-7, "ramp": 15000, "max_cycles": 60000}))
    ours, two, bonded, explicit = (case.run(mesh, one, ranks=ranks) for one, ranks in (
        (scene, 1), (scene, 2), (changed(wall()[1], ("stages", scene["stages"][:2])), 1), (changed(scene, ("relaxation.method", "explicit")), 1)))  # fmt: skip
    methods = [{stage["method"] for stage in run.summary["stages"]} for run in (ours, two, bonded)]
    case.check("auto, a wall that cracks: methods; on two ranks; with cohesion", methods, [{"stiffness_mass"}, {"stiffness_mass"}, {"explicit"}])
    case.check("... checksums on two ranks", *([stage["checksum"] for stage in run.summary["stages"]] for run in (two, ours)))
    rows = [[run.stage_summary(name)["cycles"] for name in ("own", "full")] for run in (ours, explicit)]
    case.check("... cycles with a ramp of 15 000: own weight, at most 700; water that cracks it, 700 to 4000; explicit, more than 15 000",
               [rows[0][0] <= 700, 700 < rows[0][1] < 4000, min(rows[1]) > 15000], [True] * 3)  # fmt: skip
    for name in ("full", "empty"):
        right = explicit.stage(name).displacement
        case.check(f"... {name}: displacements by explicit cycles [m]", ours.stage(name).displacement, right, absolute=1e-3 * abs(right).max())
    cracks = [run.stage_summary("full")["laws"]["block"] for run in (ours, explicit)]
    case.check("... energy lost [J], widest crack [m]", *([row[key] for key in ("lost", "crack_width")] for row in cracks), relative=1e-3)
    case.check("... it has cracked", cracks[1]["lost"] > 0, True)


def newton(case):
    """Newton's method comes to the equilibria of explicit cycles; where there is none, both say so."""
    mesh, scene = wall()
    scene = changed(scene, ("stages", scene["stages"][:3]), ("relaxation", {"tolerance": 1e-6, "max_cycles": 40000}))
    for level in (6, 6.6):
        explicit, other = (case.run(mesh, changed(scene, ("loads.water.level", level), ("relaxation.method", method))) for method in ("explicit", "preconditioned"))
        case.check(f"Newton's method, water at {level} m: stages by it", [s["method"] for s in other.summary["stages"]], ["preconditioned"] * 3)
        for name in ("full", "empty"):
            ours, theirs = (r.stage(name).displacement for r in (other, explicit))
            case.check(f"... {name}: displacements against those of explicit cycles [m]", ours, theirs, absolute=2e-4 * np.abs(theirs).max())
            ours, theirs = (r.stage_summary(name)["laws"]["block"] for r in (other, explicit))
            case.check("... energy lost, largest damage", [ours["lost"], ours["damage"]], [theirs["lost"], theirs["damage"]], relative=5e-4)
    # cycles enough: how the wall breaks, and so how soon it goes on steadily, hangs on the cycle at which creep hands over
    fails = case.run(mesh, changed(scene, ("loads.water.level", 7.5), ("relaxation.method", "preconditioned"), ("relaxation.max_cycles", 200000)))
    case.check("... water at 7.5 m, which the wall does not bear", fails.stage_summary("full")["verdict"], "collapsed")


def ranks_and_restart(case):
    mesh, scene = wall()
    folder = case.prepare(mesh, changed(scene, ("checkpoint", {"every": 400, "keep": 1000})))
    first = case.again(folder)
    case.check("all stages end well", [s["verdict"] for s in first.summary["stages"]], ["converged"] * 3 + ["completed"])
    damage = [first.stage_summary(s["name"])["laws"]["block"]["damage"] for s in first.summary["stages"]]
    case.check("full, it cracks; emptied, it stays cracked", [damage[0] == 0, damage[1] > 0.5, damage[2] == damage[1]], [True] * 3)
    widths = [first.stage_summary(name)["laws"]["block"]["crack_width"] for name in ("full", "empty")]
    case.check("... and the cracks close", bool(widths[1] < 0.2 * widths[0]), True)
    for ranks in case.ranks(2, 3, 4):
        case.check(f"checksums on {ranks} ranks", checksums(case.run(mesh, scene, ranks=ranks)), checksums(first))
    check_restarts(case, folder, first)


def both_laws(case):
    """Blocks that crack on ground that yields: each law has its own history in a checkpoint."""
    mesh, scene = wall()
    ground = {"density": 2400, "young": 10e9, "poisson": 0.2, "law": "mohr_coulomb", "cohesion": 1e5, "friction": 30, "tension": 2e4}
    scene = changed(scene, ("materials.ground", ground), ("stages", scene["stages"][:2]), ("checkpoint", {"every": 1000, "keep": 1000}))
    folder = case.prepare(mesh, scene)
    first = case.again(folder)
    laws = first.stage_summary("full")["laws"]
    case.check("two laws in one scene: ground yields, wall cracks", [laws["ground"]["plastic_strain"] > 0, laws["block"]["damage"] > 0], [True] * 2)
    case.again(folder, "-output", "kept")
    kept = sorted((folder / "kept" / "checkpoints").iterdir())
    for ranks in (1, 2):
        case.check(f"... restart on {ranks} ranks: checksums", checksums(case.again(folder, "-restart", kept[len(kept) // 2], ranks=ranks)), checksums(first))
