"""Runs samples in processes of the solver that set up the scene once and take rows of numbers, where the scene allows it (key `samples`, docs/reference/samples.md).

Each sample ends as a process of its own would, with the same bits; with `start: nearest` with the same verdict and within the tolerance of the stage, from
samples that each process solves first and that no run changes, so that the rows are the same on any number of processes. One that dies, or takes too long, takes its worker with it, and the next sample starts a new one.
"""

from quoin_tools.base.sample_rows import Rows
from quoin_tools.ensemble.variables import EnsembleError


class Unshared(Exception):
    """The solver refuses the table: each sample needs a run of its own."""


class Worker(Rows):
    """One process. header: of the rows that it takes; first: rows that it solves first."""

    def __init__(self, design, header, first=()):
        model = ["-model", design.model] if design.model else []
        super().__init__(["-options_file", design.scene, *model, *design.options], header)
        if not self.takes():
            self.close()
            raise Unshared
        for row in first:
            if self.answer(row) is None:
                raise EnsembleError(f"start: nearest: the process has ended in {row}: {self.close()[1]}")
