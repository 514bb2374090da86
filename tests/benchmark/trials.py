"""Studies to failure by explicit cycles and by Newton's method with creep: brackets, and what they cost.

    PYTHONPATH=tools python tests/benchmark/trials.py --quoin build/quoin [--json out.json] [--only voronoi]

The strength reductions and the flood of the examples guilhofrei_sliding and guilhofrei_voronoi (three seeds). Effort is of the
study's stage alone, seconds are user CPU of the whole run on one rank, output included. --before OTHER: the same by Newton's method of
another build, in between. Exit code 1 when two methods disagree on a bracket."""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools")]

from driver import ENVIRONMENT  # noqa: E402
from quoin_tools.results import Results  # noqa: E402

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


def row(quoin, study, method):
    with tempfile.TemporaryDirectory() as folder:
        stage, seconds = run(os.path.abspath(quoin), folder, study, method)
    found = stage.get("flood") or stage["strength_reduction"]
    return {"bracket": [found["stable"], found["failing"]], "trials": len(found["trials"]), "seconds": seconds, "method": stage["method"],
            "longest": max(trial["cycles"] for trial in found["trials"])} | {
                key: stage[key] for key in ("force_evaluations", "solves", "factorisations")}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--before", help="another build of the program, for its Newton's method")
    parser.add_argument("--only", default="", help="studies whose name holds this")
    parser.add_argument("--json", help="file for the rows")
    options = parser.parse_args()
    runs = [("explicit", options.quoin, "explicit"), ("Newton", options.quoin, "preconditioned")]
    if options.before:
        runs.insert(1, ("before", options.before, "preconditioned"))
    rows, agree = {}, True
    print("| study | by | bracket | trials | force evaluations | of one trial, the most | solves | factorisations | user s |\n"
          "|---|---|---|---:|---:|---:|---:|---:|---:|")
    for name, study in STUDIES.items():
        if options.only.lower() not in name.lower():
            continue
        rows[name] = {by: row(quoin, study, method) for by, quoin, method in runs}
        agree &= all(r["bracket"] == rows[name]["explicit"]["bracket"] for r in rows[name].values())
        for by, r in rows[name].items():
            print(f"| {name} | {by} | {r['bracket'][0]:.6g}, {r['bracket'][1]:.6g} | {r['trials']} | {r['force_evaluations']} | {r['longest']} | "
                  f"{r['solves']} | {r['factorisations']} | {r['seconds']:.2f} |", flush=True)
    if options.json:
        Path(options.json).write_text(json.dumps(rows, indent=1), encoding="utf-8")
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main())
