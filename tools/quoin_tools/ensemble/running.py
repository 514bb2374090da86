"""Runs the missing samples, several at a time, and writes each as soon as it is done."""

import time
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, ThreadPoolExecutor, wait

from quoin_tools.base import solver
from quoin_tools.ensemble import analysis
from quoin_tools.ensemble.journal import Journal, Row
from quoin_tools.ensemble.ranks import Ranks
from quoin_tools.ensemble.sampling import Sampler
from quoin_tools.ensemble.workers import model_of

AHEAD = 2  # tasks a worker that wait for it


class Samples:
    """Values and weight of each index."""

    def __init__(self, design, centre=None):
        self.design, self.sampler = design, Sampler(design.method, design.variables, design.seed, design.block, centre)

    def of(self, index):
        return tuple(self.design.variables.values([self.sampler.normal(index)])[0]), self.sampler.weight(index)


class Here:
    """Judges samples on this machine, in threads or processes, `size` of them."""

    def __init__(self, design, folder, jobs, keep):
        self.model, self.size = model_of(design, folder, keep), jobs
        self.pool = ProcessPoolExecutor(jobs) if self.model.processes and jobs > 1 else ThreadPoolExecutor(jobs)

    def submit(self, values, index, level):
        return self.pool.submit(timed, self.model, values, index, level)

    def end(self):
        """Ends the samples that have begun; those that wait do not begin."""
        self.pool.shutdown(wait=False, cancel_futures=True)
        solver.end_all()

    def close(self):
        self.pool.shutdown()
        self.model.close()


def run(design, folder, jobs=1, part=(1, 1), keep=False, report=None, centre=None, executor=None):
    """Returns {(sample, level): Row} of all samples at the end. part: (k, m), every m-th sample from k on. report(rows, done, left, began): progress. executor: of ranks.allocation."""
    journal = Journal(folder, design, str(part[0]) if part[1] == 1 else f"{part[0]}_of_{part[1]}")
    rows, samples, began = journal.rows(), Samples(design, centre), time.monotonic()
    todo = [(i, level) for i in range(part[0] - 1, design.samples, part[1]) for level in design.levels if (i, level) not in rows]
    if not todo:
        return rows
    journal.open()
    place = Here(design, folder, jobs, keep) if executor is None else Ranks(executor, design, folder, keep)
    waiting, done, queue = {}, 0, iter(todo)
    try:
        while True:
            for index, level in queue if len(waiting) < AHEAD * place.size else ():
                values, weight = samples.of(index)
                waiting[place.submit(values, index, level)] = (index, level, values, weight)
                if len(waiting) >= AHEAD * place.size:
                    break
            if not waiting:
                break
            for ended in wait(waiting, return_when=FIRST_COMPLETED).done:
                index, level, values, weight = waiting.pop(ended)
                (outcome, response, why), seconds = ended.result()
                rows[index, level] = Row(index, level, weight, outcome, response, seconds, why, tuple(one.kept(v) for one, v in zip(design.variables.each, values, strict=True)))
                journal.write(rows[index, level])
                done += 1
            if report:
                report(rows, done, len(todo) - done, began)
            if part[1] == 1 and done % design.batch == 0 and analysis.enough(design, rows):
                queue = iter(())
    except solver.Ended:
        place.end()
        raise
    finally:
        place.close()
        journal.close()
    return rows


def timed(model, values, index, level):
    began = time.monotonic()
    return model.judge(values, index, level), time.monotonic() - began
