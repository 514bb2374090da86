"""How a limit moves with k_n: the trials of a scene again with ten times the stiffness of all joints.

    quoin hinges scene.yaml [--quoin build/quoin] [--part 0.01] [-model model.h5 ...]

Limits of rigid blocks come from below as k_n^(-1/3): two of them give the one of rigid hinges, what is missing to it, and the
k_n at which it is missed by --part. A hinge is pressed over a part of its face; what is missing counts, because one wall has hinges of many lengths. docs/rigid_blocks.md. Options that it does not know go to quoin."""

import os
import subprocess
import sys
import tempfile

from quoin_tools.base import scene as scenes
from quoin_tools.base import solver
from quoin_tools.base.command import Parser
from quoin_tools.base.results import Results, ResultsError
from quoin_tools.base.terminal import table

TRIALS = ("strength_reduction", "flood", "load_factor", "anchor_force")
RATIO = 10.0
BEYOND = 1 / (RATIO ** (1 / 3) - 1)  # of the change with ten times k_n, what is still missing


def stiffer(joints, times):
    """Options of quoin."""
    return [word for name, row in joints.items() for key in ("k_n", "k_s") if key in (row or {})
            for word in (f"-joints_{name}_{key}", f"{times * float(row[key]):.10g}")]  # fmt: skip


def run(quoin, path, options, folder):
    command = [quoin, "-options_file", path, *options, "-output", folder]
    done = solver.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    if not os.path.exists(os.path.join(folder, "summary.json")):
        raise ResultsError((done.stderr.strip() or f"{quoin}: no results").splitlines()[-1])
    return Results(folder)


def limits(results):
    """Stage of trials to (last stable value, width of the bracket, compressed part of the face there)."""
    found = {}
    for stage in results.summary["stages"]:
        study = next((stage[kind] for kind in TRIALS if kind in stage), None)
        if study is None or study["stable"] is None:
            continue
        last = next(t for t in study["trials"] if t["value"] == study["stable"])
        found[stage["name"]] = study["stable"], study["width"], last.get("hinges", {}).get("least")
    return found


def words(value, digits=4):
    return "-" if value is None else f"{value:.{digits}g}"


def compared(once, ten, part):
    """Rows: stage, limits, what rigid hinges would give, compressed parts, and k_n times what makes it `part`."""
    rows = []
    for name in once:
        if name not in ten:
            continue
        (a, width, pressed), (b, _, pressed_ten) = once[name], ten[name]
        rigid = b + BEYOND * (b - a)
        missing = abs(rigid - a) / abs(rigid) if rigid else None
        times = None if missing is None or pressed is None else max(1.0, (missing / part) ** 3)
        rows.append((name, words(a), words(width, 2), words(b), words(rigid), words(missing, 2), words(pressed, 2), words(pressed_ten, 2), words(times, 2)))
    return rows


def main(arguments=None):
    parser = Parser(prog="quoin hinges", description="How limits move with k_n.")
    parser.add_argument("scene")
    parser.add_argument("--quoin", help="the solver (that of the command quoin)")
    parser.add_argument("--part", type=float, default=0.01, help="part of the limit of rigid hinges that may be missing (0.01)")
    given, options = parser.parse_known_args(arguments)
    try:
        program = given.quoin or solver.find()
        joints = scenes.parse(solver.settled(given.scene, options, program), given.scene).joints
        with tempfile.TemporaryDirectory() as folder:
            once, ten = (limits(run(program, given.scene, [*options, *more], os.path.join(folder, name)))
                         for name, more in (("once", []), ("ten", stiffer(joints, RATIO))))  # fmt: skip
        if not once:
            raise ResultsError(f"{given.scene}: no stage of trials that has found a stable value")
    except (ResultsError, scenes.SceneError, solver.SolverError, OSError) as error:
        print(f"hinges: {error}", file=sys.stderr)
        return 2
    header = ("stage", "limit", "bracket", "with 10 k_n", "rigid hinges", "missing", "pressed over", "with 10 k_n", f"k_n times, for {given.part:g}")
    print("\n".join(table(header, compared(once, ten, given.part))))
    return 0
