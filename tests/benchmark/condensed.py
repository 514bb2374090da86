"""Condensed bodies: the friction reduction S1 of section G1 against plain relaxation and against one sparse solve.

    PYTHONPATH=tools python tests/benchmark/condensed.py --quoin build/quoin --columns 100 --plain --json out.json

User CPU seconds of whole runs on one rank, least of `--repeat` (of plain relaxation: one run, minutes): the study with
dam and rock condensed, explicit and with Newton's method; a sparse Cholesky solution of the same mesh under its weight
(one stage with relaxation.method preconditioned, less a run that does not relax); and, with --plain, the study by plain
relaxation. Last stable and first failing angle and the crest must agree; exit code 1 when they do not."""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools"), str(ROOT / "examples" / "guilhofrei_sliding")]

from driver import ENVIRONMENT  # noqa: E402
from mesh import key_mesh  # noqa: E402
from quoin_tools.blockmesh import write  # noqa: E402

CONDENSED = ["-materials_dam_condensed", "true", "-materials_rock_condensed", "true"]
STUDY = ["-stages", "sw,swhp,swhpu,s1", "-stages_s1_bracket", "0.05"]
NEWTON = ["-relaxation_method", "preconditioned"]
RUNS = {"S1, condensed, explicit": STUDY + CONDENSED,
        "S1, condensed, Newton's method": STUDY + CONDENSED + NEWTON,
        "set-up and output": ["-stages", "sw", "-relaxation_tolerance", "1e30", "-relaxation_velocity_tolerance", "1e30",
                              "-relaxation_check_every", "1", "-relaxation_ramp", "1"],
        "set-up, sparse Cholesky solve, output": ["-stages", "sw", *NEWTON, "-strain", "small"]}


def run(quoin, folder, options):
    """User CPU seconds of one run, and its summary."""
    command = [quoin, "-options_file", str(ROOT / "examples" / "guilhofrei_sliding" / "scene.yaml"), "-model", "model.h5",
               "-output", "out", *options]
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(command, cwd=folder, env=ENVIRONMENT | dict(os.environ), capture_output=True, text=True, check=False)
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return seconds, json.loads(Path(folder, "out", "summary.json").read_text(encoding="utf-8"))


def outcome(summary):
    """Last stable angle, first failing angle [degree], crest u_x [m] of the last stable state."""
    stage = summary["stages"][-1]
    reduction = stage["strength_reduction"]
    return reduction["stable"], reduction["failing"], stage["probes"]["crest_upstream"]["u_x"]


def main():
    parser = argparse.ArgumentParser(description="Benchmark of condensed bodies.")
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"), help="the program (%(default)s)")
    parser.add_argument("--columns", type=int, default=100, help="of the dam; blocks: 3 columns^2 (%(default)s)")
    parser.add_argument("--repeat", type=int, default=3, help="runs of each kind (%(default)s)")
    parser.add_argument("--plain", action="store_true", help="also by plain relaxation")
    parser.add_argument("--json", help="write the numbers")
    options = parser.parse_args()
    quoin, seconds, found = os.path.abspath(options.quoin), {}, {}
    with tempfile.TemporaryDirectory() as folder:
        write(os.path.join(folder, "model.h5"), key_mesh(options.columns))
        for name, words in RUNS.items():
            runs = [run(quoin, folder, words) for _ in range(options.repeat)]
            seconds[name] = min(s for s, _ in runs)
            if "S1" in name:
                found[name] = outcome(runs[-1][1])
        if options.plain:
            seconds["S1, plain relaxation"], summary = run(quoin, folder, STUDY)
            found["S1, plain relaxation"] = outcome(summary)
    solve = seconds["set-up, sparse Cholesky solve, output"] - seconds["set-up and output"]
    study = seconds["S1, condensed, explicit"]
    ratios = {"condensed study over one sparse solve": study / solve}
    if options.plain:
        ratios["plain relaxation over condensed study"] = seconds["S1, plain relaxation"] / study
    for name, value in seconds.items():
        ends = "  stable {:.5f}, fails {:.5f} degree, crest {:.6e} m".format(*found[name]) if name in found else ""
        print(f"{name:42s} {value:8.2f} s{ends}")
    for name, value in ratios.items():
        print(f"{name:42s} {value:8.2f}")
    if options.json:
        Path(options.json).write_text(json.dumps({"columns": options.columns, "seconds": seconds, "found": found,
                                                  "ratios": ratios}, indent=1), encoding="utf-8")
    first = next(iter(found.values()))
    return int(any(f[:2] != first[:2] or abs(f[2] / first[2] - 1) > 1e-3 for f in found.values()))


if __name__ == "__main__":
    sys.exit(main())
