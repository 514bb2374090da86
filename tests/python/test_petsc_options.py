"""Options for PETSc's solvers change bits of preconditioned runs: they are reported, recorded, and compared by a restart."""

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
from scenes import static  # noqa: E402

QUOIN = os.environ.get("QUOIN", str(ROOT / "build/quoin"))


@pytest.fixture
def folder(tmp_path):
    mesh, scene = static(4)
    scene = scene | {"relaxation": scene["relaxation"] | {"method": "preconditioned"}}
    write(str(tmp_path / "model.h5"), mesh)
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    return tmp_path


def run(folder, *options):
    """What it prints, what it warns of, and its summary."""
    done = subprocess.run([QUOIN, "-options_file", "scene.yaml", *options], cwd=folder, capture_output=True, text=True, check=True)
    return done.stdout, done.stderr, json.loads((folder / "out" / "summary.json").read_text(encoding="utf-8"))


def test_options_are_told_and_recorded(folder):
    told, _, summary = run(folder)
    assert "petsc_options" not in summary and "for PETSc's solvers" not in told
    told, warned, summary = run(folder, "-mat_no_inode", "-ksp_monitor")
    assert "for PETSc's solvers: -mat_no_inode:" in told and not warned
    assert summary["petsc_options"] == "-mat_no_inode"
    assert "# options of PETSc's solvers: -mat_no_inode" in (folder / "out" / "scene_echo.yaml").read_text(encoding="utf-8")


def test_a_restart_compares_them(folder):
    run(folder, "-checkpoint_keep", "9")
    told = run(folder, "-restart", "out/checkpoints/checkpoint_000001.h5", "-mat_no_inode")[0]
    assert "changed since the checkpoint: petsc_options: not given -> -mat_no_inode" in told


def test_no_warning_of_what_nobody_has_given(folder):
    assert not run(folder, "-pc_type", "jacobi")[1]
    assert "-mat_no_inod was read by nothing" in run(folder, "-mat_no_inod")[1]


def test_traps_of_the_processor_are_refused(folder):
    """-fp_trap ended each run with exit code 7: what vector code throws away may divide by zero."""
    done = subprocess.run([QUOIN, "-options_file", "scene.yaml", "-fp_trap"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 2 and done.stderr == ("quoin: error: command line: -fp_trap: lanes whose results are thrown away may divide by zero: "
                                                    "NaN is looked for instead\n")
