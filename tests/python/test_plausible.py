"""Loads and meshes that no dam has are reported by the run and by quoin check; a dam as it should be is not."""

import pytest
from quoin_tools.mesh.blockmesh import BlockMesh
from test_mirror import QUOIN, SCENE, dam, mirrored, run

pytestmark = pytest.mark.skipif(not QUOIN.exists(), reason="the solver is not built")
STAGES = "  - full: {loads: [weight, water, silt, uplift, lift, ice, wave]}\n  - shaken: {from: full, loads: [weight, water, silt, uplift, lift, ice, wave, quake]}\n"

ANCHOR = "anchors: {{bar: {{head: [SIGN2, 20], root: [SIGN2, -4], area: {}, young: {}, prestress: [{}], lock: [full]}}}}\nstages:"


def said_of(folder, mesh, sign, *changes):
    """What a run of the dam says on stderr, with changes (old, new) of its scene."""
    text = SCENE.format(sign)
    text = text[: text.index("  - full")] + STAGES
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    done = run(folder, mesh, text)
    assert done.returncode in (0, 6), done.stderr  # it may fall
    return "\n".join(line for line in done.stderr.splitlines() if "no stage lists" not in line)


WRONG = {
    "ice on the downstream face": (("type: ice, faces: upstream, level: 21.5", "type: ice, faces: downstream, level: 21.5"), "loads.ice pushes to the {left}, where no water of the stage pushes"),
    "silt on the downstream face": (("type: silt, faces: upstream", "type: silt, faces: downstream"), "loads.silt pushes to the {left}, where no water of the stage pushes"),
    "a wave on the downstream face": (("type: wave, faces: upstream", "type: wave, faces: downstream"), "loads.wave pushes to the {left}, where no water of the stage pushes"),
    "water of k_h on the downstream face": (("-0.01], faces: upstream", "-0.01], faces: downstream"), "loads.quake shakes water at the faces 'downstream', where no water of the stage stands"),
    "ice far below the surface": (("level: 21.5", "level: 12"), "loads.ice: its level is 12 m, but the water of loads.water stands at 22 m"),
    "uplift twice": (("type: uplift, faces: bed_2", "type: uplift, faces: base"), "loads.uplift and loads.lift both are in 'base': water there counts twice"),
    "k_h in percent": (("[SIGN0.02, -0.01]", "[SIGN12, -0.01]"), "loads.quake.coefficient: k_h {sign}12 is more than the weight"),
    "a gallery above the water": (("gallery: 0.5", "gallery: 50"), "loads.uplift.gallery: 50 m is above the water, which stands at 22 m"),
    "a pressure in kPa": (("wave: {", "gas: {type: pressure, faces: upstream, pressure: 10}\n  wave: {"), "loads.gas.pressure: 10 Pa is not within 1000 to 1e+08: 1 kPa is 1e3 Pa"),
    "a traction in kPa": (("wave: {", "wind: {type: traction, faces: downstream, value: [3, 4]}\n  wave: {"), "loads.wind.value: 5 Pa is not within 1000 to 1e+08"),
    "a load on the crest in kN": (("5e3, -2e4]", "5, -20]"), "loads.crane.value: 20.6155 N/m is not within 100 to 1e+09: 1 kN/m is 1e3 N/m"),
    "drains that take all": (("efficiency: 0.5", "efficiency: 1"), "loads.uplift.efficiency: 1 is more than drains are granted"),
    "cohesion in kPa": (("bed_1: {cohesion: 5e4}", "bed_1: {cohesion: 100}"), "joints.bed_1.cohesion: 100 Pa is not within 5000 to 1e+08"),
    "tension beyond the apex": (("bed_1: {cohesion: 5e4}", "bed_1: {cohesion: 5e4, tension: 1e5}"), "joints.bed_1: tension, 1e+05 Pa, is beyond the apex of the shear strength, cohesion / tan(friction) = 5.959e+04 Pa"),
    "a joint without a row": ((", bed_2: {friction: 35}", ""), "no row of joints has the name of these face sets: bed_2; their contacts have the row default"),
    "uplift of a lower level": (("faces: base, level: 22", "faces: base, level: 12"), "stages.full: loads.uplift.level: 12 m, but the water of loads.water stands at 22 m"),
    "shaken water of a lower level": (("-0.01], faces: upstream, level: 22", "-0.01], faces: upstream, level: 14"), "stages.shaken: loads.quake.level: 14 m, but the water of loads.water stands at 22 m"),
    "gravity in cm/s2": (("stages:", "gravity: 981\nstages:"), "gravity: 981 m/s2 is not within 9 to 11"),
    "a thickness in mm": (("stages:", "thickness: 1000\nstages:"), "thickness: 1000 m is not within 0.01 to 200"),
    "an anchor whose area is in mm2": (("stages:", ANCHOR.format("1500", "2e11", "2e6")), "anchors.bar.area: 1500 m2 is not within 1e-06 to 0.1: 1000 mm2 is 1e-3 m2"),
    "an anchor whose steel is in GPa": (("stages:", ANCHOR.format("1.5e-3", "200", "2e6")), "anchors.bar.young: 200 Pa is not within 1e+09 to 1e+12"),
    "a prestress in kN": (("stages:", ANCHOR.format("1.5e-3", "2e11", "2000")), "anchors.bar.prestress: 2000 N is not within 3000 to 3.75e+06: it is 1.333 MPa in its area"),
    "more prestress than steel bears": (("stages:", ANCHOR.format("1.5e-4", "2e11", "2e6")), "anchors.bar.prestress: 2e+06 N is not within 300 to 375000: it is 1.333e+04 MPa in its area"),
    "silt higher than the water": (("type: silt, faces: upstream, level: 6", "type: silt, faces: upstream, level: 23"), "stages.full: loads.silt: its level is 23 m, but the water of loads.water stands at 22 m: density is what silt weighs in water"),
    "a level in another datum": (("faces: upstream, level: 22}", "faces: upstream, level: 422}"), "loads.water.level: 422 m, but the faces of upstream reach from 0 to 24 m"),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
@pytest.mark.parametrize("side", ["left", "right"])
def test_what_no_dam_has_is_told(tmp_path, what, side):
    (old, new), said = WRONG[what]
    sign = "" if side == "left" else "-"
    found = said_of(tmp_path, dam() if side == "left" else mirrored(dam()), sign, (old.replace("SIGN", sign), new.replace("SIGN", sign)))
    assert said.format(left="left" if side == "left" else "right", sign=sign) in found


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_dam_as_it_should_be_is_not_doubted(tmp_path, side):
    assert said_of(tmp_path, dam() if side == "left" else mirrored(dam()), "" if side == "left" else "-") == ""


def test_a_reservoir_at_the_faces_downstream(tmp_path):
    text = SCENE.format("").replace("type: reservoir, faces: upstream", "type: reservoir, faces: downstream")
    text = text[: text.index("  - full")] + "  - full: {loads: [weight, water]}\n"
    done = run(tmp_path, dam(), text)
    assert "stages.full: the highest water, loads.water at 22 m, stands at the faces 'downstream': expected the reservoir upstream" in done.stderr


def test_a_mesh_in_millimetres(tmp_path):
    small = dam()
    large = BlockMesh(small.vertices * 1e3, small.blocks, small.block_group, small.group_names, small.group_rigid, small.face_sets, small.points)
    text = SCENE.format("").replace("  - full: {loads: [weight, water, tail, silt, uplift, lift, crane]}", "  - full: {loads: [weight, water]}")
    done = run(tmp_path, large, text[: text.index("  - winter")])
    assert "the mesh is 4.4e+04 m wide and 3.2e+04 m high: expected metres" in done.stderr
    assert "loads.water.level: 22 m, but the faces of upstream reach from 0 to 24000 m" in done.stderr
