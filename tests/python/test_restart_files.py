"""A restart does not replace what it cannot read just now: it ends with one line, and the next one goes on."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
QUOIN = os.environ.get("QUOIN", str(ROOT / "build" / "quoin"))
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests/reliability")]

import yaml  # noqa: E402
from calls import content  # noqa: E402
from quoin_tools.base.integrity import check_folder  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from run import ENVIRONMENT, outcome  # noqa: E402
from scenes import dynamic, static  # noqa: E402

pytestmark = pytest.mark.skipif(not os.path.exists(QUOIN), reason="the program is not built")


def moving():
    """Blocks that fall, with frames; rows of history.csv often enough that checkpoints have some."""
    mesh, scene = dynamic(0.02, 2)
    scene["stages"][0]["fall"]["frames"] = 4
    scene["relaxation"]["history_every"] = 50
    return mesh, scene


def run(folder, *options):
    done = subprocess.run([QUOIN, "-options_file", "scene.yaml", *options], cwd=folder, capture_output=True, text=True, env=os.environ | ENVIRONMENT)
    return done.returncode, done.stderr.strip()


@pytest.fixture(scope="module", params=["static", "moving"])
def before(request, tmp_path_factory):
    """A folder with a checkpoint in the middle of a run and what it had written by then, and what the run comes to."""
    folder = tmp_path_factory.mktemp(request.param)
    mesh, scene = static(4) if request.param == "static" else moving()
    write(str(folder / "model.h5"), mesh)
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    every = "150" if request.param == "static" else "500"
    code, error = run(folder, "-checkpoint_every", every, "-checkpoint_keep", "1000")
    assert code == 0, error
    expected = content(folder)
    numbers = sorted(int(path.stem.split("_")[1]) for path in (folder / "out" / "checkpoints").glob("*.h5"))
    middle = f"checkpoint_{numbers[2 * len(numbers) // 3]:06d}.h5"
    for path in (folder / "out" / "checkpoints").glob("*.h5"):
        if path.name != middle:
            path.unlink()
    return folder, expected


@pytest.mark.parametrize("name", ["history.csv", "joint_history.csv", "results.h5"])
def test_what_cannot_be_read_stays(before, name, tmp_path):
    """A link to itself cannot be opened by anybody, the superuser included. It was replaced: rows and stages up to the checkpoint were lost."""
    folder, expected = before
    if not (folder / "out" / name).exists():
        return  # nothing runs in time
    shutil.copytree(folder, tmp_path / "run")
    path, kept = tmp_path / "run" / "out" / name, tmp_path / name
    shutil.move(path, kept)
    path.symlink_to(name)
    code, error = run(tmp_path / "run", "-restart", "auto")
    assert code in (8, 10) and f"output: cannot read 'out/{name}': Too many levels of symbolic links" in error, (code, error)
    assert len(error.splitlines()) == 1 and path.is_symlink()
    path.unlink()
    shutil.move(kept, path)
    code, error = run(tmp_path / "run", "-restart", "auto")
    assert code == 0 and content(tmp_path / "run") == expected, error


def tree(folder):
    """Contents of all files but the lock's."""
    return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file() and path.name != "quoin.lock"}


@pytest.mark.parametrize("name", ["history.csv", "joint_history.csv", "results.h5"])
def test_a_flipped_bit_is_told(before, name, tmp_path):
    """Histories that are damaged start again behind the checkpoint, with a warning. Without its results a run does not go on by `auto`: who names the checkpoint
    goes on without the stages before it, and the summary names them. What the run leaves is whole, and as far as it goes the same."""
    folder, expected = before
    if not (folder / "out" / name).exists():
        return
    shutil.copytree(folder, tmp_path / "run")
    path = tmp_path / "run" / "out" / name
    data = bytearray(path.read_bytes())
    data[len(data) // 4] ^= 1
    path.write_bytes(bytes(data))
    restart, stopped = ("-restart", "auto"), ""
    if name == "results.h5":
        files = tree(tmp_path / "run" / "out")
        code, error = run(tmp_path / "run", *restart)
        assert code == 10 and re.search("does not hold [14] of the (stages|frames)", error) and len(error.splitlines()) == 1, (code, error)
        assert tree(tmp_path / "run" / "out") == files
        restart, stopped = ("-restart", "out"), error
    code, error = run(tmp_path / "run", *restart)
    assert code == 0 and name in error and len(error.splitlines()) == 1, (code, error)
    said = check_folder(tmp_path / "run" / "out")
    assert any("without stage" in line for line in said) == ("of the stages" in stopped), said
    assert outcome(tmp_path / "run")[0] == expected[3][0]
