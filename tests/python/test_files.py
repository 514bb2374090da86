"""A file of a tool that cannot be written: one line names it, the file of before stays, nothing is left behind. Work shared out to copies."""

import errno
import multiprocessing
import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from quoin_tools.base import files  # noqa: E402
from quoin_tools.base.shared import shared, sharing  # noqa: E402
from quoin_tools.mesh import blockmesh  # noqa: E402
from quoin_tools.mesh.meshing import rectangle  # noqa: E402
from quoin_tools.show import export, plot_mesh  # noqa: E402


def picture(path):
    plot_mesh.plot(rectangle(0, 0, 1, 1), path)


def mesh(path):
    blockmesh.write(path, rectangle(0, 0, 1, 1))


def table(path):
    export.write(path, ("a", "b"), [(1.0, 2)])


WRITERS = {"picture.png": picture, "picture.svg": picture, "model.h5": mesh, "table.csv": table}


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("call", ["fsync", "replace", "open"])
def test_what_was_there_stays(tmp_path, monkeypatch, name, call):
    path = tmp_path / name
    path.write_bytes(b"of before")
    mode = path.stat().st_mode

    def fail(*_, **__):
        raise OSError(errno.EIO, "Input/output error")
    monkeypatch.setattr(os, call, fail)
    with pytest.raises(OSError, match="Input/output error") as found:
        WRITERS[name](str(path))
    monkeypatch.undo()
    assert found.value.filename == str(path)
    assert path.read_bytes() == b"of before" and os.listdir(tmp_path) == [name]
    WRITERS[name](str(path))
    assert len(path.read_bytes()) > 9 and os.listdir(tmp_path) == [name]
    assert path.stat().st_mode == mode  # not the 0600 of a temporary file


def test_a_full_disk(tmp_path):
    """A file that may not grow beyond 1 kB: half of it is written, and thrown away. Python keeps half of a compiled module."""
    code = f"""import resource, signal, sys; sys.path.insert(0, {str(ROOT / "tools")!r}); sys.dont_write_bytecode = True
signal.signal(signal.SIGXFSZ, signal.SIG_IGN); resource.setrlimit(resource.RLIMIT_FSIZE, (1024, 1024))
from quoin_tools.base.command import command; from quoin_tools.base.files import write_file
sys.exit(command(lambda: write_file("file", b"x" * 10000)))"""
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "file: File too large" in done.stderr, done.stderr
    assert not os.listdir(tmp_path)


def test_a_pipe_is_written_to_and_stays_one(tmp_path):
    """A device likewise: a file renamed over /dev/full would take it away from the whole machine."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    end = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    try:
        files.write_file(pipe, "text")
        assert stat.S_ISFIFO(pipe.stat().st_mode)
        assert os.read(end, 100) == b"text"
    finally:
        os.close(end)
    assert os.listdir(tmp_path) == ["pipe"]


def test_no_results_file(tmp_path):
    (tmp_path / "results.h5").write_bytes(b"none")
    with pytest.raises(OSError), files.reading(tmp_path / "results.h5"):
        pass


@pytest.mark.parametrize("copies", [1, 2, 3])
def test_work_shared_out(copies, capsys):
    """Answers in the order of the tasks, what each copy has heard, once, and what it says. Copies wait for each other at their first task, so each has one."""
    heard, all_at_work = ["before"], multiprocessing.Barrier(copies)
    met = []

    def task(k):
        heard.append(f"word {k % 2}")
        if not met:
            met.append(all_at_work.wait())
        if k > 4:
            print(f"task {k}", file=sys.stderr)
        return k * k, os.getpid()

    answers = shared([lambda k=k: task(k) for k in range(7)], heard, copies)
    assert [answer for answer, _ in answers] == [k * k for k in range(7)] and sorted(capsys.readouterr().err.splitlines()) == ["task 5", "task 6"]
    assert len({number for _, number in answers}) == copies and (os.getpid() in dict(answers).values()) == (copies == 1)
    assert set(heard) == {"before", "word 0", "word 1"} and (copies == 1 or len(heard) == 3)


def test_an_error_beside_the_work_ends_it(tmp_path, monkeypatch):
    """Functions that no copy has begun are not run, and no copy is left."""
    begun, may_end = multiprocessing.Barrier(3), multiprocessing.Event()

    def task(k):
        if k < 2:
            begun.wait()
            may_end.wait()
        (tmp_path / str(k)).write_text("done")

    class OfTheTest(Exception):
        pass

    kind = multiprocessing.get_context("fork").Process
    join = kind.join
    monkeypatch.setattr(kind, "join", lambda child: (may_end.set(), join(child)))
    with pytest.raises(OfTheTest), sharing([lambda k=k: task(k) for k in range(9)], None, 2):
        begun.wait()
        raise OfTheTest
    assert {path.name for path in tmp_path.iterdir()} == {"0", "1"} and not multiprocessing.active_children()


@pytest.mark.parametrize("copies", [1, 3])
def test_the_first_task_that_fails_is_told(copies, tmp_path):
    def task(k):
        if k in (4, 5):
            raise OSError(errno.ENOSPC, "No space left on device", str(tmp_path / str(k)))
        return k

    with pytest.raises(OSError, match="No space left") as found:
        shared([lambda k=k: task(k) for k in range(7)], None, copies)
    assert found.value.filename == str(tmp_path / "4")


def test_a_copy_that_is_killed():
    with pytest.raises(RuntimeError, match="ended before its work was done"):
        shared([lambda: os._exit(9), lambda: 1], None, 2)
