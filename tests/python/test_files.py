"""A file of a tool that cannot be written: one line names it, the file of before stays, nothing is left behind."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from quoin_tools.base import files  # noqa: E402
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


def test_no_results_file(tmp_path):
    (tmp_path / "results.h5").write_bytes(b"none")
    with pytest.raises(OSError), files.reading(tmp_path / "results.h5"):
        pass
