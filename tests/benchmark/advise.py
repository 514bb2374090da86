#!/usr/bin/env python3
"""What `-advise` says stages take against what they take: trials by Newton's method, on the studies of trials.py and on
three more scenes; cycles, on the examples.

    PYTHONPATH=tools python tests/benchmark/advise.py --quoin build/quoin

Writes the tables of docs/generated/benchmarks.md between their marks and prints the largest factor between the two."""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools"), str(ROOT / "tests" / "benchmark")]

from driver import ENVIRONMENT  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from record import replace_between, table  # noqa: E402
from trials import STUDIES  # noqa: E402

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


STONE = {"density": 2400, "young": 10e9, "poisson": 0.2}
JOINT = {"stress_model": "tptm", "k_n": 10e9, "k_s": 3e9, "friction": 45}
REDUCE = {"type": "strength_reduction", "what": "friction"}
WEIGHT_WATER = {"loads": ["weight", "water"]}
# dams, a wall and polygons beside the examples: generator and its arguments, scene
OWN = {
    "dam of 60 m, friction": (("dam", "--height", "60", "--crest-width", "8", "--columns", "20"), {
        "relaxation": {"tolerance": 1e-6, "groups": ["dam"]}, "materials": {"dam": STONE, "rock": STONE}, "joints": {"base": JOINT},
        "supports": {"rock_sides": {"fix": "x"}, "rock_bottom": {"fix": "y"}},
        "loads": {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": {"type": "reservoir", "faces": "upstream", "level": 60.0, "density": 1000}},
        "stages": [{"sw": {"loads": ["weight"]}}, {"swhp": WEIGHT_WATER}, {"reduction": REDUCE | WEIGHT_WATER | {"step": 2, "limit": 10, "bracket": 0.1}}]}),
    "wall of 125 stones, pushed": (("walls", "wall", "--deformable", "--blocks", "12", "--courses", "10"), {
        "materials": {"block": STONE, "base": STONE}, "joints": {"default": JOINT}, "supports": {"base": {"fix": "xy"}},
        "loads": {"weight": {"type": "self_weight"}, "push": {"type": "traction", "faces": "left", "value": [10e3, 0]}},
        "stages": [{"sw": {"loads": ["weight"]}}, {"push": {"loads": ["weight", "push"]}},
                   {"reduction": REDUCE | {"loads": ["weight", "push"], "step": 2, "limit": 4, "bracket": 0.25}}]}),
    "Voronoi, sides of 2.5 m, seed 7": (("voronoi", "--side", "2.5", "--seed", "7", "--square"), {
        "contact": {"tolerance": 0.005}, "materials": {"dam": STONE, "facing": STONE}, "joints": {"joint": JOINT}, "supports": {"base": {"fix": "xy"}},
        "loads": {"weight": {"type": "self_weight"}, "water": {"type": "reservoir", "faces": "upstream", "level": 33.0, "density": 1000}},
        "stages": [{"sw": {"loads": ["weight"]}}, {"swhp": WEIGHT_WATER}, {"reduction": REDUCE | WEIGHT_WATER | {"start": 30, "step": 1, "limit": 8}}]}),
}  # fmt: skip


def prepared(case, folder):
    """Scene and model of a case of EXAMPLES, trials.STUDIES or OWN, as words of a command."""
    environment = ENVIRONMENT | dict(os.environ) | {"PYTHONPATH": str(ROOT / "tools")}
    model = os.path.join(folder, "model.h5")
    if isinstance(case[-1], dict):
        (generator, *arguments), keys = case
        kind, rest = arguments[:1] if generator == "walls" else [], arguments[1:] if generator == "walls" else arguments
        made, options = ["-m", "quoin_tools", "import", generator, *kind, "-o", model, *rest], ()
        scene = os.path.join(folder, "scene.yaml")
        Path(scene).write_text(yaml.safe_dump({"model": "model.h5"} | keys, sort_keys=False), encoding="utf-8")
    else:
        name, scene, (mesh, *arguments), options = case
        name = name if (ROOT / "examples" / name).exists() else f"guilhofrei_{name}"
        made, scene = [f"examples/{name}/{mesh}.py", model, *arguments], f"examples/{name}/{scene}.yaml"
    subprocess.run([sys.executable, *made], cwd=ROOT, env=environment, check=True, capture_output=True)
    return ["-options_file", scene, "-model", model, "-output", os.path.join(folder, "out"), *options]


def ran(command, folder):
    subprocess.run(command, cwd=ROOT, env=ENVIRONMENT | dict(os.environ), check=True, capture_output=True)
    return Results(os.path.join(folder, "out")).summary["stages"]


def advice(quoin, words):
    return subprocess.run([quoin, *words, "-advise", "0.01"], cwd=ROOT, env=ENVIRONMENT | dict(os.environ), check=True, capture_output=True, text=True).stdout


def compare(quoin, case, folder):
    """[(stage, cycles said, cycles run)]"""
    words = prepared(case, folder)
    said = advice(quoin, words)
    return [(stage["name"], int(re.search(rf"^{stage['name']} +\d+ +(\d+)", said, re.M)[1]), stage["cycles"])
            for stage in ran([quoin, *words], folder)]


def compare_newton(quoin, case, folder):
    """Of the stage of trials: its name; trials, evaluations, solves: said, (least, most), run; seconds said and run."""
    words = prepared(case, folder)
    said = advice(quoin, words)
    stage = next(s for s in ran([quoin, *words, "-relaxation_method", "preconditioned"], folder) if "flood" in s or "strength_reduction" in s)
    name, trials = stage["name"], (stage.get("flood") or stage["strength_reduction"])["trials"]
    first, second = (line.split() for line in re.findall(rf"^{name} .*$", said, re.M)[:2])
    guess = [float(word) for word in second[1:]]
    return (name, (float(first[1]), len(trials)), (guess[:3], stage["force_evaluations"]), (guess[3:], stage["solves"]),
            (float(first[-1]), sum(trial["wall_s"] for trial in trials)))


NEWTON = ["study", "trials said", "run", "evaluations said", "range", "run", "solves said", "range", "run", "seconds said [s]", "run [s]"]


def newton_rows(quoin):
    """Lines of the table, and how many of the cases lie in the range said."""
    lines, inside = [], 0
    for name, case in (STUDIES | OWN).items():
        with tempfile.TemporaryDirectory() as folder:
            _, trials, evaluations, solves, seconds = compare_newton(quoin, case, folder)
        within = [guess[1] <= run <= guess[2] for guess, run in (evaluations, solves)]
        inside += all(within)
        cells = [cell for (guess, run), hit in zip((evaluations, solves), within)
                 for cell in (f"{guess[0]:.0f}", f"{guess[1]:.0f}-{guess[2]:.0f}", f"{run}{'' if hit else ' (outside)'}")]
        lines.append([name, f"{trials[0]:.0f}", trials[1], *cells, f"{seconds[0]:.2g}", f"{seconds[1]:.2g}"])
        print(*lines[-1], sep=", ", flush=True)
    return lines, inside


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--newton", action="store_true", help="trials by Newton's method alone; cycles stay")
    options = parser.parse_args()
    rows, inside = newton_rows(os.path.abspath(options.quoin))
    replace_between("advise newton", table(NEWTON, rows))
    print(f"{inside} of {len(rows)} studies within what was said")
    if options.newton:
        return
    lines, worst = [], 1.0
    for example in EXAMPLES:
        with tempfile.TemporaryDirectory() as folder:
            for stage, said, run in compare(os.path.abspath(options.quoin), EXAMPLES[example], folder):
                lines.append([example, stage, said, run, f"{said / run:.2f}"])
                print(*lines[-1], sep=", ", flush=True)
                worst = max(worst, said / run, run / said)
    replace_between("advise", table(["example", "stage", "said [cycles]", "run [cycles]", "ratio"], lines))
    print(f"largest factor {worst:.2f}")


if __name__ == "__main__":
    main()
