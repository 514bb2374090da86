"""Block mesh of section G1 on jointed rock, that of examples/guilhofrei_seepage with fewer and larger blocks: hundreds of runs are made on it.

    PYTHONPATH=tools python examples/guilhofrei_readings/mesh.py OUTPUT.h5"""

import sys

from quoin_tools.mesh.blockmesh import check, write
from quoin_tools.mesh.dam import G1, dam_part, name_sides
from quoin_tools.mesh.meshing import join
from quoin_tools.mesh.rock import JointSet, jointed_rock

SETS = (JointSet("sheet", 15, 5.0, (0, -2.5)), JointSet("steep", -75, 5.0, (2.0, 0)))  # dips downstream and upstream
UPSTREAM, DOWNSTREAM, DEPTH, COLUMNS = -28.0, 50.0, -27.0, 8  # m, ends of the rock; blocks across the base


def rock_mesh():
    (x0, y0), (x1, y1) = G1.heel, G1.toe
    rock = jointed_rock([(UPSTREAM, DEPTH), (DOWNSTREAM, DEPTH), (DOWNSTREAM, y1), (x1, y1), (x0, y0), (UPSTREAM, y0)], SETS, refine=0)
    joints = dict(rock.face_sets)
    mesh = join([dam_part(G1, COLUMNS), rock])
    shift = len(mesh.blocks) - len(rock.blocks)
    name_sides(mesh, G1)
    mesh.face_sets |= {name: rows + [shift, 0] for name, rows in joints.items()}
    return mesh


if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    made = rock_mesh()
    check(made)
    write(sys.argv[1], made)
    print(f"wrote {sys.argv[1]}: {len(made.blocks)} blocks")
