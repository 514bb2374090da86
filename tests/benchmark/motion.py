#!/usr/bin/env python3
"""Motion in time: error against time over the step and the mesh, and the same model by OpenSees.

    PYTHONPATH=tools python tests/benchmark/motion.py --quoin build/quoin --python build/venv/bin/python
    PYTHONPATH=tools python tests/benchmark/motion.py --parts race --race 24 58 --duration 1      # rates alone, short
    PYTHONPATH=tools python tests/benchmark/motion.py --quoin build/quoin --check                 # limits, for CTest: seconds

slip    Section G1 of examples/guilhofrei_earthquake: static stages by Newton's method, then 20 s of its synthetic record (the same
        five sines in an envelope of 20 s), base of 45 degrees that slips and opens, with a dashpot of a millisecond in the joint; base
        of the rock that lets waves out, water as added mass, alpha 1. Without the dashpot slip does not converge with the step, however
        small (rows "no dashpot"): the joint rings, and how far it slides hangs on when. Error of the step: against the same mesh with
        the step --fine of the bound; error of the mesh: of that against --finest columns. Errors are of the largest displacement of the
        crest and of the last slip of the heel, both against the rock under the heel.
condensed
        Section G1 as above in small strain, with the example's dashpot of 0.1 ms, whole and with dam and rock condensed up to 30 and 60 Hz (--highest),
        without damping by stiffness and with --beta, by `dt_factor: auto`: errors against the whole mesh with the same damping.
race    The section on rock whose bottom moves by the record, elastic joint (stress model pt: springs at nodes), small strain, no loads,
        alpha 1, so that both solve the same equations: Quoin's explicit steps by `dt_factor: auto` (0.9 of a bound without room for contacts that are not there) and OpenSees by Newmark's
        average acceleration (peer_runs/opensees_motion.py) at --race-steps. Errors over 20 s against OpenSees with a quarter of the
        smallest step; where that takes too long (--duration) rates alone, and the record only begins.

Processor seconds (user and system) for the whole record, on one rank; of Quoin the whole process, reading, static stages and writing
included; of OpenSees its steps alone; without it the part is left out. The least of --repeats. Rows of docs/data/motion.csv with the same part, solver, mesh and step are
replaced, the others stay. Writes the tables of docs/generated/benchmarks.md; accuracy.py draws the panel."""

import argparse
import csv
import json
import os
import runpy
import subprocess
import sys
import tempfile
from pathlib import Path
from resource import RUSAGE_CHILDREN

import numpy as np
import yaml

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
EXAMPLES = ROOT / "examples"
sys.path[:0] = [str(path) for path in (HERE, HERE / "peer_runs", ROOT / "tests" / "verification", ROOT / "tools")]

from driver import ENVIRONMENT, changed, dump  # noqa: E402
from fig6_dam import Clock  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from record import DATA, replace_between, table  # noqa: E402

LASTS = 20.0  # [s] of the record
AUTO = 0.9  # of the bound, with dt_factor: auto, where blocks deform and connectivity is fixed
SAMPLE = 0.005  # [s] at most between rows of the history; a parabola through three of them gives a peak
QUOIN, OPENSEES = "Quoin", "OpenSees"
DAMPED, BARE, MESH = "slip", "slip, no dashpot", "slip, mesh"
SYSTEMS = ("BandSPD", "SuperLU")  # the fastest in steps of the wheel's solvers for small and for large models
CONDENSED, SOFT = "condensed, no beta", "condensed"
HEAD = ("part", "solver", "columns", "blocks", "step", "steps", "duration", "cpu_s", "crest", "slip", "crest_error", "slip_error")
WORDS = ("part", "solver")


# ---- runs

def of_example(file, name):
    """A function of a script; benchmarks and examples have files of the same names."""
    return runpy.run_path(str(EXAMPLES / file))[name]


def write_record(path):
    t = np.round(np.arange(round(LASTS / 0.01) + 1) * 0.01, 2)
    accelerations = of_example("guilhofrei_earthquake/record.py", "accelerations")(t)
    path.write_text("".join(f"{x:.2f}, {a:.12g}\n" for x, a in zip(t, accelerations)), encoding="utf-8")


def slipping(dashpot):
    """The scene of the example up to the end of the record."""
    scene = yaml.safe_load((EXAMPLES / "guilhofrei_earthquake" / "scene.yaml").read_text(encoding="utf-8"))
    kept = [stage for stage in scene["stages"] if set(stage) & {"sw", "full", "shake"}]
    return changed(scene, ("stages", kept), ("joints.base.damping", dashpot), ("relaxation.method", "preconditioned"))


def racing():
    scene = changed(slipping(0.0), ("strain", "small"), ("joints.base", {"law": "elastic", "stress_model": "pt", "k_n": 10e9, "k_s": 3e9}))
    scene["supports"]["rock_bottom"] = {"fix": "xy", "motion": "quake"}
    return changed(scene, ("stages", [{"shake": {"type": "dynamic", "loads": [], "alpha": 1.0}}]))


def environment():
    return ENVIRONMENT | dict(os.environ) | {"PYTHONPATH": str(ROOT / "tools")}


def quoin(program, folder, scene, factor, duration, every):
    """Cost of a run and its results; rows of the history every so many steps."""
    stages = [{name: stage | {"dt_factor": factor, "duration": duration} if name == "shake" else stage}
              for stages in scene["stages"] for name, stage in stages.items()]  # fmt: skip
    scene = changed(scene, ("stages", stages), ("relaxation.history_every", every), ("model", "model.h5"), ("output", "out"))
    Path(folder, "scene.yaml").write_text(dump(scene), encoding="utf-8")
    clock = Clock(RUSAGE_CHILDREN)
    done = subprocess.run([program, "-options_file", "scene.yaml", "-checkpoint_minutes", "0"], cwd=folder, env=environment(), capture_output=True, text=True)
    cost = clock.read()
    if done.returncode:
        raise RuntimeError(f"quoin: exit code {done.returncode} {done.stdout[-1000:]}{done.stderr[-1000:]}")
    return cost["cpu_s"], Results(os.path.join(folder, "out"))


def peak(x):
    """Largest size of samples, by the parabola through the three about it."""
    i = int(np.abs(x).argmax())
    if i in (0, len(x) - 1):
        return abs(x[i])
    a, b, c = np.abs(x[i - 1:i + 2]) if np.all(np.sign(x[i - 1:i + 2]) == np.sign(x[i])) else (0, abs(x[i]), 0)
    return b + (c - a) ** 2 / (8 * (2 * b - a - c)) if 2 * b > a + c else b


def answers(results):
    """Largest displacement of the crest and last slip of the heel since the record began, against the rock under the heel [m]."""
    history = results.history
    rows = history["stage"] == "shake"
    rock = history["rock_heel_ux_m"][rows]
    crest, heel = (history[name][rows] - rock for name in ("crest_upstream_ux_m", "heel_ux_m"))
    return {"crest": peak(crest - crest[0]), "slip": heel[-1] - heel[0]}


def solve(program, scene, columns, factor, duration, repeats):
    """A row of the data without its errors."""
    with tempfile.TemporaryDirectory() as folder:
        mesh = of_example("guilhofrei_sliding/mesh.py", "key_mesh")(columns)
        write(os.path.join(folder, "model.h5"), mesh)
        write_record(Path(folder, "quake.csv"))
        dt = quoin(program, folder, scene, factor, 1e-3, 10**9)[1].stage_summary("shake")["dt"]
        every = max(1, int(SAMPLE / dt))
        runs = [quoin(program, folder, scene, factor, duration, every) for _ in range(repeats)]
        results = runs[-1][1]
        return {"columns": columns, "blocks": len(mesh.blocks), "step": factor, "steps": results.stage_summary("shake")["cycles"],
                "duration": duration, "cpu_s": min(run[0] for run in runs), **answers(results)}  # fmt: skip


def opensees(options, columns, dt, duration, system, repeats=1):
    with tempfile.TemporaryDirectory() as folder:
        mesh = of_example("guilhofrei_sliding/mesh.py", "key_mesh")(columns)
        write(os.path.join(folder, "model.h5"), mesh)
        write_record(Path(folder, "quake.csv"))
        runs = []
        for _ in range(repeats):
            done = subprocess.run([options.python, str(HERE / "peer_runs" / "opensees_motion.py"), "--mesh", "model.h5", "--record", "quake.csv",
                                   "--duration", str(duration), "--dt", str(dt), "--system", system],
                                  cwd=folder, env=environment(), capture_output=True, text=True)  # fmt: skip
            lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
            if done.returncode or not lines:
                raise RuntimeError(f"opensees_motion.py: exit code {done.returncode} {done.stderr[-1000:]}")
            runs.append(json.loads(lines[-1]))
        least = min(runs, key=lambda run: run["cpu_s"])
        return {"columns": columns, "blocks": len(mesh.blocks), "step": dt, "steps": least["steps"], "duration": duration,
                "cpu_s": least["cpu_s"], "crest": least["crest"], "slip": 0.0}  # fmt: skip


def against(row, exact):
    return {"crest_error": abs(row["crest"] / exact["crest"] - 1), "slip_error": abs(row["slip"] / exact["slip"] - 1) if exact["slip"] else 0.0}


# ---- parts

def slip(options):
    finest = solve(options.quoin, slipping(options.dashpot), options.finest, options.finest_factor, LASTS, 1)
    yield {"part": MESH, "solver": QUOIN, **finest, **against(finest, finest)}
    for columns in options.columns:
        exact = solve(options.quoin, slipping(options.dashpot), columns, options.fine, LASTS, 1)
        yield {"part": MESH, "solver": QUOIN, **exact, **against(exact, finest)}
        for factor in options.factors:
            row = solve(options.quoin, slipping(options.dashpot), columns, factor, LASTS, options.repeats)
            yield {"part": DAMPED, "solver": QUOIN, **row, **against(row, exact)}
    columns = min(options.columns)
    exact = None
    for factor in sorted((options.fine, *options.factors)):
        row = solve(options.quoin, slipping(0.0), columns, factor, LASTS, 1)
        exact = exact or row
        yield {"part": BARE, "solver": QUOIN, **row, **against(row, exact)}


def condensed(options):
    """Both bodies of the section condensed, against the whole mesh with the same damping."""
    for part, beta in ((SOFT, options.beta), (CONDENSED, 0.0)):
        exact = None
        for highest in (None, *options.highest):
            scene = changed(slipping(1e-4), ("strain", "small"))
            for stages in scene["stages"]:
                if "shake" in stages:
                    stages["shake"] |= {"beta": beta}
            for group in scene["materials"].values() if highest else ():
                group |= {"condensed": True, "highest_frequency": highest}
            row = solve(options.quoin, scene, max(options.columns), "auto", LASTS, 1) | {"step": AUTO}
            exact = exact or row
            yield {"part": part, "solver": f"{QUOIN}, to {highest:g} Hz" if highest else QUOIN, **row, **against(row, exact)}


def race(options):
    if subprocess.run([options.python, "-c", "import openseespy"], capture_output=True).returncode:
        print("OpenSees is not installed (openseespy): left out", flush=True)
        return
    for columns in options.race:
        whole = columns <= options.whole
        duration = LASTS if whole else options.duration
        exact = opensees(options, columns, min(options.race_steps) / 4, LASTS, SYSTEMS[0]) if whole else None
        nothing = {"crest_error": float("nan"), "slip_error": float("nan")}
        row = solve(options.quoin, racing(), columns, "auto", duration, options.repeats) | {"slip": 0.0, "step": AUTO}
        yield {"part": "race", "solver": QUOIN, **row, **(against(row, exact) if whole else nothing)}
        for dt in options.race_steps if whole else [min(options.race_steps)]:
            for system in SYSTEMS:
                row = opensees(options, columns, dt, duration, system, options.repeats)
                yield {"part": "race", "solver": f"{OPENSEES}, {system}", **row, **(against(row, exact) if whole else nothing)}


PARTS = {"slip": slip, "condensed": condensed, "race": race}


# ---- what is written

def kept():
    path = DATA / "motion.csv"
    if not path.exists():
        return []
    with open(path, newline="", encoding="utf-8") as file:
        return [{name: value if name in WORDS else float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def name_of(row):
    return row["part"], row["solver"], float(row["columns"]), round(float(row["step"]), 9)


def keep(row):
    rows = {name_of(old): old for old in kept()} | {name_of(row): row}
    with open(DATA / "motion.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, HEAD, lineterminator="\n")
        writer.writeheader()
        for _, one in sorted(rows.items()):
            writer.writerow({key: f"{value:.6g}" if isinstance(value, float) else value for key, value in one.items()})


def percent(value):
    return "-" if np.isnan(value) else f"{100 * value:.2g} %"


def slip_table(rows):
    lines = []
    for row in (row for row in rows if row["part"] in (DAMPED, BARE)):
        mesh = [one for one in rows if one["part"] == MESH and one["columns"] == row["columns"]]
        lines.append(["yes" if row["part"] == DAMPED else "no", f"{row['columns']:.0f}", f"{row['blocks']:.0f}", f"{row['step']:g}", f"{row['steps']:.0f}",
                      f"{row['cpu_s']:.3g}", f"{1e3 * row['crest']:.2f}", f"{1e3 * row['slip']:.2f}", percent(row["crest_error"]), percent(row["slip_error"]),
                      percent(mesh[0]["crest_error"]) if mesh and row["part"] == DAMPED else "-"])  # fmt: skip
    return table(["dashpot", "columns", "blocks", "dt_factor", "steps", "processor [s]", "crest [mm]", "slip [mm]", "error of the step: crest", "slip",
                  "error of the mesh: crest"], lines)  # fmt: skip


def race_table(rows):
    lines = []
    for row in sorted((row for row in rows if row["part"] == "race"), key=lambda row: (row["blocks"], row["solver"] != QUOIN, row["step"])):
        own = next(one for one in rows if (one["part"], one["solver"], one["columns"]) == ("race", QUOIN, row["columns"]))
        rate, mine = row["cpu_s"] / row["duration"], own["cpu_s"] / own["duration"]
        step = f"{row['step']:g} of the bound" if row["solver"] == QUOIN else f"{1e3 * row['step']:.3g} ms"
        lines.append([f"{row['blocks']:.0f}", row["solver"], step, f"{row['duration']:g}", f"{1e6 * row['cpu_s'] / row['steps']:.3g}", f"{rate:.3g}",
                      f"{rate / mine:.2g}", percent(row["crest_error"])])  # fmt: skip
    return table(["blocks", "solver", "step", "record [s]", "a step [us]", "processor seconds for a second", "of Quoin's", "error of the crest"], lines)


def condensed_table(rows):
    lines = []
    for row in (row for row in rows if row["part"] in (SOFT, CONDENSED)):
        lines.append(["yes" if row["part"] == SOFT else "no", "all" if row["solver"] == QUOIN else row["solver"].removeprefix(f"{QUOIN}, "), f"{row['steps']:.0f}",
                      f"{row['cpu_s']:.3g}", f"{1e3 * row['crest']:.2f}", f"{1e3 * row['slip']:.2f}", percent(row["crest_error"]), percent(row["slip_error"])])  # fmt: skip
    return table(["beta", "vibrations within bodies", "steps", "processor [s]", "crest [mm]", "slip [mm]", "error: crest", "slip"], lines)


def check(program):
    """A short record on a coarse mesh: what must hold on any machine."""
    short = 8.0
    exact, row = (solve(program, slipping(1e-3), 6, factor, short, 1) for factor in (0.1, 0.9))
    errors = against(row, exact)
    print(f"104 blocks, {short:g} s: dt_factor 0.9 against 0.1: crest {percent(errors['crest_error'])}, slip {percent(errors['slip_error'])}, {row['cpu_s']:.2f} s")
    if not errors["crest_error"] < 0.02 or row["crest"] < 1e-3:
        raise SystemExit("the largest displacement of the crest is off by more than 2 %")


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--python", default=sys.executable, help="that has OpenSees")
    parser.add_argument("--parts", nargs="*", choices=PARTS, default=list(PARTS), help="none: tables alone")
    parser.add_argument("--repeats", type=int, default=2)
    parser.add_argument("--columns", type=int, nargs="+", default=[6, 12, 24], help="across the base of the dam")
    parser.add_argument("--finest", type=int, default=48, help="columns of the mesh that others are compared with")
    parser.add_argument("--finest-factor", type=float, default=0.3, help="its step")
    parser.add_argument("--factors", type=float, nargs="+", default=[0.9, 0.6, 0.3], help="steps over the stability bound")
    parser.add_argument("--fine", type=float, default=0.1, help="step of the reference")
    parser.add_argument("--dashpot", type=float, default=1e-3, help="[s]")
    parser.add_argument("--highest", type=float, nargs="+", default=[30, 60], help="[Hz] of condensed bodies")
    parser.add_argument("--beta", type=float, default=1e-4, help="[s] of the part condensed")
    parser.add_argument("--race", type=int, nargs="+", default=[24, 58, 116], help="columns")
    parser.add_argument("--race-steps", type=float, nargs="+", default=[0.01, 0.005], help="[s] of OpenSees")
    parser.add_argument("--whole", type=int, default=24, help="most columns for the whole record")
    parser.add_argument("--duration", type=float, default=1.0, help="[s] of the record that larger models run")
    parser.add_argument("--check", action="store_true", help="limits alone; writes nothing")
    options = parser.parse_args()
    options.quoin = os.path.abspath(options.quoin)
    return options


def main():
    options = parse()
    if options.check:
        return check(options.quoin)
    for part in options.parts:
        for row in PARTS[part](options):
            keep(row)
            print("  " + ", ".join(f"{key} {value:.4g}" if isinstance(value, float) else str(value) for key, value in row.items()), flush=True)
    rows = kept()
    replace_between("motion slip", slip_table(rows))
    replace_between("motion condensed", condensed_table(rows))
    replace_between("motion race", race_table(rows))
    return None


if __name__ == "__main__":
    main()
