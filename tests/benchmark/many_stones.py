#!/usr/bin/env python3
"""Which method for many stones: error against time, and a map of where each method is right, hands over, or is wrong.

    PYTHONPATH=tools python tests/benchmark/many_stones.py --quoin build/quoin                # the map (ten minutes) and error against time up to 2003 stones (ten)
    PYTHONPATH=tools python tests/benchmark/many_stones.py --quoin build/quoin --stones 7776  # error against time of one size: half an hour
    PYTHONPATH=tools python tests/benchmark/many_stones.py --draw                             # the charts from the data

Voronoi dams of section G1 under their own weight, one rank, processor time of the whole process.
Error against time: rigid and elastic stones, friction 60 degrees, tolerances 1e-4 to 1e-8. The error is the largest difference of displacements over the
largest, against explicit cycles to 1e-9 with a ramp of 10 000; a line has what a ramp of 1000 changes there, where friction has several equilibria.
Map: 150 elastic stones of three seeds, friction 20 to 75 degrees, k_s/k_n 0.1 to 1, k_n 1 to 100 GPa/m. The least friction by limit analysis is an
upper bound of what stands. Right: verdict of the reference, and displacements within 1 %, or within what two ramps of it differ by. Another equilibrium
is farther off, and told where the run warns.
Rows that are there are kept (--again: not). Writes docs/data/many_stones.json, docs/data/stones_map.json, docs/img/many_stones.png, docs/img/stones_map.png."""

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

from best import KEPT, answer, error, finite, run  # noqa: E402
from best_scenes import DAM, RIGID, SIDES, STIFF  # noqa: E402
from driver import ENVIRONMENT  # noqa: E402
from quoin_tools.base.files import save_figure  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.voronoi import Options, voronoi_mesh  # noqa: E402
from record import DATA, DOCS, keep  # noqa: E402

TICKS = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500)  # [s]
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
SLOW = {7776: ("explicit", "stiffness_mass", "default"), 20032: ("explicit", "stiffness_mass", "default")}  # the others take minutes there
FRICTIONS = (20, 25, 30, 33, 36, 40, 45, 52, 60, 75)
STIFFNESSES = ((1e9, 0.3), (10e9, 0.1), (10e9, 0.3), (10e9, 1.0), (100e9, 0.3))  # k_n [Pa/m], k_s/k_n
SEEDS = (1, 5, 3)
LIMIT = 10.0  # [s] of a run of the map


def scene_in(folder, seed, side, also=()):
    """Mesh and scene; the words behind the program."""
    write(str(folder / "model.h5"), voronoi_mesh(options=Options(seed=seed, side=side)))
    scene = DAM | {"stages": [*DAM["stages"], *also]}
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    return ("-options_file", "scene.yaml", "-model", "model.h5", "-output", "out", "-checkpoint_minutes", "0", "-stages", "sw")


def kept(name):
    path = DATA / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else []


def reference(name, command, folder, ramp, limit, tolerance="1e-9"):
    """Answer of explicit cycles with a long ramp (None: stopped), of this name in build/best where it was found before."""
    path = KEPT / f"{name}, ramp of {ramp}.json"
    if path.exists():
        found = json.loads(path.read_text(encoding="utf-8"))
        return found and found | {"fields": {stage: np.array(field) for stage, field in found["fields"].items()}}
    code, _, _ = run([*command, "-relaxation_method", "explicit", "-relaxation_ramp", str(ramp), "-relaxation_tolerance", tolerance, "-relaxation_velocity_tolerance", "1e-7",
                            "-relaxation_max_cycles", "1000000"], folder, limit)  # fmt: skip
    found = answer(folder, code) if code is not None else None
    KEPT.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(found, default=np.ndarray.tolist), encoding="utf-8")
    return found


# ---- error against time

def speed(program, stones, limit, again, methods):
    side, seed = SIDES[stones]
    there = {(row["stones"], row["blocks"], row["method"], row["tolerance"]) for row in kept("many_stones")} if not again else set()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        words = scene_in(folder, seed, side)
        for blocks, kind in (("rigid", RIGID), ("elastic", ())):
            if stones > 2003 and blocks == "elastic":
                continue
            names = [method for method in SLOW.get(stones, METHODS) if method in methods and (method != "Newton" or stones == 150)]
            tolerances = TOLERANCES if stones <= 2003 else TOLERANCES[::2]
            missing = [(method, tolerance) for method in names for tolerance in tolerances if (stones, blocks, method, tolerance) not in there]
            if not missing:
                continue
            command = [program, *words, *kind, *STIFF.get(stones, ())]
            right, other = (reference(f"{stones} {blocks} stones", command, folder, ramp, 5 * limit) for ramp in (10000, 1000))
            unsure = finite(error(other, right, {})) if right and other else None
            print(f"{stones} {blocks} stones: reference {right['verdict'] if right else 'stopped'}; a ramp of 1000 changes {unsure}", flush=True)
            for method, tolerance in missing:
                code, seconds, warned = run([*command, *METHODS[method][0], "-relaxation_tolerance", tolerance, "-relaxation_velocity_tolerance", tolerance], folder, limit)
                found = answer(folder, code) if code is not None else None
                row = {"stones": stones, "blocks": blocks, "method": method, "tolerance": tolerance, "seconds": seconds, "verdict": found["verdict"] if found else "stopped",
                       "ran": found["method"] if found else "", "warned": warned, "error": finite(error(found, right, {})) if found and right else None, "unsure": unsure}  # fmt: skip
                keep("many_stones", [row], ("stones", "blocks", "method", "tolerance"))
                print(", ".join(f"{value}" for value in row.values()), flush=True)


def draw_speed(rows, path):
    """A panel a size: error over processor time, a line a method, its points the tolerances."""
    sizes = [(stones, blocks) for blocks in ("rigid", "elastic") for stones in SIDES if any((row["stones"], row["blocks"]) == (stones, blocks) for row in rows)]
    columns = max(sum(blocks == kind for _, blocks in sizes) for kind in ("rigid", "elastic"))
    figure, panels = pyplot.subplots(2, columns, figsize=(3.5 * columns + 0.5, 7.2), sharey=True, constrained_layout=True, squeeze=False)
    for axes in panels.flat:
        axes.set_visible(False)
    for i, (stones, blocks) in enumerate(sizes):
        line = blocks == "elastic"
        axes = panels[int(line)][i - sum(kind == "rigid" for _, kind in sizes) if line else i]
        axes.set_visible(True)
        mine = [row for row in rows if (row["stones"], row["blocks"]) == (stones, blocks)]
        unsure = next((row["unsure"] for row in mine if row["unsure"]), None)
        if unsure:
            axes.axhspan(1e-9, 100 * unsure, color="grey", alpha=0.18)
        axes.axhline(0.5, color="black", linewidth=0.7, linestyle=":")
        for method, (_, colour) in METHODS.items():
            points = [(row["seconds"], max(100 * row["error"], 1e-6), row) for row in mine if row["method"] == method and row["error"] is not None and row["verdict"] == "converged"]
            if not points:
                continue
            over = method == "default"
            axes.plot([p[0] for p in points], [p[1] for p in points], color=colour, linewidth=1.0, linestyle="--" if over else "-", zorder=3 if over else 2)
            for seconds, off, row in points:
                size = 3 + 1.5 * TOLERANCES.index(row["tolerance"])
                axes.plot(seconds, off, "o", color=colour, markersize=size, markerfacecolor="none" if over else colour, zorder=3 if over else 2)
        low, high = min(row["seconds"] for row in mine), max(row["seconds"] for row in mine)
        low, high = 0.8 * low, max(1.3 * high, 8 * low)
        axes.set(xscale="log", yscale="log", title=f"{stones} {blocks} stones", xlabel="processor time of the process [s]", xlim=(low, high), ylim=(1e-6, 100))
        ticks = [tick for tick in TICKS if low <= tick <= high]
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.minorticks_off()
        axes.grid(alpha=0.25)
        if axes in (panels[0][0], panels[1][0]):
            axes.set_ylabel("error of displacement, over the largest [%]")
    marks = [pyplot.Line2D([], [], color=colour, marker="o", linestyle="--" if name == "default" else "-", markerfacecolor="none" if name == "default" else colour, label=name)
             for name, (_, colour) in METHODS.items() if any(row["method"] == name for row in rows)]  # fmt: skip
    marks += [pyplot.Line2D([], [], color="grey", marker="o", linestyle="none", markersize=3 + 1.5 * i, label=f"tolerance {tolerance}") for i, tolerance in enumerate(TOLERANCES) if i % 2 == 0]
    marks += [pyplot.Rectangle((0, 0), 1, 1, color="grey", alpha=0.18, label="explicit ramps of 1000 and 10 000 differ by this"),
              pyplot.Line2D([], [], color="black", linewidth=0.7, linestyle=":", label="0.5 %")]  # fmt: skip
    figure.legend(handles=marks, loc="outside lower center", ncols=max(2, columns + 1), fontsize=8)
    save_figure(figure, path, dpi=130)


# ---- map

def bound(program, folder):
    """Least friction by limit analysis [degree]."""
    done = subprocess.run([sys.executable, "-m", "quoin_tools", "limit", "scene.yaml", "--stage", "less", "-model", "model.h5"], cwd=folder, capture_output=True, text=True,
                          env=os.environ | ENVIRONMENT | {"PYTHONPATH": str(ROOT / "tools"), "QUOIN": program})  # fmt: skip
    found = re.search(r"less.*?([\d.]+)", next((line for line in done.stdout.splitlines() if "less" in line), ""))
    if not found:
        raise RuntimeError(done.stdout + done.stderr)
    return float(found[1])


def judged(row, right, unsure):
    """One word for a cell."""
    if row["verdict"] in ("undecided", "diverged", "stopped", "interrupted"):
        return "no verdict"
    if right is None or right["verdict"] not in ("converged", "collapsed"):
        return "no reference"
    if row["verdict"] != right["verdict"]:
        return "wrong verdict"
    if row["verdict"] == "collapsed":
        return "falls, right"
    if row["error"] <= max(SAME, unsure or 0.0):
        return "hands over, right" if "then" in row["ran"] else "right"
    return "another equilibrium, told" if row["warned"] else "another equilibrium, not told"


def chart(program, again, methods):
    there = {(row["seed"], row["k_n"], row["ratio"], row["friction"], row["method"]) for row in kept("stones_map")} if not again else set()
    reduced = ({"less": {"type": "strength_reduction", "loads": ["weight"], "bracket": 0.5, "limit": 5}}, )
    for seed in SEEDS:
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
                    right, other = (reference(cell, command, folder, ramp, LIMIT, "1e-8") for ramp in (10000, 1000))
                    unsure = error(other, right, {}) if right and other and right["verdict"] == other["verdict"] == "converged" else None
                    rows = []
                    for method in missing:
                        code, seconds, warned = run([*command, *METHODS[method][0]], folder, LIMIT)
                        found = answer(folder, code) if code is not None else None
                        off = error(found, right, {}) if found and right else np.nan
                        row = {"seed": seed, "k_n": k_n, "ratio": ratio, "friction": friction, "bound": least, "method": method, "seconds": seconds,
                               "verdict": found["verdict"] if found else "stopped", "ran": found["method"] if found else "", "warned": warned, "error": finite(off),
                               "right_verdict": right["verdict"] if right else "stopped", "other_verdict": other["verdict"] if other else "stopped",
                               "unsure": finite(unsure) if unsure is not None else None}  # fmt: skip
                        row["kind"] = judged(row | {"error": off}, right, unsure)
                        rows.append(row)
                    keep("stones_map", rows, ("seed", "k_n", "ratio", "friction", "method"))
                    print(f"seed {seed}, k_n {k_n:g}, k_s/k_n {ratio:g}, friction {friction}: " + "; ".join(f"{row['method']} {row['kind']} {row['seconds']:.2f} s" for row in rows), flush=True)


KINDS = {"right": "#009e73", "falls, right": "#a6d8c4", "hands over, right": "#f0e442", "another equilibrium, told": "#cc79a7", "no verdict": "#bbbbbb", "another equilibrium, not told": "#7b2d5b",
         "wrong verdict": "#d55e00", "no reference": "#ffffff"}  # fmt: skip
CHARTED = {"explicit": "#0072b2", "stiffness_mass": "#e69f00", "Newton": "#6a3d9a"}


def draw_map(rows, path):
    """Columns: a method each, and which to take; rows: seeds. Cells: friction by stiffness."""
    seeds = sorted({row["seed"] for row in rows})
    columns = [*CHARTED, "default", "take"]
    figure, panels = pyplot.subplots(len(seeds), len(columns), figsize=(15.5, 1.3 + 2.15 * len(seeds)), sharex=True, sharey=True, constrained_layout=True, squeeze=False)
    for k, (line, seed) in enumerate(zip(panels, seeds)):
        mine = {(row["k_n"], row["ratio"], row["friction"], row["method"]): row for row in rows if row["seed"] == seed}
        least = next(row["bound"] for row in mine.values())
        for axes, method in zip(line, columns):
            picture = np.ones((len(STIFFNESSES), len(FRICTIONS), 3))
            for i, (k_n, ratio) in enumerate(STIFFNESSES):
                for j, friction in enumerate(FRICTIONS):
                    if method != "take":
                        row = mine.get((k_n, ratio, friction, method))
                        if row:
                            picture[i, j] = colors.to_rgb(KINDS[row["kind"]])
                            dark = row["kind"] in ("right", "wrong verdict", "another equilibrium, not told")
                            axes.text(j, i, f"{row['seconds']:.2g}", ha="center", va="center", fontsize=6, color="white" if dark else "black")
                        continue
                    good = [row for name in CHARTED if (row := mine.get((k_n, ratio, friction, name))) and row["kind"] in ("right", "falls, right")]
                    if good:
                        best = min(good, key=lambda row: row["seconds"])
                        picture[i, j] = colors.to_rgb(CHARTED[best["method"]])
                        axes.text(j, i, f"{best['seconds']:.2g}", ha="center", va="center", fontsize=6, color="white")
            axes.imshow(picture, origin="lower", aspect="auto")
            axes.set_xticks(range(len(FRICTIONS)), FRICTIONS, fontsize=7)
            axes.set_yticks(range(len(STIFFNESSES)), [f"{k_n / 1e9:g}, {ratio:g}" for k_n, ratio in STIFFNESSES], fontsize=7)
            axes.axvline(np.searchsorted(FRICTIONS, least) - 0.5, color="black", linewidth=1.4, linestyle="--")
            if k == 0:
                axes.set_title({"take": "fastest right method"}.get(method, method), fontsize=10)
            if k == len(seeds) - 1:
                axes.set_xlabel("friction [degree]", fontsize=8)
        line[0].set_ylabel(f"seed {seed}\nk_n [GPa/m], k_s/k_n [-]", fontsize=8)
    present = {row["kind"] for row in rows}
    marks = [pyplot.Rectangle((0, 0), 1, 1, facecolor=colour, edgecolor="grey", label=kind) for kind, colour in KINDS.items() if kind in present]
    marks += [pyplot.Line2D([], [], color="black", linewidth=1.4, linestyle="--", label="limit analysis: none stands left of it")]
    marks += [pyplot.Rectangle((0, 0), 1, 1, facecolor=colour, label=f"fastest: {name}") for name, colour in CHARTED.items()]
    figure.legend(handles=marks, loc="outside lower center", ncols=5, fontsize=8, title="numbers: processor time [s]", title_fontsize=8)
    save_figure(figure, path, dpi=130)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--stones", type=int, nargs="*", choices=list(SIDES), help="error against time of these sizes alone (150, 597, 2003, and the map)")
    parser.add_argument("--limit", type=float, default=60.0, help="[s] of processor time of a run of error against time (%(default)s)")
    parser.add_argument("--map", action="store_true", help="the map alone")
    parser.add_argument("--methods", nargs="+", default=list(METHODS), choices=list(METHODS), help="these alone")
    parser.add_argument("--again", action="store_true", help="rows that are there, too")
    parser.add_argument("--draw", action="store_true", help="charts from the data")
    options = parser.parse_args()
    program = os.path.abspath(options.quoin)
    if not options.draw:
        for stones in () if options.map else (150, 597, 2003) if options.stones is None else options.stones:
            speed(program, stones, options.limit, options.again, options.methods)
        if options.map or options.stones is None:
            chart(program, options.again, options.methods)
    if kept("many_stones"):
        draw_speed(kept("many_stones"), DOCS / "img" / "many_stones.png")
    if kept("stones_map"):
        draw_map(kept("stones_map"), DOCS / "img" / "stones_map.png")


if __name__ == "__main__":
    main()
