"""The example engineers_dam: forty lines of data, from the section and from its drawing, against statics of the dam and the rock above its seam."""

import math
import os
import subprocess
from pathlib import Path

import pytest
from quoin_tools.base.results import Results
from quoin_tools.mesh import section
from quoin_tools.mesh.blockmesh import write
from test_section import group_areas, lengths

pytest.importorskip("gmsh")
pytest.importorskip("ezdxf")
ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "examples/engineers_dam"
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))

pytestmark = pytest.mark.skipif(not QUOIN.exists(), reason="the solver is not built")
GALLERY = 2 * 1.6 + 16 / 2 * math.sin(math.pi / 16)  # the arch is half a 32-gon of 1 m
DAM = 29.4 * 30.5 / 2 + 5 * 30.5 / 2 + 5 * 7.5 - 1.2 * 12 / 2 - 1.2 * 26 - GALLERY  # m2
WEDGE, WATER = 44 * 4 / 2, 9810.0  # m2 of rock between base and seam, N/m3


def by_hand():
    """N and T of the seam [N/m]."""
    angle, length = math.atan2(4, 44), math.hypot(4, 44)
    down = 9.81 * (2400 * DAM + 2600 * WEDGE) + WATER * 0.1 * (36 * 12 - 12**2 / 2)  # weights, water on the batter
    thrust = WATER * 40**2 / 2  # on the dam and in the crack
    uplift = WATER * ((40 + 40 / 3) / 2 * 5.02 + 40 / 3 / 2 * (length - 5.02))
    return down * math.cos(angle) + thrust * math.sin(angle) - uplift, thrust * math.cos(angle) - down * math.sin(angle)


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    found, folder = {}, tmp_path_factory.mktemp("dam")
    for name, more in (("section", ()), ("drawing", ("-stages", "empty,full"))):
        mesh = section.mesh_of(EXAMPLE / f"{name}.yaml")[0]
        write(folder / f"{name}.h5", mesh)
        subprocess.run([QUOIN, "-options_file", EXAMPLE / "scene.yaml", "-model", folder / f"{name}.h5", "-output", folder / name, *more],
                       check=True, stdout=subprocess.DEVNULL)  # fmt: skip
        found[name] = mesh, Results(folder / name)
    return found


def test_forty_lines_of_data():
    assert sum(len((EXAMPLE / name).read_text().splitlines()) for name in ("section.yaml", "scene.yaml")) <= 40


def test_section_and_drawing_are_the_same_dam(runs):
    (one, _), (other, _) = runs.values()
    assert group_areas(one) == pytest.approx({"dam": DAM, "rock": 199.4 * 70})
    assert group_areas(other) == pytest.approx(group_areas(one), rel=1e-4)  # the arch
    common = ("base", "seam", "crack", "upstream", "rock_sides", "rock_bottom")
    assert [lengths(other)[name] for name in common] == pytest.approx([lengths(one)[name] for name in common])


@pytest.mark.parametrize("name", ["section", "drawing"])
def test_forces_of_the_seam(runs, name):
    seam = runs[name][1].stage_summary("full")["joints"]["seam"]
    assert [seam["N"], seam["T"]] == pytest.approx(by_hand(), rel=1e-3)


def test_friction_at_failure(runs):
    """The bracket has the angle of statics, but for what a dam that comes to rest after a while still moves."""
    N, T = by_hand()
    limit = math.degrees(math.atan2(T, N))
    trials = runs["section"][1].stage_summary("sliding")["strength_reduction"]
    assert trials["failing"] - 0.05 < limit < trials["stable"] and trials["stable"] - trials["failing"] < 0.1
