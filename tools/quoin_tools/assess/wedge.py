"""Finds the plane on which the part above a bent path slides.

As one rigid body it can move along a piece of the path only if it comes off all other pieces, or runs along them: towards the
end of the path that is the piece that rises most, towards the start the one that falls most, when the rest lets it. On it alone the
part then stands; what was in contact elsewhere parts.

    plane = sliding_plane(path, forces)     # a Base, or a GravityError that says why there is none
"""

import numpy as np

from quoin_tools.assess.gravity import Base
from quoin_tools.assess.section_cut import GravityError
from quoin_tools.base.language import N_, _

BENT = 0.02  # [-] of its chord: a path that goes farther from it is no plane
ALONG = 1e-6  # [-] a direction that goes into a piece by less runs along it
WAY_OUT = N_("a strength reduction of the block model judges it")


def is_bent(path):
    base = Base(path[0], path[-1])
    return bool(np.abs((path - base.start) @ base.normal).max() > BENT * base.length)


def planes(path, thickness=1.0):
    """Returns (Base, sense) of the pieces along which the part above can move, towards the end (1) or the start (-1) of the path."""
    bases = [Base(a, b, thickness) for a, b in zip(path[:-1], path[1:])]
    normals = np.array([base.normal for base in bases])
    return [(base, sense) for sense in (1, -1) for base in bases if (normals @ (sense * base.along) >= -ALONG).all()]


def sliding_plane(path, forces, thickness=1.0):
    """Returns the plane along which the forces (X, Y, M) push the part above."""
    pushed = [base for base, sense in planes(path, thickness) if sense * base.resultants(forces)[1] > 0]
    if not pushed:
        raise GravityError(_("the path is bent, and the loads push the part above along none of its planes that it could slide on: {0}", _(WAY_OUT)))
    return max(pushed, key=lambda base: abs(base.resultants(forces)[1]))


def words(base):
    (x, y), (u, v) = base.ends()
    rise = np.degrees(np.arctan2(base.along[1], base.along[0]))
    return _("the plane from ({0:.2f}, {1:.2f}) to ({2:.2f}, {3:.2f}) m, {4:+.1f}°", x, y, u, v, rise)
