"""Shares work out to copies of this process, one for each processor: pictures of one run, say."""

import contextlib
import gc
import io
import multiprocessing
import os
import pickle
import sys
import threading


def processors():
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1


def shared(tasks, collected=None, copies=None):
    """Returns the answers of functions without arguments, in their order."""
    with sharing(tasks, collected, copies) as answers:
        return answers()


@contextlib.contextmanager
def sharing(tasks, collected=None, copies=None):
    """Runs functions without arguments while this process does other work. Yields a function that waits for their answers and returns them, in their order.
    Each copy takes the next function that no other has taken, and sends its answers at the end. At the end of the context the copies end after the functions that they are at.

    collected: a list that the tasks lengthen, each copy its own; here it gets the items of all copies. Their text on stderr is printed here. The first error
    of a task is raised here too.
    Copies are forked and share the data of this process. With one processor, other threads or no fork, this process does all, when the answers are asked for."""
    copies = min(copies or processors(), len(tasks))
    if copies < 2 or not hasattr(os, "fork") or threading.active_count() > 1:
        yield lambda: [task() for task in tasks]
        return
    fork = multiprocessing.get_context("fork")
    taken, children, ends = fork.Value("i", 0), [], []
    gc.freeze()  # so that no copy looks through what it shares, which would copy it
    try:
        for _copy in range(copies):
            ours, theirs = fork.Pipe(duplex=False)
            children.append(fork.Process(target=run_tasks, args=(tasks, taken, collected, theirs)))
            children[-1].start()
            theirs.close()  # so that the end of the copy ends the pipe
            ends.append(ours)
        gc.unfreeze()
        yield lambda: answers_of(ends, len(tasks), collected)
    finally:
        with taken.get_lock():
            taken.value = len(tasks)  # after an error here no copy takes another one
        for child, end in zip(children, ends):
            end.close()
            child.join()


def answers_of(ends, number, collected):
    """Waits for all copies. Returns the answers of a number of tasks."""
    answers, failures = [None] * number, []
    for end in ends:
        try:
            found, added, failure, errors = end.recv()
        except EOFError:
            raise RuntimeError("a copy of this process ended before its work was done") from None
        sys.stderr.write(errors)
        for k, answer in found.items():
            answers[k] = answer
        if collected is not None:
            collected += [item for item in dict.fromkeys(added) if item not in collected]
        if failure is not None:
            failures.append(failure)
    if failures:
        raise min(failures, key=lambda failure: failure[0])[1]
    return answers


def next_of(taken):
    """Returns the number of the next task that no copy has taken."""
    with taken.get_lock():
        taken.value += 1
        return taken.value - 1


def run_tasks(tasks, taken, collected, end):
    """Runs tasks until none is left. Sends {number of a task: its answer}, the items they collected, (number, exception) of the one that failed, and their text on stderr."""
    answers, before, failure = {}, len(collected or ()), None
    with contextlib.redirect_stderr(io.StringIO()) as errors:
        while failure is None and (k := next_of(taken)) < len(tasks):
            try:
                answers[k] = tasks[k]()
            except Exception as error:
                failure = k, error
    added = (collected or [])[before:]
    with contextlib.suppress(BrokenPipeError):  # nobody waits for it
        try:
            end.send((answers, added, failure, errors.getvalue()))
        except (pickle.PicklingError, TypeError, AttributeError):  # not every exception can be pickled
            number, reason = failure
            end.send((answers, added, (number, RuntimeError(f"{type(reason).__name__}: {reason}")), errors.getvalue()))
