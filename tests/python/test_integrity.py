"""Output folders whose files were changed by one bit, cut off, or are of something else: every reader says so in one line."""

import os
import random
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests/reliability")]

import yaml  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.show.plot_mesh import plot  # noqa: E402
from quoin_tools.show.verify import signed  # noqa: E402
from scenes import static  # noqa: E402

QUOIN = os.environ.get("QUOIN", str(ROOT / "build/quoin"))
MADE = ("mesh.png", "report.html")  # by tools
FILES = ("results.h5", "results.xdmf", "summary.json", "history.csv", "joint_history.csv", *MADE)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    mesh, scene = static(4)
    scene["stages"].append({"shake": {"type": "dynamic", "loads": ["weight", "water"], "duration": 0.02}})
    write(str(folder / "model.h5"), mesh)
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    subprocess.run([QUOIN, "-options_file", "scene.yaml"], cwd=folder, check=True, capture_output=True)
    plot(mesh, str(folder / "out/mesh.png"))
    (folder / "out/report.html").write_text(signed("<p>a sheet</p>\n" * 20), encoding="utf-8")
    return folder / "out"


def tool(name, *arguments, pipe=""):
    """Exit code, stdout and stderr of a tool in a process of its own."""
    words = f"{sys.executable} -m quoin_tools {name} {' '.join(map(str, arguments))} {pipe}"
    done = subprocess.run(["bash", "-c", f"set -o pipefail; {words}"], capture_output=True, text=True, env=os.environ | {"PYTHONPATH": str(ROOT / "tools")})
    return done.returncode, done.stdout, done.stderr


def test_whole(run):
    from quoin_tools.base.integrity import check_folder
    assert len(check_folder(run)) == len(FILES) + 1  # the newest checkpoint is looked at, too


@pytest.mark.parametrize("name", FILES)
def test_every_flip_is_found(run, tmp_path, name):
    from quoin_tools.base.integrity import ResultsError, check_folder
    rng = random.Random(name)  # noqa: S311
    copy = tmp_path / "copy"
    shutil.copytree(run, copy)
    good = (copy / name).read_bytes()
    for i in range(60):
        data = bytearray(good)
        at = rng.randrange(min(520, len(data)) if i < 20 else len(data))
        data[at] ^= 1 << rng.randrange(8)
        (copy / name).write_bytes(bytes(data))
        with pytest.raises(ResultsError) as found:
            check_folder(copy)
        assert name in str(found.value) and "\n" not in str(found.value)
    for length in (0, 1, len(good) // 2, len(good) - 1):
        (copy / name).write_bytes(good[:length])
        with pytest.raises(ResultsError):
            check_folder(copy)


def test_tools_refuse_in_one_line(run, tmp_path):
    from quoin_tools.base import results
    from quoin_tools.show import compare, export, report
    copy = tmp_path / "copy"
    shutil.copytree(run, copy)
    for name in ("results.h5", "summary.json"):
        good = (copy / name).read_bytes()
        for bad in (good[:900] + b"?" + good[901:], b"something else"):
            (copy / name).write_bytes(bad)
            for module, more in ((results, ()), (compare, (run,)), (export, ("--to", tmp_path / "csv")), (report, ())):
                words = [str(copy), *map(str, more)]
                done = tool("show", *words) if name == "results.h5" and module is results else called(module, words)
                assert done[0] == 2 and done[2].count("\n") == 1 and name in done[2], (module, done)
        (copy / name).write_bytes(good)


def called(module, words):
    """The same within this process, which is faster."""
    import contextlib
    import io
    out, error = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
        code = module.main(words)
    return code, out.getvalue(), error.getvalue()


def test_a_reader_that_has_seen_enough(run):
    code, out, error = tool("show", run, pipe="| head -n 1")
    assert (code, error) == (0, "") and out.count("\n") == 1


def test_a_folder_of_two_runs(run, tmp_path):
    """results.h5 of one run and summary.json of another."""
    from quoin_tools.base.results import Results, ResultsError
    copy = tmp_path / "copy"
    shutil.copytree(run, copy)
    subprocess.run([QUOIN, "-options_file", "scene.yaml", "-materials_dam_young", "11e9", "-output", str(tmp_path / "other")],
                   cwd=run.parent, check=True, capture_output=True)
    shutil.copy(tmp_path / "other/results.h5", copy / "results.h5")
    with pytest.raises(ResultsError, match="of another run"):
        assert Results(copy).summary


def without_last(folder):
    """results.h5 as it was before its last stage."""
    import h5py
    from sealed import seal_results
    with h5py.File(folder / "results.h5", "r+") as file:
        del file["stages/shake"]
    seal_results(folder / "results.h5")


def without_stage(folder):
    from sealed import read_summary, write_summary
    summary = read_summary(folder)
    summary["stages"].pop()
    write_summary(folder, summary)


@pytest.mark.parametrize(("what", "said"), [
    (without_last, "results.h5: does not hold stage 'shake', which summary.json has"),
    (without_stage, "results.h5: holds stage 'shake', which summary.json does not have"),
    (lambda folder: (without_last(folder), without_stage(folder), drop_grids(folder)), r"not have stage .shake.,? (as|which) .*checkpoint_\d+.h5 has"),
])  # fmt: skip
def test_files_that_do_not_belong_together(run, tmp_path, what, said):
    """A stage that results.h5, summary.json or both lack, each file whole by itself: `whole` and all that shows results say so."""
    from quoin_tools.base.integrity import check_folder
    from quoin_tools.base.results import Results, ResultsError
    copy = tmp_path / "copy"
    shutil.copytree(run, copy)
    what(copy)
    for look in (check_folder, Results):
        with pytest.raises(ResultsError, match=said):
            look(copy)


def drop_grids(folder):
    """Those of the last stage in results.xdmf."""
    import zlib
    path = folder / "results.xdmf"
    text = path.read_text(encoding="utf-8")
    start = text.index('    <Grid Name="shake" GridType')
    text = text[:start] + text[text.index("\n    </Grid>\n", start) + len("\n    </Grid>\n") :]
    body = text[: text.rindex("<!-- crc32 ")]
    path.write_text(f"{body}<!-- crc32 {zlib.crc32(body.encode()):08x} -->\n", encoding="utf-8")


def test_checkpoints_of_another_run(run, tmp_path):
    from quoin_tools.base.integrity import ResultsError, check_folder
    subprocess.run([QUOIN, "-options_file", "scene.yaml", "-materials_dam_young", "11e9", "-output", str(tmp_path / "other")],
                   cwd=run.parent, check=True, capture_output=True)
    shutil.rmtree(tmp_path / "other/checkpoints")
    shutil.copytree(run / "checkpoints", tmp_path / "other/checkpoints")
    with pytest.raises(ResultsError, match="checkpoint_.*: of another run than"):
        check_folder(tmp_path / "other")


def test_a_copy_of_results_that_fails(run, tmp_path):
    """The last stage goes into a copy of results.h5. No file can be opened for it, somebody takes results.h5 away or puts an older one there: exit code 8, and a restart does not
    lose the stages before."""
    from quoin_tools.base.integrity import check_folder
    few = ["bash", "-c", f"ulimit -n 14 && exec {QUOIN} -options_file scene.yaml -output {tmp_path / 'few'}"]
    done = subprocess.run(few, cwd=run.parent, capture_output=True, text=True)
    assert done.returncode == 8 and done.stderr.count("quoin: error: output: cannot write") == 1, (done.returncode, done.stderr)
    again = [QUOIN, "-options_file", "scene.yaml", "-output", str(tmp_path / "few"), "-restart", "auto"]
    done = subprocess.run(again, cwd=run.parent, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    check_folder(tmp_path / "few")


@pytest.mark.parametrize(("put", "said"), [(None, "cannot write '.*results.h5.part': No such file"), ("sw", "results.h5' is not what this run has written"),
                                           ("other", "results.h5' is not what this run has written")])
def test_results_that_somebody_takes_away(run, tmp_path, put, said):
    """While the last stage runs results.h5 is removed, or replaced: by one of before, by one of another run. Exit code 8, and no restart by `auto` drops the stages before."""
    words = [QUOIN, "-options_file", "scene.yaml", "-stages_shake_duration", "0.4", "-output", str(tmp_path / "out")]
    (tmp_path / "put").mkdir()
    if put:
        more = ["-stages", "sw", "-output", str(tmp_path / "put")] if put == "sw" else ["-materials_dam_young", "11e9", "-output", str(tmp_path / "put")]
        subprocess.run([*words[:3], *more], cwd=run.parent, check=True, capture_output=True)
    process = subprocess.Popen(words, cwd=run.parent, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    summary = tmp_path / "out/summary.json"
    while process.poll() is None and not (summary.exists() and '"name": "hp"' in summary.read_text(encoding="utf-8")):
        pass
    (tmp_path / "out/results.h5").unlink()
    if put:
        shutil.copy(tmp_path / "put/results.h5", tmp_path / "out/results.h5")
    _, error = process.communicate()
    assert process.returncode == 8 and re.search(said, error), (process.returncode, error)
    done = subprocess.run([*words, "-restart", "auto"], cwd=run.parent, capture_output=True, text=True)
    assert done.returncode == 10 and done.stderr.count("\n") == 1, (done.returncode, done.stderr)


def held_fast(what):
    """Blocks none of whose vertices can move, with an anchor between them, or that grow warm, or with water in their joint: all that two runs differ in is not displacement. Scene, and a key with two values."""
    from quoin_tools.mesh.meshing import join, rectangle, renamed
    from scenes import lifts, transient
    if what == "water":
        mesh, scene = transient()
        scene["supports"]["block"] = {"fix": "xy"}
        return mesh, scene | {"stages": scene["stages"][:1]}, "loads_rest_level", ("0.2", "0.5")
    mesh = join([renamed(rectangle(0, i, 1, 1, group=name, rigid=what == "anchors"), {"bottom": "bottom", "top": "top"}, {}) for i, name in enumerate(("low", "high"))])
    scene = lifts()[1]
    scene["supports"] = {name: {"fix": "xy"} for name in (("low", "high") if what == "anchors" else ("bottom", "top"))}
    scene["stages"] = [{"first": {"loads": ["weight"]}}, {"second": {"loads": ["weight"]}}]
    if what == "anchors":
        scene["materials"] = {name: {"density": 2400} for name in ("low", "high")}
        scene["anchors"]["bar"] = {"head": [0.4, 1.9], "root": [0.4, 0.1], "area": 8e-4, "young": 200e9, "prestress": 1.05e5, "lock": "first"}
        return mesh, scene, "anchors_bar_prestress", ("1.05e5", "1.76e5")
    del scene["anchors"]
    for material in scene["materials"].values():
        material["expansion"] = 1e-5
    scene["loads"]["warm"] = {"type": "temperature", "groups": ["low", "high"], "change": 5}
    scene["stages"][1]["second"]["loads"] = ["weight", "warm"]
    return mesh, scene, "loads_warm_change", ("5", "9")


@pytest.mark.alone
@pytest.mark.parametrize(("what", "differs"), [("anchors", r"anchors.bar.force \[kN\] +105 +176"), ("heat", r"temperature.max \[K\] +5 +9"), ("water", r"field flow.pressure")])
def test_states_that_differ_in_more_than_displacements(tmp_path, what, differs):
    """They have the same displacements and contacts. Their checksums differ, and `compare` says in what; the same run on two ranks has the same checksum."""
    import json

    from quoin_tools.show import compare
    mesh, scene, key, values = held_fast(what)
    write(str(tmp_path / "model.h5"), mesh)
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    sums = []
    for k, (value, ranks) in enumerate(((values[0], 1), (values[1], 1), (values[1], 2))):
        launch = [] if ranks == 1 else ["mpirun", "-q", "-n", "2", "--oversubscribe", "--bind-to", "none"]
        done = subprocess.run([*launch, QUOIN, "-options_file", "scene.yaml", f"-{key}", value, "-output", f"out{k}"], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        sums.append(json.loads((tmp_path / f"out{k}/summary.json").read_text(encoding="utf-8"))["stages"][-1]["checksum"])
    assert sums[0] != sums[1] == sums[2]
    code, said, _ = called(compare, [str(tmp_path / "out0"), str(tmp_path / "out1")])
    assert code == 1 and re.search(differs, said), said
    code, said, _ = called(compare, [str(tmp_path / "out1"), str(tmp_path / "out2")])
    assert code == 0 and said.count("the same bits") == len(scene["stages"]), said
