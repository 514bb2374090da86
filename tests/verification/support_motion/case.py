"""Supports that follow a file: linear between its rows, steps where a time stands twice, a line of names; and stages without loads."""

import numpy as np
from driver import changed
from quoin_tools.mesh.meshing import join, rectangle, renamed

WHAT = "supports that move in time: displacement of a file linear between its rows, exact; stages without loads"
SOURCE = "a from 0 to 1 m/s2 in 4 s: v = t^2/8, u = t^3/24; v linear between rows: u = sum of (v_i + v_i+1)/2 (t_i+1 - t_i)"
BY = "by hand"

SCENE = {
    "materials": {"table": {"density": 1000}, "block": {"density": 2400}},
    "joints": {"default": {"law": "elastic", "k_n": 1e6, "k_s": 1e6}},
    "supports": {"table": {"fix": "xy", "motion": "motion.csv", "quantity": "acceleration"}},
    "relaxation": {"history_every": 1},
    "stages": [{"move": {"type": "dynamic", "loads": [], "duration": 4.0, "dt_factor": 0.2, "frames": 3}}],
}


def block_on_table():
    return join([renamed(rectangle(0, -1, 1, 1, group="table", rigid=True), {}, {"on_table": "bottom_left"}),
                 renamed(rectangle(0, 0, 1, 1, group="block", rigid=True), {}, {"on_block": "bottom_left"})])


def moved(case, text, *changes, ranks=1):
    folder = case.prepare(block_on_table(), changed(SCENE, *changes))
    (folder / "motion.csv").write_text(text)
    return case.again(folder, ranks=ranks)


def run(case):
    two_rows(case)
    steps(case)
    velocities(case)
    no_loads(case)


def two_rows(case):
    """Two rows are enough for a ramp of acceleration."""
    result = moved(case, "0, 0, 0\n4, 1, -0.5\n")
    case.check("rows 0,0,0 and 4,1,-0.5: moved [m]", result.probe("move", "on_table"), [64 / 24, -32 / 24], relative=1e-12)
    t, u = result.history["time_s"], result.history["on_table_ux_m"]
    case.check("... on the way [m]", u, t**3 / 24, absolute=5e-9)  # history.csv has ten digits
    case.check("... the block on a soft joint went with it [m]", result.probe("move", "on_block")[0], 64 / 24, absolute=0.01)
    two = moved(case, "0, 0, 0\n4, 1, -0.5\n", ranks=2)
    case.check("... same bits on 2 ranks", two.stage_summary("move")["checksum"], result.stage_summary("move")["checksum"])


def steps(case):
    """1 m/s2 for a second, -1 for one, at rest: two times stand twice; names in the first line, as spreadsheets write them."""
    rows = "0, 1, 0\n1, 1, 0\n1, -1, 0\n2, -1, 0\n2, 0, 0\n3, 0, 0\n"
    for what, head in (("names", "t, x, y\n"), ("a comment, names in quotes", '# made by hand\n"time [s]", "x", "y"\n'),
                       ("UTF-8 with its mark", "\ufefft;x;y\n")):
        result = moved(case, head + rows)
        case.check(f"steps of acceleration, {what}: moved [m]", result.probe("move", "on_table"), [1.0, 0.0], absolute=1e-12)
    t, u = result.history["time_s"], result.history["on_table_ux_m"]
    exact = np.where(t < 1, t**2 / 2, np.where(t < 2, 1 - (2 - np.minimum(t, 2))**2 / 2, 1))
    case.check("... on the way [m]", u, exact, absolute=1e-9)


def velocities(case):
    """Rows closer than steps, and a step of velocity: nothing of them is lost."""
    t = np.linspace(0, 4, 40001)
    v = np.where(t < 2, np.sin(300 * t)**2, 0)
    text = "".join(f"{a:.17g}, {b:.17g}, 0\n" for a, b in zip(t, v))
    result = moved(case, text, ("supports.table.quantity", "velocity"))
    case.check("40 001 rows, several a step: moved [m]", result.probe("move", "on_table")[0], np.sum(v[1:] + v[:-1]) * 5e-5, relative=1e-9)
    result = moved(case, "0, 2, 0\n1.2345, 2, 0\n1.2345, 0, 0\n5, 0, 0\n", ("supports.table.quantity", "velocity"))
    case.check("velocity that stops at a time within a step: moved [m]", result.probe("move", "on_table")[0], 2.469, relative=1e-12)


def no_loads(case):
    """What swings needs no load, nor does what is relieved; a first static stage does."""
    stages = [{"pressed": {"loads": ["press"]}}, {"relieved": {"loads": []}}]
    scene = changed(SCENE, ("supports.table", {"fix": "xy"}), ("loads", {"press": {"type": "self_weight"}}), ("stages", stages))
    result = case.run(block_on_table(), scene)
    case.check("relieved of its weight: settled before and after [m]",
               [result.probe(name, "on_block")[1] for name in ("pressed", "relieved")], [-2400 * 9.81 / 1e6, 0.0], absolute=1e-7)
    free = changed(SCENE, ("supports.table", {"fix": "xy"}), ("materials.block.velocity", [0.0, 0.1]),
                   ("stages", [{"swing": {"type": "dynamic", "loads": [], "duration": 4.0}}]))
    swing = case.run(block_on_table(), free)
    case.check("thrown off, nothing else acts: amplitude v sqrt(m/k) [m]", swing.history["on_block_uy_m"].max(),
               0.1 * np.sqrt(2400 / 1e6), relative=1e-3)
    refused = case.run(block_on_table(), changed(scene, ("stages", [{"pressed": {"loads": []}}])))
    case.check("a first static stage without loads", refused.verdict, "bad input")
