"""Relaxation with a mass proportional to the elastic stiffness (relaxation.method: stiffness_mass) against closed forms and
the explicit loop: elastic columns of any mesh, a dam of stones with friction, verdicts, variable connectivity, restarts, ranks, fallback."""

import shutil

import h5py
import numpy as np
from driver import changed, load
from quoin_tools.mesh.blockmesh import areas
from quoin_tools.mesh.stacks import block_on_plane, column, patch_test
from quoin_tools.mesh.voronoi import Options, voronoi_mesh
from quoin_tools.mesh.walls import arch, wall

WHAT = "relaxation by stiffness-proportional mass: closed forms, cycles whatever the mesh, dams of stones by explicit cycles, verdicts, restarts"
SOURCE = "springs in series; W cos(a), W sin(a) on a plane; the explicit loop"
BY = "by hand; Quoin itself, the explicit loop"

RHO, GRAVITY = 2400.0, 9.81
STONE = {"density": RHO, "young": 10e9, "poisson": 0.2}
SCENE = {
    "relaxation": {"method": "stiffness_mass", "tolerance": 1e-6},
    "materials": {"dam": STONE, "facing": STONE},
    "joints": {"default": {"stress_model": "tptm", "k_n": 10e9, "k_s": 3e9, "friction": 60}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight"}},
    "stages": [{"sw": {"loads": ["weight"]}}],
}
EXPLICIT = ("relaxation.method", "explicit")
ARCH = SCENE | {
    "relaxation": {}, "materials": {"voussoir": {"density": RHO}, "abutment": {"density": 0}}, "supports": {"abutment": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["voussoir"]}},
}  # fmt: skip
RIGID = (("materials.dam", {"density": RHO, "rigid": True}), ("materials.facing", {"density": RHO, "rigid": True}))


def run(case):
    columns(case)
    plane(case)
    stones(case)
    verdicts(case)
    chosen(case)
    rubble(case)
    equilibria(case)
    chains(case)
    raised(case)
    leaves(case)
    restart(case)
    ranks(case)
    hand_overs(case)
    creeps(case)
    divergences(case)
    hurries(case)
    guards(case)


def stage_of(result):
    return result.stage_summary(result.summary["stages"][0]["name"])


def columns(case):
    """n stones on top of each other, joints k_n: the top goes down by the sum of weights above each joint over k_n, in as many cycles."""
    k_n, numbers = 1e9, (4, 16, 64)
    scene = changed(SCENE, ("strain", "small"), ("materials", {"block": {"density": RHO, "rigid": True}, "base": {"density": 0, "rigid": True}}),
                    ("loads.weight.groups", ["block"]), ("joints.default", {"k_n": k_n, "k_s": 0.3 * k_n, "friction": 45}))  # fmt: skip
    runs = case.run_all([(column(n), scene) for n in numbers])
    tops = [np.abs(r.stage("sw").displacement[:, 1]).max() for r in runs]
    case.check("columns of 4, 16, 64 stones: settlement of the top [m]", tops,
               [RHO * GRAVITY * n * (n + 1) / 2 / k_n for n in numbers], relative=1e-6)  # fmt: skip
    cycles = [stage_of(r)["cycles"] for r in runs]
    case.check("... cycles behind the ramp of 1000, at most", max(cycles) <= 1150, True)
    case.check("... method, and a solve a cycle", [stage_of(runs[0])["method"], stage_of(runs[0])["solves"] >= cycles[0]], ["stiffness_mass", True])
    logged = case.again(case.prepare(column(4), scene), "-log_view")
    timed = [int(line.split()[1]) for line in logged.stdout.splitlines() if line.startswith("Solves ")]
    case.check("... its solves are timed as such, one a cycle", timed, [stage_of(logged)["cycles"]])


def plane(case):
    """A block on a slope of 30 degrees: forces by statics where friction holds; it slides away where friction is less."""
    scene = changed(SCENE, ("materials", {"block": STONE, "base": {"density": 0}}), ("loads.weight.groups", ["block"]))
    for rigid in (True, False):
        stands, falls = case.run_all([(block_on_plane(rigid=rigid), changed(scene, ("joints.default.friction", phi))) for phi in (31, 29)])
        base = stage_of(stands)["supports"]["base"]
        weight = RHO * GRAVITY * 0.2
        name = "rigid" if rigid else "deformable"
        case.check(f"{name} block on a slope of 30 degrees: reaction over its weight", [base["x"] / weight, base["y"] / weight], [0, 1], absolute=1e-6)
        case.check("... verdicts with 31 and 29 degrees", [stage_of(stands)["verdict"], stage_of(falls)["verdict"]], ["converged", "collapsed"])


def dam():
    return voronoi_mesh(options=Options(seed=5, side=1.6))


def stones(case):
    """150 stones of 1.6 m under their weight: one answer, in fewer cycles."""
    for name, changes in (("rigid", RIGID), ("deformable", ())):
        scene, variable = changed(SCENE, *changes), ("contact", {"connectivity": "variable"})
        ours, explicit, moved = case.run_all([(dam(), scene), (dam(), changed(scene, EXPLICIT)), (dam(), changed(scene, variable))])
        size = abs(explicit.stage("sw").displacement).max()
        for what, run_of in (("fixed", ours), ("variable", moved)):
            case.check(f"150 {name} stones, {what} connectivity: displacements by explicit cycles, fixed [m]", run_of.stage("sw").displacement,
                       explicit.stage("sw").displacement, absolute=1e-3 * size)  # fmt: skip
            case.check("... method", stage_of(run_of)["method"], "stiffness_mass")
        case.check("... base force over weight", stage_of(ours)["supports"]["base"]["y"], RHO * GRAVITY * areas(dam()).sum(), relative=1e-6)
        case.check("... cycles, less than two thirds of", 3 * stage_of(ours)["cycles"] < 2 * stage_of(explicit)["cycles"], True)


def verdicts(case):
    """With 35 degrees the stones at the upstream face cannot stand, and both methods say so."""
    scene = changed(SCENE, *RIGID, ("joints.default.friction", 35))
    both = case.run_all([(dam(), scene), (dam(), changed(scene, EXPLICIT))])
    case.check("150 rigid stones, friction 35 degrees: verdicts", [stage_of(r)["verdict"] for r in both], ["collapsed"] * 2)
    case.check("... cycles, less than half of", 2 * stage_of(both[0])["cycles"] < stage_of(both[1])["cycles"], True)
    less = changed(scene, ("joints.default.friction", 30), ("checkpoint", {"every": 1200}))
    folder, far = case.prepare(dam(), less), case.run(dam(), changed(less, ("joints.default.friction", 20)))
    ours = case.again(folder)
    slid = float(stage_of(ours)["evidence"].split(", ")[1].split(" ")[0])
    case.check("... 30 degrees: a stone that has slid by a tenth of its face decides, not twice the ramp of 1000", [0.1 < slid < 0.2, 1000 < stage_of(ours)["cycles"] < 2000], [True] * 2)
    case.check("... 20 degrees: not before the ramp has ended", stage_of(far)["cycles"] > 1000, True)
    again = [case.again(folder, ranks=2), case.again(folder, "-restart", sorted((folder / "out" / "checkpoints").iterdir())[0])]
    case.check("... on two ranks, and behind a restart: checksums", [stage_of(r)["checksum"] for r in again], [stage_of(ours)["checksum"]] * 2)


def chosen(case):
    """The default takes this method for hundreds of rigid stones with friction alone, in strength reductions of fifty stones or more, rigid or not,
    on any number of ranks, and leaves it where it finds no end."""
    brief = changed(SCENE, ("relaxation", {"method": "auto", "ramp": 0, "max_cycles": 50}))
    many = voronoi_mesh(options=Options(seed=3, side=0.6))
    rigid, bonded = changed(brief, *RIGID), changed(brief, *RIGID, ("joints.default.cohesion", 1e4))
    results = [case.run(mesh, scene, ranks=ranks) for mesh, scene, ranks in ((many, rigid, 1), (many, rigid, 2), (many, brief, 1), (many, bonded, 1), (dam(), rigid, 1))]
    case.check("auto, 597 rigid stones: method; on two ranks, deformable, with cohesion, 150 stones", [stage_of(r)["method"] for r in results],
               [*["stiffness_mass, then explicit"] * 3, *["explicit"] * 2])  # fmt: skip
    less = ("stages", [{"sw": {"type": "strength_reduction", "loads": ["weight"], "start": 45, "step": 12, "limit": 20, "bracket": 6}}])
    few = voronoi_mesh(options=Options(seed=5, facing=(0, 0), side=2.5))
    trials = [case.run(mesh, changed(brief, less, *more)) for mesh, more in
              ((many, ()), (dam(), ()), (many, (("joints.default.cohesion", 1e4),)), (few, (("materials", {"dam": STONE}),)))]
    case.check("... strength reduction of 597 deformable stones, of 150, of 597 with cohesion, of 41: method", [stage_of(r)["method"] for r in trials],
               [*["stiffness_mass, then explicit"] * 2, "explicit", "preconditioned"])  # fmt: skip
    both = case.run_all([(dam(), changed(SCENE, less, ("relaxation", {"method": method}))) for method in ("stiffness_mass", "explicit")])
    brackets = [[stage_of(r)["strength_reduction"][end] for end in ("stable", "failing")] for r in both]
    case.check("150 deformable stones: bracket, that of explicit cycles [degree]", brackets[0], brackets[1], relative=1e-9)
    case.check("... method", [stage_of(r)["method"] for r in both], ["stiffness_mass", "explicit"])


def leaves(case):
    """Where blocks jump in two trials, the rest of a strength reduction is done by explicit cycles, with their bracket."""
    stiff = changed(SCENE, *RIGID, ("relaxation", {}), ("joints.default", {"k_n": 1e11, "k_s": 1e11, "friction": 50}),
                    ("stages", [{"less": {"type": "strength_reduction", "loads": ["weight"], "start": 50, "step": 10, "limit": 5, "bracket": 0.5}}]))  # fmt: skip
    stones = voronoi_mesh(options=Options(seed=7, side=3.0))
    one, two, explicit = case.run(stones, stiff), case.run(stones, stiff, ranks=2), case.run(stones, changed(stiff, EXPLICIT))
    why = stage_of(one)["method_choice"].split("; ")
    case.check("97 rigid stones in stiff joints, strength reduction: method", stage_of(one)["method"], "stiffness_mass, then explicit")
    case.check("... its last trials are explicit: chosen, and why", why[:2],
               ["stiffness_mass: the trials after those that it left by explicit cycles",
                "2 times explicit cycles began again, after a jump of blocks (2), a divergence (0) or no end (0)"])  # fmt: skip
    case.check("... on two ranks: checksum", stage_of(two)["checksum"], stage_of(one)["checksum"])
    brackets = [[stage_of(found)["strength_reduction"][end] for end in ("stable", "failing")] for found in (one, explicit)]
    case.check("... bracket, that of explicit cycles [degree]", brackets[0], brackets[1], relative=1e-9)


def creeps(case):
    """By default explicit cycles that have let slip go are left: of a dam that falls in a tenth of their time, with the same bits on two ranks and
    behind a restart; one that stands keeps its place."""
    scene = changed(SCENE, ("relaxation", {}), ("joints.default.friction", 35))
    folder = case.prepare(dam(), changed(scene, ("checkpoint", {"minutes": 60, "keep": 9})))
    one = case.again(folder)
    explicit = case.run(dam(), changed(scene, EXPLICIT))
    case.check("150 deformable stones, friction 35 degrees, auto: method", stage_of(one)["method"], "explicit, then stiffness_mass")
    case.check("... and explicit: verdicts", [stage_of(r)["verdict"] for r in (one, explicit)], ["collapsed"] * 2)
    case.check("... cycles, less than a fifth of", 5 * stage_of(one)["cycles"] < stage_of(explicit)["cycles"], True)
    again = [case.again(folder, ranks=2), case.again(folder, "-restart", folder / "out" / "checkpoints" / "checkpoint_000001.h5", ranks=2)]
    case.check("... on two ranks, and from the checkpoint of the hand-over: checksums", [stage_of(r)["checksum"] for r in again], [stage_of(one)["checksum"]] * 2)
    stands = changed(scene, ("joints.default.friction", 45))
    ours, other = case.run_all([(dam(), stands), (dam(), changed(stands, EXPLICIT))])
    right = other.stage("sw").displacement
    case.check("... 45 degrees: method", stage_of(ours)["method"], "explicit, then stiffness_mass")
    case.check("... displacements by explicit cycles [m]", ours.stage("sw").displacement, right, absolute=2e-3 * abs(right).max())


def rubble(case):
    """A dam of elastic stones takes this method up to its first stall, then explicit cycles: one answer, by the law of friction, whatever the ramp,
    the number of ranks and where the stage is begun again. A wall of courses stays with explicit cycles."""
    stones = voronoi_mesh(options=Options(seed=32, side=1.0))
    scene = changed(SCENE, ("relaxation", {}), ("joints.default.friction", 38), ("checkpoint", {"every": 900, "keep": 99}))
    folder = case.prepare(stones, scene)
    one, slow = case.again(folder), case.run(stones, changed(scene, ("relaxation.ramp", 8000)))
    shutil.copytree(folder / "out" / "checkpoints", folder / "kept")
    why = stage_of(one)["method_choice"]
    case.check("255 deformable stones, auto: method", stage_of(one)["method"], "stiffness_mass, then explicit")
    case.check("... told: why, and the hand-over", ["255 stones of rubble" in why, "at the first stall" in why], [True, True])
    order = float(why.split("four-fold order ")[1].split(";")[0])
    case.check("... four-fold order", order, 0.5, absolute=0.1)
    case.check("... friction to the end by its law", "slip kept" in stage_of(one)["evidence"], False)
    right = slow.stage("sw").displacement
    case.check("... displacements by a ramp eight times as long [m]", one.stage("sw").displacement, right, absolute=1e-4 * abs(right).max())
    stalled = int(why.split("went on after ")[1].split()[0])
    files, cycles = [file for file in sorted((folder / "kept").iterdir()) if "stage" in h5py.File(file)], stage_of(one)["cycles"]
    case.check("... stalls behind the first checkpoint, before the last", 900 < stalled < cycles // 900 * 900, True)
    case.check("... checkpoints: every 900 cycles, and at the stall", len(files), cycles // 900 + 1)
    again = [case.again(folder, ranks=2), *(case.again(folder, "-restart", file, ranks=n) for file in (files[0], files[stalled // 900], files[-1]) for n in (1, 2))]
    what = ("checksum", "verdict", "cycles", "method", "method_choice")
    case.check("... on two ranks, and from checkpoints before, at and behind the stall on one and two", [[stage_of(r)[key] for key in what] for r in again],
               [[stage_of(one)[key] for key in what]] * 7)  # fmt: skip
    bonded = changed(SCENE, ("relaxation", {}), ("materials", {"block": STONE, "base": {"density": 0, "rigid": True}}), ("loads.weight.groups", ["block"]))
    case.check("a wall of 411 deformable stones: method", stage_of(case.run(wall(20, 20, rigid=False), bonded))["method"], "explicit")


def equilibria(case):
    """Where many contacts of rubble slip there may be several equilibria, and a run says so by any method. Courses have shown one: two ramps agree."""
    told = "Where so many slip in rubble there may be several equilibria"
    for method in ("explicit", "preconditioned", "stiffness_mass"):
        one = case.run(voronoi_mesh(options=Options(seed=574, side=2.0)), changed(SCENE, *RIGID, ("relaxation.method", method), ("joints.default.friction", 60)))
        case.check(f"rubble of rigid stones, {method}: converged by the law of friction", [stage_of(one)["verdict"], "slip kept" in stage_of(one)["evidence"]], ["converged", False])
        case.check("... told of other equilibria", told in one.stderr, True)
    bed = changed(SCENE, EXPLICIT, ("joints.default.k_n", 1e9), ("joints.default.k_s", 1e9), ("materials", {"block": {"density": RHO}, "base": {"density": 0}}),
                  ("loads.weight.groups", ["block"]), ("loads.push", {"type": "traction", "faces": "left", "value": [10e3, 0]}), ("stages", [{"pushed": {"loads": ["weight", "push"]}}]))  # fmt: skip
    one, slow = case.run_all([(wall(10, 10), bed), (wall(10, 10), changed(bed, ("relaxation.ramp", 10000)))])
    slid = int((abs(one.stage("pushed").contacts.slip).max(axis=-1) > 0).sum())
    case.check("a wall that is pushed: a twentieth of its contacts has slipped", slid > 0.05 * len(one.stage("pushed").contacts.slip), True)
    right = slow.stage("pushed").displacement
    case.check("... displacements by a longer ramp [m]", one.stage("pushed").displacement, right, absolute=1e-4 * abs(right).max())
    case.check("... nothing told", told in one.stderr + slow.stderr, False)


def chains(case):
    """An arch of 51 stones: its static stage stays explicit, the trials take a solve a cycle, with the bracket of explicit cycles."""
    scene = changed(ARCH, ("relaxation.tolerance", 1e-6), ("joints.default.friction", 40),
                    ("stages", [{"sw": {"loads": ["weight"]}}, {"less": {"type": "strength_reduction", "loads": ["weight"], "step": 10, "bracket": 0.25, "limit": 5}}]))  # fmt: skip
    one, other = case.run_all([(arch(51), scene), (arch(51), changed(scene, EXPLICIT))])
    two = case.run(arch(51), scene, ranks=2)
    for run_of, where in ((one, ""), (two, " on two ranks")):
        case.check(f"an arch of 51 stones{where}: methods", [run_of.stage_summary(name)["method"] for name in ("sw", "less")], ["explicit", "stiffness_mass"])
    case.check("... checksums", two.stage_summary("less")["checksum"], one.stage_summary("less")["checksum"])
    brackets = [[found.stage_summary("less")["strength_reduction"][end] for end in ("stable", "failing")] for found in (one, other)]
    case.check("... bracket, that of explicit cycles [degree]", brackets[0], brackets[1], relative=1e-9)
    push = changed(scene, ("loads.crown", {"type": "point_force", "point": "crown_extrados", "value": [0, -10e3]}), ("materials.voussoir", STONE),
                   ("stages", [{"crown": {"type": "load_factor", "loads": ["weight", "crown"], "raises": ["crown"], "step": 4, "limit": 100, "bracket": 0.5}}]))  # fmt: skip
    strong = changed(push, ("joints.default.cohesion", 1e5), ("joints.default.tension", 5e4))
    for what, keys in (("", push), (" in joints with cohesion", strong)):
        few, other = case.run_all([(arch(21, rigid=False), keys), (arch(21, rigid=False), changed(keys, EXPLICIT))])
        case.check(f"an arch of 21 deformable stones{what}, load at its crown: method", stage_of(few)["method"], "stiffness_mass")
        case.check("... bracket, that of explicit cycles", [stage_of(few)["load_factor"][end] for end in ("stable", "failing")],
                   [stage_of(other)["load_factor"][end] for end in ("stable", "failing")], relative=1e-9)  # fmt: skip


def raised(case):
    """Where a load is raised on rubble the trials take a solve a cycle, whatever the number of ranks; on a wall of courses they do not."""
    trials = [{"more": {"type": "load_factor", "loads": ["weight", "push"], "raises": ["push"], "step": 1, "limit": 20, "bracket": 0.1}}]
    scene = changed(SCENE, *RIGID, ("relaxation", {}), ("joints.default", {"k_n": 1e9, "k_s": 1e8, "friction": 60, "stress_model": "pt"}),
                    ("loads.push", {"type": "reservoir", "faces": "upstream", "level": 25, "density": 1000}), ("stages", trials))  # fmt: skip
    stones = voronoi_mesh(options=Options(seed=222, side=2.0))
    one, other, two = case.run(stones, scene), case.run(stones, changed(scene, EXPLICIT)), case.run(stones, scene, ranks=2)
    case.check("water raised on a dam of rigid stones: method", stage_of(one)["method"], "stiffness_mass")
    case.check("... factor, that of explicit cycles", stage_of(one)["load_factor"]["stable"], stage_of(other)["load_factor"]["stable"], relative=0.03)
    case.check("... checksum on two ranks", stage_of(two)["checksum"], stage_of(one)["checksum"])
    bed = changed(scene, ("materials", {"block": {"density": RHO}, "base": {"density": 0}}), ("loads.weight.groups", ["block"]),
                  ("loads.push", {"type": "traction", "faces": "left", "value": [3e3, 0]}))  # fmt: skip
    case.check("... of a wall: method", stage_of(case.run(wall(6, 10), bed))["method"], "explicit")


def restart(case):
    """From a checkpoint within the ramp and one behind it, the same bits on one rank and on several."""
    folder = case.prepare(dam(), changed(SCENE, *RIGID, ("checkpoint", {"every": 600, "keep": 9})))
    first = case.again(folder)
    case.again(folder, "-output", "kept")
    kept = sorted((folder / "kept" / "checkpoints").iterdir())
    case.check("150 rigid stones: checkpoints", len(kept) >= 2, True)
    whole = first.stage("sw").displacement
    for file, ranks in ((kept[0], 1), (kept[1], 1), (kept[0], 2)):
        again = case.again(folder, "-restart", file, ranks=ranks)
        case.check(f"restart from {file.name} on {ranks}: displacements [m]", again.stage("sw").displacement, whole, absolute=0.0)


def ranks(case):
    """The same bits on any number of ranks, through shared memory and by messages, rigid and deformable, with contacts found anew."""
    for name, changes in (("rigid", RIGID), ("deformable, variable connectivity", (("contact", {"connectivity": "variable"}), ))):
        folder = case.prepare(dam(), changed(SCENE, *changes, ("relaxation.ramp", 100), ("relaxation.max_cycles", 200)))
        sums = [stage_of(case.again(folder, "-exchange", exchange, ranks=n))["checksum"] for n, exchange in ((1, "auto"), (2, "auto"), (3, "auto"), (5, "auto"), (2, "messages"))]
        case.check(f"stones, {name}: checksums on 1, 2, 3, 5 ranks and on 2 by messages, one number", len(set(sums)), 1)


def hand_overs(case):
    """A stage that goes over to explicit cycles leaves a checkpoint: from there any number of ranks comes to the end of the run that went on."""
    kept = ("checkpoint", {"minutes": 60, "keep": 9})
    ends_soon = changed(SCENE, *RIGID, kept, ("relaxation", {"method": "stiffness_mass", "ramp": 100, "max_cycles": 200}))
    soft = changed(ARCH, kept, ("relaxation.method", "stiffness_mass"), ("joints.default.k_n", 1e7), ("joints.default.k_s", 1e6))
    newton = changed(load("preconditioned").WALL, kept, ("relaxation.method", "preconditioned"), ("relaxation.effort", 1))
    for name, mesh, scene, times in (("stiffness_mass finds no end", dam(), ends_soon, 1), ("stiffness_mass diverges", arch(21, thickness=0.7), soft, 1),
                                     ("Newton's method finds no end", wall(4, 3, rigid=False), newton, 2)):
        folder = case.prepare(mesh, scene)
        whole = case.again(folder)
        stages = [stage["name"] for stage in whole.summary["stages"]]
        shutil.copytree(folder / "out" / "checkpoints", folder / "kept")
        within = [file for file in sorted((folder / "kept").iterdir()) if "stage" in h5py.File(file)]
        case.check(f"{name}: checkpoints within a stage", len(within), times)
        for n in case.ranks(1, 2, 4):
            again = case.again(folder, "-restart", within[0], ranks=n)
            ends = [[result.stage_summary(stage)[what] for stage in stages for what in ("checksum", "verdict", "cycles", "method")] for result in (again, whole)]
            case.check(f"... ends after a restart from it on {n}", *ends)


def divergences(case):
    """Voussoirs of soft joints turn by a radian a cycle: explicit cycles do it again, and find what they find alone, a collapse or a factor."""
    soft = changed(ARCH, ("joints.default", {"k_n": 1.8e8, "k_s": 9e6, "friction": 25}),
                   ("loads.crown", {"type": "point_force", "point": "crown_extrados", "value": [0, -10e3]}),
                   ("stages", [{"sw": {"loads": ["weight"]}}, {"crown": {"type": "load_factor", "loads": ["weight", "crown"], "raises": ["crown"], "step": 20, "limit": 400, "bracket": 2}}]))  # fmt: skip
    one, other = (found.stage_summary("crown") for found in case.run_all([(arch(75, thickness=2.3), soft), (arch(75, thickness=2.3), changed(soft, EXPLICIT))]))
    case.check("an arch of 75 stones in soft joints, load at its crown: method", one["method"], "stiffness_mass, then explicit")
    case.check("... told why, and two trials of six alone: a divergence leaves nothing in the factor", one["method_choice"].split("; ")[1],
               "2 times explicit cycles began again, after a jump of blocks (0), a divergence (2) or no end (0)")
    brackets = [[found["load_factor"][end] for end in ("stable", "failing")] for found in (one, other)]
    case.check("... bracket, that of explicit cycles", brackets[0], brackets[1], relative=1e-9)
    stiffness_mass = changed(ARCH, ("relaxation.method", "stiffness_mass"), ("joints.default.k_n", 1e7), ("joints.default.k_s", 1e6))
    fixed, variable = case.run_all([(arch(21, thickness=0.7), scene) for scene in (stiffness_mass, changed(stiffness_mass, ("contact", {"connectivity": "variable"})))])
    case.check("an arch that falls: verdict and method", [stage_of(fixed)["verdict"], stage_of(fixed)["method"]], ["collapsed", "stiffness_mass, then explicit"])
    case.check("... told", fixed.stderr.count("cycles of stiffness_mass have diverged: explicit cycles begin again"), 1)
    case.check("... with variable connectivity no stage goes back, and its end says so", [stage_of(variable)["verdict"], stage_of(variable)["evidence"].endswith("try relaxation.method: explicit")],
               ["diverged", True])  # fmt: skip


def hurries(case):
    """A wall in which nothing slips under pressure takes a shorter ramp, with the answer of explicit cycles, the same bits on two ranks and behind a restart."""
    scene = changed(SCENE, ("materials", {"block": {"density": RHO, "rigid": True}, "base": {"density": 0, "rigid": True}}), ("joints.default.friction", 35),
                    ("loads.weight.groups", ["block"]), ("checkpoint", {"every": 100, "keep": 9}))  # fmt: skip
    folder = case.prepare(wall(8, 8), scene)
    ours, explicit = case.again(folder), case.run(wall(8, 8), changed(scene, EXPLICIT))
    shutil.copytree(folder / "out" / "checkpoints", folder / "kept")
    case.check("a wall of 68 stones: cycles, with a ramp of 1000, at most", stage_of(ours)["cycles"] <= 500, True)
    size = abs(explicit.stage("sw").displacement).max()
    case.check("... displacements by explicit cycles [m]", ours.stage("sw").displacement, explicit.stage("sw").displacement, absolute=1e-4 * size)
    first = sorted((folder / "kept").iterdir())[0]
    others = case.again(folder, ranks=2), case.again(folder, "-restart", first)
    case.check("... checksums on two ranks, and behind a restart within the ramp", [stage_of(other)["checksum"] for other in others], [stage_of(ours)["checksum"]] * 2)


def guards(case):
    """Where the stiffness has no factor, for want of support or of memory, explicit cycles do the stage, and a line says so."""
    patch = load("patch")
    pull = {side: {"type": "traction", "faces": side, "value": [x * 400.0, 0]} for side, x in (("left", -1), ("right", 1))}
    scene = changed(patch.SCENE, ("relaxation.method", "stiffness_mass"), ("supports", {}), ("relaxation.allow_floating", True),
                    ("loads", pull), ("stages", [{"pull": {"loads": ["left", "right"]}}]))  # fmt: skip
    floats = case.run(patch_test(), scene)
    case.check("a floating patch: method", stage_of(floats)["method"], "explicit")
    case.check("... told", floats.stderr.count("no factor"), 1)
    case.check("... stress [Pa]", floats.stage("pull").stress[:, 0], 400.0, relative=1e-6)
    local = case.run(column(2), changed(SCENE, ("materials", {"block": STONE, "base": {"density": 0}}), ("loads.weight.groups", ["block"]),
                                        ("relaxation.damping", "local")))  # fmt: skip
    case.check("damping: local opposes single degrees of freedom: method", stage_of(local)["method"], "explicit")
    # the factor takes 0.16 GB, the rest 0.07: what a process has resident varies by some 0.01
    small = case.run(wall(80, 80, rigid=False), changed(load("preconditioned").WALL, ("relaxation.method", "stiffness_mass"), ("memory_limit", 0.17),
                                                        ("relaxation.max_cycles", 50), ("relaxation.ramp", 0)))  # fmt: skip
    case.check("a wall, no memory for the factor: method", stage_of(small)["method"], "explicit")
    case.check("... told", small.stderr.count("no memory for the factor"), 1)
