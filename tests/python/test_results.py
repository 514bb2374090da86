"""Results: the reader, its table and the pictures on a folder written here by hand after
docs/results_format.md; and what the solver itself writes, read back by h5py and by VTK's own XDMF reader."""

import json
import os
import runpy
import subprocess
import sys

import h5py
import numpy as np
import pytest

ROOT = os.path.join(os.path.dirname(__file__), "..", "..")
sys.path.insert(0, os.path.join(ROOT, "tools"))

from quoin_tools.base import results  # noqa: E402
from quoin_tools.base.integrity import HEADER  # noqa: E402
from quoin_tools.base.results import CRUSHING, OPEN, SLIPPING, Results, ResultsError  # noqa: E402
from quoin_tools.mesh import blockmesh, stacks  # noqa: E402
from quoin_tools.mesh.meshing import split_triangles  # noqa: E402
from quoin_tools.show import export, paraview_state, plots, stress, style  # noqa: E402
from sealed import history_member, seal_results, write_summary  # noqa: E402

QUOIN = os.environ.get("QUOIN", os.path.join(ROOT, "build", "quoin"))
N = 4  # columns of the body below

solver = pytest.mark.skipif(not os.path.exists(QUOIN), reason="the solver is not built")


# ---- a folder written by hand: a square on a wide rock; stress is that of a column with an eccentric load


def body(n, x, y, width, height):
    """Vertices and blocks of n by n rectangles."""
    s = np.linspace(0, 1, n + 1)
    vertices = np.array([(x + width * a, y + height * b) for b in s for a in s])
    rows = [(j * (n + 1) + i, j * (n + 1) + i + 1, (j + 1) * (n + 1) + i + 1, (j + 1) * (n + 1) + i)
            for j in range(n) for i in range(n)]  # fmt: skip
    return vertices, np.array(rows)


def hand_mesh():
    upper, lower = body(N, 0.0, 0.0, 2.0, 2.0), body(2, -4.0, -5.0, 10.0, 5.0)
    blocks = np.concatenate([upper[1], lower[1] + len(upper[0])])
    blocks = np.concatenate(
        [blocks[1:], [[0, 1, N + 2, -1], [0, N + 2, N + 1, -1]]]
    )  # block 0 becomes two triangles
    return np.concatenate([upper[0], lower[0]]), blocks, np.array([0] * (N * N - 1) + [1] * 4 + [0] * 2)


def sigma_at(x):
    """[Pa] N = 2e5 N compression, M = 2e4 N m about the middle of the base, 2 m long."""
    return -1e5 + 12 * 2e4 * (x - 1.0) / 8


def write_stage(group, index, factor, vertices, blocks):
    group.attrs.update({"index": index, "verdict": b"converged", "evidence": b'ratio "small"'})
    group.attrs.update({"cycles": 100, "ratio": 1e-9})
    nb, ends = len(blocks), np.linspace(0, 2, N + 1)
    centre = np.array([vertices[row[row >= 0]].mean(axis=0) for row in blocks])
    syy = factor * sigma_at(centre[:, 0])
    group["displacement"] = factor * 1e-3 * np.c_[0.2 * vertices[:, 1], -0.1 * vertices[:, 1]]
    group["stress"] = np.c_[np.zeros(nb), syy, np.zeros(nb)]
    group["s1"], group["s2"], group["angle"] = np.maximum(syy, 0), np.minimum(syy, 0), np.zeros(nb)
    group["gauss_stress"] = np.full((nb, 4, 3), np.nan)
    group["rotation"] = np.full(nb, np.nan)
    contacts = group.create_group("contacts")
    x = np.c_[ends[1:], ends[:-1]][::-1]  # from right to left, to be sorted by the reader
    contacts["face"] = np.c_[np.arange(N), np.zeros(N, int), np.full(N, N * N), np.full(N, 2)]
    contacts["joint"], contacts["class"] = np.ones(N, int), np.zeros(N, int)
    contacts["state"], contacts["length"], contacts["open"] = np.zeros((N, 2), int), np.full(N, 0.5), np.zeros(N)
    contacts["point"], contacts["displacement"] = np.stack([x, 0 * x], axis=2), np.zeros((N, 2, 2))
    contacts["normal"], contacts["force"] = np.tile([0.0, 1.0], (N, 2, 1)), np.zeros((N, 2, 2))
    for name in ("opening", "sliding", "slip", "broken"):
        contacts[name] = np.zeros((N, 2))
    contacts["sigma"], contacts["tau"] = factor * sigma_at(x), np.full((N, 2), -3e4)


def joint_summary(factor):
    def end(x):
        return {"x": x, "y": 0.0, "sigma": factor * sigma_at(x), "tau": -3e4, "opening": 0.0, "sliding": 0.0}

    both = {"law": "mohr_coulomb", "n_contacts": N, "length": 2.0, "N": factor * 2e5, "T": 6e4}
    both |= {"open_length": 0.25, "slipping_length": 0.0, "crushing_length": 0.0}
    both |= {"friction_needed": 16.7, "sliding_factor_peak": 2.5, "sliding_factor_residual": None}
    both |= {"sigma_min": end(0.0), "sigma_max": end(2.0)}
    line = {"line": True, "M": factor * 2e4, "force": {"x": 6e4, "y": -2e5}, "chord": 2.0}
    line |= {"start": end(0.0), "end": end(2.0)}
    line |= {"sigma_linear_start": factor * sigma_at(0.0), "sigma_linear_end": factor * sigma_at(2.0)}
    return {"base": both | line, "net": both | {"line": False}}


def stage_summary(name, factor):
    high = {"value": 10.0, "block": 1, "x": 0.5, "y": 0.5}
    low = {"value": -1e6, "block": 2, "x": 1.0, "y": 0.5}
    stage = {"name": name, "verdict": "converged", "evidence": "ratio 1e-9 <= 1e-8", "ratio": 1e-9}
    stage |= {"cycles": 100, "wall_s": 0.1, "joints": joint_summary(factor)}
    stage |= {"applied": {"x": 6e4, "y": -2e5}, "reaction": {"x": -6e4, "y": 2e5}}
    stage["probes"] = {"top": {"x": 2.0, "y": 2.0, "u_x": factor * 4e-4, "u_y": -2e-4}}
    stage["stress_by_group"] = {
        "dam": {"s1_max": high, "s2_min": low},
        "rock": {"s1_max": None, "s2_min": None},
    }
    return stage


def history_row(cycle):
    stage = "weight" if cycle < 600 else "a-flood"
    return f"{cycle},{stage},1,{10 ** (-cycle / 100):g},1,.1,1,.1,1e-3,{cycle * 1e-6:g},-1e-3"


@pytest.fixture
def folder(tmp_path):
    vertices, blocks, group = hand_mesh()
    with h5py.File(tmp_path / "results.h5", "w", userblock_size=HEADER) as file:
        file.attrs.update({"format": b"quoin-results", "version": 2, "run": np.uint64(7), "title": b"by hand", "scene": b"s.yaml",
                           "model": b"m.h5", "thickness": 1.0})  # fmt: skip
        file["mesh/vertices"], file["mesh/blocks"] = vertices, blocks
        file["mesh/block_group"] = file["mesh/macroblock"] = group
        file["mesh/group_names"], file["mesh/group_rigid"] = np.array([b"dam", b"rock"]), [0, 0]
        file["mesh/joint_names"] = np.array([b"default", b"base", b"net"])
        for index, name in enumerate(("weight", "a-flood")):  # in this order, not by the alphabet
            write_stage(file.create_group(f"stages/{name}"), index, 1.0 + index, vertices, blocks)
    seal_results(tmp_path / "results.h5")
    stages = [stage_summary("weight", 1.0), stage_summary("a-flood", 2.0)]
    sizes = {f"n_{name}": 7 for name in ("blocks", "vertices", "macroblocks", "contacts", "dofs")}
    names = "cycle,stage,ramp,ratio,kinetic_J,alpha_per_s,dt_s,alpha_dt,u_max_m,top_ux_m,top_uy_m"
    rows = [history_row(cycle) for cycle in range(100, 1100, 100)]
    (tmp_path / "history.csv").write_text("\n".join([names, *rows, "1100,a-flo"]))
    known = {"history": history_member("\n".join([names, *rows]).encode()), "run": f"{7:016x}"}
    write_summary(tmp_path, {"title": "by hand", "ranks": 2, "stages": stages} | known | sizes)
    return tmp_path


def test_fields(folder):
    run = Results(folder)
    assert run.stages == ["weight", "a-flood"] and run.title == "by hand" and run.thickness == 1.0
    assert run.mesh.group_names == ["dam", "rock"] and run.mesh.joint_names == ["default", "base", "net"]
    stage = run.stage()
    assert (stage.name, stage.verdict, stage.cycles, stage.evidence) == (
        "a-flood",
        "converged",
        100,
        'ratio "small"',
    )
    assert stage.displacement.shape == (len(run.mesh.vertices), 2) and len(stage.contacts) == N
    assert stage.contacts.klass.tolist() == [0] * N
    with pytest.raises(AttributeError):
        _ = stage.no_such_field
    assert run.history["cycle"].tolist() == list(
        range(100, 1100, 100)
    )  # the row cut off at the end is left out
    assert run.history["stage"][0] == "weight" and run.history["top_ux_m"][-1] == pytest.approx(1e-3)


def test_mesh_geometry(folder):
    mesh = Results(folder).mesh
    assert mesh.areas().sum() == pytest.approx(4.0 + 50.0)
    assert mesh.areas()[-2:] == pytest.approx([0.125, 0.125])
    assert mesh.centres()[-2] == pytest.approx([1 / 3, 1 / 6])
    assert len(mesh.outline()) == 4 * N + 8  # faces between blocks of one body are not in it
    length = np.linalg.norm(np.diff(mesh.vertices[mesh.outline()], axis=1), axis=2).sum()
    assert length == pytest.approx(8.0 + 30.0)


def test_joint_profile_runs_along_the_joint(folder):
    run = Results(folder)
    distance, sigma, tau = run.joint_profile("a-flood", "base")
    assert distance.ravel() == pytest.approx([0, 0.5, 0.5, 1, 1, 1.5, 1.5, 2])
    assert sigma == pytest.approx(2 * sigma_at(distance)) and np.all(tau == 3e4)
    with pytest.raises(ResultsError, match="stage 'weight': joint 'net' is no line, so it has no distance along it"):
        run.joint_profile("weight", "net")
    with pytest.raises(ResultsError, match="stage 'weight': joint 'default' (has no contacts in it|is no line)"):
        run.joint_profile("weight", "default")
    with pytest.raises(ResultsError, match="contacts have no 'opened' at their ends, there are: opening, sliding"):
        run.joint_profile("weight", "base", "opened")
    with pytest.raises(ResultsError, match="no joint 'bas', there are: .*base"):
        run.joint_profile("weight", "bas")


def test_table(folder, capsys):
    assert results.main([str(folder)]) == 0
    text = capsys.readouterr().out
    for words in (
        "by hand",
        "2 ranks",
        "0.400",
        "0.800",
        "200.0",
        "400.0",
        "2.500",
        "-1.000",
        "(1.00, 0.50)",
        "ratio 1e-9",
    ):
        assert words in text, words
    lines = text.splitlines()
    header = next(i for i, line in enumerate(lines) if line.startswith("  stage") and "joint" in line)
    assert len({len(line) for line in lines[header : header + 2]}) == 1
    assert lines[header + 3].split()[:2] == ["weight", "net"] and lines[header + 3].split()[-1] == "-"


def test_pictures(folder, capsys):
    assert plots.main([str(folder)]) == 0
    names = {"mesh", "history", "stress_weight", "stress_a-flood", "joint_base_weight", "joint_base_a-flood"}
    assert {os.path.splitext(name)[0] for name in os.listdir(folder) if name.endswith(".png")} == names
    printed = capsys.readouterr().out.split()
    assert sorted(printed) == sorted(str(folder / f"{name}.png") for name in names)
    for path in printed:
        with open(path, "rb") as file:
            head = file.read(24)
        width, height = (int.from_bytes(head[i : i + 4], "big") for i in (16, 20))
        assert head[1:4] == b"PNG" and width > 500 and height > 400, path
    assert plots.main([str(folder), "--whole"]) == 0


def test_view_leaves_the_rock_out(folder):
    mesh = Results(folder).mesh
    box, groups = style.view(mesh)
    assert groups.tolist() == [0] and -1 < box[0] < 0 and 2 < box[1] < 3
    box, groups = style.view(mesh, whole=True)
    assert groups.tolist() == [0, 1] and box[0] < -4
    mesh.group_rigid[0] = 1  # a picture of a body without stress would be empty
    assert style.view(mesh)[1].tolist() == [0, 1]


def test_table_says_how_stages_were_solved(folder, capsys):
    summary = json.loads((folder / "summary.json").read_text())
    results.main([str(folder)])
    assert "How they were solved" not in capsys.readouterr().out  # a summary of before
    effort = {"method": "preconditioned, then explicit", "force_evaluations": 6021, "solves": 31, "factorisations": 2}
    summary["stages"][1] |= effort
    summary["condensed"] = {"bodies": 1, "kept_dofs": 112, "inner_dofs": 3511, "factors": 1, "factor_wall_s": 0.02}
    write_summary(folder, summary)
    results.main([str(folder)])
    text = capsys.readouterr().out
    assert "1 condensed body in small strain, 3511 inner dofs left out" in text
    row = next(line for line in text.splitlines() if "then explicit" in line)
    assert row.split() == ["a-flood", "preconditioned,", "then", "explicit", "-", "6021", "31", "2"]


def test_blocks_that_move_far_stand_where_they_are(folder):
    mesh = Results(folder).mesh
    box, _ = style.view(mesh)  # of the body: 2 m wide, round (1, 1)
    seen, size = style.inside(mesh.vertices, box), box[1] - box[0]
    moved = np.zeros_like(mesh.vertices)
    moved[seen] = 1e-3, 0.0
    assert plots.magnification(mesh, moved, box) == (100.0, box)  # of 0.06 * 2.64 m / 1e-3 m
    moved[seen] = 1.5 * size, -0.5 * size
    factor, wider = plots.magnification(mesh, moved, box)
    assert factor == 1.0 and wider[0] == box[0] and wider[3] == box[3]
    assert np.allclose(wider[1], 2.0 + 1.54 * size) and np.allclose(wider[2], -0.54 * size)
    moved[seen] = 1000 * size, 0.0
    factor, same = plots.magnification(mesh, moved, box)
    assert factor < 1e-4 and same == box


def test_history_shows_the_points_that_move_most():
    history = {f"p{i}_{x}_m": np.array([0.0, i if x == "ux" else 0.0]) for i in range(9) for x in ("ux", "uy")}
    assert plots.moving_points(history) == [f"p{i}" for i in range(3, 9)]


def test_contours_do_not_smear_across_joints(folder):
    mesh = Results(folder).mesh
    values = np.where(mesh.block_group == 0, 1.0, np.nan)
    field = stress.at_vertices(mesh, np.nan_to_num(values), mesh.block_group == 0)
    assert field[: (N + 1) ** 2] == pytest.approx(1.0) and np.all(field[(N + 1) ** 2 :] == 0)


@pytest.mark.parametrize(
    "value, expected", [(1.0, 1), (1.99, 1), (2.0, 2), (4999, 2000), (0.05, 0.05), (0.049, 0.02)]
)
def test_nice_numbers(value, expected):
    assert style.nice(value) == pytest.approx(expected)


def test_faults_are_named_in_one_line(folder, tmp_path, capsys):
    def fault(where):
        for program in (results, plots):
            assert program.main([str(where)]) == 2
            error = capsys.readouterr().err
            assert error.count("\n") == 1 and "Traceback" not in error
        return error

    empty = tmp_path / "empty"
    empty.mkdir()
    assert "no results.h5" in fault(empty)
    with h5py.File(empty / "results.h5", "w", userblock_size=HEADER) as file:
        file.attrs["format"] = b"quoin-mesh"
    seal_results(empty / "results.h5")
    assert "not a results file" in fault(empty)
    (empty / "results.h5").write_bytes((folder / "results.h5").read_bytes()[:3000])
    assert "it is damaged" in fault(empty)
    with pytest.raises(ResultsError, match="no stage 'quake', there are: weight, a-flood"):
        Results(folder).stage("quake")
    (folder / "summary.json").write_text('{"stages": [')
    assert "summary.json" in fault(folder)


# ---- what the solver writes

SCENE = r"""
title: 'quote " backslash \ and é'
model: model.h5
output: out
materials:
  lower: {density: 2400, young: 10e9, poisson: 0.2}
  upper: {density: 2400, young: 10e9, poisson: 0.2}
  base: {density: 0}
joints:
  default: {k_n: 1e10, k_s: 3e9, friction: 40, cohesion: 1e5}
  joint: {k_n: 1e10, k_s: 3e9, friction: 35, friction_residual: 30, cohesion: 1e4}
supports: {bottom: {fix: xy}}
loads:
  weight: {type: self_weight}
  push: {type: traction, faces: top, value: [2000, -20000]}
relaxation: {ramp: 300, tolerance: 1e-9, history_every: 100}
stages:
  weight: {loads: [weight]}
  push: {loads: [weight, push]}
"""


def run_quoin(folder, ranks, *options):
    """Exit code and stderr; ends with the test, whatever happens."""
    command = [QUOIN, "-options_file", "scene.yaml", *options]
    if ranks > 1:
        command = ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none", *command]
    environment = os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, env=environment)
    return done.returncode, done.stderr


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Two bodies, triangles below and quadrilaterals above, on a rigid base: on 1 and on 2 ranks."""
    folder = tmp_path_factory.mktemp("runs")
    mesh = stacks.two_bodies(3, 4, base=True)
    mesh = split_triangles(mesh, mesh.block_group == mesh.group_names.index("lower"))
    blockmesh.write(folder / "model.h5", mesh)
    (folder / "scene.yaml").write_text(SCENE, encoding="utf-8")
    for ranks in (1, 2):
        code, error = run_quoin(folder, ranks, "-output", f"out{ranks}")
        assert code == 0, error
    return folder


BESIDE = ("checkpoints", "scene_echo.yaml")  # results apart


@solver
@pytest.mark.alone  # the first to ask for the runs
def test_files_and_sizes(runs):
    assert set(os.listdir(runs / "out1")) == {"history.csv", "results.h5", "results.xdmf", "summary.json", *BESIDE}
    run, mesh = Results(runs / "out1"), blockmesh.read(runs / "model.h5")
    assert np.array_equal(run.mesh.vertices, mesh.vertices) and np.array_equal(run.mesh.blocks, mesh.blocks)
    assert np.array_equal(run.mesh.block_group, mesh.block_group) and run.mesh.group_names == mesh.group_names
    assert run.summary["title"] == run.title == 'quote " backslash \\ and é'
    assert run.summary["n_blocks"] == len(mesh.blocks) and run.summary["n_vertices"] == len(mesh.vertices)
    assert run.stages == [stage["name"] for stage in run.summary["stages"]] == ["weight", "push"]
    assert len(run.history["cycle"]) > 10 and set(run.history["stage"]) == {"weight", "push"}


@solver
def test_same_numbers_on_any_number_of_ranks(runs):
    def compare(name, item):
        if isinstance(item, h5py.Dataset) and name != "mesh/rank":
            assert item[()].tobytes() == other[name][()].tobytes(), name

    with h5py.File(runs / "out1/results.h5") as one, h5py.File(runs / "out2/results.h5") as other:
        one.visititems(compare)
        assert one["mesh/rank"][()].tolist() == [0] * len(other["mesh/rank"]) and set(other["mesh/rank"][()]) == {0, 1}
    assert (runs / "out1/history.csv").read_bytes() == (runs / "out2/history.csv").read_bytes()
    one, two = (Results(runs / name).summary for name in ("out1", "out2"))
    assert (one.pop("ranks"), two.pop("ranks")) == (1, 2) and one.pop("crc32") != two.pop("crc32")
    for stage in one["stages"] + two["stages"]:
        stage.pop("wall_s")
    assert one == two


@solver
def test_summary_holds_equilibrium(runs):
    run = Results(runs / "out1")
    weight = {"weight": 2 * 2400 * 9.81, "push": 2 * 2400 * 9.81 + 20000.0}
    for stage in run.summary["stages"]:
        push = 2000.0 * (stage["name"] == "push")
        assert stage["applied"]["y"] == pytest.approx(-weight[stage["name"]], rel=1e-9)
        assert stage["reaction"]["y"] == pytest.approx(weight[stage["name"]], rel=1e-6)
        assert stage["reaction"]["x"] == pytest.approx(-push, abs=0.1)
        upper = weight[stage["name"]] - 2400 * 9.81
        joint = stage["joints"]["joint"]
        assert joint["line"] and joint["length"] == pytest.approx(1.0)
        assert joint["N"] == pytest.approx(upper, rel=1e-4) and joint["T"] == pytest.approx(push, abs=0.5)
        assert joint["M"] == pytest.approx(
            -push * 1.0, abs=5.0
        )  # the push acts 1 m above: it presses on the end
        assert joint["sigma_linear_end"] - joint["sigma_linear_start"] == pytest.approx(
            12 * joint["M"], rel=1e-9
        )
        assert (joint["start"]["x"], joint["end"]["x"]) == (0.0, 1.0)
        if push:
            peak = joint["N"] * np.tan(np.radians(35)) + 1e4
            assert joint["sliding_factor_peak"] == pytest.approx(peak / joint["T"], rel=1e-12)
            residual = joint["N"] * np.tan(np.radians(30))
            assert joint["sliding_factor_residual"] == pytest.approx(residual / joint["T"], rel=1e-12)


@solver
def test_summary_agrees_with_the_fields(runs):
    run = Results(runs / "out1")
    for facts in run.summary["stages"]:
        stage = run.stage(facts["name"])
        top = run.mesh.vertices[:, 1].argmax()
        assert facts["max_displacement"]["value"] == pytest.approx(
            np.linalg.norm(stage.displacement, axis=1).max()
        )
        assert facts["stress"]["s2_min"]["value"] == np.nanmin(stage.s2)
        assert facts["stress"]["s2_min"]["block"] == np.nanargmin(stage.s2)
        assert (
            facts["stress_by_group"]["base"]["s1_max"] is None and np.isfinite(stage.displacement[top]).all()
        )
        for name, probe in facts["probes"].items():
            vertex = blockmesh.read(runs / "model.h5").points[name]
            assert [probe["u_x"], probe["u_y"]] == stage.displacement[vertex].tolist()
            assert [probe["x"], probe["y"]] == run.mesh.vertices[vertex].tolist()
        contacts = stage.contacts
        mine = contacts.joint == run.mesh.joint_names.index("joint")
        assert -contacts.force[mine, :, 0].sum() == pytest.approx(facts["joints"]["joint"]["N"], rel=1e-4)
        assert facts["joints"]["joint"]["n_contacts"] == mine.sum() == 6
        assert facts["joints"]["joint"]["sigma_min"]["sigma"] == contacts.sigma[mine].min()


@solver
def test_block_fields(runs):
    run = Results(runs / "out1")
    stage, mesh = run.stage(), run.mesh
    rigid = mesh.block_group == mesh.group_names.index("base")
    triangle = mesh.blocks[:, 3] < 0
    assert np.array_equal(np.isnan(stage.s1), rigid) and np.array_equal(np.isfinite(stage.rotation), rigid)
    assert (
        np.isnan(stage.gauss_stress[triangle, 1:]).all()
        and np.isfinite(stage.gauss_stress[triangle, 0]).all()
    )
    assert np.isfinite(stage.gauss_stress[~triangle & ~rigid]).all()
    assert stage.gauss_stress[triangle, 0] == pytest.approx(stage.stress[triangle])
    sxx, syy, sxy = stage.stress[~rigid].T
    assert stage.s1[~rigid] + stage.s2[~rigid] == pytest.approx(sxx + syy)
    c, s = np.cos(stage.angle[~rigid]), np.sin(stage.angle[~rigid])
    assert c * c * sxx + s * s * syy + 2 * c * s * sxy == pytest.approx(stage.s1[~rigid], rel=1e-9, abs=1e-6)


@solver
def test_vtk_reads_the_same_numbers(runs):
    xdmf = pytest.importorskip("vtkmodules.vtkIOXdmf2")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    run = Results(runs / "out1")
    reader = xdmf.vtkXdmfReader()
    reader.SetFileName(str(runs / "out1/results.xdmf"))
    reader.UpdateInformation()
    for time, name in enumerate(run.stages, 1):
        stage = run.stage(name)
        reader.UpdateTimeStep(float(time))
        grids = leaves(reader.GetOutputDataObject(0))
        assert len(grids) == 2
        blocks, contacts = grids
        assert blocks.GetNumberOfCells() == len(run.mesh.blocks)
        kinds = [blocks.GetCellType(i) for i in range(blocks.GetNumberOfCells())]
        assert kinds == [5 if row[3] < 0 else 9 for row in run.mesh.blocks]  # VTK_TRIANGLE, VTK_QUAD
        for i, row in enumerate(run.mesh.blocks):
            cell = blocks.GetCell(i)
            assert [cell.GetPointId(k) for k in range(cell.GetNumberOfPoints())] == row[row >= 0].tolist()

        def field(data, name):
            return vtk_to_numpy(data.GetArray(name))

        assert np.array_equal(vtk_to_numpy(blocks.GetPoints().GetData())[:, :2], run.mesh.vertices)
        assert np.array_equal(field(blocks.GetPointData(), "displacement")[:, :2], stage.displacement)
        assert np.array_equal(field(blocks.GetCellData(), "stress_xx_yy_xy"), stage.stress, equal_nan=True)
        tensor = field(blocks.GetCellData(), "stress").reshape(-1, 3, 3)
        assert np.array_equal(tensor[:, [0, 1, 0, 1], [0, 1, 1, 0]], stage.stress[:, [0, 1, 2, 2]], equal_nan=True)
        assert not np.nan_to_num(tensor[:, 2]).any() and not np.nan_to_num(tensor[:, :, 2]).any() and np.isfinite(stage.stress).any()
        assert np.array_equal(field(blocks.GetCellData(), "s1"), stage.s1, equal_nan=True)
        assert np.array_equal(field(blocks.GetCellData(), "group"), run.mesh.block_group)
        assert contacts.GetNumberOfCells() == len(stage.contacts)
        assert np.array_equal(
            vtk_to_numpy(contacts.GetPoints().GetData())[:, :2], stage.contacts.point.reshape(-1, 2)
        )
        for quantity in ("sigma", "tau", "opening", "state"):
            assert np.array_equal(
                field(contacts.GetPointData(), quantity), getattr(stage.contacts, quantity).ravel()
            )
        assert np.array_equal(field(contacts.GetCellData(), "joint"), stage.contacts.joint)


@solver
def test_paraview_gets_the_names(runs, tmp_path):
    """What the state file reads of results.xdmf; the copy that is written knows where the run is."""
    run = Results(runs / "out1")
    names, steps = paraview_state.meanings(runs / "out1/results.xdmf")
    assert list(names["group"].values()) == run.mesh.group_names and list(names["joint"].values()) == run.mesh.joint_names
    assert {names["state"][bit] for bit in (OPEN, SLIPPING, CRUSHING)} == {"open", "slipping", "crushing"}
    assert [name for _, name in steps] == run.stages and [time for time, _ in steps] == list(range(1, len(steps) + 1))
    assert [paraview_state.scale_of(largest, 100.0) for largest in (0.0, 1e-3, 0.013, 50.0)] == [1.0, 5000.0, 200.0, 1.0]
    (path,) = export.paraview(run, tmp_path)
    script = runpy.run_path(path)  # in another folder than the run
    assert script["folder"]() == str(runs / "out1")


def leaves(composite):
    iterator = composite.NewIterator()
    iterator.InitTraversal()
    found = []
    while not iterator.IsDoneWithTraversal():
        found.append(iterator.GetCurrentDataObject())
        iterator.GoToNextItem()
    return found


@solver
def test_pictures_of_a_run(runs):
    assert plots.main([str(runs / "out2")]) == 0
    assert {"mesh.png", "history.png", "stress_push.png", "joint_joint_push.png"} <= set(
        os.listdir(runs / "out2")
    )


@solver
def test_old_results_stay_until_a_stage_is_complete(runs, tmp_path):
    for name in ("model.h5", "scene.yaml"):
        (tmp_path / name).write_bytes((runs / name).read_bytes())
    (tmp_path / "out").mkdir()
    old = dict.fromkeys(("results.h5", "results.xdmf", "summary.json", "history.csv"), b"of an older run")
    for name, content in old.items():
        (tmp_path / "out" / name).write_bytes(content)
    code, error = run_quoin(tmp_path, 1, "-joints.joint.k_n", "-5")
    assert code == 2 and error.count("\n") == 1
    assert {name: (tmp_path / "out" / name).read_bytes() for name in os.listdir(tmp_path / "out")} == old
    assert run_quoin(tmp_path, 1)[0] == 0
    assert set(os.listdir(tmp_path / "out")) == {*old, *BESIDE}
    assert Results(tmp_path / "out").stages == ["weight", "push"]


@solver
@pytest.mark.parametrize("ranks", [1, 2])
def test_a_folder_that_cannot_be_made(runs, ranks):
    code, error = run_quoin(runs, ranks, "-output", "model.h5/out")
    lines = [line for line in error.splitlines() if "model.h5/out" in line]
    assert code == 8 and len(lines) == 1 and "cannot make the folder" in lines[0] and "Not a directory" in lines[0]


@solver
def test_full_blocks_that_lock_are_told(runs):
    """Nothing is computed: there is no folder for results."""
    def told(*options):
        error = run_quoin(runs, 1, "-output", "/dev/null/out", *options)[1]
        return [line for line in error.splitlines() if "much too stiff" in line]

    assert told("-materials_upper_poisson", "0.44") == []
    both = told("-materials_upper_poisson", "0.46", "-materials_lower_poisson", "0.49")
    assert len(both) == 2 and "materials.lower: at Poisson's ratio 0.49" in both[0] and "upper" in both[1]
    assert told("-materials_upper_poisson", "0.46", "-materials_upper_element", "bending") == []
    assert told("-materials_upper_poisson", "0.46", "-materials_upper_rigid", "true") == []
    assert told("-materials_upper_poisson", "0.46", "-plane", "stress") == []


@solver
def test_strength_of_elastic_joints_is_told(runs):
    """A row takes its law from the default row: friction beside an elastic law limits nothing."""
    def told(*options):
        return [line for line in run_quoin(runs, 1, "-output", "/dev/null/out", *options)[1].splitlines() if "limits nothing" in line]

    elastic = ("-joints_default_law", "elastic", "-joints_joint_law", "elastic")
    assert told() == [] and told(*elastic, "-joints_joint_friction", "0", "-joints_joint_cohesion", "0") == []
    line, = told(*elastic, "-joints_joint_friction", "45")
    assert "joints.joint: its law is elastic in every stage, so friction 45 limits nothing" in line
    assert told(*elastic, "-joints_joint_friction", "45", "-stages_push_joints_joint_law", "mohr_coulomb") == []


@solver
def test_numbers_in_another_unit_are_doubted(runs):
    """Each kind of number that is likely to be in another unit has one line; usual numbers have none."""
    def told(*options):
        return [line for line in run_quoin(runs, 1, "-output", "/dev/null/out", *options)[1].splitlines() if "is not within" in line]

    assert told() == []
    for option, value, words in (
        ("joints_joint_k_n", "20", "joints.joint.k_n: 20 Pa/m is not within 1e+07 to 1e+14: it closes by 5e+04 m under 1 MPa"),
        ("joints_default_friction", "0.7", "joints.default.friction: 0.7 degree is not within 2 to 80: it is an angle, not its tangent"),
        ("joints_joint_cohesion", "0.2", "joints.joint.cohesion: 0.2 Pa"),
        ("materials_upper_density", "23.5", "materials.upper.density: 23.5 kg/m3 is not within 100 to 20000: 24 kN/m3 would be 2400 kg/m3"),
        ("materials_upper_young", "12000", "materials.upper.young: 12000 Pa"),
        ("materials_upper_tension", "2", "materials.upper.tension: 2 Pa"),
        ("stages_push_joints_joint_cohesion", "0.2", "stages.push.joints.joint.cohesion: 0.2 Pa"),
    ):
        line, = told("-" + option, value)
        assert words in line


@solver
def test_loads_that_no_stage_lists_are_told(runs):
    def told(*options):
        return [line for line in run_quoin(runs, 1, "-output", "/dev/null/out", *options)[1].splitlines() if "no stage lists" in line]

    assert told() == []
    assert told("-stages", "weight") == ["quoin: warning: no stage lists: push"]


@solver
def test_stages_that_newtons_method_leaves_out_are_told(runs):
    def told(*options):
        return [line for line in run_quoin(runs, 1, "-output", "/dev/null/out", *options)[1].splitlines() if "fixed connectivity" in line]

    newton = ("-relaxation_method", "preconditioned")
    assert told(*newton) == told("-contact_connectivity", "variable") == []
    assert [line.split(": ")[-1] for line in told(*newton, "-contact_connectivity", "variable")] == ["weight, push"]
    assert [line.split(": ")[-1] for line in told(*newton, "-stages_push_variable", "true")] == ["push"]


@solver
@pytest.mark.skipif(not os.path.isdir("/sys/kernel"), reason="no file system that refuses folders to all")
def test_the_reason_why_a_folder_cannot_be_made(runs):
    """Not that of looking for it afterwards, which was `No such file or directory`."""
    code, error = run_quoin(runs, 1, "-output", "/sys/quoin/out")
    with pytest.raises(OSError) as refused:
        os.mkdir("/sys/quoin")
    assert code == 8 and f"cannot make the folder '/sys/quoin/out': {refused.value.strerror}" in error
