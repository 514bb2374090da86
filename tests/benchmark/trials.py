"""Studies to failure by explicit cycles and by Newton's method with creep: brackets, and what they cost.

    PYTHONPATH=tools python tests/benchmark/trials.py --quoin build/quoin [--only voronoi]

The strength reductions and the flood of the examples guilhofrei_sliding and guilhofrei_voronoi (three seeds). Effort is of the
study's stage alone, seconds are user CPU of the whole run on one rank, output included. Exit code 1 when the two disagree on a
bracket. Writes docs/data/trials.json, where other studies stay, and the table of docs/generated/benchmarks.md."""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools"), str(ROOT / "tests" / "benchmark")]

from driver import ENVIRONMENT  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from record import keep, replace_between, table  # noqa: E402

# name: example, scene, mesh and its arguments, options
STUDIES = {
    "S1, friction": ("sliding", "scene", ("mesh", ), ("-stages", "sw,swhp,swhpu,s1")),
    "S2, friction": ("sliding", "scene_s2", ("mesh_s2", ), ()),
    "S3, strengths": ("sliding", "scene", ("mesh", ), ("-stages", "sw,swhp,swhpuk,s3")),
    "S4, flood": ("sliding", "scene", ("mesh", ), ("-stages", "sw,swhp,swhpu,s4")),
} | {f"Voronoi, seed {seed}": ("voronoi", "scene", ("mesh", str(seed)), ()) for seed in (1, 2, 3)}


def run(quoin, folder, study, method):
    """What the last stage says, and user seconds of the run."""
    example, scene, (mesh, *arguments), options = study
    here, model = ROOT / "examples" / f"guilhofrei_{example}", os.path.join(folder, "model.h5")
    subprocess.run([sys.executable, here / f"{mesh}.py", model, *arguments], check=True, stdout=subprocess.DEVNULL,
                   env=os.environ | {"PYTHONPATH": str(ROOT / "tools")})
    command = [quoin, "-options_file", here / f"{scene}.yaml", "-model", model, "-output", os.path.join(folder, "out"),
               "-relaxation_method", method, *options]
    process = subprocess.Popen(command, env=os.environ | ENVIRONMENT, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RuntimeError(f"{' '.join(map(str, command))}: exit code {process.returncode}")
    results = Results(os.path.join(folder, "out"))
    return results.stage_summary(results.stages[-1]), usage.ru_utime


METHODS = {"explicit": "explicit", "Newton": "preconditioned"}  # name in the table: in the scene
HEADER = ["study", "by", "bracket", "trials", "force evaluations", "of one trial, the most", "solves", "factorisations", "user time [s]"]


def row(quoin, name, by):
    with tempfile.TemporaryDirectory() as folder:
        stage, seconds = run(os.path.abspath(quoin), folder, STUDIES[name], METHODS[by])
    found = stage.get("flood") or stage["strength_reduction"]
    return {"study": name, "by": by, "bracket": [found["stable"], found["failing"]], "trials": len(found["trials"]),
            "force_evaluations": stage["force_evaluations"], "longest": max(trial["cycles"] for trial in found["trials"]),
            "solves": stage["solves"], "factorisations": stage["factorisations"], "seconds": seconds}  # fmt: skip


def cells(row):
    bracket, seconds = ", ".join(f"{end:.6g}" for end in row["bracket"]), f"{row['seconds']:.2f}"
    return [row["study"], row["by"], bracket, row["trials"], row["force_evaluations"], row["longest"], row["solves"], row["factorisations"], seconds]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--only", default="", help="studies whose name holds this")
    options = parser.parse_args()
    names, agree = [name for name in STUDIES if options.only.lower() in name.lower()], True
    if not names:
        parser.error(f"no study {options.only}; there are: {'; '.join(STUDIES)}")
    print(*HEADER, sep=", ")
    for name in names:
        found = []
        for by in METHODS:
            found.append(row(options.quoin, name, by))
            print(*cells(found[-1]), sep=", ", flush=True)
        agree &= found[0]["bracket"] == found[1]["bracket"]
        rows = keep("trials", found, ("study", "by"))
    rows.sort(key=lambda row: list(STUDIES).index(row["study"]))
    replace_between("trials", table(HEADER, map(cells, rows)))
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main())
