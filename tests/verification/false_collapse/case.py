# ranks: 1
"""What stands is not told to fall, and what falls is told so: gaps, motion before the stage, nothing that moves."""

import numpy as np
from driver import changed
from quoin_tools.meshing import join, rectangle, renamed

WHAT = "what is no collapse, and what is: gaps, earlier motion, nothing that moves"
SOURCE = "statics: nothing moves but by the closure of joints, weight/k_n/width"

G, RHO, K_N = 9.81, 2400.0, 1e9
SCENE = {
    "contact": {"connectivity": "fixed"},
    "materials": {"block": {"density": RHO, "young": 1e9, "poisson": 0.2}, "base": {"density": 0, "young": 1e9, "poisson": 0.2}},
    "joints": {"default": {"k_n": K_N, "k_s": K_N, "friction": 10}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
    "stages": [{"rest": {"loads": ["weight"]}}],
}
CLOSURE = RHO * G / K_N  # of the joint under a block 1 m high
METHODS = ("explicit", "preconditioned")


def block_at(x, name="corner", y=0.0, rigid=True, n=1):
    return renamed(rectangle(x, y, 1, 1, n, n, group="block", rigid=rigid), {}, {name: "bottom_left"})


def base(rigid=True):
    return renamed(rectangle(-2, -1, 8, 1, group="base", rigid=rigid), {})


def run(case):
    gap(case)
    motion_before(case)
    nothing_moves(case)


def gap(case):
    """Two cubes 0.105 m apart are a contact under a tolerance of 0.11 m, and have not parted."""
    mesh = join([base(), block_at(0), block_at(1.105, "right")])
    for method in METHODS:
        result = case.run(mesh, changed(SCENE, ("contact.tolerance", 0.11), ("relaxation", {"method": method})))
        case.check(f"two cubes 0.105 m apart, {method}", result.verdict, "converged")
        case.check("... go down by weight/k_n [m]", -result.probe("rest", "right")[1], CLOSURE, relative=1e-4)


def motion_before(case):
    """The base runs 2 m under a block, which slides by 1.17 m of it; then the block stands there as before."""
    t = np.linspace(0, 1, 101)
    scene = changed(SCENE, ("supports.base", {"fix": "xy", "motion": "run.csv", "quantity": "velocity"}),
                    ("stages", [{"rest": {"loads": ["weight"]}}, {"run": {"type": "dynamic", "loads": ["weight"], "duration": 1.0}},
                                {"after": {"loads": ["weight"]}}]))
    folder = case.prepare(join([base(), block_at(0)]), scene)
    (folder / "run.csv").write_text("".join(f"{a},{12 * a * (1 - a)},0\n" for a in t))
    result = case.again(folder)
    case.check("a static stage after the base has run 2 m under a block, fixed connectivity", result.verdict, "converged")
    case.check("... stands on its joint, closed by [m]", -result.probe("after", "corner")[1], CLOSURE, relative=1e-4)
    case.check("... and says after both stages that fixed connectivity is outgrown", result.stderr.count("fixed connectivity is outgrown"), 2)


def nothing_moves(case):
    """All is held and nothing pulls: 0/0 is equilibrium."""
    mesh = join([base(False), block_at(0, rigid=False, n=2)])
    scene = changed(SCENE, ("gravity", 0), ("supports", {"base": {"fix": "xy"}, "block": {"fix": "xy"}}))
    for method in METHODS:
        stage = case.run(mesh, changed(scene, ("relaxation", {"method": method, "ramp": 0}))).stage_summary("rest")
        case.check(f"all held, no weight, {method}", stage["verdict"], "converged")
        case.check("... cycles, at most a look", stage["cycles"] <= 50, True)
