"""What fuzzing has found in the tools' readers: files with any content end in the reader's own error, in one line, in no time."""

import sys

import pytest

h5py = pytest.importorskip("h5py")
np = pytest.importorskip("numpy")
sys.path.insert(0, __file__.rpartition("/")[0])
from quoin_tools.base import integrity, results, scene  # noqa: E402
from quoin_tools.mesh import blockmesh  # noqa: E402
from sealed import seal_results, write_summary  # noqa: E402

BOMB = "a0: &a0 [x, x]\n" + "".join(f"a{i}: &a{i} [*a{i - 1}, *a{i - 1}]\n" for i in range(1, 40))
MERGES = "a0: &a0 {k: 1}\n" + "".join(f"a{i}: &a{i} {{<<: [*a{i - 1}, *a{i - 1}]}}\n" for i in range(1, 40))


def line(error):
    assert "\n" not in str(error.value) and len(str(error.value)) > 20
    return str(error.value)


@pytest.mark.parametrize("text", [BOMB, MERGES, "a: &a [*a]\n", "title: 2001-99-99\n", "[" * 5000, "thickness: [1]\n", "a: " + "9" * 5000 + "\n"],
                         ids=["aliases", "merges", "circle", "date", "deep", "thickness", "long number"])  # fmt: skip
def test_scene(tmp_path, text):
    (tmp_path / "scene.yaml").write_text(text)
    with pytest.raises(scene.SceneError) as error:
        scene.read(tmp_path / "scene.yaml")
    assert line(error).startswith(f"{tmp_path}/scene.yaml: ")


@pytest.mark.parametrize("data", [b"stage,x\na,b\n", b"stage,x\na,\xff\n", b'stage,x\n"' + b"a" * 200000 + b'",1\n'], ids=["word", "latin1", "long"])
def test_history(tmp_path, data):
    (tmp_path / "history.csv").write_bytes(data)
    with pytest.raises(results.ResultsError) as error:
        results.read_history(tmp_path / "history.csv")
    line(error)


def test_summary_of_another_version_or_program(tmp_path):
    for summary in ({"version": 3}, {"format": "other"}, {"version": None}):
        write_summary(tmp_path, summary)
        with pytest.raises(results.ResultsError, match="this program reads 2"):
            integrity.read_summary(tmp_path / "summary.json")


def results_file(path, **others):
    arrays = {"vertices": np.zeros((3, 2)), "blocks": np.array([[0, 1, 2, -1]], "i4"), "block_group": np.zeros(1, "i4"),
              "macroblock": np.zeros(1, "i4"), "group_rigid": np.zeros(1, "i4"),
              "group_names": np.array([b"a"], "S64"), "joint_names": np.array([b"b"], "S64")}  # fmt: skip
    with h5py.File(path, "w", userblock_size=integrity.HEADER) as file:
        file.attrs["format"], file.attrs["version"], file.attrs["run"], file.attrs["thickness"] = "quoin-results", 2, 1, 1.0
        for name in ("title", "scene", "model"):
            file.attrs[name] = ""
        for name, value in (arrays | others).items():
            if isinstance(value, tuple):
                file.create_dataset(f"mesh/{name}", value, "f8", chunks=True)
            elif value is not None:
                file[f"mesh/{name}"] = value
        file.create_group("stages/one").attrs["index"] = 0
    seal_results(path)


@pytest.mark.parametrize("others", [{"blocks": np.array([[0, 1, 7, -1]], "i4")}, {"vertices": (1 << 30, 2)}, {"group_names": None}, {"macroblock": np.zeros(2, "i4")}],
                         ids=["vertex", "declared", "missing", "shape"])  # fmt: skip
def test_results(tmp_path, others):
    results_file(tmp_path / "results.h5")
    stage = results.Results(tmp_path).stages
    assert stage == ["one"]
    results_file(tmp_path / "results.h5", **others)
    with pytest.raises(results.ResultsError, match="not a complete results file") as error:
        results.Results(tmp_path)
    line(error)


def test_stage_without_its_fields(tmp_path):
    results_file(tmp_path / "results.h5")
    with pytest.raises(results.ResultsError, match="not a complete results file"):
        results.Results(tmp_path).stage("one")


def test_mesh_that_is_declared_only(tmp_path):
    with h5py.File(tmp_path / "model.h5", "w") as file:
        file.attrs["format"], file.attrs["version"] = np.bytes_("quoin-mesh"), np.int32(1)
        file.create_dataset("vertices", (1 << 34, 2), "f8", chunks=(16, 2))[0] = 1.0
    with pytest.raises(blockmesh.MeshError, match="its data are not in the file"):
        blockmesh.read(tmp_path / "model.h5")
