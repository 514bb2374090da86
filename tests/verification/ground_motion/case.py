"""Records that shake the ground: Newmark's block on a frictional joint, files of PEER and tables, scaling, the baseline."""

from pathlib import Path

import numpy as np
from driver import changed
from quoin_tools.assess import newmark
from quoin_tools.base import record
from quoin_tools.mesh.meshing import join, rectangle, renamed, vertex_at
from quoin_tools.mesh.stacks import block_on_plane

WHAT = "ground motion: Newmark's sliding block (VS08, VS09), AT2 and tables, scale, pga, baseline, the end of a record"
SOURCE = "slip of a rigid-plastic block on a record that is linear between rows, exact; the ground at its end: v = u = 0"
BY = "exact integration of Newmark's block by this project"

G = 9.81
FRICTIONS = (0.10, 0.15, 0.20, 0.25)
HEIGHT = 0.5
STIFFNESS = 2400 * HEIGHT * (2 * np.pi * 150) ** 2  # [Pa/m] a block slides at 150 Hz on its joint
SCENE = {
    "strain": "small",
    "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "history_every": 10},
    "materials": {"table": {"density": 2400}} | {f"block_{i}": {"density": 2400} for i in range(4)},
    "joints": {"default": {"k_n": STIFFNESS, "k_s": STIFFNESS, "friction": 45}}
    | {f"block_{i}+table": {"friction": float(np.degrees(np.arctan(mu)))} for i, mu in enumerate(FRICTIONS)},
    "motions": {"quake": {"file": "quake.csv", "direction": "x"}},
    "supports": {"table": {"fix": "xy", "motion": "quake"}},
    "loads": {"weight": {"type": "self_weight", "groups": [f"block_{i}" for i in range(4)]}},
    "stages": {"rest": {"loads": ["weight"]},
               "shake": {"type": "dynamic", "loads": ["weight"], "duration": 12.5, "dt_factor": 0.15}},
}  # fmt: skip


def quake(T=12.0, dt=0.01, close=True):
    """The synthetic record: five sines in an envelope, the baseline closed for rows that are joined by lines."""
    t = np.round(np.arange(0, T + dt / 2, dt), 10)
    envelope = np.sin(np.pi * t / T) ** 2
    sines = zip((0.8, 1.7, 2.9, 4.3, 6.1), (0.10, 0.14, 0.12, 0.08, 0.05), (0.0, 1.1, 2.3, 0.7, 4.0))
    a = envelope * G * sum(A * np.sin(2 * np.pi * f * t + p) for f, A, p in sines)
    if close:
        ends = np.array([ends_of(t, x) for x in (envelope, envelope * t, a)])
        c = np.linalg.solve(ends[:2].T, ends[2])
        a = a - envelope * (c[0] + c[1] * t)
    return t, a


def ends_of(t, a):
    shaken = record.Record("", t, a)
    return shaken.v[-1], shaken.u[-1]


def text(t, a):
    return "".join(f"{x:.17g}, {y:.17g}\n" for x, y in zip(t, a))


def blocks_on_table():
    table = rectangle(-1, -1, 24, 1, group="table", rigid=True)
    blocks = [rectangle(6 * i, 0, 4, HEIGHT, group=f"block_{i}", rigid=True) for i in range(4)]
    return join([renamed(table, {}, {"ground": "bottom_left"})] +
                [renamed(block, {}, {f"at_{i}": "bottom_left"}) for i, block in enumerate(blocks)])


def shaken(case, files, *changes, ranks=1):
    """A run with these files beside its scene."""
    folder = case.prepare(blocks_on_table(), changed(SCENE, *changes))
    for name, content in files.items():
        (folder / name).write_text(content)
    return case.again(folder, ranks=ranks)


def slips(result):
    """Times [s] and slip of each block [m] over them."""
    rows = result.history["stage"] == "shake"
    column = {name: values[rows] for name, values in result.history.items()}
    slip = np.array([column[f"at_{i}_ux_m"] - column["ground_ux_m"] for i in range(4)])
    return column["time_s"], slip - slip[:, :1]


def ground(result):
    """What the ground does at the end of the stage [m], and what the run says of its motion along x."""
    return result.probe("shake", "ground"), result.stage_summary("shake")["motion"]["table_x"]


QUICK = ("stages.shake.dt_factor", 0.9)  # where only the ground counts


LONG = ("synthetic",)  # parts that the short form leaves out


def run(case):
    half_sine(case)
    frames(case)
    synthetic(case)
    inclined(case)
    formats(case)
    scales(case)
    baselines(case)
    two_records(case)


def half_sine(case):
    """VS08; the ground goes on at its last velocity while the block slows down."""
    t = np.linspace(0, 0.4, 2001)
    t, a = np.append(t, [0.4, 4.0]), np.append(0.5 * G * np.sin(np.pi * t / 0.4), [0.0, 0.0])
    exact = newmark.slide(record.Record("", t, a), newmark.yielding(0.2))[0]
    case.check("VS08, half a sine of 0.5 g, mu = 0.2: slip by the tool [m]", -exact.final, 0.17980, absolute=5e-6)
    case.check("... starts, stops [s]", exact.ends(), [0.05240, 0.66244], absolute=5e-6)
    case.check("... at 0.4 s: slip [m], velocity [m/s]", [-exact.slip[2000], -exact.velocity[2000]], [0.11224, 0.51491], absolute=5e-6)
    result = shaken(case, {"quake.csv": text(t, a)}, ("stages.shake.duration", 1.6), ("relaxation.history_every", 1))
    time, slip = slips(result)
    case.check("... slip of the joint [m]", -slip[2, -1], 0.17980, relative=0.01)
    late = (time > 0.45) & (time < 0.6)  # it slows down by mu g until it stops
    case.check("... stops at [s]", time[late] + np.sqrt(2 * (slip[2, late] - slip[2, -1]) / (0.2 * G)), 0.66244, relative=0.002)


def frames(case):
    """Damping by mass against the ground, or against what rests: the block of VS08, and what is carried along."""
    t = np.linspace(0, 0.4, 401)
    files = {"quake.csv": text(np.append(t, [0.4, 4.0]), np.append(0.5 * G * np.sin(np.pi * t / 0.4), [0.0, 0.0]))}
    for frame, slip in (("ground", 0.126), ("absolute", 0.494)):
        result = shaken(case, files, ("stages.shake", SCENE["stages"]["shake"] | {"duration": 2.5, "alpha": 1.5, "frame": frame}))
        energy = result.stage_summary("shake")["energy"]
        case.check(f"VS08 with alpha 1.5, frame {frame}: slip [m]", abs(slips(result)[1][2]).max(), slip, relative=0.02)
        case.check("... energy balance over the work of the support", energy["balance"] / abs(energy["supports"]), 0.0, absolute=1e-3)
    ramp = {"quake.csv": "0, 1\n1, 1\n1, 0\n4, 0\n"}  # up to 1 m/s, and on
    keys = ("stages.shake", {"type": "dynamic", "loads": ["weight"], "duration": 3.9, "alpha": 2, "dt_factor": 0.15})
    carried = shaken(case, ramp, keys, ("joints", {"default": {"law": "elastic", "k_n": STIFFNESS, "k_s": STIFFNESS}}))
    lag = shaken(case, ramp, keys, ("stages.shake.frame", "absolute"), ("joints", {"default": {"law": "elastic", "k_n": STIFFNESS, "k_s": STIFFNESS}}))
    behind = [slips(run)[1][2, -1] for run in (carried, lag)]
    case.check("blocks carried at 1 m/s with alpha 2, frame ground: they lag by [m]", behind[0], 0.0, absolute=2e-8)
    case.check("... absolute, by alpha m v / k [m]", behind[1], -2 * 2400 * HEIGHT / STIFFNESS, relative=0.01)


def synthetic(case):
    """VS09: four blocks on one ground."""
    t, a = quake()
    shaking = record.Record("", t, a)
    case.check("VS09: PGA [m/s2], PGV [m/s], PGD [m], Arias intensity [m/s]",
               [shaking.pga, shaking.pgv, shaking.pgd, shaking.arias()[-1]], [4.3069, 0.3254, 0.0582, 1.8341], relative=5e-4)
    exact = [newmark.slide(shaking, newmark.yielding(mu)) for mu in FRICTIONS]
    case.check("... mu 0.10, 0.15, 0.20, 0.25: final slip by the tool [m]", [slip.final for slip, _ in exact],
               [-0.06941, -0.03451, -0.01883, -0.01068], absolute=1e-5)
    case.check("... largest each way, mu 0.10 [m]", exact[0][1], [-0.09556, 0.00422], absolute=1e-5)
    case.check("... last motion [s]", [slip.ends()[1] for slip, _ in exact], [9.757, 8.987, 8.098, 7.467], absolute=1e-3)
    result = shaken(case, {"quake.csv": text(t, a)})
    _, slip = slips(result)
    case.check("... final slip of the joints [m]", slip[:, -1], [-0.06941, -0.03451, -0.01883, -0.01068], relative=0.02)
    case.check("... largest each way, mu 0.10 [m]", [slip[0].min(), slip[0].max()], [-0.09556, 0.00422], absolute=1e-3)
    place, told = ground(result)
    case.check("... the ground ends at rest, where it was: [m/s], [m], said and moved",
               [told["end_velocity"], told["end_displacement"], *place], [0, 0, 0, 0], absolute=1e-14)
    warnings = [line for line in result.stdout.splitlines() if "warning" in line]
    case.check("... warnings: of joints that nothing damps, none of the record", ["nothing damps" in line for line in warnings], [True])
    energy = result.stage_summary("shake")["energy"]
    case.check("... energy balance over the work of the support", energy["balance"] / energy["supports"], 0.0, absolute=1e-10)
    for factor in (0.07, 0.4):
        other = shaken(case, {"quake.csv": text(t, a)}, ("stages.shake.dt_factor", factor))
        case.check(f"... dt_factor {factor}: final slip [m]", slips(other)[1][:, -1], slip[:, -1], relative=0.02)
        case.check("... and the ground [m]", ground(other)[0], [0, 0], absolute=1e-14)
    sums = [shaken(case, {"quake.csv": text(t, a)}, QUICK, ("stages.shake.duration", 5.0), ranks=n).stage_summary("shake")["checksum"] for n in case.ranks(1, 2, 3, 4)]
    case.check("... same bits on 1, 2, 3 and 4 ranks", len(set(sums)), 1)


def inclined(case):
    """VS09 on a plane of 10 degrees that falls to +x, shaken along x."""
    t, a = quake()
    mesh = block_on_plane(slope_degrees=10, plane_length=3.0, start=1.0)
    mesh.points["origin"] = vertex_at(mesh, 0, 0, "base")
    stiffness = 2400 * 0.2 * (2 * np.pi * 150) ** 2
    scene = changed(SCENE, ("materials", {"block": {"density": 2400}, "base": {"density": 2400}}), ("loads.weight.groups", ["block"]),
                    ("supports", {"base": {"fix": "xy", "motion": "quake"}}))  # fmt: skip
    for phi, expected in ((20, 0.02810), (25, 0.00374)):
        exact, _ = newmark.slide(record.Record("", t, a), newmark.incline(phi, 10))
        case.check(f"VS09, plane of 10 degrees, phi {phi}: slip down it by the tool [m]", exact.final, expected, absolute=1e-5)
        folder = case.prepare(mesh, changed(scene, ("joints", {"default": {"k_n": stiffness, "k_s": stiffness, "friction": phi}})))
        (folder / "quake.csv").write_text(text(t, a))
        result = case.again(folder)
        moved = [result.probe("shake", x) - result.probe("rest", x) for x in ("bottom_left", "origin")]
        case.check("... slip of the joint [m]", np.hypot(*(moved[0] - moved[1])), expected, relative=0.03)
    case.check("... stops at, phi 20 [s]", newmark.slide(record.Record("", t, a), newmark.incline(20, 10))[0].ends()[1], 8.115, absolute=1e-3)


def formats(case):
    """A file of PEER, a table with blanks and one of three columns hold the same numbers."""
    t = 0.02 * np.arange(151)
    values = [f"{x:.6E}" for x in 0.3 * np.sin(np.pi * t / 3) ** 2 * np.sin(2 * np.pi * t)]
    a = np.array([float(x) for x in values]) * record.STANDARD
    peer = "PEER NGA STRONG MOTION DATABASE RECORD\nSynthetic, 1/1/2026, Here, 090\nACCELERATION TIME SERIES IN UNITS OF G\n"
    body = "".join("  " + "  ".join(values[i:i + 5]) + "\n" for i in range(0, len(values), 5))
    short = (("stages.shake.duration", 3.0),)
    runs = {"table of two columns": ({"quake.csv": text(t, a)}, ()),
            "AT2": ({"quake.AT2": peer + "NPTS=    151, DT=   .0200 SEC,\n" + body}, (("motions.quake.file", "quake.AT2"),)),
            "AT2, its step in milliseconds": ({"quake.AT2": peer + "NPTS=    151, DT=   20.0 MSEC,\n" + body}, (("motions.quake.file", "quake.AT2"),)),
            "AT2 with an older head": ({"quake.at2": peer + "    151    .0200    NPTS, DT\n" + body}, (("motions.quake.file", "quake.at2"),)),
            "blanks": ({"quake.txt": "# t a\n" + text(t, a).replace(",", "\t")}, (("motions.quake.file", "quake.txt"),)),
            "three columns": ({"quake.csv": "".join(f"{x:.17g}, {y:.17g}, 0\n" for x, y in zip(t, a))}, (("motions.quake.direction", "xy"),)),
            "no motions": ({"quake.csv": "".join(f"{x:.17g}, {y:.17g}, 0\n" for x, y in zip(t, a))},
                           (("motions", {}), ("supports.table.motion", "quake.csv"), ("supports.table.quantity", "acceleration")))}  # fmt: skip
    sums = {name: shaken(case, files, *short, *changes).stage_summary("shake")["checksum"] for name, (files, changes) in runs.items()}
    for name in list(sums)[1:]:
        case.check(f"same record, {name}: same bits", sums[name], sums["table of two columns"])
    for head, told in (("DT=   20.0 MSEC,", False), ("DT=   20.0,", True)):  # without a unit it is 20 s
        out = shaken(case, {"quake.AT2": peer + "NPTS=    151, " + head + "\n" + body}, ("stages.shake.duration", 0.1), ("motions.quake.file", "quake.AT2")).stdout
        case.check(f"... a step '{head}': its speed is reported to be none of a ground", "expected at most 80 m/s2 and 8 m/s of a shaken ground" in out, told)
    speeds = 100 * a  # [cm/s], which a VT2 file has
    fast = f"A\nVELOCITY TIME SERIES IN UNITS OF CM/S\nNPTS= {len(t)}, DT= .02\n" + "\n".join(f"{x:.17g}" for x in speeds)
    files = {"quake.VT2": fast, "quake.csv": text(t, 0.01 * speeds)}
    sums = [shaken(case, files, *short, ("motions.quake", {"file": name, "direction": "x", "quantity": "velocity"})).stage_summary("shake")["checksum"]
            for name in files]  # fmt: skip
    case.check("velocities, VT2 and a table: same bits", *sums)


def scales(case):
    t, a = quake()
    files = {"quake.csv": text(t, a)}
    half = ground(shaken(case, files, QUICK, ("motions.quake.scale", -0.5)))[1]
    case.check("scale -0.5: PGA [m/s2], PGV [m/s]", [half["largest_acceleration"], half["largest_velocity"]], [4.30689 / 2, 0.325452 / 2], relative=1e-5)
    scaled = shaken(case, files, QUICK, ("motions.quake.pga", 2.5))
    case.check("pga: 2.5: PGA [m/s2]", ground(scaled)[1]["largest_acceleration"], 2.5, relative=1e-14)
    again = shaken(case, {"quake.csv": Path(scaled.folder, "motion_quake.csv").read_text()}, QUICK)
    case.check("... its record as written, run again: same bits", again.stage_summary("shake")["checksum"], scaled.stage_summary("shake")["checksum"])


def baselines(case):
    """The synthetic record before it was closed; and closed, but with two decimals, or with an offset."""
    t, raw = quake(close=False)
    _, closed = quake()
    cases = {"not closed": (raw, [-2.1e-3, -14e-3]), "two decimals": (np.round(closed, 2), [-1.1e-3, -1.7e-3]),
             "offset of 0.001 g": (closed + 0.001 * G, [0.11772, 0.70632])}  # fmt: skip
    for name, (a, ends) in cases.items():
        result = shaken(case, {"quake.csv": text(t, a)}, QUICK)
        place, told = ground(result)
        case.check(f"{name}: ends with [m/s], moved by [m]", [told["end_velocity"], told["end_displacement"]], ends, relative=0.05)
        case.check("... and so does the ground [m]", place[0], told["end_displacement"], absolute=1e-12)
        case.check("... warned of where it is more than 1 % of PGV", "the support stops there at once" in result.stdout, abs(ends[0]) > 0.00325)
        case.check("... and that they may be velocities, above 0.05 m/s", "say quantity: velocity" in result.stdout, ends[0] > 0.05)
        result = shaken(case, {"quake.csv": text(t, a)}, QUICK, ("motions.quake.baseline", "linear"))
        place, told = ground(result)
        case.check("... baseline: linear: ends with [m/s], moved by [m], the ground", [told["end_velocity"], told["end_displacement"], place[0]],
                   [0, 0, 0], absolute=1e-13)  # fmt: skip
        if name == "not closed":
            written = np.loadtxt(f"{result.folder}/motion_quake.csv", delimiter=",")
            case.check("... is what the formula closes [m/s2]", written[:, 1], closed, absolute=1e-12)


def two_records(case):
    """A horizontal and a vertical file, with steps of their own, move the ground together."""
    t, a = quake()
    rows = np.arange(0, 12.0005, 0.016)
    v = 0.6 * np.interp(rows, t, a)
    peer = f"A\nB\nACCELERATION TIME SERIES IN UNITS OF CM/S/S\nNPTS= {len(rows)}, DT= .016 SEC\n"
    files = {"quake.csv": text(t, a), "up.AT2": peer + "\n".join(f"{100 * x:.15e}" for x in v)}
    motions = {"quake": SCENE["motions"]["quake"], "up": {"file": "up.AT2", "direction": "y", "baseline": "linear", "scale": 0.5}}
    result = shaken(case, files, QUICK, ("motions", motions), ("supports.table.motion", ["quake", "up"]), ("relaxation.history_every", 1))
    column = {name: values[result.history["stage"] == "shake"] for name, values in result.history.items()}
    x = record.Record("", t, a)
    y = record.Record("", *np.loadtxt(f"{result.folder}/motion_up.csv", delimiter=",").T)
    for name, exact in (("x", x), ("y", y)):
        times = np.minimum(column["time_s"], exact.t[-1])
        i = np.clip(np.searchsorted(exact.t, times, side="right") - 1, 0, len(exact.t) - 2)
        h, slope = times - exact.t[i], np.diff(exact.a)[i] / np.diff(exact.t)[i]
        u = exact.u[i] + h * (exact.v[i] + h * (exact.a[i] / 2 + h * slope / 6))
        case.check(f"two files: the ground along {name} over time [m]", column[f"ground_u{name}_m"], u, absolute=5e-10)
