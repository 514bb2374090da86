"""Block mesh of section G1 of the Guilhofrei dam on its rock; face set key: the joint's first 3 m from the heel.

    PYTHONPATH=tools python examples/guilhofrei_sliding/mesh.py OUTPUT.h5 [COLUMNS]

COLUMNS of blocks across the base of the dam, 15 by default: the key is then two columns, 3.04 m, long."""

import sys

from quoin_tools.mesh.blockmesh import check, face_ends, write
from quoin_tools.mesh.dam import G1, dam_mesh

KEY = 3.0  # m


def key_mesh(columns=15):
    """The dam and its rock, with the face set key: whole columns, as near to 3 m as they come."""
    mesh = dam_mesh(G1, columns)
    width = (G1.toe[0] - G1.heel[0]) / columns
    length = max(1, round(KEY / width)) * width
    base = mesh.face_sets["base"]
    mesh.face_sets["key"] = base[mesh.vertices[face_ends(mesh, base)][:, :, 0].max(axis=1) < length + 1e-6]
    return mesh


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3) or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    made = key_mesh(*map(int, sys.argv[2:]))
    check(made)
    write(sys.argv[1], made)
    print(f"wrote {sys.argv[1]}: {len(made.blocks)} blocks")
