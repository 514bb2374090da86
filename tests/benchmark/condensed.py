"""Condensed bodies: the friction reduction S1 of section G1 against plain relaxation and against one sparse solve.

    PYTHONPATH=tools python tests/benchmark/condensed.py --quoin build/quoin --runs solve explicit newton plain

User CPU seconds of whole runs on one rank, least of `--repeat` (of plain relaxation: one run, minutes): the study with
dam and rock condensed, explicit and with Newton's method; a sparse Cholesky solution of the same mesh under its weight
(one stage with relaxation.method preconditioned, less a run that does not relax); and the study by plain relaxation, when
it is asked for. Last stable and first failing angle and the crest must agree; exit code 1 when they do not. Writes
docs/data/condensed.json, where runs that are not asked for stay, and the table of docs/generated/benchmarks.md."""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / path) for path in ("tests/verification", "tests/benchmark", "tools", "examples/guilhofrei_sliding")]

from driver import ENVIRONMENT  # noqa: E402
from mesh import key_mesh  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from record import keep, replace_between, table  # noqa: E402

CONDENSED = ["-materials_dam_condensed", "true", "-materials_rock_condensed", "true"]
STUDY = ["-stages", "sw,swhp,swhpu,s1", "-stages_s1_bracket", "0.05"]
NEWTON = ["-relaxation_method", "preconditioned"]
SOLVE, PLAIN = "one sparse Cholesky solve", "S1, plain relaxation"
NAMES = {"solve": SOLVE, "explicit": "S1, condensed, explicit", "newton": "S1, condensed, Newton's method", "plain": PLAIN}
OPTIONS = {"explicit": STUDY + CONDENSED, "newton": STUDY + CONDENSED + NEWTON, "plain": STUDY}
BARE = ["-stages", "sw", "-relaxation_tolerance", "1e30", "-relaxation_velocity_tolerance", "1e30", "-relaxation_check_every", "1",
        "-relaxation_ramp", "1"]  # set-up and output
WITH_SOLVE = ["-stages", "sw", *NEWTON, "-strain", "small"]


def run(quoin, folder, options):
    """User CPU seconds of one run, and its summary."""
    command = [quoin, "-options_file", str(ROOT / "examples" / "guilhofrei_sliding" / "scene.yaml"), "-model", "model.h5",
               "-output", "out", "-relaxation_method", "explicit", *options]
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(command, cwd=folder, env=ENVIRONMENT | dict(os.environ), capture_output=True, text=True, check=False)
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return seconds, json.loads(Path(folder, "out", "summary.json").read_text(encoding="utf-8"))


def least(quoin, folder, options, repeat):
    runs = [run(quoin, folder, options) for _ in range(repeat)]
    return min(seconds for seconds, _ in runs), runs[-1][1]


def row_of(quoin, folder, name, repeat):
    """Seconds; of a study last stable and first failing angle [degree], trials, crest u_x [m] of the last stable state."""
    if name == "solve":
        bare, summary = least(quoin, folder, BARE, repeat)
        seconds, _ = least(quoin, folder, WITH_SOLVE, repeat)
        return {"run": SOLVE, "blocks": summary["n_blocks"], "seconds": seconds - bare}
    seconds, summary = least(quoin, folder, OPTIONS[name], 1 if name == "plain" else repeat)
    stage = summary["stages"][-1]
    reduction = stage["strength_reduction"]
    return {"run": NAMES[name], "blocks": summary["n_blocks"], "seconds": seconds, "stable": reduction["stable"], "failing": reduction["failing"],
            "trials": len(reduction["trials"]), "crest": stage["probes"]["crest_upstream"]["u_x"]}  # fmt: skip


def cells_of(rows):
    """Of the table: seconds in solves of the same mesh, and how much less than by plain relaxation."""
    at, cells = {(row["blocks"], row["run"]): row["seconds"] for row in rows}, []
    for row in sorted(rows, key=lambda row: (row["blocks"], row["seconds"])):
        solve, plain = at.get((row["blocks"], SOLVE)), at.get((row["blocks"], PLAIN))
        study = [f"{row['stable']:.4f}, {row['failing']:.4f}", row["trials"], f"{1e3 * row['crest']:.5f}"] if "stable" in row else [""] * 3
        cells.append([row["run"], row["blocks"], f"{row['seconds']:.3g}", f"{row['seconds'] / solve:.1f}" if solve else "",
                      f"{plain / row['seconds']:.0f}" if plain and study[0] else "", *study])  # fmt: skip
    return cells


def main():
    parser = argparse.ArgumentParser(description="Benchmark of condensed bodies.")
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"), help="the program (%(default)s)")
    parser.add_argument("--columns", type=int, default=100, help="of the dam; blocks: 3 columns^2 (%(default)s)")
    parser.add_argument("--repeat", type=int, default=3, help="runs of each kind (%(default)s)")
    parser.add_argument("--runs", nargs="+", default=["solve", "explicit", "newton"], choices=list(NAMES), help="the others stay (%(default)s)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        write(os.path.join(folder, "model.h5"), key_mesh(options.columns))
        for name in options.runs:
            row = row_of(os.path.abspath(options.quoin), folder, name, options.repeat)
            rows = keep("condensed", [row], ("blocks", "run"))
            print(*row.values(), sep=", ", flush=True)
    header = ["run", "blocks", "user time [s]", "sparse Cholesky solves", "times less than plain", "stands, fails [degree]", "trials", "crest [mm]"]
    replace_between("condensed", table(header, cells_of(rows)))
    found = [r for r in rows if r["blocks"] == row["blocks"] and "stable" in r]
    return int(any((r["stable"], r["failing"]) != (found[0]["stable"], found[0]["failing"]) or abs(r["crest"] / found[0]["crest"] - 1) > 1e-3
                   for r in found))  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
