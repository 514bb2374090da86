"""Undamped and damped vibration of a rigid block on a joint by the central difference scheme (V08).

A static stage without damping is that vibration: after a sudden load the block swings about its equilibrium. Scaled masses make
the frequency: r = w dt/2 is proportional to the safety of the step."""

import numpy as np
from driver import changed
from quoin_tools.mesh.stacks import one_contact

WHAT = "one dof swings: period, constant amplitude, decay with damping (V08)"
SOURCE = "T_num/T = r / asin(r), r = w dt/2; damped: u+ (1 + a/2) = (2 - 4 r^2) u - (1 - a/2) u-, a = alpha dt"
BY = "closed form by hand"

SCENE = {
    "relaxation": {"damping": "none", "tolerance": 1e-15, "velocity_tolerance": 1e-15, "ramp": 0, "check_every": 1,
                   "history_every": 1, "max_cycles": 10000},
    "materials": {"block": {"density": 1000}, "base": {"density": 0}},
    "joints": {"default": {"law": "elastic", "k_n": 10e9, "k_s": 3e9}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"push": {"type": "traction", "faces": "top", "value": [0, -1e4]}},
    "stages": [{"swing": {"loads": ["push"]}}],
}
STATIC = -1e4 / 10e9


def swing(result):
    """Displacement over its static value, less 1."""
    return result.history["top_left_uy_m"] / STATIC - 1


def recurrence(u):
    """Least squares c, d of u+ = c u - d u-."""
    return np.linalg.lstsq(np.column_stack([u[1:-1], -u[:-2]]), u[2:], rcond=None)[0]


def run(case):
    mesh, safety = one_contact(), np.array([0.1, 0.2, 0.5, 0.8, 0.9, 1.0])
    short = changed(SCENE, ("relaxation.max_cycles", 300))
    results = case.run_all([(mesh, changed(short, ("relaxation.safety", s))) for s in safety])
    angle = np.array([np.arccos(recurrence(swing(result))[0] / 2) for result in results])  # of a cycle: 2 pi dt/T_num
    r = np.sin(angle[0] / 2) / safety[0] * safety
    for i in range(1, len(safety)):
        case.check(f"T_num/T at r = {r[i]:.4f}", 2 * r[i] / angle[i], r[i] / np.arcsin(r[i]), relative=1e-8)

    u = swing(case.run(mesh, SCENE))
    cosine = recurrence(u)[0] / 2
    square = u[1:]**2 - 2 * cosine * u[1:] * u[:-1] + u[:-1]**2  # constant along the swing; history.csv has 10 digits
    amplitude = np.sqrt([part.mean() for part in np.array_split(square, 10)])
    case.check("amplitude of each 1000 of 10000 cycles / first", amplitude / amplitude[0], 1.0, absolute=1e-10)

    a = 0.1  # k A^2/2 (1 - a) reaches the middle, k A'^2/2 (1 + a) takes it up
    local = changed(short, ("relaxation.damping", "local"), ("relaxation.local", a), ("relaxation.safety", 0.05), ("relaxation.max_cycles", 1000))
    u = swing(case.run(mesh, local))
    ends = np.abs(u[1:-1][(u[1:-1] - u[:-2]) * (u[2:] - u[1:-1]) < 0])
    case.check("local damping a = 0.1: each swing over that before: sqrt((1 - a)/(1 + a))", ends[1:] / ends[:-1],
               np.sqrt((1 - a) / (1 + a)), relative=2e-3)  # fmt: skip

    for alpha_dt, s in ((0.02, 0.5), (0.2, 1.0)):
        damped = changed(short, ("relaxation.damping", "fixed"), ("relaxation.alpha_dt", alpha_dt), ("relaxation.safety", s))
        square = r[list(safety).index(s)]**2
        expected = np.array([2 - 4 * square, 1 - alpha_dt / 2]) / (1 + alpha_dt / 2)
        case.check(f"alpha dt = {alpha_dt}, safety {s}: recurrence", recurrence(swing(case.run(mesh, damped))[:100]), expected,
                   relative=1e-8)
