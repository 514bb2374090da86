"""Quoin from Python (docs/python.md): its examples, tables beside the arrays that they come from, and types for checkers."""

import doctest
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from quoin_tools.base import tables
from quoin_tools.base.results import Results

ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
MYPY = ROOT / "build/checkers/bin/mypy"
pytestmark = pytest.mark.skipif(not QUOIN.exists(), reason="the program is not built")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where the examples of the page have run."""
    place = tmp_path_factory.mktemp("python")
    page = (ROOT / "docs/python.md").read_text(encoding="utf-8").replace("```pycon", "").replace("```", "")
    before = Path.cwd()
    os.chdir(place)
    try:
        examples = doctest.DocTestParser().get_doctest(page, {}, "docs/python.md", "docs/python.md", 0)
        told: list[str] = []
        counted = doctest.DocTestRunner().run(examples, out=told.append)
    finally:
        os.chdir(before)
    assert counted.attempted > 15 and counted.failed == 0, "".join(told)
    return place


def test_tables_are_the_arrays(folder):
    results = Results(folder / "out")
    stage = results.stage("push")
    vertices, blocks, contacts = (results.table(kind, "push") for kind in ("vertices", "blocks", "contacts"))
    assert (vertices[["u_x", "u_y"]].to_numpy() == stage.displacement).all() and (vertices[["x", "y"]].to_numpy() == results.mesh.vertices).all()
    assert np.array_equal(blocks[["s_xx", "s_yy", "s_xy"]].to_numpy(), stage.stress, equal_nan=True) and blocks["group"].tolist() == ["plate", "block"]
    for k in (0, 1):
        assert (contacts.xs(k, level="end")["tau"].to_numpy() == stage.contacts.tau[:, k]).all()
        assert (contacts.xs(k, level="end")["force_n"].to_numpy() == stage.contacts.force[:, k, 0]).all()
    history = results.table("history")
    assert {name: len(column) for name, column in results.history.items()} == dict.fromkeys(history.columns, len(history))
    for table in (vertices, blocks, contacts, history):
        assert list(table.attrs["units"]) == list(table.columns)
    assert history.attrs["units"] | {"alpha_per_s": "1/s", "kinetic_J": "J", "cycle": "", "dt_s": "s"} == history.attrs["units"]
    with pytest.raises(tables.TableError, match="there are: vertices, blocks"):
        results.table("block")


@pytest.mark.long
@pytest.mark.skipif(not MYPY.exists(), reason="needs mypy of tools/check.sh")
def test_types_of_an_installed_module(tmp_path):
    """As `pip install .` leaves it: a right program passes, and a wrong one does not."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", tmp_path / "venv"], check=True)
    site = next((tmp_path / "venv/lib").glob("python*/site-packages"))
    subprocess.run([sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--disable-pip-version-check", "--no-build-isolation", "--target", site, ROOT], check=True)
    program = "import quoin\nresults = quoin.run('scene.yaml', ranks={})\nnames: list[str] = results.stages\nresults.table('blocks', names[0])\n"
    told = {}
    for name, ranks in (("good", "2"), ("bad", "'two'")):
        (tmp_path / f"{name}.py").write_text(program.format(ranks), encoding="utf-8")
        words = [MYPY, "--ignore-missing-imports", "--python-executable", tmp_path / "venv/bin/python", f"{name}.py"]
        told[name] = subprocess.run(words, cwd=tmp_path, env=os.environ | {"PYTHONPATH": ""}, capture_output=True, text=True, check=False).stdout
    assert "Success" in told["good"] and 'incompatible type "str"' in told["bad"], told
