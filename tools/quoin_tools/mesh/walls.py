"""Makes walls in running bond, arches of voussoirs, and slopes of stepped blocks.

    quoin import walls wall -o wall.h5 --courses 8 --blocks 6 --opening 4 8 1 4
    quoin import walls arch -o arch.h5 --voussoirs 21 --radius 10 --thickness 1.5
    quoin import walls slope -o slope.h5

Every stone is a macroblock. Groups block, lintel, base, voussoir, abutment; base and abutment are rigid, to be held
in x and y. Lengths in metres, angles in degrees."""

import argparse
import sys

import numpy as np

from quoin_tools.base import units
from quoin_tools.base.command import Parser, words_of
from quoin_tools.mesh.blockmesh import BlockMesh, MeshError, areas, check, face_ends, macroblocks, outer_faces, write
from quoin_tools.mesh.meshing import face_set_on, face_set_where, join, quad_patch, rectangle, renamed, vertex_at
from quoin_tools.mesh.stacks import CORNERS


def require(possible, what):
    if not possible:
        raise MeshError(f"expected {what}")


# ---- wall ------------------------------------------------------------------------------------------------

def wall(blocks=6, courses=8, length=1.0, height=0.5, openings=(), divide=(1, 1), rigid=True, reach=None):
    """Running bond on a rigid base that is wider by reach (a block): odd courses begin and end with a half block.

    An opening is (first, last, lowest, highest): from half block `first` up to `last`, from course `lowest` up to
    `highest`, all counted from 0, the ends not included. A lintel as deep as a course spans it, resting on half a
    block at each end. divide: blocks per half block across, and up, of each stone.

    Face sets joint_bed, joint_head, joint_base (both sides), left, right, top, opening, bottom (of the base)."""
    require(min(blocks, courses, *divide) >= 1 and min(length, height) > 0, "at least one block, positive lengths")
    bond = stones(blocks, courses, openings)
    half, reach = 0.5 * length, length if reach is None else reach
    bodies = [rectangle(-reach, -height, blocks * length + 2 * reach, height, group="base", rigid=True)]
    bodies[0] = renamed(bodies[0], {"bottom": "bottom", "joint_base": "top"})
    for j, course in enumerate(bond):
        ends = np.flatnonzero(np.diff(course, prepend=-2, append=-2))
        for a, b in zip(ends[:-1], ends[1:]):
            if course[a] >= 0:
                group = "lintel" if course[a] >= 2 * blocks else "block"
                stone = rectangle(a * half, j * height, (b - a) * half, height, (b - a) * divide[0], divide[1],
                                  group, rigid)
                bodies.append(renamed(stone))
    mesh = join(bodies)
    name_wall(mesh, bond, half, height)
    return mesh


def stones(blocks, courses, openings):
    """Stone of every half block, row by row; -1: none, from 2 blocks on: lintels."""
    bond = [(np.arange(2 * blocks) + j % 2) // 2 for j in range(courses)]
    for i, (first, last, lowest, highest) in enumerate(openings):
        inside = 0 < first < last < 2 * blocks and 0 <= lowest < highest < courses
        require(inside, f"opening {i} within the wall, with half a block beside it and a course above")
        for j in range(lowest, highest):
            bond[j][first:last] = -1
        bond[highest][first - 1:last + 1] = 2 * blocks + i
    for i, (first, last, lowest, highest) in enumerate(openings):  # after all of them: none may cut another
        whole = all((bond[j][first:last] == -1).all() for j in range(lowest, highest))
        beside = all(bond[highest - 1][[first - 1, last]] >= 0)
        whole &= bool(beside) and (bond[highest] == 2 * blocks + i).sum() == last - first + 2
        require(whole, f"opening {i} and its lintel clear of the others")
    return bond


def name_wall(mesh, bond, half, height):
    """Sets from where the faces lie: a face between two stones is a joint, others are outside or an opening."""
    faces = outer_faces(mesh)
    faces = faces[mesh.block_group[faces[:, 0]] != mesh.group_names.index("base")]
    ends = mesh.vertices[face_ends(mesh, faces)]
    middle, along = ends.mean(axis=1), ends[:, 1] - ends[:, 0]
    outwards = np.sign(np.round(np.column_stack([along[:, 1], -along[:, 0]]), 12))
    filled = np.pad(np.array(bond) >= 0, 1)
    column, row = np.floor((middle + 0.25 * np.array([half, height]) * outwards) / [half, height]).astype(int).T
    stone = filled[row + 1, column + 1]  # on the other side of the face
    bed, outside = along[:, 0] != 0, ~stone
    sets = {"joint_base": row < 0, "joint_bed": stone & bed, "joint_head": stone & ~bed,
            "left": column < 0, "right": column >= len(bond[0]), "top": row >= len(bond)}
    named = np.any([sets[name] for name in ("joint_base", "left", "right", "top")], axis=0)
    sets["opening"] = outside & ~named
    for name, mine in sets.items():
        if mine.any():
            before = mesh.face_sets.get(name, np.empty((0, 2), dtype=int))
            mesh.face_sets[name] = np.concatenate([before, faces[mine]])
    group = [name for name in mesh.group_names if name != "base"]
    width, top = half * len(bond[0]), height * len(bond)
    for name, x, y in zip(CORNERS, (0, width, 0, width), (0, 0, top, top)):
        mesh.points[name] = stone_vertex(mesh, x, y, group)


def stone_vertex(mesh, x, y, groups):
    """Lowest vertex at a place that belongs to one of the groups."""
    for group in groups:
        try:
            return vertex_at(mesh, x, y, group)
        except MeshError:
            continue
    raise MeshError(f"no stone at ({x:g}, {y:g})")


# ---- arch ------------------------------------------------------------------------------------------------

def arch(voussoirs=21, radius=10.0, thickness=1.5, span_angle=180.0, divide=(1, 1), rigid=True):
    """Arch of equal voussoirs between two rigid abutments; radius is that of the intrados, the centre is (0, 0).

    Voussoirs are numbered from the right springing; divide: blocks along the arch and through it of each.

    Face sets joint (between voussoirs), joint_springing (both sides), intrados, extrados, bottom (backs of the
    abutments), bottom_left and bottom_right (of one, for a support that gives way); points springing_left,
    springing_right on the intrados, crown_intrados, crown_extrados (the vertex next to the crown)."""
    require(voussoirs >= 2 and min(divide) >= 1 and 0 < span_angle <= 270 and span_angle / voussoirs < 90,
            "at least two voussoirs, of less than 90 degrees each, an arch of at most 270 degrees")
    require(min(radius, thickness) > 0, "a positive radius and thickness")
    half = 0.5 * np.radians(span_angle)
    angles = np.linspace(0.5 * np.pi - half, 0.5 * np.pi + half, voussoirs + 1)
    rays = np.column_stack([np.cos(angles), np.sin(angles)])
    rays[np.abs(rays) < 1e-15] = 0.0
    inside, outside = radius * rays, (radius + thickness) * rays
    bodies = [abutment(inside[k], outside[k], sign * thickness, side)
              for k, sign, side in ((0, 1, "right"), (voussoirs, -1, "left"))]
    for i in range(voussoirs):
        body = quad_patch(inside[i + 1], inside[i], outside[i], outside[i + 1], *divide, "voussoir", rigid)
        sets = body.face_sets
        ends = {"joint_springing": [], "joint": []}
        ends["joint_springing" if i == 0 else "joint"].append(sets["right"])
        ends["joint_springing" if i == voussoirs - 1 else "joint"].append(sets["left"])
        body.face_sets = {"intrados": sets["bottom"], "extrados": sets["top"]} | {
            name: np.concatenate(rows) for name, rows in ends.items() if rows}
        body.points = {}
        bodies.append(body)
    mesh = join(bodies)
    mesh.points = {"springing_right": vertex_at(mesh, *inside[0], "voussoir"),
                   "springing_left": vertex_at(mesh, *inside[-1], "voussoir"),
                   "crown_intrados": nearest(mesh, 0.0, radius), "crown_extrados": nearest(mesh, 0.0, radius + thickness)}
    return mesh


def abutment(inner, outer, depth, side):
    """A rigid block behind the springing line; a positive depth goes on clockwise. side: left or right."""
    ray = (outer - inner) / np.hypot(*(outer - inner))
    back = depth * np.array([ray[1], -ray[0]])
    corners = (inner + back, outer + back, outer, inner)
    if depth < 0:
        corners = (outer + back, inner + back, inner, outer)
    return renamed(quad_patch(*corners, 1, 1, "abutment", True),
                   {"bottom": "bottom", f"bottom_{side}": "bottom", "joint_springing": "top"})


def nearest(mesh, x, y):
    return int(np.argmin(np.round(np.hypot(mesh.vertices[:, 0] - x, mesh.vertices[:, 1] - y), 9)))


# ---- slope -----------------------------------------------------------------------------------------------

def slope(columns=16, crest=10, width=10.0, tread_dip=30.0, step=1.0, rise=5.0, fall=5.2, depth=None, rigid=True):
    """Columns on a rigid stepped base, as in toppling tests; the default is the example of Goodman and Bray (1976).

    In the frame that is turned by tread_dip, the treads are level, each higher by `step` than the one before;
    tops rise by `rise` per column as far as column `crest` and fall by `fall` behind it. Column 1 is at the toe,
    on the left, with a tread of the base before it; depth is that of the base below the treads (two widths).

    Face sets joint (between columns), joint_base (both sides), face (free sides and tops), bottom (of the base);
    points top_1 ... (the upper corner of a column on the side of the toe), toe."""
    require(columns >= 1 and 1 <= crest <= columns and width > 0 and step >= 0, "1 <= crest <= columns, a width")
    number = np.arange(1, columns + 1)
    low = step * number
    high = np.where(number <= crest, rise * number, rise * crest - fall * (number - crest))
    require((high > low + 1e-9).all() and 0 <= tread_dip < 90, "columns of positive height, a dip below 90 degrees")
    depth = 2.0 * width if depth is None else depth
    bodies = [stepped_base(columns, width, step, depth)]
    for i in range(columns):
        left, right = i * width, (i + 1) * width
        body = quad_patch((left, low[i]), (right, low[i]), (right, high[i]), (left, high[i]), 1, 1, "block", rigid)
        bodies.append(renamed(body, {}, {f"top_{i + 1}": "top_left"} | ({} if i else {"toe": "bottom_left"})))
    mesh = join(bodies)
    name_slope(mesh, width, depth, low, high)
    angle = np.radians(tread_dip)
    mesh.vertices = mesh.vertices @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return mesh


def stepped_base(columns, width, step, depth):
    """Tread 0 is the one before the toe, level with the first; risers have faces of their own."""
    level = step * np.maximum(np.arange(columns + 1), 1)  # of treads 0, 1 ...
    x = width * np.arange(-1, columns + 1)
    floor = np.append(level - depth, level[-1] - depth)
    require(depth > step, "a base deeper than a step")
    vertices, number, blocks = [], {}, []
    def node(x, y):
        return number.setdefault((float(x), float(y)), len(number))
    for i in range(columns + 1):
        a, b = x[i], x[i + 1]
        below, beyond, left, right = (node(a, floor[i]), node(b, floor[i + 1]), node(a, level[i]), node(b, level[i]))
        before = node(a, level[i - 1]) if i else left  # the riser is from here to the tread
        if before == left:
            blocks.append([below, beyond, right, left])
        else:
            blocks += [[below, beyond, before, -1], [before, beyond, right, left]]
    vertices = np.array(list(number))
    return BlockMesh(vertices, blocks, np.zeros(len(blocks)), ["base"], [1])


def name_slope(mesh, width, depth, low, high):
    """In the frame of the treads: sides of columns that meet are joint, what meets the base is joint_base."""
    columns = len(low)
    sets = {name: [] for name in ("joint", "joint_base", "face", "bottom")}
    for i in range(columns):
        left, right = i * width, (i + 1) * width
        corners = [(left, low[i]), (right, low[i]), (right, high[i]), (left, high[i])]
        names = ["joint_base", "joint" if i < columns - 1 else "face", "face", "joint" if i else "face"]
        for name, a, b in zip(names, corners, corners[1:] + corners[:1]):
            sets[name].append(own_face(mesh, i, a, b))
        sets["joint_base"].append(face_set_on(mesh, *corners[:2], group="base"))
        if i and low[i] > low[i - 1]:
            sets["joint_base"].append(face_set_on(mesh, (left, low[i - 1]), (left, low[i]), group="base"))
    sets["joint_base"].append(face_set_on(mesh, (-width, low[0]), (0, low[0]), group="base"))
    level = np.concatenate([low[:1], low])
    sets["bottom"] = [face_set_where(mesh, lambda x, y: y < np.interp(x, width * np.arange(-1, columns + 1),
                                     np.append(level, level[-1])) - 0.5 * depth, "base")]
    mesh.face_sets = {name: np.concatenate(rows) for name, rows in sets.items() if len(rows)}


def own_face(mesh, i, a, b):
    """Returns the face from a to b of column i."""
    faces = face_set_on(mesh, a, b, group="block")
    first = np.flatnonzero(mesh.block_group == mesh.group_names.index("block"))[i]
    return faces[faces[:, 0] == first]


# ---- command line ----------------------------------------------------------------------------------------

def options_of(arguments):
    parser = Parser(prog="quoin import walls", description=__doc__.splitlines()[0])
    kinds = parser.add_subparsers(dest="kind", required=True)
    def kind(name, what):
        sub = kinds.add_parser(name, help=what, description=what,
                               formatter_class=argparse.ArgumentDefaultsHelpFormatter)
        sub.add_argument("-o", "--output", required=True, help="block mesh to write")
        sub.add_argument("--deformable", action="store_true", help="stones deform; default: they are rigid")
        return sub.add_argument
    add = kind("wall", "wall in running bond on a rigid base")
    add("--blocks", type=int, default=6, help="in a course")
    add("--courses", type=int, default=8, help="of the wall")
    add("--length", type=units.option("m"), default=1.0, help="of a block [m]")
    add("--height", type=units.option("m"), default=0.5, help="of a course [m]")
    add("--opening", nargs=4, type=int, action="append", default=[], metavar=("FIRST", "LAST", "LOW", "HIGH"),
        help="half blocks FIRST up to LAST, courses LOW up to HIGH, from 0; can be given again")
    add("--divide", nargs=2, type=int, default=(1, 1), metavar=("NX", "NY"), help="blocks per half block, and up")
    add = kind("arch", "arch of voussoirs between rigid abutments")
    add("--voussoirs", type=int, default=21, help="number of them")
    add("--radius", type=units.option("m"), default=10.0, help="of the intrados [m]")
    add("--thickness", type=units.option("m"), default=1.5, help="of the arch [m]")
    add("--span-angle", type=units.option("degree"), default=180.0, help="from springing to springing [degrees]")
    add("--divide", nargs=2, type=int, default=(1, 1), metavar=("NX", "NY"), help="blocks along, and through")
    add = kind("slope", "columns on a rigid stepped base")
    add("--columns", type=int, default=16, help="number of them")
    add("--crest", type=int, default=10, help="column at the crest")
    add("--width", type=units.option("m"), default=10.0, help="of a column [m]")
    add("--tread-dip", type=units.option("degree"), default=30.0, help="of the treads [degrees]")
    add("--step", type=units.option("m"), default=1.0, help="height of a step [m]")
    add("--rise", type=units.option("m"), default=5.0, help="of the tops, per column, below the crest [m]")
    add("--fall", type=units.option("m"), default=5.2, help="of the tops, per column, behind the crest [m]")
    return parser.parse_args(arguments)


def build(options):
    rigid = not options.deformable
    if options.kind == "wall":
        return wall(options.blocks, options.courses, options.length, options.height, options.opening,
                    options.divide, rigid)
    if options.kind == "arch":
        return arch(options.voussoirs, options.radius, options.thickness, options.span_angle, options.divide, rigid)
    return slope(options.columns, options.crest, options.width, options.tread_dip, options.step, options.rise,
                 options.fall, rigid=rigid)


def main(arguments=None):
    options = options_of(arguments)
    try:
        mesh = build(options)
        check(mesh)
        write(options.output, mesh)
    except (MeshError, OSError) as error:
        print(words_of(error), file=sys.stderr)
        return 2
    print(f"wrote {options.output}: {macroblocks(mesh).max() + 1} macroblocks, {len(mesh.blocks)} blocks, "
          f"{len(mesh.vertices)} vertices, {areas(mesh).sum():.2f} m2")
    return 0
