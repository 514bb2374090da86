"""A static state with friction by Newton's method, against one sparse Cholesky solve and the paper's relaxation.

    PYTHONPATH=tools python tests/benchmark/preconditioned.py --quoin build/quoin

The dam of Fig. 6, N by N blocks, friction 45 degrees at its base: it opens at the heel and slips. Seconds are user CPU of
one rank, the least of three runs, less those of the same run stopped after one cycle (reading, set-up, output). "elastic" has an elastic joint: one
assembly, one factor and a few solves, the honest bar. "paper" is (35)-(38) alone with its default ramp, stopped when it has
taken --cap times the seconds of Newton's method, up to the size --paper; error is of crest displacement and toe stress
against Newton's state. Memory is the largest of the process, less that of the stopped run, per block.
Writes docs/data/preconditioned.json, where other sizes stay, and the table of docs/generated/benchmarks.md."""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools"), str(ROOT / "tests" / "benchmark"), str(ROOT / "examples" / "fig6")]

from driver import ENVIRONMENT, changed, dump, load  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from record import keep, replace_between, table  # noqa: E402
from triangle_dam import triangle_dam  # noqa: E402

JOINT = {"k_n": 30e9, "k_s": 10e9, "friction": 45, "stress_model": "t2pt"}
PROBE = 4000  # [cycles] for the cost of one; over 400 the noise of a run was a fifth
REPEATS = 3


def resident(pid):
    """Largest memory so far [MiB]."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text(encoding="utf-8").splitlines()
    except OSError:
        return 0.0
    return max((int(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM")), default=0.0)


def run(quoin, folder, scene):
    """User seconds, MiB, and the summary of the stage."""
    Path(folder, "scene.yaml").write_text(dump(scene), encoding="utf-8")
    process = subprocess.Popen([quoin, "-options_file", "scene.yaml"], cwd=folder, env=ENVIRONMENT | dict(os.environ),
                               stdout=subprocess.DEVNULL)
    done, most = 0, 0.0
    while not done:  # the usage of this process alone; its ru_maxrss would begin with that of Python
        time.sleep(0.01)
        most = max(most, resident(process.pid))
        done, status, usage = os.wait4(process.pid, os.WNOHANG)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in (0, 4):
        raise RuntimeError(f"{folder}: exit code {process.returncode}")
    return usage.ru_utime, most, Results(folder + "/out").stage_summary("full")


def least(quoin, folder, scene):
    return min((run(quoin, folder, scene) for _ in range(REPEATS)), key=lambda found: found[0])


def error(stage, exact):
    """Larger of the relative errors of crest displacement and toe stress."""
    pairs = [(s["probes"]["crest"]["u_x"], s["joints"]["base"]["end"]["sigma"]) for s in (stage, exact)]
    return max(abs(a / b - 1) for a, b in zip(*pairs))


def cycles(n):
    """Changes of the scene that stop it after so many cycles."""
    return (("relaxation.max_cycles", n), ("relaxation.check_every", n), ("relaxation.ramp", 0))


def measure(quoin, folder, n, paper, cap):
    mesh = triangle_dam(n)
    write(os.path.join(folder, "model.h5"), mesh)
    relaxation = {"tolerance": 1e-6, "velocity_tolerance": 1, "history_every": 10000}
    base = changed(load("fig6").SCENE, ("relaxation", relaxation), ("joints.default", JOINT))
    newton = changed(base, ("relaxation.method", "preconditioned"))
    stop, bare, _ = least(quoin, folder, changed(base, *cycles(1)))
    elastic, _, _ = least(quoin, folder, changed(newton, ("joints.default.law", "elastic")))
    seconds, most, stage = least(quoin, folder, newton)
    row = {"blocks": len(mesh.blocks), "elastic_s": elastic - stop, "newton_s": seconds - stop, "set_up_s": stop,
           "over_elastic": (seconds - stop) / (elastic - stop), "evaluations": stage["force_evaluations"],
           "solves": stage["solves"], "method": stage["method"], "bytes_per_block": (most - bare) * 2**20 / len(mesh.blocks)}
    if n <= paper:
        old = changed(base, ("relaxation.damping", "paper"))
        probe, _, _ = run(quoin, folder, changed(old, *cycles(PROBE)))
        most_cycles = int(cap * row["newton_s"] / max((probe - stop) / PROBE, 1e-9))
        taken, _, end = run(quoin, folder, changed(old, ("relaxation.max_cycles", most_cycles)))
        row |= {"paper_s": taken - stop, "paper_cycles": end["cycles"], "paper_verdict": end["verdict"],
                "paper_error": error(end, stage), "paper_over_newton": (taken - stop) / row["newton_s"]}
    return row


def row_of_table(row):
    """Cells of the table."""
    paper = ""
    if "paper_s" in row:
        what = "error still" if row["paper_verdict"] != "converged" else "converged, error"
        paper = f"{row['paper_cycles']} cycles, {row['paper_s']:.3g} s, {row['paper_over_newton']:.0f} times as long: {what} {100 * row['paper_error']:.2g} %"
    return [row["blocks"], f"{row['elastic_s']:.2g}", f"{row['newton_s']:.2g}", f"{row['over_elastic']:.1f}", row["evaluations"], row["solves"],
            f"{row['bytes_per_block']:.0f}", paper]  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--sizes", type=int, nargs="+", default=[64, 128, 316])
    parser.add_argument("--paper", type=int, default=128, help="largest size that is also run with the paper's relaxation")
    parser.add_argument("--cap", type=float, default=25.0, help="times the seconds of Newton's method")
    options = parser.parse_args()
    header = ["blocks", "elastic [s]", "Newton [s]", "ratio", "force evaluations", "solves", "memory [B a block]", "paper"]
    print(*header, sep=", ")
    for n in options.sizes:
        with tempfile.TemporaryDirectory() as folder:
            row = measure(os.path.abspath(options.quoin), folder, n, options.paper, options.cap)
        rows = sorted(keep("preconditioned", [row], ("blocks",)), key=lambda row: row["blocks"])
        print(*row_of_table(row), sep=", ", flush=True)
    replace_between("preconditioned", table(header, map(row_of_table, rows)))


if __name__ == "__main__":
    main()
