"""Valgrind's memcheck on 2 ranks: blocks that slide with variable connectivity, a dam by Newton's method and by
cycles with the stiffness as mass, a restart.

    python tests/reliability/memcheck.py --quoin build/quoin

What Open MPI does itself is left out (its own suppressions and tests/valgrind.supp). Exit code 1: valgrind complains."""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import scenes
from run import ENVIRONMENT, Bench

SUPPRESSIONS = [path for path in (Path("/usr/share/openmpi/openmpi-valgrind.supp"), scenes.ROOT / "tests" / "valgrind.supp") if path.exists()]
COMPLAINT, OK, UNDECIDED = 99, 0, 4  # exit codes: of valgrind by its options here, and of include/quoin.h


def newton(scene):
    scene["relaxation"] |= {"increments": 2}
    del scene["stages"][1:]


def stiffness_mass(scene):
    newton(scene)
    scene["relaxation"] |= {"method": "stiffness_mass", "max_cycles": 20, "check_every": 10, "ramp": 10}


def short(scene):
    scene["relaxation"] |= {"max_cycles": 150, "check_every": 50}


RUNS = [  # scene, change, options of one run after the other
    ("variable", short, [("-checkpoint_every", 50), ("-restart", "auto")]),
    ("newton", newton, [()]),
    ("newton", stiffness_mass, [()]),
]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default="build/quoin")
    quoin = parser.parse_args().quoin
    failed = []
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(quoin, folder)
        for name, change, runs in RUNS:
            place = bench.prepare(name, change)
            for options in runs:
                command = ["mpirun", "-q", "-n", "2", "--oversubscribe", "--bind-to", "none", "valgrind", "-q", f"--error-exitcode={COMPLAINT}",
                           *(f"--suppressions={path}" for path in SUPPRESSIONS), bench.quoin, "-options_file", "scene.yaml", *map(str, options)]  # fmt: skip
                done = subprocess.run(command, cwd=place, capture_output=True, text=True, env=ENVIRONMENT | dict(os.environ))
                good = done.returncode in (OK, UNDECIDED) and "==" not in done.stderr
                print(f"{change.__name__} of {name} {' '.join(map(str, options))}: {'clean' if good else f'exit code {done.returncode}'}", flush=True)
                if not good:
                    failed.append(done.stdout + done.stderr)
    print("\n".join(failed), end="")
    return bool(failed)


if __name__ == "__main__":
    sys.exit(main())
