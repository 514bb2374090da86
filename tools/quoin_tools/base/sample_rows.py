"""Starts a solver that sets up a scene once and takes rows of samples through a pipe (key `samples`, docs/reference/samples.md).

rows = Rows(["-options_file", "scene.yaml"], "sample,loads.water.level,loads")
rows.answer("a,12.5,loads.h5")["outcome"]
"""

import contextlib
import csv
import subprocess
import tempfile
import threading

from quoin_tools.base import solver


class Rows:
    """One process. words: of its command line; header: of the rows that it takes."""

    def __init__(self, words, header):
        self.errors = tempfile.TemporaryFile("w+", encoding="utf-8")  # noqa: SIM115
        self.process = solver.start(
            solver.command([*words, "-samples", "/dev/stdin"]),
            env=solver.environment_of_one(),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.errors,
            text=True,
            encoding="utf-8",
        )
        self.columns, self.late = None, False
        self.send(header)

    def takes(self):
        """Waits until the scene is set up. Tells whether the process takes the rows."""
        for line in self.process.stdout if self.columns is None else ():
            if line.startswith("sample,"):
                self.columns = line.rstrip("\n").split(",")
                break
        return self.columns is not None

    def send(self, line):
        with contextlib.suppress(BrokenPipeError):  # its last line gives the reason
            self.process.stdin.write(line + "\n")
            self.process.stdin.flush()

    def answer(self, row, time_limit=None):
        """Returns {column: text} of a row; None: the process has ended."""
        timer = threading.Timer(time_limit, self.stop) if time_limit else None
        if timer:
            timer.start()
        try:
            if self.takes():
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
        for pipe in (self.process.stdin, self.process.stdout):
            with contextlib.suppress(BrokenPipeError):
                pipe.close()
        code = self.process.wait()
        solver.ended(self.process)
        with self.errors:
            self.errors.seek(0)
            lines = [line for line in self.errors.read().splitlines() if line.strip()]
        return code, lines[-1] if lines else "", self.late
