"""Samples over one MPI allocation (mpi4py.futures): rank 0 hands them out and writes the rows, every other rank judges one at a time, the first free takes the next.

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
    """The executor on rank 0; the others are in here until it is left. Collective over all ranks of the job."""
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
    """As running.Here."""

    def __init__(self, executor, design, folder, keep):
        self.executor, self.task = executor, (design, folder, keep)
        self.size = executor.num_workers

    def submit(self, values, index, level):
        return self.executor.submit(judged, *self.task, values, index, level)

    def end(self):
        """Nothing: mpirun ends the ranks."""

    def close(self):
        """Nothing: the ranks close what they have when they end."""


def judged(design, folder, keep, values, index, level):
    """On a rank: (answer, seconds) of a sample."""
    if design.mark not in MODELS:
        MODELS[design.mark] = model = model_of(design, folder, keep)
        atexit.register(model.close)
    began = time.monotonic()
    return MODELS[design.mark].judge(values, index, level), time.monotonic() - began
