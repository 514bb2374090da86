#!/usr/bin/env python3
"""Other programs on the same work, side by side in one run: time and error of each.

    PYTHONPATH=tools python tests/benchmark/peers.py --quoin build/quoin --python build/venv/bin/python

static     The dam of Fig. 6 with its joint, elastic and with 45 degrees of friction: Quoin's preconditioned relaxation and,
           at --paper blocks across, the paper's; CalculiX, OpenSees; one sparse Cholesky solve by CHOLMOD of the elastic
           problem assembled in numpy, the bar for them all. Errors of crest displacement and toe stress (mean over the last
           eighth of the base), the larger one: against an independent solver on the same mesh (peer_runs/plain.py), and
           against its values extrapolated to no mesh.
explicit   Total-Lagrangian quadrilaterals by central differences: Kratos and Quoin, the same block for the same time.
wall       Rigid blocks in running bond: LMGC90 and Quoin.
stones     Dams of rigid Voronoi stones under their weight: LMGC90 until its forces balance to 1 %, Quoin with its defaults, for three joints.

What each peer models stands at the top of its file in peer_runs/. Processor seconds (user and system) of one core, medians;
wall seconds beside them. Of Quoin and CalculiX the whole process counts, reading and writing included; "solution" is Quoin's
less the same run stopped after a cycle. OpenSees, Kratos and LMGC90 build their model in Python, which does not count.
A peer that is not installed is left out with a line. QUOIN_PEERS=1 tools/setup.sh installs them. Writes docs/data/peers.json
after each size (other sizes and parts stay), docs/img/peers.png and the tables of docs/generated/benchmarks.md, or into --folder."""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path
from resource import RUSAGE_CHILDREN

import matplotlib

matplotlib.use("Agg")
import numpy as np
from matplotlib import pyplot

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path[:0] = [str(HERE / "peer_runs"), str(HERE), str(ROOT / "tests" / "verification"), str(ROOT / "tools"), str(ROOT / "examples" / "fig6")]

from accuracy import toe_stress  # noqa: E402
from driver import ENVIRONMENT, VERDICTS, changed, dump, load  # noqa: E402
from fig6_dam import DENSITY, FRICTION, K_N, K_S, POISSON, YOUNG, Clock  # noqa: E402
from quoin_tools.base.files import save_figure  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.meshing import rectangle  # noqa: E402
from quoin_tools.mesh.walls import wall  # noqa: E402
from record import DATA, DOCS, replace_between, table  # noqa: E402
from triangle_dam import triangle_dam  # noqa: E402
from voronoi_stones import dam as stone_dam  # noqa: E402

ELASTIC, FRICTIONAL = "elastic", "friction 45 degrees"
TEN_MINUTES, START = 600.0, 2.0  # [s]; beside less the start of a process counts
LONG, SHORTEST = 10.0, 0.01  # [s] a run that takes longer is not repeated; what the difference of two runs can tell
# peer: the module of Python that must be there
MODULES = {"OpenSees": "openseespy", "Kratos": "KratosMultiphysics.StructuralMechanicsApplication", "LMGC90": "compas_lmgc90"}
# name: (peer, script, options, laws)
STATIC = {
    "CHOLMOD, one solve": ("CHOLMOD", "plain.py", (), (ELASTIC,)),
    "CalculiX, springs": ("CalculiX", "calculix.py", ("--joint", "springs"), (ELASTIC,)),
    "CalculiX, face to face": ("CalculiX", "calculix.py", ("--joint", "face"), (ELASTIC, FRICTIONAL)),
    "CalculiX, node to face": ("CalculiX", "calculix.py", ("--joint", "node"), (FRICTIONAL,)),
    "OpenSees": ("OpenSees", "opensees.py", (), (ELASTIC, FRICTIONAL)),
}
QUOIN, PAPER = "Quoin", "Quoin, the paper's relaxation"
STONES = {"101": (2.75, 5), "151": (1.6, 5), "275": (1.0, 5), "599": (0.6, 3), "2004": (0.3, 3)}  # stones: side [m], seed
# name: k_n [Pa/m] and k_s/k_n of the stones, the usual ones first
STIFF = {"Quoin, k_n 10 GPa/m": (10e9, 0.3), "Quoin, k_n 1000 GPa/m": (1000e9, 0.3), "Quoin, k_n 1000 GPa/m, k_s = k_n": (1000e9, 1.0)}
NEWTON = {"method": "preconditioned", "tolerance": 1e-5, "velocity_tolerance": 1, "history_every": 10000}


# ---- runs

def installed(options):
    """Whether each peer is there; a line for one that is not."""
    there = {"CHOLMOD": True, "CalculiX": shutil.which(options.ccx) is not None}
    for name, module in MODULES.items():
        there[name] = not subprocess.run([options.python, "-c", f"import {module}"], capture_output=True).returncode
    for name in there:
        if not there[name]:
            print(f"{name} is not installed ({MODULES.get(name, options.ccx)}): left out", flush=True)
    return there


def environment():
    return ENVIRONMENT | dict(os.environ) | {"PYTHONPATH": str(ROOT / "tools")}


def peer(python, script, *options):
    """What a peer reports in its last line."""
    done = subprocess.run([python, str(HERE / "peer_runs" / script), *map(str, options)], env=environment(), capture_output=True, text=True)
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if done.returncode or not lines:
        raise RuntimeError(f"{script} {options}: exit code {done.returncode} {done.stderr[-1000:]}")
    return json.loads(lines[-1])


def median(run, repeats):
    """The run of the median processor time; one that takes long is not repeated."""
    runs = [run()]
    while len(runs) < repeats and runs[0]["cpu_s"] < LONG:
        runs.append(run())
    return sorted(runs, key=lambda one: one["cpu_s"])[(len(runs) - 1) // 2] | {"runs": len(runs)}


def quoin(program, folder, scene, *changes):
    """Cost of a run of the scene in the folder, and what the last stage and its results are."""
    Path(folder, "scene.yaml").write_text(dump(changed(scene, *changes)), encoding="utf-8")
    clock = Clock(RUSAGE_CHILDREN)
    done = subprocess.run([program, "-options_file", "scene.yaml"], cwd=folder, env=environment(), capture_output=True, text=True)
    cost = clock.read()
    if VERDICTS.get(done.returncode, "bad input") == "bad input":
        raise RuntimeError(f"quoin: exit code {done.returncode} {done.stderr[-1000:]}")
    results = Results(os.path.join(folder, "out"))
    name = list(scene["stages"][-1])[0]
    return cost | {"stage": results.stage_summary(name), "results": results}


def stopped(cycles):
    """Changes of a static scene that end it after so many cycles of the explicit loop."""
    return (("relaxation.max_cycles", cycles), ("relaxation.check_every", cycles), ("relaxation.ramp", 0), ("relaxation.method", "explicit"))


# ---- static

def dam_run(program, folder, n, *changes):
    """Quoin on the dam: crest and toe beside the cost."""
    path = Path(folder, "model.h5")
    if not path.exists():
        write(str(path), triangle_dam(n, "M"))
    scene = changed(load("fig6").SCENE, ("relaxation", NEWTON), ("joints.default", {"k_n": K_N, "k_s": K_S, "stress_model": "tptm"}))
    run = quoin(program, folder, scene, *changes)
    results, stage = run.pop("results"), run.pop("stage")
    return run | {"crest": stage["probes"]["crest"]["u_x"], "toe": toe_stress(*results.joint_profile("full", "base")[:2]),
                  "iterations": stage["cycles"]}  # fmt: skip


def law_of(law):
    friction = float(np.degrees(np.arctan(FRICTION)))
    return (("joints.default.law", "elastic"),) if law == ELASTIC else (("joints.default.friction", friction),)


def quoin_rows(program, n, law, repeats, paper, cap):
    """Newton's method, and the paper's relaxation stopped after cap times its seconds."""
    with tempfile.TemporaryDirectory() as folder:
        start = median(partial(dam_run, program, folder, n, *law_of(law), *stopped(1)), repeats)
        newton = median(partial(dam_run, program, folder, n, *law_of(law)), repeats)
        newton["solution_s"] = max(newton["cpu_s"] - start["cpu_s"], SHORTEST)
        yield QUOIN, newton
        if law == FRICTIONAL and n == paper:
            old = (*law_of(law), ("relaxation.method", "explicit"), ("relaxation.damping", "paper"))
            probed = max(200, 2 * 10**7 // n**2)
            cycle = max(dam_run(program, folder, n, *old, *stopped(probed))["cpu_s"] - start["cpu_s"], SHORTEST) / probed
            run = dam_run(program, folder, n, *old, ("relaxation.max_cycles", 1 + int(cap * newton["solution_s"] / cycle)))
            yield PAPER, run | {"solution_s": max(run["cpu_s"] - start["cpu_s"], SHORTEST), "runs": 1}


def extrapolated(rows):
    """Crest and toe for no mesh, from three meshes, each twice as fine: order from their differences."""
    a, b, c = (np.array([row["crest"], row["toe"]]) for row in rows)
    ratio = np.clip((b - a) / np.where(c == b, 1, c - b), 1.5, 16)
    return c + (c - b) / (ratio - 1)


def errors(row, same, limit):
    """Larger of the relative errors of crest and toe, against the independent solver and against no mesh."""
    found = np.array([row["crest"], row["toe"]])
    return {"error_same_mesh": float(np.abs(found / [same["crest"], same["toe"]] - 1).max()),
            "error": float(np.abs(found / limit - 1).max())}  # fmt: skip


def static(options, there):
    for law in (ELASTIC, FRICTIONAL):
        flag = ("--friction",) if law == FRICTIONAL else ()
        exact = {n: peer(options.python, "plain.py", "--n", n, *flag) for n in {*options.limit, *options.sizes}}
        limit = extrapolated([exact[n] for n in options.limit])
        print(f"{law}: crest {1e3 * limit[0]:.5f} mm, toe {1e-6 * limit[1]:.5f} MPa, extrapolated by the independent solver", flush=True)
        for n in options.sizes:
            found = list(quoin_rows(options.quoin, n, law, options.repeats, options.paper, options.cap))
            for name, (who, script, more, laws) in STATIC.items():
                if law in laws and there[who]:
                    more = (*more, "--program", options.ccx) if who == "CalculiX" else more
                    found.append((name, median(partial(peer, options.python, script, "--n", n, *more, *flag), options.repeats)))
            yield [{"law": law, "solver": name, "elements": n * n, **run, **errors(run, exact[n], limit)} for name, run in found]


# ---- explicit steps and the wall

def steps_cost(program, folder, scene, duration, factor):
    """Processor seconds of a step: of a dynamic stage of `factor` durations, less one of the duration; and the end of the latter."""
    runs = [quoin(program, folder, scene, ("stages", [{"all": scene["stages"][0]["all"] | {"duration": t}}]))
            for t in (duration, factor * duration)]  # fmt: skip
    cpu, steps = np.diff([run["cpu_s"] for run in runs])[0], np.diff([run["stage"]["cycles"] for run in runs])[0]
    return {"cpu_s": float(cpu / steps), "stage": runs[0]["stage"]}


def block_scene():
    return {"strain": "large", "materials": {"body": {"density": DENSITY, "young": YOUNG, "poisson": POISSON}},
            "supports": {"bottom": {"fix": "xy"}}, "loads": {"weight": {"type": "self_weight"}},
            "stages": [{"all": {"type": "dynamic", "loads": ["weight"], "duration": 1.0, "dt_factor": 0.5}}]}  # fmt: skip


def explicit(options, there):
    for n in options.explicit:
        steps = max(10, min(400, 4 * 10**6 // n**2))
        other = median(partial(peer, options.python, "kratos.py", "--n", n, "--steps", steps), options.repeats) if there["Kratos"] else None
        duration = other["time"] if other else 0.5 * 100 / n * steps / 3726
        with tempfile.TemporaryDirectory() as folder:
            write(os.path.join(folder, "model.h5"), rectangle(0.0, 0.0, 100.0, 100.0, n, n))
            scene = block_scene()
            factor = max(3, min(10**8 // n**2, 50000) // steps)
            dynamic = median(partial(steps_cost, options.quoin, folder, scene, duration, factor), options.repeats)
            relaxed = changed(scene, ("stages", [{"all": {"loads": ["weight"]}}]), ("relaxation", {"history_every": 10**9}))
            many = max(100, min(10**8 // n**2, 50000))
            ends = [median(partial(quoin, options.quoin, folder, relaxed, *stopped(k)), options.repeats)["cpu_s"] for k in (1, many)]
        where = dynamic.pop("stage")["probes"]["top_left"]
        rows = [{"solver": "Quoin, step in time", "elements": n * n, "ns": dynamic["cpu_s"] / n**2 * 1e9, "u_x": where["u_x"], "u_y": where["u_y"]},
                {"solver": "Quoin, cycle of relaxation", "elements": n * n, "ns": (ends[1] - ends[0]) / (many - 1) / n**2 * 1e9}]  # fmt: skip
        if other:
            rows.append({"solver": "Kratos", "elements": n * n, "ns": other["ns_per_element_step"], "u_x": other["u_x"], "u_y": other["u_y"]})
        yield rows


def rigid_wall(options, there):
    joints = {"k_n": 10e9, "k_s": 3e9, "friction": 45, "stress_model": "tptm"}
    for n in options.walls:
        mesh = wall(n, n, 1.0, 1.0)
        scene = {"thickness": 0.5, "materials": {"base": {"density": 0}, "block": {"density": DENSITY}}, "joints": {"default": joints},
                 "supports": {"base": {"fix": "xy"}}, "loads": {"weight": {"type": "self_weight"}},
                 "stages": [{"all": {"type": "dynamic", "loads": ["weight"], "duration": 1.0, "dt_factor": 0.5}}]}  # fmt: skip
        with tempfile.TemporaryDirectory() as folder:
            write(os.path.join(folder, "model.h5"), mesh)
            run = median(partial(steps_cost, options.quoin, folder, scene, 0.01, 100), options.repeats)
            model = json.loads(Path(folder, "out", "summary.json").read_text(encoding="utf-8"))
        found = [("Quoin", model["n_contacts"], run["cpu_s"], run["stage"]["dt"])]
        if there["LMGC90"]:
            other = median(partial(peer, options.python, "lmgc90.py", "--n", n), options.repeats)
            found.append(("LMGC90", other["contacts"], other["cpu_s"] / other["steps"], other["dt"]))
        yield [{"solver": name, "blocks": n * n, "contacts": contacts, "us_per_step": 1e6 * cost, "ns_per_contact": 1e9 * cost / contacts,
                "dt_s": dt, "cpu_s_per_second": cost / dt} for name, contacts, cost, dt in found]  # fmt: skip


def stone_scene(k_n, ratio, friction):
    return {"materials": dict.fromkeys(("dam", "facing"), {"density": DENSITY, "rigid": True}), "joints": {"default": {"k_n": k_n, "k_s": ratio * k_n, "friction": friction}},
            "supports": {"base": {"fix": "xy"}}, "loads": {"weight": {"type": "self_weight"}}, "stages": [{"sw": {"loads": ["weight"]}}]}  # fmt: skip


def stones_of(options, there):
    """Verdict, residual, penetration, sum of normal forces and cost; a row of each program and k_n."""
    for name in options.stones:
        (side, seed), friction = STONES[name.split(":")[0]], float(name.split(":")[1])
        with tempfile.TemporaryDirectory() as folder:
            mesh, rings, held = stone_dam(side, seed)
            write(os.path.join(folder, "model.h5"), mesh)
            found = []
            for solver, joint in STIFF.items():
                run = median(partial(quoin, options.quoin, folder, stone_scene(*joint, friction)), options.repeats)
                stage, joint = run.pop("stage"), run.pop("results").summary["stages"][0]["joints"]["default"]
                found.append((solver, run | {"verdict": "stands" if stage["verdict"] == "converged" else "falls" if stage["verdict"] == "collapsed" else "no end",
                              "steps": stage["cycles"], "residual": stage["ratio"], "penetration": -joint["sigma_min"]["opening"], "normal": joint["N"],
                              "moved": stage["max_displacement"]["value"]}))  # fmt: skip
            if there["LMGC90"] and len(rings) <= options.most:
                path = Path(folder, "rings.json")
                path.write_text(json.dumps({"rings": [ring.tolist() for ring in rings], "held": held}), encoding="utf-8")
                found.append(("LMGC90", peer(options.python, "lmgc90_stones.py", "--stones", path, "--angle", friction, "--limit", options.seconds)))
        yield [{"stones": len(rings), "friction": friction, "solver": solver, **run} for solver, run in found]


# name: (rows of one size in one run after another, columns in which they agree: they are replaced together)
PARTS = {"static": (static, ("law", "elements")), "explicit": (explicit, ("elements",)), "wall": (rigid_wall, ("blocks",)),
         "stones": (stones_of, ("stones", "friction"))}  # fmt: skip


def measure(options, path):
    """The parts asked for, beside what the file holds of other sizes and parts; written after each size."""
    data = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    there = installed(options) if options.parts else {}
    for part in options.parts:
        run, columns = PARTS[part]
        for rows in run(options, there):
            size = [rows[0][column] for column in columns]
            data[part] = sorted([row for row in data.get(part, []) if [row[c] for c in columns] != size] + rows,
                                key=lambda row: [row[c] for c in columns])  # fmt: skip
            path.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
            for row in rows:
                print("  " + ", ".join(f"{key} {value:.4g}" if isinstance(value, float) else str(value) for key, value in row.items()), flush=True)
    return data


# ---- what is written

COLOURS = {"Quoin": "#d55e00", "CHOLMOD": "#555555", "CalculiX": "#0072b2", "OpenSees": "#009e73", "Kratos": "#cc79a7", "LMGC90": "#e69f00"}
MARKS = {"Quoin": "o", PAPER: "X", "CHOLMOD, one solve": "_", "CalculiX, springs": "v", "CalculiX, face to face": "s",
         "CalculiX, node to face": "D", "OpenSees": "^"}  # fmt: skip


def colour(solver):
    return COLOURS[solver.split(",")[0]]


def growth(points):
    """Time = c stones^p through the three largest of (stones, seconds) in which the start of the process does not count: p, and stones for ten minutes. None: too few."""
    points = sorted(point for point in points if point[1] > START)
    if len(points) < 3 or points[-1][0] < 2 * points[0][0]:
        return None
    n, seconds = np.log(np.array(points[-3:])).T
    p, c = np.polyfit(n, seconds, 1)
    return p, float(np.exp((np.log(TEN_MINUTES) - c) / p))


def times_of_stones(rows):
    """{solver: [(stones, seconds)]} of dams that stand at 60 degrees; Quoin's default also with the thousands of stones of many_stones.py."""
    rows = [row for row in rows if row["friction"] == 60 and row["verdict"] == "stands" and row["solver"] in (next(iter(STIFF)), "LMGC90")]
    found = {solver: [(row["stones"], row["cpu_s"]) for row in rows if row["solver"] == solver] for solver in dict.fromkeys(row["solver"] for row in rows)}
    path, default = DATA / "many_stones.json", next(iter(found), None)
    if default and path.exists():
        found[default] += [(row["stones"], row["seconds"]) for row in json.loads(path.read_text(encoding="utf-8"))
                           if row["size"] >= 2003 and (row["method"], row["verdict"]) == ("default", "converged")]  # fmt: skip
    return found


def counted(number):
    """A number of stones with two digits that count."""
    return f"{float(f'{number:.2g}'):,.0f}".replace(",", " ")


def draw_stones(axes, rows):
    for solver, points in times_of_stones(rows).items():
        axes.plot(*np.transpose(sorted(points)), color=colour(solver), marker="o", label=solver)
        if found := growth(points):
            most = found[1]
            stones, seconds = max(points)
            axes.plot((stones, most), (seconds, TEN_MINUTES), color=colour(solver), linestyle="--", linewidth=1)
            axes.annotate(f"{counted(most)} stones", (most, TEN_MINUTES), (0, 5), textcoords="offset points", ha="right", color=colour(solver))
    for row in (row for row in rows if row["friction"] == 60 and row["verdict"] == "no end"):
        axes.plot(row["stones"], row["cpu_s"], "x", color=colour(row["solver"]), markersize=9)
        axes.annotate(f"stopped at {100 * row['best']:.1f} % unbalanced", (row["stones"], row["cpu_s"]), (9, -4), textcoords="offset points", color=colour(row["solver"]))
    axes.axhline(TEN_MINUTES, color="black", linewidth=0.7)
    axes.set(xscale="log", yscale="log", xlabel="rigid stones", ylabel="processor time [s]", ylim=(0.05, 3 * TEN_MINUTES),
             title="Voronoi dams, friction 60 degrees; line: 10 minutes, dashed: extrapolated")  # fmt: skip
    axes.legend(loc="lower right")


def draw(data, path):
    figure = pyplot.figure(figsize=(15, 9.5), constrained_layout=True)
    grid = figure.add_gridspec(2, 3)
    panels = [figure.add_subplot(place) for place in (grid[0, 0], grid[0, 1], grid[0, 2], grid[1, 0], grid[1, 1:])]
    draw_stones(panels[4], data["stones"])
    for axes, law in zip(panels, (ELASTIC, FRICTIONAL)):
        for name in dict.fromkeys(row["solver"] for row in data["static"] if row["law"] == law):
            mine = [row for row in data["static"] if (row["law"], row["solver"]) == (law, name)]
            axes.plot([row["elements"] for row in mine], [row["cpu_s"] for row in mine], color=colour(name), marker=MARKS[name],
                      linestyle=":" if name.startswith("CHOLMOD") else "-", linewidth=1.2, label=name)  # fmt: skip
        bare = [row for row in data["static"] if (row["law"], row["solver"]) == (law, QUOIN)]
        axes.plot([row["elements"] for row in bare], [row["solution_s"] for row in bare], color=colour(QUOIN), linestyle="--", linewidth=1,
                  label="Quoin, solution only")  # fmt: skip
        axes.set(xscale="log", yscale="log", xlabel="elements", ylabel="processor time [s]", title=f"Dam of Fig. 6, {law}")
        axes.legend(fontsize=8)
    axes = panels[2]
    for row in (row for row in data["static"] if not row["solver"].startswith("CHOLMOD")):  # CHOLMOD solves for the reference
        axes.plot(row["cpu_s"], max(row["error_same_mesh"], 1e-8), color=colour(row["solver"]), marker=MARKS[row["solver"]], linestyle="none",
                  fillstyle="none" if row["law"] == ELASTIC else "full", markersize=5)  # fmt: skip
    axes.axhline(1e-3, color="black", linewidth=0.7)
    axes.set(xscale="log", yscale="log", xlabel="processor time [s]", ylabel="error against an independent solver, same mesh [-]",
             title="hollow: elastic, full: friction; line: 0.1 %")  # fmt: skip
    axes = panels[3]
    bars = [(f"{row['solver']}\n{row['elements']} elements", row["ns"], row["solver"]) for row in data["explicit"]]
    bars += [(f"{row['solver']}, wall of\n{row['blocks']} blocks, per contact", row["ns_per_contact"], row["solver"]) for row in data["wall"]]
    axes.barh([bar[0] for bar in bars], [bar[1] for bar in bars], color=[colour(bar[2]) for bar in bars])
    axes.set(xscale="log", xlabel="processor time per element or contact and step [ns]", title="Explicit steps; rigid wall")
    axes.invert_yaxis()
    axes.tick_params(axis="y", labelsize=6.5)
    for axes, parts in zip(panels, (("static", ), ("static", ), ("static", ), ("explicit", "wall"), ("stones", ))):
        axes.grid(alpha=0.3, which="major")
        axes.set_visible(any(data[part] for part in parts))  # empty ones have no logarithm
    save_figure(figure, path, dpi=110)


def percent(value):
    return f"{100 * value:.2g} %" if value >= 1e-6 else "< 1e-4 %"


def static_table(rows):
    lines = []
    for row in rows:
        own = next(r for r in rows if (r["law"], r["elements"], r["solver"]) == (row["law"], row["elements"], QUOIN))
        text = f"{row['cpu_s']:.3g}" + (f" (solution {row['solution_s']:.3g})" if "solution_s" in row else "")
        lines.append([row["law"], row["elements"], row["solver"], text, f"{row['wall_s']:.3g}", f"{row['cpu_s'] / own['cpu_s']:.2g}",
                      percent(row["error_same_mesh"]), percent(row["error"])])  # fmt: skip
    return table(["joint", "elements", "solver", "processor [s]", "wall [s]", "of Quoin's time", "error, same mesh", "error, no mesh"], lines)


def ratios(rows):
    """What Quoin's times are to those of the others, size by size."""
    lines = []
    at = {(row["law"], row["elements"], row["solver"]): row for row in rows}
    for size in dict.fromkeys(row["elements"] for row in rows):
        own, bar, paper = at[FRICTIONAL, size, QUOIN], at[ELASTIC, size, "CHOLMOD, one solve"], at.get((FRICTIONAL, size, PAPER))
        words = [f"{size} elements: frictional state, error {percent(own['error_same_mesh'])}: solution {own['solution_s'] / bar['cpu_s']:.2g}, "
                 f"whole process {own['cpu_s'] / bar['cpu_s']:.2g} times one sparse Cholesky solve"]  # fmt: skip
        for law in (ELASTIC, FRICTIONAL):
            others = [row for row in rows if (row["law"], row["elements"]) == (law, size) and row["solver"].startswith("CalculiX")]
            if others:
                fastest = min(others, key=lambda row: row["cpu_s"])
                words.append(f"{fastest['solver']}, {law}: {fastest['cpu_s'] / at[law, size, QUOIN]['cpu_s']:.2g} times as long")
        if paper:
            words.append(f"the paper's relaxation, stopped after {paper['solution_s'] / own['solution_s']:.0f} times as long: "
                         f"error {percent(paper['error_same_mesh'])}")  # fmt: skip
        lines.append("- " + "; ".join(words) + "\n")
    return "".join(lines)


def explicit_table(rows):
    lines = []
    for size in dict.fromkeys(row["elements"] for row in rows):
        at = {row["solver"]: row for row in rows if row["elements"] == size}
        if "Kratos" in at:
            other, step, cycle = (at[name] for name in ("Kratos", "Quoin, step in time", "Quoin, cycle of relaxation"))
            lines.append([size, f"{other['ns']:.0f}", f"{step['ns']:.1f}", f"{other['ns'] / step['ns']:.0f}", f"{cycle['ns']:.1f}",
                          f"{other['ns'] / cycle['ns']:.0f}", f"{1e3 * other['u_y']:.5f}, {1e3 * step['u_y']:.5f}"])  # fmt: skip
    return table(["elements", "Kratos [ns]", "Quoin, step in time [ns]", "ratio", "Quoin, cycle of relaxation [ns]", "ratio",
                  "u_y of the corner, Kratos and Quoin [mm]"], lines)  # fmt: skip


def wall_table(rows):
    lines = [[row["blocks"], row["solver"], row["contacts"], f"{row['us_per_step']:.3g}", f"{row['ns_per_contact']:.3g}", f"{row['dt_s']:.2g}",
              f"{row['cpu_s_per_second']:.3g}"] for row in rows]  # fmt: skip
    return table(["blocks", "solver", "contacts", "step [us]", "per contact [ns]", "time step [s]", "processor seconds for a second"], lines)


def stones_table(rows):
    lines = []
    for row in rows:
        own = next(r for r in rows if (r["stones"], r["friction"]) == (row["stones"], row["friction"]))
        lines.append([row["stones"], f"{row['friction']:g}", row["solver"], row["verdict"], f"{row['cpu_s']:.3g}", f"{row['cpu_s'] / own['cpu_s']:.2g}", row["steps"], f"{row.get('best', row['residual']):.1e}",
                      f"{1e3 * row['penetration']:.2g}", *("--" if row["verdict"] == "falls" else (f"{1e3 * row['moved']:.2g}", f"{1e-6 * row['normal']:.3g}"))])  # fmt: skip
    text = table(["stones", "friction", "solver", "verdict", "processor [s]", "of Quoin's time", "cycles or steps", "unbalanced ratio", "penetration [mm]", "moved [mm]", "sum of normal forces [MN]"], lines)
    ends = [f"{solver}: time grows with stones^{found[0]:.2f}, {counted(found[1])} stones in 10 minutes" for solver, points in times_of_stones(rows).items() if (found := growth(points))]
    return text + "".join(f"- {end}\n" for end in ends)


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--python", default=sys.executable, help="that has the peers of Python")
    parser.add_argument("--ccx", default="ccx", help="the program CalculiX")
    parser.add_argument("--folder", help="for peers.json, peers.png, peers.md; the default is docs/")
    parser.add_argument("--parts", nargs="*", choices=PARTS, default=list(PARTS), help="the others keep what peers.json holds; none: tables and picture alone")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--sizes", type=int, nargs="*", default=[45, 100, 316], help="of the dam, blocks across")
    parser.add_argument("--limit", type=int, nargs=3, default=[79, 158, 316], help="of the reference, each twice the one before")
    parser.add_argument("--paper", type=int, default=316, help="size that the paper's relaxation runs too, 0: none")
    parser.add_argument("--cap", type=float, default=25.0, help="... for so many times the seconds of Newton's method")
    parser.add_argument("--explicit", type=int, nargs="*", default=[32, 100, 316], help="sides of the block")
    parser.add_argument("--walls", type=int, nargs="*", default=[5, 10], help="blocks across and courses of the wall")
    parser.add_argument("--stones", nargs="*", default=["101:60", "151:60", "151:45", "275:60", "599:60", "2004:60"], help="stones:friction [degree] of dams")
    parser.add_argument("--most", type=int, default=599, help="stones that LMGC90 is asked to take (%(default)d)")
    parser.add_argument("--seconds", type=float, default=300.0, help="of processor time that LMGC90 has for a dam of stones (%(default)g)")
    options = parser.parse_args()
    options.quoin = os.path.abspath(options.quoin)
    return options


def main():
    options = parse()
    folder = Path(options.folder) if options.folder else None
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
    data = dict.fromkeys(PARTS, []) | measure(options, (folder or DATA) / "peers.json")
    text = "\n".join((static_table(data["static"]), ratios(data["static"]), explicit_table(data["explicit"]), wall_table(data["wall"]), stones_table(data["stones"])))
    draw(data, folder / "peers.png" if folder else DOCS / "img" / "peers.png")
    if folder:
        (folder / "peers.md").write_text(text, encoding="utf-8")
    else:
        replace_between("peers", text)
    print(text)


if __name__ == "__main__":
    main()
