"""Runs the missing samples, several at a time, here or over the ranks of an MPI job, and writes each as soon as it is done."""

import atexit
import contextlib
import itertools
import os
import time
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, ThreadPoolExecutor, wait

from quoin_tools.base import solver
from quoin_tools.ensemble import analysis
from quoin_tools.ensemble.journal import Journal, Row
from quoin_tools.ensemble.models import model_of
from quoin_tools.ensemble.sampling import Sampler
from quoin_tools.ensemble.variables import EnsembleError

AHEAD = 2  # tasks a worker that wait for it


class Samples:
    """Values and weight of each index. Method `all`: every combination of the choices."""

    def __init__(self, design, centre=None):
        self.design = design
        self.all = list(itertools.product(*(one.choices for one in design.variables.each))) if design.method == "all" else None
        self.sampler = None if self.all else Sampler(design.method, design.variables, design.seed, design.block, centre)

    def of(self, index):
        if self.all:
            return self.all[index], 1.0
        values = tuple(self.design.variables.values([self.sampler.normal(index)])[0])
        return self.design.drawn.over(values, index) if self.design.drawn else values, self.sampler.weight(index)


@contextlib.contextmanager
def allocation():
    """Gives rank 0 of an MPI job the executor of the others, which judge a sample at a time, the first free takes the next; these stay in here until rank 0 leaves it, and get None."""
    try:
        from mpi4py import MPI
        from mpi4py.futures import MPICommExecutor
    except (ImportError, RuntimeError) as error:
        raise EnsembleError(f"--mpi: {' '.join(str(error).split())}: expected the package mpi4py and the MPI library that mpirun belongs to") from error
    if MPI.COMM_WORLD.size == 1:
        raise EnsembleError("--mpi: there is one rank: expected two or more, mpirun -n 4 quoin ensemble ...; without --mpi, -j says how many samples run at a time")
    with MPICommExecutor(MPI.COMM_WORLD, root=0) as executor:
        yield executor


MODELS: dict = {}  # of this process: the samples that it judges share one


def judged(model, values, index, level):
    """Returns (answer, seconds). model: in a process of its own the arguments by which it is made."""
    if isinstance(model, tuple):
        made = MODELS.get(model[0].mark)
        if made is None:
            MODELS[model[0].mark] = made = model_of(*model)
            atexit.register(made.close)
        model = made
    began = time.monotonic()
    return model.judge(values, index, level), time.monotonic() - began


def forget_others(journal, there):
    """Removes the rows of a journal that are of another study, or where the results of a row are gone. there(row): tells whether they are there."""
    try:
        kept = all(there(row) for row in journal.rows().values())
    except EnsembleError:  # of another study
        kept = False
    if not kept and os.path.exists(journal.path):
        os.remove(journal.path)


def failed(ended):
    """Whether a future has no result: it was cancelled or raised an error."""
    return ended.cancelled() or ended.exception() is not None


def run(design, folder, jobs=1, part=(1, 1), keep=False, report=None, centre=None, executor=None, judge=model_of):
    """Returns {(sample, level): Row} of all samples at the end. part: (k, m), every m-th sample from k on. report(rows, done, left, began): progress. executor: of `allocation`."""
    journal = Journal(folder, design, str(part[0]) if part[1] == 1 else f"{part[0]}_of_{part[1]}")
    rows, samples, began = journal.rows(), Samples(design, centre), time.monotonic()
    todo = [(i, level) for i in range(part[0] - 1, design.samples, part[1]) for level in design.levels if (i, level) not in rows]
    if not todo:
        return rows
    journal.open()
    model = given = (design, folder, keep)
    if executor is None:
        model = MODELS[design.mark] = judge(design, folder, keep)  # processes that are forked have it
    apart = executor is not None or (model.processes and jobs > 1)
    size = jobs if executor is None else executor.num_workers
    pool = executor or (ProcessPoolExecutor(jobs) if apart else ThreadPoolExecutor(jobs))
    waiting, done, queue, cut = {}, 0, iter(todo), False

    def keep_row(ended):
        index, level, values, weight = waiting.pop(ended)
        (outcome, response, why), seconds = ended.result()
        if cut and outcome == "undecided":
            return  # the signal that ends this process has ended the sample too, most likely: it runs again
        rows[index, level] = Row(index, level, weight, outcome, response, seconds, why, tuple(one.kept(v) for one, v in zip(design.variables.each, values, strict=True)))
        journal.write(rows[index, level])

    try:
        while True:
            for index, level in queue if len(waiting) < AHEAD * size else ():
                values, weight = samples.of(index)
                waiting[pool.submit(judged, given if apart else model, values, index, level)] = (index, level, values, weight)
                if len(waiting) >= AHEAD * size:
                    break
            if not waiting:
                break
            for ended in sorted(wait(waiting, return_when=FIRST_COMPLETED).done, key=failed):
                keep_row(ended)
                done += 1
            if report:
                report(rows, done, len(todo) - done, began)
            if part[1] == 1 and done % design.batch == 0 and analysis.enough(design, rows):
                queue = iter(())
    except (solver.Ended, KeyboardInterrupt) as end:
        cut = True
        if isinstance(end, solver.Ended):
            solver.end_all()  # those that wait do not begin; mpirun ends its ranks
        raise
    finally:
        if executor is None:
            pool.shutdown(cancel_futures=True)
            MODELS.pop(design.mark).close()
            for ended in [one for one in waiting if not failed(one)]:  # beside one that failed
                keep_row(ended)
        journal.close()
    return rows
