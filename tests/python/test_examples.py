"""The examples run as their headers say and give the numbers of their references.
ranks: 1 3"""

import csv
import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
QUOIN = os.environ.get("QUOIN", str(ROOT / "build" / "quoin"))
pytestmark = pytest.mark.skipif(not os.path.exists(QUOIN), reason="the program is not built")


def load(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def run(example, folder, ranks=1, mesh=(), options=()):
    """summary.json of an example; its stages by name."""
    folder.mkdir()
    model = str(folder / "model.h5")
    environment = dict(os.environ, PYTHONPATH=str(ROOT / "tools"))
    subprocess.run([sys.executable, f"examples/{example}/mesh.py", model, *mesh], cwd=ROOT, env=environment,
                   check=True, timeout=60)
    subprocess.run(["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), QUOIN, "-options_file",
                    f"examples/{example}/scene.yaml", "-model", model, "-output", str(folder), *options],
                   cwd=ROOT, check=True, timeout=120)
    with open(folder / "summary.json", encoding="utf-8") as file:
        return {stage["name"]: stage for stage in json.load(file)["stages"]}


@pytest.fixture(scope="module")
def dam(tmp_path_factory):
    folder = tmp_path_factory.mktemp("guilhofrei") / "one"
    return folder, run("guilhofrei", folder)


def test_guilhofrei(dam):
    """Every number of reference.csv against the finite elements: 0.5 %, 3 % at the heel, which slips."""
    for row in load(ROOT / "examples/guilhofrei/compare.py").compare(dam[0]):
        close = 0.03 if row["key"] == "joint_heel" else 0.005
        if row["fe"] is not None:
            assert row["ours"] == pytest.approx(row["fe"], rel=close, abs=0.001), row["quantity"]


def test_guilhofrei_on_three_ranks_has_the_same_bits(dam, tmp_path):
    """Water that follows faces which ranks share."""
    three = run("guilhofrei", tmp_path / "three", ranks=3)
    assert [stage["checksum"] for stage in three.values()] == [stage["checksum"] for stage in dam[1].values()]


@pytest.mark.parametrize("model", ["pt", "r2pt", "r3pt", "tptm"])
def test_fig6(model, tmp_path):
    """8 blocks along the base, family M."""
    stage = run("fig6", tmp_path / model, mesh=("8", "M"), options=("-joints_base_stress_model", model))["full"]
    with open(ROOT / "examples/fig6/reference.csv", encoding="utf-8", newline="") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        row, = [row for row in rows if (row["family"], row["n"], row["model"]) == ("M", "8", model)]
    base = stage["joints"]["base"]
    assert base["end"]["sigma"] * 1e-6 == pytest.approx(float(row["toe_MPa"]), rel=1e-4)
    assert base["start"]["sigma"] * 1e-6 == pytest.approx(float(row["heel_MPa"]), rel=1e-4)
    assert stage["probes"]["crest"]["u_x"] * 1e3 == pytest.approx(float(row["crest_ux_mm"]), rel=1e-4)
