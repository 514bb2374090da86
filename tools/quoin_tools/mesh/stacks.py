"""Columns, patches, cantilevers and grids of macroblocks for tests and benchmarks.

Face sets left, right, bottom, top are the outer sides, joint the faces on both sides of the joints. `base` is
a rigid group below the bodies; with a base, bottom is the underside of the base, to be held there."""

import numpy as np

from quoin_tools.mesh.blockmesh import BlockMesh, face_ends, outer_faces
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed, split_triangles

CORNERS = ("bottom_left", "bottom_right", "top_left", "top_right")


def column(n, width=1.0, height=1.0, rigid=True, base=True, overhang=None, base_depth=1.0):
    """n single blocks on top of each other, each a macroblock, on a rigid base that is wider by overhang.

    Joints: joint_0 is the lowest one (on the base), joint_1 the next ...; joint is all of them. The base
    reaches out by half a width, so that a block that slides or rocks stays on it. Points: corners of the
    column, and block_1 ... block_n, the lower left vertex of each."""
    bodies = []
    if base:
        reach = 0.5 * width if overhang is None else overhang
        ground = rectangle(-reach, -base_depth, width + 2 * reach, base_depth, group="base", rigid=True)
        bodies.append(renamed(ground, {"bottom": "bottom", "joint_0": "top"}))
    for i in range(n):
        body = rectangle(0.0, i * height, width, height, group="block", rigid=rigid)
        below = f"joint_{i if base else i - 1}" if base or i > 0 else "bottom"
        above = f"joint_{i + 1 if base else i}" if i < n - 1 else "top"
        points = {f"block_{i + 1}": "bottom_left"}
        if i == 0:
            points |= {"bottom_left": "bottom_left", "bottom_right": "bottom_right"}
        if i == n - 1:
            points |= {"top_left": "top_left", "top_right": "top_right"}
        sides = {below: "bottom", above: "top", "left": "left", "right": "right"}
        bodies.append(renamed(body, sides, points))
    return with_joint(join(bodies))


def with_joint(mesh):
    """Unite joint_0, joint_1 ... in the face set joint."""
    parts = [rows for name, rows in mesh.face_sets.items() if name.startswith("joint_")]
    if parts:
        mesh.face_sets["joint"] = np.concatenate(parts)
    return mesh


def one_contact(length=1.0, height=1.0, rigid=True, overhang=None):
    """One block on one contact of the given length, on a wider rigid base (V06, V07)."""
    return column(1, length, height, rigid, overhang=overhang)


def two_bodies(nx_lower=2, nx_upper=3, ny_lower=None, ny_upper=None, size=1.0, base=False, rigid=False,
               triangles=False):
    """Two square bodies with non-matching faces on their joint (V02); ny is nx if not given.

    Groups lower, upper, base; the joint on the base is joint_base. Points lower_* and upper_* at corners."""
    lower = rectangle(0.0, 0.0, size, size, nx_lower, ny_lower or nx_lower, "lower", rigid)
    upper = rectangle(0.0, size, size, size, nx_upper, ny_upper or nx_upper, "upper", rigid)
    sides = {"left": "left", "right": "right"}
    below = "joint_base" if base else "bottom"
    bodies = [renamed(lower, sides | {below: "bottom", "joint": "top"}, {f"lower_{c}": c for c in CORNERS}),
              renamed(upper, sides | {"joint": "bottom", "top": "top"}, {f"upper_{c}": c for c in CORNERS})]
    if triangles:
        bodies = [split_triangles(body) for body in bodies]
    if base:
        ground = rectangle(0.0, -size, size, size, group="base", rigid=True)
        bodies.append(renamed(ground, {"bottom": "bottom", "joint_base": "top"}))
    return join(bodies)


def block_on_plane(width=1.0, height=0.2, slope_degrees=30.0, plane_length=None, start=None, rigid=True):
    """A block on an inclined plane that falls to the right (V05, V13).

    The base is a rigid block with an inclined top of plane_length (3 widths), its lower end at the origin;
    the block starts `start` below the upper end (a quarter width). Left is the block's upslope side."""
    length = 3.0 * width if plane_length is None else plane_length
    start = 0.25 * width if start is None else start
    angle = np.radians(slope_degrees)
    down, up = np.array([np.cos(angle), -np.sin(angle)]), np.array([np.sin(angle), np.cos(angle)])
    upper_end, lower_end = -length * down, np.zeros(2)
    depth = -max(width, height)
    base = quad_patch((upper_end[0], depth), (0.0, depth), lower_end, upper_end, 1, 1, "base", True)
    a = upper_end + start * down
    b = a + width * down
    block = quad_patch(a, b, b + height * up, a + height * up, 1, 1, "block", rigid)
    return join([renamed(base, {"bottom": "bottom", "joint": "top"}),
                 renamed(block, {"joint": "bottom", "left": "left", "right": "right", "top": "top"},
                         {c: c for c in CORNERS})])


def cantilever(nx, ny, length=10.0, height=1.0, triangles=False):
    """A beam from x = 0 (left, its root) to x = length, y from -height/2 to height/2 (V03)."""
    beam = rectangle(0.0, -0.5 * height, length, height, nx, ny)
    return split_triangles(beam) if triangles else beam


def patch_test(triangles=False):
    """MacNeal's patch of five quadrilaterals (V01); points outer_0..3 and inner_0..3 counter-clockwise."""
    vertices = [(0, 0), (.24, 0), (.24, .12), (0, .12), (.04, .02), (.18, .03), (.16, .08), (.08, .08)]
    blocks = [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7)]
    sets = {"bottom": [(0, 0)], "right": [(1, 0)], "top": [(2, 0)], "left": [(3, 0)]}
    points = {f"outer_{i}": i for i in range(4)} | {f"inner_{i}": 4 + i for i in range(4)}
    mesh = BlockMesh(vertices, blocks, np.zeros(5), ["body"], [0], sets, points)
    return split_triangles(mesh) if triangles else mesh


def block_grid(nx, ny, mx, my, size=1.0, triangle_every=0, rigid_every=0):
    """nx by ny square macroblocks of mx by my quadrilaterals, joints between all of them.

    Every triangle_every-th macroblock is split in triangles, every rigid_every-th one is rigid (group rigid;
    0: none); macroblocks and their vertices are numbered row by row from the lower left one."""
    y, x = np.meshgrid(np.linspace(0, size, my + 1), np.linspace(0, size, mx + 1), indexing="ij")
    local = np.stack([x, y], axis=2).reshape(-1, 2)
    column_of, row_of = np.tile(np.arange(nx), ny), np.repeat(np.arange(ny), nx)
    origin = size * np.column_stack([column_of, row_of])
    vertices = (origin[:, None] + local).reshape(-1, 2)
    node = np.arange(len(local)).reshape(my + 1, mx + 1)
    quads = np.stack([node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1]], axis=2).reshape(-1, 4)
    blocks = (np.arange(nx * ny)[:, None, None] * len(local) + quads).reshape(-1, 4)

    macroblock = np.repeat(np.arange(nx * ny), mx * my)
    rigid = every(macroblock, rigid_every)
    names, flags = (["block", "rigid"], [0, 1]) if rigid.any() else (["block"], [0])
    mesh = BlockMesh(vertices, blocks, rigid, names, flags)
    if triangle_every:
        mesh = split_triangles(mesh, every(macroblock, triangle_every))
    name_grid(mesh, size * nx, size * ny)
    return mesh


def every(index, k):
    """True for the k-th, 2k-th ... index (counted from 1); k = 0: never."""
    return (index + 1) % k == 0 if k else np.zeros(len(index), dtype=bool)


def name_grid(mesh, width, height):
    """Outer faces on the outline get its four sides, all the others are joint; points at the corners."""
    faces = outer_faces(mesh)
    middle = mesh.vertices[face_ends(mesh, faces)].mean(axis=1)
    close = 1e-9 * max(width, height)
    sides = {"left": middle[:, 0] < close, "right": middle[:, 0] > width - close,
             "bottom": middle[:, 1] < close, "top": middle[:, 1] > height - close}
    for name, on_side in sides.items():
        mesh.face_sets[name] = faces[on_side]
    inside = ~np.any(list(sides.values()), axis=0)
    if inside.any():
        mesh.face_sets["joint"] = faces[inside]
    for name, x, y in zip(CORNERS, (0, width, 0, width), (0, 0, height, height)):
        mesh.points[name] = int(np.argmin(np.hypot(mesh.vertices[:, 0] - x, mesh.vertices[:, 1] - y)))
