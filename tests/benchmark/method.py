#!/usr/bin/env python3
"""From how many degrees of freedom on is Newton's method the faster way to the equilibrium of elastic joints?

    PYTHONPATH=tools python tests/benchmark/method.py --quoin build/quoin                # all sizes: about six minutes
    PYTHONPATH=tools python tests/benchmark/method.py --quoin build/quoin --most 20000   # up to so many degrees of freedom

Weight on Voronoi dams (seed 5, elastic stones), on walls of elastic and of rigid stones, and on the dam of Fig. 6 (one body on one joint); all
joints of `law: elastic`, tolerance 1e-6. Seconds: of processor time of the whole run, the least of three below 5 s. Difference: the largest of
displacements over the largest. `relaxation.method: auto` (method.c) has its bound from here.
Writes docs/data/method.csv (rows of a scene that has run replace those before) and the table of docs/generated/benchmarks.md."""

import argparse
import csv
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import yaml

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools"), str(ROOT / "examples" / "fig6")]

from driver import ENVIRONMENT  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh.blockmesh import macroblocks, write  # noqa: E402
from quoin_tools.mesh.voronoi import Options, voronoi_mesh  # noqa: E402
from quoin_tools.mesh.walls import wall  # noqa: E402
from record import DATA, replace_between, table  # noqa: E402
from triangle_dam import triangle_dam  # noqa: E402

STONE = {"density": 2400, "young": 10e9, "poisson": 0.2}
JOINTS = {"default": {"law": "elastic", "k_n": 10e9, "k_s": 3e9}}
VORONOI = {100: 2.75, 150: 1.6, 598: 0.6, 2070: 0.3}
WALLS = [(10, 10), (16, 16), (25, 24), (45, 40), (140, 142)]
DAMS = [8, 16, 32, 64, 128, 256]
HEAD = ["scene", "stones", "degrees of freedom", "explicit: cycles", "explicit, s", "Newton: solves", "Newton, s", "difference"]


def scenes():
    """(name, mesh, degrees of freedom at least)."""
    for stones, side in VORONOI.items():
        yield "Voronoi dam", lambda side=side: voronoi_mesh(options=Options(seed=5, side=side)), 10 * stones
    for rigid in (False, True):
        for blocks, courses in WALLS:
            what = "wall, rigid stones" if rigid else "wall, elastic stones"
            yield what, lambda b=blocks, c=courses, r=rigid: wall(b, c, rigid=r), (3 if rigid else 8) * blocks * courses
    for n in DAMS:
        yield "dam of Fig. 6", lambda n=n: triangle_dam(n, "M"), 2 * n * n


def run(program, folder, method):
    """Processor seconds, cycles, solves, degrees of freedom, displacements."""
    least, repeat = np.inf, 0
    while repeat < 3:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [program, "-options_file", "scene.yaml", "-relaxation_method", method, "-checkpoint_minutes", "0"]
        subprocess.run(command, cwd=folder, env=os.environ | ENVIRONMENT, stdout=subprocess.DEVNULL, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        least = min(least, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
        repeat += 3 if least > 5 else 1
    results = Results(os.path.join(folder, "out"))
    stage = results.stage_summary("sw")
    if stage["verdict"] != "converged" or stage["method"] != method:
        raise RuntimeError(f"{stage['verdict']}, {stage['method']}")
    return least, stage["cycles"], stage["solves"], results.summary["n_dofs"], results.stage("sw").displacement


def measure(program, what, mesh):
    with tempfile.TemporaryDirectory() as folder:
        write(os.path.join(folder, "model.h5"), mesh)
        stones = [name for name in mesh.group_names if name not in ("base", "ground")]
        scene = {"model": "model.h5", "output": "out", "joints": JOINTS, "relaxation": {"max_cycles": 2000000},
                 "materials": {name: STONE if name in stones else {"density": 0} for name in mesh.group_names},
                 "supports": {"ground" if "ground" in mesh.group_names else "base": {"fix": "xy"}},
                 "loads": {"weight": {"type": "self_weight", "groups": stones}},
                 "stages": [{"sw": {"loads": ["weight"]}}]}  # fmt: skip
        Path(folder, "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
        slow, cycles, _, dofs, one = run(program, folder, "explicit")
        fast, _, solves, _, other = run(program, folder, "preconditioned")
    apart = np.hypot(*(one - other).T).max() / np.hypot(*other.T).max()
    values = [what, len(np.unique(macroblocks(mesh))), dofs, cycles, f"{slow:.2f}", solves, f"{fast:.2f}", f"{apart:.1e}"]
    return dict(zip(HEAD, map(str, values)))


def kept():
    path = DATA / "method.csv"
    return list(csv.DictReader(path.open(encoding="utf-8"))) if path.exists() else []


def keep(row):
    same = ("scene", "stones", "degrees of freedom")
    rows = [old for old in kept() if any(old[name] != row[name] for name in same)] + [row]
    rows.sort(key=lambda row: (row["scene"], int(row["degrees of freedom"])))
    with open(DATA / "method.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, HEAD)
        writer.writeheader()
        writer.writerows(rows)
    titles = [name.replace(", s", " [s]") for name in HEAD]
    replace_between("method", table(titles, [[row[name] for name in HEAD] for row in rows]))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--most", type=float, default=np.inf, help="degrees of freedom")
    options = parser.parse_args()
    for what, mesh, dofs in sorted(scenes(), key=lambda scene: scene[2]):
        if dofs > options.most:
            continue
        row = measure(os.path.abspath(options.quoin), what, mesh())
        print(*row.values(), sep=", ", flush=True)
        keep(row)


if __name__ == "__main__":
    main()
