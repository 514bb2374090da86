"""Stones of a section: courses with a bond, Voronoi polygons, joint sets of the rock; against counts, lengths and areas by hand and the generator of Voronoi dams."""

import numpy as np
import pytest
from quoin_tools.mesh import section, voronoi
from quoin_tools.mesh.blockmesh import check, face_ends, macroblocks, quality
from quoin_tools.mesh.dam import G1
from test_section import SMALL, declared, group_areas, lengths, meshed

pytest.importorskip("gmsh")

WALL = "size: 3\ndam: {upstream: [[0, 0], [0, 6]], downstream: [[12, 0], [12, 6]], pattern: {courses: 1, stones: 2}}\n"
STONES = SMALL.replace("lifts: [6]", "pattern: {courses: 1, stones: 2}").replace("seams:", "joints: {sheet: {dip: 15, spacing: 4}, steep: {dip: -75, spacing: 4}}\n  seams:")


def bodies(mesh):
    return int(macroblocks(mesh).max()) + 1



@pytest.mark.parametrize("bond, stones, heads", [(0.5, 3 * 6 + 3 * 7, 3 * 5 + 3 * 6), (0, 36, 30), (0.25, 2 * 6 + 4 * 7, 2 * 5 + 4 * 6)])
def test_courses(tmp_path, bond, stones, heads):
    mesh = meshed(tmp_path, WALL.replace("stones: 2", f"stones: 2, bond: {bond}"))
    assert bodies(mesh) == stones
    found = lengths(mesh)
    assert found["joint_bed"] == pytest.approx(2 * 5 * 12) and found["joint_head"] == pytest.approx(2 * heads)
    assert group_areas(mesh)["dam"] == pytest.approx(72)


def test_beds_that_dip(tmp_path):
    """All beds have the dip, all heads are square to them, but for what is bent at the outline."""
    mesh = meshed(tmp_path, WALL.replace("stones: 2", "stones: 2, dip: 10").replace("size: 3", "size: 9"))
    for name, angle in (("joint_bed", -10), ("joint_head", 80)):
        ends = mesh.vertices[face_ends(mesh, mesh.face_sets[name])]
        along = ends[:, 1] - ends[:, 0]
        length = np.hypot(*along.T)
        dips = (np.degrees(np.arctan2(along[:, 1], along[:, 0])) - angle + 90) % 180 - 90
        assert length[np.abs(dips) < 0.1].sum() > 0.8 * length.sum()
    assert group_areas(mesh)["dam"] == pytest.approx(72)


@pytest.mark.parametrize("pattern, stones", [("{courses: 100, stones: 100}", 1), ("{courses: 1, stones: 1e5}", 6), ("{voronoi: 100}", 1)])
def test_stones_larger_than_the_dam(tmp_path, pattern, stones):
    mesh = meshed(tmp_path, WALL.replace("{courses: 1, stones: 2}", pattern))
    assert bodies(mesh) == stones and group_areas(mesh)["dam"] == pytest.approx(72)


def test_voronoi_is_that_of_the_generator(tmp_path):
    corners = [list(map(float, xy)) for xy in G1.corners()]
    text = (f"size: 50\ndam: {{upstream: {[corners[0], corners[4]]}, downstream: {[corners[1], corners[2], corners[3]]}, "
            "pattern: {voronoi: 2, seed: 3, facing: [1, 1]}}\n")  # fmt: skip
    mesh, known = meshed(tmp_path, text), voronoi.voronoi_mesh(options=voronoi.Options(seed=3))
    assert bodies(mesh) == bodies(known) > 100
    assert group_areas(mesh) == pytest.approx(group_areas(known), rel=1e-6)
    assert lengths(mesh) == pytest.approx(lengths(known), rel=1e-6)


@pytest.mark.parametrize("pattern", ["{courses: 1, stones: 2}", "{voronoi: 1}", "{voronoi: 0.8, facing: [0.6, 0.6], seed: 4}"])
def test_gallery_base_seam_and_joint_sets(tmp_path, pattern):
    """No area is lost; the outline, gallery, base and seam stay as they are drawn; blocks have fair corners."""
    mesh = meshed(tmp_path, STONES.replace("{courses: 1, stones: 2}", pattern))
    check(mesh)
    area = group_areas(mesh)
    assert area.pop("rock") == pytest.approx(49 * 15) and sum(area.values()) == pytest.approx(58)
    found = lengths(mesh)
    seam = (9 + 20 + 20 - (20 - 3 / np.tan(np.radians(10)))) / np.cos(np.radians(10))
    assert [found[name] for name in ("gallery", "base", "seam", "upstream")] == pytest.approx([6, 18, 2 * seam, np.hypot(10, 1)])
    assert bodies(mesh) > 60 and quality(mesh)[0] > 5
    for name in ("sheet", "steep"):  # both sides of every joint; between parallels 4 m apart there is a length of area / 4
        assert found[name] == pytest.approx(2 * 49 * 15 / 4, rel=0.2)


BAD = [
    ("{courses: 1, stones: 2}", "{courses: 1}", ":6: dam.pattern: 'stones' is missing, expected a number [m] above 0"),
    ("{courses: 1, stones: 2}", "{}", ":6: dam.pattern: expected courses or voronoi"),
    ("{courses: 1, stones: 2}", "{courses: 1, voronoi: 2, stones: 2}", "dam.pattern.voronoi: expected only one of courses or voronoi"),
    ("stones: 2", "stones: 2, bond: 2", ":6: dam.pattern.bond: 2: expected a number [part of a stone] at least 0 and at most 1"),
    ("{courses: 1, stones: 2}", "{voronoi: 1, facing: 1}", ":6: dam.pattern.facing: 1: expected [thickness upstream, thickness downstream]"),
    ("{courses: 1, stones: 2}", "{voronoi: 1, facing: [9, 9]}", ":6: dam.pattern: the facing is too thick for the section"),
    ("{courses: 1, stones: 2}", "{courses: 0.01, stones: 0.01}", ":6: dam.pattern: about 5.8e+05 stones, expected at most 100000"),
    ("{courses: 1, stones: 2}", "{courses: 1, stones: 2}\n  lifts: [6]", ":7: dam.lifts: expected lifts or a pattern"),
    ("sheet: {dip: 15, ", "sheet: {", ":11: rock.joints.sheet: 'dip' is missing"),
]


@pytest.mark.parametrize("old, new, reason", BAD, ids=range(len(BAD)))
def test_a_mistake_is_one_line(tmp_path, capsys, old, new, reason):
    assert STONES.count(old) == 1
    path = declared(tmp_path, STONES.replace(old, new))
    assert section.main([str(path), "-o", str(tmp_path / "no.h5")]) == 2
    said = capsys.readouterr().err.strip()
    assert said.count("\n") == 0 and said.startswith(str(path)) and reason in said, said
