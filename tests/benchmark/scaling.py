#!/usr/bin/env python3
"""Time and memory against size, and ranks against each other: set-up, cycle and their parts.

    PYTHONPATH=tools python tests/benchmark/scaling.py                       # 1e3 to 4e6 blocks, 1 and 2 ranks
    PYTHONPATH=tools python tests/benchmark/scaling.py --sides 32 100        # these again, the others stay
    PYTHONPATH=tools python tests/benchmark/scaling.py --draw-only

Scenes of run.py: `block`, one body of side x side blocks; `wall`, single blocks with joints (tptm) all around, as many.
Set-up: seconds of wall time that quoin prints, from the start of reading to the first cycle, with its parts. A cycle:
bench_cycle's least processor time (run.py); its parts: shares that quoin prints. How many times as fast two ranks are:
its median over turns of a cycle together and a cycle of the whole scene on the slower one of the two processors. Memory: resident pages of all ranks,
largest, and the median between set-up and the end of the cycles. With --same-bits the two smallest sizes run on 1, 2 and 4 ranks, and the checksums of the
state are compared. Writes docs/data/scaling.csv, docs/img/scaling_size.png, docs/img/scaling_ranks.png and the table of
docs/generated/benchmarks.md."""

import argparse
import csv
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import numpy as np
from matplotlib import pyplot

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "benchmark"), str(ROOT / "tools")]

import run  # noqa: E402
from quoin_tools.base.files import save_figure  # noqa: E402
from record import DATA as FOLDER  # noqa: E402
from record import DOCS, replace_between, table  # noqa: E402

DATA, IMAGES = FOLDER / "scaling.csv", DOCS / "img"
SCENES = {"block": "block", "wall": "tptm"}  # here: in run.py
SAID, MEMORY = {"block": "one body", "wall": "single blocks"}, ("peak_MiB", "resident_MiB")
MOST = {"block": 2000, "wall": 1000}  # sides: 4e6 single blocks with 8e6 contacts would take 25 GiB
SET_UP = ("reading", "checks", "order", "partition", "distribution", "model", "contacts", "output")
CYCLE = ("exchange", "contacts", "blocks", "rigid bodies", "damping")
COLUMNS = ("scene", "blocks", "contacts", "ranks", "cycle_ns_per_block", "speed_up", "set_up_s", "peak_MiB", "resident_MiB", "checksum",
           *(f"set_up_{p}" for p in SET_UP), *(f"cycle_{p}" for p in CYCLE))


def side_of(scene, side):
    """run.py's side that gives about side^2 blocks: its scenes of single blocks have about side^2 contacts."""
    return side if scene == "block" else round(side * 2**0.5)


def memory(parent):
    """Resident MiB of all processes below, now and at their peaks."""
    now = peak = 0.0
    try:
        children = Path(f"/proc/{parent}/task/{parent}/children").read_text(encoding="utf-8").split()
        if Path(f"/proc/{parent}/comm").read_text(encoding="utf-8").strip() == "quoin":
            status = Path(f"/proc/{parent}/status").read_text(encoding="utf-8")
            now, peak = (int(re.search(rf"{key}:\s+(\d+)", status)[1]) / 1024 for key in ("VmRSS", "VmHWM"))
    except (OSError, TypeError):
        return 0.0, 0.0
    below = [memory(child) for child in children]
    return now + sum(b[0] for b in below), peak + sum(b[1] for b in below)


def shares(text, pattern, names):
    """Seconds in all, and the share of each part, of a line that quoin prints; its last one."""
    total, parts = re.findall(pattern, text)[-1]
    found = {name: int(value) / 100 for name, value in re.findall(r" ([a-z ]+) (\d+) %", parts)}
    return float(total), {name: found.get(name, 0.0) for name in names}


def row_of(options, scene, side, ranks):
    with tempfile.TemporaryDirectory() as folder:
        run.prepared(folder, SCENES[scene], side_of(scene, side))
        cycles = max(50, min(10000, 20_000_000 // side**2))
        command = [options.quoin, "-options_file", "scene.yaml", "-output", "out", "-relaxation_method", "explicit", "-stages_all_ramp",
                   "0", "-stages_all_max_cycles", str(cycles)]  # fmt: skip
        if ranks > 1:
            command = ["mpirun", "-q", "-n", str(ranks), "--oversubscribe", "--bind-to", "none", *command]
        environment = dict(os.environ) | run.ENVIRONMENT | {"OMPI_MCA_mpi_yield_when_idle": str(int(ranks > 2))}
        peak, running = 0.0, []
        with open(Path(folder, "log"), "w+", encoding="utf-8") as log:
            process = subprocess.Popen(command, cwd=folder, env=environment, stdout=log, stderr=subprocess.STDOUT)
            while process.poll() is None:
                now, most = memory(process.pid)
                peak = max(peak, most)
                said = Path(folder, "log").read_text(encoding="utf-8")
                if "set-up" in said and "stage all" not in said:
                    running += [now] if now else []
                time.sleep(0.02)
            log.seek(0)
            text = log.read()
        if process.returncode not in (0, 4):
            raise SystemExit(f"{scene}, side {side}, {ranks} ranks: {text[-2000:]}")
        stage = json.loads(Path(folder, "out", "summary.json").read_text(encoding="utf-8"))["stages"][0]
    set_up, parts = shares(text, r"set-up ([\d.]+) s:(.*)", SET_UP)
    _, step = shares(text, r"([\d.e+]+) us a cycle:(.*)", CYCLE)
    if options.no_clock:
        bench = {"n_elements": int(re.search(r"(\d+) blocks in", text)[1]), "n_contacts": 0, "cycle": 0.0}
    else:
        bench = run.measure(options.bench, SCENES[scene], side_of(scene, side), ranks, options.seconds)
    blocks = bench["n_elements"]
    return ({"scene": scene, "blocks": blocks, "contacts": bench["n_contacts"], "ranks": ranks,
             "cycle_ns_per_block": run.least(bench, "cycle") / blocks, "speed_up": bench.get("speed_up", 1.0), "set_up_s": set_up, "peak_MiB": peak, "resident_MiB": float(np.median(running or [peak])),
             "checksum": stage["checksum"]} | {f"set_up_{k}": v for k, v in parts.items()}
            | {f"cycle_{k}": v for k, v in step.items()})


def exponent(x, y):
    return np.polyfit(np.log(x), np.log(y), 1)[0]


def draw_size(rows):
    figure, axes = pyplot.subplots(1, 3, figsize=(13, 4.2), constrained_layout=True)
    for scene, colour in (("block", "tab:blue"), ("wall", "tab:orange")):
        for ranks, style in ((1, "o-"), (2, "s--")):
            own = [r for r in rows if r["scene"] == scene and int(r["ranks"]) == ranks]
            n = np.array([float(r["blocks"]) for r in own])
            if len(own) < 2:
                continue
            what = SAID[scene] + f", {ranks} rank" + "s" * (ranks > 1)
            cycle, set_up = (np.array([float(r[k]) for r in own]) for k in ("cycle_ns_per_block", "set_up_s"))
            axes[0].loglog(n, 1e-6 * cycle * n, style, color=colour, label=f"{what}: exponent {exponent(n, cycle * n):.2f}")
            axes[1].loglog(n, set_up, style, color=colour, label=f"{what}: exponent {exponent(n[-2:], set_up[-2:]):.2f} (last)")
            if ranks == 1:
                for key, mark in zip(MEMORY, (":", "-")):
                    value = np.array([float(r[key]) for r in own]) * 2**20
                    slope = np.diff(value)[-1] / np.diff(n)[-1]
                    axes[2].loglog(n, value / n, "o" + mark, color=colour,
                                   label=f"{what}, {'median after set-up' if mark == '-' else 'peak'}: {slope:.0f} B more a block")
    axes[0].set(xlabel="blocks", ylabel="processor time of a cycle per rank [ms]", title="Cycle")
    axes[1].set(xlabel="blocks", ylabel="from reading to the first cycle [s]", title="Set-up")
    axes[1].axhline(30, color="grey", lw=0.8)
    axes[2].set(xlabel="blocks", ylabel="resident memory [B a block]", title="Memory, 1 rank, program included")
    for axis in axes:
        axis.legend(fontsize=7, loc="upper right" if axis is axes[2] else "upper left")
        axis.grid(alpha=0.3)
    axes[2].set_ylim(top=4 * axes[2].get_ylim()[1])
    save_figure(figure, IMAGES / "scaling_size.png", dpi=130)


def draw_ranks(rows):
    rows = [r for r in rows if int(r["ranks"]) <= 2]
    one, two = ({(r["scene"], int(r["blocks"])) for r in rows if int(r["ranks"]) == n} for n in (1, 2))
    sizes = sorted(one & two)
    figure, axes = pyplot.subplots(1, 2, figsize=(13, 4.6), constrained_layout=True, sharey=True)
    for axis, scene in zip(axes, ("block", "wall")):
        ticks = []
        for place, (_, blocks) in enumerate(s for s in sizes if s[0] == scene):
            pair = {int(r["ranks"]): r for r in rows if r["scene"] == scene and int(r["blocks"]) == blocks}
            whole = float(pair[1]["cycle_ns_per_block"])
            for ranks, r in pair.items():
                height = 1.0 / float(r["speed_up"])
                bottom, x = 0.0, place + 0.2 * (2 * ranks - 3)
                total = sum(float(r[f"cycle_{p}"]) for p in CYCLE) or 1.0
                for part, colour in zip(CYCLE, ("tab:red", "tab:orange", "tab:blue", "tab:green", "tab:purple")):
                    part_height = height * float(r[f"cycle_{part}"]) / total
                    axis.bar(x, part_height, 0.36, bottom, color=colour, label=part if not place and ranks == 1 else None)
                    bottom += part_height
                axis.text(x, height + 0.02, f"{1 / height:.2f} x" if ranks > 1 else f"{whole:.0f} ns", ha="center", fontsize=8, in_layout=False)
            ticks.append(f"{blocks}\n1 rank, 2 ranks")
        axis.axhline(0.5, color="grey", lw=0.8)
        axis.set_xticks(range(len(ticks)), ticks)
        axis.set(xlabel="blocks", ylim=(0, 1.3), ylabel="time of a cycle over that of 1 rank [-]",
                 title={"block": "One body", "wall": "Single blocks with joints"}[scene])
    axes[0].legend(fontsize=8, ncol=len(CYCLE), loc="upper center")
    save_figure(figure, IMAGES / "scaling_ranks.png", dpi=130)


def write_table(rows):
    ordered = sorted(rows, key=lambda r: (r["scene"], int(r["blocks"]), int(r["ranks"])))
    lines = []
    for r in ordered:
        lines.append([SAID[r["scene"]], r["blocks"], r["contacts"], r["ranks"], f"{float(r['cycle_ns_per_block']):.1f}", f"{float(r['speed_up']):.2f}" if r["ranks"] != "1" else "",
                      r["set_up_s"], f"{float(r['set_up_distribution']) + float(r['set_up_partition']):.0%}", *(f"{float(r[k]):.0f}" for k in MEMORY)])  # fmt: skip
    head = ["", "blocks", "contacts", "ranks", "cycle [ns a block]", "times as fast as 1 rank", "reading to first cycle [s]", "of it dealing out to ranks",
            "peak [MiB]", "median after set-up [MiB]"]  # fmt: skip
    replace_between("scaling", table(head, lines))


def same_bits(options):
    for scene in SCENES:
        for side in sorted(options.sides)[:2]:
            found = {ranks: row_of(options, scene, side, ranks)["checksum"] for ranks in (1, 2, 4)}
            print(scene, side, found, "same bits" if len(set(found.values())) == 1 else "DIFFERENT BITS", flush=True)
            if len(set(found.values())) > 1:
                sys.exit(1)


def measure(options):
    """Puts what is asked for into the data; other rows stay."""
    rows = {}
    if DATA.exists():
        with open(DATA, newline="", encoding="utf-8") as f:
            rows = {(r["scene"], int(r["blocks"]), int(r["ranks"])): r for r in csv.DictReader(f)}
    for scene in options.scenes:
        for side in (s for s in options.sides if s <= MOST[scene]):
            for ranks in options.ranks:
                row = row_of(options, scene, side, ranks)
                rows[scene, row["blocks"], ranks] = {k: f"{v:.5g}" if isinstance(v, float) else v for k, v in row.items()}
                with open(DATA, "w", newline="", encoding="utf-8") as f:
                    writer = csv.DictWriter(f, COLUMNS, lineterminator="\n")
                    writer.writeheader()
                    writer.writerows(rows[key] for key in sorted(rows))
                print({k: row[k] for k in COLUMNS[:9]}, flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--bench", default=str(ROOT / "build" / "tests" / "bench_cycle"))
    parser.add_argument("--sides", type=int, nargs="+", default=[32, 100, 316, 1000, 2000])
    parser.add_argument("--scenes", nargs="+", choices=list(SCENES), default=list(SCENES))
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--seconds", type=float, default=0.3, help="for each measurement of a cycle")
    parser.add_argument("--same-bits", action="store_true", help="checksums on 1, 2 and 4 ranks; nothing else")
    parser.add_argument("--draw-only", action="store_true", help="pictures from the data there is")
    options = parser.parse_args()
    options.quoin, options.bench = os.path.abspath(options.quoin), os.path.abspath(options.bench)
    options.no_clock = options.same_bits
    if options.same_bits:
        same_bits(options)
        return
    if not options.draw_only:
        measure(options)
    with open(DATA, newline="", encoding="utf-8") as f:
        rows = list(csv.DictReader(f))
    write_table(rows)
    draw_size(rows)
    if {r["ranks"] for r in rows} >= {"1", "2"}:
        draw_ranks(rows)


if __name__ == "__main__":
    main()
