"""The state through PETSc's viewers: -displacement_view and its like show the numbers that results.h5 holds."""

import os
import re
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests/reliability")]

from quoin_tools.mesh.blockmesh import write  # noqa: E402
from scenes import static  # noqa: E402

QUOIN = os.environ.get("QUOIN", str(ROOT / "build/quoin"))
VECS = ["displacement", "velocity", "force", "load", "mass"]


@pytest.fixture
def folder(tmp_path):
    mesh, scene = static(4)
    write(str(tmp_path / "model.h5"), mesh)
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    return tmp_path


def run(folder, ranks, *options):
    launch = [] if ranks == 1 else ["mpirun", "-quiet", "--oversubscribe", "-n", str(ranks)]
    return subprocess.run([*launch, QUOIN, "-options_file", "scene.yaml", *options], cwd=folder, capture_output=True, text=True)


def displacements(folder):
    """Of all vertices, in ascending order (a Vec is in the order of the ranks), stage by stage; no vertex is rigid here."""
    with h5py.File(folder / "out" / "results.h5") as file:
        return [np.sort(file[f"stages/{stage}/displacement"][()], axis=None) for stage in ("sw", "hp")]


def binary(path):
    """The Vecs of a file of PETSc's binary viewer."""
    data, vecs = path.read_bytes(), []
    while data:
        magic, n = np.frombuffer(data, ">i4", 2)
        assert magic == 1211214
        vecs.append(np.frombuffer(data, ">f8", n, 8).astype(float))
        data = data[8 + 8 * n:]
    return vecs


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.alone)])
def test_viewers_show_what_the_results_hold(folder, ranks):
    views = {"displacement": "binary:u.bin::append", "velocity": "hdf5:v.h5", "force": "binary:f.bin", "load": "binary:load.bin",
             "mass": "ascii:m.txt"}
    done = run(folder, ranks, *[word for name, value in views.items() for word in (f"-{name}_view", value)])
    assert done.returncode == 0 and not done.stderr
    stages, seen = displacements(folder), binary(folder / "u.bin")
    assert len(seen) == len(stages) == 2  # appended, a stage each
    for vec, stage in zip(seen, stages):
        assert np.array_equal(np.sort(vec), stage) and np.ptp(vec) > 0
    n = stages[0].size
    with h5py.File(folder / "v.h5") as file:
        assert file["velocity"].shape == (n,)
    force, load = binary(folder / "f.bin")[0], binary(folder / "load.bin")[0]
    assert force.size == load.size == n
    free = np.abs(force - load) < 1e-4 * np.abs(load).max()  # but for supports, in equilibrium
    assert 0.5 * n < free.sum() < n and np.abs(load).max() > 1e3
    text = (folder / "m.txt").read_text(encoding="utf-8")
    assert "Vec Object: mass" in text and len(re.findall(r"^[1-9]\S*$", text, re.MULTILINE)) == n


@pytest.mark.parametrize("viewer", ["ascii:u.txt:ascii_matlab", "hdf5:u.h5"])
def test_the_last_stage_is_in_the_file(folder, viewer):
    assert run(folder, 1, "-displacement_view", viewer).returncode == 0
    if viewer.startswith("ascii"):
        lines = (folder / "u.txt").read_text(encoding="utf-8").split("[", 1)[1].split("]")[0].split()
        seen = np.array([float(word) for word in lines])
    else:
        with h5py.File(folder / "u.h5") as file:
            seen = file["displacement"][()]
    assert np.array_equal(np.sort(seen), displacements(folder)[1])


def test_a_viewer_that_petsc_lacks_is_refused_at_once(folder):
    done = run(folder, 1, "-load_view", "binari:load.bin")
    assert done.returncode == 2 and not (folder / "out").exists()
    assert done.stderr.strip() == ("quoin: error: command line: -load_view binari:load.bin: expected ascii, binary, draw or hdf5, "
                                   "as -load_view binary:file.bin")


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("viewer, why", [("hdf5:no/such/u.h5", "No such file or directory"), ("ascii:no/such/u.txt", "No such file or directory"),
                                         ("binary:model.h5/u.bin::append", "Not a directory"), (":.", "Is a directory")])
def test_a_file_that_cannot_be_written_is_refused_at_once(folder, viewer, why, ranks):
    done = run(folder, ranks, "-displacement_view", viewer)
    said = [line for line in done.stderr.splitlines() if line.startswith("quoin: error:")]
    assert done.returncode == 2 and said == [f"quoin: error: command line: -displacement_view {viewer}: cannot write the file: {why}"]
    assert [path.name for path in (folder / "out").iterdir()] == ["quoin.lock"]


def test_a_file_may_lie_in_the_output_folder(folder, monkeypatch):
    """Which the run makes; and PETSc puts in values of the environment."""
    monkeypatch.setenv("QUOIN_HERE", str(folder))
    (folder / "here").mkdir()
    viewers = {"displacement": "ascii:out/u.txt", "load": "binary:here/../out/load.bin", "mass": "ascii:${QUOIN_HERE}/m.txt"}
    assert run(folder, 1, *[word for name, value in viewers.items() for word in (f"-{name}_view", value)]).returncode == 0
    assert (folder / "out/u.txt").stat().st_size and binary(folder / "out/load.bin")[0].size and (folder / "m.txt").stat().st_size


def test_misspelt_and_unread_views_are_told(folder):
    assert run(folder, 1, "-displacment_view").returncode == 2
    # advice tries stages and ends none
    advised = run(folder, 1, "-advise", "0.3", *[f"-{name}_view" for name in VECS])
    for name in VECS:
        assert f"-{name}_view was read by nothing" in advised.stderr
