"""Where the method fails, what the user is warned of: step, connectivity, slivers, nearly parallel faces, support, a contact run over."""

import numpy as np
from driver import changed
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed
from quoin_tools.mesh.stacks import block_on_plane, column

WHAT = "where the method fails, its warnings"
SOURCE = "the messages"
BY = "the messages of this project"

SCENE = {
    "contact": {"connectivity": "variable", "tolerance": 0.005},
    "relaxation": {"allow_floating": True},
    "materials": {"block": {"density": 2400}, "base": {"density": 2400}},
    "joints": {"default": {"k_n": 1e9, "k_s": 1e9, "friction": 30}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
}


def stage(**keys):
    return ("stages", [{"go": {"type": "dynamic", "loads": ["weight"]} | keys}])


def told(case, what, result, verdict, words):
    case.check(what, result.verdict, verdict)
    said = result.stdout + result.stderr
    case.check(f"... says \"{words}\"", words in said, True)


def run(case):
    pressed_through(case)
    too_large_a_step(case)
    outgrown(case)
    not_held(case)
    sliver(case)
    nearly_parallel(case)
    in_mid_record(case)


def in_mid_record(case):
    """Static stages between two parts of a record bring the blocks to rest while the ground moves; joints of rigid blocks that nothing damps."""
    motion = {"motions": {"quake": {"file": "quake.csv", "direction": "x"}}, "supports": {"base": {"fix": "xy", "motion": "quake"}}}
    shake = {"type": "dynamic", "loads": ["weight"], "duration": 0.2}
    for damping, undamped in ((0, True), (1e-4, False)):
        for between, said in (([], False), ([{"again": {"loads": ["weight"]}}], True)):
            scene = changed(SCENE | motion, ("joints.default.damping", damping),
                            ("stages", [{"rest": {"loads": ["weight"]}}, {"one": shake}, *between, {"two": shake}]))
            folder = case.prepare(block_on_plane(slope_degrees=0), scene)
            (folder / "quake.csv").write_text("0, 0\n0.2, 1.2\n0.4, -1.2\n")  # 0.12 m/s at 0.2 s
            out = case.again(folder).stdout
            case.check(f"damping {damping:g}, {len(between)} static stages in mid-record: reported", "begins at t = 0.2 s, in the middle of the motion of support base, which moves at 0.12 m/s" in out, said)
            case.check("... joints that nothing damps: reported", "whose vibrations nothing damps" in out, undamped)


def pressed_through(case):
    """A block falls fast on a joint far too soft; and one so fast that a step takes it through the base's face."""
    mesh = column(1)
    soft = changed(SCENE, ("joints.default.k_n", 1e5), ("joints.default.k_s", 1e5), ("materials.block.velocity", [0.0, -10.0]),
                   stage(duration=1.0))
    told(case, "a contact is pressed in by a tenth of its length", case.run(mesh, soft), "diverged", "a contact is pressed in by")
    # into a slab of 0.3 m by v (m / k_n L)^1/2: 0.069 m, less than a quarter of it, and 0.097 m
    slab = join([renamed(rectangle(-2, -0.3, 4, 0.3, 4, 1, group="base", rigid=True), {}), renamed(rectangle(-1, 0.01, 2, 2, group="block", rigid=True), {})])
    for speed, verdict, words in ((-1.0, "converged", ""), (-1.4, "diverged", "a contact is pressed in by")):
        heavy = changed(SCENE, ("joints.default.k_n", 1e6), ("joints.default.k_s", 1e6), ("materials.block.velocity", [0.0, speed]), stage(loads=[], duration=0.3))
        told(case, f"a block strikes a thin slab at {-speed:g} m/s", case.run(slab, heavy), verdict, words)
    fast = changed(SCENE, ("materials.block.velocity", [0.0, -1e6]), stage(duration=0.01, dt_factor=1.0))
    told(case, "a block passes through in one step", case.run(mesh, fast), "diverged", "the step is too large")


def too_large_a_step(case):
    """Ten blocks fall on each other with steps at the bound of closed contacts, which is not enough where they open and close."""
    mesh = join([renamed(rectangle(-1, -1, 3, 1, group="base", rigid=True), {}),
                 *(renamed(rectangle(0, 0.55 * i + 0.05, 1, 0.5, group="block", rigid=True), {}) for i in range(10))])
    result = case.run(mesh, changed(SCENE, stage(duration=1.5, dt_factor=1.0)))
    told(case, "ten blocks fall, steps at the stability bound", result, "diverged", "the energy account is out by")
    result = case.run(mesh, changed(SCENE, stage(duration=0.4)))
    case.check("... at the default step", result.verdict, "converged")


def outgrown(case):
    """Fixed connectivity: a block slides off its contact."""
    scene = changed(SCENE, ("contact.connectivity", "fixed"), ("joints.default.friction", 10), stage(duration=0.6))
    told(case, "contacts are beyond the range of fixed connectivity", case.run(block_on_plane(), scene), "converged", "contacts are beyond the range of fixed connectivity")


def not_held(case):
    scene = changed(SCENE, ("relaxation", {}), ("stages", [{"rest": {"loads": ["weight"]}}]))
    mesh = join([renamed(rectangle(0, -1, 1, 1, group="base", rigid=True), {}),
                 renamed(rectangle(0, 1, 1, 1, group="block", rigid=True), {})])
    told(case, "a body with no support", case.run(mesh, scene), "bad input", "has no support")


def sliver(case):
    """A sliver is refused with its aspect ratio, one whose area is rounding as well; a slender block runs and is reported."""
    refused = "a sliver of aspect ratio 1e+09, expected at most 1e+06"
    for height, verdict, said in ((1e-13, "bad input", "its area is zero"), (1e-9, "bad input", refused),
                                  (1e-4, "converged", "1 block with an aspect ratio above 1000; worst is block 1, 1e+04")):
        thin = quad_patch((0, 0), (1, 0), (1, height), (0, height), 1, 1, "block", True)
        mesh = join([renamed(rectangle(0, -1, 1, 1, group="base", rigid=True), {}), renamed(thin, {})])
        result = case.run(mesh, changed(SCENE, ("stages", [{"rest": {"loads": ["weight"]}}])))
        case.check(f"a sliver 1 m by {height:g} m", result.verdict, verdict)
        case.check(f"... says \"{said}\"", said in result.stderr, True)


def nearly_parallel(case):
    """A wedge of half a degree on a plane, landing: contact of one corner, then of both faces; it comes to rest, nothing is gained."""
    t = np.tan(np.radians(0.5))
    wedge = quad_patch((0, 0.01), (1, 0.01 + t), (1, 0.5), (0, 0.5), 1, 1, "block", True)
    mesh = join([renamed(rectangle(-1, -1, 3, 1, group="base", rigid=True), {}), renamed(wedge, {}, {"right": "bottom_right"})])
    scene = changed(SCENE, ("joints.default.damping", 5e-4), stage(duration=1.5))
    result = case.run(mesh, scene)
    energy = result.stage_summary("go")["energy"]
    case.check("faces at half a degree: lands flat, right corner at [m]", 0.01 + t + result.probe("go", "right")[1], 0.0, absolute=1e-4)
    case.check("... nothing gained: all work of the weight is lost", energy["friction"] / energy["outside"], 1.0, absolute=0.01)
