"""Makes a dam of random Voronoi polygons between facing courses of quadrilaterals; the default is section G1.

    quoin import voronoi -o model.h5 --seed 1
    quoin import voronoi -o model.h5 --section 0,0 20,0 5,25 5,30 0,30 --side 1.5 --facing 0 1 --rock 2

Corners of the section are counter-clockwise from the heel; its first side is the base, level sides at the top are
the crest, those before it the downstream face, those behind it the upstream face. Every polygon and every
quadrilateral of the facing is a macroblock, with one face on each of its sides. Groups dam, facing, rock; face sets
joint (all joints above the base), base, upstream, downstream, crest; points heel, toe, crest_upstream,
crest_downstream; with rock also those of mesh/dam.py."""

import argparse
import math
import os
import sys
import time
from dataclasses import dataclass

import numpy as np
import scipy
import shapely

from quoin_tools.base import units
from quoin_tools.base.command import Parser, words_of
from quoin_tools.mesh import crest, polygons
from quoin_tools.mesh.blockmesh import BlockMesh, MeshError, areas, check, cross, face_ends, macroblocks, quality, write
from quoin_tools.mesh.dam import G1, corner
from quoin_tools.mesh.meshing import (
    double_vertices,
    face_set_on,
    faces_on_edges,
    graded,
    join,
    line,
    ruled,
    structured,
    vertex_at,
)

FACES = ("base", "downstream", "crest", "upstream")
DRAWN = 4096  # random points drawn at a time
MOST = 1e6  # polygons: half an hour
FOLDED = 240.0  # degrees: a corner of a polygon beyond folds it
SHARPEST = 5.0  # degrees: sharper corners of blocks bring a warning


@dataclass
class Options:
    """Lengths in metres. side: mean side of a polygon; shortest: no side is shorter (default: a quarter of side);
    facing: thickness upstream and downstream (0: none); course: height of a course; square: joints between courses
    square to the face, not turning from the base to the next side; lloyd: steps towards even polygons; refine: times
    every block is cut in quadrilaterals; rock: heights of the dam to each side and below (0: no rock); joints: False
    welds all polygons (the continuum of the same blocks); base: how many sides of the section, the first ones, are its base;
    coping: height of one stone over the whole crest (0: none); bonded: all stones with a centre in these uppermost metres are one body (0: none)."""

    side: float = 2.0
    seed: int = 1
    shortest: float | None = None
    facing: tuple = (1.0, 1.0)
    course: float = 1.0
    square: bool = False
    lloyd: int = 1
    refine: int = 0
    rock: float = 0.0
    joints: bool = True
    base: int = 1
    coping: float = 0.0
    bonded: float = 0.0

    def least(self):
        return 0.25 * self.side if self.shortest is None else self.shortest

    def finest(self):
        """Returns (shortest side, smallest area) of stones and facing that are cut."""
        facing = [thickness for thickness in self.facing if thickness]
        side = min([self.least(), *(0.4 * size for size in (*facing, *([self.course] if facing else [])))])
        return side, min([0.15 * 2.2 * self.side**2, *(0.4 * size * self.course for size in facing)])


def voronoi_mesh(section=None, options=None, progress=lambda what: None):
    """Makes the model of a section: corners [m], default G1. progress(line): receives the progress."""
    options = options or Options()
    section = checked_section(G1.corners() if section is None else section, options)
    tess, facing = tessellate(section, options, progress)
    progress(f"{len(tess.rings)} polygons to be cut in blocks")
    mesh = block_mesh(tess, facing, section, options)
    return with_rock(mesh, section, options.rock) if options.rock > 0 else mesh


# ---- section and facing ----------------------------------------------------------------------------------

def checked_section(section, options):
    section = np.asarray(section, dtype=float).reshape(-1, 2)
    polygon = shapely.Polygon(section) if len(section) >= 3 else None
    if polygon is None or not np.isfinite(section).all() or not polygon.is_valid or polygons.area(section) <= 0:
        raise MeshError("section: expected at least three corners, counter-clockwise, sides that do not cross")
    numbers = [options.side, options.course, options.least(), 1 + options.rock, *(1 + np.array(options.facing))]
    if not (np.isfinite(numbers).all() and min(numbers[:3]) > 0 and min(numbers[3:]) >= 1):
        raise MeshError("expected positive lengths; 0 for no facing or no rock")
    if options.least() > 0.5 * options.side or min(options.lloyd, options.refine, options.seed) < 0:
        raise MeshError("expected a shortest side of at most half the mean side, and no negative numbers")
    if (count := polygons.area(section) / (2.2 * options.side**2)) > MOST:
        raise MeshError(f"side: about {count:.3g} polygons, expected at most {MOST:g}")
    reach = section[:, 1].max() - section[: options.base + 1, 1].max()
    for name, height in (("coping", options.coping), ("bonded", options.bonded)):
        if not (height == 0 or 0 < height < reach):
            raise MeshError(f"{name}: {height:g}: expected less than the {reach:g} m of the crest above the base, 0 for none")
    if section[0, 0] >= section[1, 0] or max(section[:2, 1]) >= section[:, 1].max():
        raise MeshError("section: its first side is not a base from heel to toe below the crest")
    return section


def face_names(section, base=1):
    """Returns the name of each side of the section; the first `base` sides are its base."""
    high = section[:, 1] > section[:, 1].max() - 1e-9
    level = high & np.roll(high, -1)
    top = np.flatnonzero(high)
    names = ["crest" if level[k] else "downstream" if k < top[0] else "upstream" for k in range(len(section))]
    return ["base"] * base + names[base:]


def inner_section(section, thickness):
    """Corners moved inwards so that side k moves by thickness[k]."""
    along = np.roll(section, -1, axis=0) - section
    along /= np.hypot(*along.T)[:, None]
    inwards = np.column_stack([-along[:, 1], along[:, 0]])
    result = section.copy()
    for k in range(len(section)):
        pair = [k - 1, k]
        if abs(np.linalg.det(inwards[pair])) < 1e-9:
            result[k] += thickness[k] * inwards[k]
        elif thickness[k - 1] or thickness[k]:
            result[k] += np.linalg.solve(inwards[pair], [thickness[k - 1], thickness[k]])
    return result


def facing_courses(section, options):
    """Quadrilaterals on the faces, and the inner section with the nodes that they have on it."""
    width = {"upstream": options.facing[0], "downstream": options.facing[1]}
    thickness = np.array([width.get(name, 0.0) for name in face_names(section, options.base)])
    inner = inner_section(section, thickness)
    quads, anchors = [], [inner]
    for k in np.flatnonzero(thickness):
        following = (k + 1) % len(section)
        a, b = section[[k, following]]
        n = max(1, round(math.dist(a, b) / options.course))
        outside, inside = line(a, b, n), line(*inner[[k, following]], n)
        if options.square:
            outside[1:-1] = inside[1:-1] + thickness[k] * np.array([b[1] - a[1], a[0] - b[0]]) / math.dist(a, b)
        quads += [np.array([outside[i], outside[i + 1], inside[i + 1], inside[i]]) for i in range(n)]
        anchors.append(inside[1:-1])
    fits = shapely.Polygon(inner).is_valid and polygons.area(inner) > 0
    if not fits or any(polygons.corner_quality(quad, range(4)) <= 0 for quad in quads):
        raise MeshError("the facing is too thick for the section")
    return quads, inner, np.concatenate(anchors), thickness


# ---- polygons --------------------------------------------------------------------------------------------

def tessellate(section, options, progress=lambda what: None):
    """Polygons and facing of a section; of three numbers of seeds the one whose mean side fits best."""
    quads, inner, anchors, thickness = facing_courses(section, options)
    size = polygons.area(inner)
    count, best = size / (2.2 * options.side**2), None
    for attempt in range(3):
        progress(f"tessellation {attempt + 1} of 3, of {max(1, round(count))} seeds")
        tess = inner_tessellation(inner, anchors, thickness, max(1, round(count)), options)
        mean = mean_side(tess)
        if best is None or abs(mean - options.side) < abs(best[0] - options.side):
            best = mean, tess
        count *= (mean / options.side) ** 2
    tess = best[1]
    whole = polygons.tessellation(quads + tess.polygons())
    facing = np.arange(len(whole.rings)) < len(quads)
    return crest.coped(whole, facing, section, options.coping, options.finest()) if options.coping else (whole, facing)


def inner_tessellation(inner, anchors, thickness, count, options):
    """Tidy Voronoi polygons of the inner section whose nodes on a facing are those of the facing."""
    rng = np.random.default_rng(options.seed)
    polygon = shapely.Polygon(inner)
    spacing = math.sqrt(polygon.area / count)
    seeds = scatter(polygon, count, 0.7 * spacing, rng)
    for _ in range(options.lloyd):
        centre = shapely.get_coordinates(shapely.centroid(cells(seeds, polygon, spacing)[0]))
        seeds = np.where(shapely.contains_xy(polygon, centre)[:, None], centre, seeds)
    whole, parts = cells(seeds, polygon, spacing)
    pieces = shapely.get_parts(np.concatenate([whole, parts]))
    rings = [polygons.ring_of(part) for part in pieces[shapely.area(pieces) > 0]]
    tess = polygons.tessellation(rings, anchors, 1e-6 * options.side)
    fitted = snapped(tess, inner, np.flatnonzero(thickness), len(anchors))
    fitted = fitted and polygons.tidy(fitted, options.least(), 0.15 * polygon.area / count)
    if fitted and max(polygons.corner_angles(xy).max() for xy in fitted.polygons()) < FOLDED:
        return fitted
    return polygons.tidy(tess, options.least(), 0.15 * polygon.area / count)


def scatter(polygon, count, distance, rng):
    """Random points in a polygon, no closer than the distance; it shrinks when they do not fit."""
    left, bottom, right, top = polygon.bounds
    low, size = np.array([left, bottom]), np.array([right - left, top - bottom])
    points, misses, cell = [], 0, distance  # points in square cells: those near one are in nine of them
    grid = {}
    shapely.prepare(polygon)
    while len(points) < count:
        drawn = low + size * rng.random((DRAWN, 2))
        for point, inside in zip(drawn.tolist(), shapely.contains_xy(polygon, drawn).tolist()):
            x, y = point
            i, j = math.floor(x / cell), math.floor(y / cell)
            if inside and all(math.hypot(x - a, y - b) > distance for column in (i - 1, i, i + 1)
                              for row in (j - 1, j, j + 1) for a, b in grid.get((column, row), ())):
                points.append(point)
                grid.setdefault((i, j), []).append(point)
                misses = 0
            else:
                misses += 1
            if misses > 200 + 20 * len(points):
                distance, misses = 0.9 * distance, 0
            if len(points) == count:
                break
    return np.array(points)


def cells(seeds, polygon, spacing):
    """Voronoi cells in the polygon; and what lies nearest to a mirror image of a seed, near a corner.

    Images of the seeds beyond the nearest sides make the cells end square on them."""
    images = mirrored(seeds, polygon, 2.0 * spacing)
    middle, far = np.mean(polygon.bounds[::2]), 10 * max(polygon.bounds[2] - polygon.bounds[0], spacing)
    far = max(far, 10 * (polygon.bounds[3] - polygon.bounds[1]))
    level = np.mean(polygon.bounds[1::2])
    frame = np.array([(middle + far * math.cos(a), level + far * math.sin(a)) for a in np.arange(6) * math.pi / 3])
    diagram = scipy.spatial.Voronoi(np.concatenate([seeds, images, frame]))
    regions = [diagram.regions[at] for at in diagram.point_region[:len(seeds) + len(images)].tolist()]
    corners = diagram.vertices[[corner for region in regions for corner in region]]
    region = np.repeat(np.arange(len(regions)), [len(region) for region in regions])
    hulls = shapely.convex_hull(shapely.multipoints(corners, indices=region))
    found = areal(shapely.intersection(hulls, polygon))
    rest = found[len(seeds):]
    return found[:len(seeds)], rest[shapely.area(rest) > 1e-9 * spacing**2]


def areal(shapes):
    """Returns the polygons of each shape, without points and lines."""
    parts, owner = shapely.get_parts(shapes, return_index=True)
    flat = shapely.get_type_id(parts) == shapely.GeometryType.POLYGON
    empty = np.setdiff1d(np.arange(len(shapes)), owner[flat])
    order = np.argsort(np.concatenate([owner[flat], empty]), kind="stable")
    parts = np.concatenate([parts[flat], np.full(len(empty), shapely.Polygon())])
    return shapely.multipolygons(parts[order], indices=np.sort(np.concatenate([owner[flat], empty])))


def mirrored(seeds, polygon, reach):
    """Images of the seeds within reach of a side, at its height, that fall outside."""
    ring = polygons.ring_of(polygon)
    images = []
    for a, b in zip(ring, np.roll(ring, -1, axis=0)):
        along = (b - a) / math.dist(a, b)
        t = (seeds - a) @ along
        foot = a + t[:, None] * along
        near = (t > 0) & (t < math.dist(a, b)) & (np.hypot(*(seeds - foot).T) < reach)
        images.append(2 * foot[near] - seeds[near])
    images = np.concatenate(images)
    return images[~shapely.contains_xy(polygon, *images.T)]


def snapped(tess, inner, sides, anchors):
    """Nodes on the sides of the inner section that have a facing go to the nearest node of it, if possible to
    one that is no corner of the section, where polygons would get sharp. None where polygons are too small for that:
    then their nodes stay, and several of them lie along one stone of the facing."""
    along = np.roll(inner, -1, axis=0) - inner
    sharp = np.flatnonzero(cross(np.roll(along, 1, axis=0), along) > 0)  # corners come first among the anchors
    moved = polygons.Tessellation(tess.nodes.copy(), list(tess.rings), tess.rank)
    for k in sides:
        a, b = inner[[k, (k + 1) % len(inner)]]
        along = (b - a) / math.dist(a, b)
        def on_side(nodes, a=a, b=b, along=along):
            t, off = (nodes - a) @ along, np.abs((nodes - a) @ [along[1], -along[0]])
            return (off < 1e-9 * math.dist(a, b)) & (t > -1e-9) & (t < math.dist(a, b) + 1e-9)
        fixed = np.flatnonzero(on_side(moved.nodes[:anchors]) & (moved.rank[:anchors] == polygons.FIXED))
        for node in np.flatnonzero(on_side(moved.nodes) & (moved.rank == polygons.LINE)):
            distance = np.hypot(*(moved.nodes[fixed] - moved.nodes[node]).T)
            nearest = fixed[np.lexsort([distance, np.isin(fixed, sharp)])[:3]].tolist()
            if not polygons.merge(moved, [(keep, int(node), moved.nodes[keep]) for keep in nearest]):
                return None
    return moved.compact()


def mean_side(tess):
    """Mean length of the sides of the polygons; a side can have several nodes."""
    node, back, ahead = polygons.around(tess.rings)
    xy = tess.nodes[node]
    before, after = xy - xy[back], xy[ahead] - xy
    turn = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
    corner = np.flatnonzero(turn > 1e-6 * np.hypot(*before.T) * np.hypot(*after.T))
    ring = np.repeat(np.arange(len(tess.rings)), [len(ring) for ring in tess.rings])[corner]
    first = np.unique(ring, return_index=True)[1]
    following = np.arange(len(corner)) + 1
    following[np.append(first[1:], len(ring)) - 1] = first  # the last of a ring
    return float(np.hypot(*(xy[corner[following]] - xy[corner]).T).mean())


# ---- mesh ------------------------------------------------------------------------------------------------

def block_mesh(tess, facing, section, options):
    """Blocks of all polygons, doubled vertices along their sides, names."""
    vertices, blocks, owner = polygons.blocks_of(tess)
    edges = polygons.inner_edges(tess.rings)
    if upper := max(options.bonded, options.coping):
        edges = crest.between_bodies(tess, edges, upper)
    for _ in range(options.refine):
        corners = np.where(blocks[:, 3] < 0, 3, 4)
        vertices, blocks, edges = polygons.refined(vertices, blocks, edges)
        owner = np.repeat(owner, corners)
    names = ["dam", "facing"] if facing.any() else ["dam"]
    mesh = BlockMesh(vertices, blocks, facing[owner], names, [0] * len(names))
    for name, found in zip(face_names(section), sides(mesh, section)):
        mesh.face_sets[name] = np.concatenate([mesh.face_sets.get(name, np.empty((0, 2), int)), found])
    high = section[section[:, 1] > section[:, 1].max() - 1e-9]
    mesh.points = {"heel": vertex_at(mesh, *section[0]), "toe": vertex_at(mesh, *section[1]),
                   "crest_downstream": vertex_at(mesh, *high[0]), "crest_upstream": vertex_at(mesh, *high[-1])}
    if not options.joints or not edges:
        return mesh
    mesh.face_sets["joint"] = faces_on_edges(mesh, edges)
    return double_vertices(mesh, edges)


def sides(mesh, section):
    return [face_set_on(mesh, a, b) for a, b in zip(section, np.roll(section, -1, axis=0))]


def with_rock(mesh, section, heights):
    """Rock below and beside the dam, level left and right of it; under the dam the faces match."""
    base = mesh.face_sets["base"]
    heel, toe = section[:2]
    x = np.unique(mesh.vertices[face_ends(mesh, base)][:, :, 0].round(9))
    x[0], x[-1] = heel[0], toe[0]
    extent, size = heights * np.ptp(section[:, 1]), (toe[0] - heel[0]) / (len(x) - 1)
    n = max(2, round(math.log2(1 + extent / size) * 2))
    beside = graded(size, extent, n)
    x = np.concatenate([heel[0] - beside[:0:-1], x, toe[0] + beside[1:]])
    top = np.column_stack([x, np.interp(x, [heel[0], toe[0]], [heel[1], toe[1]])])
    floor = np.column_stack([x, np.full(len(x), heel[1] - extent)])
    rock = structured(ruled(floor, top, 1 - graded(size, extent, n)[::-1] / extent), "rock")
    low, first, last = heel[1] - extent, (x[0], heel[1]), (x[-1], toe[1])
    on = {"rock_top_upstream": (first, heel), "rock_top_downstream": (toe, last), "base": (heel, toe)}
    rock.face_sets = {"rock_sides": np.concatenate([rock.face_sets["left"], rock.face_sets["right"]]),
                      "rock_bottom": face_set_on(rock, (x[0], low), (x[-1], low))}
    rock.face_sets |= {name: face_set_on(rock, a, b) for name, (a, b) in on.items()}
    rock.points = {"rock_heel": vertex_at(rock, *heel), "rock_toe": vertex_at(rock, *toe)}
    return join([mesh, rock])


# ---- command line ----------------------------------------------------------------------------------------

def options_of(arguments):
    parser = Parser(prog="quoin import voronoi", description=__doc__.splitlines()[0],
                                     formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    add = parser.add_argument
    add("-o", "--output", required=True, help="block mesh to write")
    add("--section", nargs="+", type=corner, metavar="X,Y",
        help="corners [m], counter-clockwise from heel and toe; default: section G1 of the Guilhofrei dam")
    add("--side", type=units.option("m"), default=2.0, help="mean side of a polygon [m]")
    add("--seed", type=int, default=1, help="of the random numbers")
    add("--shortest", type=units.option("m"), help="shortest side [m]; default: a quarter of the mean side")
    add("--facing", nargs=2, type=float, default=(1.0, 1.0), metavar=("UP", "DOWN"),
        help="thickness of the facing upstream and downstream [m]; 0: none")
    add("--course", type=units.option("m"), default=1.0, help="height of a course of the facing [m]")
    add("--square", action="store_true", help="joints between courses square to the face; else they turn from side to side")
    add("--coping", type=units.option("m"), default=0.0, help="height of a coping [m]: one stone over the whole crest, on a level bed; 0: none")
    add("--bonded", type=units.option("m"), default=0.0, help="uppermost metres whose stones are one body, with a toothed underside; 0: none")
    add("--lloyd", type=int, default=1, help="steps towards even polygons")
    add("--refine", type=int, default=0, help="times every block is cut in quadrilaterals")
    add("--rock", type=float, default=0.0, help="rock to each side and below, in heights of the dam; 0: none")
    add("--continuous", action="store_true", help="no joints: the same blocks as one macroblock")
    return parser.parse_args(arguments)


class Progress:
    """Prints lines on stdout: seconds since the start, and the next task."""

    def __init__(self):
        self.start = time.monotonic()

    def __call__(self, what):
        now = time.monotonic()
        print(f"{now - self.start:6.1f} s  {what}", flush=True)


def writable(path):
    """Refuses, before any work, a file that could not be written at the end."""
    folder = os.path.dirname(os.fspath(path)) or "."
    os.makedirs(folder, exist_ok=True)
    if os.path.isdir(path) or not os.access(folder, os.W_OK):
        raise MeshError(f"{path}: cannot be written")


def main(arguments=None):
    given = options_of(arguments)
    options = Options(given.side, given.seed, given.shortest, tuple(given.facing), given.course, given.square,
                      given.lloyd, given.refine, given.rock, not given.continuous, coping=given.coping, bonded=given.bonded)
    try:
        writable(given.output)
        mesh = voronoi_mesh(given.section, options, Progress())
        check(mesh)
        write(given.output, mesh)
    except (MeshError, OSError) as error:
        print(words_of(error), file=sys.stderr)
        return 2
    rock = mesh.group_names.index("rock") if "rock" in mesh.group_names else -1
    area = areas(mesh)[mesh.block_group != rock].sum()
    print(f"wrote {given.output}: {macroblocks(mesh).max() + 1} macroblocks, {len(mesh.blocks)} blocks, "
          f"{len(mesh.vertices)} vertices, dam {area:.2f} m2")
    sharpest = quality(mesh)[0]
    if sharpest < SHARPEST:
        print(f"warning: a block has a corner of {sharpest:.1f} degrees: several polygons lie along one stone of the facing; "
              "a smaller --course gives better blocks", file=sys.stderr)
    return 0
