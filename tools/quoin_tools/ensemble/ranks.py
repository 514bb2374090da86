"""Runs samples over one MPI allocation (mpi4py.futures): rank 0 hands them out and writes the rows, every other rank judges one at a time, the first free takes the next.

    with allocation() as executor:  # None on the ranks that judge, when all is done
"""

import atexit
import contextlib
import time

from quoin_tools.ensemble.variables import EnsembleError
from quoin_tools.ensemble.workers import model_of

MODELS: dict = {}  # of this rank: the samples that it judges share one


@contextlib.contextmanager
def allocation():
    """Gives rank 0 the executor; the other ranks stay in here until rank 0 leaves it. Collective over all ranks of the job."""
    try:
        from mpi4py import MPI
        from mpi4py.futures import MPICommExecutor
    except (ImportError, RuntimeError) as error:
        raise EnsembleError(f"--mpi: {' '.join(str(error).split())}: expected the package mpi4py and the MPI library that mpirun belongs to") from error
    if MPI.COMM_WORLD.size == 1:
        raise EnsembleError("--mpi: there is one rank: expected two or more, mpirun -n 4 quoin ensemble ...; without --mpi, -j says how many samples run at a time")
    with MPICommExecutor(MPI.COMM_WORLD, root=0) as executor:
        yield executor


class Ranks:
    """Judges samples as running.Here does."""

    def __init__(self, executor, design, folder, keep):
        self.executor, self.task = executor, (design, folder, keep)
        self.size = executor.num_workers

    def submit(self, values, index, level):
        return self.executor.submit(judged, *self.task, values, index, level)

    def end(self):
        """Does nothing: mpirun ends the ranks."""

    def close(self):
        """Does nothing: the ranks close their files when they end."""


def judged(design, folder, keep, values, index, level):
    """Judges a sample on a rank. Returns (answer, seconds)."""
    if design.mark not in MODELS:
        MODELS[design.mark] = model = model_of(design, folder, keep)
        atexit.register(model.close)
    began = time.monotonic()
    return MODELS[design.mark].judge(values, index, level), time.monotonic() - began
