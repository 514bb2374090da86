#!/usr/bin/env python3
"""Error against time: stress models, meshes, blocks, solvers, damping, strain measures, connectivity, rigid, condensed or not.

    PYTHONPATH=tools python tests/benchmark/accuracy.py --quoin build/quoin

Three cases: the dam of Fig. 6 with an elastic and with a frictional base joint, and the Guilhofrei section G1 under
self-weight and full reservoir. Error: the larger of the relative errors of crest displacement and of the normal stress
at the toe, which is the mean over the last eighth of the base: at the corner itself it grows with the logarithm of the
mesh (Fig. 6: 0.519, 0.517, 0.513, 0.509 MPa with 32 to 256 blocks along the base). Reference: tptm, extrapolated.
Time: seconds that the summary of a run on one rank says its stages took, and the factors of condensed bodies; reading, set-up
and writing do not count; the least of at least three runs, more where they are short. Nothing else may run meanwhile.
The last panel is of motion in time: data of motion.py, error of the largest displacement of the crest.
Writes docs/img/accuracy.png, docs/data/accuracy.csv and the tables of docs/generated/benchmarks.md between its marks."""

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import numpy as np
from matplotlib import pyplot

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools"), str(ROOT / "tests" / "benchmark"), str(ROOT / "examples" / "fig6")]

from driver import ENVIRONMENT, MODELS  # noqa: E402
from quoin_tools.base.files import save_figure  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.dam import dam_mesh  # noqa: E402
from record import DATA, DOCS, replace_between, table  # noqa: E402
from triangle_dam import triangle_dam  # noqa: E402

NEWTON = ("-relaxation_method", "preconditioned")
PAPER = ("-relaxation_damping", "paper")
# name: (scene, mesh of n blocks along the base, sizes, size of the reference, what every run of the case adds, last stage)
# explicit runs take the sizes but the last one, those of other stress models than tptm but the last two
CASES = {
    "Fig. 6, elastic joint": ("fig6", lambda n: triangle_dam(n, "M"), (4, 8, 16, 32, 64, 128), 256, (), "full"),
    "Fig. 6, friction 45 degrees": ("fig6", lambda n: triangle_dam(n, "M"), (4, 8, 16, 32, 64, 128), 256,
                                    ("-joints_base_law", "mohr_coulomb", "-joints_base_friction", "45"), "full"),
    "Guilhofrei G1, self-weight and reservoir": ("guilhofrei", lambda n: dam_mesh(columns=n), (6, 12, 24, 48, 96), 192, (), "swhp"),
}  # fmt: skip
# name: (options, stress models)
VARIANTS = {
    "explicit": ((), MODELS),
    "explicit, damping of the paper": (PAPER, ("tptm",)),
    "explicit, other strain measure": (("-strain", "other"), ("tptm",)),
    "explicit, variable connectivity": (("-contact_connectivity", "variable", "-strain", "large"), ("tptm",)),
    "preconditioned": (NEWTON, MODELS),
    "preconditioned, bending blocks": ((*NEWTON, "-materials_*_element", "bending"), ("tptm",)),
    "preconditioned, reduced blocks": ((*NEWTON, "-materials_*_element", "reduced"), ("tptm",)),
    "preconditioned, condensed": ((*NEWTON, "-materials_*_condensed", "true"), ("tptm",)),
    "explicit, condensed": (("-materials_*_condensed", "true"), ("tptm",)),
    "preconditioned, rigid dam": ((*NEWTON, "-materials_dam_rigid", "true"), ("tptm",)),
}
GROUPS = {"fig6": ("dam",), "guilhofrei": ("dam", "rock")}  # that a * in an option stands for
CREST = {"fig6": "crest", "guilhofrei": "crest_upstream"}
SHORT = 0.1  # [s] such runs are repeated four times as often
STRAIN = {"fig6": "large", "guilhofrei": "small"}  # the one the scene does not use


def run(command, folder):
    """Seconds of the stages and of the factors of condensed bodies, and the process."""
    done = subprocess.run(command, cwd=folder, env=ENVIRONMENT | dict(os.environ), capture_output=True, text=True)
    if done.returncode:
        return None, done
    summary = json.loads(Path(folder, "out", "summary.json").read_text(encoding="utf-8"))
    return sum(stage["wall_s"] for stage in summary["stages"]) + summary.get("condensed", {}).get("factor_wall_s", 0.0), done


def toe_stress(distance, sigma):
    """Mean over the last eighth of the base; stress runs linearly between the ends of a contact."""
    start, long = distance.max() * 7 / 8, distance[:, 1] > distance[:, 0]  # a vertex on a face has no length
    distance, sigma = distance[long], sigma[long]
    a, b = np.maximum(distance, start).T
    slope = (sigma[:, 1] - sigma[:, 0]) / (distance[:, 1] - distance[:, 0])
    middle = sigma[:, 0] + slope * ((a + b) / 2 - distance[:, 0])
    return np.sum((b - a) * middle) / np.sum(b - a)


def for_scene(scene, options):
    """-materials_*_key value for every group; "other": the other strain measure."""
    words = []
    for word, value in zip(options[::2], options[1::2]):
        for group in GROUPS[scene] if "*" in word else ("",):
            words += [word.replace("*", group), STRAIN[scene] if value == "other" else value]
    return words


def is_charted(variant, model, n, sizes):
    """The explicit loop on the finest meshes takes minutes and says nothing new."""
    if not variant.startswith("explicit") or "condensed" in variant:
        return True
    return n <= sizes[-2] if (variant, model) == ("explicit", "tptm") else n <= sizes[-3]


def solve(quoin, case, n, model, options, repeats, tolerance="1e-7"):
    """Toe stress [Pa], crest displacement [m], seconds; None where the run does not converge."""
    scene, mesh, _, _, extra, stage = CASES[case]
    options = for_scene(scene, options)
    with tempfile.TemporaryDirectory() as folder:
        write(os.path.join(folder, "model.h5"), mesh(n))
        command = [quoin, "-options_file", str(ROOT / "examples" / scene / "scene.yaml"), "-model", "model.h5", "-output", "out",
                   "-joints_base_stress_model", model, "-relaxation_tolerance", tolerance, *extra, "-relaxation_method", "explicit", *options]  # fmt: skip
        seconds, done = run(command, folder)
        if done.returncode:
            print(f"  {case}, n = {n}, {model} {' '.join(options)}: exit code {done.returncode} {done.stderr[:200]}", file=sys.stderr)
            return None
        results = Results(os.path.join(folder, "out"))
        toe, crest = toe_stress(*results.joint_profile(stage, "base")[:2]), results.stage_summary(stage)["probes"][CREST[scene]]["u_x"]
        for _ in range(repeats - 1 if seconds > SHORT else 4 * repeats - 1):
            seconds = min(seconds, run(command, folder)[0])
        return toe, crest, seconds


def reference(quoin, case):
    """Toe stress and crest displacement of tptm, extrapolated: order from three meshes, each twice as fine."""
    finest = CASES[case][3]
    values = [np.array(solve(quoin, case, n, "tptm", NEWTON, 1, "1e-9")[:2]) for n in (finest // 4, finest // 2, finest)]
    ratio = np.clip((values[1] - values[0]) / np.where(values[2] == values[1], 1, values[2] - values[1]), 1.5, 16)
    return values[2] + (values[2] - values[1]) / (ratio - 1)


def measure(quoin, repeats, cases):
    rows = []
    for case in cases:
        exact = reference(quoin, case)
        print(f"{case}: toe {exact[0] * 1e-6:.4f} MPa, crest {exact[1] * 1e3:.4f} mm", flush=True)
        for variant, (options, models) in VARIANTS.items():
            for model in models:
                for n in CASES[case][2]:
                    if not is_charted(variant, model, n, CASES[case][2]):
                        continue
                    found = solve(quoin, case, n, model, options, repeats)
                    if found is None:
                        continue
                    errors = np.abs(np.array(found[:2]) / exact - 1)
                    rows.append({"case": case, "variant": variant, "model": model, "n": n, "toe_error": errors[0],
                                 "crest_error": errors[1], "error": max(errors), "seconds": found[2]})  # fmt: skip
                    print(f"  {variant}, {model}, {n}: error {100 * max(errors):.3g} %, {found[2]:.3g} s", flush=True)
    return rows


def front(rows):
    """Rows that no other beats in both error and time, from the fastest on."""
    best, least = [], np.inf
    for row in sorted(rows, key=lambda row: (row["seconds"], row["error"])):
        if row["error"] < least:
            best.append(row)
            least = row["error"]
    return best


COLOURS = {"explicit": "#0072b2", "explicit, damping of the paper": "#e69f00", "explicit, other strain measure": "#56b4e9",
           "explicit, variable connectivity": "#009e73", "explicit, condensed": "#111111", "preconditioned": "#d55e00",
           "preconditioned, bending blocks": "#cc79a7", "preconditioned, reduced blocks": "#8c6d31",
           "preconditioned, condensed": "#6a3d9a", "preconditioned, rigid dam": "#777777"}  # fmt: skip
MARKS = dict(zip(MODELS, "ovs^<D"))


def draw_motion(axes):
    """Motion in time, from the data of motion.py: step over step on each mesh; the same model by OpenSees."""
    with open(DATA / "motion.csv", newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if float(row["crest_error"]) > 0]
    lines = {("slip", "Quoin"): ("o-", "base slips, {} columns"), ("condensed", "Quoin, to 30 Hz"): ("D", "base slips, beta, condensed to 30 Hz, {} columns"),
             ("condensed", "Quoin, to 60 Hz"): ("d", "the same to 60 Hz"), ("race", "Quoin"): ("s", "elastic joint, {} columns"),
             ("race", "OpenSees, BandSPD"): ("^:", "OpenSees, elastic joint, {} columns")}  # fmt: skip
    for (part, solver), (mark, words) in lines.items():
        mine = [row for row in rows if (row["part"], row["solver"]) == (part, solver)]
        for columns in sorted({float(row["columns"]) for row in mine}):
            line = [(float(row["cpu_s"]), 100 * float(row["crest_error"])) for row in mine if float(row["columns"]) == columns]
            axes.plot(*zip(*line), mark, markersize=4, linewidth=0.8, label=words.format(f"{columns:g}"))
    mesh = [100 * float(row["crest_error"]) for row in rows if row["part"] == "slip, mesh"]
    if mesh:
        axes.axhspan(min(mesh), max(mesh), color="grey", alpha=0.2, label="error of these meshes")
    axes.set(xscale="log", yscale="log", title="Motion in time: G1, 20 s of record", xlabel="processor time, one rank [s]")
    axes.grid(alpha=0.3, which="both")
    axes.legend(fontsize=7, loc="lower left")


def draw(rows, path):
    cases = list(dict.fromkeys(row["case"] for row in rows))
    figure, panels = pyplot.subplots(1, len(cases) + 1, figsize=(5.2 * (len(cases) + 1), 5.4), sharey=True, constrained_layout=True, squeeze=False)
    draw_motion(panels[0][-1])
    panels = panels[:, :-1]
    for axes, case in zip(panels[0], cases):
        mine = [row for row in rows if row["case"] == case]
        for variant, colour in COLOURS.items():
            for model in MODELS:
                line = [(row["seconds"], 100 * row["error"]) for row in mine if (row["variant"], row["model"]) == (variant, model)]
                if line:
                    axes.plot(*zip(*line), color=colour, marker=MARKS[model], markersize=4, linewidth=0.6,
                              label=variant if model == "tptm" else None)  # fmt: skip
        best = front(mine)
        axes.plot([row["seconds"] for row in best], [100 * row["error"] for row in best], color="black", linewidth=2.2, alpha=0.35,
                  drawstyle="steps-post", label="best of all")  # fmt: skip
        axes.set(xscale="log", yscale="log", title=case, xlabel="time of the solution, one rank [s]")
        axes.grid(alpha=0.3, which="both")
    panels[0][0].set_ylabel("error of toe stress and crest displacement, the larger [%]")
    first = panels[0][0].legend(fontsize=7, loc="upper right", bbox_to_anchor=(1, 0.93))
    panels[0][0].add_artist(first)
    marks = [pyplot.Line2D([], [], color="grey", marker=mark, linestyle="none", label=model) for model, mark in MARKS.items()]
    panels[0][-1].legend(handles=marks, fontsize=7, loc="upper right", title="stress model", title_fontsize=7)
    save_figure(figure, path, dpi=130)


def advice(rows):
    """For each case and accuracy, the fastest way there: table of docs/generated/benchmarks.md."""
    lines = []
    for case in dict.fromkeys(row["case"] for row in rows):
        mine = [row for row in rows if row["case"] == case]
        for limit in (0.05, 0.01, 0.001):
            good = [row for row in mine if row["error"] <= limit]
            if not good:
                lines.append([case, f"{100 * limit:g} %", "none of the meshes tried", "", "", ""])
                continue
            best = min(good, key=lambda row: row["seconds"])
            other = [row["seconds"] for row in mine if (row["variant"], row["model"], row["n"]) == ("explicit", best["model"], best["n"])]
            beside = f"{other[0]:.3g}" if other else "-"
            lines.append([case, f"{100 * limit:g} %", f"{best['variant']}, {best['model']}", best["n"], f"{best['seconds']:.3g}", beside])
    return table(["case", "error below", "fastest", "blocks along the base", "time [s]", "explicit, same model and mesh [s]"], lines)


def others(path, chosen):
    """Rows of the cases that are not run now, as they stand in the data."""
    with open(path, newline="", encoding="utf-8") as file:
        return [{key: value if key in ("case", "variant", "model") else float(value) for key, value in row.items()} | {"n": int(row["n"])}
                for row in csv.DictReader(file) if row["case"] not in chosen]  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--case", type=int, nargs="*", default=list(range(len(CASES))), help="numbers of the cases, from 0; the others keep their data; none: chart and table alone")
    options = parser.parse_args()
    path = DATA / "accuracy.csv"
    chosen = [list(CASES)[i] for i in options.case]
    rows = others(path, chosen) + measure(os.path.abspath(options.quoin), options.repeats, chosen)
    rows.sort(key=lambda row: list(CASES).index(row["case"]))
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows({key: f"{value:.6g}" if isinstance(value, float) else value for key, value in row.items()} for row in rows)
    draw(rows, DOCS / "img" / "accuracy.png")
    replace_between("accuracy", advice(rows))
    print(advice(rows))


if __name__ == "__main__":
    main()
