#!/usr/bin/env python3
"""Cycles that `-advise` says a stage takes against those it takes, on the examples.

    PYTHONPATH=tools python tests/benchmark/advise.py --quoin build/quoin

Writes the table of docs/performance.md between its marks and prints the largest factor between the two."""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools"), str(ROOT / "tests" / "benchmark")]

from driver import ENVIRONMENT  # noqa: E402
from quoin_tools.results import Results  # noqa: E402
from record import replace_between, table  # noqa: E402

SLIDING = "guilhofrei_sliding"
# words: (example, scene, mesh script and its arguments, options)
EXAMPLES = {
    "fig6": ("fig6", "scene", ("mesh",), ()),
    "fig6, friction 45 degrees": ("fig6", "scene", ("mesh",), ("-joints_base_law", "mohr_coulomb", "-joints_base_friction", "45")),
    "guilhofrei": ("guilhofrei", "scene", ("mesh",), ()),
    "guilhofrei_local": ("guilhofrei_local", "scene", ("mesh",), ()),
    "guilhofrei_sliding, S1": (SLIDING, "scene", ("mesh",), ("-stages", "sw,swhp,swhpu,s1")),
    "guilhofrei_sliding, S2": (SLIDING, "scene_s2", ("mesh_s2",), ()),
    "guilhofrei_sliding, S3": (SLIDING, "scene", ("mesh",), ("-stages", "sw,swhp,swhpuk,s3")),
    "guilhofrei_sliding, S4": (SLIDING, "scene", ("mesh",), ("-stages", "sw,swhp,swhpu,s4")),
    "guilhofrei_voronoi, seed 1": ("guilhofrei_voronoi", "scene", ("mesh", "1"), ("-stages", "sw,swhp")),
}  # fmt: skip


def compare(quoin, example, folder):
    """[(stage, cycles said, cycles run)]"""
    name, scene, (mesh, *arguments), options = EXAMPLES[example]
    environment = ENVIRONMENT | dict(os.environ) | {"PYTHONPATH": str(ROOT / "tools")}
    model, out = os.path.join(folder, "model.h5"), os.path.join(folder, "out")
    subprocess.run([sys.executable, f"examples/{name}/{mesh}.py", model, *arguments], cwd=ROOT, env=environment, check=True, capture_output=True)
    command = [quoin, "-options_file", f"examples/{name}/{scene}.yaml", "-model", model, "-output", out, *options]
    said = subprocess.run([*command, "-advise", "0.01"], cwd=ROOT, env=environment, check=True, capture_output=True, text=True).stdout
    subprocess.run(command, cwd=ROOT, env=environment, check=True, capture_output=True)
    summary = Results(out).summary["stages"]
    return [(stage["name"], int(re.search(rf"^{stage['name']} +\d+ +(\d+)", said, re.M)[1]), stage["cycles"]) for stage in summary]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    options = parser.parse_args()
    lines, worst = [], 1.0
    for example in EXAMPLES:
        with tempfile.TemporaryDirectory() as folder:
            for stage, said, run in compare(os.path.abspath(options.quoin), example, folder):
                lines.append([example, stage, said, run, f"{said / run:.2f}"])
                print(*lines[-1], sep=", ", flush=True)
                worst = max(worst, said / run, run / said)
    replace_between("advise", table(["example", "stage", "said", "run", "ratio"], lines))
    print(f"largest factor {worst:.2f}")


if __name__ == "__main__":
    main()
