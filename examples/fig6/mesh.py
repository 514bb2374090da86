"""Block mesh of the dam of the paper's Fig. 6: a triangle, 80 m by 100 m, on rigid ground.

    PYTHONPATH=tools python examples/fig6/mesh.py OUTPUT.h5 [N] [FAMILY]

N blocks along the base, 16 by default. FAMILY M (default): N by N blocks mapped on the triangle, the top row triangles.
FAMILY G: rectangles of a grid, a triangle at the end of each row on the slope."""

import sys

from quoin_tools.mesh.blockmesh import MeshError, write
from triangle_dam import triangle_dam


def main():
    if not 2 <= len(sys.argv) <= 4 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    output, n, family = (sys.argv[1:] + ["16", "M"][len(sys.argv) - 2:])[:3]
    if not n.isdigit() or int(n) < 2:
        sys.exit(f"mesh.py: N is {n}: expected a whole number from 2 on")
    try:
        mesh = triangle_dam(int(n), family)
        write(output, mesh)
    except (MeshError, OSError) as error:
        sys.exit(f"mesh.py: {error}")
    print(f"wrote {output}: family {family}, {len(mesh.blocks)} blocks, {len(mesh.vertices)} vertices")


if __name__ == "__main__":
    main()
