"""Runs samples in processes of the solver that set up the scene once and take rows of numbers, where the scene allows it (key `samples`, docs/scene.md).

Each sample ends as a process of its own would, with the same bits; with `start: nearest` with the same verdict and within the tolerance of the stage, from
samples that each process solves first and that no run changes, so that the rows are the same on any number of processes. One that dies, or takes too long, takes its worker with it, and the next sample starts a new one.
"""

import contextlib
import csv
import queue
import signal
import subprocess
import tempfile
import threading

import scipy

from quoin_tools.base import solver
from quoin_tools.ensemble.models import FALLS, Limit, Refused, Solver, bare, keys_of
from quoin_tools.ensemble.sampling import sobol
from quoin_tools.ensemble.variables import EnsembleError

PIVOTS = 32  # samples that are solved first, over all levels


class Unshared(Exception):
    """The solver refuses the table: each sample needs a run of its own."""


class Worker:
    """One process. header: of the rows that it takes; first: rows that it solves first."""

    def __init__(self, design, header, first=()):
        self.errors = tempfile.TemporaryFile("w+", encoding="utf-8")  # noqa: SIM115
        model = ["-model", design.model] if design.model else []
        words = solver.command(["-options_file", design.scene, *model, *design.options, "-samples", "/dev/stdin"])
        self.process = solver.start(
            words,
            env=solver.environment_of_one(),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.errors,
            text=True,
            encoding="utf-8",
        )
        self.columns, self.late = None, False
        self.send(header)
        for line in self.process.stdout:
            if line.startswith("sample,"):
                self.columns = line.rstrip("\n").split(",")
                break
        else:
            self.close()
            raise Unshared
        for row in first:
            if self.answer(row, None) is None:
                message = self.last_words()
                self.close()
                raise EnsembleError(f"start: nearest: the process has ended in {row}: {message}")

    def send(self, line):
        with contextlib.suppress(BrokenPipeError):  # its last line gives the reason
            self.process.stdin.write(line + "\n")
            self.process.stdin.flush()

    def answer(self, row, time_limit):
        """Returns {column: text} of a row; None: the process has ended."""
        timer = threading.Timer(time_limit, self.stop) if time_limit else None
        if timer:
            timer.start()
        try:
            self.send(row)
            line = self.process.stdout.readline()
        finally:
            if timer:
                timer.cancel()
        return dict(zip(self.columns, next(csv.reader([line])), strict=True)) if line.endswith("\n") else None

    def stop(self):
        self.late = True
        self.process.kill()

    def last_words(self):
        self.errors.seek(0)
        return next((line for line in reversed(self.errors.read().splitlines()) if line.strip()), "")

    def close(self):
        self.send("")
        for pipe in (self.process.stdin, self.process.stdout):
            with contextlib.suppress(BrokenPipeError):
                pipe.close()
        self.process.wait()
        solver.ended(self.process)
        self.errors.close()


class Workers:
    """Judges samples as Solver does: judge(values, sample, level)."""

    processes = False  # children of threads

    def __init__(self, design, folder):
        self.design, self.alone = design, Solver(design, folder)
        self.idle, self.shares, self.looked = queue.SimpleQueue(), True, False
        paths = [path for path in (design.condition.path if design.condition else None, design.response) if path]
        self.paths = list(dict.fromkeys(map(bare, paths)))

    def header(self, keys):
        until = [f"until:{self.design.stage}"] if self.design.stage else []
        return ",".join(["sample", *keys, *(f"tell:{path}" for path in self.paths), *until])

    def worker(self, keys):
        try:
            return self.idle.get_nowait()
        except queue.Empty:
            return Worker(self.design, self.header(keys), self.pivots() if self.design.start == "nearest" else ())

    def pivots(self):
        """Returns rows that spread evenly over the variables and levels."""
        points = scipy.special.ndtri(sobol(0, 0, PIVOTS, len(self.design.columns())))
        values = self.design.variables.values(points)
        return [self.row(f"pivot:{k}", keys_of(self.design, one, self.design.levels[k % len(self.design.levels)])) for k, one in enumerate(values)]

    def row(self, name, given):
        cells = [repr(value) if isinstance(value, float) else str(value) for value in given.values()]
        empty = [""] * self.header([]).count(",")  # of columns that ask for something
        return ",".join([name, *cells, *empty])

    def judge(self, values, sample, level):
        given = keys_of(self.design, values, level)
        if any("," in str(value) for value in given.values()):  # a table of samples has no such cells
            self.shares = False
        try:
            worker = self.worker(list(given)) if self.shares else None
        except Unshared:
            self.shares, worker = False, None
        if worker is None and self.design.start == "nearest":
            raise EnsembleError("start: nearest: samples that differ in these keys, or of this scene, cannot share a process")
        if worker is None:
            return self.alone.judge(values, sample, level)
        row = worker.answer(self.row(str(sample), given), self.design.time_limit)
        if row is None:
            return self.ended(worker, sample)
        self.idle.put(worker)
        answer = self.outcome(row, sample)
        if not self.looked and row["outcome"] not in ("refused", "fails", "undecided") and not all(row[path] for path in self.paths):
            self.looked = True  # a number is not there: a run of its own says whether its name is wrong
            self.alone.judge(values, sample, level)
        return answer

    def ended(self, worker, sample):
        """Returns the outcome of a sample whose process has ended."""
        code, message = worker.process.wait(), worker.last_words()
        worker.close()
        if worker.late:
            return "undecided", None, f"longer than {self.design.time_limit:g} s"
        if code < 0:
            return "undecided", None, f"ended by {signal.Signals(-code).name}"
        return "undecided", None, message if message.startswith("quoin: error") else f"exit code {code} without results"

    def outcome(self, row, sample):
        wanted, why = self.design.stage, row["why"]
        if row["outcome"] == "refused":
            raise Refused(f"sample {sample}: {why}")
        if row["outcome"] == "fails":
            before = bool(wanted) and row["stage"] != wanted
            return "fails", None, FALLS if FALLS in why else "collapsed before" if before else "collapsed"
        if row["outcome"] == "undecided":
            return "undecided", None, why.partition(":")[0]
        numbers = {path: float(row[path]) if row[path] else None for path in self.paths}
        return self.alone.by_numbers(row["stage"], lambda path: numbers[path])

    def close(self):
        while not self.idle.empty():
            self.idle.get_nowait().close()


def model_of(design, folder, keep=False):
    """Returns the judge of the samples. Samples whose folder is kept, or that have a mesh each, need a process each."""
    if design.judge == "limit":
        return Limit(design, folder, keep)
    return Solver(design, folder, keep) if keep or design.mesh else Workers(design, folder)
