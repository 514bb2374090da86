"""Fills a shape with stones: courses with a bond, Voronoi polygons, or the rock between sets of joints.

Slivers go to neighbours and short sides are merged, so stones end square or a little bent at the outline; the outline itself and what meets it
from the other side stay."""

import math
from dataclasses import dataclass

import numpy as np
import shapely

from quoin_tools.mesh import polygons, rock, voronoi
from quoin_tools.mesh.plan import Line, Region
from quoin_tools.mesh.rock import JointSet

MOST = 100_000  # stones
LARGE = 0.2  # of a shape: larger stones are no measure of smallness


@dataclass
class Courses:
    """Courses of a height [m], in stones of a length [m]; bond: by which part of a stone each course is moved against the one below.

    dip: degrees by which beds fall to the right. A bed passes through the lowest point of the shape."""

    height: float
    length: float
    bond: float = 0.5
    dip: float = 0.0

    def stone(self):
        return self.height * self.length

    def cells(self, shape):
        bed, low = JointSet("bed", self.dip, self.height).along(), np.array(lowest(shape))
        frame = np.array([bed, [-bed[1], bed[0]]])
        local = (shapely.get_coordinates(shape) - low) @ frame.T / [self.length, self.height]
        (left, bottom), (right, top) = local.min(axis=0), local.max(axis=0)
        rings = []
        for row in range(math.floor(bottom), math.ceil(top)):
            moved = (self.bond * row) % 1.0
            column = np.arange(math.floor(left - moved), math.ceil(right - moved)) + moved
            corner = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
            at = np.column_stack([column, np.full(len(column), row)])[:, None] + corner
            rings += list(low + (at * [self.length, self.height]) @ frame)
        return rings, np.zeros(len(rings), dtype=bool)

    def tidied(self, tess, most):
        side = min(self.height, self.length, most)
        return polygons.tidy(tess, 0.25 * side, 0.2 * side * min(max(self.height, self.length), 4 * side), 0)

    def names(self):
        return [JointSet("joint_bed", self.dip, 1.0), JointSet("joint_head", self.dip - 90 if self.dip > 0 else self.dip + 90, 1.0)]


@dataclass
class Polygons:
    """Voronoi polygons, by voronoi.Options; corners: of the section, from the heel, where there is a facing."""

    options: voronoi.Options
    corners: list

    def stone(self):
        return 2.2 * self.options.side**2

    def cells(self, shape):
        ring = np.array(self.corners or shapely.geometry.polygon.orient(shape).exterior.coords[:-1], dtype=float)
        tess, facing = voronoi.tessellate(ring, self.options)
        return tess.polygons(), facing

    def tidied(self, tess, _most):
        """Only what a gallery has cut: stones and facing are tidy."""
        return polygons.tidy(tess, *self.options.finest())

    def names(self):
        return [JointSet("joint", 0.0, 1.0)]


@dataclass
class Joints:
    """Sets of parallel joints."""

    sets: list

    def stone(self):
        return np.prod(sorted(s.spacing for s in self.sets)[:2]) if len(self.sets) > 1 else self.sets[0].spacing ** 2

    def cells(self, shape):
        lines = [shape.exterior, *(line for joints in self.sets for line in rock.lines_across(np.array(shape.exterior.coords), joints))]
        found = [part for part in shapely.polygonize([shapely.union_all(lines)]).geoms if shape.intersects(part.representative_point())]
        rings = [polygons.ring_of(part) for part in found]
        return sorted(rings, key=lambda ring: tuple(ring.mean(axis=0).round(6))), np.zeros(len(rings), dtype=bool)

    def tidied(self, tess, most):
        least = min([s.spacing for s in self.sets] + [most])
        return polygons.tidy(tess, 0.2 * least, 0.1 * least**2, 0)

    def names(self):
        return self.sets


def lowest(shape):
    """Returns the leftmost of the lowest points."""
    return min(shape.exterior.coords, key=lambda xy: (xy[1], xy[0]))


def read(keys, corners, base):
    """Reads the pattern from a mapping of the section file; None where it has a mistake."""
    kind = keys.one_of("courses", "voronoi")
    if kind == "courses":
        found = [keys.number("courses", above=0), keys.number("stones", above=0), keys.number("bond", 0.5, least=0, most=1, unit="part of a stone"),
                 keys.number("dip", 0.0, least=-80, most=80, unit="degree")]  # fmt: skip
        keys.done()
        return None if None in found else Courses(*found)
    if kind is None:
        return None
    side, seed, course = keys.number("voronoi", above=0), keys.whole("seed", 1, least=0), keys.number("course", 1.0, above=0)
    facing, lloyd = keys.get("facing", [0.0, 0.0]), keys.whole("lloyd", 1, least=0)
    keys.done()
    if not (isinstance(facing, list) and len(facing) == 2 and all(isinstance(f, (int, float)) and f >= 0 for f in facing)) or (any(facing) and not corners):
        return keys.fault("facing", "expected [thickness upstream, thickness downstream] of a dam, in m", facing)
    if None in (side, seed, course, lloyd):
        return None
    return Polygons(voronoi.Options(side=side, seed=seed, facing=tuple(facing), course=course, lloyd=lloyd, base=base), corners if any(facing) else [])


def too_many(pattern, shape):
    count = shape.area / pattern.stone()
    return f"about {count:.3g} stones, expected at most {MOST:g}" if count > MOST else None


def lay(plan, region, pattern):
    """Cuts a region of a plan in stones: its joints become lines, its facing a group of its own."""
    rings, facing = pattern.cells(region.shape)
    near = 1e-6 * math.sqrt(min(pattern.stone(), region.shape.area))
    plan.rough = max(plan.rough, 3 * near)
    tess, outside = clipped(rings, facing, region.shape, fixed_nodes(plan, region.shape, near), pattern, near)
    edges = polygons.inner_edges(tess.rings)
    owner = rock.nearest_set(tess.nodes, edges, pattern.names()) if edges else []
    names = [s.name for s in pattern.names()]
    plan.lines += [Line(names[k], tess.nodes[list(edge)].tolist(), joint=True) for edge, k in zip(edges, owner)]
    if outside.any():
        mine = shapely.union_all([shapely.Polygon(xy) for xy, out in zip(tess.polygons(), outside) if out], grid_size=plan.grid())
        others = shapely.difference(region.shape, mine, grid_size=plan.grid())
        plan.regions.remove(region)
        for group, shape in ((region.group, others), ("facing", mine)):
            plan.regions += [Region(group, part, region.size, region.rigid) for part in shapely.get_parts(shape)]


def fixed_nodes(plan, shape, near):
    """Corners of the outline, and what lines of the plan have on it: nodes that stay."""
    own = shapely.get_coordinates(shape)
    others = [line.points for line in plan.lines] + [[place[:2]] for place in plan.points.values()]
    coords = np.array([xy for points in others for xy in points], dtype=float).reshape(-1, 2)
    on = shapely.dwithin(shapely.points(coords), shape.boundary, near)
    return np.unique(np.concatenate([own, coords[on]]), axis=0)


def clipped(rings, facing, shape, fixed, pattern, tolerance):
    """Tidy tessellation of the stones within the shape, and which of them are of the facing."""
    parts, outside = [], []
    for ring, out in zip(rings, facing):
        for part in simple_parts(shapely.intersection(shapely.Polygon(ring), shape)):
            parts.append(polygons.ring_of(part))
            outside.append(out)
    tess = polygons.tessellation(parts, fixed, tolerance)
    if shape.interiors or not isinstance(pattern, Polygons):
        tess = pattern.tidied(tess, LARGE * math.sqrt(shape.area))
    if not any(outside):
        return tess, np.zeros(len(tess.rings), dtype=bool)
    whole = shapely.union_all([shapely.Polygon(ring) for ring, out in zip(parts, outside) if out])
    shapes = [shapely.Polygon(xy) for xy in tess.polygons()]
    return tess, shapely.area(shapely.intersection(shapes, whole)) > 0.5 * shapely.area(shapes)


def simple_parts(shape):
    """Returns the polygons of a shape; one round a hole is cut above and below the middle of the hole."""
    for part in shapely.get_parts(shape):
        if part.geom_type != "Polygon" or part.area == 0:
            continue
        if not part.interiors:
            yield part
            continue
        low, high = part.bounds[1] - 1, part.bounds[3] + 1
        middles = [0.5 * (hole.bounds[0] + hole.bounds[2]) for hole in part.interiors]
        cuts = shapely.union_all([part.boundary, *(shapely.LineString([(x, low), (x, high)]) for x in middles)])
        yield from (piece for piece in shapely.polygonize([cuts]).geoms if part.contains(piece.representative_point()))
