#!/usr/bin/env python3
"""Which method for many stones: error against time, a map of where each method is right, hands over, or is wrong, and the goals of time.

    PYTHONPATH=tools python tests/benchmark/many_stones.py --quoin build/quoin                     # all but 7776 and 20 032 stones: half an hour
    PYTHONPATH=tools python tests/benchmark/many_stones.py --quoin build/quoin --stones 7776 20032 # time of these sizes: half an hour
    PYTHONPATH=tools python tests/benchmark/many_stones.py --quoin build/quoin --goals 2070 fall   # goals whose names hold these words
    PYTHONPATH=tools python tests/benchmark/many_stones.py --draw                                  # charts and table from the data

Voronoi dams of section G1 under their own weight, one rank, processor time of the whole process, one run at a time: beside other work it is longer, all
methods alike, so the chart has ratios.
Error against time: rigid and elastic stones of several seeds, friction 60 degrees, tolerances 1e-4 to 1e-8. The error is the largest difference of
displacements over the largest, against explicit cycles to 1e-9 with a ramp of 10 000, or stiffness_mass with a ramp of 4000 where these keep slip as it
came; the grey part is by how much such references and an explicit ramp of 1000 differ, where friction has several equilibria. Of more than 2003 stones time alone.
Map: 150 elastic stones of three seeds, friction 20 to 75 degrees, k_s/k_n 0.1 to 1, k_n 1 to 100 GPa/m. The least friction by limit analysis is an
upper bound of what stands. Right: verdict of the reference, and displacements within 1 %, or within what references differ by, which
are those of error against time, to 1e-8. Another equilibrium is farther off, and told where the run warns.
Rows that are there are kept (--again: not). Writes docs/data/many_stones.json, stones_map.json, stones_goals.json, docs/img/many_stones.png, stones_map.png
and a table of docs/generated/benchmarks.md."""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import numpy as np
import yaml
from matplotlib import colors, pyplot

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools"), str(ROOT / "tests" / "benchmark")]

from best import KEPT, answer, chosen, error, finite, run  # noqa: E402
from best_scenes import DAM, RIGID, SIDES, STIFF, Scene, scenes  # noqa: E402
from driver import ENVIRONMENT  # noqa: E402
from quoin_tools.base.files import save_figure  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.voronoi import Options, voronoi_mesh  # noqa: E402
from record import DATA, DOCS, keep, replace_between, table  # noqa: E402

SAME = 0.01  # two answers that are the same, of the map
TOLERANCES = ("1e-4", "1e-5", "1e-6", "1e-7", "1e-8")
# name: options, colour
METHODS = {
    "explicit": (("-relaxation_method", "explicit"), "#0072b2"),
    "explicit, local damping": (("-relaxation_method", "explicit", "-relaxation_damping", "local"), "#56b4e9"),
    "explicit, damping of the paper": (("-relaxation_method", "explicit", "-relaxation_damping", "paper"), "#e69f00"),
    "stiffness_mass": (("-relaxation_method", "stiffness_mass"), "#d55e00"),
    "Newton": (("-relaxation_method", "preconditioned", "-relaxation_effort", "2e6"), "#6a3d9a"),
    "default": ((), "#111111"),
}
MANY = 2003  # stones from which these methods alone run, with the usual tolerance
FAST = ("explicit", "stiffness_mass", "default")
REFERENCES = (("explicit", 10000), ("explicit", 1000), ("stiffness_mass", 4000))
USUAL = "1e-6"  # tolerance of a scene that gives none
SEEDED = {150: (5, 1, 3), 597: (3, 1, 5), 2003: (3, 5), 7776: (3,), 20032: (5,)}  # size (of the first seed): seeds
FRICTIONS = (20, 30, 36, 45, 60, 75)
STIFFNESSES = ((1e9, 0.3), (10e9, 0.1), (10e9, 0.3), (10e9, 1.0), (100e9, 0.3))  # k_n [Pa/m], k_s/k_n
SEEDS = (1, 5, 3)
LIMIT = 5.0  # [s] of a run of the map
MAPPED = ("seed", "k_n", "ratio", "friction", "method")  # what a cell of the map is known by
SPEED = ("size", "seed", "blocks", "method", "tolerance")  # what a row of error against time is known by


def scene_in(folder, seed, side, also=()):
    """Mesh and scene; the words behind the program."""
    write(str(folder / "model.h5"), voronoi_mesh(options=Options(seed=seed, side=side)))
    scene = DAM | {"stages": [*DAM["stages"], *also]}
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    return ("-options_file", "scene.yaml", "-model", "model.h5", "-output", "out", "-checkpoint_minutes", "0", "-stages", "sw")


def kept(name):
    path = DATA / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else []


def reference(name, command, folder, ramp, limit, tolerance="1e-9", method="explicit"):
    """Answer of a method with a long ramp (None: stopped), of this name in build/best where it was found before."""
    path = KEPT / f"{name}, {method}, ramp of {ramp}.json"
    if path.exists():
        found = json.loads(path.read_text(encoding="utf-8"))
        return found and found | {"fields": {stage: np.array(field) for stage, field in found["fields"].items()}}
    code, _, _ = run([*command, "-relaxation_method", method, "-relaxation_ramp", str(ramp), "-relaxation_tolerance", tolerance, "-relaxation_velocity_tolerance", "1e-7",
                            "-relaxation_max_cycles", "1000000"], folder, limit)  # fmt: skip
    found = answer(folder, code) if code is not None else None
    KEPT.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(found, default=np.ndarray.tolist), encoding="utf-8")
    return found


# ---- error against time

def ways(size, blocks, first):
    """(method, tolerance) of a dam, methods of one tolerance in turn; first: its seed is the first of its size."""
    if size >= MANY:
        return [(method, USUAL) for method in FAST]
    fine, coarse = blocks == "rigid" and first, TOLERANCES[::2]
    found = [(method, tolerance) for tolerance in (TOLERANCES if fine else coarse) for method in FAST]
    slow = [method for method in METHODS if method not in FAST] if first else []
    return found + [(method, tolerance) for tolerance in (coarse if fine else (USUAL,)) for method in slow if method != "Newton" or size == 150 or (fine and tolerance == USUAL)]


def speed(program, size, limit, again, methods):
    there = {tuple(row[name] for name in SPEED) for row in kept("many_stones")} if not again else set()
    for seed in SEEDED[size]:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            words = scene_in(folder, seed, SIDES[size][0])
            for blocks, kind in (("rigid", RIGID), ("elastic", ())):
                if blocks == "elastic" and (size >= MANY or seed != SEEDED[size][0]):
                    continue
                missing = [way for way in ways(size, blocks, seed == SEEDED[size][0]) if way[0] in methods and (size, seed, blocks, *way) not in there]
                if missing:
                    measure(program, (*words, *kind, *STIFF.get(size, ())), folder, {"size": size, "seed": seed, "blocks": blocks}, missing, limit)


def measure(program, words, folder, about, ways, limit):
    """Rows of a dam. Of more than MANY stones the explicit end is what the others are compared with."""
    command = [program, *words]
    large = about["size"] > MANY
    name = f"{about['size']} {about['blocks']} stones, seed {about['seed']}"
    found = [] if large else [(reference(name, command, folder, ramp, 5 * limit, method=method), f"{method}, ramp of {ramp}") for method, ramp in REFERENCES]
    right, how, unsure = chosen([each for each in found if each[0]])
    right, unsure = right if right["verdict"] else None, finite(unsure)
    print(f"{name}: reference {how}; others that count differ by {unsure}", flush=True)
    for method, tolerance in ways:
        code, seconds, warned = run([*command, *METHODS[method][0], "-relaxation_tolerance", tolerance, "-relaxation_velocity_tolerance", tolerance], folder, 10 * limit if large else limit)
        found = answer(folder, code) if code is not None else None
        stones = json.loads((folder / "out" / "summary.json").read_text(encoding="utf-8"))["n_macroblocks"] if found else None
        beside = {"yard": timed(command[0], yard(), limit)[1]} if large else {}
        row = about | {"method": method, "tolerance": tolerance, "stones": stones, "seconds": seconds, "verdict": found["verdict"] if found else "stopped", "ran": found["method"] if found else "",
                       "warned": warned, "error": finite(error(found, right, {})) if found and right else None, "unsure": unsure} | beside  # fmt: skip
        keep("many_stones", [row], SPEED)
        print(", ".join(f"{value}" for value in row.values()), flush=True)
        if large and method == "explicit":
            right = found


PANELS = ((150, "rigid"), (597, "rigid"), (2003, "rigid"), (150, "elastic"), (597, "elastic"))
MARKS = ("o", "s", "^")  # of seeds


def draw_speed(rows, path):
    """Error over time for each size, in times of explicit cycles to 1e-6; the last panel has seconds over stones."""
    figure, panels = pyplot.subplots(2, 3, figsize=(15, 9.2), constrained_layout=True)
    for axes, (size, blocks) in zip(panels.flat, PANELS):
        mine = [row for row in rows if (row["size"], row["blocks"]) == (size, blocks)]
        if mine:
            draw_errors(axes, mine, SEEDED[size])
            axes.set_title(f"{'about ' if blocks == 'rigid' else ''}{size} {blocks} stones")
    draw_sizes(panels[1][2], rows)
    for axes in panels[:, 0]:
        axes.set_ylabel("error of displacement, over the largest [%]")
    marks = [pyplot.Line2D([], [], color=colour, marker="o", linestyle="--" if name == "default" else "-", markerfacecolor="none" if name == "default" else colour, label=name)
             for name, (_, colour) in METHODS.items() if any(row["method"] == name for row in rows)]  # fmt: skip
    marks += [pyplot.Line2D([], [], color="grey", marker="o", linestyle="none", markersize=size_of(tolerance), label=f"tolerance {tolerance}") for tolerance in TOLERANCES[::2]]
    marks += [pyplot.Line2D([], [], color="grey", marker=mark, linestyle="none", label=f"dam {k + 1}") for k, mark in enumerate(MARKS)]
    marks += [pyplot.Rectangle((0, 0), 1, 1, color="grey", alpha=0.18, label="below: within what references of a dam differ by"),
              pyplot.Line2D([], [], color="black", linewidth=0.8, linestyle=":", label="0.5 %")]  # fmt: skip
    figure.legend(handles=marks, loc="outside lower center", ncols=5, fontsize=10)
    save_figure(figure, path, dpi=110)


def size_of(tolerance):
    return 4 + 1.5 * TOLERANCES.index(tolerance)


def draw_errors(axes, rows, seeds):
    unsure = max((row["unsure"] for row in rows if row["unsure"]), default=0)
    if unsure > 1e-6:
        axes.axhspan(1e-9, 100 * unsure, color="grey", alpha=0.18)
    axes.axhline(0.5, color="black", linewidth=0.8, linestyle=":")
    whole = {row["seed"]: row["seconds"] for row in rows if (row["method"], row["tolerance"]) == ("explicit", USUAL)}
    for method, (_, colour) in METHODS.items():
        for seed, mark in zip(seeds, MARKS):
            mine = sorted((row for row in rows if (row["method"], row["seed"]) == (method, seed) and row["verdict"] == "converged" and row["error"] is not None),
                          key=lambda row: TOLERANCES.index(row["tolerance"]))  # fmt: skip
            over = method == "default"
            xy = [(row["seconds"] / whole[seed], max(100 * row["error"], 1e-5)) for row in mine]
            if xy:
                axes.plot(*np.transpose(xy), color=colour, linewidth=1.0, linestyle="--" if over else "-", zorder=3 if over else 2)
            for row, (x, y) in zip(mine, xy):
                axes.plot(x, y, mark, color=colour, markersize=size_of(row["tolerance"]) + (3 if over else 0), markerfacecolor="none" if over else colour, zorder=3 if over else 2)
    for y, text in ((60, "other slip, at any tolerance"), (0.28, "right")):
        axes.text(0.16, y, text, fontsize=9, style="italic", va="center")
    ticks = (0.2, 0.5, 1, 2, 5, 10, 20)
    axes.set(xscale="log", yscale="log", ylim=(1e-5, 100), xlim=(0.15, 25), xlabel=f"processor time, in times of explicit cycles to {USUAL}")
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    axes.grid(alpha=0.25)


def draw_sizes(axes, rows):
    """Seconds over rigid stones to 1e-6, the median of the dams of a size, in times of the yard: its own run beside a large size, the row of 597 stones for the others."""
    mine = [row for row in rows if (row["blocks"], row["tolerance"], row["verdict"]) == ("rigid", USUAL, "converged")]
    usual = next((row["seconds"] for row in mine if (row["size"], row["seed"], row["method"]) == (597, SEEDED[597][0], "explicit")), YARD)
    for method in FAST:
        rows = [row for row in mine if row["method"] == method]
        points = sorted(tuple(np.median([(row["stones"], row["seconds"] / row.get("yard", usual) * YARD) for row in rows if row["size"] == size], axis=0)) for size in {row["size"] for row in rows})
        over = method == "default"
        if points:
            axes.plot(*np.transpose(points), color=METHODS[method][1], marker="o", markersize=10 if over else 6, markerfacecolor="none" if over else METHODS[method][1], linestyle="--" if over else "-")
    for stones, seconds in ((2070, 2), (20052, 60)):
        axes.plot(stones, seconds, "*", color="#009e73", markersize=15)
        axes.annotate(f"goal: {seconds} s", (stones, seconds), (-10, 6), textcoords="offset points", ha="right", color="#009e73", fontsize=11)
    axes.set(xscale="log", yscale="log", ylim=(0.1, 200), xlabel="rigid stones", ylabel=f"processor time [s], by explicit\ncycles of 597 stones, times {YARD:g} s (a quiet machine)", title=f"time over rigid stones, to {USUAL}")
    axes.grid(alpha=0.25)


# ---- goals

# what: scene of best_scenes.py, what its answer must be, seconds on a quiet machine
GOALS = {
    "2070 stones stand at 60 degrees": ((2003, 5), "converged", 2),
    "20 032 stones stand at 60 degrees": ((20032, 5), "converged", 60),
    "2003 stones fall at 35 degrees": ("Voronoi dam, 2003 stones, rigid, friction 35", "collapsed", 20),
    "2003 stones, full reservoir, friction of 45 degrees reduced to a bracket of 0.25": ("the same, friction reduced to 0.25 degree", "converged", 60),
}
YARD_OFF = 0.1  # part by which a time over that of the yard scatters
YARD = 0.57  # [s] explicit cycles of the dam of 597 stones (seed 3) on a quiet machine: what seconds beside other work are compared with


def yard():
    """What a time beside other work is compared with: explicit cycles of the dam of 597 stones."""
    return Scene("yard", DAM, lambda: voronoi_mesh(options=Options(seed=3, side=SIDES[597][0])), (*RIGID, *METHODS["explicit"][0]))


def goals(program, limit, names):
    """A row for each goal, with the seconds of the yard just before and just after."""
    known = {scene.name: scene for scene in scenes(("usual", "large"))}
    for what in names:
        scene, verdict, seconds = GOALS[what]
        if not isinstance(scene, str):
            size, seed = scene
            known[scene] = Scene(what, DAM, lambda size=size, seed=seed: voronoi_mesh(options=Options(seed=seed, side=SIDES[size][0])), (*RIGID, *STIFF.get(size, ())))
        before, (found, took, stones), after = (timed(program, one, limit) for one in (yard(), known[scene], yard()))
        beside = (before[1] + after[1]) / 2
        if not isinstance(scene, str) and size > MANY:  # a row of the chart of times
            keep("many_stones", [{"size": size, "seed": seed, "blocks": "rigid", "method": "default", "tolerance": USUAL, "stones": stones, "seconds": took, "verdict": found["verdict"],
                                  "ran": found["method"], "warned": None, "error": None, "unsure": None, "yard": beside}], SPEED)  # fmt: skip
        row = {"goal": what, "verdict": found["verdict"], "ran": found["method"], "brackets": ", ".join(f"{stands} stands, {falls} falls" for stands, falls in found["brackets"].values()), "seconds": took, "yard": beside, "quiet": took / beside * YARD, "allowed": seconds,
               "right": found["verdict"] == verdict}  # fmt: skip
        keep("stones_goals", [row], ("goal", ))
        print(", ".join(f"{value}" for value in row.values()), flush=True)


def timed(program, scene, limit):
    """Answer, seconds and stones of a scene by default."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        code, seconds, _ = run([program, *scene.prepare(folder)], folder, limit)
        if code is None:
            return {"verdict": "stopped", "method": "", "brackets": {}}, seconds, None
        return answer(folder, code), seconds, json.loads((folder / "out" / "summary.json").read_text(encoding="utf-8"))["n_macroblocks"]


def met(row):
    over = row["quiet"] / row["allowed"]
    return "**no**" if not row["right"] or over > 1 + YARD_OFF else "at the limit" if over > 1 - YARD_OFF else "yes"


def goals_table(rows):
    lines = [[row["goal"], row["verdict"], row["ran"], row["brackets"] or "-", row["allowed"], f"{row['quiet']:.2g}", f"{row['seconds']:.3g}", f"{row['yard']:.2g}", met(row)] for row in rows]
    return table(["goal, by default on one core", "verdict", "method", "bracket", "allowed [s]", "quiet [s]", "measured [s]", "yard [s]", "met"], lines)


# ---- map

def bound(program, folder):
    """Least friction by limit analysis [degree]."""
    done = subprocess.run([sys.executable, "-m", "quoin_tools", "limit", "scene.yaml", "--stage", "less", "-model", "model.h5"], cwd=folder, capture_output=True, text=True,
                          env=os.environ | ENVIRONMENT | {"PYTHONPATH": str(ROOT / "tools"), "QUOIN": program})  # fmt: skip
    found = re.search(r"less.*?([\d.]+)", next((line for line in done.stdout.splitlines() if "less" in line), ""))
    if not found:
        raise RuntimeError(done.stdout + done.stderr)
    return float(found[1])


def judged(row, right):
    """One word for a cell."""
    if row["verdict"] in ("undecided", "diverged", "stopped", "interrupted"):
        return "no verdict"
    if right is None:
        return "no reference"
    if row["verdict"] != right["verdict"]:
        return "wrong verdict"
    if row["verdict"] == "collapsed":
        return "falls, right"
    if row["error"] is not None and row["error"] <= max(SAME, row["unsure"] or 0.0):
        return "hands over, right" if "then" in row["ran"] else "right"
    return "another equilibrium, told" if row["warned"] else "another equilibrium, not told"


def chart(program, again, methods, seeds):
    there = {tuple(row[name] for name in MAPPED) for row in kept("stones_map")} if not again else set()
    reduced = ({"less": {"type": "strength_reduction", "loads": ["weight"], "bracket": 0.5, "limit": 5}}, )
    for seed in seeds:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            words = scene_in(folder, seed, SIDES[150][0], reduced)
            least = bound(program, folder)
            print(f"seed {seed}: limit analysis: stands from {least} degrees on", flush=True)
            for k_n, ratio in STIFFNESSES:
                for friction in FRICTIONS:
                    missing = [method for method in (*CHARTED, "default") if method in methods and (seed, k_n, ratio, friction, method) not in there]
                    if not missing:
                        continue
                    command = [program, *words, "-joints_default_friction", str(friction), "-joints_default_k_n", f"{k_n:g}", "-joints_default_k_s", f"{ratio * k_n:g}"]
                    cell = f"150 stones, seed {seed}, {k_n:g}, {ratio:g}, {friction}"
                    found = [(reference(cell, command, folder, ramp, 2 * LIMIT, "1e-8", method), f"{method}, ramp of {ramp}") for method, ramp in REFERENCES]
                    right, how, unsure = chosen([each for each in found if each[0] and each[0]["verdict"] in ("converged", "collapsed")])
                    right, rows = right if right["verdict"] else None, []
                    for method in missing:
                        code, seconds, warned = run([*command, *METHODS[method][0]], folder, LIMIT)
                        found = answer(folder, code) if code is not None else None
                        off = finite(error(found, right, {})) if found and right else None
                        row = {"seed": seed, "k_n": k_n, "ratio": ratio, "friction": friction, "bound": least, "method": method, "seconds": seconds,
                               "verdict": found["verdict"] if found else "stopped", "ran": found["method"] if found else "", "warned": warned, "error": off,
                               "right_verdict": right["verdict"] if right else "stopped", "reference": how, "unsure": finite(unsure)}  # fmt: skip
                        row["kind"] = judged(row, right)
                        rows.append(row)
                    keep("stones_map", rows, MAPPED)
                    print(f"seed {seed}, k_n {k_n:g}, k_s/k_n {ratio:g}, friction {friction}: " + "; ".join(f"{row['method']} {row['kind']} {row['seconds']:.2f} s" for row in rows), flush=True)


KINDS = {"right": "#009e73", "falls, right": "#a6d8c4", "hands over, right": "#f0e442", "another equilibrium, told": "#cc79a7", "no verdict": "#bbbbbb", "another equilibrium, not told": "#7b2d5b",
         "wrong verdict": "#d55e00", "no reference": "#ffffff"}  # fmt: skip
CHARTED = {"explicit": "#0072b2", "stiffness_mass": "#e69f00", "Newton": "#6a3d9a"}


SIGNS = {"no verdict": "?", "wrong verdict": "!", "another equilibrium, told": "~", "another equilibrium, not told": "!"}  # beside the colour


def draw_map(rows, path):
    """Columns: a method each, and the fastest right one; rows: dams. Cells: friction by stiffness; a number where it takes twice the time of the fastest right one."""
    seeds = [seed for seed in SEEDS if any(row["seed"] == seed for row in rows)]
    columns = [*CHARTED, "default", "take"]
    figure, panels = pyplot.subplots(len(seeds), len(columns), figsize=(16, 1.6 + 2.5 * len(seeds)), sharex=True, sharey=True, constrained_layout=True, squeeze=False)
    for k, (line, seed) in enumerate(zip(panels, seeds)):
        mine = {tuple(row[name] for name in MAPPED[1:]): row for row in rows if row["seed"] == seed}
        least = next(row["bound"] for row in mine.values())
        for axes, method in zip(line, columns):
            picture = np.ones((len(STIFFNESSES), len(FRICTIONS), 3))
            for i, j in np.ndindex(picture.shape[:2]):
                cell = (*STIFFNESSES[i], FRICTIONS[j])
                good = [row for name in CHARTED if (row := mine.get((*cell, name))) and row["kind"] in ("right", "falls, right")]
                best = min(good, key=lambda row: row["seconds"], default=None)
                row = best if method == "take" else mine.get((*cell, method))
                if not row:
                    continue
                picture[i, j] = colors.to_rgb(CHARTED[row["method"]] if method == "take" else KINDS[row["kind"]])
                times = row["seconds"] / best["seconds"] if best else 1
                text = SIGNS.get(row["kind"], "" if times < 2 else f"{times:.0f}x")
                axes.text(j, i, text, ha="center", va="center", fontsize=10, fontweight="bold", color="white" if row["kind"] in ("right", "wrong verdict", "another equilibrium, not told") else "black")
            axes.imshow(picture, origin="lower", aspect="auto")
            axes.set_xticks(range(len(FRICTIONS)), FRICTIONS)
            axes.set_yticks(range(len(STIFFNESSES)), [f"{k_n / 1e9:g}, {ratio:g}" for k_n, ratio in STIFFNESSES])
            axes.set_xticks(np.arange(0.5, len(FRICTIONS) - 1), minor=True)
            axes.set_yticks(np.arange(0.5, len(STIFFNESSES) - 1), minor=True)
            axes.grid(which="minor", color="white", linewidth=1.2)
            axes.tick_params(which="minor", length=0)
            axes.axvline(np.searchsorted(FRICTIONS, least) - 0.5, color="black", linewidth=2.5)
            if k == 0:
                axes.set_title({"take": "take: fastest right"}.get(method, method), fontsize=13, fontweight="bold")
            if k == len(seeds) - 1:
                axes.set_xlabel("friction [degree]")
        line[0].set_ylabel(f"dam {k + 1}\nk_n [GPa/m], k_s/k_n")
    present = {row["kind"] for row in rows}
    marks = [pyplot.Rectangle((0, 0), 1, 1, facecolor=colour, edgecolor="grey", label=f"{kind}  {SIGNS.get(kind, '')}") for kind, colour in KINDS.items() if kind in present]
    marks += [pyplot.Line2D([], [], color="black", linewidth=2.5, label="left of it none stands (limit analysis)"), pyplot.Line2D([], [], linestyle="none", label="3x: 3 times the fastest right way")]
    marks += [pyplot.Rectangle((0, 0), 1, 1, facecolor=colour, label=f"take {name}") for name, colour in CHARTED.items()]
    figure.legend(handles=marks, loc="outside lower center", ncols=4, fontsize=11)
    save_figure(figure, path, dpi=100)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--stones", type=int, nargs="*", choices=list(SIDES), help="error against time of these sizes alone (150, 597, 2003, and the map)")
    parser.add_argument("--limit", type=float, default=60.0, help="[s] of processor time of a run of error against time (%(default)s)")
    parser.add_argument("--map", action="store_true", help="the map alone")
    parser.add_argument("--seeds", type=int, nargs="+", choices=SEEDS, default=SEEDS, help="of the map")
    parser.add_argument("--goals", nargs="*", help="the goals alone whose names hold one of these words (all): the time of the default, with its verdict")
    parser.add_argument("--methods", nargs="+", default=list(METHODS), choices=list(METHODS), help="these alone")
    parser.add_argument("--again", action="store_true", help="rows that are there, too")
    parser.add_argument("--draw", action="store_true", help="charts from the data")
    options = parser.parse_args()
    program = os.path.abspath(options.quoin)
    if not options.draw:
        everything = options.stones is None and not options.map and options.goals is None
        for stones in (150, 597, 2003) if everything else options.stones or ():
            speed(program, stones, options.limit, options.again, options.methods)
        if options.map or everything:
            chart(program, options.again, options.methods, options.seeds)
        if options.goals is not None or everything:
            goals(program, 20 * options.limit, [what for what in GOALS if not options.goals or any(word in what for word in options.goals)])
    if kept("many_stones"):
        draw_speed(kept("many_stones"), DOCS / "img" / "many_stones.png")
    if kept("stones_map"):
        draw_map(kept("stones_map"), DOCS / "img" / "stones_map.png")
    if kept("stones_goals"):
        replace_between("goals of many stones", goals_table(kept("stones_goals")))


if __name__ == "__main__":
    main()
