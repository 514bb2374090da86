"""The key `advise`: what it says a run costs against what the run costs, and what a change alters against both runs."""

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
QUOIN = os.environ.get("QUOIN", str(ROOT / "build" / "quoin"))
sys.path.insert(0, str(ROOT / "tools"))

from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.dam import dam_mesh  # noqa: E402
from quoin_tools.mesh.stacks import block_grid, column  # noqa: E402
from triangle_dam import triangle_dam  # noqa: E402

pytestmark = pytest.mark.skipif(not os.path.exists(QUOIN), reason="the program is not built")

BLOCKS = ("-materials_dam_condensed", "false", "-materials_rock_condensed", "false")  # the advice counts cycles of blocks: bodies that a run condenses by itself take fewer
FIG6 = ("fig6", lambda: triangle_dam(24, "M"), ())
FIG6_FRICTION = ("fig6", lambda: triangle_dam(24, "M"), ("-joints_base_law", "mohr_coulomb", "-joints_base_friction", "45"))
G1 = ("guilhofrei", lambda: dam_mesh(columns=6 if os.environ.get("QUOIN_SHORT") else 12), ())
# a process of its own, because what a process has held counts for its children too
HELD = """import resource, subprocess, sys
subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL)
print("held", resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"""


def command_of(case, folder, *options):
    scene, mesh, extra = case
    if not (folder / "model.h5").exists():
        write(str(folder / "model.h5"), mesh())
    return [QUOIN, "-options_file", f"examples/{scene}/scene.yaml", "-model", str(folder / "model.h5"), "-output", str(folder / "out"), *extra, *options]


def on_ranks(ranks, command):
    return ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), *command] if ranks > 1 else command


def run(case, folder, *options, ranks=1):
    """stdout, exit code, stderr."""
    done = subprocess.run(on_ranks(ranks, command_of(case, folder, *options)), cwd=ROOT, capture_output=True, text=True)
    return done.stdout, done.returncode, done.stderr


class Advice:
    """What is printed, as numbers."""

    def __init__(self, text):
        self.text, lines = text, text.splitlines()
        self.memory = float(re.search(r"^explicit +(\d+) +(\d+)$", text, re.M)[1]) * 1e6
        start = next(i for i, line in enumerate(lines) if line.startswith("stage "))
        self.stages = {}
        for line in lines[start + 1 :]:
            cells = line.split()
            if len(cells) != 7:
                break
            self.stages[cells[0]] = dict(zip(("trials", "cycles", "least", "most", "explicit", "preconditioned"), map(float, cells[1:])))
        self.efforts = {row[0]: [float(cell) if cell != "-" else np.nan for cell in row[1:]] for row in
                        (line.split() for line in text.split("preconditioned    evaluations", 1)[1].splitlines()[1 : 1 + len(self.stages)])}  # fmt: skip
        self.changes = {}
        for line in lines:
            row = re.match(r"(\S.*?) {2,}([\d.e+-]+) +(\S+) +(\S+) +(\S+) +(\S+)$", line)
            if row and row[1].split()[0] not in (*self.stages, "explicit"):
                self.changes[row[1]] = [float(cell) if cell != "-" else np.nan for cell in row.groups()[1:]]


def advise(case, folder, accuracy="0.01", **keywords):
    text, code, errors = run(case, folder, "-advise", accuracy, **keywords)
    assert code == 0, errors
    assert not (folder / "out").exists(), "nothing is to be written"
    return Advice(text)


@pytest.mark.parametrize("case", [FIG6, FIG6_FRICTION, G1], ids=["fig6", "fig6_friction", "g1"])
def test_cycles(case, tmp_path):
    """Cycles of static stages to a factor 2.5, as docs/performance.md says."""
    advice = advise(case, tmp_path)
    _, code, errors = run(case, tmp_path)
    assert code == 0, errors
    with open(tmp_path / "out" / "summary.json", encoding="utf-8") as file:
        stages = json.load(file)["stages"]
    assert [stage["name"] for stage in stages] == list(advice.stages)
    for stage in stages:
        guess = advice.stages[stage["name"]]
        assert guess["cycles"] / 2.5 < stage["cycles"] < 2.5 * guess["cycles"], stage["name"]
        assert guess["least"] < stage["cycles"] < guess["most"]


def guilhofrei(folder):
    subprocess.run([sys.executable, "examples/guilhofrei_sliding/mesh.py", str(folder / "model.h5")], cwd=ROOT, check=True,
                   env=dict(os.environ, PYTHONPATH=str(ROOT / "tools")))  # fmt: skip
    return "guilhofrei_sliding", None, ("-stages", "sw,swhp,swhpu,s1")


@contextlib.contextmanager
def one_processor_for(n):
    """What is started within shares one processor with n other programs that never rest."""
    mine, busy = os.sched_getaffinity(0), []
    try:
        os.sched_setaffinity(0, {min(mine)})
        busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(n)]
        yield
    finally:
        os.sched_setaffinity(0, mine)
        for process in busy:
            process.kill()
            process.wait()


@pytest.mark.long
def test_beside_other_work(tmp_path):
    """Seconds are of this program alone, so the advice does not hang on what else the machine does. By the clock on the wall those of Newton's
    method and of condensing were 5 to 40 times as many."""
    case = guilhofrei(tmp_path)
    alone = advise(case, tmp_path)
    with one_processor_for(6):
        beside = advise(case, tmp_path)
    for what in ("the scene as it is", "bodies: condensed"):
        for one, other in zip(alone.changes[what][:3], beside.changes[what][:3]):
            assert one / 3 < other < 3 * one, (what, one, other)
    for text in (alone.text, beside.text):
        assert "joint forces within 1 %: bodies: condensed" in text


@pytest.mark.long
def test_trials(tmp_path):
    """Cycles of a strength reduction to a factor 3, within the range."""
    case = guilhofrei(tmp_path)
    advice = advise(case, tmp_path)
    assert run(case, tmp_path, "-relaxation_method", "explicit", *BLOCKS)[1] == 0
    with open(tmp_path / "out" / "summary.json", encoding="utf-8") as file:
        for stage in json.load(file)["stages"]:
            guess = advice.stages[stage["name"]]
            assert guess["cycles"] / 3 < stage["cycles"] < 3 * guess["cycles"], stage["name"]
            assert guess["least"] < stage["cycles"] < guess["most"]
    # by Newton's method: stages that were solved are known, of trials the range is
    assert run(case, tmp_path, "-relaxation_method", "preconditioned", *BLOCKS)[1] == 0
    with open(tmp_path / "out" / "summary.json", encoding="utf-8") as file:
        for stage in json.load(file)["stages"]:
            effort, done = advice.efforts[stage["name"]], [stage["force_evaluations"], stage["solves"]]
            if stage["name"] != "s1":
                assert [effort[0], effort[3]] == done, stage["name"]
            assert effort[1] <= done[0] <= effort[2] and effort[4] <= done[1] <= effort[5], stage["name"]
            assert effort[0] / 2.5 < done[0] < 2.5 * effort[0] and effort[3] / 2.5 < done[1] < 2.5 * effort[3], stage["name"]
    condensed = advice.changes["bodies: condensed"]
    assert max(condensed[3:]) < 0.1 and condensed[1] < 0.2 * advice.changes["the scene as it is"][1]
    assert "joint forces within 1 %: bodies: condensed" in advice.text and "-materials_dam_condensed true" in advice.text
    assert re.search("^not tried: s1: ", advice.text, re.M)


def longer(*values):
    return pytest.param(*values, marks=pytest.mark.long)


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=[pytest.mark.alone, pytest.mark.long])])
@pytest.mark.parametrize("method, bodies, blocks", [longer("explicit", 1, 250), ("explicit", 90, 1), longer("explicit", 40, 4),
                                                    ("preconditioned", 1, 150), longer("preconditioned", 70, 1), longer("preconditioned", 40, 4)])  # fmt: skip
def test_memory(method, bodies, blocks, ranks, tmp_path):
    """The memory reported before anything is factorised is what rank 0 takes, which is the most."""
    memory_is_foreseen({"law": "elastic"}, method, bodies, blocks, ranks, tmp_path)


@pytest.mark.parametrize("bodies, blocks, ranks", [longer(1, 250, 1), (90, 1, 1), pytest.param(1, 250, 2, marks=[pytest.mark.alone, pytest.mark.long])])
def test_memory_where_joints_fail(bodies, blocks, ranks, tmp_path):
    """Rank 0 gathers for a checkpoint what judges the motion."""
    memory_is_foreseen({"friction": 30}, "explicit", bodies, blocks, ranks, tmp_path)


def held_by(command, folder, ranks=1):
    """Largest resident memory [B] of a rank."""
    done = subprocess.run(on_ranks(ranks, [sys.executable, "-c", HELD, *command, "-output", "out"]), cwd=folder, capture_output=True, text=True)
    assert done.stdout.count("held") == ranks, done.stdout + done.stderr
    return 1024 * max(int(kilobytes) for kilobytes in re.findall(r"held (\d+)", done.stdout))


@pytest.mark.parametrize("method, most", [("explicit", 1800), ("stiffness_mass", 2000)])
def test_memory_of_stones(method, most, tmp_path):
    """What a rigid stone or contact with friction takes at the peak [B], results and checkpoint included: less in a Voronoi dam,
    where vertices are fewer."""
    held, parts = [], []
    for side in (10, 70):
        folder = tmp_path / str(side)
        folder.mkdir()
        write(str(folder / "model.h5"), block_grid(side, side, 1, 1))
        write_stack(folder, {"friction": 60}, rigid=True)
        held.append(held_by([QUOIN, "-options_file", "scene.yaml", "-relaxation_method", method], folder))
        assert json.loads((folder / "out/summary.json").read_text())["stages"][0]["method"] == method  # to its end, by a factor that is exact enough
        parts.append(side**2 + 2 * side * (side - 1))
    assert 500 < (held[1] - held[0]) / (parts[1] - parts[0]) < most, held


def write_stack(folder, law, rigid=False):
    """The scene of a stack of blocks under its weight, for 50 cycles."""
    scene = {"model": "model.h5", "materials": {"block": {"density": 2400, "young": 10e9, "poisson": 0.2, "rigid": rigid}},
             "joints": {"default": law | {"k_n": 10e9, "k_s": 3e9}}, "supports": {"bottom": {"fix": "xy"}},
             "loads": {"weight": {"type": "self_weight"}}, "stages": [{"all": {"loads": ["weight"], "ramp": 0, "max_cycles": 50}}]}  # fmt: skip
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")


def memory_is_foreseen(law, method, bodies, blocks, ranks, tmp_path):
    """To -15 to +25 % of what is not the program alone."""
    mesh = block_grid(bodies, bodies, blocks, blocks)
    write(str(tmp_path / "model.h5"), mesh)
    write_stack(tmp_path, law)
    command = [QUOIN, "-options_file", "scene.yaml", "-relaxation_method", method]
    held = held_by(command, tmp_path, ranks)
    with subprocess.Popen(on_ranks(ranks, [*command, "-advise", "0.01"]), cwd=tmp_path, stdout=subprocess.PIPE, text=True) as process:
        said = next(float(line.split()[1]) for line in process.stdout if line.startswith(f"{method} "))
        process.terminate()  # before it tries what could be left out
    program = 52e6
    assert 0.85 < (1e6 * said - program) / (held - program) < 1.25, (said, held)


def test_no_memory_for_the_factor(tmp_path):
    """Said and not tried; a run goes on by explicit cycles and says so in its summary. The limit is what both ways of the
    whole model take on the average, so that the explicit one fits."""
    case = ("fig6", lambda: triangle_dam(64, "M"), ())
    text, code, errors = run(case, tmp_path, "-advise", "0.01", "-memory_limit", "0.059")
    assert code == 0, errors
    said = re.search(r"^preconditioned: not tried, its factor takes (\d+) MB and (\d+) MB are available$", text, re.M)
    assert said and int(said[1]) > int(said[2])
    assert text.index("memory [MB]") < said.start() < text.index("explicit:")
    _, code, errors = run(case, tmp_path, "-relaxation_method", "preconditioned", "-memory_limit", "0.059")
    assert code == 0 and len([line for line in errors.splitlines() if "no memory for the factor" in line]) == 1, errors
    with open(tmp_path / "out" / "summary.json", encoding="utf-8") as file:
        stage = json.load(file)["stages"][0]
    assert stage["verdict"] == "converged" and stage["method"] == "explicit" and "; no memory for the factor: it takes about" in stage["evidence"]
    _, code, errors = run(case, tmp_path, "-materials_dam_condensed", "true", "-memory_limit", "0.0575")
    assert code == 11 and re.match(r"quoin: error: the factors of \d+ condensed bod(y|ies) take about \S+ GB of memory, \S+ GB are available", errors), errors
    _, code, errors = run(case, tmp_path, "-memory_limit", "0.001")
    assert code == 11 and "need about" in errors


@pytest.mark.long
def test_limit_of_effort(tmp_path):
    """Blocks in stacks that slip apart under their own weight: creep would follow them for minutes; it is given up, which is reported, and the advice goes on."""
    mesh = block_grid(60, 60, 1, 1)
    write(str(tmp_path / "model.h5"), mesh)
    scene = {"model": "model.h5", "materials": {"block": {"density": 2400, "young": 10e9, "poisson": 0.2}},
             "joints": {"default": {"k_n": 10e9, "k_s": 3e9, "friction": 30}}, "supports": {"bottom": {"fix": "xy"}},
             "loads": {"weight": {"type": "self_weight"}}, "stages": [{"all": {"loads": ["weight"], "ramp": 0}}]}  # fmt: skip
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    done = subprocess.run([QUOIN, "-options_file", "scene.yaml", "-advise", "0.01"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    evaluations, solves = map(int, re.search(r"^preconditioned: given up after (\d+) force evaluations, (\d+) solves$", done.stdout, re.M).groups())
    most = 5e7 / (60 * 60 + 4 * 7080) / 3  # blocks and contacts, src/study/attempt.c
    assert most / 2 < evaluations + solves < most + 70  # the last iteration may take 60
    assert "no equilibrium of the first stages was found" in done.stdout and re.search(r"^explicit: \S+ us a cycle", done.stdout, re.M)


def test_changes(tmp_path):
    """The change reported is the difference of two runs: displacements, and resultants of contacts."""
    tight = (*G1[:2], ("-relaxation_method", "preconditioned"))
    advice = advise(tight, tmp_path)

    def answers(*options):
        assert run(tight, tmp_path, *options)[1] == 0
        stage = Results(str(tmp_path / "out")).stage("swhp")
        return np.asarray(stage.displacement), np.asarray(stage.contacts.force).sum(axis=1)

    u, force = answers()
    for what, options in {"joints: pt": ("-joints_base_stress_model", "pt"), "blocks: reduced": ("-materials_dam_element", "reduced", "-materials_rock_element", "reduced"),
                          "rigid: dam": ("-materials_dam_rigid", "true")}.items():  # fmt: skip
        other, other_force = answers(*options)
        moved = np.linalg.norm(other - u, axis=1).max() / np.linalg.norm(u, axis=1).max()
        joints = np.linalg.norm(other_force - force, axis=1).sum() / np.linalg.norm(force, axis=1).sum()
        assert advice.changes[what][3:] == pytest.approx([100 * moved, 100 * joints], rel=0.02), what
    assert "displacements and joint forces within 1 %: " in advice.text and "not tried" not in advice.text


@pytest.mark.alone
@pytest.mark.long
def test_ranks(tmp_path):
    one, two = advise(G1, tmp_path), advise(G1, tmp_path, ranks=2)
    for name, stage in one.stages.items():
        assert two.stages[name]["cycles"] == pytest.approx(stage["cycles"], rel=0.01)
    for what, row in one.changes.items():
        assert two.changes[what][3:] == pytest.approx(row[3:], rel=0.05, abs=1e-3), what


def test_in_time(tmp_path):
    """The steps of a dynamic stage are known."""
    subprocess.run([sys.executable, "examples/motion/mesh.py", str(tmp_path / "model.h5"), "edge"], cwd=ROOT, check=True,
                   env=dict(os.environ, PYTHONPATH=str(ROOT / "tools")))  # fmt: skip
    case = ("motion", None, ("-stages_move_frames", "0", "-stages_move_duration", "0.02"))
    text, code, errors = run(case, tmp_path, "-advise", "0.1")
    assert code == 0, errors
    steps = int(re.search(r"^move +1 +(\d+)", text, re.M)[1])
    assert run(case, tmp_path)[1] == 0
    with open(tmp_path / "out" / "summary.json", encoding="utf-8") as file:
        assert abs(steps - json.load(file)["stages"][0]["cycles"]) <= 1


@pytest.mark.long
def test_many_groups(tmp_path):
    """However many groups, the options of a change are whole: each block of a column of 40 is a group of its own."""
    mesh, n = column(40, rigid=False), 40
    block = mesh.group_names.index("block")
    own = np.flatnonzero(mesh.block_group == block)
    assert len(own) == n
    mesh.group_names = [f"course_of_stones_{i}" for i in range(n)] + [name for name in mesh.group_names if name != "block"]
    mesh.group_rigid = np.array([0] * n + [1], dtype=np.int32)
    mesh.block_group[mesh.block_group != block] = n
    mesh.block_group[own] = np.arange(n)[::-1]  # the lowest block, which alone is squeezed at its foot, comes last
    write(str(tmp_path / "model.h5"), mesh)
    stone = {"density": 2400, "young": 10e9, "poisson": 0.2}
    scene = {"model": "model.h5", "materials": dict.fromkeys(mesh.group_names[:n], stone) | {"base": {"density": 0, "rigid": True}},
             "joints": {"default": {"k_n": 1e12, "k_s": 1e12, "friction": 45}}, "supports": {"base": {"fix": "xy"}},
             "loads": {"weight": {"type": "self_weight"}}, "stages": [{"weight": {"loads": ["weight"]}}]}  # fmt: skip
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    def run_here(*options):
        done = subprocess.run([QUOIN, "-options_file", "scene.yaml", "-relaxation_method", "preconditioned", *options], cwd=tmp_path,
                              capture_output=True, text=True)  # fmt: skip
        assert done.returncode == 0, done.stderr
        return done.stdout

    def moved(*options):
        run_here("-output", "out", *options)
        return np.asarray(Results(str(tmp_path / "out")).stage("weight").displacement)

    reduced = [word for name in mesh.group_names[:n] for word in (f"-materials_{name}_element", "reduced")]
    full, other = moved(), moved(*reduced)
    change = np.linalg.norm(other - full, axis=1).max() / np.linalg.norm(full, axis=1).max()
    half = moved(*reduced[: len(reduced) // 2])
    assert np.linalg.norm(half - other, axis=1).max() > 0.1 * np.linalg.norm(other - full, axis=1).max()
    assert Advice(run_here("-advise", "0.01")).changes["blocks: reduced"][3] == pytest.approx(100 * change, rel=0.02)


def test_a_signal_ends_it(tmp_path):
    """Nothing is written, so there is nothing to wait for or to tell (it said that its output could not be written, exit code 8)."""
    command = command_of(FIG6, tmp_path, "-advise", "0.01")
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        next(line for line in process.stdout if line.startswith("explicit "))
        process.terminate()
        assert "cannot" not in process.stderr.read()
    assert process.returncode == -signal.SIGTERM


def test_bad_accuracy(tmp_path):
    _, code, errors = run(FIG6, tmp_path, "-advise", "2")
    assert code == 2
    assert errors.strip() == "quoin: error: command line: -advise: 2 is out of range: must be >= 0, < 1"
