"""Cost of the start-up and of finding contacts again: nanoseconds per block of each part, and its exponent.

    python tests/benchmark/detection.py --quoin build/quoin --sides 100 316 1000 --ranks 2 --json out.json
    python tests/benchmark/detection.py --instructions          # also counted by valgrind, at the first size
    python tests/benchmark/detection.py --held 0.9              # what `upgradeable: false` saves, for nine tenths of the blocks

The blocks are a square grid of single rigid blocks, each a macroblock: the most faces, near pairs and contacts that
a number of blocks can have. Contacts are verified at the start of a stage of variable connectivity, so that stages of
one cycle each measure it. The exponent is that of cost against number of blocks between the first and the last size;
1 is linear. Memory is the largest of a rank."""

import argparse
import json
import math
import os
import re
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools")]

from driver import ENVIRONMENT, dump  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.stacks import block_grid  # noqa: E402

STAGES = 3
VERIFICATION = ("Verification", "VerifyFarFaces", "VerifyNearFaces", "VerifyFaces", "VerifyVertices", "VerifyHistory")
SETUP = ("SetUpReading", "SetUpChecks", "SetUpOrder", "SetUpPartition", "SetUpDistribution", "SetUpModel", "SetUpContacts",
         "SetUpOutput")


def grid(side, held):
    """side by side blocks; the lower part `held` of them in a group of that name."""
    mesh = block_grid(side, side, 1, 1)
    mesh.group_names, mesh.group_rigid = ["block", "held"], mesh.group_rigid.repeat(2)
    mesh.block_group[: round(held * side) * side] = 1
    return mesh


def scene(upgradeable=True):
    material = {"density": 2400, "rigid": True}
    stage = {"loads": ["weight"], "variable": True, "max_cycles": 1, "ramp": 1}
    return {"materials": {"block": material, "held": material | {"upgradeable": upgradeable}},
            "joints": {"default": {"k_n": 10e9, "k_s": 3e9, "friction": 35}},
            "supports": {"bottom": {"fix": "xy"}},
            "relaxation": {"check_every": 1, "allow_floating": True, "tolerance": 1e30, "velocity_tolerance": 1e30},
            "loads": {"weight": {"type": "self_weight"}},
            "stages": [{f"s{i}": stage} for i in range(STAGES)]}


def run(command, folder):
    done = subprocess.run(command, cwd=folder, env=ENVIRONMENT | dict(os.environ), capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}: exit code {done.returncode}\n{done.stdout}{done.stderr}")


def measure(quoin, folder, side, ranks, held=0.0, upgradeable=True):
    """Seconds by part: of one verification, of the whole set-up and its parts."""
    write(os.path.join(folder, "model.h5"), grid(side, held))
    Path(folder, "scene.yaml").write_text(dump(scene(upgradeable)), encoding="utf-8")
    run(["mpirun", "-q", "-n", str(ranks), "--oversubscribe", "--bind-to", "none", quoin, "-options_file", "scene.yaml",
         "-log_view", ":log.txt"], folder)
    log = Path(folder, "log.txt").read_text(encoding="utf-8")
    seconds = {}
    for part in VERIFICATION + SETUP:
        row = re.search(rf"^{part}\s+(\d+)\s+\S+\s+(\S+)", log, re.M)
        seconds[part] = float(row[2]) / int(row[1]) if row else 0.0
    # the event of the distribution has that of the partition inside
    seconds["SetUpDistribution"] = max(0.0, seconds["SetUpDistribution"] - seconds["SetUpPartition"])
    seconds["SetUp"] = sum(seconds[part] for part in SETUP)
    return seconds


def instructions(quoin, folder):
    """Instructions of one verification, on one rank."""
    run(["valgrind", "--tool=callgrind", "--toggle-collect=ContactsVerify", "--callgrind-out-file=callgrind.out", quoin,
         "-options_file", "scene.yaml"], folder)
    text = Path(folder, "callgrind.out").read_text(encoding="utf-8")
    return int(re.search(r"^summary: (\d+)", text, re.M)[1]) / STAGES


def exponent(rows, part):
    first, last = rows[0], rows[-1]
    if len(rows) < 2 or min(first["seconds"][part], last["seconds"][part]) < 1e-3:
        return None
    return math.log(last["seconds"][part] / first["seconds"][part]) / math.log(last["blocks"] / first["blocks"])


def table(rows, ranks):
    lines = [f"ns per block, {ranks} rank(s)".ljust(24) + "".join(f"{row['blocks']:>12d}" for row in rows) + "    exponent"]
    for part in VERIFICATION + ("SetUp",) + SETUP:
        power = exponent(rows, part)
        lines.append(part.ljust(24) + "".join(f"{1e9 * row['seconds'][part] / row['blocks']:12.0f}" for row in rows)
                     + (f"{power:12.2f}" if power is not None else "           -"))
    lines.append("set-up, s".ljust(24) + "".join(f"{row['seconds']['SetUp']:12.2f}" for row in rows))
    lines.append("memory of a rank, MiB".ljust(24) + "".join(f"{row['memory_MiB']:12.0f}" for row in rows))
    return "\n".join(lines)


def compare_held(quoin, side, ranks, held, count):
    """Verification with and without upgradeable: false in `held` of the blocks: seconds, or instructions."""
    cost = {}
    for upgradeable in (True, False):
        with tempfile.TemporaryDirectory() as folder:
            seconds = measure(quoin, folder, side, ranks, held, upgradeable)["Verification"]
            cost[upgradeable] = instructions(quoin, folder) if count else 1e9 * seconds
    unit = "instructions" if count else "ns"
    return (f"a verification of {side**2} blocks, {ranks} rank(s), {held:g} of them not upgradeable: {cost[True] / side**2:.0f} -> "
            f"{cost[False] / side**2:.0f} {unit} per block, {cost[True] / cost[False]:.2f} times less")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--sides", type=int, nargs="+", default=[100, 316, 1000], help="blocks in a row of the grid")
    parser.add_argument("--ranks", type=int, default=1)
    parser.add_argument("--instructions", action="store_true", help="count them with valgrind at the first size")
    parser.add_argument("--held", type=float, help="this part of the blocks with and without upgradeable: false, at each size")
    parser.add_argument("--json", help="file for the figures")
    options = parser.parse_args()
    quoin, rows, counted = os.path.abspath(options.quoin), [], None
    if options.held is not None:
        for side in sorted(options.sides):
            print(compare_held(quoin, side, options.ranks, options.held, options.instructions))
        return
    for side in sorted(options.sides):
        with tempfile.TemporaryDirectory() as folder:
            seconds = measure(quoin, folder, side, options.ranks)
            memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
            rows.append({"blocks": side**2, "seconds": seconds, "memory_MiB": memory})
            if options.instructions and len(rows) == 1:
                counted = instructions(quoin, folder) / side**2
    print(table(rows, options.ranks))
    if counted is not None:
        print(f"instructions of a verification: {counted:.0f} per block at {rows[0]['blocks']} blocks")
    if options.json:
        figures = {"ranks": options.ranks, "rows": rows, "instructions_per_block": counted,
                   "exponent": {part: exponent(rows, part) for part in VERIFICATION + ("SetUp",) + SETUP}}
        Path(options.json).write_text(json.dumps(figures, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
