"""A gravity dam on rock with a joint between them; the default is section G1 of the Guilhofrei dam.

    quoin import dam -o model.h5 --columns 24
    quoin import dam -o model.h5 --section 0,0 60,0 5,55 5,60 0,60 --joint-mesh "finer 4"

x runs downstream, y up, the heel of G1 is the origin. Groups dam, rock; face sets base (both sides of the
joint), upstream, downstream, crest, rock_sides, rock_bottom, rock_top_upstream, rock_top_downstream."""

import argparse
import sys
from dataclasses import dataclass

import numpy as np

from quoin_tools.base import units
from quoin_tools.base.command import Parser, words_of
from quoin_tools.mesh.blockmesh import MeshError, areas, check, write
from quoin_tools.mesh.meshing import face_set_on, graded, join, line, ruled, split_triangles, structured, vertex_at


@dataclass
class Section:
    """Corners of the dam [m], counter-clockwise; `break_` is where the vertical downstream face begins."""

    heel: tuple
    toe: tuple
    break_: tuple
    crest_downstream: tuple
    crest_upstream: tuple

    def corners(self):
        return np.array([self.heel, self.toe, self.break_, self.crest_downstream, self.crest_upstream])

    def height(self):
        return self.crest_upstream[1] - self.heel[1]


def gravity_section(height=33.0, crest_width=5.0, batter=0.05, crest_face=4.85, slope=16.15 / 25.87,
                    base_slope=0.1):
    """Heel at the origin; batter and slope are horizontal per vertical, crest_face is the vertical face."""
    left = batter * height
    right, top_of_slope = left + crest_width, height - crest_face
    toe = (right + slope * top_of_slope) / (1.0 + slope * base_slope)
    return Section((0.0, 0.0), (toe, base_slope * toe), (right, top_of_slope), (right, height),
                   (left, height))


G1 = Section((0.0, 0.0), (22.8, 2.28), (6.65, 28.15), (6.65, 33.0), (1.65, 33.0))


def dam_mesh(section=G1, columns=12, rows=None, rock_columns=None, rock_extent=3.0, triangles=False):
    """The whole model; rock_columns under the dam (default: columns), rock_extent in heights of the dam."""
    dam = dam_part(section, columns, rows)
    rock = rock_part(section, rock_columns or columns, rock_extent * section.height())
    mesh = join([dam, rock])
    name_sides(mesh, section)
    return split_triangles(mesh) if triangles else mesh


def dam_part(section, columns, rows=None):
    """Rows run from the battered face to the downstream faces; a row ends at the break of the slope."""
    heel, toe, break_, right, left = section.corners()
    crest_face = right[1] - break_[1]
    lower, upper = rows or default_rows(section, columns)
    # the upstream end of the row through the break is on the batter, at the level of the break
    at_break = heel + (left - heel) * (break_[1] - heel[1]) / (left[1] - heel[1])
    middle = line(at_break, break_, columns)
    xy = ruled(line(heel, toe, columns), middle, np.linspace(0, 1, lower + 1))
    if crest_face > 0:
        crest = ruled(middle, line(left, right, columns), np.linspace(0, 1, upper + 1))
        xy = np.concatenate([xy, crest[1:]])
    mesh = structured(xy, "dam")
    mesh.face_sets = {}
    return mesh


def default_rows(section, columns):
    """Rows below and above the break, about as high as the columns are wide at the base."""
    heel, toe, break_, right, _ = section.corners()
    width = (toe[0] - heel[0]) / columns
    slope_height = break_[1] - 0.5 * (heel[1] + toe[1])
    return max(1, round(slope_height / width)), max(1, round((right[1] - break_[1]) / width))


def rock_part(section, columns, extent):
    """Rock below and beside the dam, graded away from the base: the first interval is a column's width."""
    (x0, y0), (x1, y1) = section.heel, section.toe
    size = (x1 - x0) / columns
    beside = graded(size, extent, max(1, round(columns * 7 / 12)))
    below = graded(size, extent, max(1, round(columns * 3 / 4))) / extent
    x = np.concatenate([x0 - beside[:0:-1], np.linspace(x0, x1, columns + 1), x1 + beside[1:]])
    top = np.column_stack([x, np.interp(x, [x0, x1], [y0, y1])])
    bottom = np.column_stack([x, np.full(len(x), y0 - extent)])
    down = ruled(top, bottom, below)
    # vertices column by column from the top, blocks row by row from the top, as in the reference meshes
    mesh = structured(down[::-1], "rock", reverse=True)
    levels, stations = down.shape[:2]
    order = np.arange(levels * stations).reshape(levels, stations)[::-1].T.ravel()
    number = np.empty(len(order), dtype=int)
    number[order] = np.arange(len(order))
    mesh.vertices, mesh.blocks, mesh.face_sets = mesh.vertices[order], number[mesh.blocks], {}
    return mesh


def name_sides(mesh, section):
    heel, toe, break_, right, left = section.corners()
    rock = mesh.vertices[mesh.blocks[mesh.block_group == 1]].reshape(-1, 2)
    (x0, y0), x1 = rock.min(axis=0), rock[:, 0].max()
    def on(group, *ends):
        parts = [face_set_on(mesh, a, b, group=group) for a, b in zip(ends[:-1], ends[1:]) if np.any(a != b)]
        return np.concatenate(parts)
    upstream_end, downstream_end = np.array([x0, heel[1]]), np.array([x1, toe[1]])
    corner_left, corner_right = np.array([x0, y0]), np.array([x1, y0])
    mesh.face_sets = {
        "base": np.concatenate([on("dam", heel, toe), on("rock", heel, toe)]),
        "upstream": on("dam", heel, left),
        "downstream": on("dam", toe, break_, right),
        "crest": on("dam", left, right),
        "rock_sides": np.concatenate([on("rock", upstream_end, corner_left),
                                      on("rock", downstream_end, corner_right)]),
        "rock_bottom": on("rock", corner_left, corner_right),
        "rock_top_upstream": on("rock", upstream_end, heel),
        "rock_top_downstream": on("rock", toe, downstream_end),
    }
    mesh.points = {"crest_upstream": vertex_at(mesh, *left), "crest_downstream": vertex_at(mesh, *right),
                   "heel": vertex_at(mesh, *heel, "dam"), "toe": vertex_at(mesh, *toe, "dam"),
                   "rock_heel": vertex_at(mesh, *heel, "rock"), "rock_toe": vertex_at(mesh, *toe, "rock")}


# ---- command line ----------------------------------------------------------------------------------------

def corner(text):
    x, y = text.split(",")
    return float(x), float(y)


def joint_mesh(words, columns):
    """Columns of the rock under the dam from 'equal', 'finer 4' or 'coarser 4'."""
    words = " ".join(words).split()
    if words == ["equal"]:
        return columns
    if len(words) == 2 and words[0] in ("finer", "coarser") and words[1].isdigit():
        found = columns + int(words[1]) * (1 if words[0] == "finer" else -1)
        if found >= 1:
            return found
    raise MeshError(f"--joint-mesh {' '.join(words)}: expected equal, finer N or coarser N, N < columns")


def check_section(section):
    heel, toe, break_, right, left = section.corners()
    if not (heel[0] < toe[0] and max(heel[1], toe[1]) < break_[1] <= right[1]):
        raise MeshError("section: expected heel left of toe, the break of the slope between toe and crest")
    if not (left[0] < right[0] <= break_[0] <= toe[0] and left[1] == right[1]):
        raise MeshError("section: expected a level crest, and a downstream face that falls to the toe")


def options_of(arguments):
    parser = Parser(prog="quoin import dam", description=__doc__.splitlines()[0],
                                     formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    add = parser.add_argument
    add("-o", "--output", required=True, help="block mesh to write")
    add("--section", nargs=5, type=corner, metavar="X,Y",
        help="heel, toe, break of the downstream slope, crest downstream, crest upstream [m], instead of "
             "the six flags below")
    add("--height", type=units.option("m"), default=33.0, help="crest above heel [m]")
    add("--crest-width", type=units.option("m"), default=5.0, help="[m]")
    add("--batter", type=float, default=0.05, help="upstream face, horizontal per vertical")
    add("--crest-face", type=units.option("m"), default=4.85, help="height of the vertical downstream face [m]")
    add("--downstream-slope", type=float, default=16.15 / 25.87, help="horizontal per vertical")
    add("--base-slope", type=float, default=0.1, help="rise of the base, vertical per horizontal")
    add("--columns", type=int, default=12, help="columns of the dam")
    add("--rows", type=int, nargs=2, metavar=("SLOPE", "CREST"),
        help="rows below and above the break of the slope; default: as high as the columns are wide")
    add("--rock-extent", type=float, default=3.0, help="rock to each side and below, in heights of the dam")
    add("--joint-mesh", nargs="+", default=["equal"], metavar="WORD",
        help="columns of the rock under the dam against the dam's: equal, finer N or coarser N")
    add("--triangles", action="store_true", help="split the quadrilaterals in triangles")
    return parser.parse_args(arguments)


def main(arguments=None):
    options = options_of(arguments)
    try:
        section = Section(*options.section) if options.section else gravity_section(
            options.height, options.crest_width, options.batter, options.crest_face,
            options.downstream_slope, options.base_slope)
        check_section(section)
        if options.columns < 1 or options.rock_extent <= 0 or min(options.rows or [1]) < 1:
            raise MeshError("expected at least one column and row, and a positive rock extent")
        rock_columns = joint_mesh(options.joint_mesh, options.columns)
        mesh = dam_mesh(section, options.columns, options.rows, rock_columns, options.rock_extent,
                        options.triangles)
        check(mesh)
        write(options.output, mesh)
    except (MeshError, OSError) as error:
        print(words_of(error), file=sys.stderr)
        return 2
    area = areas(mesh)[mesh.block_group == 0].sum()
    print(f"wrote {options.output}: {len(mesh.blocks)} blocks, {len(mesh.vertices)} vertices, "
          f"dam {area:.2f} m2")
    return 0
