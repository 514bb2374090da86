#!/usr/bin/env python3
"""Bodies that meet in time: error against time for dt_factor 0.9, 0.5, 0.1, 0.05 and auto.

    PYTHONPATH=tools python tests/benchmark/step_control.py --quoin build/quoin
    PYTHONPATH=tools python tests/benchmark/step_control.py --quoin build/quoin --more   # why 0.05 is the default: printed alone

Scenes: a block that drops flat on a dashpot, and one that spins and lands on a corner; a block set rocking; one that slides on a
shaken table; one that slides and strikes another; a column of four that falls together; a dam that rocks and slides on a shaken
base, of blocks that deform and rigid. Each with five values of gravity about 9.81 m/s2, because one run of a motion with blows is right or
wrong by chance. Truth: the same at 0.01. The error is the largest difference of a history over its range: of the times between
(history), of its largest value (peak) and at the end; root mean squares over the five. Processor seconds of the whole process, user time,
mean of the five. Writes docs/data/step_control.csv and docs/img/step_control.png."""

import argparse
import csv
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage

import matplotlib

matplotlib.use("Agg")
import numpy as np
import yaml
from matplotlib import pyplot

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools")]

from driver import ENVIRONMENT, changed  # noqa: E402
from quoin_tools.base.files import save_figure  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.meshing import join, rectangle, renamed  # noqa: E402

G, FINE, FACTORS = 9.81, "0.01", ("0.9", "0.5", "0.1", "0.05", "auto")
GRAVITIES = (0.94, 0.97, 1.0, 1.03, 1.06)
HEAD = ("scene", "dt_factor", "steps", "cpu_s", "history_error", "peak_error", "end_error")
COLOURS = {"0.9": "#d62828", "0.5": "#f77f00", "0.1": "#2a6f97", "0.05": "#61a5c2", "auto": "#1b7f3b"}


def quake(peak, frequency, length):
    t = np.linspace(0, length, 301)
    a = peak * np.sin(np.pi * t / length) ** 2 * np.sin(2 * np.pi * frequency * t)
    return "".join(f"{x:.9g}, {y:.17g}, 0\n" for x, y in zip(np.append(t, [length + 1e-6, 99.0]), np.append(a, [0.0, 0.0]), strict=True))


def base(x, width):
    return renamed(rectangle(x, -1, width, 1, group="base", rigid=True), {})


def block(x, y, width, height, name, *cells):
    return renamed(rectangle(x, y, width, height, *cells, group="block", rigid=not cells), {}, {name: "top_left"})


def scene(joint, duration, *changes, rests=True):
    go = {"type": "dynamic", "loads": ["weight"], "duration": duration, "dt_factor": "auto"}
    return changed({"model": "m.h5", "contact": {"connectivity": "variable", "tolerance": 0.005}, "materials": {"base": {"density": 2400}, "block": {"density": 2400}},
                    "relaxation": {"allow_floating": True, "history_every": 1, "tolerance": 1e-8}, "joints": {"default": joint}, "supports": {"base": {"fix": "xy"}},
                    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}}, "stages": ([{"rest": {"loads": ["weight"]}}] if rests else []) + [{"go": go}]}, *changes)  # fmt: skip


def joint(k_n, k_s, friction, damping):
    return {"k_n": k_n, "k_s": k_s, "friction": friction, "damping": damping}


def scenes():
    hard, shaken = joint(1e9, 1e9, 35, 5e-4), {"fix": "xy", "motion": "quake.csv", "quantity": "acceleration"}
    k_s = 2400 * 0.25 * (2 * np.pi * 30) ** 2
    dam, fixed = ("supports.base", shaken), ("contact", {"tolerance": 0.005})
    return {
        "drops flat": (join([base(-2, 6), block(0, 0.2, 1, 0.5, "at")]), scene(hard, 1.5, rests=False), ["at_uy_m"], ""),
        "lands on a corner": (join([base(-2, 6), block(0, 0.2, 1, 0.5, "at")]), scene(hard, 1.2, ("materials.block.spin", -1.0), rests=False), ["at_ux_m", "at_uy_m"], ""),
        "rocks": (join([base(-2, 6), block(0, 0, 0.5, 2, "at")]), scene(joint(1e9, 1e9, 60, 2e-4), 4.0, ("materials.block", {"density": 2400, "spin": -0.5, "velocity": [0.0, 0.125]})), ["at_ux_m"], ""),
        "slides, shaken": (join([base(-2, 8), block(0, 0, 1, 0.25, "at")]), scene(joint(100 * k_s, k_s, 11.31, 0.1 / (2 * np.pi * 30)), 2.0, dam), ["at_ux_m"], quake(0.5 * G, 2, 1.5)),
        "strikes another": (join([base(-2, 8), block(0, 0, 0.5, 0.25, "at"), renamed(rectangle(1, 0, 0.5, 0.25, group="mate", rigid=True), {}, {"mate": "top_left"})]),
                            scene(joint(1e9, 1e9, 10, 1e-4), 1.5, ("materials.block.velocity", [2.0, 0.0]), ("materials.mate", {"density": 2400}), ("loads.weight.groups", ["block", "mate"])), ["at_ux_m", "mate_ux_m"], ""),
        "column falls": (join([base(-2, 6), *(block(0, 0.05 * (i + 1) + 0.5 * i, 1, 0.5, f"at_{i}") for i in range(4))]), scene(hard, 1.0, rests=False), ["at_1_uy_m", "at_3_uy_m"], ""),
        "dam, deforms": (join([base(-4, 14), block(0, 0, 4, 10, "at", 4, 10)]), scene(joint(1e10, 4e9, 35, 1e-4), 2.5, dam, fixed, ("materials.block", {"density": 2400, "young": 5e9, "poisson": 0.2})), ["at_ux_m"], quake(0.55 * G, 2, 2.0)),
        "dam, rigid": (join([base(-4, 14), block(0, 0, 4, 10, "at")]), scene(joint(1e10, 4e9, 35, 1e-4), 2.5, dam, fixed), ["at_ux_m"], quake(0.55 * G, 2, 2.0)),
    }  # fmt: skip


def more_scenes():
    """The dam, blocks that fall and rock, with other damping and joints."""
    known, kept = scenes(), {}
    bare, stages = ("joints.default.damping", 0.0), known["dam, deforms"][1]["stages"]

    def vary(name, what, *changes):
        mesh, keys, probes, record = known[name]
        kept[f"{name}, {what}"] = (mesh, changed(keys, *changes), probes, record)

    def stage(**keys):
        return ("stages", [stages[0], {"go": stages[1]["go"] | keys}])

    vary("dam, deforms", "dashpot")
    vary("dam, deforms", "no dashpot", bare)
    vary("dam, deforms", "beta", stage(beta=1e-4))
    vary("dam, deforms", "alpha", stage(alpha=2))
    vary("dam, deforms", "friction 20", ("joints.default.friction", 20))
    vary("dam, deforms", "elastic joint", ("joints.default", {"k_n": 1e10, "k_s": 4e9, "law": "elastic"}))
    vary("dam, rigid", "dashpot")
    for name in ("dam, rigid", "rocks", "drops flat", "strikes another"):
        vary(name, "no dashpot", bare)
    vary("column falls", "dashpot")
    return kept


def run(quoin, folder, mesh, keys, record, factor):
    """History of the motion, steps, processor seconds."""
    with tempfile.TemporaryDirectory(dir=folder) as place:
        write(f"{place}/m.h5", mesh)
        Path(place, "s.yaml").write_text(yaml.safe_dump(keys, sort_keys=False), encoding="utf-8")
        Path(place, "quake.csv").write_text(record)
        every = "10" if factor == FINE else "1"
        start = getrusage(RUSAGE_CHILDREN).ru_utime
        subprocess.run([quoin, "-options_file", "s.yaml", "-checkpoint_minutes", "0", "-relaxation_history_every", every, "-stages_go_dt_factor", factor],
                       cwd=place, env=ENVIRONMENT | dict(os.environ), check=True, capture_output=True)  # fmt: skip
        spent = getrusage(RUSAGE_CHILDREN).ru_utime - start
        results = Results(f"{place}/out")
        mine = results.history["stage"] == "go"
        return {name: column[mine] for name, column in results.history.items() if name != "stage"}, results.stage_summary("go")["cycles"], spent


def errors(history, truth, probes):
    """Largest of the probes: history, peak, end."""
    worst = np.zeros(3)
    for probe in probes:
        t, u, span = truth["time_s"], truth[probe], np.ptp(truth[probe])
        if span < 1e-4:
            continue
        end = min(t[-1], history["time_s"][-1])
        times = history["time_s"][history["time_s"] <= end]
        now = history[probe][: len(times)]
        worst = np.maximum(worst, [abs(np.interp(times, t, u) - now).max() / span, abs(np.ptp(now) / span - 1), abs(np.interp(end, t, u) - np.interp(end, times, now)) / span])
    return worst


def measure(quoin, motions, gravities=GRAVITIES, factors=FACTORS):
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name, (mesh, keys, probes, record) in motions.items():
            kinds = [changed(keys, ("gravity", G * part)) for part in gravities]
            truths = [run(quoin, folder, mesh, kind, record, FINE)[0] for kind in kinds]
            for factor in factors:
                found = [run(quoin, folder, mesh, kind, record, factor) for kind in kinds]
                off = np.sqrt(np.mean([errors(history, truth, probes) ** 2 for (history, _, _), truth in zip(found, truths, strict=True)], axis=0))
                steps, spent = (np.mean([x[i] for x in found]) for i in (1, 2))
                rows.append(dict(zip(HEAD, (name, factor, f"{steps:.0f}", f"{spent:.3g}", *(f"{x:.3g}" for x in off)), strict=True)))
                print(*rows[-1].values(), flush=True)
    return rows


def draw(rows, path):
    names = list(dict.fromkeys(row["scene"] for row in rows))
    figure, panels = pyplot.subplots(2, (len(names) + 1) // 2, figsize=(13, 6), constrained_layout=True)
    for axes, name in zip(panels.flat, names, strict=False):
        for row in (row for row in rows if row["scene"] == name):
            x, y, colour = float(row["steps"]), 100 * max(float(row["history_error"]), 1e-7), COLOURS[row["dt_factor"]]
            axes.loglog(x, y, "o" if row["dt_factor"] != "auto" else "*", color=colour, markersize=8 if row["dt_factor"] != "auto" else 14)
            axes.annotate(row["dt_factor"], (x, y), textcoords="offset points", xytext=(6, 4), fontsize=8, color=colour)
        axes.set_title(name, fontsize=9)
        axes.grid(True, which="both", alpha=0.25)
        axes.margins(0.25)
        axes.xaxis.set_minor_formatter("")
        axes.yaxis.set_minor_formatter("")
    figure.supxlabel("steps")
    figure.supylabel("error of the history [% of its range]")
    save_figure(figure, path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--more", action="store_true", help="other damping and joints; three values of gravity")
    options = parser.parse_args()
    if options.more:
        measure(os.path.abspath(options.quoin), more_scenes(), (0.95, 1.0, 1.05), ("0.05", "auto"))
        return
    rows = measure(os.path.abspath(options.quoin), scenes())
    with open(ROOT / "docs" / "data" / "step_control.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, HEAD)
        writer.writeheader()
        writer.writerows(rows)
    draw(rows, ROOT / "docs" / "img" / "step_control.png")


if __name__ == "__main__":
    main()
