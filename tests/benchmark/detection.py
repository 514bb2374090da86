"""Cost of finding contacts anew: rigid blocks in a grid, nanoseconds per block of a verification.

    python tests/benchmark/detection.py --quoin build/quoin --sides 100 316 1000

Contacts are verified at the start of a stage of variable connectivity, so that stages of one cycle each measure it."""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools")]

from driver import ENVIRONMENT, dump  # noqa: E402
from quoin_tools.blockmesh import write  # noqa: E402
from quoin_tools.stacks import block_grid  # noqa: E402

STAGES = 3


def scene():
    stage = {"loads": ["weight"], "variable": True, "max_cycles": 1, "ramp": 1}
    return {"materials": {"block": {"density": 2400, "rigid": True}},
            "joints": {"default": {"k_n": 10e9, "k_s": 3e9, "friction": 35}},
            "supports": {"bottom": {"fix": "xy"}},
            "relaxation": {"check_every": 1, "allow_floating": True, "tolerance": 1e30, "velocity_tolerance": 1e30},
            "loads": {"weight": {"type": "self_weight"}},
            "stages": [{f"s{i}": stage} for i in range(STAGES)]}


def measure(quoin, side, ranks):
    """Seconds of a verification, least of the stages."""
    with tempfile.TemporaryDirectory() as folder:
        write(os.path.join(folder, "model.h5"), block_grid(side, side, 1, 1))
        Path(folder, "scene.yaml").write_text(dump(scene()), encoding="utf-8")
        command = ["mpirun", "-q", "-n", str(ranks), "--oversubscribe", "--bind-to", "none", quoin, "-options_file", "scene.yaml",
                   "-log_view", ":log.txt"]
        subprocess.run(command, cwd=folder, env=ENVIRONMENT | dict(os.environ), capture_output=True, check=False)
        row = re.search(r"^Verification\s+(\d+)\s+\S+\s+(\S+)", Path(folder, "log.txt").read_text(), re.M)
        return float(row[2]) / int(row[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--sides", type=int, nargs="+", default=[100, 316, 1000], help="blocks in a row of the grid")
    parser.add_argument("--ranks", type=int, default=1)
    options = parser.parse_args()
    print(f"{'blocks':>9}  {'s':>8}  ns per block of a verification, {options.ranks} rank(s)")
    for side in options.sides:
        seconds = measure(os.path.abspath(options.quoin), side, options.ranks)
        print(f"{side**2:9d}  {seconds:8.4f}  {1e9 * seconds / side**2:8.0f}", flush=True)


if __name__ == "__main__":
    main()
