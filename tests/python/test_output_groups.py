"""Groups with `output: false`: their blocks, and contacts between them, are not in results.h5; all else is as with them."""

import csv
import json
import os
import shutil
import subprocess
import sys

import h5py
import numpy as np
import pytest

ROOT = os.path.join(os.path.dirname(__file__), "..", "..")
sys.path.insert(0, os.path.join(ROOT, "tools"))

from quoin_tools.base import results  # noqa: E402
from quoin_tools.base.results import CONTACT_FIELDS, SOME_STAGES, STAGE_FIELDS, VERTEX_FACE, Results  # noqa: E402
from quoin_tools.mesh import blockmesh  # noqa: E402
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed, split_triangles  # noqa: E402
from quoin_tools.show import export, plots  # noqa: E402

QUOIN = os.environ.get("QUOIN", os.path.join(ROOT, "build", "quoin"))
pytestmark = pytest.mark.skipif(not os.path.exists(QUOIN), reason="the solver is not built")

SCENE = """
model: model.h5
contact: {connectivity: variable, tolerance: 0.002}
relaxation: {history_every: 20, max_cycles: 20000, allow_floating: true}
materials:
  ground: {density: 2400, rigid: true}
  low: {density: 2400, young: 1e8, poisson: 0.2}
  high: {density: 2400, young: 1e8, poisson: 0.2, tension: 1e5, compression: 1e6, cohesion: 1e5, friction: 30}
  fallen: {density: 2400, young: 1e8, poisson: 0.2, velocity: [0.1, 0], spin: 0.2}
joints:
  default: {stress_model: tptm, k_n: 1e9, k_s: 1e9, friction: 30}
supports: {ground: {fix: xy}}
loads:
  weight: {type: self_weight, groups: [low, high]}
  all: {type: self_weight, groups: [low, high, fallen]}
stages:
  - rest: {loads: [weight]}
  - fall: {type: dynamic, loads: [all], duration: 0.04, frames: 3}
"""
LEFT_OUT = ("-materials_ground_output", "no", "-materials_low_output", "no")


def model():
    """Ground of four rigid blocks; a column on it, one body of the groups low and high with vertices of both; a block on a corner."""
    ground = split_triangles(rectangle(-3.0, -1.0, 6.0, 1.0, nx=4, group="ground", rigid=True), [True, False, False, True])
    column = rectangle(0.5, 0.0, 1.0, 2.0, nx=2, ny=4, group="low")
    column.group_names, column.group_rigid = ["low", "high"], [0, 0]
    column.block_group[4:] = 1
    along, up = np.array([np.cos(0.5), np.sin(0.5)]), np.array([-np.sin(0.5), np.cos(0.5)])
    corner = np.array([-1.0, 1e-3])
    fallen = quad_patch(corner, corner + along, corner + along + up, corner + up, 2, 2, "fallen")
    parts = [(ground, {}), (column, {"crest": "top_left", "foot": "bottom_left"}), (fallen, {"corner": "bottom_left"})]
    return join([renamed(part, {}, points) for part, points in parts])


def run_quoin(folder, out, ranks, *options):
    command = [*(["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"] if ranks > 1 else []), QUOIN]
    environment = os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    return subprocess.run([*command, "-options_file", "scene.yaml", "-output", out, *options], cwd=folder,
                          capture_output=True, text=True, timeout=120, env=environment)  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("output_groups")
    blockmesh.write(folder / "model.h5", model())
    (folder / "scene.yaml").write_text(SCENE, encoding="utf-8")
    for out, ranks, options in (("whole", 1, ()), ("part", 1, LEFT_OUT), ("part2", 2, LEFT_OUT)):
        done = run_quoin(folder, out, ranks, *options)
        assert done.returncode == 0, done.stderr
    return folder


def rows_of(mine, whole):
    """Rows of the whole model's contacts that are written, and what their `face` then is."""
    block_row = np.full(len(whole.mesh.blocks), -2)
    block_row[mine.mesh.block_file] = np.arange(len(mine.mesh.blocks))
    vertex_row = np.full(len(whole.mesh.vertices), -2)
    vertex_row[mine.mesh.vertex_file] = np.arange(len(mine.mesh.vertices))

    def of(face):
        face = face.copy()
        for block, place in ((0, 1), (2, 3)):
            vertex = face[:, block] == -1
            face[vertex, place] = vertex_row[face[vertex, place]]
            face[vertex & (face[:, place] == -2), block] = -2
            face[~vertex, block] = block_row[face[~vertex, block]]
            face[~vertex & (face[:, block] == -2), place] = -2
        return face[(face[:, 0] != -2) | (face[:, 2] != -2)], (face[:, 0] != -2) | (face[:, 2] != -2)

    return of


@pytest.mark.alone  # the first to ask for the runs
@pytest.mark.parametrize("out", ["part", "part2"])
def test_what_is_written_is_as_with_all(folder, out):
    whole, mine = Results(folder / "whole"), Results(folder / out)
    written = [i for i, group in enumerate(whole.mesh.group_names) if group in ("high", "fallen")]
    assert mine.mesh.block_file.tolist() == np.flatnonzero(np.isin(whole.mesh.block_group, written)).tolist()
    used = whole.mesh.blocks[mine.mesh.block_file]
    assert mine.mesh.vertex_file.tolist() == np.unique(used[used >= 0]).tolist()
    assert np.array_equal(np.where(mine.mesh.blocks < 0, -1, mine.mesh.vertex_file[mine.mesh.blocks]), used)
    assert whole.mesh.block_file.tolist() == list(range(len(whole.mesh.blocks)))
    for field, rows in (("vertices", "vertex_file"), ("block_group", "block_file"), ("macroblock", "block_file")):
        assert np.array_equal(getattr(mine.mesh, field), getattr(whole.mesh, field)[getattr(mine.mesh, rows)])
    assert mine.frames("fall") == whole.frames("fall") and len(mine.frames("fall")) == 3
    contacts_of, kinds = rows_of(mine, whole), set()
    for name in [*mine.stages, *mine.frames("fall")]:
        a, b = mine.stage(name), whole.stage(name)
        for field in STAGE_FIELDS + SOME_STAGES:
            rows = mine.mesh.vertex_file if field in ("displacement", "mechanism") else mine.mesh.block_file
            if getattr(b, field) is None:
                assert getattr(a, field) is None
            else:
                assert np.array_equal(getattr(a, field), getattr(b, field)[rows], equal_nan=True), (name, field)
        face, kept = contacts_of(b.contacts.face)
        assert np.array_equal(a.contacts.face, face) and not kept.all()
        kinds |= {(klass == VERTEX_FACE, *(face[i, [0, 2]] == -2)) for i, klass in enumerate(a.contacts.klass)}
        for field in CONTACT_FIELDS[1:]:
            field = "klass" if field == "class" else field
            assert np.array_equal(getattr(a.contacts, field), getattr(b.contacts, field)[kept], equal_nan=True), (name, field)
    assert (True, True, False) in kinds, "no vertex of a written block stood on a block that is not written"


@pytest.mark.parametrize("out", ["part", "part2"])
def test_all_else_is_of_the_whole_model(folder, out):
    def plain(item):  # what ranks and clocks change, and energies of the dynamic stage, which agree to rounding
        if isinstance(item, dict):
            return {k: plain(v) for k, v in item.items() if k not in ("wall_s", "ranks", "wall", "run", "crc32", "history") and not (k == "energy" and "balance" in v)}
        return [plain(v) for v in item] if isinstance(item, list) else item

    summaries = [json.loads((folder / name / "summary.json").read_text(encoding="utf-8")) for name in ("whole", out)]
    assert plain(summaries[0]) == plain(summaries[1])
    assert summaries[1]["stages"][1]["stress_by_group"]["low"]["s2_min"]["value"] < 0
    histories = []
    for name in ("whole", out):
        with open(folder / name / "history.csv", encoding="utf-8") as file:
            histories.append([[v for k, v in row.items() if not k.endswith("_J")] for row in csv.DictReader(file)])
    assert histories[0] == histories[1] and len(histories[0]) > 5
    with h5py.File(sorted((folder / "whole/checkpoints").iterdir())[-1]) as a, h5py.File(sorted((folder / out / "checkpoints").iterdir())[-1]) as b:
        for name in ("u", "v", "f", "contacts", "contacts_key"):
            assert np.array_equal(a["state"][name], b["state"][name])


def test_bytes(folder):
    """A frame shrinks by the blocks, vertices and contacts that are not in it."""
    def size(name):
        total = 0

        def add(_, item):
            nonlocal total
            total += item.nbytes if isinstance(item, h5py.Dataset) else 0

        with h5py.File(folder / name / "results.h5") as file:
            file["stages/fall_1"].visititems(add)
        return total

    whole, mine = Results(folder / "whole"), Results(folder / "part")
    vertex, block, contact = 16, 24 + 4 * 8 + 96, 4 * 4 + 2 * 4 + 2 * 4 + 2 * 8 + 4 * 32 + 6 * 16 + 8
    gone = [len(getattr(whole.mesh, rows)) - len(getattr(mine.mesh, rows)) for rows in ("vertices", "blocks")]
    gone.append(len(whole.stage("fall_1").contacts) - len(mine.stage("fall_1").contacts))
    assert size("whole") - size("part") == np.dot(gone, [vertex, block, contact]) and min(gone) > 0


def test_tools_read_it(folder, capsys):
    assert plots.main([str(folder / "part")]) in (None, 0) and (folder / "part/mesh.png").exists()
    assert results.main([str(folder / "part")]) == 0 and "fallen" in capsys.readouterr().out
    export.main([str(folder / "part"), "--stage", "fall", "--to", str(folder / "csv")])
    with open(folder / "csv/fall_blocks.csv", encoding="utf-8") as file:
        blocks = [int(row["block"]) for row in csv.DictReader(file)]
    assert blocks == Results(folder / "part").mesh.block_file.tolist()
    corner = model().points["corner"]
    with open(folder / "csv/fall_contacts.csv", encoding="utf-8") as file:
        assert any(row["block b"] == "-1" and int(row["face b"]) == corner or row["block a"] == "-1" and int(row["face a"]) == corner
                   for row in csv.DictReader(file))


def test_vtk_reads_it(folder):
    xdmf = pytest.importorskip("vtkmodules.vtkIOXdmf2")
    mine, reader = Results(folder / "part"), xdmf.vtkXdmfReader()
    reader.SetFileName(str(folder / "part/results.xdmf"))
    reader.UpdateInformation()
    reader.UpdateTimeStep(1.0)
    iterator = reader.GetOutputDataObject(0).NewIterator()
    iterator.InitTraversal()
    blocks = iterator.GetCurrentDataObject()
    assert (blocks.GetNumberOfCells(), blocks.GetNumberOfPoints()) == (len(mine.mesh.blocks), len(mine.mesh.vertices))


def test_restart_with_other_groups_is_refused(folder):
    done = run_quoin(folder, "again", 1, "-restart", str(folder / "part/checkpoints"))
    assert done.returncode == 10 and done.stdout.count("materials_low_output: no -> not given") == 1
    assert "its results leave out other groups (materials.<name>.output) than the scene" in done.stderr
    done = run_quoin(folder, "again", 1, "-restart", str(folder / "part/checkpoints"), *LEFT_OUT)
    assert done.returncode == 0, done.stderr


def test_restart_into_results_of_another_run_is_refused(folder):
    """Its stages have the same names, its friction is another: results.h5 is refused and stays as it is. The same run again,
    with other options that change no result, is not another."""
    for out, *options in (("own",), ("own_again", "-checkpoint_keep", "9", "-title", "again"), ("others", "-joints_default_friction", "20")):
        assert run_quoin(folder, out, 1, *options).returncode == 0
    before = (folder / "others/results.h5").read_bytes()
    done = run_quoin(folder, "others", 1, "-restart", str(folder / "own/checkpoints"))
    assert done.returncode == 10
    lines = [line for line in done.stderr.splitlines() if line.startswith("quoin: ")]
    assert lines == ["quoin: error: restart: 'others/results.h5' is of another run than the checkpoint: give another folder as output"]
    assert (folder / "others/results.h5").read_bytes() == before
    for out in ("own", "own_again"):
        done = run_quoin(folder, out, 1, "-restart", str(folder / "own/checkpoints"))
        assert done.returncode == 0 and "goes on from" in done.stdout and "starts again" not in done.stderr, done.stderr
    with h5py.File(folder / "own/results.h5") as own, h5py.File(folder / "others/results.h5") as others:
        assert own.attrs["run"] != others.attrs["run"]


def test_branches_of_a_checkpoint_are_runs_of_their_own(folder):
    """With other options each is a run of its own: results.h5 of one is refused to the other and to the run they come from; the
    same branch once more is the same, and may take over the folder it starts from."""
    def branch(start, out, friction, code=0):
        done = run_quoin(folder, out, 1, "-restart", str(folder / start), "-joints_default_friction", str(friction), *keep)
        assert done.returncode == code, done.stderr
        assert ("is of another run than the checkpoint" in done.stderr) == (code == 10)
        with h5py.File(folder / out / "results.h5") as file:
            return file.attrs["run"]

    keep = ("-checkpoint_keep", "99")
    assert run_quoin(folder, "stem", 1, *keep).returncode == 0
    shutil.copytree(folder / "stem", folder / "taken_over")
    rest = "stem/checkpoints/checkpoint_000001.h5"  # at its end
    stem, low, high = branch(rest, "stem", 30), branch(rest, "low", 20), branch(rest, "high", 25)
    assert len({stem, low, high}) == 3
    before = (folder / "low/results.h5").read_bytes()
    branch("high/checkpoints", "low", 25, 10)
    branch(rest, "low", 25, 10)
    branch(rest, "low", 30, 10)
    assert (folder / "low/results.h5").read_bytes() == before
    assert branch(rest, "low", 20) == low and branch("low/checkpoints", "low", 20) == low
    assert branch(rest, "taken_over", 20) == low  # its first stage is that of the stem
    with h5py.File(folder / "taken_over/results.h5") as file:
        assert {"rest", "fall"} <= set(file["stages"])
    branch(rest, "taken_over", 30, 10)


def test_an_interrupted_run_names_its_checkpoint(folder):
    done = run_quoin(folder, "n" * 200, 1, "-checkpoint_wall_limit", "1e-6")
    evidence = json.loads((folder / ("n" * 200) / "summary.json").read_text(encoding="utf-8"))["stages"][-1]["evidence"]
    assert done.returncode == 5 and evidence in done.stdout
    done = run_quoin(folder, "resumed", 1, "-restart", evidence.split("-restart ")[1])
    assert done.returncode == 0 and "goes on from" in done.stdout, done.stderr
