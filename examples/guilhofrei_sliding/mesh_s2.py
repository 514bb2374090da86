"""Block mesh for S2: section G1 and the rock it would carry along on a plane below the shear key.

    PYTHONPATH=tools python examples/guilhofrei_sliding/mesh_s2.py OUTPUT.h5 [COLUMNS]

The paper shows the plane in a drawing only. Here it starts DEPTH below the heel and rises by SLOPE to the ground at the level of
the toe. Groups dam, foundation (what moves with it), rock; face sets base, plane (both sides) and plane_below_dam, which
has the uplift. The trench of the key is open upstream, so nothing presses on the foundation's upstream face."""

import sys

import numpy as np
from quoin_tools.mesh.blockmesh import BlockMesh, check, write
from quoin_tools.mesh.dam import G1, dam_part
from quoin_tools.mesh.meshing import face_set_on, graded, join, ruled, structured, vertex_at

DEPTH, SLOPE = 1.15, 0.07  # m, rise per metre: the middle of 1.0 to 1.3 m and 6 to 8 %
END = (G1.toe[1] + DEPTH) / SLOPE  # m, where the plane meets the ground
EXTENT = 3 * G1.height()


def stations(columns):
    """x of the plane's vertices: those of the dam's base, and about as far apart beyond the toe."""
    beyond = max(2, round(columns * (END - G1.toe[0]) / G1.toe[0]))
    return np.concatenate([np.linspace(0, G1.toe[0], columns + 1), np.linspace(G1.toe[0], END, beyond + 1)[1:]])


def foundation(x):
    """One row of blocks between plane and ground; the last is a triangle."""
    n = len(x) - 1
    bottom = np.column_stack([x, SLOPE * x - DEPTH])
    top = np.column_stack([x, np.minimum(x * G1.toe[1] / G1.toe[0], G1.toe[1])])[:-1]
    blocks = [[i, i + 1, n + 2 + i, n + 1 + i] for i in range(n - 1)] + [[n - 1, n, 2 * n, -1]]
    return BlockMesh(np.concatenate([bottom, top]), np.array(blocks), np.zeros(n), ["foundation"], [0], {}, {})


def rock(x):
    """Rock below the plane and on both sides of it."""
    size = x[1] - x[0]
    beside, below = graded(size, EXTENT, 9), graded(size, EXTENT, 11) / EXTENT
    x = np.concatenate([-beside[:0:-1], x, END + beside[1:]])
    top = np.column_stack([x, SLOPE * np.clip(x, 0, END) - DEPTH])
    bottom = np.column_stack([x, np.full(len(x), -EXTENT)])
    mesh = structured(ruled(top, bottom, below)[::-1], "rock")
    mesh.face_sets = {}
    return mesh


def plane_mesh(columns=15):
    x = stations(columns)
    mesh = join([dam_part(G1, columns), foundation(x), rock(x)])
    foot, under_toe, end = (0, -DEPTH), (G1.toe[0], SLOPE * G1.toe[0] - DEPTH), (END, G1.toe[1])
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)

    def both(a, b, *groups):
        return np.concatenate([face_set_on(mesh, a, b, group=group) for group in groups])

    under = both(foot, under_toe, "foundation", "rock")
    mesh.face_sets = {
        "base": both(G1.heel, G1.toe, "dam", "foundation"),
        "plane": np.concatenate([under, both(under_toe, end, "foundation", "rock")]),
        "plane_below_dam": under,
        "upstream": face_set_on(mesh, G1.heel, G1.crest_upstream, group="dam"),
        "rock_sides": np.concatenate([both((low[0], -DEPTH), low, "rock"), both((high[0], G1.toe[1]), (high[0], low[1]), "rock")]),
        "rock_bottom": both(low, (high[0], low[1]), "rock"),
    }
    mesh.points = {"crest_upstream": vertex_at(mesh, *G1.crest_upstream), "crest_downstream": vertex_at(mesh, *G1.crest_downstream),
                   "heel": vertex_at(mesh, *G1.heel, "dam"), "toe": vertex_at(mesh, *G1.toe, "dam")}  # fmt: skip
    return mesh


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3) or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    made = plane_mesh(*map(int, sys.argv[2:]))
    check(made)
    write(sys.argv[1], made)
    print(f"wrote {sys.argv[1]}: {len(made.blocks)} blocks")
