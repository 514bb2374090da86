#!/usr/bin/env python3
"""Where damping in time is right and where a run warns: alpha, beta and dt_factor of a cantilever, beta and dt_factor of a block that slides.

    PYTHONPATH=tools python tests/benchmark/damping.py --quoin build/quoin

The truth is the same scene with 0.02 of the stability bound; the error is that of the top's way over its largest displacement (cantilever), of
the largest displacement of the crest (sliding block). A cell is right with an error up to 5 %, reported where a run warns, diverges or refuses, and lies
otherwise. Writes docs/data/damping_stability.csv and docs/img/damping_stability.png. Exit code 1: a cell lies."""

import argparse
import csv
import os
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
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools")]

from driver import ENVIRONMENT, VERDICTS  # noqa: E402
from quoin_tools.base.files import save_figure  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.meshing import join, rectangle, renamed  # noqa: E402

LIE = 0.05
COLOURS = {"right": "#2a9d5c", "told": "#c9ced6", "lies": "#d62828"}
FINE = "0.02"
CANTILEVER = {"model": "m.h5", "materials": {"ground": {"density": 2000, "young": 1e9, "poisson": 0.2}}, "supports": {"bottom": {"fix": "xy"}},
              "joints": {"default": {"law": "elastic", "k_n": 1e9, "k_s": 1e9}}, "relaxation": {"history_every": 1, "tolerance": 1e-8},
              "loads": {"side": {"type": "traction", "faces": "right", "value": [1e4, 0]}},
              "stages": [{"pull": {"loads": ["side"]}}, {"swing": {"type": "dynamic", "loads": [], "duration": 0.5}}]}  # fmt: skip
SLIDER = {"model": "m.h5", "materials": {"table": {"density": 2400}, "block": {"density": 2400, "young": 5e9, "poisson": 0.2}},
          "supports": {"table": {"fix": "xy", "motion": "quake.csv", "quantity": "acceleration"}}, "relaxation": {"history_every": 10, "tolerance": 1e-8},
          "joints": {"default": {"stress_model": "tptm", "k_n": 1e10, "k_s": 4e9, "friction": 30}}, "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
          "stages": [{"rest": {"loads": ["weight"]}}, {"swing": {"type": "dynamic", "loads": ["weight"], "duration": 1.5}}]}  # fmt: skip


class Maps:
    def __init__(self, quoin, folder):
        self.quoin, self.folder, self.rows, self.runs = quoin, Path(folder), [], 0

    def run(self, scene, mesh, options):
        """Verdict, evidence, history of the last stage."""
        self.runs += 1
        place = self.folder / f"{self.runs:03d}"
        place.mkdir()
        write(str(place / "m.h5"), mesh)
        (place / "s.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
        t = np.linspace(0, 1.5, 301)
        a = 0.5 * 9.81 * np.sin(np.pi * t / 1.5) ** 2 * np.sin(2 * np.pi * 2 * t)
        (place / "quake.csv").write_text("".join(f"{x:.9g}, {y:.17g}, 0\n" for x, y in zip(t, a, strict=True)))
        words = [self.quoin, "-options_file", "s.yaml", "-checkpoint_minutes", "0", *(w for k, v in options.items() for w in (f"-stages_swing_{k}", f"{v}"))]
        done = subprocess.run(words, cwd=place, env=ENVIRONMENT | dict(os.environ), capture_output=True, text=True)
        verdict = VERDICTS.get(done.returncode, "failed")
        evidence = next((line for line in (done.stdout + done.stderr).splitlines() if "warning" in line or "error" in line), "")
        if verdict != "converged":
            return verdict, evidence, None, 0
        results = Results(str(place / "out"))
        mine = results.history["stage"] == "swing"
        h = {name: column[mine] for name, column in results.history.items() if name != "stage"}
        return "warned" if evidence else "completed", evidence, h, results.stage_summary("swing")["cycles"]

    def cell(self, title, row, x, scene, mesh, options, error):
        right = self.truth(scene, mesh, options)
        verdict, evidence, h, steps = self.run(scene, mesh, options)
        off = error(h, right) if h is not None and right is not None else np.nan
        kind = "told" if verdict != "completed" else "right" if off <= LIE else "lies"
        self.rows.append({"map": title, "row": row, "dt_factor": x, "verdict": verdict, "kind": kind, "error": f"{off:.4g}", "steps": steps, "evidence": evidence})

    def truth(self, scene, mesh, options):
        key = str([scene, {k: v for k, v in options.items() if k != "dt_factor"}])
        self.known = getattr(self, "known", {})
        if key not in self.known:
            self.known[key] = self.run(scene, mesh, options | {"dt_factor": FINE})[2]
        return self.known[key]


def way(h, right):
    """Largest difference of the top's displacement at the same times."""
    t, u = right["time_s"], right["top_left_ux_m"]
    return abs(np.interp(h["time_s"], t, u) - h["top_left_ux_m"])[h["time_s"] <= t[-1]].max() / abs(u).max()


def crest(h, right):
    tops = [abs(x["crest_ux_m"] - x["ground_ux_m"]).max() for x in (h, right)]
    return abs(tops[0] / tops[1] - 1)


def cantilever(maps):
    mesh, dt_0 = rectangle(0, 0, 1, 8, 2, 16, group="ground"), 4e-4  # the bound without beta, about
    factors = [0.05, 0.3, 0.9, 1.0, "auto"]
    for beta in (0.0, 0.1, 1.0, 10.0, 100.0):
        for x in factors:
            maps.cell("cantilever: beta", f"beta = {beta:g} dt_0", x, CANTILEVER, mesh, {"beta": beta * dt_0, "dt_factor": x}, way)
    for alpha in (1.0, 100.0, 10000.0):
        for x in factors:
            maps.cell("cantilever: alpha", f"alpha = {alpha:g} 1/s", x, CANTILEVER, mesh, {"alpha": alpha, "dt_factor": x}, way)


def slider(maps):
    table = renamed(rectangle(-4, -1, 14, 1, group="table", rigid=True), {}, {"ground": "top_left"})
    mesh = join([table, renamed(rectangle(0, 0, 4, 8, 4, 8, group="block"), {}, {"crest": "top_left"})])
    for beta in (0.0, 2e-5, 1e-4, 1e-3):
        for x in (0.05, 0.3, 0.9, "auto"):
            maps.cell("block that slides: beta", f"beta = {beta:g} s", x, SLIDER, mesh, {"beta": beta, "dt_factor": x}, crest)


def draw(rows, path):
    titles = list(dict.fromkeys(row["map"] for row in rows))
    figure, panels = pyplot.subplots(1, len(titles), figsize=(4.6 * len(titles), 3.2), constrained_layout=True)
    for axes, title in zip(panels, titles, strict=True):
        mine = [row for row in rows if row["map"] == title]
        xs, names = list(dict.fromkeys(row["dt_factor"] for row in mine)), list(dict.fromkeys(row["row"] for row in mine))
        grid = np.zeros((len(names), len(xs)))
        for row in mine:
            i, j = names.index(row["row"]), xs.index(row["dt_factor"])
            grid[i, j] = list(COLOURS).index(row["kind"])
            text = f"{100 * float(row['error']):.2g}" + (" w" if row["verdict"] == "warned" else "") if row["error"] != "nan" else row["verdict"]
            axes.text(j, i, text, ha="center", va="center", fontsize=8, color="black" if row["kind"] == "told" else "white")
        axes.imshow(grid, cmap=colors.ListedColormap(list(COLOURS.values())), vmin=-0.5, vmax=2.5, aspect="auto")
        axes.set_xticks(range(len(xs)), [str(x) for x in xs], fontsize=8)
        axes.set_yticks(range(len(names)), names, fontsize=8)
        axes.set(title=title, xlabel="dt_factor [-]")
    figure.suptitle("error in %; w: with a warning; green: right, grey: told, red: neither", fontsize=9)
    save_figure(figure, path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        maps = Maps(os.path.abspath(options.quoin), folder)
        cantilever(maps)
        slider(maps)
    with open(ROOT / "docs" / "data" / "damping_stability.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, maps.rows[0].keys())
        writer.writeheader()
        writer.writerows(maps.rows)
    draw(maps.rows, ROOT / "docs" / "img" / "damping_stability.png")
    lies = [row for row in maps.rows if row["kind"] == "lies"]
    for row in lies:
        print(f"lies: {row['map']}, {row['row']}, dt_factor {row['dt_factor']}: error {100 * float(row['error']):.3g} %")
    print(f"{len(maps.rows)} cells, {len(lies)} lie")
    return 1 if lies else 0


if __name__ == "__main__":
    sys.exit(main())
