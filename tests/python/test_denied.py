"""What the system denies: large files, processor time, memory that ranks share, locks, memory; signals before the run has begun; what others have put
into the output folder. Each is reported, and the next run goes on to the results of an undisturbed one."""

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
QUOIN = os.environ.get("QUOIN", str(ROOT / "build" / "quoin"))
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests/reliability")]

import yaml  # noqa: E402
from calls import content  # noqa: E402
from quoin_tools.base import solver  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.voronoi import Options, voronoi_mesh  # noqa: E402
from quoin_tools.mesh.walls import arch, wall  # noqa: E402
from run import ENVIRONMENT, outcome  # noqa: E402
from scenes import static  # noqa: E402

pytestmark = pytest.mark.skipif(not os.path.exists(QUOIN), reason="the program is not built")
LONG = ("-relaxation_velocity_tolerance", "1e-30", "-relaxation_max_cycles", "1000000000")  # never ends by itself


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """A folder with a scene and its results, and what these are."""
    folder = tmp_path_factory.mktemp("undisturbed")
    mesh, scene = static(4)
    write(str(folder / "model.h5"), mesh)
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    code, _, error = run(folder)
    assert code == 0, error
    return folder, content(folder)


@pytest.fixture
def folder(undisturbed, tmp_path):
    """The scene alone."""
    for name in ("model.h5", "scene.yaml"):
        shutil.copy(undisturbed[0] / name, tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def denying(tmp_path_factory):
    """The library that denies, see tests/reliability/deny.c."""
    library = tmp_path_factory.mktemp("deny") / "deny.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-o", library, ROOT / "tests/reliability/deny.c", "-ldl"], check=True)
    return lambda what: {"LD_PRELOAD": str(library), "QUOIN_DENY": str(what)}


def command(*options, ranks=1, limits=""):
    launch = [] if ranks == 1 else ["mpirun", "-q", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"]
    return ["bash", "-c", f'{limits} exec "$@"', "-", *launch, QUOIN, "-options_file", "scene.yaml", *options]


def run(folder, *options, environment=None, **more):
    """Exit code, stdout, and what it says went wrong."""
    done = subprocess.run(command(*options, **more), cwd=folder, capture_output=True, text=True, env=os.environ | ENVIRONMENT | (environment or {}))
    return done.returncode, done.stdout, [line for line in done.stderr.splitlines() if line.startswith("quoin: ")]


def goes_on(folder, expected):
    code, _, error = run(folder, "-restart", "auto")
    assert code == 0 and content(folder) == expected, error


@pytest.mark.parametrize("blocks", [1, 8, 30, 51, 59])  # of 1024 bytes; the last checkpoint has 60
def test_files_that_may_not_grow(folder, undisturbed, blocks):
    code, _, error = run(folder, limits=f"ulimit -f {blocks};")
    assert code == 8 and len(error) == 1 and "File too large" in error[0], (code, error)
    goes_on(folder, undisturbed[1])


def test_processor_time(folder):
    """Its soft limit is reported by SIGXCPU, which ends a program that does not look for it."""
    code, out, error = run(folder, *LONG, limits="ulimit -S -t 1;")
    assert code == 5 and len(error) == 1 and "a signal stops the run" in error[0] and "-restart out/checkpoints" in out, (code, out, error)
    code, out, error = run(folder, *LONG, "-restart", "auto", "-checkpoint_wall_limit", "1e-9")
    assert code == 5 and "goes on from" in out, (code, out, error)


@pytest.mark.parametrize("number", [signal.SIGUSR1, signal.SIGUSR2, signal.SIGTERM, signal.SIGXCPU], ids=lambda number: number.name)
def test_signals_during_set_up(folder, undisturbed, denying, number):
    """They wait for the first cycle: SIGUSR1 asks for a checkpoint there, the others for one and an end."""
    code, out, error = run(folder, environment=denying(int(number)))
    assert code == (0 if number == signal.SIGUSR1 else 5), (code, out, error)
    goes_on(folder, undisturbed[1])


@pytest.mark.alone
@pytest.mark.parametrize("what", ["space", "window"])
def test_no_shared_memory(folder, undisturbed, denying, what):
    """Ranks exchange messages instead, with the same bits."""
    code, _, error = run(folder, ranks=2, environment=denying(what))
    assert code == 0 and len(error) == 1 and "they exchange messages" in error[0], (code, error)
    assert outcome(folder) == outcome(undisturbed[0])
    code, _, error = run(folder, ranks=2)
    assert code == 0 and not error


def test_no_locks(folder, undisturbed, denying):
    """Any refusal but "another has it" is reported by its name (a disk over the network without locks)."""
    code, _, error = run(folder, environment=denying("lock"))
    assert code == 8 and error == ["quoin: error: output: cannot lock 'out/quoin.lock': No locks available"]
    goes_on(folder, undisturbed[1])


def test_no_memory_for_the_scene(folder, denying):
    code, _, error = run(folder, environment=denying("yaml"))
    assert code == 2 and error == ["quoin: error: scene.yaml: no memory is left to read it"] and not (folder / "out").exists()


def factor_scene(folder, method):
    """Stones that slide, or a wall of blocks; their cycles end soon."""
    stones = method == "stiffness_mass"
    mesh = voronoi_mesh(options=Options(seed=5, side=1.6)) if stones else wall(4, 4, rigid=False, divide=(2, 2))
    stone = {"density": 2400, "rigid": True} if stones else {"density": 2400, "young": 10e9, "poisson": 0.2}
    write(str(folder / "model.h5"), mesh)
    scene = {"model": "model.h5", "output": "out", "relaxation": {"method": method, "ramp": 0, "max_cycles": 50}, "supports": {"base": {"fix": "xy"}},
             "materials": {"dam": stone, "facing": stone} if stones else {"block": stone, "base": {"density": 0}},
             "joints": {"default": {"k_n": 10e9, "k_s": 3e9, "friction": 60}}, "loads": {"weight": {"type": "self_weight", "groups": ["dam" if stones else "block"]}},
             "stages": [{"sw": {"loads": ["weight"]}}]}  # fmt: skip
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")


def without_factor(folder, error):
    """Explicit cycles have done the stage, and one line says so."""
    told = [line for line in error if "no memory for the factor" in line]
    return len(told) == 1 and "goes on by explicit cycles" in told[0] and json.loads((folder / "out/summary.json").read_text(encoding="utf-8"))["stages"][0]["method"].endswith("explicit")


def allocations(folder, denying, **more):
    done = subprocess.run(command(**more), cwd=folder, capture_output=True, text=True, env=os.environ | ENVIRONMENT | denying("factor_0"))
    return max(int(line.split()[1]) for line in done.stderr.splitlines() if line.startswith("deny: "))


@pytest.mark.parametrize("method", ["stiffness_mass", "preconditioned"])
def test_no_memory_within_a_factor(tmp_path, denying, method):
    """Whichever allocation of a factor fails: the project's own, METIS's, CHOLMOD's. CHOLMOD tries some of them again, smaller."""
    factor_scene(tmp_path, method)
    n = allocations(tmp_path, denying)
    assert n >= 10
    ends = []
    for i in range(1, n + 1, 1 if method == "stiffness_mass" else 4):
        code, _, error = run(tmp_path, environment=denying(f"factor_{i}"))
        assert code in (0, 4), (i, error)
        ends.append(without_factor(tmp_path, error))
    assert all(ends) if method == "stiffness_mass" else sum(ends) >= len(ends) // 2


def test_max_cycles_of_each_method(tmp_path):
    """Cycles that explicit ones replace are no part of theirs: the verdict is that of explicit cycles alone, in the same number of them."""
    factor_scene(tmp_path, "stiffness_mass")
    stages = []
    for method in ("stiffness_mass", "explicit"):
        code, _, error = run(tmp_path, "-relaxation_method", method)
        assert code == 4, error
        stages.append(json.loads((tmp_path / "out/summary.json").read_text(encoding="utf-8"))["stages"][0])
    both, alone = stages
    assert both["method"] == "stiffness_mass, then explicit" and (both["cycles"], alone["cycles"]) == (100, 50)
    assert both["evidence"] == alone["evidence"] and both["evidence"].startswith("50 cycles: ")


@pytest.mark.alone
def test_no_memory_on_one_rank(tmp_path, denying):
    """All ranks give the factor up together. The last allocation but one tries the memory that ranks share; the last is MPI's own."""
    factor_scene(tmp_path, "stiffness_mass")
    environment = {"QUOIN_DENY_RANK": "1"}
    n = allocations(tmp_path, lambda what: denying(what) | environment, ranks=2)
    for i in (1, n - 3, n - 2, n - 1):
        code, _, error = run(tmp_path, ranks=2, environment=denying(f"factor_{i}") | environment)
        assert code == 4 and (by_messages(error) if i == n - 1 else without_factor(tmp_path, error)), (i, error)


def by_messages(error):
    return sum("they exchange messages" in line for line in error) == 1


@pytest.mark.alone
@pytest.mark.parametrize("ranks", [2, 3])
def test_no_shared_memory_for_a_factor(tmp_path, denying, ranks):
    """Ghosts and damping have their windows, the factor has none, on all ranks or on one: its solves go by messages, with the same bits."""
    factor_scene(tmp_path, "stiffness_mass")
    code, _, error = run(tmp_path)
    undisturbed = outcome(tmp_path)
    assert code == 4 and not by_messages(error), error
    for rank in ({}, {"QUOIN_DENY_RANK": str(ranks - 1)}):
        code, _, error = run(tmp_path, ranks=ranks, environment=denying("window_3") | rank)
        assert code == 4 and by_messages(error) and outcome(tmp_path) == undisturbed, (code, error)


@pytest.mark.alone
def test_folder_of_shared_memory_is_missing(folder, undisturbed):
    """Open MPI's ranks would wait for each other."""
    code, _, error = run(folder, ranks=2, environment={"OMPI_MCA_osc_sm_backing_directory": str(folder / "missing")})
    assert code == 0 and len(error) == 1 and by_messages(error), (code, error)
    assert outcome(folder) == outcome(undisturbed[0])


@pytest.mark.alone
@pytest.mark.parametrize("ranks", [2, 3])
def test_small_shared_memory(tmp_path, ranks):
    """Of every size from none to more than a run takes; a page that its disk has no room for would end a rank."""
    if subprocess.run(["unshare", "-m", "true"], capture_output=True).returncode:
        pytest.skip("no file system can be mounted here")
    factor_scene(tmp_path, "stiffness_mass")
    run(tmp_path)
    undisturbed, told = outcome(tmp_path), []
    (tmp_path / "disk").mkdir()
    for size in (8, 140, 180, 240, 500):
        disk = f"mount -t tmpfs -o size={size}k,nr_inodes=100 tmpfs disk && exec"
        done = subprocess.run(["unshare", "-m", "sh", "-c", f'{disk} "$@"', "-", *command(ranks=ranks)], cwd=tmp_path, capture_output=True, text=True, timeout=300,
                              env=os.environ | ENVIRONMENT | {"OMPI_MCA_osc_sm_backing_directory": str(tmp_path / "disk")})
        assert done.returncode == 4 and outcome(tmp_path) == undisturbed, (size, done.stderr)
        told.append(by_messages(done.stderr.splitlines()))
    assert told[0] and not told[-1] and sorted(told, reverse=True) == told


def hand_over_scene(folder, kind):
    """Stages, or trials, that go over to explicit cycles; the checkpoints are those of the hand-overs and of the ends of stages."""
    if kind == "stiffness_mass":  # finds no end
        factor_scene(folder, kind)
        changes = {"relaxation": {"method": kind, "ramp": 100, "max_cycles": 400}}
    elif kind == "preconditioned":
        factor_scene(folder, kind)
        changes = {"relaxation": {"method": kind, "effort": 1, "tolerance": 1e-5}}
    else:  # diverges, in one of three trials
        write(str(folder / "model.h5"), arch(75, thickness=2.3))
        changes = {
            "model": "model.h5", "output": "out", "materials": {"voussoir": {"density": 2400}, "abutment": {"density": 0}},
            "joints": {"default": {"k_n": 1.8e8, "k_s": 9e6, "friction": 25}}, "supports": {"abutment": {"fix": "xy"}},
            "loads": {"weight": {"type": "self_weight", "groups": ["voussoir"]}, "crown": {"type": "point_force", "point": "crown_extrados", "value": [0, -10e3]}},
            "stages": [{"sw": {"loads": ["weight"]}},
                       {"crown": {"type": "load_factor", "loads": ["weight", "crown"], "raises": ["crown"], "step": 2, "limit": 400, "bracket": 1}}],
        }  # fmt: skip
    path = folder / "scene.yaml"
    scene = (yaml.safe_load(path.read_text(encoding="utf-8")) if path.exists() else {}) | changes | {"checkpoint": {"minutes": 60, "keep": 9}}
    path.write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")


@pytest.mark.long
@pytest.mark.alone
@pytest.mark.parametrize("kind", ["stiffness_mass", "preconditioned", "trials"])
def test_kills_at_a_hand_over(tmp_path, denying, kind):
    """A signal comes as the checkpoint of a hand-over gets its name, just before or after; on another number of ranks the run ends as one that
    nothing has disturbed."""
    hand_over_scene(tmp_path, kind)
    end, _, error = run(tmp_path)
    whole = outcome(tmp_path)
    methods = [stage["method"] for stage in json.loads((tmp_path / "out/summary.json").read_text(encoding="utf-8"))["stages"]]
    assert end in (0, 4) and methods[-1].endswith(", then explicit"), error
    for i, n in enumerate((-1, 1, -2, 2, -3, 3) if kind == "trials" else (-1, 1)):
        for number in (signal.SIGKILL, signal.SIGTERM):
            shutil.rmtree(tmp_path / "out")
            ranks = 1 + i % 2
            code, out, error = run(tmp_path, ranks=ranks, environment=denying(f"kill_{n}_{int(number)}"))
            assert code in ((137, -9) if number == signal.SIGKILL else (5,)), (n, number, code, error)
            code, out, error = run(tmp_path, "-restart", "auto", ranks=(2, 4, 1)[i % 3])
            assert code == end and outcome(tmp_path) == whole, (n, number, code, out, error)
            assert not list((tmp_path / "out").rglob("*.part"))


@pytest.mark.parametrize("name", ["results.h5", "results.xdmf", "history.csv", "summary.json", "scene_echo.yaml", "checkpoints/checkpoint_000000.h5"])
def test_links_to_elsewhere_are_not_followed(folder, undisturbed, name):
    """Whoever may write into the output folder could have another file overwritten."""
    precious = folder / "precious"
    precious.write_text("yes")
    part = folder / f"out/{name}.part"
    part.parent.mkdir(parents=True)
    part.symlink_to(precious)
    code, _, error = run(folder)
    assert precious.read_text() == "yes"
    assert code == 8 and len(error) == 1 and name in error[0] and "Too many levels of symbolic links" in error[0], (code, error)
    part.unlink(missing_ok=True)
    goes_on(folder, undisturbed[1])


def test_numbers_of_checkpoints(folder, undisturbed):
    """One that a run could not count on from is none of a run; behind the last number that has a name no file is written that no restart finds."""
    place = folder / "out/checkpoints"
    place.mkdir(parents=True)
    (place / "checkpoint_2147483647.h5").write_text("of somebody else")
    code, _, error = run(folder)
    assert code == 0 and content(folder) == undisturbed[1], error
    assert (place / "checkpoint_2147483647.h5").read_text() == "of somebody else" and max(map(len, os.listdir(place))) == len("checkpoint_2147483647.h5")
    good = (place / sorted(os.listdir(place))[1]).read_bytes()
    (place / "checkpoint_999999999.h5").write_bytes(good)
    code, _, error = run(folder)
    assert code == 8 and len(error) == 1 and "no number is left in 'out/checkpoints' behind 999999999" in error[0], (code, error)
    assert not list(place.glob("checkpoint_1000000000*"))


def test_starts_at_once(folder, undisturbed):
    """One has the folder, the others are refused; one that comes when it is free goes on from the newest checkpoint, whose number it has read by then."""
    starts = [subprocess.Popen(command("-restart", "auto", "-checkpoint_every", "150"), cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                               text=True, env=os.environ | ENVIRONMENT) for _ in range(6)]  # fmt: skip
    errors = [start.communicate()[1] for start in starts]
    codes = [start.returncode for start in starts]
    assert set(codes) <= {0, 9} and 0 in codes, (codes, errors)
    assert all("another run" in error for code, error in zip(codes, errors) if code == 9)
    assert content(folder) == undisturbed[1]
    assert not list((folder / "out").rglob("*.part"))


@pytest.mark.parametrize("words", [["-help"], ["-schema"], ["-options_file", "scene.yaml", "-echo"], ["-options_file", "scene.yaml", "-advise", "0.01"], ["-options_file", "scene.yaml", "-samples", "/dev/stdin"]])
def test_text_on_a_full_disk(folder, words):
    """What is nothing but text ends with 8, and says so; a reader of a pipe that has seen enough is no fault."""
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run([QUOIN, *words], cwd=folder, stdout=full, stderr=subprocess.PIPE, text=True, input="sample,joints.base.k_n\n1,1e10\n", env=os.environ | ENVIRONMENT)
    assert done.returncode == 8 and done.stderr.count("quoin: error: output") == 1, (done.returncode, done.stderr)
    if words[0] != "-options_file":
        done = subprocess.run(["bash", "-c", f"set -o pipefail; {QUOIN} {words[0]} | head -n 1"], capture_output=True, text=True)
        assert (done.returncode, done.stderr) == (0, "")


def solvers(folder):
    """Processes of solvers, and of mpirun, that run scenes of this folder."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            words = (path / "cmdline").read_text(encoding="utf-8").split("\0")
        except OSError:
            continue
        if QUOIN in words and any(str(folder) in word for word in words):
            found.append(int(path.name))
    return found


def test_a_solver_that_starts_as_a_signal_ends_the_others(monkeypatch):
    """The signal comes between the start of the process and its entry in the list of those that run."""
    begin = subprocess.Popen

    def late(*words, **options):
        process = begin(*words, **options)
        solver.end_all()
        return process

    monkeypatch.setattr(solver, "ENDING", threading.Event())
    monkeypatch.setattr(subprocess, "Popen", late)
    process = solver.start(["sleep", "600"])
    assert process.wait(60) == -signal.SIGTERM
    solver.ended(process)


@pytest.mark.parametrize(("who", "number"), [("study", signal.SIGTERM), ("python", signal.SIGHUP), ("python", signal.SIGKILL), ("ensemble", signal.SIGTERM)])
def test_whoever_starts_solvers_ends_them(folder, who, number):
    """A signal that ends the process that has started mpirun, or samples, leaves none of them behind."""
    scene, out = str(folder / "scene.yaml"), str(folder / "out")
    lasting = {"relaxation.velocity_tolerance": 1e-30, "relaxation.max_cycles": 1000000000}
    words = {"study": [str(ROOT / "tools/quoin.py"), "study", scene, "joints.base.k_n=1e10,2e10", "-n", "2", "-o", out, *LONG],
             "python": ["-c", f"import quoin; quoin.run({scene!r}, 2, {lasting}, output={out!r})"],
             "ensemble": [str(ROOT / "tools/quoin.py"), "ensemble", str(folder / "ensemble.yaml"), "-j", "2", "-o", out]}[who]
    (folder / "ensemble.yaml").write_text(yaml.safe_dump({"scene": scene, "samples": 8, "seed": 1, "fail": "collapsed", "options": list(LONG),
                                                          "variables": {"materials.dam.young": {"distribution": "uniform", "min": 9e9, "max": 11e9}}}), encoding="utf-8")
    # whoever runs the tests by nohup ignores SIGHUP, and a program leaves it so
    process = subprocess.Popen(["env", "--default-signal", sys.executable, *words], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                               env=os.environ | ENVIRONMENT | {"PYTHONPATH": str(ROOT / "tools"), "QUOIN_SOLVER": QUOIN})
    wanted = 2 if who == "ensemble" else 3
    while process.poll() is None and len(solvers(folder)) < wanted:
        time.sleep(0.05)
    assert process.poll() is None
    process.send_signal(number)
    assert process.wait() == -number
    until = time.monotonic() + (0 if number != signal.SIGKILL else 60)  # after SIGKILL the system tells the solvers, and nobody waits for them
    while solvers(folder) and time.monotonic() < until:
        time.sleep(0.05)
    assert not solvers(folder)
