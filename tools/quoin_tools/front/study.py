"""A scene over values of its keys: one run for each combination, and a table.

    quoin study scene.yaml joints.base.friction=35,40,45
                [loads.water.level=30,33] [-n RANKS] [-o FOLDER]
                [-j JOBS] [-key value ...]

Runs go into FOLDER/1, FOLDER/2, ... (out/study), JOBS of them at a time (1),
with what the solver said in log.txt; the table is printed and is
FOLDER/study.csv: verdict and trials of each stage, bodies that overturned,
sliding factor of every joint. A run that collapses or stays undecided is a row
of it; a scene that the solver refuses ends the study. One that was ended goes
on where it was, if it is begun again. Folders that a larger study has left
there stay; a line names them."""

import csv
import io
import os
import sys

from quoin_tools.base import solver
from quoin_tools.base.files import write_file
from quoin_tools.front.running import UsageError, split


def main(words):
    if not words or words[0] in ("-h", "--help"):
        print(__doc__.strip())
        return 0 if words else 2
    from quoin_tools.ensemble import design, running
    from quoin_tools.ensemble.journal import Journal
    from quoin_tools.ensemble.models import Named, Refused

    folder, jobs, varied, rest = options_of(words)
    scene, ranks, keys = split(rest, with_ranks=True)
    wanted = design.of_values(scene, varied, keys, ranks)
    journal = Journal(folder, wanted)
    running.forget_others(journal, lambda row: os.path.isfile(os.path.join(folder, str(row.sample + 1), "summary.json")))
    try:
        with solver.stopping():
            running.run(wanted, folder, jobs, report=report if sys.stderr.isatty() else None, judge=Named)
    except Refused as error:
        print(error, file=sys.stderr)
        return error.code
    write(folder, list(varied), [row for index, values in enumerate(running.Samples(wanted).all) for row in rows_of(index + 1, values, os.path.join(folder, str(index + 1)))])
    os.remove(journal.path)  # begun once more it runs all of them
    if older := earlier_runs(folder, len(running.Samples(wanted).all)):
        print(f"{folder}: {', '.join(map(str, older))}: of an earlier study, not in the table")
    return 0


def earlier_runs(folder, runs):
    """Returns the numbers of folders of runs that a larger study has left there."""
    return sorted(int(name) for name in os.listdir(folder) if name.isascii() and name.isdigit() and int(name) > runs)


def report(rows, done, left, _began):
    print(f"\r{done} done, {left} left   ", end="" if left else "\n", file=sys.stderr, flush=True)


def options_of(words):
    """Returns the folder, the number of runs at a time, the values of each key that varies, and the remaining words."""
    from quoin_tools.ensemble.design import option

    folder, jobs, varied, rest, words = os.path.join("out", "study"), "1", {}, [], list(words)
    while words:
        word = words.pop(0)
        name, equals, values = word.partition("=")
        if word in ("-o", "--output") and words:
            folder = words.pop(0)
        elif word in ("-j", "--jobs") and words:
            jobs = words.pop(0)
        elif word.startswith("-") or not equals or os.path.exists(word):  # a scene may have such a name
            rest.append(word)
            if word.startswith("-") and words and not words[0].startswith("-") and "=" not in words[0]:
                rest.append(words.pop(0))
        elif not name or not all(values.split(",")):
            raise UsageError(f"{word}: expected a key and values, such as joints.base.friction=35,40,45")
        elif same := next((other for other in varied if option(other) == option(name)), None):
            raise UsageError(f"{name}: given twice; expected all of its values in one list, such as {name}={','.join(varied[same])},{values}")
        else:
            varied[name] = values.split(",")
    if twice := [name for name in varied if any(word.startswith("-") and option(word[1:]) == option(name) for word in rest)]:
        raise UsageError(f"{twice[0]}: it varies, and -{twice[0]} gives it a value too")
    if not varied:
        raise UsageError("nothing varies: expected a key and values, such as joints.base.friction=35,40,45")
    if not jobs.isdigit() or int(jobs) < 1:
        raise UsageError(f"-j {jobs}: expected a number >= 1")
    return folder, int(jobs), varied, rest


COMMON = ("stage", "verdict", "stable", "failing", "overturned", "joint", "sliding factor")
SHOWN = 6  # joints in the terminal; all of them are in study.csv


def rows_of(number, values, output):
    """Returns for each stage of a run (values of COMMON, sliding factor of each joint). overturned: number of bodies; joint: the one nearest to sliding."""
    from quoin_tools.base.results import Results, fixed, sliding, trials_of

    rows = []
    for stage in Results(output).summary["stages"]:
        found = trials_of(stage) or {}
        factors = {name: joint["sliding_factor_peak"] for name, joint in stage["joints"].items() if joint["sliding_factor_peak"] is not None}
        least = min(factors, key=factors.get, default=None)
        over = sum(body["overturned"] is not None for body in stage.get("bodies", [])) if "balance" in stage.get("energy", {}) else "-"
        rows.append(((number, *values, stage["name"], stage["verdict"], fixed(found.get("stable"), digits=4), fixed(found.get("failing"), digits=4),
                      over, least or "-", sliding(factors.get(least))), {name: sliding(factors.get(name)) for name in stage["joints"]}))  # fmt: skip
    return rows


def write(folder, names, rows):
    from quoin_tools.base.terminal import table

    joints = list(dict.fromkeys(joint for _, factors in rows for joint in factors))
    header = ("run", *names, *COMMON)
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([(*header, *(f"sliding factor {joint}" for joint in joints)), *((*row, *(factors.get(joint, "-") for joint in joints)) for row, factors in rows)])
    path = os.path.join(folder, "study.csv")
    write_file(path, text.getvalue())
    shown = joints[:SHOWN] if len(joints) > 1 else []
    print("\n".join(table((*header, *shown), [(*row, *(factors.get(joint, "-") for joint in shown)) for row, factors in rows])))
    if len(joints) > len(shown) > 0:
        print(f"sliding factors of {len(joints) - len(shown)} more joints are in {path}")
    print(f"wrote {path}")
