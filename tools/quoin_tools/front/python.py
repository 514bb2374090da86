"""run() for Python programs; results are arrays of numpy (quoin_tools.base.results)."""

import os
import subprocess
import tempfile

import yaml

from quoin_tools.base import solver
from quoin_tools.base.results import Results
from quoin_tools.base.scene import Loader

__all__ = ["Results", "RunError", "run"]

VERDICTS = (0, 3, 4, 6)  # exit codes of runs that have come to their end: done, diverged, undecided, collapsed


class RunError(ValueError):
    """Why there are no results: what the solver said, in its words; code is its exit code."""

    def __init__(self, message, code):
        super().__init__(message)
        self.code = code


def run(scene, ranks=1, keys=None, output=None, progress=False):
    """Results of a scene: a file, or a dictionary as the file would have it. keys: values of keys by their names, "loads.water.level": 33;
    output: folder of results in place of the scene's; progress: the solver's lines go to the terminal. A run whose stages did not all converge has
    results too: results.summary["stages"][-1]["verdict"]. RunError: there are none."""
    given = dict(keys or {}) | ({} if output is None else {"output": os.fspath(output)})
    if not isinstance(scene, dict):
        return run_file(os.fspath(scene), ranks, given, progress)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scene.yaml")
        with open(path, "w", encoding="utf-8") as file:
            yaml.safe_dump(scene, file, sort_keys=False)
        return run_file(path, ranks, given, progress)


def run_file(path, ranks, keys, progress):
    words = solver.command(["-options_file", path, *options(keys)], ranks)
    done = solver.run(words, env=solver.environment(ranks), stderr=subprocess.PIPE, stdout=None if progress else subprocess.DEVNULL)
    if done.returncode not in VERDICTS:
        said = [line for line in done.stderr.splitlines() if line.strip()]
        raise RunError(said[-1] if said else f"the solver ended with code {done.returncode} and said nothing", done.returncode)
    return Results(str(keys.get("output") or output_of(path)))


def output_of(path):
    """As the scene says; its numbers may carry units, which the solver knows."""
    with open(path, encoding="utf-8") as file:
        return str((yaml.load(file, Loader) or {}).get("output") or "out")  # noqa: S506 (a SafeLoader)


def options(keys):
    """Words of the command line that give keys of the scene their values."""
    words = []
    for key, value in keys.items():
        words += ["-" + key.replace(".", "_"), value_word(value)]
    return words


def value_word(value):
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        return ",".join(value_word(item) for item in value)
    return repr(value) if isinstance(value, float) else str(value)
