"""What becomes of bodies in motion: overturned, fallen, slid out of their place, with the time; bodies that fixed connectivity lets through."""

import numpy as np
from driver import changed
from quoin_tools.base.results import report
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed

WHAT = "bodies in motion: overturned, fallen, slid out of their place, when; bodies that pass through each other"
SOURCE = "free fall: 0.5 h after sqrt(h/g); sliding: 0.1 b after (v - sqrt(v^2 - 0.2 b mu g))/(mu g); balance of a block: atan(b/h)"
BY = "by hand"

G = 9.81
SCENE = {
    "contact": {"connectivity": "variable", "tolerance": 0.01},
    "relaxation": {"allow_floating": True, "history_every": 10},
    "materials": {"block": {"density": 2400}, "base": {"density": 2400}},
    "joints": {"default": {"k_n": 1e9, "k_s": 1e9, "friction": 30, "stress_model": "pt"}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
}


def on_base(width, height, x=0.0, y=0.0, base=(-4, 12), division=1):
    return join([renamed(rectangle(base[0], -1, base[1], 1, group="base", rigid=True), {}),
                 renamed(rectangle(x, y, width, height, division, 2 * division, group="block", rigid=division == 1), {})])  # fmt: skip


def go(**keys):
    return ("stages", [{"go": {"type": "dynamic", "loads": ["weight"], "dt_factor": 0.1} | keys}])


def told(result):
    """The list `bodies` of the stage."""
    return result.stage_summary("go")["bodies"]


def run(case):
    overturned(case)
    next_to_balance(case)
    slid(case)
    fallen(case)
    table(case)
    fixed(case)


def overturned(case):
    """A block of 1 by 2 m given a spin: below what it needs to get over its corner it rocks back, above it goes over."""
    alpha = np.arctan(0.5)
    needed = np.sqrt(1.5 * G / np.hypot(0.5, 1.0) * (1 - np.cos(alpha)))  # of the rotation about the corner
    for factor, fates in ((0.9, []), (1.1, ["overturned"])):
        w = factor * needed  # about its corner: spin and the velocity of the mass centre
        scene = changed(SCENE, ("materials.block", {"density": 2400, "spin": -w, "velocity": [w * 1.0, w * 0.5]}),
                        ("joints.default.friction", 60), go(duration=1.2))
        result = case.run(on_base(1.0, 2.0), scene)
        found = [fate for body in told(result) for fate in ("overturned", "fallen", "slid") if body[fate] is not None and fate != "slid"]
        case.check(f"spin {factor:g} of what it needs to go over: {fates}", found, fates)
    wide = np.cbrt(12 * 2400 * 2.0 * G * 1.0 / 1e7)  # of the hinge of tptm
    soft = changed(scene, ("joints.default", {"k_n": 1e7, "k_s": 1e7, "friction": 60, "stress_model": "tptm"}), go(duration=0.01))
    case.check("... with tptm and 1e7 Pa/m: it says which part of its arm is missing", f"and {wide:.2g} of the arm of a rigid hinge is missing" in case.run(on_base(1.0, 2.0), soft).stdout, True)
    case.check("... with pt it does not", "of a rigid hinge is missing" in result.stdout, False)
    body = told(result)[0]
    case.check("... of group block, and in the evidence", [body["group"], "overturned: macroblock" in result.stage_summary("go")["evidence"]], ["block", True])
    t, w, theta = 0.0, factor * needed, 0.0  # Housner's block, in steps of 10 us
    while theta < alpha:
        w -= 1e-5 * 0.75 * G / np.hypot(0.5, 1.0) * np.sin(alpha - theta)
        theta += 1e-5 * w
        t += 1e-5
    case.check("... passes its balance at [s]", body["overturned"], t, absolute=0.02)
    flexible = changed(scene, ("materials.block", scene["materials"]["block"] | {"young": 1e10, "poisson": 0.2}), go(duration=0.8, dt_factor=0.5))
    folder = case.prepare(on_base(1.0, 2.0, division=2), flexible)
    one = case.again(folder)
    first, evidence = told(one), one.stage_summary("go")["evidence"]
    case.check("... as a body of eight deformable blocks [s]", first[0]["overturned"], t, absolute=0.05)
    two = case.again(folder, "-checkpoint_every", 7000, ranks=2)
    case.check("... the same, bit for bit, on 2 ranks", [told(two) == first, two.stage_summary("go")["evidence"].split(" s in ")[0]],
               [True, evidence.split(" s in ")[0]])  # fmt: skip
    again = case.again(folder, "-restart", sorted((folder / "out" / "checkpoints").iterdir())[-1])
    case.check("... and after a restart behind it", told(again) == first, True)


def next_to_balance(case):
    """A cube that lies corner down in a notch of 90 degrees, 2e-4 rad from its balance: a swing of 2e-3 rad does not overturn it."""
    for lean in (2e-4, -2e-4):
        turned = np.array([[np.cos(lean), -np.sin(lean)], [np.sin(lean), np.cos(lean)]])
        at = lambda x, y: turned @ (x, y)  # noqa: B023, E731
        cube = quad_patch(at(0, 0), at(1, -1), at(2, 0), at(1, 1), 1, 1, "block", True)
        sides = [quad_patch(at(-1, -1), at(1, -3), at(1, -1), at(-0.5, 0.5), 1, 1, "base", True),
                 quad_patch(at(1, -3), at(3, -1), at(2.5, 0.5), at(1, -1), 1, 1, "base", True)]
        scene = changed(SCENE, ("materials.block", {"density": 2400, "spin": 0.1}), ("joints.default.k_n", 1e7), ("joints.default.k_s", 1e7), go(duration=0.5))
        result = case.run(join([renamed(part, {}) for part in (*sides, cube)]), scene)
        case.check(f"a cube corner down in a notch, {lean:g} rad from its balance: nothing to tell", told(result), [])


def slid(case):
    """A block thrown along its base comes to rest after v^2 / (2 mu g)."""
    mu, v = np.tan(np.radians(30)), 1.5
    rest = [{"rest": {"loads": ["weight"]}}]
    for name, speed, expected in (("far", v, True), ("not far", 0.5 * v, False)):
        scene = changed(SCENE, ("materials.block.velocity", [speed, 0.0]), ("stages", rest + go(duration=0.5)[1]))
        body = told(case.run(on_base(1.5, 0.3), scene))
        case.check(f"thrown at {speed:g} m/s, {name}: slid out of its place", bool(body), expected)
        if body:
            case.check("... at [s]", body[0]["slid"], (v - np.sqrt(v**2 - 0.3 * mu * G)) / (mu * G), absolute=5e-3)
            case.check("... neither fallen nor overturned", [body[0]["fallen"], body[0]["overturned"]], [None, None])
            case.check("... moved v^2 / (2 mu g) [m]", body[0]["moved_x"], v**2 / (2 * mu * G), relative=0.02)


def fallen(case):
    """A block that is let go beside its base."""
    result = case.run(on_base(1.0, 1.0, x=10.0), changed(SCENE, go(duration=0.5)))
    body = told(result)[0]
    case.check("free fall: fallen at [s]", body["fallen"], np.sqrt(1.0 / G), absolute=5e-3)
    case.check("... printed", "fallen: macroblock" in result.stdout, True)
    case.check("... in the table of results", "Bodies that left their place" in report(result.summary), True)


def table(case):
    """What is carried along with the ground has not moved over it."""
    scene = changed(SCENE, ("supports.base", {"fix": "xy", "motion": "motion.csv"}), ("joints.default.friction", 60), go(duration=2.0))
    folder = case.prepare(on_base(1.5, 0.5), scene)
    (folder / "motion.csv").write_text("0, 0, 0\n1, 1, 0\n2, 0, 0\n")
    result = case.again(folder)
    case.check("block on a table that moves by 1 m: nothing to tell", told(result), [])


def fixed(case):
    """Connectivity is fixed: a block falls onto the base 0.5 m below, and through it; a warning says so before."""
    scene = changed(SCENE, ("contact.connectivity", "fixed"), go(duration=0.4))
    result = case.run(on_base(1.0, 1.0, y=0.5), scene)
    case.check("fixed connectivity, falls through its base", result.verdict, "diverged")
    case.check("... reported before", "macroblock with no contact will pass through" in result.stdout, True)
    case.check("... and then", "bodies pass through each other" in result.stage_summary("go")["evidence"], True)
    result = case.run(on_base(1.0, 1.0), scene)
    case.check("fixed connectivity, stays in its place: completed, nothing to tell", [result.verdict, told(result)], ["converged", []])
