"""Block mesh of section G1 on rock that two sets of joints cut into blocks.

    PYTHONPATH=tools python examples/guilhofrei_seepage/mesh.py OUTPUT.h5 [COLUMNS]

COLUMNS of blocks across the base of the dam, 15 by default. Face sets sheet and steep are the joints of the rock, base that of
the dam."""

import sys

from quoin_tools.mesh.blockmesh import check, macroblocks, write
from quoin_tools.mesh.dam import G1, dam_part, name_sides
from quoin_tools.mesh.meshing import join
from quoin_tools.mesh.rock import JointSet, jointed_rock

SETS = (JointSet("sheet", 15, 5.0, (0, -2.5)), JointSet("steep", -75, 5.0, (2.0, 0)))  # dips downstream and upstream
UPSTREAM, DOWNSTREAM, DEPTH = -28.0, 50.0, -27.0  # m, ends of the rock


def rock_mesh(columns=15):
    (x0, y0), (x1, y1) = G1.heel, G1.toe
    outline = [(UPSTREAM, DEPTH), (DOWNSTREAM, DEPTH), (DOWNSTREAM, y1), (x1, y1), (x0, y0), (UPSTREAM, y0)]
    rock = jointed_rock(outline, SETS, refine=1)
    joints = dict(rock.face_sets)
    mesh = join([dam_part(G1, columns), rock])
    shift = len(mesh.blocks) - len(rock.blocks)
    name_sides(mesh, G1)
    mesh.face_sets |= {name: rows + [shift, 0] for name, rows in joints.items()}
    return mesh


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3) or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    made = rock_mesh(*map(int, sys.argv[2:]))
    check(made)
    write(sys.argv[1], made)
    joints = sum(len(made.face_sets[s.name]) for s in SETS) // 4
    print(f"wrote {sys.argv[1]}: {len(made.blocks)} blocks, {macroblocks(made).max() + 1} bodies, {joints} joints in the rock")
