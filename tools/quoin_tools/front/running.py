"""Runs or checks a scene with the solver; checks a block mesh or a run.

    quoin run [-n RANKS] scene.yaml [-key value ...]
        runs it; results go to the folder that its key `output` names
    quoin check scene.yaml [-key value ...]
                [--guideline NAME [--guidelines FILE]]
        reads and checks scene and mesh, with each item of what_if; runs
        nothing, writes nothing; --guideline: says where its uplift differs from
        what the guideline asks for
    quoin check model.h5 [--tolerance 0.001] [--info]
        checks a block mesh and prints a summary of it; --info: only prints it
    quoin check out [...]
        finds damaged files in output folders, a line for each file
    quoin check --advise scene.yaml [-key value ...]
        what a run would cost, and what could be left out within 1 %

A key gets another value by -joints_base_friction 40; `quoin help` lists the
keys. Exit codes: 0 done, 2 bad input, 3 diverged, 4 undecided, 5 interrupted,
6 collapsed; `quoin help "exit codes"` has all of them."""

import os
import subprocess
import sys

from quoin_tools.base import solver
from quoin_tools.front import scene_check

ACCURACY = "0.01"  # relative error that -advise allows by default
SAYS, WARNS = "quoin: ", "quoin: warning:"  # on stderr
SET_UP = "memory [MB]"  # first line of -advise behind the set-up


class UsageError(ValueError):
    """The words behind a command are wrong; the message is one line."""


def split(words, with_ranks=False):
    """Returns scene, number of ranks, and the keys that go to the solver."""
    scene, ranks, keys, rest = None, 1, [], list(words)
    while rest:
        word = rest.pop(0)
        if with_ranks and word in ("-n", "-np", "--ranks"):
            value = rest.pop(0) if rest else ""
            if not value.isdigit() or int(value) < 1:
                raise UsageError(f"{word} {value}: expected a number of ranks".replace("  ", " "))
            ranks = int(value)
        elif word == "-options_file" and rest:
            scene = rest.pop(0)
        elif word.startswith("-") and len(word) > 1:
            keys.append(word)
            if rest and not is_option(rest[0]):
                keys.append(rest.pop(0))
        elif scene is None:
            scene = word
        else:
            raise UsageError(f"{word}: a second scene; one is run at a time")
    if scene is None:
        raise UsageError("no scene is given: expected a file such as scene.yaml")
    return scene, ranks, keys


def is_option(word):
    """Tells an option from a negative number."""
    return word.startswith("-") and word[1:2].isalpha()


def asks_for_help(words):
    if words[:1] in (["-h"], ["--help"]):
        print(__doc__.strip())
        return True
    return False


def run(words):
    if asks_for_help(words):
        return 0
    scene, ranks, keys = split(words, with_ranks=True)
    return solver.become(["-options_file", scene, *keys], ranks)


def advise(words):
    if asks_for_help(words):
        return 0
    scene, _, keys = split(words)
    return solver.become(["-options_file", scene, *([] if "-advise" in keys else ["-advise", ACCURACY]), *keys])


def check(words):
    """Checks a block mesh, output folders, or a scene with its mesh."""
    if asks_for_help(words):
        return 0
    if words and words[0].endswith(".h5"):
        from quoin_tools.mesh.blockmesh import main as check_mesh

        return check_mesh(words)
    if words and os.path.isdir(words[0]):
        from quoin_tools.base.integrity import main as check_folders

        return check_folders(words)
    guideline, file = taken(words, "--guideline"), taken(words, "--guidelines")
    if file and not guideline:
        raise UsageError("--guidelines: it belongs to a guideline, and --guideline names none")
    scene, _, keys = split(words)
    return check_scene(scene, keys, guideline, file)


def taken(words, option):
    """Takes an option with its value out of a list of words; returns the value, None without the option."""
    if option not in words:
        return None
    at = words.index(option)
    if at + 1 >= len(words) or is_option(words[at + 1]):
        raise UsageError(f"{option}: a value behind it is missing")
    value = words[at + 1]
    del words[at : at + 2]
    return value


def check_scene(scene, keys, guideline, file):
    """Lets the solver set up what it would run, and ends it before it measures what a run costs; then looks at what the solver does not. An error stands alone."""
    started, lines = solver.command(["-options_file", scene, *keys, "-advise", ACCURACY]), []
    with solver.start(started, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=solver.environment()) as process:
        for line in process.stdout:
            if line.startswith(SET_UP):
                process.kill()  # it writes nothing when it gives advice
                break
            lines.append(line)
        else:
            show(lines)
            code = process.wait()
            return code if code >= 0 else 128 - code
    found, wrong = scene_check.look(scene, keys, guideline, file)
    if wrong:
        print("\n".join(found), file=sys.stderr)
        return 2
    show(lines)
    show(f"{WARNS} {line}\n" for line in found)
    doubts = sum(line.startswith(WARNS) for line in lines) + len(found)
    print(f"{scene}: {f'{doubts} warning' + 's' * (doubts > 1) if doubts else 'nothing is wrong with it'}, and nothing was run")
    return 0


def show(lines):
    for line in lines:
        print(line, end="", file=sys.stderr if line.startswith(SAYS) else sys.stdout, flush=True)
