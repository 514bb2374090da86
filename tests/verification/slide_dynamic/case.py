"""A rigid block that slides in time: down a plane of 30 degrees (V05), and on a base that is shaken (Newmark's block, V12)."""

import numpy as np
from driver import changed
from quoin_tools.mesh.meshing import vertex_at
from quoin_tools.mesh.stacks import block_on_plane

WHAT = "a block slides in time: down an incline (V05), on a base that is shaken (V12)"
SOURCE = "a = g (sin a - cos a tan phi); Newmark: s = (A - a_c) A t0^2 / 2 a_c, a_c = g cos a (tan phi - tan a)"
BY = "closed form of Newmark, by hand"

G = 9.81
SCENE = {
    "contact": {"connectivity": "variable", "tolerance": 0.005},
    "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9},
    "materials": {"block": {"density": 2400}, "base": {"density": 2400}},
    "joints": {"default": {"k_n": 10e9, "k_s": 10e9, "friction": 45}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
}


def tan(degrees):
    return np.tan(np.radians(degrees))


def on_plane(slope, length):
    mesh = block_on_plane(slope_degrees=slope, plane_length=length, start=1.0)
    mesh.points["origin"] = vertex_at(mesh, 0, 0, "base")
    return mesh


def run(case):
    incline(case)
    one_pulse(case)
    square_cycle(case)
    shaken_incline(case)


def incline(case):
    alpha, phi, t, mass = np.pi / 6, 20.0, 0.5, 2400 * 0.2
    stages = [{"rest": {"loads": ["weight"]}},
              {"slide": {"type": "dynamic", "loads": ["weight"], "duration": t, "joints": {"default": {"friction": phi}}}}]
    result = case.run(on_plane(30, 3.0), changed(SCENE, ("stages", stages)))
    a = G * (np.sin(alpha) - np.cos(alpha) * tan(phi))
    moved = np.array([result.probe("slide", c) - result.probe("rest", c) for c in ("bottom_left", "top_right")])
    case.check("V05, phi = 20: slid down the plane in 0.5 s, both corners [m]", moved @ [np.cos(alpha), -np.sin(alpha)],
               0.5 * a * t**2, relative=0.001)
    energy = result.stage_summary("slide")["energy"]
    case.check("... kinetic energy [J]", energy["kinetic"], 0.5 * mass * (a * t)**2, relative=0.001)
    case.check("... lost in friction: N tan(phi) s [J]", energy["friction"],
               mass * G * np.cos(alpha) * tan(phi) * 0.5 * a * t**2, relative=0.005)
    case.check("... energy balance over the work of the weight", energy["balance"] / energy["outside"], 0.0, absolute=1e-4)


def shaken(case, slope, phi, rows, duration, ranks=1):
    """Slip of the block down the plane over time, of a base with accelerations (t, along the plane, up it)."""
    angle = np.radians(slope)
    along = np.array([-np.cos(angle), np.sin(angle)])
    stages = [{"rest": {"loads": ["weight"]}},
              {"shake": {"type": "dynamic", "loads": ["weight"], "duration": duration, "dt_factor": 0.1}}]
    scene = changed(SCENE, ("stages", stages), ("joints.default.friction", phi),
                    ("supports.base", {"fix": "xy", "motion": "motion.csv", "quantity": "acceleration"}))
    folder = case.prepare(on_plane(slope, 6.0), scene)
    (folder / "motion.csv").write_text("".join(f"{t:.9f}, {a * along[0]:.12g}, {a * along[1]:.12g}\n" for t, a in rows))
    result = case.again(folder, ranks=ranks)
    history = {name: column[result.history["stage"] == "shake"] for name, column in result.history.items()}
    slip = [(history[f"bottom_left_u{x}_m"] - history[f"origin_u{x}_m"]) for x in "xy"]
    time = history["time_s"]
    return result, time, -(along[0] * (slip[0] - slip[0][0]) + along[1] * (slip[1] - slip[1][0]))


def pulse(a, t0, end):
    return [(0.0, a), (t0, a), (t0 + 1e-9, 0.0), (end, 0.0)]


def one_pulse(case):
    A, a_c, t0 = 0.5 * G, 0.2 * G, 0.5
    results = [shaken(case, 0, np.degrees(np.arctan(0.2)), pulse(-A, t0, 9.0), 1.5, ranks) for ranks in (1, 2)]
    result, t, s = results[0]
    final = -(A - a_c) * A * t0**2 / (2 * a_c)
    case.check("V12, pulse of 0.5 g for 0.5 s, mu = 0.2: slip [m]", s[-1], final, relative=0.001)
    late = (t > 0.6) & (t < 1.2)  # it slows down by a_c until it stops
    case.check("... stops at [s]", t[late] + np.sqrt(2 * (s[late] - s[-1]) / a_c), A * t0 / a_c, relative=0.001)
    energy = result.stage_summary("shake")["energy"]
    mass = 2400 * 0.2
    case.check("... lost in friction: m a_c s [J]", energy["friction"], -mass * a_c * final, relative=0.005)
    case.check("... energy balance over the work of the support", energy["balance"] / energy["supports"], 0.0, absolute=1e-3)
    case.check("... same bits on 2 ranks", results[1][0].stage_summary("shake")["checksum"],
               result.stage_summary("shake")["checksum"])


def square_cycle(case):
    A, t0 = 0.5 * G, 0.5
    rows = [(0.0, A), (t0, A), (t0 + 1e-9, -A), (2 * t0, -A), (2 * t0 + 1e-9, 0.0), (9.0, 0.0)]
    _, t, s = shaken(case, 0, np.degrees(np.arctan(0.2)), rows, 1.6)
    case.check("V12, 0.5 g for 0.5 s and back: largest and final slip [m]", [s.max(), s[-1]], [0.52554, 0.22523], relative=0.005)


def shaken_incline(case):
    phi, slope, A, t0 = 30.0, 10.0, 0.6 * G, 0.3
    a_c = G * np.cos(np.radians(slope)) * (tan(phi) - tan(slope))
    _, t, s = shaken(case, slope, phi, pulse(A, t0, 9.0), 0.7)
    case.check("V12, plane of 10 degrees, phi = 30, 0.6 g for 0.3 s: slip down the plane [m]", s[-1] - s[0],
               (A - a_c) * A * t0**2 / (2 * a_c), relative=0.005)
    late = (t > 0.32) & (t < 0.43)
    case.check("... stops at [s]", t[late] + np.sqrt(2 * (s[-1] - s[late]) / a_c), A * t0 / a_c, relative=0.005)
