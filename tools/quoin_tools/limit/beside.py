"""Runs the solver beside what the main thread computes, with as many of both at a time as there are processors.

    with Beside() as side:
        run = side.begin(lambda running: ...)        running: for solver.run
        with side.turn():
            ...                                      what the main thread computes
        run.result()

What leaves the block by an error or a signal leaves no solver running.
"""

import contextlib
import threading
from concurrent.futures import ThreadPoolExecutor, wait

from quoin_tools.base.shared import processors

OFTEN, PATIENCE = 0.1, 10  # s between signals to solvers that are to end; after that they are killed


class Stopped(Exception):
    """The block has been left: a run does not begin any more."""


class Beside:
    def __init__(self, at_a_time=None):
        at_a_time = at_a_time or processors()
        self.turns, self.pool = threading.Semaphore(at_a_time), ThreadPoolExecutor(at_a_time)
        self.running, self.begun, self.left = set(), [], False

    def begin(self, task):
        """Returns the Future of task(running), which runs when there is a processor for it."""

        def run():
            with self.turn():
                if self.left:
                    raise Stopped
                return task(self.running)

        self.begun.append(self.pool.submit(run))
        return self.begun[-1]

    @contextlib.contextmanager
    def turn(self):
        with self.turns:
            yield

    def __enter__(self):
        return self

    def __exit__(self, *_):
        """Ends the runs that nobody waits for any more."""
        self.left = True
        self.pool.shutdown(wait=False, cancel_futures=True)
        for _ in range(int(PATIENCE / OFTEN)):
            for process in list(self.running):
                process.terminate()
            if not wait([one for one in self.begun if not one.cancelled()], OFTEN).not_done:
                break
        else:
            for process in list(self.running):
                process.kill()
        self.pool.shutdown()
