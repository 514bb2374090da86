"""What tests/terms/*.diff (docs/extend.md) add, in the program built with it: springs between points and to the ground, which have what a
force term gets from its row of the table and nothing else; a load, a stage, a field of the results."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import h5py
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests/reliability")]

import yaml  # noqa: E402
from quoin_tools.assess import assessment  # noqa: E402
from quoin_tools.assess.assessment_options import Options  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.meshing import join, rectangle, renamed  # noqa: E402
from run import ENVIRONMENT  # noqa: E402

QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin")).parent / "tests/quoin_recipes"
CORNERS = "bottom_left", "bottom_right", "top_left", "top_right"
STIFFNESS, DENSITY, GRAVITY, WIDTH, HEIGHT = 2e6, 2400.0, 10.0, 2.0, 1.0
MASS = DENSITY * WIDTH * HEIGHT


def run(folder, material, stage, *options, ranks=1, mesh=None, **others):
    write(str(folder / "model.h5"), mesh or rectangle(0, 0, WIDTH, HEIGHT, nx=2, group="block"))
    scene = {
        "model": "model.h5", "gravity": GRAVITY,
        "relaxation": {"allow_floating": True, "tolerance": 1e-9},
        "materials": {"block": {"density": DENSITY} | material},
        "joints": {"default": {"law": "elastic", "k_n": 1e9, "k_s": 1e9}},
        "springs": {name: {"point": name, "stiffness": [STIFFNESS, STIFFNESS]} for name in CORNERS},
        "loads": {"weight": {"type": "self_weight"}},
        "stages": {"hang": {"loads": ["weight"]} | stage},
    } | others
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    start = ["mpirun", "-q", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"] if ranks > 1 else []
    return subprocess.run([*start, QUOIN, "-options_file", "scene.yaml", *options], cwd=folder, capture_output=True, text=True,
                          env=ENVIRONMENT | dict(os.environ))


def stages_of(folder):
    return json.loads((folder / "out/summary.json").read_text(encoding="utf-8"))["stages"]


def stage_of(folder):
    return stages_of(folder)[0]


def sinking(folder):
    """Sum of stiffness times settlement over weight: 1."""
    probes = stage_of(folder)["probes"]
    return -sum(STIFFNESS * probes[name]["u_y"] for name in CORNERS) / (MASS * GRAVITY)


ELASTIC, RIGID = {"young": 1e9, "poisson": 0.2}, {"rigid": True}


@pytest.mark.parametrize("material", [ELASTIC, RIGID])
@pytest.mark.parametrize("method", ["explicit", "preconditioned"])
def test_springs_carry_the_weight(tmp_path, material, method):
    done = run(tmp_path, material, {}, "-relaxation_method", method)
    assert done.returncode == 0, done.stderr
    assert sinking(tmp_path) == pytest.approx(1, abs=1e-6)


@pytest.mark.alone
def test_the_same_bits_on_two_ranks(tmp_path):
    checksums = set()
    for ranks in (1, 2):
        assert run(tmp_path, ELASTIC, {}, ranks=ranks).returncode == 0
        checksums.add(stage_of(tmp_path)["checksum"])
    assert len(checksums) == 1


def test_motion_in_time_and_its_energy(tmp_path):
    """Let go, the block swings about its settlement: after half a period it is twice as deep; the account has the springs."""
    omega = math.sqrt(4 * STIFFNESS / MASS)
    done = run(tmp_path, RIGID, {"type": "dynamic", "duration": math.pi / omega, "dt_factor": 0.02})
    assert done.returncode == 0, done.stderr
    assert "out by" not in done.stdout + done.stderr
    assert sinking(tmp_path) == pytest.approx(2, rel=1e-3)


HUNG = {"roof": {"fix": "xy", "target": "roof"}}


def hung():
    """A block 5 m below another, whose top is held; corners of both where they face each other."""
    upper = renamed(rectangle(0, 6, WIDTH, HEIGHT, nx=2, group="block"), {"roof": "top"},
                    {"upper_left": "bottom_left", "upper_right": "bottom_right"})  # fmt: skip
    lower = renamed(rectangle(0, 0, WIDTH, HEIGHT, nx=2, group="block"), {}, {"lower_left": "top_left", "lower_right": "top_right"})
    return join([upper, lower])


@pytest.mark.alone
@pytest.mark.parametrize("material", [ELASTIC, RIGID])
@pytest.mark.parametrize("method", ["explicit", "preconditioned"])
def test_springs_between_blocks(tmp_path, material, method):
    """A block hangs by two springs that cross. However the blocks are dealt out to two ranks, one reads a point of the other, and the
    springs bear half the weight each."""
    tie = {"stiffness": [STIFFNESS, STIFFNESS]}
    springs = {"one": {"point": "upper_left", "to": "lower_right"} | tie, "other": {"point": "upper_right", "to": "lower_left"} | tie}
    checksums = set()
    for ranks in (1, 2):
        done = run(tmp_path, material, {}, "-relaxation_method", method, "-partition", "stripes", ranks=ranks, mesh=hung(),
                   springs=springs, supports=HUNG)  # fmt: skip
        assert done.returncode == 0, done.stderr
        probes = stage_of(tmp_path)["probes"]
        for spring in springs.values():
            stretch = probes[spring["point"]]["u_y"] - probes[spring["to"]]["u_y"]
            assert stretch == pytest.approx(MASS * GRAVITY / 2 / STIFFNESS, rel=1e-6)
        checksums.add(stage_of(tmp_path)["checksum"])
    assert len(checksums) == 1 or method == "preconditioned"


def test_a_point_that_is_none(tmp_path):
    done = run(tmp_path, ELASTIC, {}, "-springs_top_left_point", "nowhere")
    assert done.returncode == 2 and done.stderr == "quoin: error: scene.yaml: springs.top_left: the mesh has no such point\n"
    done = run(tmp_path, ELASTIC, {}, "-springs_top_left_stiffness", "stiff")
    assert done.returncode == 2 and "springs" in done.stderr and "stiffness" in done.stderr


# ---- backfill, forces, reaction: on a block whose bottom is held

GRADIENT = 12e3  # Pa/m: earth at rest that reaches to the top of the block
PUSH, WEIGHT = GRADIENT * HEIGHT**2 / 2, MASS * GRAVITY
HELD = {"supports": {"bottom": {"fix": "xy"}}, "springs": {}, "strain": "small",
        "loads": {"weight": {"type": "self_weight"}, "earth": {"type": "backfill", "faces": "left", "level": HEIGHT, "gradient": GRADIENT}}}  # fmt: skip
BOTH = ["weight", "earth"]


def xy(forces):
    return [forces["x"], forces["y"]]


def reaction(folder, stage):
    """Sum of the field over all vertices."""
    with h5py.File(folder / "out/results.h5") as file:
        return file[f"stages/{stage}/reaction"][:].sum(axis=0)


@pytest.mark.parametrize("material", [ELASTIC, RIGID])
def test_backfill_on_springs(tmp_path, material):
    done = run(tmp_path, material, {"loads": BOTH}, loads=HELD["loads"], strain="small")
    assert done.returncode == 0, done.stderr
    probes = stage_of(tmp_path)["probes"]
    carried = [sum(STIFFNESS * probes[name][f"u_{x}"] for name in CORNERS) for x in "xy"]
    assert carried == pytest.approx([PUSH, -WEIGHT], rel=1e-6)


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.alone)])
def test_reactions_balance_the_backfill(tmp_path, ranks):
    done = run(tmp_path, ELASTIC, {}, ranks=ranks, **HELD | {"stages": {"stand": {"loads": BOTH}}})
    assert done.returncode == 0, done.stderr
    assert xy(stage_of(tmp_path)["applied"]) == pytest.approx([PUSH, -WEIGHT], rel=1e-12)
    assert reaction(tmp_path, "stand") == pytest.approx([-PUSH, WEIGHT], rel=1e-6)


def test_the_gravity_method_has_the_backfill(tmp_path):
    """No line of the tools names the load: its force and its moment, negative at the toe, come from the run; in a load factor too."""
    wall = renamed(rectangle(0, 0, WIDTH, HEIGHT, nx=2, ny=2, group="block"), {"back": "left", "base": "bottom"})
    mesh = join([renamed(rectangle(-1, -1, WIDTH + 2, 1, 1, 1, group="rock", rigid=True), {}), wall])
    earth = HELD["loads"]["earth"] | {"faces": "back"}
    done = run(tmp_path, ELASTIC, {}, mesh=mesh, springs={}, strain="small", supports={"rock": {"fix": "xy"}}, loads=HELD["loads"] | {"earth": earth},
               materials={"block": {"density": DENSITY} | ELASTIC, "rock": {"density": 0, "rigid": True}},
               joints={"base": {"k_n": 1e10, "k_s": 1e10, "friction": 40}},
               stages=[{"stand": {"loads": BOTH}}, {"more": {"type": "load_factor", "loads": BOTH, "raises": ["earth"], "step": 1, "limit": 3}}])  # fmt: skip
    assert done.returncode == 0, done.stderr
    assessments, _ = assessment.assess(assessment.load_case(tmp_path / "out", Options()))
    for stage, factor in (("stand", 1), ("more", 3)):
        base = next(found for found in assessments if (found.stage, found.name) == (stage, "base"))
        hand = (base.hand.N, base.hand.T, base.hand.M)
        assert hand == pytest.approx((WEIGHT, factor * PUSH, -factor * PUSH * HEIGHT / 3), rel=1e-9), stage


def test_forces_of_a_stage_in_which_nothing_moves(tmp_path):
    """Before the block moves, its bottom bears what stands on its own vertices: half of the weight, two thirds of the backfill. Afterwards the forces are in balance."""
    stages = {"before": {"type": "forces", "loads": BOTH}, "stand": {"loads": BOTH}, "after": {"type": "forces", "loads": BOTH}}
    done = run(tmp_path, ELASTIC, {}, **HELD | {"stages": stages})
    assert done.returncode == 0, done.stderr
    before, stand, after = stages_of(tmp_path)
    assert reaction(tmp_path, "before") == pytest.approx([-PUSH * 2 / 3, WEIGHT / 2], rel=1e-12)
    assert before["max_displacement"]["value"] == 0 and before["ratio"] > 0.1
    assert (after["verdict"], after["cycles"]) == ("completed", 0) and after["ratio"] < 1e-9
    assert after["checksum"] == stand["checksum"] != before["checksum"]


def test_a_face_set_that_is_none(tmp_path):
    done = run(tmp_path, ELASTIC, {}, "-loads_earth_faces", "nowhere", **HELD)
    assert done.returncode == 2 and "loads.earth" in done.stderr and "the mesh has no face set 'nowhere'" in done.stderr
