"""A dam of 32 m that has been heightened by 4 m, on rigid rock:  PYTHONPATH=tools python examples/anchored_dam/mesh.py MODEL.h5 [COLUMNS]"""

import os
import sys

from quoin_tools.mesh.blockmesh import write
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed


def mesh(columns=12):
    """Old dam, heightening and rock; faces upstream, joints base and lift."""
    old = renamed(quad_patch((0, 0), (24, 0), (4, 32), (0, 32), columns, 16, group="old"), {"upstream": "left", "base": "bottom", "lift": "top"}, {"toe": "bottom_right"})
    new = renamed(quad_patch((0, 32), (4, 32), (4, 36), (0, 36), 3, 3, group="new"), {"upstream": "left"}, {"crest": "top_left"})
    rock = renamed(rectangle(-20, -20, 64, 20, group="rock", rigid=True), {"bottom": "bottom"})
    return join([rock, old, new])


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3) or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    os.makedirs(os.path.dirname(sys.argv[1]) or ".", exist_ok=True)
    write(sys.argv[1], mesh(*map(int, sys.argv[2:])))
