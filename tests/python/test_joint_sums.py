"""Sums of the contact forces in results.h5, as docs/results_format.md has them, against the loads that they balance: faces
that match and that do not (FF1, FF2), corners on faces, fixed and variable connectivity. And values at the ends of a joint
that has slid."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
import yaml
from quoin_tools.base.results import Results
from quoin_tools.mesh import blockmesh, meshing
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import face_set_on, join

QUOIN = os.environ.get("QUOIN", "build/quoin")
pytestmark = pytest.mark.skipif(not Path(QUOIN).exists(), reason="the solver is not built")
G, RHO, PUSH = 9.81, 2000.0, 3e3
VERTEX_FACE = 4


def rectangle(*place, **kind):
    """Without names of its own."""
    return meshing.renamed(meshing.rectangle(*place, **kind), faces={}, points={})


def heap(corners):
    """A block on a wider base, one that overhangs it, a small one on that; with corners: a diamond between two blocks."""
    diamond = np.array([[5.3, 0.7], [5.3 + np.sqrt(0.5), 0.7 + np.sqrt(0.5)], [5.3, 0.7 + np.sqrt(2)], [5.3 - np.sqrt(0.5), 0.7 + np.sqrt(0.5)]])
    parts = [rectangle(-3.0, -1.0, 11.0, 1.0, nx=3, group="base", rigid=True), rectangle(0.0, 0.0, 2.0, 1.0, nx=2, ny=2, group="soft"),
             rectangle(0.7, 1.0, 2.0, 1.0, nx=2, group="stone", rigid=True), rectangle(1.2, 2.0, 0.6, 0.5, group="stone", rigid=True)]  # fmt: skip
    if corners:
        parts += [rectangle(4.0, 0.0, 1.0, 1.0, group="stone", rigid=True), rectangle(5.6, 0.0, 1.0, 1.0, group="stone", rigid=True),
                  BlockMesh(diamond, np.array([[0, 1, 2, 3]]), np.zeros(1), ["stone"], [1], {}, {})]  # fmt: skip
    mesh = join(parts)
    mesh.face_sets["side"] = face_set_on(mesh, (2.7, 1.0), (2.7, 2.0))
    return mesh


def solve(folder, mesh, scene, ranks=1):
    folder.mkdir(parents=True, exist_ok=True)
    blockmesh.write(folder / "model.h5", mesh)
    (folder / "scene.yaml").write_text(yaml.safe_dump({"model": "model.h5"} | scene, sort_keys=False), encoding="utf-8")
    start = ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"] if ranks > 1 else []
    done = subprocess.run([*start, QUOIN, "-options_file", "scene.yaml"], cwd=folder, capture_output=True, text=True, timeout=120,
                          env=os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"})  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return Results(folder / "out")


def heap_scene(variable, model):
    return {
        "strain": "large",
        "contact": {"connectivity": "variable" if variable else "fixed"},
        "materials": {"base": {"density": 0}, "soft": {"density": RHO, "young": 1e9, "poisson": 0.2}, "stone": {"density": RHO}},
        "joints": {"default": {"k_n": 1e9, "k_s": 5e8, "friction": 50, "stress_model": model}},
        "supports": {"base": {"fix": "xy"}},
        "loads": {"weight": {"type": "self_weight"}, "push": {"type": "traction", "faces": "side", "value": [-PUSH, 0.0]}},
        "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-8, "max_cycles": 100000, "allow_floating": True},
        "stages": [{"weight": {"loads": ["weight"]}}, {"push": {"loads": ["weight", "push"]}}],
    }


@pytest.mark.alone
@pytest.mark.parametrize("variable, model", [(False, "tptm"), (False, "pt"), (True, "tptm"), (True, "pt")])
def test_forces_of_contacts_balance_each_body(tmp_path, variable, model):
    mesh = heap(corners=variable)
    for ranks in (1, 2):
        results = solve(tmp_path / str(ranks), mesh, heap_scene(variable, model), ranks)
        body, area = results.mesh.macroblock, results.mesh.areas()
        names = np.array(results.mesh.group_names)[results.mesh.block_group]
        for name in ("weight", "push"):
            contacts = results.stage(name).contacts
            classes = set(contacts.klass)
            assert classes & {0, 1} and classes & {2, 3} and (VERTEX_FACE in classes) == variable
            moved = results.mesh.vertices + results.stage(name).displacement
            for number in np.unique(body[names != "base"]):
                blocks = np.flatnonzero(body == number)
                weight = RHO * G * area[blocks].sum()
                centre = (RHO * G * area[blocks]) @ moved[results.mesh.blocks[blocks]].mean(axis=1) / weight
                pushed = name == "push" and set(np.unique(results.mesh.blocks[blocks])) & set(mesh.blocks[mesh.face_sets["side"][:, 0]].ravel())
                loads = np.array([-PUSH if pushed else 0.0, -weight, -weight * centre[0] + (1.5 * PUSH if pushed else 0.0)])
                assert contacts.on_body(number) == pytest.approx(-loads, abs=2e-4 * weight), (ranks, name, number)
            reaction = results.stage_summary(name)["reaction"]
            ground = sum(contacts.on_body(number) for number in np.unique(body[names == "base"]))
            assert ground[:2] == pytest.approx([-reaction["x"], -reaction["y"]], abs=1e-3 * RHO)


def test_normal_leads_from_b_to_a(tmp_path):
    results = solve(tmp_path, heap(corners=True), heap_scene(True, "tptm"))
    contacts, mesh = results.stage("weight").contacts, results.mesh
    centre = np.array([mesh.centres()[mesh.macroblock == number].mean(axis=0) for number in range(mesh.macroblock.max() + 1)])
    from_b = centre[contacts.macroblock[:, 0]] - centre[contacts.macroblock[:, 1]]
    assert len(contacts) >= 8 and (np.einsum("nkx,nx->nk", contacts.normal, from_b) > 0).all()
    assert np.abs(contacts.normal[:, 0] - contacts.normal[:, 1]).max() < 1e-3  # both ends alike


def test_ends_of_a_joint_are_no_slivers(tmp_path):
    """A block that was pushed by 15 mm along faces of a metre has a contact as long with the next face, which lies 0.2 mm
    lower and bears nothing. The stress at the end is that of the face which bears the weight."""
    mesh = join([rectangle(0.0, -1.0, 3.0, 1.0, nx=3, group="base", rigid=True), rectangle(3.0, -1.0, 1.0, 1.0 - 2e-4, group="base", rigid=True),
                 rectangle(1.0, 0.0, 2.0, 1.0, nx=2, group="stone", rigid=True)])  # fmt: skip
    mesh.face_sets["side"], mesh.face_sets["joint"] = face_set_on(mesh, (1.0, 0.0), (1.0, 1.0)), face_set_on(mesh, (0.0, 0.0), (4.0, 0.0), 1e-3)
    scene = heap_scene(True, "tptm")
    scene["materials"].pop("soft")
    scene["joints"] = {"default": {"k_n": 1e9, "k_s": 5e5, "friction": 50}, "joint": {}}
    scene["contact"]["tolerance"] = 0.002
    scene["loads"]["push"]["value"] = [15e3, 0.0]  # on 2 m of 0.5 MPa/m
    scene["stages"] = [{"weight": {"loads": ["weight"]}}, {"push": {"loads": ["weight", "push"], "ramp": 3000}}]
    results = solve(tmp_path, mesh, scene)
    contacts, joint = results.stage("push").contacts, results.stage_summary("push")["joints"]["joint"]
    sliver = contacts.length.argmin()
    assert 5e-3 < contacts.length[sliver] < 16e-3 and (contacts.sigma[sliver] == 0).all()
    assert joint["end"]["x"] == pytest.approx(3.0, abs=0.02) and joint["N"] == pytest.approx(2 * RHO * G, rel=1e-4)
    linear = joint["sigma_linear_start"], joint["sigma_linear_end"]
    assert [joint[end]["sigma"] for end in ("start", "end")] == pytest.approx(linear, rel=0.05)


def test_a_sliver_is_no_stress_of_its_joint(tmp_path):
    """A block pushed by 15 mm along faces of a metre meets a kink of 5 %: 15 mm of contact with five times the stress of the joint.
    sigma_min is what it bears over a tenth of a metre, and so is the compression of the sheet."""
    slope = BlockMesh(np.array([[3.0, -1.0], [4.0, -1.0], [4.0, 0.05], [3.0, 0.0]]), np.array([[0, 1, 2, 3]]), np.zeros(1), ["base"], [1], {}, {})
    mesh = join([rectangle(0.0, -1.0, 3.0, 1.0, nx=3, group="base", rigid=True), slope, rectangle(1.0, 0.0, 2.0, 1.0, nx=2, group="stone", rigid=True)])  # fmt: skip
    mesh.face_sets["side"], mesh.face_sets["joint"] = face_set_on(mesh, (1.0, 0.0), (1.0, 1.0)), face_set_on(mesh, (0.0, 0.0), (4.0, 0.0), 1e-3)
    mesh.face_sets["joint"] = np.vstack([mesh.face_sets["joint"], face_set_on(mesh, (3.0, 0.0), (4.0, 0.05), 1e-3)])
    scene = heap_scene(True, "tptm")
    scene["materials"].pop("soft")
    scene["joints"] = {"default": {"k_n": 1e9, "k_s": 5e5, "friction": 50}, "joint": {}}
    scene["contact"]["tolerance"] = 0.002
    scene["loads"]["push"]["value"] = [17e3, 0.0]
    scene["stages"] = [{"weight": {"loads": ["weight"]}}, {"push": {"loads": ["weight", "push"], "ramp": 3000}}]
    results = solve(tmp_path, mesh, scene)
    contacts, joint = results.stage("push").contacts, results.stage_summary("push")["joints"]["joint"]
    long = contacts.length > 0.1
    steep = contacts.sigma.min(axis=1).argmin()
    assert 5e-3 < contacts.length[steep] < 16e-3 and contacts.sigma[steep].min() < 10 * contacts.sigma[long].min()
    over = contacts.sigma[steep].min() * contacts.length[steep] / 0.1
    assert joint["sigma_min"]["sigma"] == pytest.approx(over, rel=1e-3)
    assert joint["sigma_max"]["sigma"] == contacts.sigma[contacts.joint == results.mesh.joint_names.index("joint")].max()
    mean = -contacts.force[steep, :, 0].sum() / 0.1
    assert mean < -joint["sigma_min"]["sigma"] < 2 * mean  # a line from its peak to no less than 0
    assert results.mesh.control(contacts)[[steep, contacts.length.argmax()]] == pytest.approx([contacts.length[steep] / 0.1, 1.0])
