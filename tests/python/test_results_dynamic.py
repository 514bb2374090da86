"""What a dynamic stage writes: frames, time and energies in every file, and vertices on faces."""

import os
import re
import shutil
import subprocess
import sys

import h5py
import numpy as np
import pytest

ROOT = os.path.join(os.path.dirname(__file__), "..", "..")
sys.path.insert(0, os.path.join(ROOT, "tools"))

from quoin_tools.base import results  # noqa: E402
from quoin_tools.base.results import ENERGIES, VERTEX_FACE, Results  # noqa: E402
from quoin_tools.mesh import blockmesh, stacks  # noqa: E402
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed  # noqa: E402
from quoin_tools.show import plots  # noqa: E402
from sealed import seal_results  # noqa: E402

QUOIN = os.environ.get("QUOIN", os.path.join(ROOT, "build", "quoin"))
pytestmark = pytest.mark.skipif(not os.path.exists(QUOIN), reason="the solver is not built")

DROP = """
model: model.h5
contact: {connectivity: variable, tolerance: 0.002}
relaxation: {allow_floating: true, history_every: 20}
materials:
  block: {density: 2400, young: 1e8, poisson: 0.2, velocity: [0.1, 0], spin: 0.2}
  base: {density: 2400, rigid: true}
joints:
  default: {stress_model: tptm, k_n: 1e9, k_s: 1e9, friction: 30}
supports: {base: {fix: xy}}
loads:
  weight: {type: self_weight, groups: [block]}
stages:
  - fall: {type: dynamic, loads: [weight], duration: 0.05, frames: 4}
"""

SHAKEN = """
title: A block on a plane that is shaken for two seconds
model: model.h5
contact: {connectivity: variable, tolerance: 0.002}
materials:
  block: {density: 2400, rigid: true, velocity: [0.3, 0]}
  base: {density: 2400, rigid: true}
joints:
  default: {stress_model: tptm, k_n: 1e9, k_s: 1e9, friction: 30, damping: 1e-4}
supports:
  base: {fix: xy, motion: shake.csv, quantity: acceleration}   # rows of t [s], x, y [m/s2]
loads:
  weight: {type: self_weight, groups: [block]}
stages:
  - rest: {loads: [weight]}
  - shaking: {type: dynamic, loads: [weight], duration: 2.0, dt_factor: 0.05, alpha: 0, frames: 20}
"""


def run_quoin(folder, ranks=1, *options):
    command = [*(["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"] if ranks > 1 else []), QUOIN]
    environment = os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    return subprocess.run([*command, "-options_file", "scene.yaml", "-output", f"out{ranks}", *options], cwd=folder,
                          capture_output=True, text=True, timeout=120, env=environment)  # fmt: skip


@pytest.fixture(scope="module")
def shaken(tmp_path_factory):
    """A rigid block that slides on a plane, and the plane is shaken."""
    folder = tmp_path_factory.mktemp("shaken")
    blockmesh.write(folder / "model.h5", stacks.block_on_plane(slope_degrees=0, plane_length=3.0, start=1.0))
    (folder / "scene.yaml").write_text(SHAKEN, encoding="utf-8")
    t = np.arange(0, 1.505, 0.01)
    rows = np.c_[t, 1.5 * np.sin(4 * np.pi * t), 0 * t]
    np.savetxt(folder / "shake.csv", rows, fmt="%.9g", delimiter=", ", header="t [s], x, y [m/s2]")
    done = run_quoin(folder)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="module")
def dropped(tmp_path_factory):
    """A block of 3 by 3, tilted by 29 degrees (up to 20 it would be a face on a face), falls on its corner; on 1 and 2 ranks."""
    folder = tmp_path_factory.mktemp("dropped")
    along, up = np.array([np.cos(0.5), np.sin(0.5)]), np.array([-np.sin(0.5), np.cos(0.5)])
    corner = np.array([0.0, 1e-3])
    block = quad_patch(corner, corner + along, corner + along + up, corner + up, 3, 3, "block", False)
    ground = rectangle(-3.0, -1.0, 6.0, 1.0, group="base", rigid=True)
    mesh = join([renamed(ground, {"bottom": "bottom"}), renamed(block, {"top": "top"}, {"corner": "bottom_left"})])
    blockmesh.write(folder / "model.h5", mesh)
    (folder / "scene.yaml").write_text(DROP, encoding="utf-8")
    for ranks in (1, 2):
        done = run_quoin(folder, ranks)
        assert done.returncode == 0, done.stderr
    return folder


def test_frames(shaken):
    run = Results(shaken / "out1")
    names = run.frames("shaking")
    assert run.stages == ["rest", "shaking"] and run.frames("rest") == []
    assert names == [f"shaking_{k}" for k in range(1, 21)]
    frames, end, dt = [run.stage(name) for name in names], run.stage("shaking"), run.stage_summary("shaking")["dt"]
    late = np.array([frame.time for frame in frames]) - 2.0 * np.arange(1, 21) / 21
    assert np.all(late > -1e-9) and np.all(late < dt + 1e-9)
    assert end.time == pytest.approx(2.0) and end.verdict == "completed" and frames[0].verdict == "running"
    history = run.history
    time = np.where(history["stage"] == "shaking", history["time_s"], np.nan)
    point = int(np.argmin(np.hypot(*(run.mesh.vertices - [-2.0, 0.2]).T)))
    for frame in frames:  # where the row of history.csv is that has the same time, or nearly
        row = np.nanargmin(np.abs(time - frame.time))
        near = abs(time[row] - frame.time) * 1.0  # [m] at 1 m/s
        assert frame.displacement[point, 0] == pytest.approx(history["top_left_ux_m"][row], abs=near + 1e-9)


def test_xdmf_has_the_frames_at_their_times(shaken):
    xdmf = pytest.importorskip("vtkmodules.vtkIOXdmf2")
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline

    run, reader = Results(shaken / "out1"), xdmf.vtkXdmfReader()
    reader.SetFileName(str(shaken / "out1" / "results.xdmf"))
    reader.UpdateInformation()
    information = reader.GetOutputInformation(0)
    times = information.Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    names = ["rest", *run.frames("shaking"), "shaking"]
    assert np.array(times) == pytest.approx([1.0 + run.stage(name).time for name in names])  # the static stage counts 1
    for name, time in zip(names, times, strict=True):
        stage = run.stage(name)
        reader.UpdateTimeStep(time)
        iterator = reader.GetOutputDataObject(0).NewIterator()
        iterator.InitTraversal()
        found = vtk_to_numpy(iterator.GetCurrentDataObject().GetPointData().GetArray("displacement"))
        assert np.array_equal(found[:, :2], stage.displacement), name


def test_energies_of_all_files_agree(shaken):
    run = Results(shaken / "out1")
    history, facts = run.history, run.stage_summary("shaking")
    static = history["stage"] == "rest"
    assert np.isnan(history["balance_J"][static]).all() and not history["time_s"][static].any()
    e = {name: history[f"{name}_J"][~static] for name in ENERGIES}
    assert {name: e[name][-1] for name in ENERGIES} == pytest.approx({name: facts["energy"][name] for name in ENERGIES}, rel=1e-9, abs=1e-12)
    assert facts["energy"]["moved"] == pytest.approx(0.5 * 2400 * 0.2 * 0.3**2 + abs(facts["energy"]["outside"]) + abs(facts["energy"]["supports"]), rel=1e-2)
    assert facts["time"] == pytest.approx(2.0) and facts["verifications"] > 100
    assert facts["contacts_made"] == facts["contacts_lost"] == 0
    came = e["outside"] + e["supports"]
    went = e["friction"] - e["detection"] + e["damping"]
    there = e["kinetic"] + e["strain"] + e["joints"]
    assert came - went - (there - there[0]) - e["balance"] == pytest.approx(0 * came, abs=1e-6)
    mass, v = 2400 * 0.2, 0.3
    assert e["kinetic"][0] == pytest.approx(0.5 * mass * v**2, rel=1e-3)
    assert np.abs(e["balance"]).max() < 1e-3 * e["friction"][-1]


def test_table_and_picture_of_energies(shaken, capsys):
    assert results.main([str(shaken / "out1")]) == 0
    text = capsys.readouterr().out
    assert "Energy of dynamic stages" in text and "detection J" in text
    assert plots.main([str(shaken / "out1")]) == 0
    written = {os.path.basename(path) for path in capsys.readouterr().out.split()}
    assert "energy_shaking.png" in written and "energy_rest.png" not in written and "history.png" in written


@pytest.mark.alone  # the first to ask for the runs
def test_vertex_on_a_face(dropped):
    """One vertex carries the block: its place, its ids in the file, and one end with all of the force."""
    run = Results(dropped / "out1")
    seen = 0
    for name in [*run.frames("fall"), "fall"]:
        contacts = run.stage(name).contacts
        for i in np.flatnonzero(contacts.klass == VERTEX_FACE):
            block, k, none, vertex = contacts.face[i]
            seen += 1
            assert none == -1 and run.mesh.vertices[vertex] == pytest.approx([0.0, 1e-3])
            assert run.mesh.group_names[run.mesh.block_group[block]] == "base"
            ring = run.mesh.blocks[block]
            assert run.mesh.vertices[ring[[k, (k + 1) % 4]]][:, 1] == pytest.approx([0, 0])  # the top of the base
            for field in ("point", "displacement", "normal", "opening", "sliding", "slip", "sigma", "tau", "state"):
                ends = getattr(contacts, field)[i]
                assert np.array_equal(ends[0], ends[1]), field
            assert np.all(contacts.force[i, 1] == 0)
            assert contacts.force[i, 0, 0] == pytest.approx(contacts.sigma[i, 0] * contacts.length[i], rel=1e-12)
            assert contacts.normal[i, 0] == pytest.approx([0, -1])  # from the vertex, side b, to the face, side a
    assert seen > 0
    facts = run.stage_summary("fall")
    assert facts["contacts_made"] >= 1 and facts["verdict"] == "completed"


def test_same_numbers_on_two_ranks(dropped):
    one, two = Results(dropped / "out1"), Results(dropped / "out2")
    assert one.stage_summary("fall")["checksum"] == two.stage_summary("fall")["checksum"]
    assert one.stage_summary("fall")["energy"] == pytest.approx(two.stage_summary("fall")["energy"], rel=1e-9, abs=1e-9)
    for name in [*one.frames("fall"), "fall"]:
        a, b = one.stage(name), two.stage(name)
        assert np.array_equal(a.displacement, b.displacement)
        for field in ("face", "klass", "length", "point", "opening", "sigma", "force"):
            assert np.array_equal(getattr(a.contacts, field), getattr(b.contacts, field)), (name, field)


def test_a_stage_may_not_be_named_like_a_frame(shaken):
    lines = (shaken / "scene.yaml").read_text(encoding="utf-8")
    (shaken / "scene.yaml").write_text(lines + "  - shaking_3: {loads: [weight]}\n", encoding="utf-8")
    done = run_quoin(shaken, 1, "-output", "refused")
    (shaken / "scene.yaml").write_text(lines, encoding="utf-8")
    assert done.returncode == 2 and "stages.shaking_3: is the name of a frame of stage shaking" in done.stderr


def groups(run):
    with h5py.File(run / "results.h5") as file:
        return set(file["stages"])


def test_restart_where_frames_are_not(shaken):
    """From a checkpoint between two frames: into a fresh folder, and where results.h5 has lost one of the frames before it. The
    run goes on without them, says so at the start, and no file names what is not there."""
    assert run_quoin(shaken, 1, "-output", "whole", "-checkpoint_every", "10000", "-checkpoint_keep", "100").returncode == 0
    whole = Results(shaken / "whole")
    path = sorted((shaken / "whole/checkpoints").glob("*.h5"))[9]  # of 18
    shutil.copytree(shaken / "whole", shaken / "holed")
    with h5py.File(shaken / "holed/results.h5", "r+") as file:
        del file["stages/shaking_2"]
    seal_results(shaken / "holed/results.h5")
    for folder, before in (("fresh", 0), ("holed", 1), ("whole", 2)):
        done = run_quoin(shaken, 1, "-output", folder, "-restart", str(path))
        assert done.returncode == 0 and "goes on from" in done.stdout, done.stderr
        run, there = Results(shaken / folder), groups(shaken / folder)
        lost = [name for name in groups(shaken / "whole") if name not in there]
        said = re.search(rf"restart: '{folder}' does not hold (\d+) of the (\d+) frames of stage shaking", done.stderr)
        assert ("results.h5' does not hold the stages" in done.stderr) == ("history.csv' does not" in done.stderr) == (before == 0)
        if before == 2:
            assert not said and not lost
        elif before == 1:
            assert said[1] == "1" and lost == ["shaking_2"]
        else:
            written = int(said[1])
            assert said[2] == said[1] and 5 < written < 15
            assert set(lost) == {"rest", *(f"shaking_{k}" for k in range(1, written + 1))}
        assert run.stage_summary("shaking")["checksum"] == whole.stage_summary("shaking")["checksum"]
        for name in there:
            assert np.array_equal(run.stage(name).displacement, whole.stage(name).displacement), name
        assert set(re.findall(r"results\.h5:/stages/(\w+)/", (shaken / folder / "results.xdmf").read_text())) == there
        assert not [file for file in os.listdir(shaken / folder) if file.endswith(".part") or file.startswith("shaking_")]
