"""A dam of 30 m in five lifts on rock:  PYTHONPATH=tools python examples/lifts_and_winter/mesh.py MODEL.h5"""

import os
import sys

import numpy as np
from quoin_tools.mesh.blockmesh import outer_faces, write
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed


def mesh():
    """Groups rock and lift_1 .. lift_5, bodies of their own; faces upstream, air (all but the rock's and the joints), base, bottom, sides; points crest, heel."""
    parts = [renamed(rectangle(-30, -30, 84, 30, 28, 10, group="rock"), {"bottom": "bottom", "left": "left", "right": "right"})]
    for i in range(5):
        y, low, high = 6 * i, 24 - 4 * i, 20 - 4 * i
        lift = quad_patch((0, y), (low, y), (high, y + 6), (0, y + 6), 12 - i, 4, group=f"lift_{i + 1}")
        faces = {"upstream": "left"} | ({"base": "bottom"} if i == 0 else {})
        parts.append(renamed(lift, faces, ({"heel": "bottom_left"} if i == 0 else {}) | ({"crest": "top_left"} if i == 4 else {})))
    whole = join(parts)
    faces = outer_faces(whole)
    ends = whole.vertices[np.stack([whole.blocks[faces[:, 0], faces[:, 1]], whole.blocks[faces[:, 0], (faces[:, 1] + 1) % 4]], axis=1)]
    in_joint = (np.abs(ends[:, 0, 1] - ends[:, 1, 1]) < 1e-9) & (ends[:, 0, 1] < 29.9)
    of_dam = whole.block_group[faces[:, 0]] != whole.group_names.index("rock")
    whole.face_sets["air"] = faces[of_dam & ~in_joint]
    return whole


if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    os.makedirs(os.path.dirname(sys.argv[1]) or ".", exist_ok=True)
    write(sys.argv[1], mesh())
