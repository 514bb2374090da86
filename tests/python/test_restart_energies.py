"""After a restart on as many ranks the energy account of a dynamic stage has the bits of the straight run."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests/reliability")]

import yaml  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from run import ENVIRONMENT  # noqa: E402
from scenes import dynamic  # noqa: E402

QUOIN = os.environ.get("QUOIN", str(ROOT / "build/quoin"))


def run(folder, ranks, *options):
    command = ["mpirun", "-q", "-n", str(ranks), "--oversubscribe", "--bind-to", "none", QUOIN, "-options_file", "scene.yaml"]
    subprocess.run([*command, *map(str, options)], cwd=folder, check=True, capture_output=True, env=ENVIRONMENT | dict(os.environ))


def told(out):
    """history.csv, and the summary's stage but for the clock."""
    stage = json.loads((out / "summary.json").read_text(encoding="utf-8"))["stages"][0]
    return (out / "history.csv").read_text(encoding="utf-8"), {name: value for name, value in stage.items() if name != "wall_s"}


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.alone)])
def test_energies_after_a_restart(tmp_path, ranks):
    mesh, scene = dynamic(0.15, 3)
    write(str(tmp_path / "model.h5"), mesh)
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    run(tmp_path, ranks, "-checkpoint_every", 1000, "-checkpoint_keep", 1000)
    expected = told(tmp_path / "out")
    checkpoints = sorted((tmp_path / "out" / "checkpoints").glob("*.h5"))[1:-1]
    assert len(checkpoints) > 3 and expected[1]["contacts_made"] > 0
    for path in checkpoints[1::4]:
        run(tmp_path, ranks, "-restart", path, "-output", "again")
        history, stage = told(tmp_path / "again")
        assert stage == expected[1]
        assert history.splitlines()[1:] == expected[0].splitlines()[-len(history.splitlines()) + 1:]
