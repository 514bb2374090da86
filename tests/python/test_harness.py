"""The harness of tests/reliability: what counts as a run that hangs, whatever else the machine does."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests/reliability")]

import run  # noqa: E402


@pytest.fixture
def job(tmp_path):
    """A run of one rank that would take an hour."""
    made = run.Job.__new__(run.Job)
    made.folder = tmp_path
    made.process = subprocess.Popen(["bash", "-c", "sleep 3600 & wait $!"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while not made.ranks():
        time.sleep(0.01)
    yield made
    made.kill("all ranks")
    made.process.kill()
    made.process.wait()


def looks(monkeypatch, job, seconds, writes=()):
    """The processor time that each look finds; at some looks the run has written. Behind the last the run is over."""
    left = list(enumerate(seconds))

    def worked(pids):
        look, now = left.pop(0)
        if not left:
            job.kill("all ranks")
            job.process.wait()  # on a busy machine it may take longer than the next look
        return now
    monkeypatch.setattr(run, "worked", worked)
    monkeypatch.setattr(run, "written", lambda folder: sum(at <= left[0][0] for at in writes))


def test_one_that_waits_for_its_turn_does_not_hang(monkeypatch, job):
    """It writes nothing, and has the processor now and then."""
    looks(monkeypatch, job, [0.01 * i for i in range(1, 8)])
    assert job.end(0.1)[0] != 0  # ended by this test


def test_one_that_writes_does_not_hang(monkeypatch, job):
    looks(monkeypatch, job, [5, 5.05, 15, 25, 25], writes=(2, 3, 4))
    job.end(0.1)


@pytest.mark.parametrize("seconds", [[5, 5, 6], [5, 5.05, 5.2, 6]], ids=["asleep", "busy"])
def test_one_that_hangs(monkeypatch, job, seconds):
    """All ranks sleep, or one works and nothing comes of it."""
    looks(monkeypatch, job, seconds)
    with pytest.raises(AssertionError, match="hangs"):
        job.end(0.1)


def test_processor_time():
    start = run.worked([os.getpid()])
    while time.process_time() < start + 0.1:
        pass
    assert start + 0.08 <= run.worked([os.getpid(), os.getppid()]) and run.worked([]) == 0
