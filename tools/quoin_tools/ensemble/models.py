"""Judges a sample: by the solver, or by limit analysis. A process of the solver that ends harms no other sample.

    judged = Solver(design, folder).judge(values, sample, level)        (outcome, response or None, why)
"""

import contextlib
import importlib
import io
import json
import math
import os
import queue
import re
import shutil
import signal
import subprocess
import threading

import scipy

from quoin_tools.base import scene as scenes
from quoin_tools.base import solver
from quoin_tools.base.files import write_file
from quoin_tools.ensemble.design import option
from quoin_tools.ensemble.sampling import sobol
from quoin_tools.ensemble.variables import EnsembleError
from quoin_tools.ensemble.workers import Unshared, Worker
from quoin_tools.limit import LimitError, bounds
from quoin_tools.mesh.of_run import mesh_at, mesh_of_scene

REFUSED, COLLAPSED = 2, 6  # exit codes of the solver
SAYS_NOTHING = (2, 7, 8, 9, 10, 11)  # those of runs that say nothing about the structure
PIVOTS = 32  # samples that are solved first, over all levels
FALLS = "does not stand at its start"  # words of the solver where the first trial fails
MAKING = threading.Lock()  # meshes are made one after the other: the output of the command is captured


class Refused(EnsembleError):
    """The solver refuses the scene of a sample: the ensemble ends."""

    def __init__(self, message, code=REFUSED):
        super().__init__(message)
        self.code = code


def keys_of(design, values, level):
    """Returns {key of the scene: value} of a sample."""
    given = {key: design.files.get((key, str(value)), value) for one, value in zip(design.variables.each, values, strict=True) for key in one.keys if not key.startswith("mesh.")}
    return given | {key: level for key in design.level_keys if level is not None}


def make_mesh(design, values, path):
    """Makes the mesh of a sample by the generator that its words name."""
    given = {key.partition(".")[2]: value for one, value in zip(design.variables.each, values, strict=True) for key in one.keys if key.startswith("mesh.")}
    words = [re.sub(r"{(\w+)}", lambda found: plain(given[found[1]]), word) for word in design.mesh[1:]]
    os.makedirs(os.path.dirname(path), exist_ok=True)
    message = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(message):
        code = importlib.import_module(f"quoin_tools.mesh.{design.mesh[0]}").main([*words, "-o", path])
    if code:
        raise Refused(f"mesh: {' '.join(message.getvalue().split())}")


def plain(value):
    if isinstance(value, str):
        return value
    return str(int(value)) if float(value).is_integer() else repr(float(value))


def text_of(value):
    """Writes a value as the solver reads it, to the last digit."""
    return repr(value) if isinstance(value, float) else str(value)


def last_line(text):
    return next((line for line in reversed(text.splitlines()) if line.strip()), "")


def number_at(summary, path):
    """Returns a number of a stage by its path, joints.base.sliding_factor_peak; None where there is none."""
    place = summary
    for name in path.split("."):
        if not isinstance(place, dict) or name not in place:
            return None
        place = place[name]
    return float(place) if isinstance(place, (int, float)) and not isinstance(place, bool) else None


def missing_at(summary, path):
    """Returns (the part of a path that exists, the next name, which does not, the names that exist there); None: the whole path exists."""
    place, names = summary, path.split(".")
    for k, name in enumerate(names):
        if not isinstance(place, dict) or name not in place:
            return ".".join(names[:k]), name, list(place) if isinstance(place, dict) else []
        place = place[name]
    return None


def bare(path):
    """Returns a path without abs( )."""
    return path[4:-1] if path.startswith("abs(") and path.endswith(")") else path


class Solver:
    """Judges samples by the solver. Those that differ in numbers alone share processes (Worker), where the scene allows it; others, those with a mesh each, and those whose folder is kept have a process each."""

    processes = False  # children of threads

    def __init__(self, design, folder, keep=False, shares=True):
        self.design, self.folder, self.keep = design, folder, keep
        self.shares, self.looked, self.idle = shares and not (keep or design.mesh), False, queue.SimpleQueue()
        paths = [path for path in (design.condition.path if design.condition else None, design.response) if path]
        self.paths = list(dict.fromkeys(map(bare, paths)))

    def judge(self, values, sample, level):
        given = keys_of(self.design, values, level)
        worker = self.worker(given)
        return self.apart(values, sample, level) if worker is None else self.shared(worker, given, values, sample, level)

    def close(self):
        while not self.idle.empty():
            self.idle.get_nowait().close()

    # ---- a process that has many samples

    def worker(self, given):
        """Returns a process for a sample with these keys; None: it needs one of its own."""
        self.shares = self.shares and not any("," in str(value) for value in given.values())  # a table of samples has no such cells
        if self.shares:
            with contextlib.suppress(queue.Empty):
                return self.idle.get_nowait()
            with contextlib.suppress(Unshared):
                return Worker(self.design, self.header(given), self.pivots() if self.design.start == "nearest" else ())
            self.shares = False
        if self.design.start == "nearest":
            raise EnsembleError("start: nearest: samples that differ in these keys, or of this scene, cannot share a process")
        return None

    def header(self, keys):
        until = [f"until:{self.design.stage}"] if self.design.stage else []
        return ",".join(["sample", *keys, *(f"tell:{path}" for path in self.paths), *until])

    def row(self, name, given):
        empty = [""] * (len(self.paths) + bool(self.design.stage))  # of columns that ask for something
        return ",".join([name, *map(text_of, given.values()), *empty])

    def pivots(self):
        """Returns rows that spread evenly over the variables and levels."""
        points = scipy.special.ndtri(sobol(0, 0, PIVOTS, len(self.design.columns())))
        values = self.design.variables.values(points)
        return [self.row(f"pivot:{k}", keys_of(self.design, one, self.design.levels[k % len(self.design.levels)])) for k, one in enumerate(values)]

    def shared(self, worker, given, values, sample, level):
        row = worker.answer(self.row(str(sample), given), self.design.time_limit)
        if row is None:
            code, message, late = worker.close()
            return self.ended(code, message, late)
        self.idle.put(worker)
        outcome, why = row["outcome"], row["why"]
        if outcome == "refused":
            raise Refused(f"sample {sample}: {why}")
        if outcome == "fails":
            before = self.design.stage and row["stage"] != self.design.stage
            return "fails", None, FALLS if FALLS in why else "collapsed before" if before else "collapsed"
        if outcome == "undecided":
            return "undecided", None, why.partition(":")[0]
        if not self.looked and not all(row[path] for path in self.paths):
            self.looked = True  # a number is not there: a run of its own says whether its name is wrong
            self.apart(values, sample, level)
        return self.by_numbers(row["stage"], lambda path: float(row[path]) if row[path] else None)

    # ---- a process each

    def words(self, values, level, output, mesh=""):
        """Returns the command line of a sample, by which anybody can run it again."""
        given = [word for key, value in keys_of(self.design, values, level).items() for word in (option(key), text_of(value))]
        model = ["-model", mesh or self.design.model] if mesh or self.design.model else []
        return solver.command(["-options_file", self.design.scene, *model, *self.design.options, *given, "-output", output], self.design.ranks)

    def apart(self, values, sample, level):
        output = os.path.join(self.folder, "runs", f"{sample:06d}" + ("" if level is None else f"_{level:g}"))
        shutil.rmtree(output, ignore_errors=True)
        mesh = os.path.join(output, "model.h5") if self.design.mesh else ""
        if mesh:
            with MAKING:
                make_mesh(self.design, values, mesh)
        try:
            done = solver.run(self.words(values, level, output, mesh), self.design.time_limit, env=solver.environment_of_one(), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        except subprocess.TimeoutExpired:
            shutil.rmtree(output, ignore_errors=True)
            return self.ended(0, "", late=True)
        message = last_line(done.stderr)
        if done.returncode == REFUSED and FALLS in message:
            return "fails", None, FALLS
        if done.returncode == REFUSED:
            raise Refused(f"sample {sample}: {message}")
        answer = self.outcome(done.returncode, output, message)
        if not self.keep and done.returncode >= 0:
            shutil.rmtree(output, ignore_errors=True)
        return answer

    def ended(self, code, message, late=False):
        """Returns the outcome of a sample whose process has ended without results."""
        if late:
            return "undecided", None, f"longer than {self.design.time_limit:g} s"
        if code < 0:
            return "undecided", None, f"ended by {signal.Signals(-code).name}"
        return "undecided", None, message if message.startswith("quoin: error") else f"exit code {code} without results"

    def outcome(self, code, output, message):
        try:
            with open(os.path.join(output, "summary.json"), encoding="utf-8") as file:
                stages = json.load(file)["stages"] if code >= 0 else None
        except (OSError, ValueError, KeyError):
            stages = None
        if stages is None:
            return self.ended(code, message)
        wanted = self.design.stage
        stage = next((s for s in stages if s["name"] == wanted), None) if wanted else stages[-1]
        if wanted and stage is None and wanted not in (there := list(scenes.read(os.path.join(output, scenes.ECHO)).stages)):
            raise Refused(f"stage: no stage '{wanted}', there are: {', '.join(there)}")
        if stage is None:
            return ("fails", None, "collapsed before") if code == COLLAPSED else ("undecided", None, f"stage {wanted} was not reached (exit code {code})")
        if stage["verdict"] == "collapsed":
            return "fails", None, "collapsed"
        if stage["verdict"] == "completed" and self.design.condition is None:
            raise Refused(f"fail: collapsed: stage {stage['name']} goes in time, or has modes, and never collapses: expected a number of it, such as abs(peaks.joints.base.slip.largest) > 0.05")
        if stage["verdict"] not in ("converged", "completed"):
            return "undecided", None, stage["verdict"]
        self.check_paths(stage, output)
        return self.by_numbers(stage["name"], lambda path: number_at(stage, path))

    def check_paths(self, stage, output):
        """Checks that the wanted numbers have names of the stage. A joint of the scene may have no contact left in a sample."""
        for key, path in (("fail", self.design.condition and self.design.condition.path), ("response", self.design.response)):
            found = missing_at(stage, bare(path)) if path else None
            if found and not (found[0] == "joints" and found[1] in scenes.read(os.path.join(output, scenes.ECHO)).joints):
                before, name, there = found
                raise Refused(f"{key}: {path}: no '{name}' {f'in {before} ' if before else ''}of stage {stage['name']}, there are: {', '.join(there) or 'none'}")

    def by_numbers(self, stage, bare_number_of):
        """Returns the outcome of a sample whose stages stand. bare_number_of(path): a number of its stage, or None."""
        condition, response = self.design.condition, self.design.response

        def number_of(path):
            number = bare_number_of(bare(path))
            return abs(number) if number is not None and bare(path) != path else number

        value = None if response is None else number_of(response)
        if condition is None:
            return "stands", value, ""
        number = number_of(condition.path)
        if number is None:
            return "undecided", value, f"no number {condition.path} in stage {stage}"
        return ("fails" if condition.holds(number) else "stands"), value, ""


class Named(Solver):
    """Runs each sample into a folder with its number, where log.txt has all that the solver said."""

    def judge(self, values, sample, level):
        output = os.path.join(self.folder, str(sample + 1))
        done = solver.run(self.words(values, level, output), env=solver.environment(self.design.ranks), stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        write_file(os.path.join(output, "log.txt"), done.stdout)
        if done.returncode < 0 or done.returncode in SAYS_NOTHING:
            what = ", ".join(f"{name}={value}" for name, value in zip(self.design.columns(), values, strict=True))
            raise Refused(f"{what}: {last_line(done.stdout) or 'the solver said nothing'}", done.returncode if done.returncode > 0 else 128 - done.returncode)
        return {0: "stands", COLLAPSED: "fails"}.get(done.returncode, "undecided"), None, ""


def words_of(design, folder):
    """Returns options of the scene without its samples; where each sample has a mesh of its own, the mesh at the middle of the variables."""
    if not design.mesh:
        return [*(["-model", design.model] if design.model else []), *design.options]
    path = os.path.join(folder, "runs", "middle", "model.h5")
    make_mesh(design, design.variables.values([[0.0] * len(design.columns())])[0], path)
    return ["-model", path, *design.options]


class Limit:
    """Judges samples by limit analysis: milliseconds, no contact history; an upper bound (docs/limit_analysis.md)."""

    processes = True  # of their own, as they compute here

    def __init__(self, design, folder, keep=False):
        self.design = design
        self.folder, self.kept = folder, None
        self.scene = scenes.parse(solver.settled(design.scene, words_of(design, folder)), design.scene)
        self.stage = design.stage or list(self.scene.stages)[-1]
        if not design.mesh:
            self.mesh, self.kept = mesh_of_scene(self.scene)[0], bounds.Kept()
            bounds.bound(self.mesh, self.scene, self.stage, design.raises, kept=self.kept)  # limits of the method for this scene are reported once

    def mesh_of(self, values, sample):
        if not self.design.mesh:
            return self.mesh
        path = os.path.join(self.folder, "runs", f"{sample:06d}", "model.h5")
        make_mesh(self.design, values, path)
        mesh = mesh_at(path, self.scene)
        shutil.rmtree(os.path.dirname(path))
        return mesh

    def judge(self, values, sample, level):
        given = keys_of(self.design, values, level)
        try:
            answer = bounds.bound(self.mesh_of(values, sample), with_keys(self.scene, given), self.stage, self.design.raises, kept=self.kept)
        except LimitError as error:
            return "undecided", None, str(error)
        if answer.value is None:
            return "fails", None, "stands at no size of the loads"
        value = float(answer.value)
        return ("fails" if self.design.condition.holds(value) else "stands"), (value if math.isfinite(value) else None), ""

    def close(self):
        pass


def with_keys(scene, given):
    """Returns the scene with other values of some keys, section.name.key."""
    from copy import deepcopy

    changed = deepcopy(scene)
    for key, value in given.items():
        section, *names, what = key.split(".")
        rows = getattr(changed, section, None)
        for name in names:
            rows = rows.get(name) if isinstance(rows, dict) else None
        if not isinstance(rows, dict) or not names:
            raise EnsembleError(f"variables: {key}: the scene has no such row: expected section.name.key")
        if isinstance(value, str) and isinstance(rows.get(what), (int, float)):
            raise EnsembleError(f"variables: {key}: {value}: limit analysis takes numbers without a unit")
        rows[what] = value
    return changed


def model_of(design, folder, keep=False):
    """Returns the judge of the samples."""
    return (Limit if design.judge == "limit" else Solver)(design, folder, keep)
