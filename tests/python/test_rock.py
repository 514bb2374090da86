"""Rock cut by sets of joints: how many blocks and joints, where they run, what is refused."""

import os
import sys

import numpy as np
import pytest

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "..", "tools"))

from quoin_tools.mesh.blockmesh import MeshError, areas, check, face_ends, macroblocks
from quoin_tools.mesh.rock import JointSet, jointed_rock

BOX = [(0, 0), (20, 0), (20, 10), (0, 10)]
SQUARE = (JointSet("bed", 0, 2.5), JointSet("head", 90, 2.5))


@pytest.mark.parametrize("refine", [0, 1])
def test_masonry_of_squares(refine):
    """3 beds of 8 joints, 7 lines of 4: two faces each, and twice as many where blocks are cut once more."""
    mesh = jointed_rock(BOX, SQUARE, refine=refine)
    assert check(mesh).max() + 1 == 8 * 4
    assert {name: len(rows) for name, rows in mesh.face_sets.items()} == {"bed": 48 << refine, "head": 56 << refine}
    assert areas(mesh) == pytest.approx((2.5 / (1 + refine)) ** 2)


def test_joints_run_as_their_dip_says():
    """Inside; near the outline short sides are merged."""
    sets = (JointSet("sheet", 20, 2.0, (10, 5)), JointSet("steep", -65, 3.0, (10, 5)))
    mesh = jointed_rock(BOX, sets)
    check(mesh)
    assert areas(mesh).sum() == pytest.approx(200)
    for joints in sets:
        ends = mesh.vertices[face_ends(mesh, mesh.face_sets[joints.name])]
        inside = ((ends > [1.5, 1.5]) & (ends < [18.5, 8.5])).all(axis=(1, 2))
        x, y = (ends[:, 1] - ends[:, 0])[inside].T
        assert inside.sum() > 20 and np.degrees(np.arctan(-y / x)) == pytest.approx(joints.dip)
        a, b = joints.along()
        away = ((ends[inside] - joints.through) @ [-b, a]) / joints.spacing
        assert away == pytest.approx(away.round(), abs=1e-9) and len(np.unique(away.round())) > 1


def test_no_sliver_is_left():
    """A joint 5 cm from the outline goes, and with it the slice between them."""
    mesh = jointed_rock(BOX, (JointSet("bed", 0, 2.5, (0, 0.05)),))
    check(mesh)
    assert macroblocks(mesh).max() + 1 == 4 and areas(mesh).sum() == pytest.approx(200)


@pytest.mark.parametrize("sets", [(), (JointSet("bed", 0, 0.0),), (JointSet("bed", 91, 1.0),), (JointSet("bed", np.nan, 1.0),)])
def test_refused(sets):
    with pytest.raises(MeshError, match="joints: expected at least one set"):
        jointed_rock(BOX, sets)
