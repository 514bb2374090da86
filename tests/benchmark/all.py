#!/usr/bin/env python3
"""Makes every file of docs/data, with its charts and tables, by the command that measures it, one after the other: hours.

    PYTHONPATH=tools python tests/benchmark/all.py                       # after cmake --build build -j
    PYTHONPATH=tools python tests/benchmark/all.py seepage stones        # these programs alone
    PYTHONPATH=tools python tests/benchmark/all.py --list                # what each writes; runs nothing

Exit code 1: a program has failed; its name is printed at the end, and the others have run all the same."""

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
WRITES = {  # files of docs/data by the program that measures them; accuracy draws a chart of what motion has measured
    "cycle": ["cycle.json"],
    "scaling": ["scaling.csv"],
    "motion": ["motion.csv"],
    "accuracy": ["accuracy.csv"],
    "yielding": ["yielding_accuracy.csv"],
    "seepage": ["seepage_accuracy.csv", "seepage_stability.csv"],
    "stability": ["stability.csv"],
    "damping": ["damping_stability.csv"],
    "step_control": ["step_control.csv"],
    "stones": ["stones.csv"],
    "many_stones": ["many_stones.json", "stones_map.json", "stones_goals.json"],
    "method": ["method.csv"],
    "best": ["best.json"],
    "preconditioned": ["preconditioned.json"],
    "condensed": ["condensed.json"],
    "trials": ["trials.json"],
    "probabilities": ["probabilities.json"],
    "peers": ["peers.json"],
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", nargs="*", metavar="program", help=f"{', '.join(WRITES)} (all)")
    parser.add_argument("--list", action="store_true", help="what each writes; nothing runs")
    options = parser.parse_args()
    unknown = [name for name in options.programs if name not in WRITES]
    if unknown:
        parser.error(f"no program {unknown[0]}: there are {', '.join(WRITES)}")
    failed = []
    for name in options.programs or WRITES:
        print(f"{name}.py: {', '.join(f'docs/data/{file}' for file in WRITES[name])}", flush=True)
        if options.list:
            continue
        start = time.monotonic()
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, [str(ROOT / "tools"), os.environ.get("PYTHONPATH")]))}
        if subprocess.run([sys.executable, HERE / f"{name}.py"], cwd=ROOT, env=environment).returncode:
            failed.append(name)
        print(f"{name}.py: {time.monotonic() - start:.0f} s", flush=True)
    if failed:
        sys.exit(f"failed: {', '.join(failed)}")


if __name__ == "__main__":
    main()
