"""Files of a run are written whole: at the end of each of many short stages this cost the square of their number."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests/reliability")]

import yaml  # noqa: E402
from quoin_tools.base.integrity import check_folder  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from scenes import stages  # noqa: E402

QUOIN = os.environ.get("QUOIN", str(ROOT / "build/quoin"))


def run(folder, n, *options):
    folder.mkdir(exist_ok=True)
    mesh, scene = stages(n)
    write(str(folder / "model.h5"), mesh)
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    subprocess.run([QUOIN, "-options_file", "scene.yaml", *options], cwd=folder, check=True, capture_output=True)
    return folder / "out"


def checkpoints(out):
    """How many have been written: the number of the last."""
    return max(int(path.stem.split("_")[1]) for path in (out / "checkpoints").glob("*.h5"))


def test_written_less_often_than_stages_end(tmp_path):
    out = run(tmp_path / "many", 160)
    assert checkpoints(out) < 100  # 16 stages, then those that are a sixteenth more: 16 (1 + ln 10) = 53; of a slow machine more
    assert len(check_folder(out)) == 5 and not list(out.rglob("*.part"))
    assert Results(out).stages == [f"s{i}" for i in range(160)]


def test_few_stages_are_written_one_by_one(tmp_path):
    assert checkpoints(run(tmp_path / "few", 16)) == 16


def test_a_checkpoint_takes_waiting_stages_along(tmp_path):
    straight = Results(run(tmp_path / "straight", 40))
    out = run(tmp_path / "often", 40, "-checkpoint_every", "700")  # within each stage
    assert checkpoints(out) >= 40 and len(check_folder(out)) == 5
    checksums = [[stage["checksum"] for stage in results.summary["stages"]] for results in (Results(out), straight)]
    assert checksums[0] == checksums[1]
