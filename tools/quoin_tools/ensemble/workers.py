"""Runs samples in processes of the solver that set up the scene once and take rows of numbers, where the scene allows it (key `samples`, docs/scene.md).

Each sample ends as a process of its own would, with the same bits; with `start: nearest` with the same verdict and within the tolerance of the stage, from
samples that each process solves first and that no run changes, so that the rows are the same on any number of processes. One that dies, or takes too long, takes its worker with it, and the next sample starts a new one.
"""

import contextlib
import csv
import subprocess
import tempfile
import threading

from quoin_tools.base import solver
from quoin_tools.ensemble.variables import EnsembleError


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
                raise EnsembleError(f"start: nearest: the process has ended in {row}: {self.close()[1]}")

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

    def close(self):
        """Ends the process. Returns its exit code, its last line, and whether it was too late."""
        self.send("")
        for pipe in (self.process.stdin, self.process.stdout):
            with contextlib.suppress(BrokenPipeError):
                pipe.close()
        code = self.process.wait()
        solver.ended(self.process)
        with self.errors:
            self.errors.seek(0)
            lines = [line for line in self.errors.read().splitlines() if line.strip()]
        return code, lines[-1] if lines else "", self.late
