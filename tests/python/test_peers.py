"""The comparison with other programs (tests/benchmark/peers.py) where none is installed, on a coarse dam: each is left out
with a line, and Quoin's own rows are right against the independent solver, which needs CHOLMOD only."""

import ctypes
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
QUOIN = os.environ.get("QUOIN", str(ROOT / "build" / "quoin"))
try:
    ctypes.CDLL("libcholmod.so.3")
    cholmod = True
except OSError:
    cholmod = False
pytestmark = [pytest.mark.long, pytest.mark.skipif(not os.path.exists(QUOIN), reason="the solver is not built"),
              pytest.mark.skipif(not cholmod, reason="CHOLMOD is not installed")]

# stands before what the Python environment may hold
WITHOUT = "raise ImportError('not here')\n"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("peers")
    for name in ("openseespy", "KratosMultiphysics", "compas_lmgc90"):
        (folder / f"{name}.py").write_text(WITHOUT)
    environment = os.environ | {"PYTHONPATH": f"{folder}:{ROOT / 'tools'}", "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run([sys.executable, ROOT / "tests" / "benchmark" / "peers.py", "--quoin", QUOIN, "--folder", folder, "--repeats", "1", "--ccx", folder / "ccx",
                           "--sizes", "16", "--limit", "8", "16", "32", "--paper", "16", "--cap", "0.1", "--explicit", "8", "--walls", "2", "--stones", "101:60", "101:20"],
                          env=environment, capture_output=True, text=True)  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout, json.loads((folder / "peers.json").read_text()), folder


def test_absent_peers_are_named_and_left_out(run):
    out, data, _ = run
    for name in ("CalculiX", "OpenSees", "Kratos", "LMGC90"):
        assert f"{name} is not installed" in out
        assert not any(row["solver"].startswith(name) for part in data.values() for row in part)


def test_quoin_agrees_with_the_independent_solver(run):
    rows = [row for row in run[1]["static"] if row["solver"] == "Quoin"]
    assert [row["law"] for row in rows] == ["elastic", "friction 45 degrees"]
    assert rows[0]["error_same_mesh"] < 1e-6
    assert rows[1]["error_same_mesh"] < 5e-5  # the independent solver integrates the joint at 32 points a segment


def test_stopped_relaxation_tells_its_error(run):
    newton, paper = (next(row for row in run[1]["static"] if row["solver"] == name and row["law"] != "elastic")
                     for name in ("Quoin", "Quoin, the paper's relaxation"))
    assert paper["error_same_mesh"] > 100 * newton["error_same_mesh"]


def test_independent_solver_gives_the_reference(run):
    reference = json.loads((ROOT / "tests" / "data" / "reference" / "fig6_elastic_and_no_tension.json").read_text())
    for key, law in (("elastic_M", "elastic"), ("MC45_M", "friction 45 degrees")):
        crest = next(row["crest_ux"] for row in reference[key] if row["n"] == 16)
        row = next(row for row in run[1]["static"] if row["solver"] == "Quoin" and row["law"] == law)
        assert row["crest"] * 1e3 == pytest.approx(crest, rel=2e-5)


def test_stiff_joints_press_in_as_much_less(run):
    """Two orders of k_n: stones stand with the same forces and a hundredth of the penetration; at 20 degrees they fall."""
    soft, stiff, sheared, *falls = sorted(run[1]["stones"], key=lambda row: -row["friction"])
    assert {row["verdict"] for row in (soft, stiff, sheared)} == {"stands"}
    assert soft["penetration"] == pytest.approx(100 * stiff["penetration"], rel=1e-3) and soft["normal"] == pytest.approx(stiff["normal"], rel=1e-3)
    assert soft["penetration"] > 1e-5
    assert abs(sheared["normal"] / stiff["normal"] - 1) > 0.01  # k_s/k_n decides between forces that all balance
    assert [row["verdict"] for row in falls] == ["falls"] * 3
    assert "- LMGC90" not in (run[2] / "peers.md").read_text()


def test_tables_and_picture_are_written(run):
    _, data, folder = run
    text = (folder / "peers.md").read_text()
    assert text.count("| Quoin |") == 2 + 1  # two laws, one wall
    assert (folder / "peers.png").stat().st_size > 10000
    assert all(row["ns"] > 0 for row in data["explicit"])


def test_one_part_into_a_new_folder(run, tmp_path):
    """The other parts are empty tables; it ended in a KeyError, and wanted a folder that is there."""
    done = subprocess.run([sys.executable, ROOT / "tests" / "benchmark" / "peers.py", "--quoin", QUOIN, "--folder", tmp_path / "a/b", "--repeats", "1", "--ccx",
                           run[2] / "ccx", "--sizes", "8", "--limit", "8", "16", "32", "--paper", "8", "--cap", "0.1", "--parts", "static"],
                          env=os.environ | {"PYTHONPATH": f"{run[2]}:{ROOT / 'tools'}", "OPENBLAS_NUM_THREADS": "1"}, capture_output=True, text=True)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert {path.name for path in (tmp_path / "a/b").iterdir()} == {"peers.json", "peers.md", "peers.png"}
