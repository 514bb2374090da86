"""The triangle dam of the paper's Fig. 6 (heel (0, 0), toe (80, 0), apex (0, 100) m) on rigid ground.

Family G: squares of a grid, a triangle at the end of each row on the slope. Family M: n by n mapped on the
triangle, the top row triangles. Vertices and blocks come in the order of tests/data/reference."""

import numpy as np
from quoin_tools.mesh.blockmesh import BlockMesh, MeshError
from quoin_tools.mesh.meshing import face_set_on

BASE, HEIGHT, GROUND_DEPTH = 80.0, 100.0, 10.0


def triangle_dam(n, family="M", ground="segments"):
    """The dam with n columns and rows; ground: one rigid block per joint segment, or a single one."""
    if family not in DAMS or ground not in ("segments", "single"):
        raise MeshError(f"fig6: family {family!r}, ground {ground!r}: expected G or M, segments or single")
    vertices, quads, triangles = DAMS[family](n)
    x = vertices[:n + 1, 0]  # the base comes first
    return assemble(vertices, quads, triangles, x if ground == "segments" else x[[0, -1]])


def assemble(vertices, quads, triangles, ground_x):
    """Put the dam on rigid ground blocks between ground_x, in the order dam, ground top, ground bottom."""
    top = len(vertices)
    count = len(ground_x)
    ground_top = np.column_stack([ground_x, np.zeros(count)])
    i = np.arange(count - 1)
    ground = np.column_stack([top + count + i, top + count + i + 1, top + i + 1, top + i])
    triangles = np.column_stack([np.reshape(triangles, (-1, 3)), np.full(len(triangles), -1)])
    blocks = np.concatenate([np.reshape(quads, (-1, 4)), triangles, ground])
    dam_blocks = len(quads) + len(triangles)
    mesh = BlockMesh(np.concatenate([vertices, ground_top, ground_top - [0.0, GROUND_DEPTH]]), blocks,
                     np.arange(len(blocks)) >= dam_blocks, ["dam", "ground"], [0, 1])
    # the base comes first, the crest last of the dam's vertices
    base = int(np.flatnonzero(np.asarray(vertices)[:, 1] == 0.0)[-1])
    mesh.points = {"crest": top - 1, "heel": 0, "toe": base,
                   "ground_heel": top, "ground_toe": top + count - 1}
    name_sides(mesh)
    return mesh


def name_sides(mesh):
    heel, toe, apex = (0.0, 0.0), (BASE, 0.0), (0.0, HEIGHT)
    below = ((0.0, -GROUND_DEPTH), (BASE, -GROUND_DEPTH))
    mesh.face_sets = {"base": face_set_on(mesh, heel, toe), "upstream": face_set_on(mesh, heel, apex),
                      "downstream": face_set_on(mesh, toe, apex), "ground_bottom": face_set_on(mesh, *below)}


def grid_dam(n):
    """Family G: nodes (80 i/n, 100 j/n), i + j <= n."""
    number, vertices = {}, []
    for j in range(n + 1):
        for i in range(n + 1 - j):
            number[i, j] = len(vertices)
            vertices.append((BASE * i / n, HEIGHT * j / n))
    quads, triangles = [], []
    for j in range(n):
        for i in range(n - j):
            corners = [number[i, j], number[i + 1, j], number[i, j + 1]]
            if i + j < n - 1:
                quads.append([corners[0], corners[1], number[i + 1, j + 1], corners[2]])
            else:
                triangles.append(corners)
    return np.array(vertices), quads, triangles


def mapped_dam(n):
    """Family M: nodes (80 (1 - j/n) i/n, 100 j/n), all columns meet in the apex."""
    vertices = [(BASE * (1 - j / n) * i / n, HEIGHT * j / n) for j in range(n) for i in range(n + 1)]
    vertices.append((0.0, HEIGHT))
    quads = [[j * (n + 1) + i, j * (n + 1) + i + 1, (j + 1) * (n + 1) + i + 1, (j + 1) * (n + 1) + i]
             for j in range(n - 1) for i in range(n)]
    last = (n - 1) * (n + 1)
    triangles = [[last + i, last + i + 1, n * (n + 1)] for i in range(n)]
    return np.array(vertices), quads, triangles


DAMS = {"G": grid_dam, "M": mapped_dam}
