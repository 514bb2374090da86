"""Shares work out to copies of this process, one for each processor: pictures of one run, say."""

import contextlib
import io
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
    sys.stdout.flush()
    sys.stderr.flush()
    ends = [start(tasks[k::copies], collected) for k in range(copies)]
    answers, failures = [None] * len(tasks), []
    for k, (child, end) in enumerate(ends):
        with os.fdopen(end, "rb") as pipe:
            data = pipe.read()
        os.waitpid(child, 0)
        if not data:
            raise RuntimeError("a copy of this process ended before its work was done")
        found, added, failure, errors = pickle.loads(data)  # noqa: S301 (a copy of this process has written it)
        sys.stderr.write(errors)
        answers[k::copies] = found + [None] * (len(tasks[k::copies]) - len(found))
        if collected is not None:
            collected += [item for item in dict.fromkeys(added) if item not in collected]
        if failure is not None:
            failures.append((k + copies * len(found), failure))
    if failures:
        raise min(failures, key=lambda failure: failure[0])[1]
    return answers


def start(tasks, collected):
    """Starts a copy of this process that runs the tasks. Returns its number, and the end of a pipe from which its answers can be read."""
    ours, theirs = os.pipe()
    child = os.fork()
    if child:
        os.close(theirs)
        return child, ours
    status = 1
    try:
        os.close(ours)
        with os.fdopen(theirs, "wb") as pipe:
            pipe.write(run_tasks(tasks, collected))
        status = 0
    finally:  # a copy ends here, whatever happens
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def run_tasks(tasks, collected):
    """Runs tasks. Returns, pickled, their answers, the items they collected, the exception that ended them, and their text on stderr."""
    answers, before, failure = [], len(collected or ()), None
    with contextlib.redirect_stderr(io.StringIO()) as errors:
        try:
            for task in tasks:
                answers.append(task())
        except Exception as error:
            failure = error
    added = (collected or [])[before:]
    try:
        return pickle.dumps((answers, added, failure, errors.getvalue()))
    except Exception:  # not every exception can be pickled
        return pickle.dumps((answers, added, RuntimeError(f"{type(failure).__name__}: {failure}"), errors.getvalue()))
