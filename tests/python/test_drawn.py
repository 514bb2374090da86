"""Meshes as they are drawn: coordinates rounded to a millimetre or a centimetre, layers thinner than contact.tolerance."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
import yaml
from quoin_tools.base.results import Results
from quoin_tools.mesh import blockmesh
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import face_set_on, join

QUOIN = os.environ.get("QUOIN", "build/quoin")
pytestmark = pytest.mark.skipif(not Path(QUOIN).exists(), reason="the solver is not built")
JOINT = {"k_n": 10e9, "k_s": 4e9, "friction": 45}


def grid(corners, nx, ny, group, points=()):
    """A body between four corners, counter-clockwise from the lower left one."""
    c = np.array(corners, dtype=float)
    s, t = np.meshgrid(np.linspace(0, 1, nx + 1), np.linspace(0, 1, ny + 1))
    s, t = s.ravel()[:, None], t.ravel()[:, None]
    vertices = (1 - t) * ((1 - s) * c[0] + s * c[1]) + t * ((1 - s) * c[3] + s * c[2])
    first = (np.arange(ny)[:, None] * (nx + 1) + np.arange(nx)).ravel()
    blocks = np.stack([first, first + 1, first + nx + 2, first + nx + 1], axis=1)
    return BlockMesh(vertices, blocks, np.zeros(len(blocks)), [group], [0], {}, dict(points))


def solve(folder, mesh, scene, *options, ranks=1):
    """What the run said, and its results."""
    folder.mkdir(parents=True, exist_ok=True)
    blockmesh.write(folder / "model.h5", mesh)
    (folder / "scene.yaml").write_text(yaml.safe_dump({"model": "model.h5"} | scene, sort_keys=False), encoding="utf-8")
    start = ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"] if ranks > 1 else []
    done = subprocess.run([*start, QUOIN, "-options_file", "scene.yaml", *options], cwd=folder, capture_output=True, text=True,
                          timeout=120, env=os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"})  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout, Results(folder / "out")


def dam(rigid, digits=None):
    """24 x 30 m on rock whose surface rises 1:10, seven faces on fifteen, with 27 m of water."""
    body = grid([(0, 0), (24, 2.4), (6, 30), (0, 30)], 7, 4, "dam", {"crest": 35})
    rock = grid([(-24, -20), (48, -20), (48, 4.8), (-24, -2.4)], 15, 2, "rock")
    mesh = join([body, rock])
    mesh.face_sets["upstream"] = face_set_on(mesh, (0, 0), (0, 30))
    if digits is not None:
        mesh.vertices[:] = np.round(mesh.vertices, digits)
    kind = {"rigid": True} if rigid else {"young": 20e9, "poisson": 0.2}
    scene = {
        "strain": "small", "materials": {"dam": {"density": 2400, **kind}, "rock": {"density": 0, **kind}}, "joints": {"default": JOINT},
        "supports": {"ground": {"fix": "xy", "target": "rock"}}, "relaxation": {"tolerance": 1e-8, "velocity_tolerance": 1e-8},
        "loads": {"weight": {"type": "self_weight"}, "water": {"type": "reservoir", "faces": "upstream", "level": 27.0}},
        "stages": [{"full": {"loads": ["weight", "water"]}}],
    }  # fmt: skip
    return mesh, scene


@pytest.mark.parametrize("rigid", [True, False])
def test_rounded_coordinates_change_no_stress(tmp_path, rigid):
    told, exact = solve(tmp_path / "exact", *dam(rigid))
    assert "as drawn" not in told
    wanted = exact.stage_summary("full")
    for digits, most in ((3, 5e-3), (2, 5e-3)):
        told, rounded = solve(tmp_path / str(digits), *dam(rigid, digits))
        found = rounded.stage_summary("full")
        for place in ("start", "end", "sigma_min"):
            stress = [stage["joints"]["default"][place]["sigma"] for stage in (found, wanted)]
            assert stress[0] == pytest.approx(stress[1], rel=most)
        assert found["joints"]["default"]["open_length"] == 0
        assert found["probes"]["crest"]["u_x"] == pytest.approx(wanted["probes"]["crest"]["u_x"], rel=most)
        assert "joints.default: as drawn its faces are apart by up to" in told and "overlap by up to" in told


def told_of_near_misses(folder, mesh, scene, ranks=1):
    """The warning of faces that nearly meet, and what the run says of them where gaps are real."""
    folder.mkdir(parents=True, exist_ok=True)
    blockmesh.write(folder / "model.h5", mesh)
    scene = {"model": "model.h5"} | scene | {"relaxation": {"max_cycles": 1, "allow_floating": True}}
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    start = ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"] if ranks > 1 else []
    done = subprocess.run([*start, QUOIN, "-options_file", "scene.yaml"], cwd=folder, capture_output=True, text=True, timeout=120, check=False,
                          env=os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"})  # fmt: skip
    assert " contact" in done.stdout and "quoin: error" not in done.stderr, done.stderr
    warned = [line for line in done.stderr.splitlines() if "a small gap wider than contact.tolerance" in line]
    noted = [line for line in done.stdout.splitlines() if "wider than contact.tolerance" in line]
    return warned, noted


@pytest.mark.alone
def test_gaps_a_little_wider_than_the_tolerance_are_told(tmp_path):
    """Rounding to 1 cm puts 4 of the 11 pairs of the base apart by more than 2 mm, at most by 4.0 mm at (6.857, 0.686), drawn at (6.86, 0.69)."""
    for digits, tolerance, ranks in ((None, 0.002, 1), (3, 0.002, 1), (2, 0.002, 1), (2, 0.002, 2), (2, 0.005, 1)):
        mesh, scene = dam(True, digits)
        warned, noted = told_of_near_misses(tmp_path, mesh, scene | {"contact": {"tolerance": tolerance}}, ranks)
        assert not noted and len(warned) == (digits == 2 and tolerance == 0.002)
        if warned:
            assert (
                "joints.default: 4 pairs of faces, 9.648 m long in all, have a small gap wider than contact.tolerance 0.002 m, "
                "the widest 0.00398 m near (6.8604, 0.68604) m between groups rock and dam: no contact at the start, so nothing is borne "
                "there: expected contact.tolerance 0.004 m" in warned[0]
            )
    for digits, pairs in ((2, 4), (None, 0)):  # beyond three tolerances only what rounding to 1 cm may leave
        mesh, scene = dam(True, digits)
        warned, _ = told_of_near_misses(tmp_path, mesh, scene | {"contact": {"tolerance": 2e-4, "overlap": 0.01}})
        assert [f"{pairs} pairs" in line and "the widest 0.00398 m" in line for line in warned] == [True] * (pairs > 0)
    mesh, scene = dam(True, 2)
    real = {"tolerance": 0.002, "initial_gaps": "real"}
    warned, noted = told_of_near_misses(tmp_path, mesh, scene | {"contact": real})
    assert not warned and len(noted) == 1 and noted[0].startswith("joints.default: 4 pairs of faces, 9.648 m, with gaps of up to 0.00398 m")


@pytest.mark.parametrize("turned", [0, 160])
def test_only_faces_that_nearly_meet_are_told(tmp_path, turned):
    """Blocks on a base: apart by 1 mm and by 20 mm (an expansion joint), on a corner, through a layer, and 0.8 m of one block at 11 mm."""
    base = grid([(-1, -1), (12, -1), (12, 0), (-1, 0)], 5, 1, "base")

    def block(*corners):
        return grid(corners, 1, 1, "stone")

    silent = [block((0, 1e-3), (1, 1e-3), (1, 1), (0, 1)), block((2, 0.02), (3, 0.02), (3, 1), (2, 1)), block((4, 0), (5, 0.1), (5, 1), (4, 1)),
              block((6, 0), (7, 0), (7, 0.011), (6, 0.011)), block((6, 0.011), (7, 0.011), (7, 1), (6, 1))]  # fmt: skip
    near = block((8.0, 0.011), (8.8, 0.011), (8.8, 1), (8.0, 1))
    a = np.radians(turned)
    scene = {
        "materials": {"base": {"density": 0, "rigid": True}, "stone": {"density": 2000, "rigid": True}}, "joints": {"default": JOINT},
        "supports": {"ground": {"fix": "xy", "target": "base"}}, "loads": {"weight": {"type": "self_weight"}}, "stages": [{"all": {"loads": ["weight"]}}],
    }  # fmt: skip
    for parts, ranks in ((silent, 1), ([*silent, near], 1), ([*silent, near], 2)):
        mesh = join([base, *parts])
        mesh.vertices[:] = mesh.vertices @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
        warned, _ = told_of_near_misses(tmp_path, mesh, scene, ranks)
        assert len(warned) == (parts is not silent)
        if warned:
            assert "joints.default: 1 pair of faces, 0.8 m long in all, has a small gap" in warned[0]
            assert "the widest 0.011 m near" in warned[0] and "expected contact.tolerance 0.012 m" in warned[0]


@pytest.mark.parametrize("gap", [4e-3, -4e-3])
def test_a_gap_at_the_toe_moves_no_crest_unless_it_is_real(tmp_path, gap):
    """A block of 15 x 20 m that turns by a gap of 4 mm at its toe moves its crest by 20 x 4 / 15 mm: only where the gap is real."""
    mesh = join(
        [
            grid([(0, 0), (15, gap), (15, 20), (0, 20)], 1, 1, "dam", {"crest": 3}),
            grid([(-5, -5), (20, -5), (20, 0), (-5, 0)], 1, 1, "rock"),
        ]
    )
    scene = dam(True)[1] | {"loads": {"weight": {"type": "self_weight"}}, "stages": [{"full": {"loads": ["weight"]}}]}
    scene["joints"] = {"default": JOINT | {"k_n": 1e14, "k_s": 1e14}}
    moved = {}
    for gaps in ("closed", "real"):
        told, results = solve(tmp_path / gaps, mesh, scene | {"contact": {"initial_gaps": gaps}})
        moved[gaps] = results.stage_summary("full")["probes"]["crest"]["u_x"]
        assert f"{'apart' if gap > 0 else 'overlap'} by up to 0.004 m near (15, {gap:g}) m" in told
    assert abs(moved["closed"]) < 1e-6
    assert moved["real"] == pytest.approx(20 * gap / 15 if gap > 0 else 0, rel=1e-3, abs=1e-6)


@pytest.mark.alone
@pytest.mark.parametrize("turned", [0, -25])
@pytest.mark.parametrize("variable", [False, True])
def test_contacts_reach_through_no_layer(tmp_path, turned, variable):
    """A layer of 4 mm between two bodies, tolerance 5 mm: two joints of 10 m, which bear one weight each."""
    parts = [grid([(-1, -2), (11, -2), (11, 0), (-1, 0)], 3, 1, "base"), grid([(0, 0), (10, 0), (10, 4e-3), (0, 4e-3)], 5, 1, "mortar"),
             grid([(0, 4e-3), (10, 4e-3), (10, 2 + 4e-3), (0, 2 + 4e-3)], 4, 1, "top")]  # fmt: skip
    mesh, a = join(parts), np.radians(turned)
    mesh.vertices[:] = mesh.vertices @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
    scene = {
        "contact": {"connectivity": "variable" if variable else "fixed"},
        "materials": {"base": {"density": 0}, "mortar": {"density": 0}, "top": {"density": 2000}} , "joints": {"default": JOINT},
        "supports": {"ground": {"fix": "xy", "target": "base"}}, "loads": {"weight": {"type": "self_weight"}},
        "relaxation": {"tolerance": 1e-8, "velocity_tolerance": 1e-8}, "stages": [{"first": {"loads": ["weight"]}}, {"again": {"loads": ["weight"]}}],
    }  # fmt: skip
    for material in scene["materials"].values():
        material |= {"young": 20e9, "poisson": 0.2}
    states = set()
    for ranks in (1, 2):
        _, results = solve(tmp_path / str(ranks), mesh, scene, ranks=ranks)
        for name in ("first", "again"):
            joint = results.stage_summary(name)["joints"]["default"]
            assert joint["n_contacts"] == 7 + 8 and joint["length"] == pytest.approx(20, rel=1e-6) and joint["open_length"] == 0
            assert joint["N"] == pytest.approx(2 * 2000 * 9.81 * 20 * np.cos(a), rel=2e-3)
        states.add(results.stage_summary("again")["checksum"])
    assert len(states) == 1


def test_a_corner_on_a_slanted_face_is_told_under_fixed_connectivity(tmp_path):
    """A plank leans with its foot on the ground and its back on the corner of a block: no faces are parallel."""
    mesh = join([grid([(-1, -1), (5, -1), (5, 0), (-1, 0)], 2, 1, "base"), grid([(0, 0), (1, 0), (1, 1), (0, 1)], 1, 1, "stone"),
                 BlockMesh(np.array([[0.9, 1.05], [3.0, 0.0], [3.2, 0.2], [1.1, 1.25]]), np.array([[0, 1, 2, 3]]), np.zeros(1), ["stone"], [0], {}, {})])  # fmt: skip
    scene = {
        "materials": {"base": {"density": 0, "rigid": True}, "stone": {"density": 2000, "rigid": True}}, "joints": {"default": JOINT},
        "supports": {"ground": {"fix": "xy", "target": "base"}}, "loads": {"weight": {"type": "self_weight"}},
        "relaxation": {"allow_floating": True, "max_cycles": 50}, "stages": [{"all": {"loads": ["weight"]}}],
    }  # fmt: skip
    blockmesh.write(tmp_path / "model.h5", mesh)
    for variable in (False, True):
        kind = {"connectivity": "variable" if variable else "fixed"}
        (tmp_path / "scene.yaml").write_text(
            yaml.safe_dump({"model": "model.h5", "contact": kind} | scene, sort_keys=False), encoding="utf-8"
        )
        done = subprocess.run(
            [QUOIN, "-options_file", "scene.yaml"], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False
        )
        words = "that is no contact and bears nothing: expected contact.connectivity: variable"
        assert (words in done.stderr) != variable and ("at (1, 1) m" in done.stderr) != variable


def test_a_joint_without_shear_stiffness_is_told_and_slides(tmp_path):
    """k_s 0 on a slope of 5 degrees, friction 45: nothing holds the block, whatever its friction, and the numbers stay finite."""
    mesh, a = (
        join([grid([(-1, -1), (3, -1), (3, 0), (-1, 0)], 2, 1, "base"), grid([(0, 0), (2, 0), (2, 1), (0, 1)], 1, 1, "stone")]),
        np.radians(-5),
    )
    mesh.vertices[:] = mesh.vertices @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
    scene = {
        "model": "model.h5", "materials": {"base": {"density": 0, "rigid": True}, "stone": {"density": 2000, "rigid": True}},
        "joints": {"default": JOINT | {"k_s": 0}}, "supports": {"ground": {"fix": "xy", "target": "base"}},
        "loads": {"weight": {"type": "self_weight"}}, "stages": [{"all": {"loads": ["weight"]}}],
    }  # fmt: skip
    blockmesh.write(tmp_path / "model.h5", mesh)
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    done = subprocess.run(
        [QUOIN, "-options_file", "scene.yaml"], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False
    )
    assert "joints.default: k_s 0 bears no shear, so friction 45 and cohesion 0 Pa hold nothing" in done.stderr
    assert Results(tmp_path / "out").stage_summary("all")["verdict"] == "collapsed"
