"""A block pushes a wedge up a plane (V23): the force at which it moves."""

import numpy as np
from driver import changed
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed

WHAT = "limit thrust of a block that pushes a wedge up a plane of 25 degrees (V23)"
SOURCE = "H = 1000 tan 30 + 300 tan (25 + 30) = 1005.8 kN"
BY = "by hand"

W_BLOCK, W_WEDGE, PHI, SLOPE = 1000e3, 300e3, 30.0, 25.0
SCENE = {
    "relaxation": {"ramp": 20000},
    "materials": {"block": {"density": 0}, "wedge": {"density": 0}, "base": {"density": 0}},
    "joints": {"default": {"k_n": 10e9, "k_s": 10e9, "friction": PHI},
               "block+wedge": {"friction": 0}},
    "supports": {"base": {"fix": "xy"}},
}


def tan(degrees):
    return np.tan(np.radians(degrees))


def two_on_base():
    """The block on the flat from x = -2 to 0; the wedge on the slope from 0 to 2, its left side vertical against the block."""
    rise = 2 * tan(SLOPE)
    flat = rectangle(-3, -1, 3, 1, group="base", rigid=True)
    slope = quad_patch((0, -1), (3, -1), (3, 3 * tan(SLOPE)), (0, 0), 1, 1, "base", True)
    block = rectangle(-2, 0, 2, 1.5, group="block", rigid=True)
    wedge = quad_patch((0, 0), (2, rise), (2, rise + 0.2), (0, 1.5), 1, 1, "wedge", True)
    return join([renamed(flat, {}), renamed(slope, {}), renamed(block, {}, {f"b_{c}": c for c in ("bottom_left", "top_left", "top_right")}),
                 renamed(wedge, {}, {f"w_{c}": c for c in ("top_left", "top_right")})])


def run(case):
    limit = W_BLOCK * tan(PHI) + W_WEDGE * tan(SLOPE + PHI)
    for model in ("tptm", "pt"):
        for part, verdict in ((0.98, "converged"), (1.02, "collapsed")):
            loads = {"block_l": {"type": "point_force", "point": "b_top_left", "value": [0, -W_BLOCK / 2]},
                     "block_r": {"type": "point_force", "point": "b_top_right", "value": [0, -W_BLOCK / 2]},
                     "wedge": {"type": "point_force", "point": "w_top_left", "value": [0, -W_WEDGE / 2]},
                     "wedge_r": {"type": "point_force", "point": "w_top_right", "value": [0, -W_WEDGE / 2]},
                     "push": {"type": "point_force", "point": "b_bottom_left", "value": [part * limit, 0]}}
            weight = [name for name in loads if name != "push"]
            stages = [{"weight": {"loads": weight}}, {"push": {"loads": list(loads)}}]
            result = case.run(two_on_base(), changed(SCENE, ("loads", loads), ("stages", stages), ("joints.default.stress_model", model)))
            case.check(f"{model}, thrust {part:g} of 1005.8 kN", result.stage(result.stages[-1]).verdict, verdict)
