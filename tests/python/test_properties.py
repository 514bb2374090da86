"""Properties of random block assemblies, whatever their size, stones, joints and loads: a scene that is turned,
mirrored or numbered in another way gives the turned, mirrored or renumbered result; the partition changes no bit; joint
stresses stay within their envelope; reactions balance loads; contacts make no momentum.

Assemblies: walls in running bond on a rigid base, pressed and pushed at the top, drawn by hypothesis, the same ones in
every run."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from quoin_tools.base.results import Results
from quoin_tools.mesh import blockmesh
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import split_triangles
from quoin_tools.mesh.walls import wall

QUOIN = os.environ.get("QUOIN", "build/quoin")
pytestmark = pytest.mark.skipif(not Path(QUOIN).exists(), reason="the solver is not built")
FRICTION, COHESION, TENSION, COMPRESSION = 35.0, 1e4, 5e3, 2e6
MODELS = ("pt", "r2pt", "r3pt", "t2pt", "t3pt", "tptm")
examples = settings(max_examples=3, deadline=None, derandomize=True, database=None, print_blob=False,
                    suppress_health_check=list(HealthCheck))  # fmt: skip


@st.composite
def assemblies(draw):
    """(mesh, scene): a wall whose stones are rigid, or deformable, of quadrilaterals or triangles."""
    rigid = draw(st.booleans())
    divide = (1, 1) if rigid else draw(st.sampled_from([(1, 1), (1, 2), (2, 1)]))
    mesh = wall(draw(st.integers(1, 3)), draw(st.integers(1, 4)), length=draw(st.floats(0.6, 2.0)), height=draw(st.floats(0.4, 1.0)),
                divide=divide, rigid=rigid)  # fmt: skip
    if not rigid and draw(st.booleans()):
        mesh = split_triangles(mesh, mesh.block_group == mesh.group_names.index("block"))
    pressure, lean = draw(st.floats(2e4, 2e5)), draw(st.floats(-0.2, 0.2))
    block = {"density": 2000.0} if rigid else {"density": 2000.0, "young": 5e9, "poisson": 0.2}
    scene = {
        "gravity": 0,
        "materials": {"block": block, "base": {"density": 0}},
        "joints": {"default": {"k_n": 1e10, "k_s": draw(st.sampled_from([1e9, 4e9, 1e10])), "stress_model": draw(st.sampled_from(MODELS)),
                               "friction": FRICTION, "cohesion": COHESION, "tension": TENSION, "compression": COMPRESSION}},
        "supports": {"base": {"fix": "xy"}},
        "loads": {"press": {"type": "traction", "faces": "top", "value": [lean * pressure, -pressure]}},
        "relaxation": {"ramp": 500, "tolerance": 1e-9},
        "stages": [{"press": {"loads": ["press"]}}],
    }  # fmt: skip
    return mesh, scene


def solve(mesh, scene, folder, ranks=1):
    """Last stage; None where the stage ended in a collapse, which it does in every version of the scene."""
    folder.mkdir(parents=True)
    blockmesh.write(folder / "model.h5", mesh)
    (folder / "scene.yaml").write_text(yaml.safe_dump({"model": "model.h5"} | scene, sort_keys=False), encoding="utf-8")
    start = ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"] if ranks > 1 else []
    done = subprocess.run([*start, QUOIN, "-options_file", "scene.yaml"], cwd=folder, capture_output=True, text=True, timeout=120,
                          env=os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"})  # fmt: skip
    assert done.returncode in (0, 6), done.stderr
    return Results(folder / "out") if done.returncode == 0 else None


SHORTEST = 0.3  # [m] face of a stone


def same(ours, expected, scale):
    """Rounding takes slipping joints along other paths, to equilibria that differ by a few millionths; and which of two
    faces gives a contact its direction depends on the run of the rings, so that forces turn by the angle between them."""
    largest = np.max(np.abs(scale))
    assert np.max(np.abs(ours - expected)) <= (1e-5 + 3 * largest / SHORTEST) * largest


def pair(first, second):
    """Displacements of two versions; None when both collapse."""
    assert (first is None) == (second is None)
    return None if first is None else (first.stage().displacement, second.stage().displacement)


def folders(tmp_path_factory):
    return tmp_path_factory.mktemp("assembly")


@examples
@given(assemblies(), st.floats(-180, 180))
def test_a_turned_scene_turns_the_result(tmp_path_factory, assembly, degrees):
    mesh, scene = assembly
    folder, angle = folders(tmp_path_factory), np.radians(degrees)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    value = turn @ scene["loads"]["press"]["value"]
    first = solve(mesh, scene, folder / "first")
    mesh.vertices = mesh.vertices @ turn.T
    scene["loads"]["press"]["value"] = [float(v) for v in value]
    u = pair(first, solve(mesh, scene, folder / "turned"))
    if u:
        same(u[1], u[0] @ turn.T, u[0])


def mirrored(mesh):
    """x -> -x: rings run the other way, and so do the numbers of their faces."""
    blocks, n = mesh.blocks.copy(), np.where(mesh.blocks[:, 3] < 0, 3, 4)
    for b, count in enumerate(n):
        blocks[b, :count] = mesh.blocks[b, [-k % count for k in range(count)]]
    sets = {name: np.column_stack([rows[:, 0], n[rows[:, 0]] - 1 - rows[:, 1]]) for name, rows in mesh.face_sets.items()}
    return BlockMesh(mesh.vertices * [-1, 1], blocks, mesh.block_group, mesh.group_names, mesh.group_rigid, sets, mesh.points)


@examples
@given(assemblies())
def test_a_mirrored_scene_mirrors_the_result(tmp_path_factory, assembly):
    mesh, scene = assembly
    folder = folders(tmp_path_factory)
    first = solve(mesh, scene, folder / "first")
    scene["loads"]["press"]["value"][0] *= -1
    u = pair(first, solve(mirrored(mesh), scene, folder / "mirrored"))
    if u:
        same(u[1], u[0] * [-1, 1], u[0])


def renumbered(mesh, seed):
    """The same mesh with vertices, blocks and the first vertex of each ring in another order; place of each vertex."""
    random = np.random.default_rng(seed)
    vertex, block = random.permutation(len(mesh.vertices)), random.permutation(len(mesh.blocks))
    blocks, n = np.full_like(mesh.blocks, -1), np.where(mesh.blocks[:, 3] < 0, 3, 4)
    shift = random.integers(0, n)
    for b, count in enumerate(n):
        blocks[block[b], :count] = np.roll(vertex[mesh.blocks[b, :count]], shift[b])
    group, vertices = np.empty_like(mesh.block_group), np.empty_like(mesh.vertices)
    group[block], vertices[vertex] = mesh.block_group, mesh.vertices
    sets = {name: np.column_stack([block[rows[:, 0]], (rows[:, 1] + shift[rows[:, 0]]) % n[rows[:, 0]]])
            for name, rows in mesh.face_sets.items()}  # fmt: skip
    points = {name: vertex[v] for name, v in mesh.points.items()}
    return BlockMesh(vertices, blocks, group, mesh.group_names, mesh.group_rigid, sets, points), vertex


@examples
@given(assemblies(), st.integers(0, 1000))
def test_numbers_of_the_file_do_not_matter(tmp_path_factory, assembly, seed):
    mesh, scene = assembly
    folder = folders(tmp_path_factory)
    other, place = renumbered(mesh, seed)
    u = pair(solve(mesh, scene, folder / "first"), solve(other, scene, folder / "renumbered"))
    if u:
        same(u[1][place], u[0], u[0])


@pytest.mark.alone
@examples
@given(assemblies(), st.integers(2, 3))
def test_the_partition_changes_no_bit(tmp_path_factory, assembly, ranks):
    mesh, scene = assembly
    folder = folders(tmp_path_factory)
    first, other = solve(mesh, scene, folder / "one"), solve(mesh, scene, folder / "more", min(ranks, len(mesh.blocks)))
    assert (first is None) == (other is None)
    if first:
        assert first.stage_summary("press")["checksum"] == other.stage_summary("press")["checksum"]


@examples
@given(assemblies())
def test_joints_stay_within_their_envelope_and_balance_the_load(tmp_path_factory, assembly):
    mesh, scene = assembly
    run = solve(mesh, scene, folders(tmp_path_factory) / "run")
    if run is None:
        return
    contacts = run.stage().contacts
    sigma, tau, slack = contacts.sigma, contacts.tau, 1e-6 * COMPRESSION
    assert np.all(sigma >= -COMPRESSION - slack) and np.all(sigma <= TENSION + slack)
    assert np.all(np.abs(tau) <= np.maximum(COHESION - sigma * np.tan(np.radians(FRICTION)), 0) + slack)
    # what the base carries is what presses on the top
    a, b = mesh.vertices[blockmesh.face_ends(mesh, mesh.face_sets["top"]).T]
    length = np.linalg.norm(b - a, axis=1).sum()
    base = mesh.block_group == mesh.group_names.index("base")
    on_base = base[contacts.face[:, 0]] | base[np.maximum(contacts.face[:, 2], 0)] & (contacts.face[:, 2] >= 0)
    vertical = np.sum(contacts.force[on_base, :, 0] * np.abs(contacts.normal[on_base, :, 1]))
    assert vertical == pytest.approx(scene["loads"]["press"]["value"][1] * length, rel=1e-6)


@examples
@given(assemblies(), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_contacts_make_no_momentum(tmp_path_factory, assembly, v_x, v_y):
    """Stones in free flight, each group with its own velocity, collide: their momentum stays."""
    mesh, scene = assembly
    rigid = bool(mesh.group_rigid[mesh.group_names.index("block")])
    scene["materials"]["base"] = {"density": 2500.0, "rigid": True, "velocity": [0.0, 0.1]}
    scene["materials"]["block"] |= {"velocity": [v_x, -abs(v_y)], "rigid": rigid}
    scene["loads"] = {"none": {"type": "self_weight"}}
    scene["relaxation"] = {"allow_floating": True}
    del scene["supports"]
    scene["stages"] = [{"fly": {"type": "dynamic", "loads": ["none"], "duration": 0.002, "dt_factor": 0.1}}]
    run = solve(mesh, scene, folders(tmp_path_factory) / "run")
    moved = run.stage().displacement
    # every vertex carries its share of its block's mass: the mass centre moves on evenly
    mass, weighted = 0.0, np.zeros(2)
    start = np.zeros(2)
    for b, row in enumerate(mesh.blocks):
        ring = row[row >= 0]
        name = mesh.group_names[mesh.block_group[b]]
        m = blockmesh.areas(mesh)[b] * scene["materials"][name]["density"]
        mass += m
        weighted += m * moved[ring].mean(axis=0)
        start += m * np.array(scene["materials"][name]["velocity"])
    assert np.allclose(weighted, start * 0.002, rtol=0, atol=1e-9 * mass)
