"""Where several tests run at a time (QUOIN_TURNS names a file), a run of several ranks has the processors alone.

Its ranks wait for each other in every cycle, and beside other work each wait would last a slice of time."""

import contextlib
import fcntl
import os


@contextlib.contextmanager
def turn(alone):
    """Beside others, or alone. Who waits to be alone keeps back those who come later."""
    name = os.environ.get("QUOIN_TURNS")
    if not name:
        yield
        return
    with open(name, "a", encoding="utf-8") as place:
        with open(name + ".next", "a", encoding="utf-8") as first:
            fcntl.flock(first, fcntl.LOCK_EX)
            fcntl.flock(place, fcntl.LOCK_EX if alone else fcntl.LOCK_SH)
        yield
