"""Meshes of blocks that move:  PYTHONPATH=tools python examples/motion/mesh.py OUTPUT edge|column|leaning"""

import sys

import numpy as np
from quoin_tools.mesh.blockmesh import write
from quoin_tools.mesh.meshing import join, rectangle, renamed


def rigid(x, y, width, height, group):
    return renamed(rectangle(x, y, width, height, group=group, rigid=True), {})


def edge():
    """A block on a ledge 0.7 m above two others."""
    return join([rigid(0, 0, 1.5, 1, "base"), rigid(1.7, 0, 1.5, 0.3, "base"), rigid(3.2, 0, 1.5, 0.3, "base"),
                 rigid(0.9, 1, 0.5, 0.25, "block")])


def column(n=10, gap=0.05):
    """Blocks of 1 m by 0.5 m above each other, with gaps."""
    return join([rigid(-0.5, -0.5, 2, 0.5, "base"), *(rigid(0, gap + i * (0.5 + gap), 1, 0.5, "block") for i in range(n))])


def leaning(part=0.4, width=0.5, height=2.0):
    """A block that leans on its lower right corner, by a part of its slenderness."""
    lean = part * np.arctan(width / height)
    c, s = np.cos(lean), np.sin(lean)
    block = rigid(0, 0, width, height, "block")
    block.vertices = (block.vertices - [width, 0]) @ np.array([[c, -s], [s, c]]) + [width, 0]
    return join([rigid(-1.25, -0.5, 3, 0.5, "base"), block])


MESHES = {"edge": edge, "column": column, "leaning": leaning}

if __name__ == "__main__":
    if len(sys.argv) != 3 or sys.argv[2] not in MESHES:
        sys.exit(__doc__)
    write(sys.argv[1], MESHES[sys.argv[2]]())
