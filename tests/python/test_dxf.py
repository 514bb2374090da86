"""A stage of a run as a drawing: areas, lengths and motions of its layers against results.h5; and back again as a section."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
import shapely
from quoin_tools.base.results import SLIPPING, Results
from quoin_tools.mesh import section
from quoin_tools.mesh.blockmesh import write
from quoin_tools.show import dxf, export
from quoin_tools.show.style import view
from test_section import SMALL, declared, group_areas, lengths, meshed

pytest.importorskip("gmsh")
ezdxf = pytest.importorskip("ezdxf")
QUOIN = Path(os.environ.get("QUOIN", Path(__file__).resolve().parents[2] / "build/quoin"))
pytestmark = pytest.mark.skipif(not QUOIN.exists(), reason="the solver is not built")

SCENE = """\
model: model.h5
strain: small
materials:
  dam: {density: 2400, young: 10e9, poisson: 0.2}
  rock: {density: 2500, rigid: true}
joints:
  default: {k_n: 10e9, k_s: 4e9, friction: 45}
  lift: {friction: 60, cohesion: 1e6, tension: 1e6}
  base: {friction: 45}
supports: {rock_bottom: {fix: xy}}
anchors: {tendon: {head: [1.5, 9], root: [1.5, -8], area: 1e-3, young: 195e9}}
loads:
  weight: {type: self_weight, groups: [dam, rock]}
  water: {type: reservoir, faces: upstream, level: 10}
stages:
  - full: {loads: [weight, water]}
  - sliding: {type: strength_reduction, reduce: [base], loads: [weight, water], step: 10, limit: 5}
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("dxf")
    write(folder / "model.h5", meshed(folder, SMALL.replace("  seams: {seam: {through: [0, -3], dip: 10}}\n", "")))
    (folder / "scene.yaml").write_text(SCENE)
    subprocess.run([QUOIN, "-options_file", "scene.yaml", "-output", "out"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    assert export.main([str(folder / "out"), "--dxf", "--to", str(folder)]) == 0
    return Results(folder / "out"), folder


def rings(folder, stage, layer):
    document = ezdxf.readfile(folder / f"{stage}.dxf")
    assert document.units == 6 and not document.audit().errors
    return [np.array([point[:2] for point in line]) for line in document.modelspace().query(f'LWPOLYLINE[layer=="{layer}"]')]


def lines(folder, stage, layer):
    found = ezdxf.readfile(folder / f"{stage}.dxf").modelspace().query(f'LINE[layer=="{layer}"]')
    return sum(line.dxf.start.distance(line.dxf.end) for line in found)


def area(polygons):
    return sum(shapely.Polygon(ring).area if shapely.LinearRing(ring).is_ccw else -shapely.Polygon(ring).area for ring in polygons)


@pytest.mark.parametrize("stage", ["full", "sliding"])
def test_bodies_and_joints(run, stage):
    """Outlines run counter-clockwise, those of holes clockwise: two bodies of the dam, the gallery, the rock."""
    results, folder = run
    assert len(rings(folder, stage, "GROUP_dam")) == 3 and area(rings(folder, stage, "GROUP_dam")) == pytest.approx(58)
    assert area(rings(folder, stage, "GROUP_rock")) == pytest.approx(49 * 15)
    contacts = results.stage(stage).contacts
    for name in results.mesh.joint_names:
        mine = contacts.joint == results.mesh.joint_names.index(name)
        drawn = np.hypot(*(contacts.point[mine, 1] - contacts.point[mine, 0]).T).sum()
        assert lines(folder, stage, f"JOINT_{name}") == pytest.approx(drawn) and (not mine.any() or drawn > 0)
    slipping = (contacts.state.reshape(len(contacts), -1) & SLIPPING).any(axis=1)
    assert lines(folder, stage, "SLIPPING") == pytest.approx(np.hypot(*(contacts.point[slipping, 1] - contacts.point[slipping, 0]).T).sum())
    assert lines(folder, stage, "ANCHORS") == pytest.approx(17)


def test_displacements_and_mechanism(run):
    """Every ring is that of the bodies, moved by the factor that is written beside it; the fastest vertex by 5 % of the section."""
    results, folder = run
    mesh = results.mesh
    for stage, layer, motion in (("full", "DISPLACED", results.stage("full").displacement), ("sliding", "MECHANISM", results.stage("sliding").mechanism)):
        here = np.concatenate(rings(folder, stage, "GROUP_dam") + rings(folder, stage, "GROUP_rock"))
        there = np.concatenate(rings(folder, stage, layer))
        at = {tuple(np.round(xy, 6)) for xy in here}
        text = "; ".join(t.dxf.text for t in ezdxf.readfile(folder / f"{stage}.dxf").modelspace().query('TEXT[layer=="NOTES"]'))
        box, _ = view(mesh)
        size = max(box[1] - box[0], box[3] - box[2])
        factor = float(text.split("displacements ")[1].split()[0]) if stage == "full" else dxf.SHARE * size
        moved = {tuple(np.round(xy, 6)) for xy in (mesh.vertices + factor * motion)[mesh.outline().ravel()]}
        assert {tuple(np.round(xy, 6)) for xy in there} == moved and len(at) > 50
        far = np.hypot(*motion.T).max() * factor / size
        assert 0.02 < far <= 0.05 + 1e-9
        crest = results.stage_summary(stage)["probes"]["crest_upstream"]["u_x"]
        assert f"stage {stage}" in text and "lengths in m" in text and f"crest_upstream: u = ({1e3 * crest:.4g}," in text


def test_a_drawing_that_is_written_is_read(run, tmp_path):
    _, folder = run
    text = f"drawing: {{file: {folder / 'full.dxf'}}}\nsize: 3\nlayers:\n  GROUP_dam: {{group: dam}}\n  GROUP_rock: {{group: rock, sides: true}}\n  JOINT_base: {{joint: base}}\n"
    text = text.replace("file: ", "gap: 0.0001, file: ")
    try:
        mesh = section.mesh_of(declared(tmp_path, text))[0]
    except section.DeclaredError as error:
        pytest.fail(str(error))
    assert group_areas(mesh) == pytest.approx({"dam": 58, "rock": 49 * 15}) and lengths(mesh)["base"] == pytest.approx(18)


def test_no_such_stage(run, capsys):
    assert export.main([str(run[0].folder), "--dxf", "--stage", "none"]) == 2
    assert "no stage 'none'" in capsys.readouterr().err
