#!/usr/bin/env python3
"""Where each method diverges or lies: time step, stiffness of joints, shape of blocks, damping, ramp, stress model, strain.

    PYTHONPATH=tools python tests/benchmark/stability.py --quoin build/quoin --limits build/tests/bench_stability

Lines: omega dt / 2 at the time step that the bounds of the stiffness allow, ours and the paper's (29), in a column of four
blocks with elastic joints; above 1, the limit of the scheme, motions grow. Maps: the dam of Fig. 6 on a joint with friction
29 degrees, 12 blocks along the base, at the tolerance 1e-6 of a scene that gives none. The error is the larger of that of the
crest displacement and of the normal forces along the joint, over their sum, against Newton's method in 8 increments to 1e-9.
It lies where it says converged, without a warning, with an error above 5 %. Last map: a rocking block in time, error of the way
of its corner against 1/500 of the stability bound; with a warning in what it prints, it is warned of.
Writes docs/img/stability.png and docs/data/stability.csv, and names every cell that lies. Exit code 1: some do."""

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import numpy as np
import yaml
from matplotlib import colors, pyplot

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools"), str(ROOT / "examples" / "fig6")]

from driver import ENVIRONMENT, MODELS, VERDICTS  # noqa: E402
from quoin_tools.base.files import save_figure  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.meshing import join, rectangle, renamed  # noqa: E402
from quoin_tools.mesh.stacks import column  # noqa: E402
from triangle_dam import triangle_dam  # noqa: E402

LIE = 0.05
N, BASE, YOUNG, HEIGHT = 12, 80.0, 30e9, 100.0  # of the dam: columns, width [m], [Pa], height [m]
SIZE = BASE / N
METHODS = {"adaptive": (), "paper": ("-relaxation_damping", "paper"), "preconditioned": ("-relaxation_method", "preconditioned")}
REFERENCE = ("-relaxation_method", "preconditioned", "-relaxation_increments", "8", "-relaxation_tolerance", "1e-9")
JOINT = {"law": "mohr_coulomb", "friction": "29", "k_n": f"{YOUNG / SIZE:g}", "k_s": f"{YOUNG / SIZE / 3:g}", "stress_model": "tptm"}
ROWS = [f"{model}, {strain}" for strain in ("small", "large") for model in MODELS]
WORDS = {"converged": "right", "lies": "converged, error > 5 %", "told": "told: warning, diverged, undecided, refused, collapsed"}


def flags(section, values):
    return [word for key, value in values.items() for word in (f"-{section}_{key}", f"{value}")]


def joint(**changes):
    return flags("joints_base", JOINT | changes)


def stretched(aspect):
    """The dam with blocks `aspect` times as wide as high, or as high as wide."""
    mesh = triangle_dam(N, "M")
    mesh.vertices = mesh.vertices * [1.0, 1.0 / aspect]
    return mesh


class Maps:
    def __init__(self, quoin, limits, folder):
        self.quoin, self.limits, self.folder, self.rows = quoin, limits, folder, []
        self.answers = {}

    def mesh(self, name, mesh):
        path = os.path.join(self.folder, name + ".h5")
        if not os.path.exists(path):
            write(path, mesh)
        return path

    def run(self, scene, mesh, options, number):
        """Verdict in words, crest displacement, normal forces of the contacts."""
        out = os.path.join(self.folder, f"out{number}")
        command = [self.quoin, "-options_file", scene, "-model", mesh, "-output", out, "-checkpoint_minutes", "0", "-relaxation_method", "explicit", *options]
        done = subprocess.run(command, cwd=ROOT, env=ENVIRONMENT | dict(os.environ), capture_output=True, text=True)
        verdict = VERDICTS.get(done.returncode, "failed")
        if verdict != "converged":
            return verdict, None
        if "warning" in done.stdout + done.stderr:
            verdict = "warned"
        results = Results(out)
        stage = results.stages[-1]
        probe = results.stage_summary(stage)["probes"]
        point = probe.get("crest") or probe["mark"]
        contacts = results.stage(stage).contacts
        force = np.zeros((0, 2)) if contacts is None else np.asarray(contacts.force)[:, :, 0].sum(axis=1)
        return verdict, (np.array([point["u_x"], point["u_y"]]), force)

    def map(self, title, x_name, xs, rows, cells, truth):
        """cells: {(row, x): (scene, mesh, options)}; truth: the same for what is right."""
        keys = [(row, x) for row in rows for x in xs]
        with ThreadPoolExecutor(2) as pool:
            jobs = list({tuple(map(str, truth[key])): truth[key] for key in keys}.items())
            missing = [(name, job) for name, job in jobs if name not in self.answers]
            start = len(self.answers) + 10000
            found = pool.map(lambda item: self.run(*item[1][1], start + item[0]), enumerate(missing))
            self.answers.update({name: answer for (name, _), (_, answer) in zip(missing, found)})
            ours = list(pool.map(lambda item: self.run(*cells[item[1]], len(self.rows) + item[0]), enumerate(keys)))
        for key, (verdict, answer) in zip(keys, ours):
            right = self.answers[tuple(map(str, truth[key]))]
            error = difference(answer, right) if answer and right else np.nan
            kind = "told" if verdict != "converged" else "lies" if not error <= LIE else "converged"
            self.rows.append({"map": title, "x": x_name, "value": key[1], "row": key[0], "verdict": verdict, "kind": kind, "error": error})
        print(f"{title}: {sum(row['kind'] == 'lies' for row in self.rows if row['map'] == title)} of {len(keys)} lie", flush=True)

    def bounds(self, title, x_name, cases):
        """cases: [(x, line, mesh, options)]; the scene is a column of four blocks."""
        scene = os.path.join(self.folder, "column.yaml")
        with open(scene, "w", encoding="utf-8") as file:
            yaml.safe_dump(COLUMN, file)
        for x, line, mesh, options in cases:
            done = subprocess.run([self.limits, scene, "-model", mesh, *options], cwd=ROOT, env=ENVIRONMENT | dict(os.environ),
                                  capture_output=True, text=True, check=True)  # fmt: skip
            for which, half in json.loads(done.stdout).items():
                kind = "converged" if half <= 1 else "diverges"
                self.rows.append({"map": title, "x": x_name, "value": x, "row": f"{which}, {line}", "verdict": "", "kind": kind, "error": half})


def difference(answer, right):
    """Of displacements and of forces, each over the largest, or over the sum."""
    (u, force), (u_right, force_right) = answer, right
    errors = [np.linalg.norm(u - u_right) / np.linalg.norm(u_right)]
    if len(force_right):
        size = np.abs(force_right).sum() or 1.0  # a corner in the air
        errors.append(np.abs(force - force_right).sum() / size if len(force) == len(force_right) else np.inf)
    return max(errors)


COLUMN = {"model": "m.h5", "strain": "small", "supports": {"base": {"fix": "xy"}}, "loads": {"weight": {"type": "self_weight"}},
          "materials": {"block": {"density": 2400, "young": YOUNG, "poisson": 0.2}, "base": {"density": 2400, "rigid": True}},
          "joints": {"default": {"law": "elastic", "k_n": 1e10, "k_s": 1e10}}, "stages": [{"weight": {"loads": ["weight"]}}]}  # fmt: skip
ROCK = {"model": "m.h5", "supports": {"base": {"fix": "xy"}}, "contact": {"connectivity": "variable", "tolerance": 0.005},
        "relaxation": {"allow_floating": True, "history_every": 1000},
        "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
        "materials": {"block": {"density": 2400, "rigid": True}, "base": {"density": 2400, "rigid": True}},
        "joints": {"default": {"k_n": 1e8, "k_s": 1e8, "friction": 75}},
        "stages": [{"rock": {"type": "dynamic", "loads": ["weight"], "duration": 0.9}}]}  # fmt: skip


def leaning_mesh(width=0.5, height=2.0):
    lean = np.arctan(width / height) / 3
    c, s = np.cos(lean), np.sin(lean)
    block = rectangle(0, 0, width, height, group="block", rigid=True)
    block.vertices = (block.vertices - [width, 0]) @ np.array([[c, -s], [s, c]]) + [width, 0]
    base = renamed(rectangle(-2, -1, 4, 1, group="base", rigid=True), {})
    return join([base, renamed(block, {"top": "top"}, {"mark": "top_left"})])


def limits(maps):
    stiffness = [10.0**p for p in (-3, -2, -1, 0, 1, 2, 3)]
    shapes = [1, 3, 10, 30, 100]
    cases = []
    for ratio in (0.0, 0.3, 1.0):
        for rigid in (True, False):
            line = f"k_s/k_n = {ratio:g}, {'rigid' if rigid else 'deformable'}"
            path = maps.mesh(f"column_{rigid}", column(4, rigid=rigid))
            cases += [(x, line, path, flags("joints_default", {"k_n": x * YOUNG, "k_s": ratio * x * YOUNG})) for x in stiffness]
    maps.bounds("time step over joint stiffness", "k_n h / E [-]", cases)
    cases = []
    for ratio in (0.0, 1.0):
        for rigid in (True, False):
            line = f"k_s/k_n = {ratio:g}, {'rigid' if rigid else 'deformable'}"
            for x in shapes:
                path = maps.mesh(f"column_{rigid}_{x}", column(4, height=1.0 / x, rigid=rigid))
                cases.append((x, line, path, flags("joints_default", {"k_n": YOUNG * x, "k_s": ratio * YOUNG * x})))
    maps.bounds("time step over shape of blocks", "width over height of a block [-]", cases)


def statics(maps):
    scene, dam = str(ROOT / "examples" / "fig6" / "scene.yaml"), maps.mesh("dam", triangle_dam(N, "M"))
    common = ["-relaxation_tolerance", "1e-6", "-relaxation_max_cycles", "100000"]

    def both(rows, xs, options, mesh=lambda x: dam, right=lambda row, x: None):
        """Cells, and the same physics by the reference: options(row, x) -> (physics, method)."""
        cells = {(row, x): (scene, mesh(x), [*common, *options(row, x)[0], *options(row, x)[1]]) for row in rows for x in xs}
        truth = {(row, x): (scene, mesh(x), [*options(row, x)[0], *REFERENCE]) for row in rows for x in xs}
        return cells, truth

    methods = [f"{method}, {strain}" for strain in ("small", "large") for method in METHODS]

    def by_method(physics):
        return lambda row, x: ([*physics(x), "-strain", row.split(", ")[1]], METHODS[row.split(", ")[0]])

    xs = [10.0**p for p in (-3, -2, -1, 0, 1, 2, 3)]
    physics = by_method(lambda x: joint(k_n=x * YOUNG / SIZE, k_s=x * YOUNG / SIZE / 3))
    maps.map("joint stiffness", "k_n h / E [-]", xs, methods, *both(methods, xs, physics))
    xs = [0.001, 0.01, 0.1, 0.3, 1, 3, 10]
    maps.map("shear stiffness", "k_s / k_n [-]", xs, methods, *both(methods, xs, by_method(lambda x: joint(k_s=x * YOUNG / SIZE))))
    xs = [0.3, 1, 3, 10, 30, 100]
    meshes = {x: maps.mesh(f"dam_{x}", stretched(x)) for x in xs}
    physics = by_method(lambda x: [*joint(), "-loads_water_level", f"{HEIGHT / x:g}"])
    maps.map("shape of blocks", "width over height, that of Fig. 6: 1 [-]", xs, methods, *both(methods, xs, physics, meshes.get))
    xs = [0.5, 0.8, 0.9, 1.0]
    physics = lambda row, x: ([*joint(), "-strain", row.split(", ")[1]], [*METHODS[row.split(", ")[0]], "-relaxation_safety", f"{x}"])  # noqa: E731
    maps.map("time step", "time step over our bound [-]", xs, methods, *both(methods, xs, physics))
    xs = [0.0, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0]
    physics = lambda row, x: (joint(stress_model=row.split(", ")[0]) + ["-strain", row.split(", ")[1]],  # noqa: E731
                              ["-relaxation_damping", "fixed", "-relaxation_alpha_dt", f"{x}"])  # fmt: skip
    maps.map("fixed damping", "alpha dt [-]", xs, ROWS, *both(ROWS, xs, physics))
    xs = [0, 10, 100, 1000, 10000]
    physics = lambda row, x: (joint(stress_model=row.split(", ")[0]) + ["-strain", row.split(", ")[1]], ["-relaxation_ramp", f"{x}"])  # noqa: E731
    maps.map("loading rate", "ramp [cycles]", xs, ROWS, *both(ROWS, xs, physics))


def dynamics(maps):
    scene, mesh = os.path.join(maps.folder, "rock.yaml"), maps.mesh("rock", leaning_mesh())
    with open(scene, "w", encoding="utf-8") as file:
        yaml.safe_dump(ROCK, file)
    xs = [0.02, 0.05, 0.1, 0.3, 1.0]
    cells = {(row, x): (scene, mesh, ["-joints_default_stress_model", row, "-stages_rock_dt_factor", f"{x}"]) for row in MODELS for x in xs}
    truth = {key: (scene, mesh, ["-joints_default_stress_model", key[0], "-stages_rock_dt_factor", "0.002"]) for key in cells}
    maps.map("in time", "time step over our bound [-]", xs, list(MODELS), cells, truth)


# ---- the picture

COLOURS = {"converged": "#2a9d5c", "told": "#c9ced6", "lies": "#d62828"}


def draw_lines(axes, rows):
    lines = dict.fromkeys(row["row"] for row in rows)
    ratios = dict(zip(("0", "0.3", "1"), ("-", "--", ":")))
    for line in lines:
        which, rest = line.split(", ", 1)
        mine = [(row["value"], row["error"]) for row in rows if row["row"] == line]
        axes.plot(*zip(*mine), color="#0072b2" if which == "ours" else "#d55e00", linestyle=ratios[rest.split(",")[0].split("= ")[1]],
                  marker="s" if "rigid" in rest else "o", markersize=3.5, linewidth=1, label=None)  # fmt: skip
    axes.axhline(1, color="black", linewidth=1.6)
    axes.text(0.02, 1.012, "limit of the scheme: omega dt = 2", transform=axes.get_yaxis_transform(), fontsize=7, va="bottom")
    axes.set(xscale="log", ylabel="omega dt / 2 at the bound's time step [-]", ylim=(0.8, 1.75))
    key = [pyplot.Line2D([], [], color=colour, label=label) for colour, label in (("#0072b2", "ours"), ("#d55e00", "paper, (29)"))]
    key += [pyplot.Line2D([], [], color="grey", linestyle=style, label=f"k_s / k_n = {ratio}") for ratio, style in ratios.items()]
    key += [pyplot.Line2D([], [], color="grey", marker=mark, linestyle="none", markersize=4, label=label) for mark, label in (("s", "rigid"), ("o", "deformable"))]
    axes.legend(handles=key, fontsize=6.5, loc="upper left", ncol=2, bbox_to_anchor=(0, 0.98))
    axes.grid(alpha=0.3)


def draw_map(axes, rows):
    xs, names = list(dict.fromkeys(row["value"] for row in rows)), list(dict.fromkeys(row["row"] for row in rows))
    kinds = list(COLOURS)
    grid = np.zeros((len(names), len(xs)))
    for row in rows:
        i, j = names.index(row["row"]), xs.index(row["value"])
        grid[i, j] = kinds.index(row["kind"])
        text = f"{100 * row['error']:.2g}" if np.isfinite(row["error"]) else {"undecided": "und.", "bad input": "ref.", "diverged": "div.", "collapsed": "coll."}.get(row["verdict"], "?")
        axes.text(j, i, text + (" w" if row["verdict"] == "warned" else ""), ha="center", va="center", fontsize=6.5,
                  color="white" if row["kind"] != "told" else "black")  # fmt: skip
    axes.imshow(grid, cmap=colors.ListedColormap(list(COLOURS.values())), vmin=-0.5, vmax=2.5, aspect="auto")
    axes.set_xticks(range(len(xs)), [f"{x:g}" for x in xs], fontsize=7)
    axes.set_yticks(range(len(names)), names, fontsize=7)


def draw(rows, path):
    titles = list(dict.fromkeys(row["map"] for row in rows))
    figure, panels = pyplot.subplots(3, 3, figsize=(16, 13.5), constrained_layout=True)
    for axes, title in zip(panels.flat, titles):
        mine = [row for row in rows if row["map"] == title]
        (draw_lines if mine[0]["verdict"] == "" else draw_map)(axes, mine)
        axes.set(title=title, xlabel=mine[0]["x"])
    for axes in panels.flat[len(titles) :]:
        axes.remove()
    handles = [pyplot.Rectangle((0, 0), 1, 1, color=COLOURS[kind], label=WORDS[kind]) for kind in COLOURS]
    figure.legend(handles=handles, loc="outside lower center", ncol=3, fontsize=9, title="in the maps: error in %, w: with a warning", title_fontsize=9)
    save_figure(figure, path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--limits", default=str(ROOT / "build" / "tests" / "bench_stability"))
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        maps = Maps(os.path.abspath(options.quoin), os.path.abspath(options.limits), folder)
        limits(maps)
        statics(maps)
        dynamics(maps)
    with open(ROOT / "docs" / "data" / "stability.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, maps.rows[0].keys())
        writer.writeheader()
        writer.writerows({key: f"{value:.6g}" if isinstance(value, float) else value for key, value in row.items()} for row in maps.rows)
    draw(maps.rows, ROOT / "docs" / "img" / "stability.png")
    lies = [row for row in maps.rows if row["kind"] == "lies"]
    for row in lies:
        print(f"lies: {row['map']}, {row['row']}, {row['x']} = {row['value']:g}: error {100 * row['error']:.3g} %")
    return 1 if lies else 0


if __name__ == "__main__":
    sys.exit(main())
