"""Dynamic relaxation of a chain of n springs (V11): rigid blocks on top of each other that move up and down only."""

import numpy as np
from driver import changed
from quoin_tools.mesh.stacks import column

WHAT = "relaxation of a chain of springs: cycles near those of the optimum damping, no overshoot (V11)"
SOURCE = ("lowest mode w0 dt = 2 safety sin(pi / 4n) of a chain fixed below; the optimum damping 2 w0 needs about "
          "1.15 ln(1/tol) / (w0 dt) cycles; cycles of the Rayleigh quotient by an independent script")
BY = "by hand; independent script of this project"

SCENE = {
    "gravity": 1.0,
    "materials": {"block": {"density": 1.0}, "base": {"density": 0}},
    "relaxation": {"check_every": 1, "history_every": 1, "tolerance": 1e-6, "velocity_tolerance": 1},
    "joints": {"default": {"law": "elastic", "k_n": 1.0, "k_s": 1.0}},
    "supports": {"base": {"fix": "xy"}, "block": {"fix": "x"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
    "stages": [{"weight": {"loads": ["weight"], "ramp": 1}}],
}
RAYLEIGH = {(20, 0.9): 240, (100, 0.9): 1192, (20, 0.5): 430, (100, 0.5): 2144}  # cycles until |r| < 1e-6 |f|


def run(case):
    """A load 1/n on each spring of 1 N/m, all at once: u = (n + 1) / 2 at the top."""
    for (n, safety), cycles in RAYLEIGH.items():
        result = case.run(column(n), changed(SCENE, ("materials.block.density", 1.0 / n), ("relaxation.safety", safety)))
        ours, top = result.stage_summary("weight")["cycles"], -0.5 * (n + 1)
        case.check(f"{n} springs, safety {safety:g}: cycles, against the script", ours, cycles, relative=0.05)
        case.check("... over those of the optimum", ours / (1.15 * np.log(1e6) / (2 * safety * np.sin(np.pi / 4 / n))), 1.0,
                   absolute=0.15)
        case.check("... displacement of the top over the exact one", result.probe("weight", "top_left")[1] / top, 1.0, absolute=1e-4)
        case.check("... its largest on the way", result.history["top_left_uy_m"].min() / top, 1.0, absolute=2e-4)
