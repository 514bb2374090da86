# ranks: 4
"""Blocks that fall: a column of ten drops and comes to rest; a block slides off an edge, falls and lands on another."""

import json

import numpy as np
from driver import changed
from quoin_tools.meshing import join, rectangle, renamed

WHAT = "a column of ten falls and comes to rest; a block slides off an edge, falls and lands"
SOURCE = "at rest: closure = weight above / k_n; energy: none gained, what is lost went into joints; the run on one rank"

G, RHO, K_N = 9.81, 2400.0, 1e9
SCENE = {
    "contact": {"connectivity": "variable", "tolerance": 0.005},
    "relaxation": {"allow_floating": True, "history_every": 200},
    "materials": {"block": {"density": RHO}, "base": {"density": RHO}},
    "joints": {"default": {"k_n": K_N, "k_s": K_N, "friction": 35, "damping": 5e-4}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
}
WIDTH, HEIGHT, GAP, N = 1.0, 0.5, 0.05, 10


def run(case):
    column(case)
    off_the_edge(case)


def on_ranks(case, what, mesh, scene, *ranks):
    """The run on one rank, and a check that the others have its bits."""
    results = [case.run(mesh, scene, ranks=n) for n in (1, *ranks)]
    sums = [result.summary["stages"][-1]["checksum"] for result in results]
    case.check(f"{what}: same bits on 1, {', '.join(map(str, ranks))} ranks", json.dumps(sorted(set(sums))), json.dumps(sums[:1]))
    return results[0]


def energy_of(case, what, result, stage):
    """Nothing is gained on the way, and the account is closed."""
    h = result.history
    mine = (h["stage"] == stage) & np.isfinite(h["balance_J"])
    moved = np.abs(h["outside_J"][mine]).max()
    stored = sum(h[name][mine] for name in ("kinetic_J", "strain_J", "joints_J"))
    gained = stored - h["outside_J"][mine]
    gained = gained - gained[0]
    case.check(f"{what}: energy never more than the weight has worked, over that work", max(0.0, gained.max() / moved), 0.0,
               absolute=1e-3)
    case.check(f"{what}: balance of the account, over that work", h["balance_J"][mine] / moved, 0.0, absolute=1e-2)
    case.check(f"{what}: made by finding contacts anew, over that work", np.abs(h["detection_J"][mine]).max() / moved, 0.0,
               absolute=1e-2)
    return moved


def deepest(result, stage):
    """Deepest closure of a contact over all frames [m]."""
    return max(-min(result.stage(name).contacts.opening.min(initial=0.0), 0.0) for name in [*result.frames(stage), stage])


def column(case):
    bodies = [rectangle(-0.5, -1, 2, 1, group="base", rigid=True)]
    for i in range(N):
        bodies.append(rectangle(0, (i + 1) * GAP + i * HEIGHT, WIDTH, HEIGHT, group="block", rigid=True))
    mesh = join([renamed(body, {}, {f"block_{i}": "bottom_left"} if i else {}) for i, body in enumerate(bodies)])
    stages = [{"fall": {"type": "dynamic", "loads": ["weight"], "duration": 3.0, "frames": 100}}]
    result = on_ranks(case, "column of ten", mesh, changed(SCENE, ("stages", stages)), 2, 3, 4)
    weight = RHO * G * WIDTH * HEIGHT
    energy_of(case, "column of ten", result, "fall")
    y = np.array([result.probe("fall", f"block_{i}") for i in range(1, N + 1)])
    closure = np.cumsum(weight * np.arange(N, 0, -1) / (K_N * WIDTH))
    case.check("column of ten at rest: closure of the joints [m]", -y[:, 1] - GAP * np.arange(1, N + 1), closure, relative=0.01)
    case.check("... moved sideways [m]", y[:, 0], 0.0, absolute=1e-6)
    energy = result.stage_summary("fall")["energy"]
    case.check("... lost in joints over the work of the weight", energy["friction"] / energy["outside"], 1.0, relative=0.001)
    # ten blocks together that stop from the fall of the whole column press no deeper than a spring that takes all its energy
    fall = N * weight * GAP * (N + 1) / 2
    case.check("... overlap no deeper than k_n explains", bool(deepest(result, "fall") < np.sqrt(2 * fall / (K_N * WIDTH))), True)


def off_the_edge(case):
    high = rectangle(0, 0, 1.5, 1.0, group="base", rigid=True)
    low = [rectangle(x, 0, 1.5, 0.3, group="base", rigid=True) for x in (1.7, 3.2)]
    block = rectangle(0.9, 1.0, 0.5, 0.25, group="block", rigid=True)
    mesh = join([*(renamed(body, {}) for body in (high, *low)), renamed(block, {}, {"block": "bottom_left", "top": "top_right"})])
    stages = [{"rest": {"loads": ["weight"]}},
              {"slide": {"type": "dynamic", "loads": ["weight"], "duration": 2.0, "frames": 100,
                         "joints": {"default": {"friction": 10}}}}]
    scene = changed(SCENE, ("stages", stages), ("materials.block.velocity", [2.0, 0.0]))
    result = on_ranks(case, "off the edge", mesh, scene, 2, 3, 4)
    moved = energy_of(case, "off the edge", result, "slide")
    kinetic = 0.5 * RHO * 0.125 * 2.0**2
    case.check("off the edge: overlap no deeper than a spring of one corner that takes all its energy",
               bool(deepest(result, "slide") < np.sqrt(2 * (moved + kinetic) / (K_N * 0.25 / 2))), True)
    mid = result.stage("slide").displacement[-4:] + result.mesh.vertices[-4:]
    case.check("... it has landed on the lower block: height of its lowest corner [m]", mid[:, 1].min(), 0.3, absolute=1e-3)
    case.report("... kinetic energy left [J]", result.stage_summary("slide")["energy"]["kinetic"], 0.0)
