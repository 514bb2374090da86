"""Shares work out to copies of this process, one for each processor: pictures of one run, say."""

import contextlib
import io
import multiprocessing
import os
import pickle
import sys
import threading


def processors():
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1


def shared(tasks, collected=None, copies=None):
    """Returns the answers of functions without arguments, in their order. Each copy runs every n-th function and sends its answers at the end.

    collected: a list that the tasks lengthen, each copy its own; here it gets the items of all copies. Their text on stderr is printed here. The first error
    of a task is raised here too.
    Copies are forked and share the data of this process. With one processor, other threads or no fork, this process does all."""
    copies = min(copies or processors(), len(tasks))
    if copies < 2 or not hasattr(os, "fork") or threading.active_count() > 1:
        return [task() for task in tasks]
    fork = multiprocessing.get_context("fork")
    children, ends = [], []
    for k in range(copies):
        ours, theirs = fork.Pipe(duplex=False)
        children.append(fork.Process(target=run_tasks, args=(tasks[k::copies], collected, theirs)))
        children[-1].start()
        theirs.close()  # so that the end of the copy ends the pipe
        ends.append(ours)
    answers, failures = [None] * len(tasks), []
    for k, (child, end) in enumerate(zip(children, ends)):
        try:
            found, added, failure, errors = end.recv()
        except EOFError:
            raise RuntimeError("a copy of this process ended before its work was done") from None
        child.join()
        sys.stderr.write(errors)
        answers[k::copies] = found + [None] * (len(tasks[k::copies]) - len(found))
        if collected is not None:
            collected += [item for item in dict.fromkeys(added) if item not in collected]
        if failure is not None:
            failures.append((k + copies * len(found), failure))
    if failures:
        raise min(failures, key=lambda failure: failure[0])[1]
    return answers


def run_tasks(tasks, collected, end):
    """Runs tasks. Sends their answers, the items they collected, the exception that ended them, and their text on stderr."""
    answers, before, failure = [], len(collected or ()), None
    with contextlib.redirect_stderr(io.StringIO()) as errors:
        try:
            for task in tasks:
                answers.append(task())
        except Exception as error:
            failure = error
    added = (collected or [])[before:]
    try:
        end.send((answers, added, failure, errors.getvalue()))
    except (pickle.PicklingError, TypeError, AttributeError):  # not every exception can be pickled
        end.send((answers, added, RuntimeError(f"{type(failure).__name__}: {failure}"), errors.getvalue()))
