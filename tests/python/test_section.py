"""Sections declared in YAML: what is meshed against the generator of the same dam and against areas and lengths by hand; every mistake one line."""

import math
import os
import re
import subprocess
import typing
from pathlib import Path

import numpy as np
import pytest
import quoin
from quoin_tools.assess import assessment_options
from quoin_tools.base import scene, units
from quoin_tools.base.results import Results
from quoin_tools.front import importing
from quoin_tools.limit.assembly import joint_order
from quoin_tools.mesh import blockmesh, section
from quoin_tools.mesh.blockmesh import areas, check, face_ends, macroblocks, read, write
from quoin_tools.mesh.dam import dam_mesh
from quoin_tools.mesh.declared import DeclaredError

pytest.importorskip("gmsh")
ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
G1 = ROOT / "examples/guilhofrei/section.yaml"

SMALL = """\
size: 2
dam:
  upstream: [[0, 0], {to: 10, batter: 0.1}]
  downstream: [[9, 0], {to: 10, batter: 0.5}]
  galleries: {gallery: {floor: [3, 2], width: 1, height: 2}}
  lifts: [6]
rock:
  upstream: 20
  downstream: 20
  depth: 15
  seams: {seam: {through: [0, -3], dip: 10}}
points: {probe: [4, 8]}
"""


def declared(folder, text=SMALL):
    path = folder / "section.yaml"
    path.write_text(text)
    return path


def meshed(folder, text=SMALL):
    return section.mesh_of(declared(folder, text))[0]


def lengths(mesh):
    """Of every face set [m]; a joint has both of its sides."""
    ends = {name: mesh.vertices[face_ends(mesh, rows)] for name, rows in mesh.face_sets.items()}
    return {name: float(np.hypot(*(xy[:, 1] - xy[:, 0]).T).sum()) for name, xy in ends.items()}


def group_areas(mesh):
    return {name: float(areas(mesh)[mesh.block_group == row].sum()) for row, name in enumerate(mesh.group_names)}


def test_guilhofrei_is_the_dam_of_the_generator():
    """Groups, face sets and points have the names, areas, lengths and places of mesh/dam.py."""
    mesh, known = section.mesh_of(G1)[0], dam_mesh(columns=24)
    assert group_areas(mesh) == pytest.approx(group_areas(known), rel=1e-9)
    assert lengths(mesh) == pytest.approx(lengths(known), rel=1e-9)
    places = [{name: tuple(m.vertices[vertex].round(9)) for name, vertex in m.points.items()} for m in (mesh, known)]
    assert places[0] == places[1]
    assert len(mesh.face_sets["base"]) == 2 * 24  # columns


def test_guilhofrei_moves_as_on_the_mesh_of_the_generator(tmp_path):
    """Crest displacements within 1.2 % of those of the mesh of twice as many blocks, forces within 1e-4."""
    found = {}
    for name, mesh in (("section", section.mesh_of(G1)[0]), ("dam", dam_mesh(columns=24))):
        write(tmp_path / f"{name}.h5", mesh)
        run = [QUOIN, "-options_file", ROOT / "examples/guilhofrei/scene.yaml", "-model", tmp_path / f"{name}.h5", "-output", tmp_path / name]
        subprocess.run(run, check=True, stdout=subprocess.DEVNULL)
        results = Results(tmp_path / name)
        found[name] = [results.stage_summary(stage) for stage in ("hp", "sw", "swhp")]
    for one, other in zip(found["section"], found["dam"]):
        crest = [stage["probes"]["crest_upstream"]["u_x"] for stage in (one, other)]
        assert crest[0] == pytest.approx(crest[1], rel=0.012)
        assert one["joints"]["base"]["N"] == pytest.approx(other["joints"]["base"]["N"], rel=3e-4, abs=1e3)


def test_gallery_lift_and_seam(tmp_path):
    mesh = meshed(tmp_path)
    check(mesh)

    assert group_areas(mesh) == pytest.approx({"dam": (9 + 3) / 2 * 10 - 2, "rock": 49 * 15}, rel=1e-9)
    assert macroblocks(mesh).max() + 1 == 4  # the dam below and above its lift, the rock above and below the seam
    seam = 20 + 29 - (20 - 3 / np.tan(np.radians(10)))  # it begins where it comes up
    expected = {"gallery": 6, "lift": 10.8, "lift_1": 10.8, "base": 18, "upstream": np.hypot(10, 1), "downstream": np.hypot(10, 5), "crest": 3,
                "seam": 2 * seam / np.cos(np.radians(10)), "rock_bottom": 49, "rock_sides": 30, "rock_top_upstream": 20, "rock_top_downstream": 20}  # fmt: skip
    assert lengths(mesh) == pytest.approx(expected, rel=1e-6)
    assert mesh.vertices[mesh.points["probe"]].tolist() == pytest.approx([4, 8])
    of_dam = mesh.blocks[mesh.block_group == mesh.group_names.index("dam")]
    assert mesh.points["heel"] in of_dam and mesh.points["rock_heel"] not in of_dam


def test_arched_gallery_and_several_elevations(tmp_path):
    text = SMALL.replace("height: 2}", "height: 2, arch: true}").replace("lifts: [6]", "lifts: {from: 5, spacing: 2}")
    mesh = meshed(tmp_path, text)
    arch = 16 / 2 * 0.25 * np.sin(np.pi / 16)  # 16 chords of a half circle of 0.5 m
    assert group_areas(mesh)["dam"] == pytest.approx(60 - (1.5 + arch), rel=1e-9)
    assert sorted(name for name in mesh.face_sets if name.startswith("lift")) == ["lift", "lift_1", "lift_2", "lift_3"]
    assert lengths(mesh)["lift_2"] == pytest.approx(2 * (9 - 0.6 * 7))


@pytest.mark.parametrize("level, length", [(2, 9 - 0.6 * 2 - 1), (3, 9 - 0.6 * 3 - 1), (4, 9 - 0.6 * 4 - 1)])
def test_lift_at_the_floor_the_middle_and_the_roof_of_a_gallery(tmp_path, level, length):
    mesh = meshed(tmp_path, SMALL.replace("lifts: [6]", f"lifts: [{level}]"))
    assert lengths(mesh)["lift"] == pytest.approx(2 * length) and macroblocks(mesh).max() + 1 == 4


def test_joint_that_ends_inside(tmp_path):
    """A crack from the heel: its end stays closed, so the dam stays one body."""
    mesh = meshed(tmp_path, SMALL.replace("lifts: [6]", "").replace("points:", "joints: {crack: [[0.5, 5], [4, 5]]}\npoints:"))
    assert lengths(mesh)["crack"] == pytest.approx(7) and macroblocks(mesh).max() + 1 == 3


def test_triangles_table_and_no_rock(tmp_path):
    """Points in a CSV file; without rock the base is a face set of the outline."""
    (tmp_path / "down.csv").write_text("x [m], y [m]\n9, 0\n# the break\n4, 8\n3, 10\n")
    text = "columns: 5\nelements: triangles\ndam: {upstream: [[0, 0], [0, 10]], downstream: down.csv, rigid: true}\n"
    mesh = meshed(tmp_path, text)
    assert (mesh.blocks[:, 3] < 0).all() and mesh.group_rigid.tolist() == [1]
    assert group_areas(mesh) == pytest.approx({"dam": (9 + 4) / 2 * 8 + (4 + 3) / 2 * 2})
    assert lengths(mesh)["base"] == pytest.approx(9) and len(mesh.face_sets["base"]) == 5


def test_base_in_steps_and_ground_that_rises(tmp_path):
    text = ("size: 1\ndam: {upstream: [[0, 0], [0, 10]], base: [[3, 0], [3, 1]], downstream: [[9, 1], [3, 10]]}\n"
            "rock: {upstream: 10, downstream: 10, depth: 10, ground_downstream: [[12, 3]]}\n")  # fmt: skip
    mesh = meshed(tmp_path, text)
    assert lengths(mesh)["base"] == pytest.approx(2 * 10)
    assert lengths(mesh)["rock_top_downstream"] == pytest.approx(np.hypot(3, 2) + 7)
    assert group_areas(mesh)["rock"] == pytest.approx(29 * 10 + 6 + (1 + 3) / 2 * 3 + 7 * 3)


def test_the_same_section_gives_the_same_bytes(tmp_path):
    written = []
    for i in range(2):
        assert section.main([str(declared(tmp_path)), "-o", str(tmp_path / f"{i}.h5")]) == 0
        written.append((tmp_path / f"{i}.h5").read_bytes())
    assert written[0] == written[1]
    assert blockmesh.main(["check", str(tmp_path / "0.h5")]) == 0
    assert read(tmp_path / "0.h5").points


BAD = [  # what is put in for what, the place that is named, words of the reason
    ("size: 2", "size: -2", ":1: size: -2: expected a number [m] above 0"),
    ("size: 2", "", "expected size or columns"),
    ("size: 2", "size: 2\ncolumns: 3", ":2: columns: expected only one of size or columns"),
    ("size: 2", "size: 0.001", "about 6e+07 blocks, expected at most 2e+06"),
    ("{to: 10, batter: 0.1}", "{to: 10, slope: 0.1}", ":3: dam.upstream.1: {'to': 10, 'slope': 0.1}: expected [x, y], or behind"),
    ("[[0, 0], {to: 10, batter: 0.1}]", "[[0, 0]]", ":3: dam.upstream: [[0, 0]]: expected a list of at least 2 points"),
    ("[[0, 0], {to: 10, batter: 0.1}]", "face.csv", ":3: dam.upstream: face.csv: cannot be read (No such file or directory)"),
    ("  downstream: [[9, 0], {to: 10, batter: 0.5}]\n", "", "dam: 'downstream' is missing, expected a list of at least 2 points"),
    ("[[9, 0], {to: 10, batter: 0.5}]", "[[-9, 0], [3, 10]]", ":4: dam.downstream: (-9.0, 0.0): begins at the toe: expected right of the heel"),
    ("[[9, 0], {to: 10, batter: 0.5}]", "[[9, 0], [-1, 5], [4, 10]]", "dam.upstream: upstream, downstream and base cross each other (Self-intersection["),
    ("width: 1", "width: wide", ":5: dam.galleries.gallery.width: wide: expected a number [m] above 0"),
    ("width: 1", "width: 1, arched: true", ":5: dam.galleries.gallery.arched: unknown key, expected arch, floor, height, size, width"),
    ("floor: [3, 2]", "floor: [0.5, 2]", ":5: dam.galleries.gallery: expected inside the dam, clear of its faces"),
    ("height: 2}", "height: 0.4, arch: true}", "dam.galleries.gallery.height: 0.4: expected at least half the width, 0.5"),
    ("{gallery:", "{2nd:", "dam.galleries.2nd: 2nd: a name is a letter, then"),
    ("lifts: [6]", "lifts: [60]", ":6: dam.lifts: 60.0: expected elevations between base and crest, above 0 and below 10"),
    ("lifts: [6]", "lifts: [6, 6]", ":6: dam.lifts: [6.0, 6.0]: expected at least one elevation, each above the one before"),
    ("lifts: [6]", "lifts: {from: 2}", ":6: dam.lifts: 'spacing' is missing, expected a number [m] above 0"),
    ("depth: 15", "depth: deep", ":10: rock.depth: deep: expected a number [m] above 0"),
    ("depth: 15", "depth: 1e300", ":10: rock.depth: 1e+300: expected a number [m] above 0, of the size of a dam or a stone"),
    ("width: 1", "width: 1e-300", ":5: dam.galleries.gallery.width: 1e-300: expected a number [m] above 0, of the size"),
    ("through: [0, -3]", "through: [0, 1e300]", ":11: rock.seams.seam.through: [0, 1e+300]: expected a point [x, y], in m"),
    ("[[0, 0], {to: 10, batter: 0.1}]", "[[0, 0], [0, 0]]", ":3: dam.upstream: (0.0, 0.0): ends at the crest: expected above heel and toe"),
    ("depth: 15", "deep: 15", ":10: rock.deep: unknown key"),
    ("depth: 15", "ground_upstream: [[3, 1]]", ":7: rock: ground and dam overlap at ("),
    ("depth: 15", "ground_upstream: [[-1, 20], [-20, 0]]", ":10: rock.ground_upstream: (-20.0, 0.0): expected within the rock, x more than -"),
    ("through: [0, -3]", "through: [0, -300]", ":11: rock.seams.seam: its line does not meet the rock"),
    (", dip: 10", ", dip: 100", ":11: rock.seams.seam.dip: 100: expected a number [degree] above -90 and at most 90"),
    ("{through: [0, -3], dip: 10}", "{points: [[0, -3], [300, -3]]}", ":11: rock.seams.seam.points: expected inside the rock"),
    ("{seam:", "{base:", None),  # a seam of this name goes with the base
    ("{seam:", "{upstream:", "'upstream' names two things, each needs a name of its own"),
    ("probe: [4, 8]", "probe: [40, 8]", ":12: points.probe: [40, 8]: expected inside a group"),
    ("probe: [4, 8]", "heel: [4, 8]", ":12: points.heel: a point that has this name already is there"),
    ("probe: [4, 8]", "probe: 4", ":12: points.probe: 4: expected a point [x, y], in m"),
    ("points:", "faces: {belt: [[4, 0], [4, 3]]}\npoints:", "faces 'belt': from (4, 0) to (4, 3) it runs inside a group"),
    ("points:", "joints: {crack: [[-9, 5], [-2, 5]]}\npoints:", "joint 'crack': from (-9, 5) to (-2, 5) it lies outside all groups"),
    ("points:", "joints: {crack: [[0, 0], [1, 10]]}\npoints:", "joint 'crack': lies on the outline, from (0, 0) to (1, 10)"),
    ("lifts: [6]", "lifts: [6]\n  lifts: [7]", ":7: dam.lifts: given twice"),
    ("size: 2", "size: 2\nscale: 3", ":2: scale: unknown key, expected columns, dam, drains,"),
    ("size: 2", "size: [2", "not YAML: "),
]


@pytest.mark.parametrize("old, new, reason", BAD, ids=range(len(BAD)))
def test_a_mistake_is_one_line(tmp_path, capsys, old, new, reason):
    assert SMALL.count(old) == 1
    path = declared(tmp_path, SMALL.replace(old, new))
    code = section.main([str(path), "-o", str(tmp_path / "no.h5")])
    said = capsys.readouterr().err.strip()
    if reason is None:
        assert code == 0, said
        return
    assert code == 2 and not (tmp_path / "no.h5").exists()
    assert said.count("\n") == 0 and said.startswith(str(path)) and reason in said, said


def test_each_mistake_has_its_line(tmp_path):
    text = SMALL.replace("size: 2", "size: big").replace("width: 1", "width: 0").replace("depth: 15", "depth: -1").replace("probe: [4, 8]", "probe: []")
    with pytest.raises(DeclaredError) as raised:
        section.load(declared(tmp_path, text))
    assert [re.search(r":(\d+): ([\w.]+)", line).groups() for line in raised.value.faults] == [
        ("1", "size"), ("5", "dam.galleries.gallery.width"), ("10", "rock.depth"), ("12", "points.probe")]  # fmt: skip


def test_a_sharp_corner_is_told_with_its_place(tmp_path, capsys):
    """The ground ends 0.2 m above a seam that it does not reach."""
    text = "columns: 6\ndam: {upstream: [[0, 0], [0, 10]], downstream: [[8, 0], {to: 10, batter: 0.7}]}\nrock:\n  ground_downstream: [[12, 0], [14, -4]]\n  seams: {seam: {through: [14, -4.2], dip: 5}}\n"
    assert section.main([str(declared(tmp_path, text)), "-o", str(tmp_path / "m.h5")]) == 0
    said = re.search(r"at \((\S+), (\S+)\) a block has a corner of (\S+) degrees", capsys.readouterr().err)
    x, y, angle = map(float, said.groups())
    assert np.hypot(x - 14, y + 4.1) < 2.5 and angle < 10  # beside the foot of the slope, where 0.2 m are left above the seam


def test_no_file(tmp_path):
    with pytest.raises(DeclaredError, match="no.yaml: No such file or directory"):
        section.load(tmp_path / "no.yaml")


def test_import_takes_sections_and_meshes_of_gmsh(tmp_path, capsys):
    """What `quoin import` calls."""
    assert importing.main([str(declared(tmp_path)), "-o", str(tmp_path / "m.h5")]) == 0 and read(tmp_path / "m.h5").points
    assert importing.main([str(tmp_path / "no.msh"), "-o", str(tmp_path / "n.h5")]) == 2
    assert "no.msh: No such file" in capsys.readouterr().err


LIFTED = """\
size: 3
dam: {upstream: [[0, 0], {to: 24, batter: 0}], downstream: [[20, 0], {to: 20, batter: 0.75}, {to: 24, batter: 0}], lifts: [6, 12, 18]}
rock: {upstream: 20, downstream: 20, depth: 15, size: 8}
"""


@pytest.mark.skipif(not QUOIN.exists(), reason="the solver is not built")
def test_the_row_of_one_lift_counts_wherever_it_stands(tmp_path):
    """The draft has one row of all lifts. A row of lift_3 has its contacts before and behind that row, on one rank and on two; above it stand (6.5 + 5) / 2 x 2 + 5 x 4 m2 of masonry."""
    assert section.main([str(declared(tmp_path, LIFTED)), "-o", str(tmp_path / "m.h5"), "--scene", str(tmp_path / "draft.yaml")]) == 0
    text = (tmp_path / "draft.yaml").read_text()
    row = next(line for line in text.splitlines() if line.startswith("  lift: "))
    assert "lift_1 to lift_3 are parts of it" in row and "\n  lift_" not in text
    for name, rows, ranks in (("behind", f"{row}\n  lift_3: {{friction: 5}}", 1), ("before", f"  lift_3: {{friction: 5}}\n{row}", 2)):
        (tmp_path / f"{name}.yaml").write_text(text.replace(row, rows))
        command = [*(["mpirun", "-n", str(ranks)] if ranks > 1 else []), QUOIN, "-options_file", tmp_path / f"{name}.yaml", "-output", tmp_path / name]
        assert subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False).returncode == 6  # it slides there
        joints = Results(tmp_path / name).stage_summary("weight")["joints"]
        assert joints["lift_3"]["N"] == pytest.approx(2400 * 9.81 * 31.5, rel=1e-5) and joints["lift"]["length"] == pytest.approx(15.5 + 11)
    order = joint_order(read(tmp_path / "m.h5"), scene.read(tmp_path / "behind.yaml"))
    assert order.index("lift_3") < order.index("lift")


@pytest.mark.skipif(not QUOIN.exists(), reason="the solver is not built")
@pytest.mark.parametrize(
    "rows, said",
    [
        ("lift_1: {friction: 9}\n  lift_2: {friction: 9}\n  lift_3: {friction: 9}", "joints.lift: no contact has this row: all contacts on its face set have the rows lift_1, lift_2, lift_3: "),
        ("upstream: {friction: 9}", "joints.upstream: no contact has this row: on its face set no two bodies touch: "),
        ("dam+rock: {friction: 9}", "joints.dam+rock: no contact has this row: all contacts between these groups have the rows base: "),
    ],
)
def test_a_row_of_joints_without_a_contact_is_refused(tmp_path, rows, said):
    assert section.main([str(declared(tmp_path, LIFTED)), "-o", str(tmp_path / "m.h5"), "--scene", str(tmp_path / "draft.yaml")]) == 0
    text = (tmp_path / "draft.yaml").read_text().replace("\nsupports:", f"\n  {rows}\nsupports:")
    (tmp_path / "s.yaml").write_text(text)
    done = subprocess.run([QUOIN, "-options_file", tmp_path / "s.yaml", "-output", tmp_path / "out"], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and said in done.stderr and "expected one contact at least" in done.stderr
    variable = ["-contact_connectivity", "variable", "-joints_upstream_friction", "9"]  # these faces may come to touch
    if "upstream" in rows:
        assert subprocess.run([QUOIN, "-options_file", tmp_path / "s.yaml", *variable, "-advise", "0.5"], stdout=subprocess.DEVNULL, check=False).returncode == 0


# ---- numbers with units, texts that would never end ------------------------------------------------------

def test_units_are_those_of_the_solver():
    """The table of src/scene/units.c, row by row."""
    text = (Path(__file__).resolve().parents[2] / "src" / "scene" / "units.c").read_text(encoding="utf-8")
    rows = re.findall(r'\{"([^"]+)", "([^"]+)", (-?\d+), ([^}]+)\}', text)
    value = {"WEIGHT": units.WEIGHT, "180. / PETSC_PI": 180 / math.pi, "1. / 3.6": 1 / 3.6}
    found = [(name, of, int(power), value.get(factor) or float(factor)) for name, of, power, factor in rows]
    assert sorted(found) == sorted((name, of, power, factor) for of, group in units.TABLE.items() for name, power, factor in group) and len(found) > 60


@pytest.mark.parametrize("text, unit, value", [
    ("12 MPa", "Pa", 12e6), ("12MPa", "Pa", 12e6), ("1.8 m", "m", 1.8), ("180 cm", "m", 1.8), ("3e2 mm", "m", 0.3), ("24 kN/m3", "kg/m3", 24e3 / 9.81), ("45 %", "-", 0.45),
    ("0.5 rad", "degree", 90 / math.pi), ("12 gpa", "Pa", "12 gpa"), ("1.8 m", "Pa", "1.8 m"), ("m", "m", "m"), (1.8, "m", 1.8), ("1,8 m", "m", "1,8 m"),
])  # fmt: skip
def test_numbers_with_units(text, unit, value):
    assert units.quantity(text, unit) == value


def test_a_section_with_units(tmp_path):
    rows = "size: {}\ndam: {{upstream: [[0, 0], [{}, {}]], downstream: [[8, 0], [2, 10]], lifts: [{}]}}\n"
    plain, with_units = tmp_path / "a.yaml", tmp_path / "b.yaml"
    plain.write_text(rows.format("1.8", "0.5", "10", "5"))
    with_units.write_text(rows.format("1.8 m", "50 cm", "0.01 km", "5000mm"))
    one, two = section.mesh_of(plain)[0], section.mesh_of(with_units)[0]
    assert np.array_equal(one.vertices, two.vertices) and np.array_equal(one.blocks, two.blocks)
    with_units.write_text(rows.format("1.8 kPa", "50 cm", "10", "5"))
    with pytest.raises(section.DeclaredError, match=r":1: size: 1.8 kPa: expected a number \[m\] above 0, or with a unit: m, um, mm, cm, km"):
        section.load(with_units)


def test_strengths_with_units():
    given = assessment_options.parser("report", "").parse_args(["out", "--strength", "12 MPa", "--strength-on", "base=45 deg,0.2 MPa", "--drain", "250 cm"])
    assert (given.strength, given.strength_on, given.drain) == (12e6, [("base", {"friction": 45, "cohesion": 0.2e6, "friction_residual": 45, "cohesion_residual": 0})], 2.5)


@pytest.mark.parametrize("text, reason", [
    ("size: " + 200_000 * "[", ":1: not YAML: nested more than 100 deep"),
    ("a: " + 100_000 * "{a: " + "1" + 100_000 * "}", ":1: not YAML: nested more than 100 deep"),
    ("size: " + 5000 * "9", ":1: not YAML that can be read: a number of 5000 digits, expected at most 200"),
    ("size: 0x" + 5000 * "f", ":1: not YAML that can be read: a number of 5002 digits, expected at most 200"),
    ("size: 2001-99-99", ":1: not YAML that can be read: '2001-99-99' is no value (month must be in 1..12)"),
    ("size: !!int a", ":1: not YAML that can be read: 'a' is no value ("),
    ("".join(f"k{i}: 1\n" for i in range(600)), ":500: not YAML: more than 1000 keys and values"),
], ids=range(7))  # fmt: skip
def test_texts_that_would_never_end(tmp_path, monkeypatch, text, reason):
    monkeypatch.setattr(scene, "MOST_NODES", 1000)  # of 100000 each reader needs 2 s
    (tmp_path / "dam.yaml").write_text(text)
    with pytest.raises(section.DeclaredError) as raised:
        section.load(tmp_path / "dam.yaml")
    assert len(raised.value.faults) == 1 and reason in raised.value.faults[0]
    with pytest.raises(scene.SceneError) as raised:
        scene.read(tmp_path / "dam.yaml")
    assert "\n" not in str(raised.value)


def test_files_of_another_kind(tmp_path):
    for name, reason in (("a.inp", "is a mesh of another program, which `meshio convert` may turn into .msh"), ("a.dwg", "is a drawing that only its own program reads"), ("/dev/zero", "not a file of up to 16777216 bytes")):
        with pytest.raises(section.DeclaredError, match=re.escape(reason)):
            section.mesh_of(name)


def test_meshes_from_python(tmp_path):
    """quoin.mesh() gives what the command writes; dir() shows what there is."""
    (tmp_path / "dam.yaml").write_text("size: 2\ndam: {upstream: [[0, 0], [0, 10]], downstream: [[8, 0], [2, 10]]}\n")
    made = quoin.mesh(tmp_path / "dam.yaml", tmp_path / "m.h5")
    assert blockmesh.read(str(tmp_path / "m.h5")).vertices == pytest.approx(made.vertices) and areas(made).sum() == pytest.approx(50)
    assert {"run", "mesh", "Results", "RunError", "MeshError"} <= set(dir(quoin))
    assert "return" in typing.get_type_hints(quoin.run) and "unit" in typing.get_type_hints(quoin.mesh)
    with pytest.raises(quoin.MeshError, match="interfaces, rigid and unit are of a mesh of Gmsh"):
        quoin.mesh(tmp_path / "dam.yaml", unit="mm")


@pytest.mark.parametrize("turned", [1, -1])
@pytest.mark.parametrize("miss", [0.0004, 0.001, -0.0004])
def test_rounded_coordinates_meet(tmp_path, turned, miss):
    """A joint whose ends miss the faces of a dam of 30 m by less than 2 mm (a thousandth of its blocks) cuts it in two, and a point beside a face is on it; both are reported."""
    def xy(x, y):
        return f"[{turned * x}, {y}]"

    left, right = [(0, 0), (3, 30)], [(20, 0), (8, 30)]
    left, right = (left, right) if turned > 0 else (right, left)
    (tmp_path / "dam.yaml").write_text(f"""size: 2
dam: {{upstream: [{xy(*left[0])}, {xy(*left[1])}], downstream: [{xy(*right[0])}, {xy(*right[1])}]}}
joints: {{crack: [{xy(1 + miss, 10)}, {xy(16 - miss, 10)}]}}
points: {{gauge: {xy(2 - abs(miss), 20)}}}
""")
    mesh, _, notes = section.mesh_of(tmp_path / "dam.yaml")
    found = np.bincount(macroblocks(mesh), areas(mesh))
    assert sorted(found) == pytest.approx([10 * (20 + 15) / 2, 20 * (15 + 5) / 2], abs=0.02)  # trapezia below and above
    assert mesh.vertices[mesh.points["gauge"]] == pytest.approx([turned * 2, 20], abs=0.0015)
    assert any("joined, as all that misses by less than 0.002 m" in note for note in notes) and any("point 'gauge'" in note and "brought to it" in note for note in notes)


def test_what_meets_is_not_moved(tmp_path):
    (tmp_path / "dam.yaml").write_text("size: 2\ndam: {upstream: [[0, 0], [0, 10]], downstream: [[8, 0], [2, 10]]}\npoints: {gauge: [1, 4]}\njoints: {crack: [[0, 5], [5, 5]]}\n")
    mesh, _, notes = section.mesh_of(tmp_path / "dam.yaml")
    assert not notes and macroblocks(mesh).max() == 1 and mesh.vertices[mesh.points["gauge"]].tolist() == [1, 4]


@pytest.mark.parametrize(("change", "said"), [
    (("batter: 0.7", "batter: -0.7"), "dam.downstream: the face hangs over by 21 m of 30 m height"),
    (("batter: 0.1", "batter: -0.3"), "dam.upstream: the face hangs over by 9 m of 30 m height"),
    (("size: 3", "size: 1800"), "size: blocks of 1800 m in a dam of 30 m height: expected metres"),
    (("size: 3", "size: 2"), None)])  # fmt: skip
def test_faces_and_sizes_that_no_dam_has_are_told(tmp_path, change, said):
    text = "size: 3\ndam: {upstream: [[0, 0], {to: 30, batter: 0.1}], downstream: [[29, 0], {to: 30, batter: 0.7}]}\n"
    (tmp_path / "section.yaml").write_text(text.replace(*change), encoding="utf-8")
    notes = section.load(tmp_path / "section.yaml")[1]
    assert notes == [] if said is None else [note.startswith(said) for note in notes] == [True], notes
