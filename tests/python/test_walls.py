"""Walls in running bond, arches, stepped slopes: areas, joints on both sides, names; and what the solver says of them."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
import yaml
from scipy.optimize import linprog

HERE = os.path.dirname(__file__)
ROOT = os.path.join(HERE, "..", "..")
sys.path.insert(0, os.path.join(ROOT, "tools"))

from quoin_tools.mesh import walls
from quoin_tools.mesh.blockmesh import areas, check, face_ends, outer_faces, read, write
from quoin_tools.show.plot_mesh import is_joint

QUOIN = os.environ.get("QUOIN", os.path.join(ROOT, "build", "quoin"))


def area(mesh, group):
    return areas(mesh)[mesh.block_group == mesh.group_names.index(group)].sum()


def faces_in_sets(mesh):
    return sorted(tuple(row) for rows in mesh.face_sets.values() for row in rows)


def directed(mesh, name):
    ends = mesh.vertices[face_ends(mesh, mesh.face_sets[name])].round(9) + 0.0  # no -0
    return {tuple(row) for row in ends.reshape(-1, 4).tolist()}


def lengths(mesh, name):
    return np.hypot(*np.diff(mesh.vertices[face_ends(mesh, mesh.face_sets[name])], axis=1)[:, 0].T)


# ---- wall ------------------------------------------------------------------------------------------------

@pytest.mark.parametrize("divide", [(1, 1), (2, 3)])
def test_wall(divide):
    """Six blocks in even courses, five and two halves in odd ones; both sides of all joints."""
    mesh = walls.wall(6, 8, divide=divide)
    component = check(mesh)
    stones = np.bincount(component, areas(mesh))[1:]
    assert len(stones) == 4 * 6 + 4 * 7
    assert np.sort(stones) == pytest.approx([0.25] * 8 + [0.5] * 44)
    assert area(mesh, "block") == pytest.approx(6 * 8 * 0.5, rel=1e-12)
    for name in ("joint_bed", "joint_head"):
        found = directed(mesh, name)
        assert found == {row[2:] + row[:2] for row in found}
    assert lengths(mesh, "joint_bed").sum() == pytest.approx(2 * 7 * 6)
    assert lengths(mesh, "joint_head").sum() == pytest.approx(2 * 0.5 * (4 * 5 + 4 * 6))
    assert is_joint(mesh, mesh.face_sets["joint_base"])
    base_ends = 2  # the free ends of the base are in no set
    assert len(faces_in_sets(mesh)) == len(outer_faces(mesh)) - base_ends == len(set(faces_in_sets(mesh)))
    assert mesh.vertices[mesh.points["top_right"]].tolist() == [6, 4]


def test_wall_with_openings():
    mesh = walls.wall(8, 8, openings=[(3, 6, 0, 4), (10, 13, 2, 5)])
    check(mesh)
    holes = 3 * 0.5 * (4 + 3) * 0.5
    assert area(mesh, "block") + area(mesh, "lintel") == pytest.approx(8 * 8 * 0.5 - holes, rel=1e-12)
    assert area(mesh, "lintel") == pytest.approx(2 * 5 * 0.5 * 0.5)
    door, window = 2 * 2 + 1.5, 2 * (1.5 + 1.5)
    assert lengths(mesh, "opening").sum() == pytest.approx(door + window)
    assert len(faces_in_sets(mesh)) == len(outer_faces(mesh)) - 2 == len(set(faces_in_sets(mesh)))


@pytest.mark.parametrize("opening", [(0, 2, 1, 3), (4, 12, 1, 3), (4, 6, 1, 8), (4, 4, 1, 3), (4, 6, 3, 3), (4, 6, -1, 3)])
def test_opening_out_of_the_wall(opening, tmp_path, capsys):
    arguments = ["wall", "-o", str(tmp_path / "a.h5"), "--opening", *map(str, opening)]
    assert walls.main(arguments) == 2
    assert "opening 0" in capsys.readouterr().err


@pytest.mark.parametrize("second", [(5, 7, 2, 4), (8, 10, 2, 4), (7, 9, 3, 5), (4, 8, 3, 5)])
def test_openings_that_touch(second):
    with pytest.raises(walls.MeshError, match="clear of the others"):
        walls.wall(8, 8, openings=[(4, 8, 1, 3), second])


# ---- arch ------------------------------------------------------------------------------------------------

@pytest.mark.parametrize("n, span, divide", [(21, 180.0, (1, 1)), (8, 120.0, (1, 1)), (9, 90.0, (2, 3)),
                                             (15, 230.0, (1, 2))])
def test_arch(n, span, divide):
    mesh = walls.arch(n, 10.0, 1.5, span, divide)
    assert check(mesh).max() + 1 == n + 2
    half = np.radians(span / n) / 2
    one = np.sin(half) * np.cos(half) * (11.5**2 - 10**2)  # a quadrilateral between two chords
    assert area(mesh, "voussoir") == pytest.approx(n * one, rel=1e-12)
    assert lengths(mesh, "joint").sum() == pytest.approx(2 * (n - 1) * 1.5)
    assert lengths(mesh, "joint_springing").sum() == pytest.approx(4 * 1.5)
    assert lengths(mesh, "intrados").sum() == pytest.approx(n * 20 * np.sin(half))
    found = directed(mesh, "joint")
    assert len(found) == len(mesh.face_sets["joint"]) and found == {row[2:] + row[:2] for row in found}
    left, right = (mesh.vertices[mesh.points[f"springing_{side}"]] for side in ("left", "right"))
    assert left == pytest.approx(right * [-1, 1], abs=1e-12)
    crown = mesh.vertices[mesh.points["crown_extrados"]]
    assert abs(crown[0]) <= 11.5 * np.sin(half) + 1e-9


# ---- slope -----------------------------------------------------------------------------------------------

def test_slope_of_goodman_and_bray():
    """Heights 4, 8 ... 40, then 33.8 ... 2.8 m; treads dip by 30 degrees; a riser behind all but the last column."""
    mesh = walls.slope()
    component = check(mesh)
    assert component.max() + 1 == 17
    heights = [4.0 * n for n in range(1, 11)] + [40 - 6.2 * n for n in range(1, 7)]
    assert np.bincount(component, areas(mesh))[1:] == pytest.approx(10 * np.array(heights), rel=1e-12)
    assert lengths(mesh, "joint_base").sum() == pytest.approx(16 * 10 * 2 + 15 * 1 + 10)
    assert lengths(mesh, "bottom").sum() == pytest.approx(15 * np.hypot(10, 1) + 20)
    tread = np.diff(mesh.vertices[face_ends(mesh, mesh.face_sets["joint_base"][-1:])][0], axis=0)[0]
    assert abs(np.degrees(np.arctan(tread[1] / tread[0]))) == pytest.approx(30.0)
    assert mesh.vertices[mesh.points["top_1"]][0] < mesh.vertices[mesh.points["toe"]][0]  # it leans outwards
    assert len(directed(mesh, "joint")) == 30


def test_slope_without_steps():
    """A plane base; blocks in a row on it."""
    mesh = walls.slope(5, 5, 1.0, 20.0, step=0.0, rise=0.8)
    assert check(mesh).max() == 5
    assert area(mesh, "block") == pytest.approx(0.8 * 15)
    assert (mesh.blocks[:, 3] >= 0).all()


# ---- command line and solver -----------------------------------------------------------------------------

@pytest.mark.parametrize("arguments", [["wall", "--opening", "4", "8", "1", "4"], ["arch"], ["slope", "--deformable"]])
def test_command_line(arguments, tmp_path):
    files = [tmp_path / name for name in ("a.h5", "b.h5")]
    for file in files:
        assert walls.main([*arguments, "-o", str(file)]) == 0
    assert files[0].read_bytes() == files[1].read_bytes()
    mesh = read(str(files[0]))
    check(mesh)
    free = [name for name, flag in zip(mesh.group_names, mesh.group_rigid) if not flag]
    assert free == (["block"] if "--deformable" in arguments else [])


@pytest.mark.parametrize("arguments", [["arch", "--voussoirs", "1"], ["arch", "--thickness", "-1"], ["wall", "--blocks", "0"],
                                       ["slope", "--crest", "20"], ["slope", "--fall", "9"], ["slope", "--tread-dip", "90"]])
def test_refused(arguments, tmp_path, capsys):
    assert walls.main([*arguments, "-o", str(tmp_path / "a.h5")]) == 2
    assert "expected" in capsys.readouterr().err


def relax(folder, mesh, held, friction):
    """Exit code and force on what is held, of rigid stones under their weight."""
    write(str(folder / "model.h5"), mesh)
    free = [name for name in mesh.group_names if name != held]
    scene = {"model": "model.h5", "relaxation": {"max_cycles": 200000},
             "materials": {name: {"density": 2500, "rigid": True} for name in mesh.group_names},
             "joints": {"default": {"k_n": 1e9, "k_s": 4e8, "friction": friction}}, "supports": {held: {"fix": "xy"}},
             "loads": {"weight": {"type": "self_weight", "groups": free}}, "stages": [{"weight": {"loads": ["weight"]}}]}
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False))
    done = subprocess.run(["mpirun", "-n", "1", "--oversubscribe", "--bind-to", "none", QUOIN, "-options_file",
                           "scene.yaml"], cwd=folder, capture_output=True, timeout=120)
    with open(folder / "out" / "summary.json", encoding="utf-8") as file:
        return done.returncode, json.load(file)["stages"][0]["reaction"]["y"]


@pytest.mark.skipif(not os.path.exists(QUOIN), reason="the program is not built")
@pytest.mark.parametrize("held, mesh, friction", [
    ("base", walls.wall(openings=[(4, 8, 1, 4)]), 35), ("abutment", walls.arch(thickness=1.5), 35),
    ("base", walls.slope(), 39.5)], ids=["wall", "arch", "slope"])
def test_stands(held, mesh, friction, tmp_path):
    code, force = relax(tmp_path, mesh, held, friction)
    weight = 2500 * 9.81 * (areas(mesh).sum() - area(mesh, held))
    assert code == 0 and force == pytest.approx(weight, rel=1e-4)


@pytest.mark.skipif(not os.path.exists(QUOIN), reason="the program is not built")
@pytest.mark.parametrize("held, mesh, friction", [("abutment", walls.arch(thickness=0.9), 35), ("base", walls.slope(), 37)],
                         ids=["arch", "slope"])
def test_falls(held, mesh, friction, tmp_path):
    """An arch thinner than 0.107 of its mean radius; columns with less than the 38.15 degrees of Goodman and Bray."""
    assert relax(tmp_path, mesh, held, friction)[0] in (3, 6)


def least_thrust(radius=10.0, thickness=1.5, voussoirs=21, unit_weight=2500 * 9.81):
    """[N] The least horizontal thrust with which a line of thrust stays within an arch that stands (Heyman), and its weight."""
    angles = np.linspace(0, np.pi, voussoirs + 1)
    ray = np.column_stack([np.cos(angles), np.sin(angles)])
    inside, outside = radius * ray, (radius + thickness) * ray
    area = 0.5 * np.sin(np.pi / voussoirs) * ((radius + thickness) ** 2 - radius**2)
    # centroid of each voussoir, from those of the two triangles of which it is the difference
    middle = (angles[1:] + angles[:-1]) / 2
    reach = 2 / 3 * np.cos(np.pi / voussoirs / 2) * ((radius + thickness) ** 3 - radius**3) / ((radius + thickness) ** 2 - radius**2)
    weights, arms = unit_weight * area * np.ones(voussoirs), reach * np.cos(middle)
    above, moment = np.append(0, np.cumsum(weights)), np.append(0, np.cumsum(weights * arms))
    # unknown H, V and the moment about the centre of the force on the first joint; at every joint it passes within
    rows, bounds = [], []
    for point, sign in ((inside, -1), (outside, 1)):
        rows.append(sign * np.column_stack([-point[:, 1], -point[:, 0], np.ones(voussoirs + 1)]))
        bounds.append(sign * (moment - point[:, 0] * above))
    found = linprog([1, 0, 0], np.concatenate(rows), np.concatenate(bounds), bounds=[(0, None), (None, None), (None, None)])
    assert found.status == 0
    return found.x[0], weights.sum()


@pytest.mark.skipif(not os.path.exists(QUOIN), reason="the program is not built")
def test_arch_that_spreads(tmp_path):
    """One abutment gives way by 40 mm: hinges form, and each support bears half the weight and the least thrust, within what the
    finite stiffness of the joints adds. A file of motion that ends in motion is reported."""
    mesh = walls.arch()
    assert [len(mesh.face_sets[name]) for name in ("bottom", "bottom_left", "bottom_right")] == [2, 1, 1]
    write(str(tmp_path / "model.h5"), mesh)
    (tmp_path / "spread.csv").write_text("0, 0, 0\n0.2, -0.05, 0\n0.8, -0.05, 0\n1.0, 0, 0\n")
    (tmp_path / "sudden.csv").write_text("0, 0, 0\n0.01, -0.05, 0\n")
    scene = {"model": "model.h5", "contact": {"connectivity": "variable", "tolerance": 0.002},
             "materials": {"voussoir": {"density": 2500}, "abutment": {"density": 2500}},
             "joints": {"default": {"k_n": 20e9, "k_s": 10e9, "friction": 40, "damping": 1e-4}},
             "supports": {"right": {"fix": "xy", "target": "bottom_right"},
                          "left": {"fix": "xy", "target": "bottom_left", "motion": "spread.csv"}},
             "loads": {"weight": {"type": "self_weight", "groups": ["voussoir"]}},
             "stages": [{"built": {"loads": ["weight"]}},
                        {"spread": {"type": "dynamic", "loads": ["weight"], "duration": 1.2, "alpha": 20, "dt_factor": 0.1}},
                        {"after": {"loads": ["weight"]}}]}  # fmt: skip
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False))

    def run(*options):
        done = subprocess.run([QUOIN, "-options_file", "scene.yaml", *options], cwd=tmp_path, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert "warning: supports.left.motion" not in run()
    built, _, after = json.loads((tmp_path / "out" / "summary.json").read_text())["stages"]
    thrust, weight = least_thrust()
    for stage in (built, after):
        left, right = stage["supports"]["left"], stage["supports"]["right"]
        assert left["x"] == pytest.approx(-right["x"], rel=1e-4) and left["x"] > 0  # inwards
        assert left["y"] == pytest.approx(weight / 2, rel=1e-4) and right["y"] == pytest.approx(weight / 2, rel=1e-4)
        for x in "xy":
            assert left[x] + right[x] == pytest.approx(stage["reaction"][x], abs=1e-6 * weight)
    assert 1.0 < after["supports"]["left"]["x"] / thrust < 1.04 < built["supports"]["left"]["x"] / thrust
    told = run("-supports_left_motion", "sudden.csv", "-stages", "built,spread", "-stages_spread_duration", "0.02")
    assert "warning: supports.left.motion: sudden.csv ends at 0.01 s with 0.05 m/s: the support stops there at once" in told
    assert "warning: supports.left.motion" not in run("-supports_left_motion", "sudden.csv", "-stages", "built,spread",
                                              "-stages_spread_duration", "0.01")
