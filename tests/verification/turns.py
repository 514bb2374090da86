"""Where several tests run at a time (QUOIN_TURNS names a file), one run of several ranks is under way at most.

Its ranks wait for each other in every cycle; beside the ranks of another run each wait would last a slice of time. Beside a run of one
rank they are slower too, but no processor is idle, as it would be while one run waited for the end of the other."""

import contextlib
import fcntl
import os


@contextlib.contextmanager
def turn(alone):
    """Waits until no other run of several ranks is under way, where this one has several (alone)."""
    name = os.environ.get("QUOIN_TURNS")
    if not name or not alone:
        yield
        return
    with open(name, "a", encoding="utf-8") as place:
        fcntl.flock(place, fcntl.LOCK_EX)
        yield
