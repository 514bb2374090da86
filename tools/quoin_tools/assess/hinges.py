"""Finds how a limit moves with k_n: runs the trials of a scene again with ten and a hundred times the stiffness of all joints.

    quoin limit --hinges scene.yaml [--quoin build/quoin] [--part 0.01] [-model model.h5 ...]

Limits of rigid blocks come from below as k_n^(-1/3), once little is missing: the two stiffest give the one of rigid hinges, what is
missing to it, and the k_n at which it is missed by --part. Stiffness goes up tenfold, three times at most, until that moves no limit
by more than 2 %. The hinges of the mechanism are pressed over a part of their faces. docs/rigid_blocks.md. Options that it does not know
go to quoin."""

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
ENOUGH = 0.02  # of a limit: it moves by less with RATIO times k_n, and the power holds
MOST = 3  # times that k_n goes up
BEYOND = 1 / (RATIO ** (1 / 3) - 1)  # missing part of the limit, over its change with ten times k_n


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
        turning = stage.get("hinges", {}).get("governing")
        found[stage["name"]] = study["stable"], study["width"], turning or last.get("hinges", {}).get("least")
    return found


def words(value, digits=4):
    return "-" if value is None else f"{value:.{digits}g}"


def moves(softer, stiffer):
    """Returns by which part each limit moves, for the stages that both runs have."""
    return {name: abs(stiffer[name][0] - softer[name][0]) / abs(stiffer[name][0]) for name in softer if name in stiffer and stiffer[name][0]}


def compared(runs, part):
    """Returns rows: stage, limits, the limit of rigid hinges, compressed parts, and the factor on k_n at which `part` of that limit is missing. runs: limits of each stiffness."""
    rows = []
    for name in runs[0]:
        if not all(name in found for found in runs):
            continue
        (a, width, pressed), (b, _, pressed_stiff), before = runs[0][name], runs[-1][name], runs[-2][name][0]
        rigid = b + BEYOND * (b - before)
        missing = abs(rigid - a) / abs(rigid) if rigid else None
        missing_stiff = abs(rigid - before) / abs(rigid) if rigid else None
        times = None if missing_stiff is None or pressed is None else max(1.0, RATIO ** (len(runs) - 2) * (missing_stiff / part) ** 3)
        rows.append((name, words(a), words(width, 2), words(b), words(RATIO ** (len(runs) - 1)), words(rigid), words(missing, 2), words(pressed, 2),
                     words(pressed_stiff, 2), words(times, 2)))  # fmt: skip
    return rows


def main(arguments=None):
    parser = Parser(prog="quoin limit --hinges", description="How limits move with k_n.")
    parser.add_argument("scene")
    parser.add_argument("--quoin", help="the solver (that of the command quoin)")
    parser.add_argument("--part", type=float, default=0.01, help="part of the limit of rigid hinges that may be missing (0.01)")
    given, options = parser.parse_known_args(arguments)
    if not 0 < given.part < 1:
        parser.error(f"--part {given.part:g}: expected a number between 0 and 1")
    try:
        program = given.quoin or solver.find()
        joints = scenes.parse(solver.settled(given.scene, options, program), given.scene).joints
        runs = []
        with tempfile.TemporaryDirectory() as folder:
            for tenfolds in range(MOST + 1):
                options_of_run = [*options, *stiffer(joints, RATIO**tenfolds)] if tenfolds else options
                runs.append(limits(run(program, given.scene, options_of_run, os.path.join(folder, f"run_{tenfolds}"))))
                if not runs[0] or tenfolds and max(moves(*runs[-2:]).values(), default=0.0) <= ENOUGH:
                    break
        if not runs[0]:
            raise ResultsError(f"{given.scene}: no stage of trials that has found a stable value")
    except (ResultsError, scenes.SceneError, solver.SolverError, OSError) as error:
        print(f"limit: {error}", file=sys.stderr)
        return 2
    header = ("stage", "limit", "bracket", "stiffest", "with k_n times", "rigid hinges", "missing", "pressed over", "stiffest", f"k_n times, for {given.part:g}")
    print("\n".join(table(header, compared(runs, given.part))))
    for name, part in moves(*runs[-2:]).items():
        if part > ENOUGH:
            print(f"limit: stage {name}: the last ten times k_n still move the limit by {100 * part:.2g} %; that of rigid hinges is not yet known to as much")
    return 0
