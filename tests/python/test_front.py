"""The command `quoin` and `import quoin`: from an empty folder to a sheet; what they refuse, in one line; help in 80 columns."""

import csv
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
import quoin
import yaml
from quoin_tools.ensemble import design
from quoin_tools.front import main as front
from quoin_tools.front import topics

ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
COMMAND = [sys.executable, ROOT / "tools/quoin.py"]
SHORT = ["-stages", "empty,full"]
SOON = ["-relaxation_tolerance", "1e-2", "-relaxation_velocity_tolerance", "1e-2"]  # on a machine with other work two ranks wait for each other

pytestmark = pytest.mark.skipif(not QUOIN.exists(), reason="the program is not built")


@pytest.fixture(autouse=True)
def environment(monkeypatch):
    monkeypatch.setenv("QUOIN_SOLVER", str(QUOIN))
    monkeypatch.delenv("PYTHONPATH", raising=False)


def call(*words, folder=None, code=0, before=()):
    done = subprocess.run([*before, *COMMAND, *words], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stdout + done.stderr
    return done


def refused(*words, folder=None, code=2):
    """The one line with which it is refused."""
    done = call(*words, folder=folder, code=code)
    assert done.stdout == "" and done.stderr.count("\n") == 1 and "Traceback" not in done.stderr, done.stdout + done.stderr
    return done.stderr.rstrip("\n")


@pytest.fixture
def answer(monkeypatch, capsys):
    """The command in this process: to start Python and its packages for each of many words takes longer than the words."""
    def of(*words, folder):
        monkeypatch.chdir(folder)
        code = front.main([str(word) for word in words])
        return code, *capsys.readouterr()

    return of


@pytest.fixture(scope="module")
def dam(tmp_path_factory):
    """A folder that `quoin new` has made, of few blocks; the tests change no file in it."""
    folder = tmp_path_factory.mktemp("front") / "my dam: 1"
    said = call("new", folder, "--height", "30", "--columns", "3")
    assert f"next: cd '{folder}'; quoin run" in said.stdout
    return folder


@pytest.fixture(scope="module")
def whole_run(dam):
    """The scene as it was made."""
    os.environ["QUOIN_SOLVER"] = str(QUOIN)
    call("run", "scene.yaml", folder=dam)
    return quoin.Results(dam / "out")


def verdicts(results):
    return [stage["verdict"] for stage in results.summary["stages"]]


# ---- the way from an empty folder to a sheet


def test_the_way(dam, whole_run):
    assert whole_run.title == "my dam: 1"
    assert whole_run.stages == ["empty", "full", "sliding"] and set(verdicts(whole_run)) == {"converged"}
    found = whole_run.stage_summary("sliding")["strength_reduction"]
    needed = whole_run.stage_summary("full")["joints"]["base"]["friction_needed"]
    assert found["failing"] - 0.5 < needed < found["stable"] + 0.5  # what statics asks for is where the dam slides
    assert "Trials to failure" in call("show", "out", folder=dam).stdout
    assert call("check", "out", folder=dam).stdout.count("whole") >= 4
    call("export", "out", "--to", "csv", folder=dam)
    assert (dam / "csv").is_dir()
    call("report", "out", folder=dam)
    assert "my dam: 1" in (dam / "out/report.html").read_text(encoding="utf-8")
    assert call("compare", "out", "out", folder=dam).returncode == 0
    call("show", "model.h5", folder=dam)
    assert (dam / "model.png").stat().st_size > 1000


def test_new_keeps_what_is_there(dam):
    before = (dam / "scene.yaml").read_bytes()
    assert refused("new", dam).endswith("section.yaml: is there already, and stays as it is")
    assert (dam / "scene.yaml").read_bytes() == before


@pytest.mark.alone
def test_ranks_and_the_solver_itself(dam, tmp_path):
    """`run` gives what the solver gives, which also answers behind mpirun by the name of the command."""
    call("run", dam / "scene.yaml", *SHORT, *SOON, "-output", tmp_path / "run")
    call("run", "-n", "2", dam / "scene.yaml", *SHORT, *SOON, "-output", tmp_path / "two")
    ranks = ("mpirun", "-n", "2", "--oversubscribe", "--bind-to", "none")
    call("-options_file", dam / "scene.yaml", *SHORT, *SOON, "-output", tmp_path / "ranks", before=ranks)
    subprocess.run([QUOIN, "-options_file", dam / "scene.yaml", *SHORT, *SOON, "-output", tmp_path / "solver"], check=True, capture_output=True)
    found = [quoin.Results(tmp_path / name).summary for name in ("run", "two", "ranks", "solver")]
    assert len({tuple(stage["checksum"] for stage in summary["stages"]) for summary in found}) == 1
    assert [summary["ranks"] for summary in found] == [1, 2, 2, 1]
    assert call("-help").stdout == subprocess.run([QUOIN, "-help"], capture_output=True, text=True, check=True).stdout


@pytest.mark.alone
def test_exit_codes_are_passed_on(dam, tmp_path):
    weak = ["scene.yaml", *SHORT, "-joints_base_friction", "20", "-output", str(tmp_path)]
    assert "collapsed" in call("run", *weak, folder=dam, code=6).stdout
    for ranks in ([], ["-n", "2"]):
        done = call("run", *ranks, *weak, "-relaxation_max_cycles", "100", folder=dam, code=4)
        assert "undecided" in done.stdout and "mpirun" not in done.stderr
        assert refused("run", *ranks, "scene.yaml", "-modl", "x", folder=dam) == "quoin: error: command line: -modl: unknown option; did you mean -model?"


def test_check_runs_nothing(dam):
    before = sorted(dam.iterdir())
    said = call("check", "scene.yaml", "-output", "never", folder=dam).stdout.splitlines()
    assert said[-1] == "scene.yaml: nothing is wrong with it, and nothing was run" and "contacts" in said[-2]
    assert "nothing is wrong" in call("check", "scene.yaml", "-stages_sliding_from", "empty", folder=dam).stdout  # load cases
    assert sorted(dam.iterdir()) == before
    done = call("check", "scene.yaml", "-loads_water_faces", "upstrm", folder=dam, code=2)
    assert re.fullmatch(r"quoin: error: .*the mesh has no face set 'upstrm'.*\n", done.stderr)


def test_check_takes_cases_that_stand_on_their_own(dam):
    """Advice tries the stages before the first of them."""
    cases = ["-stages", "empty,full,sliding", "-stages_sliding_from", "empty"]
    done = call("check", "scene.yaml", *cases, folder=dam)
    assert done.stdout.splitlines()[-1] == "scene.yaml: nothing is wrong with it, and nothing was run" and done.stderr == ""
    advice = call("check", "--advise", "scene.yaml", *cases, folder=dam).stdout
    assert re.search(r"^full +1 +\d+", advice, flags=re.M) and "not tried: sliding: what is left out" in advice
    assert "no stage named 'ful'" in call("check", "scene.yaml", *cases[:3], "ful", folder=dam, code=2).stderr


@pytest.mark.skipif(not shutil.which("script"), reason="needs script, which gives a terminal")
def test_progress_stays_in_its_row(dam, tmp_path):
    """On a terminal of 80 columns, whose parent process shows what it shows: a trial without end, stopped after four seconds, so that there are lines of progress on any machine."""
    endless = "-relaxation_tolerance 1e-30 -relaxation_velocity_tolerance 1e-30 -relaxation_max_cycles 100000000 -checkpoint_wall_limit 0.07"
    words = f"{QUOIN} -options_file scene.yaml -output {tmp_path} -stages sliding {endless}"
    shown = subprocess.run(["script", "-qec", f"true; {words}; true", "/dev/null"], cwd=dam, capture_output=True, text=True, stdin=subprocess.DEVNULL, check=False).stdout
    progress = [piece for line in shown.split("\n") for piece in line.split("\r") if piece.startswith("sliding ") and " cycle " in piece]
    assert progress and {len(piece) for piece in progress} == {79}
    assert not re.search(r"[^\r\n]stage sliding", shown)  # a trial begins a row


def test_check_ends_the_solver(tmp_path, monkeypatch):
    """Where it would begin to run stages."""
    solver = tmp_path / "solver"
    solver.write_text('#!/bin/sh\necho "3 blocks"\necho "memory [MB]"\nsleep 1\ntouch went_on\n', encoding="utf-8")
    solver.chmod(0o755)
    (tmp_path / "scene.yaml").write_text("model: model.h5\n")
    monkeypatch.setenv("QUOIN_SOLVER", str(solver))
    assert call("check", "scene.yaml", folder=tmp_path).stdout == "3 blocks\nscene.yaml: nothing is wrong with it, and nothing was run\n"
    assert not (tmp_path / "went_on").exists()


def test_advise(dam):
    before = sorted(dam.iterdir())
    assert "within 1 %" in call("check", "--advise", "scene.yaml", *SHORT, folder=dam).stdout
    assert "not tried: sliding" in call("check", "--advise", "scene.yaml", *SOON, "-stages_sliding_from", "empty", folder=dam).stdout
    assert sorted(dam.iterdir()) == before


def test_study(dam, tmp_path):
    for name in ("6", "9", "notes"):
        (tmp_path / "study" / name).mkdir(parents=True)
    said = call("study", "joints.base.friction=20,50", "scene.yaml", "loads.water.level=20,30", *SHORT, "-o", tmp_path / "study", folder=dam).stdout
    with open(tmp_path / "study/study.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    ends = {(row["joints.base.friction"], row["loads.water.level"]): row["verdict"] for row in rows if row["stage"] == "full"}
    assert ends == {("20", "20"): "converged", ("20", "30"): "collapsed", ("50", "20"): "converged", ("50", "30"): "converged"}
    factors = {row["loads.water.level"]: float(row["sliding factor"]) for row in rows if row["joints.base.friction"] == "50" and row["stage"] == "full"}
    full = quoin.Results(tmp_path / "study/4").stage_summary("full")["joints"]["base"]
    assert factors["30"] == round(full["sliding_factor_peak"], 3) < factors["20"]
    last = next(row for row in rows if row["run"] == "4" and row["stage"] == "full")
    assert (last["overturned"], last["joint"]) == ("-", "base") and last["sliding factor base"] == last["sliding factor"]
    assert said.endswith(f"{tmp_path / 'study'}: 6, 9: of an earlier study, not in the table\n")
    assert "collapsed" in said and "stage full" in (tmp_path / "study/1/log.txt").read_text(encoding="utf-8")
    wrong = refused("study", "scene.yaml", "joints.base.frict=20,50", "-o", tmp_path / "wrong", folder=dam)
    assert wrong.startswith("joints.base.frict=20: quoin: error: command line: -joints_base_frict: unknown option")


def test_study_goes_on(dam, tmp_path, monkeypatch):
    """One whose second run was killed goes on behind the first; one of other values, that is complete, or that lost the folder of a run, runs all of them."""
    folder, solver = tmp_path / "study", tmp_path / "solver"
    solver.write_text(f'#!/bin/sh\ncase "$*" in *{folder}/2*) [ -e {tmp_path}/whole ] || kill -9 $$ ;; esac\nexec {QUOIN} "$@"\n', encoding="utf-8")
    solver.chmod(0o755)
    monkeypatch.setenv("QUOIN_SOLVER", str(solver))

    def runs(values, code=0, jobs=1):
        """Which runs have ended since."""
        before = {path: path.stat().st_mtime_ns for path in folder.glob("*/log.txt")}
        call("study", "scene.yaml", f"joints.base.friction={values}", *SHORT, "-o", folder, "-j", str(jobs), folder=dam, code=code)
        return sorted(int(path.parent.name) for path in folder.glob("*/log.txt") if before.get(path) != path.stat().st_mtime_ns)

    assert runs("45,50", code=128 + 9)[0] == 1 and not (folder / "study.csv").exists()
    (tmp_path / "whole").touch()
    assert runs("45,50") == [2] and len((folder / "study.csv").read_text(encoding="utf-8").splitlines()) > 2
    assert runs("45,50") == [1, 2] and sorted(path.name for path in folder.iterdir()) == ["1", "2", "study.csv"]
    assert runs("45,48") == [1, 2]
    (tmp_path / "whole").unlink()
    assert runs("46,50", code=128 + 9)[0] == 1
    shutil.rmtree(folder / "1")
    (tmp_path / "whole").touch()
    assert runs("46,50") == [1, 2]
    (tmp_path / "whole").unlink()
    assert runs("44,50", code=128 + 9, jobs=2)[0] == 1  # it ends after the second was killed
    (tmp_path / "whole").touch()
    assert runs("44,50") == [2]


def test_report_of_a_diverged_run(dam, tmp_path):
    """Its contact forces are no numbers: the sheet has the gravity method alone, and says that the stage diverged."""
    call("run", "scene.yaml", *SHORT, "-materials_dam_young", "1e-5", "-output", tmp_path / "out", folder=dam, code=3)
    said = call("report", tmp_path / "out", "--terminal", folder=dam).stdout
    assert "The stage ended diverged" in said
    call("report", tmp_path / "out", folder=dam)
    assert "The stage ended diverged" in (tmp_path / "out/report.html").read_text(encoding="utf-8")


def test_mark_of_a_mesh_beside_the_scene(dam, tmp_path):
    """A mesh that an option or a value names is looked for beside the scene too; rows of another one do not count."""
    (tmp_path / "scene.yaml").write_bytes((dam / "scene.yaml").read_bytes())
    (tmp_path / "e.yaml").write_text("scene: scene.yaml\nsamples: 1\nseed: 1\noptions: [-model, m.h5]\nvariables: {joints.base.friction: {distribution: normal, mean: 45, deviation: 1}}\n", encoding="utf-8")

    def marks(mesh):
        (tmp_path / "m.h5").write_text(mesh, encoding="utf-8")
        scene, varied = str(tmp_path / "scene.yaml"), {"joints.base.friction": ["40"]}
        return [design.of_values(scene, varied, ["-model", "m.h5"], 1).mark, design.of_values(scene, {"model": ["m.h5"]}, [], 1).mark, design.read(str(tmp_path / "e.yaml")).mark]

    assert marks("one") == marks("one")
    assert all(first != second for first, second in zip(marks("one"), marks("two"), strict=True))


@pytest.mark.parametrize("keys, said", [
    ({"levels": {"keys": "joints_base_friction", "values": [40]}}, "joints.base.friction is set twice, by variables or levels"),
    ({"fail": "joints.base.sliding_factor_peak < nan"}, "fail: joints.base.sliding_factor_peak < nan: expected collapsed, or a condition"),
    ({"time_limit": float("inf")}, "time_limit: inf: expected a number > 0 and <= 1e+09"),
    ({"seed": 2**63}, "seed: 9223372036854775808: expected a whole number >= 0 and < 2^63"),
    ({"response": 3}, "response: 3: expected a number of a stage by its path"), ({"stage": ["full"]}, "stage: ['full']: expected the name of a stage"),
    ({"correlation": 3}, "correlation: 3: expected rows of two variables and a number"),
])  # fmt: skip
def test_ensemble_refusals(dam, tmp_path, answer, keys, said):
    variables = {"joints.base.friction": {"distribution": "normal", "mean": 45, "deviation": 1}}
    (tmp_path / "e.yaml").write_text(yaml.safe_dump({"scene": str(dam / "scene.yaml"), "samples": 1, "seed": 1, "options": SHORT, "variables": variables} | keys), encoding="utf-8")
    code, out, error = answer("ensemble", "e.yaml", folder=tmp_path)
    assert (code, out) == (2, "") and error.startswith(f"quoin ensemble: e.yaml: {said}") and error.count("\n") == 1


def test_a_scene_of_a_study_that_is_no_yaml(tmp_path, answer):
    (tmp_path / "broken.yaml").write_text("joints: {base: {friction: 30}\nstages: [a\n", encoding="utf-8")
    code, _, error = answer("study", "broken.yaml", "joints.base.friction=30,40", folder=tmp_path)
    assert code == 2 and "broken.yaml" in error and "fault of the program" not in error and error.count("\n") == 1


# ---- refusals, and what prints no traceback


@pytest.mark.parametrize("words, said", [
    (["nwe"], "quoin nwe: no command 'nwe'; did you mean new?"),
    (["run"], "quoin run: no scene is given: expected a file such as scene.yaml"),
    (["run", "-n", "two", "scene.yaml"], "quoin run: -n two: expected a number of ranks"),
    (["run", "a.yaml", "b.yaml"], "quoin run: b.yaml: a second scene; one is run at a time"),
    (["study", "scene.yaml", "joints.base.friction=30", "joints.base.friction=35"], "quoin study: joints.base.friction: given twice; expected all of its values in one list, such as joints.base.friction=30,35"),
    (["study", "scene.yaml", "joints.base.friction=30", "joints_base_friction=35"], "quoin study: joints_base_friction: given twice; expected all of its values in one list, such as joints_base_friction=30,35"),
    (["study", "scene.yaml", "joints.base.friction=30", "-joints_base_friction", "20"], "quoin study: joints.base.friction: it varies, and -joints.base.friction gives it a value too"),
    (["study", "scene.yaml"], "quoin study: nothing varies: expected a key and values, such as joints.base.friction=35,40,45"),
    (["help", "laods"], "quoin help: no topic 'laods'; did you mean 'loads'?"),
    (["report"], "quoin report: the following arguments are required: folder; quoin report -h says more"),
    (["show", "nowhere"], "show: nowhere: no results.h5 (a run writes it at the end of its first stage)"),
    (["import", "dam.dxf", "-o", "m.h5"], "dam.dxf: is a drawing, expected a section file that names it (drawing: {file: ...}) and says what its layers are"),
    (["import", "walls", "wall", "-o", "/proc/none.h5"], "/proc/none.h5: No such file or directory"),
    (["new", "/proc/none"], "quoin new: /proc/none/section.yaml: No such file or directory"),
    (["limit", "scene.yaml", "--sliding"], "quoin limit: --sliding is withdrawn: its estimate without dilation was 2 to 25 % above what blocks bear; --both says what stands and what fails"),
    (["new", "dam", "--slope", "-1"], "quoin new: expected a height, a crest and columns above zero, and faces that do not overhang"),
])  # fmt: skip
def test_refusals(words, said, tmp_path, answer):
    assert answer(*words, folder=tmp_path) == (2, "", said + "\n")


def test_a_refusal_of_the_command(tmp_path):
    """As one that is started says it; those before and behind are of this process."""
    assert refused("nwe", folder=tmp_path) == "quoin nwe: no command 'nwe'; did you mean new?"


FORMS = [[name, option] for name, forms in front.FORMS.items() for option in forms]
PARSED = [[name] for name in front.COMMANDS if name not in ("help", "run", "check", "study", "new", "show")]


@pytest.mark.parametrize("words", [*PARSED, *(form for form in FORMS if form != ["check", "--advise"])], ids=" ".join)
def test_options_that_are_not_there(words, tmp_path, answer):
    code, out, error = answer(*words, "--no-such-option", folder=tmp_path)
    assert (code, out) == (2, "") and re.fullmatch(r"quoin \w+.*: .*; quoin \w+.* -h says more\n", error)


@pytest.mark.parametrize("name", front.FORMER)
def test_former_names(name, tmp_path, answer):
    """A name of an earlier version runs the same function, after a line with the name of today, and stands in no list."""
    (code, out, error), today = answer(name, "-h", folder=tmp_path), front.FORMER[name][1]
    assert code == 0 and out and error == f"quoin: {name} is now: quoin {today}\n"
    assert today.split()[0] in front.COMMANDS and not re.search(rf"^ +{name} ", front.usage(), flags=re.M)
    options = [word for word in today.split() if word.startswith("--")]
    assert not options or front.FORMS[today.split()[0]][options[0]] == front.FORMER[name][0]


def test_former_arguments(dam, tmp_path):
    told = {name: call(name, *words, folder=dam).stdout for name, words in {"blockmesh": ["info", "model.h5"], "plot_mesh": ["model.h5", "-o", tmp_path / "mesh.png"]}.items()}
    assert told["blockmesh"] == call("check", "model.h5", folder=dam).stdout == call("check", "model.h5", "--info", folder=dam).stdout
    assert (tmp_path / "mesh.png").stat().st_size > 1000
    for words in (["dam"], ["import", "dam"]):
        call(*words, "-o", tmp_path / f"{len(words)}.h5", "--columns", "4")
    assert (tmp_path / "1.h5").read_bytes() == (tmp_path / "2.h5").read_bytes()
    done = subprocess.run([sys.executable, "-m", "quoin_tools", "check", dam / "model.h5"], env=os.environ | {"PYTHONPATH": str(ROOT / "tools")}, capture_output=True, text=True, check=True)
    assert done.stdout == told["blockmesh"]


def test_without_the_solver(monkeypatch, tmp_path):
    monkeypatch.setenv("QUOIN_SOLVER", "/nowhere/quoin")
    assert refused("run", "scene.yaml", folder=tmp_path) == "quoin run: QUOIN_SOLVER: /nowhere/quoin: no program there"
    monkeypatch.delenv("QUOIN_SOLVER")
    shutil.copytree(ROOT / "tools", tmp_path / "tools", ignore=shutil.ignore_patterns("__pycache__"))  # a package without a checkout around it
    done = subprocess.run([sys.executable, tmp_path / "tools/quoin.py", "run", "scene.yaml"], capture_output=True, text=True, check=False,
                          env=dict(os.environ, PATH="/nowhere"))  # fmt: skip
    assert done.returncode == 2 and re.fullmatch(r"quoin run: the solver is not installed: .*\n", done.stderr), done.stderr


def test_without_a_launcher(monkeypatch, tmp_path):
    monkeypatch.setenv("QUOIN_MPIRUN", "no-such-launcher --quiet")
    assert refused("run", "-n", "2", "scene.yaml", folder=tmp_path) == "quoin run: no-such-launcher --quiet: no such program, and 2 ranks need it"


def test_a_package_that_is_not_there(tmp_path):
    """One line names it; what needs none works."""
    code = f"import sys; sys.path.insert(0, {str(ROOT / 'tools')!r}); sys.modules['yaml'] = sys.modules['numpy'] = None; import quoin; sys.exit(quoin.main(sys.argv[1:]))"
    for words, end in ((["show", "out"], 2), (["help", "loads"], 0), (["--version"], 0)):
        done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, check=False)
        assert done.returncode == end, done.stderr
        assert not end or re.fullmatch(r"quoin show: needs the Python package numpy, which \S+ lacks: pip install numpy\n", done.stderr)


def test_a_package_that_debian_has(monkeypatch, capsys):
    monkeypatch.setattr(sys, "prefix", "/usr")
    monkeypatch.setattr(sys, "executable", "/usr/bin/python3")
    monkeypatch.setattr(os.path, "exists", lambda path: path == "/usr/bin/apt-get")

    def needs():
        raise ModuleNotFoundError("No module named 'yaml.nodes'", name="yaml.nodes")

    assert front.ended("new", needs) == 2
    assert capsys.readouterr().err == "quoin new: needs the Python package python3-yaml, which /usr/bin/python3 lacks: apt-get install python3-yaml\n"


def test_a_package_of_another_version(capsys):
    def old():
        return np.function_of_a_later_numpy

    assert front.ended("new", old) == 2
    said = capsys.readouterr().err
    assert said == f"quoin new: the Python package numpy {np.__version__} of {sys.executable} has no numpy.function_of_a_later_numpy: another version is needed\n"


def test_faults_are_one_line(monkeypatch, capsys):
    def broken():
        raise KeyError("inside")

    assert front.ended("run", broken) == 7
    said = capsys.readouterr().err
    assert re.fullmatch(r"quoin run: a fault of the program: KeyError: 'inside' \(test_front.py, line \d+; QUOIN_TRACE=1 prints the whole trace\)\n", said)
    monkeypatch.setenv("QUOIN_TRACE", "1")
    with pytest.raises(KeyError):
        front.ended("run", broken)


@pytest.mark.parametrize("words", [["help", "theory"], ["-h"], ["help", "report"], ["show", "out"], ["export", "out"], ["-help"], ["run", "-h"]], ids=" ".join)
def test_a_reader_that_has_seen_enough(words, dam, whole_run):
    """As `| head`: not a word, whether the pipe is gone before the first line or after it."""
    for lines in (0, 1):
        with subprocess.Popen([*COMMAND, *words], cwd=dam, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            for _ in range(lines):
                assert process.stdout.readline()
            process.stdout.close()
            assert process.stderr.read() == "" and process.wait() == 0


# ---- help


def test_help_in_80_columns(capsys):
    """Every topic, document and chapter: no line is longer, code included."""
    wanted = [*topics.pages(), *topics.DOCUMENTS, *(heading.lower() for _, heading, _ in topics.chapters())]
    assert {"loads", "stages", "anchors", "dynamic"} <= set(wanted)
    for text in [topics.overview(), front.usage(), *(topics.topic(name) for name in wanted)]:
        assert not [line for line in text.splitlines() if len(line) > 80]
    for module in ("running", "importing", "show", "study", "topics"):
        lines = __import__(f"quoin_tools.front.{module}", fromlist="x").__doc__.splitlines()
        assert not [line for line in lines if len(line) > 80], module


def test_help_has_every_key():
    """As the solver prints them; nothing of a row is lost in its layout."""
    table = subprocess.run([QUOIN, "-help"], capture_output=True, text=True, check=True).stdout
    keys = re.findall(r"^\| `([^`]+)`", table, flags=re.M)
    assert sorted(keys) == sorted(row[0] for row in topics.key_rows()) and len(keys) > 150
    words = topics.topic("loads").split()
    for key, *facts in topics.key_rows():
        if key.startswith("loads."):
            assert key in words and not [word for fact in facts if fact != "-" for word in fact.split() if word.strip(",") not in " ".join(words)]


def test_help_of_chapters_and_commands():
    assert "raises: [ice]" in topics.topic("load_factor")
    assert "[scene]" not in topics.topic("safety") and "**" not in topics.topic("modes")
    assert call("help", "study").stdout == call("study", "-h").stdout
    assert "materials.<name>.density" in topics.topic("density")


def test_help_of_types():
    """Of loads and stages, with what its page says of it; every type has one."""
    silt = topics.topic("silt")
    assert "Rankine" in silt and re.findall(r"^loads\.\S+", silt, flags=re.M) == [f"loads.<name>.{key}" for key in ("type", "faces", "level", "density", "lateral", "friction", "partial_factor")]
    assert "loads.<name>.tailwater" in topics.topic("tailwater") and "loads.<name>.lever" in topics.topic("crest load")
    assert "stages.<name>.rises" in topics.topic("flood")
    assert len(topics.types()) > 20 and {name for _, name in topics.types()} <= set(topics.pages())
    assert "what scatters" in topics.topic("ensembles") and "upper bound" in topics.topic("what the number means").lower()


# ---- completion, package


def test_completion(dam):
    """The words of the file are those of the table; files, topics, keys and options are found where they are asked for."""
    script = ROOT / "tools/install/quoin.bash"
    listed = re.search(r'^_quoin_commands="([^"]*)"', script.read_text(encoding="utf-8"), flags=re.M)[1].split()
    assert listed == list(front.COMMANDS)

    def completed(*words):
        code = f'source "{script}"; quoin() {{ "{sys.executable}" "{ROOT}/tools/quoin.py" "$@"; }}; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _quoin; printf "%s\\n" "${{COMPREPLY[@]}}"'
        return subprocess.run(["bash", "-c", code, "bash", "quoin", *words], cwd=dam, capture_output=True, text=True, check=True).stdout.split("\n")[:-1]

    assert completed("rep") == ["report"] and completed("import", "vor") == ["voronoi"]
    assert "scene.yaml" in completed("run", "") and "model.h5" not in completed("run", "")
    assert completed("run", "scene.yaml", "-relaxation_eff") == ["-relaxation_effort"]
    assert completed("report", "out", "--guideline") == ["--guideline", "--guidelines"]
    assert completed("help", "supp") == ["supports"]


def test_the_package_has_every_room():
    with open(ROOT / "pyproject.toml", "rb") as file:
        project = tomllib.load(file)
    rooms = {f"quoin_tools.{path.parent.name}" for path in ROOT.glob("tools/quoin_tools/*/__init__.py")}
    assert set(project["tool"]["setuptools"]["packages"]) == rooms | {"quoin_tools", "quoin_tools.docs", "quoin-stubs"}
    pins = re.findall(r"^(\w+)==", (ROOT / "tools/requirements.txt").read_text(encoding="utf-8").partition("# what these need")[0], flags=re.M)
    wanted = {*project["project"]["dependencies"], *project["project"]["optional-dependencies"]["mpi"]}
    assert wanted == set(pins) - {"hypothesis", "pytest", "setuptools", "vtk"}  # those are for tests
    kinds = {path.suffix for path in ROOT.glob("tools/quoin_tools/*/*") if path.is_file() and path.parent.name != "__pycache__"}
    assert kinds == {".py", ".yaml", ".json"}  # package-data and tools/install/CMakeLists.txt name these, and those of page/
    assert {path.suffix for path in ROOT.glob("tools/quoin_tools/*/page/*")} <= set(re.findall(r'PATTERN "\*(\.\w+)"', (ROOT / "tools/install/CMakeLists.txt").read_text(encoding="utf-8")))


def test_one_version():
    version = re.search(r"VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8").split("project(quoin")[1])[1]
    assert call("--version").stdout == f"quoin {version}\n" and quoin.__version__ == version
    assert not [path for path in ROOT.glob("tools/**/*.py") if f'"{version}"' in path.read_text(encoding="utf-8")]


# ---- Python


@pytest.mark.alone
def test_python_by_file_and_dictionary(dam, tmp_path, monkeypatch):
    monkeypatch.chdir(dam)
    loose = {"tolerance": 1e-2, "velocity_tolerance": 1e-2}
    keys = {"stages": ["empty", "full"], "loads.water.level": 25.0} | {f"relaxation.{key}": value for key, value in loose.items()}
    results = quoin.run("scene.yaml", keys=keys, output=tmp_path / "file")
    stage = results.stage("full")
    assert stage.displacement.shape == results.mesh.vertices.shape and stage.contacts.sigma.shape == (3, 2)
    scene = yaml.safe_load((dam / "scene.yaml").read_text(encoding="utf-8"))
    scene["loads"]["water"]["level"] = 25.0
    scene["stages"] = scene["stages"][:2]
    scene["relaxation"] |= loose
    again = quoin.run(scene | {"output": str(tmp_path / "dictionary"), "thickness": "100 cm"}, ranks=2)
    assert np.array_equal(again.stage("full").displacement, stage.displacement)
    assert json.loads((tmp_path / "dictionary/summary.json").read_text())["ranks"] == 2


def test_python_verdicts_and_refusals(dam, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(dam)
    weak = quoin.run("scene.yaml", keys={"stages": ["empty", "full"], "joints.base.friction": 20}, output=tmp_path)
    assert verdicts(weak) == ["converged", "collapsed"]
    with pytest.raises(quoin.RunError, match="no load named 'watr'") as caught:
        quoin.run({**yaml.safe_load((dam / "scene.yaml").read_text(encoding="utf-8")), "stages": [{"full": {"loads": ["watr"]}}]}, output=tmp_path / "no")
    assert caught.value.code == 2 and capfd.readouterr() == ("", "")
    with pytest.raises(AttributeError, match="no attribute 'rnu'"):
        quoin.rnu  # noqa: B018
