"""run, check and advise: the solver with a scene.

    quoin run [-n RANKS] scene.yaml [-key value ...]
        runs it; results go to the folder that its key `output` names
    quoin check scene.yaml [-key value ...]
        reads and checks scene and mesh, runs nothing, writes nothing
    quoin advise scene.yaml [-key value ...]
        what a run would cost, and what could be left out within 1 %

A key is given anew as -joints_base_friction 40; `quoin help` says which there
are. Exit codes: 0 done, 2 bad input, 3 diverged, 4 undecided, 5 interrupted,
6 collapsed; `quoin help "exit codes"` has all of them."""

import subprocess
import sys

from quoin_tools.base import solver

ACCURACY = "0.01"  # of advise, unless its key is given
SAYS, WARNS = "quoin: ", "quoin: warning:"  # on stderr
SET_UP = "memory [MB]"  # what the solver says first behind set-up, when it is asked for advice


class UsageError(ValueError):
    """What is wrong with the words behind a command, in one line."""


def split(words, with_ranks=False):
    """(scene, ranks, what goes to the solver)"""
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
    """A number may begin with a minus."""
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
    """The solver sets up what it would run. When it goes on to what that costs, nothing is left to be checked, and it is ended."""
    if asks_for_help(words):
        return 0
    scene, _, keys = split(words)
    started = solver.command(["-options_file", scene, *keys, "-advise", ACCURACY])
    doubts = 0
    with solver.start(started, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=solver.environment()) as process:
        for line in process.stdout:
            if line.startswith(SET_UP):
                process.kill()  # it writes nothing when it gives advice
                found = f"{doubts} warning{'s' * (doubts > 1)}" if doubts else "nothing is wrong with it"
                print(f"{scene}: {found}, and nothing was run")
                return 0
            doubts += line.startswith(WARNS)
            print(line, end="", file=sys.stderr if line.startswith(SAYS) else sys.stdout, flush=True)
    return process.returncode if process.returncode >= 0 else 128 - process.returncode
