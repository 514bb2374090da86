#!/usr/bin/env python3
"""Many stones that slide: do explicit cycles come to rest, without energy from nothing, and where Newton's method does?

    PYTHONPATH=tools python tests/benchmark/stones.py --quoin build/quoin                  # minutes
    PYTHONPATH=tools python tests/benchmark/stones.py --quoin build/quoin --stones 2070    # the large dam alone

Voronoi dams (seed 5) of 100, 150, 598 and 2070 stones under their own weight, E 10 GPa, k_n 10 GPa/m, tolerance 1e-6, 120 000 cycles at
most: friction, k_s/k_n, stress model and strain, all of friction with k_s on the two small ones, one at a time on the others. Kinetic energy: the
largest of the history over the work of the weight, half of weight times settlement of the crest. Newton's method has an effort of 1e7
and its answer is left out where it found none; --before program: rows of an older program beside.
Writes docs/data/stones.csv (rows of a size that has run replace those before) and the table of docs/generated/benchmarks.md."""

import argparse
import csv
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools")]

from driver import ENVIRONMENT, VERDICTS  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.voronoi import Options, voronoi_mesh  # noqa: E402
from record import DATA, replace_between, table  # noqa: E402

STONE = {"density": 2400, "young": 10e9, "poisson": 0.2}
SCENE = {"relaxation": {"tolerance": 1e-6, "max_cycles": 120000, "history_every": 100}, "materials": {"dam": STONE, "facing": STONE},
         "joints": {"default": {"stress_model": "tptm", "k_n": 10e9, "k_s": 3e9, "friction": 60}},
         "supports": {"base": {"fix": "xy"}}, "loads": {"weight": {"type": "self_weight"}}, "stages": [{"sw": {"loads": ["weight"]}}]}  # fmt: skip
WEIGHT = 2400 * 9.81 * 411.96  # [N/m] of section G1
SIDES = {100: 2.75, 150: 1.6, 598: 0.6, 2070: 0.3}
NEWTON = ["-relaxation_method", "preconditioned", "-relaxation_effort", "1e7"]
BASE = (60, 0.3, "tptm", "large")
HEAD = ["stones", "friction, degree", "k_s/k_n", "model", "strain", "program", "verdict", "cycles", "kinetic energy / work", "crest, mm", "Newton's, mm"]


def design(stones):
    """Cells (friction, k_s/k_n, model, strain)."""
    one = [BASE, (45, *BASE[1:]), (75, *BASE[1:]), (60, 0.1, *BASE[2:]), (60, 1, *BASE[2:]), (60, 0.3, "pt", "large"), (60, 0.3, "t2pt", "large"),
           (60, 0.3, "tptm", "small")]  # fmt: skip
    if stones == 2070:
        return one[:2]
    if stones == 598:
        return [*one, (75, 0.3, "t2pt", "large"), (75, 0.3, "tptm", "small")]
    return [*one, *((friction, ratio, "tptm", "large") for friction in (45, 75) for ratio in (0.1, 1)), (75, 0.3, "pt", "small"), (45, 0.3, "t2pt", "small")]


def run(program, folder, mesh, cell, options=()):
    """Verdict, how it got there, cycles, kinetic energy over work, crest [mm]."""
    friction, ratio, model, strain = cell
    out, scene = os.path.join(folder, "out"), os.path.join(folder, "scene.yaml")
    with open(scene, "w", encoding="utf-8") as file:
        yaml.safe_dump(SCENE, file)
    command = [program, "-options_file", scene, "-model", mesh, "-output", out, "-strain", strain, "-joints_default_friction", f"{friction}",
               "-joints_default_k_s", f"{ratio * 10e9:g}", "-joints_default_stress_model", model, "-checkpoint_minutes", "0", *options]  # fmt: skip
    done = subprocess.run(command, cwd=ROOT, env=os.environ | ENVIRONMENT, capture_output=True, text=True)
    verdict = VERDICTS.get(done.returncode, f"exit code {done.returncode}")
    with open(os.path.join(out, "history.csv"), encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    crest = [1e3 * float(rows[-1][f"crest_upstream_u{axis}_m"]) for axis in "xy"]
    work = 0.5 * WEIGHT * abs(crest[1]) * 1e-3
    kinetic = max(float(row["kinetic_J"]) for row in rows) / work
    explicit = "explicit cycles" in done.stderr or "then explicit" in done.stdout
    return {"verdict": verdict, "cycles": int(rows[-1]["cycle"]), "kinetic": kinetic, "crest": crest, "explicit": explicit}


def row_of(stones, cell, who, found, newton):
    answer = lambda crest: f"{crest[0]:.2f}, {crest[1]:.3f}"  # noqa: E731
    there = newton is not None and newton["verdict"] == "converged" and not newton["explicit"]
    values = [stones, *cell, who, found["verdict"], found["cycles"], f"{found['kinetic']:.1e}", answer(found["crest"]),
              "" if newton is None else answer(newton["crest"]) if there else "none found"]  # fmt: skip
    return dict(zip(HEAD, map(str, values)))


def kept():
    path = DATA / "stones.csv"
    return list(csv.DictReader(path.open(encoding="utf-8"))) if path.exists() else []


def keep(rows):
    rows = sorted(rows, key=lambda row: int(row["stones"]))
    with open(DATA / "stones.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, HEAD)
        writer.writeheader()
        writer.writerows(rows)
    titles = [name.replace(", degree", " [degree]").replace(", mm", " [mm]") for name in HEAD]
    replace_between("stones", table(titles, [[row[name] for name in HEAD] for row in rows]))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--before", help="an older program, for three rows of 598 stones")
    parser.add_argument("--stones", type=int, nargs="*", default=[100, 150, 598], choices=list(SIDES))
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for stones in options.stones:
            mesh = os.path.join(folder, f"{stones}.h5")
            write(mesh, voronoi_mesh(options=Options(seed=5, side=SIDES[stones])))
            rows = []
            for cell in design(stones):
                found, newton = run(options.quoin, folder, mesh, cell), run(options.quoin, folder, mesh, cell, NEWTON)
                rows.append(row_of(stones, cell, "now", found, newton))
                if options.before and stones == 598 and cell in ((45, *BASE[1:]), (75, *BASE[1:]), (75, 0.3, "t2pt", "large")):
                    rows.append(row_of(stones, cell, "before", run(options.before, folder, mesh, cell), None))
                print(*rows[-1].values(), flush=True)
            keep([row for row in kept() if row["stones"] != str(stones)] + rows)


if __name__ == "__main__":
    main()
