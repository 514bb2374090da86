"""A plane of regions, joints and named lines, meshed by gmsh: where sections and drawings meet.

Every line is cut where others meet it, gmsh fills what lies between, and `gmsh_import` opens the joints."""

import contextlib
import os
import tempfile
from collections import Counter, defaultdict
from dataclasses import dataclass, field

import numpy as np
import shapely

from quoin_tools.mesh.blockmesh import MeshError, check, xy_text
from quoin_tools.mesh.gmsh_import import import_msh
from quoin_tools.mesh.meshing import vertex_at

FINE = 1e-9  # grid of coordinates over the power of ten of the model's size
THIN = 1e-3  # a region thinner than this part of the size of blocks is no region
MOST_BLOCKS = 2_000_000


@dataclass
class Region:
    """Blocks of a group. size: of blocks, where lines are no shorter; None: as far from finer ones as they are."""

    group: str
    shape: shapely.Polygon
    size: float | None = None
    rigid: bool = False


@dataclass
class Line:
    """A polyline with a name. joint: it opens; else it names faces of the outline. count: blocks along it."""

    name: str
    points: list
    joint: bool = False
    count: int | None = None


@dataclass
class Plan:
    """points: name to (x, y, groups), one of which has the vertex; none: any. fine: (shape, size) of places with smaller blocks."""

    regions: list = field(default_factory=list)
    lines: list = field(default_factory=list)
    points: dict = field(default_factory=dict)
    fine: list = field(default_factory=list)
    growth: float = 0.25
    triangles: bool = False

    def grid(self):
        low, high = shapely.total_bounds([region.shape for region in self.regions]).reshape(2, 2)
        return FINE * 10.0 ** np.floor(np.log10((high - low).max()))

    def least(self):
        return min(size for _, size in self.sources())

    def sources(self):
        return [(region.shape, region.size) for region in self.regions if region.size] + self.fine


@dataclass
class Cut:
    """Nodes, edges between them, faces as (region, rings of nodes), and how many faces each edge has."""

    nodes: np.ndarray
    edges: list
    faces: list
    uses: Counter
    shapes: list


def mesh_of(plan):
    """Checked block mesh; MeshError says what cannot be and where."""
    expected_size(plan)
    cut = arranged(plan)
    names = named_edges(plan, cut)
    joints = sorted({line.name for line in plan.lines if line.joint and line.name in names})
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "plan.msh")
        fill(plan, cut, names, path)
        mesh = import_msh(path, joints, sorted({region.group for region in plan.regions if region.rigid}))
    mesh.points = {name: named_vertex(mesh, name, place, plan.grid()) for name, place in plan.points.items()}
    check(mesh)
    return mesh


def named_vertex(mesh, name, place, grid):
    x, y, groups = place
    for group in [g for g in groups if g in mesh.group_names] or [None]:
        with contextlib.suppress(MeshError):
            return vertex_at(mesh, x, y, group, max(1e-6, 3 * grid))
    raise MeshError(f"point {name!r}: ({x:g}, {y:g}) is not in a body" + (f" of {' or '.join(groups)}" if groups else ""))


def expected_size(plan):
    """Refuses, before gmsh would run for hours, a size that asks for too many blocks."""
    count = sum(shape.area / size**2 for shape, size in plan.sources())
    if count > MOST_BLOCKS:
        raise MeshError(f"size: about {count:.2g} blocks, expected at most {MOST_BLOCKS:g}")


# ---- lines cut where they meet ---------------------------------------------------------------------------

def arranged(plan):
    grid = plan.grid()
    check_regions(plan, grid)
    wanted = shapely.multipoints([place[:2] for place in plan.points.values()])
    lines = [region.shape.boundary for region in plan.regions] + [shapely.LineString(line.points) for line in plan.lines]
    whole = shapely.union_all(shapely.snap(lines, wanted, 2 * grid), grid_size=grid)
    parts = shapely.get_parts(whole)
    parts = parts[shapely.get_type_id(parts) == shapely.GeometryType.LINESTRING]
    coords, owner = shapely.get_coordinates(parts, return_index=True)
    _, first, number = np.unique(np.round(coords / grid).astype(np.int64), axis=0, return_index=True, return_inverse=True)
    nodes, number = coords[first], number.ravel()
    key = {tuple(place): i for i, place in enumerate(np.round(nodes / grid).astype(np.int64).tolist())}
    together = owner[:-1] == owner[1:]
    edges = sorted({(min(a, b), max(a, b)) for a, b in zip(number[:-1][together].tolist(), number[1:][together].tolist()) if a != b})
    faces, shapes, uses = [], [], Counter()
    tree = shapely.STRtree([region.shape for region in plan.regions])
    for shape in shapely.polygonize(parts).geoms:
        inside = tree.query(shape.representative_point(), predicate="within")
        if len(inside) == 0:
            continue
        check_thin(plan, plan.regions[inside[0]], shape)
        rings = []
        for ring in (shape.exterior, *shape.interiors):
            places = np.round(np.array(ring.coords)[:-1] / grid).astype(np.int64).tolist()
            rings.append([key[tuple(place)] for place in places])
            uses.update((min(a, b), max(a, b)) for a, b in zip(rings[-1], rings[-1][1:] + rings[-1][:1]))
        faces.append((int(inside[0]), rings))
        shapes.append(shape)
    return Cut(nodes, edges, faces, uses, shapes)


def check_regions(plan, grid):
    for region in plan.regions:
        if not region.shape.is_valid or region.shape.is_empty:
            raise MeshError(f"group {region.group!r}: its outline crosses itself ({shapely.is_valid_reason(region.shape)})")
    shapes = [region.shape for region in plan.regions]
    for i, j in sorted(shapely.STRtree(shapes).query(shapes, predicate="intersects").T.tolist()):
        if i < j:
            common = shapely.intersection(shapes[i], shapes[j])
            if common.area > (1e3 * grid) ** 2 and common.area > 1e-6 * min(shapes[i].area, shapes[j].area):
                at = common.representative_point()
                raise MeshError(f"group {plan.regions[i].group!r} and group {plan.regions[j].group!r}: overlap by {common.area:.4g} m2 at {xy_text((at.x, at.y))}")


def check_thin(plan, region, shape):
    """A sliver between lines that nearly coincide is a mistake of the drawing, not a body."""
    thickness = 2 * shape.area / shape.length
    if thickness < THIN * plan.least():
        at = shape.representative_point()
        raise MeshError(f"group {region.group!r}: a sliver {thickness:.2g} m thick at {xy_text((at.x, at.y))}: two lines nearly coincide there")


def named_edges(plan, cut):
    """Name to its edges. An edge of a joint has blocks on both sides, one of faces is on the outline or on a joint."""
    grid, found, opened = plan.grid(), defaultdict(set), set()
    edges = np.array(cut.edges)
    ends = cut.nodes[edges]
    tree = shapely.STRtree(shapely.points(ends.mean(axis=1)))
    for line in sorted(plan.lines, key=lambda line: not line.joint):
        drawn = shapely.LineString(line.points)
        mine = [tuple(edge) for edge in edges[np.sort(tree.query(drawn, predicate="dwithin", distance=3 * grid))].tolist()]
        check_line(line, cut, mine, opened)
        chosen = [edge for edge in mine if cut.uses[edge] == 2 or (line.joint and inner(cut, edge)) or (not line.joint and cut.uses[edge] == 1)]
        if line.joint:
            opened.update(chosen)
        found[line.name].update(chosen)
    return {name: sorted(chosen) for name, chosen in found.items() if chosen}


def check_line(line, cut, mine, opened):
    what = "joint" if line.joint else "faces"
    outside = [edge for edge in mine if cut.uses[edge] == 0 and not inner(cut, edge)]
    if outside or not mine:
        a, b = cut.nodes[list(outside[0])] if outside else (line.points[0], line.points[-1])
        raise MeshError(f"{what} {line.name!r}: from {xy_text(a)} to {xy_text(b)} it lies outside all groups")
    if line.joint:
        if all(cut.uses[edge] == 1 for edge in mine):
            raise MeshError(f"joint {line.name!r}: lies on the outline, from {xy_text(line.points[0])} to {xy_text(line.points[-1])}")
        return
    for edge in mine:
        if cut.uses[edge] != 1 and edge not in opened:
            a, b = cut.nodes[list(edge)]
            raise MeshError(f"faces {line.name!r}: from {xy_text(a)} to {xy_text(b)} it runs inside a group, expected the outline or a joint")


def inner(cut, edge):
    """Whether an edge that bounds no face lies in one: the end of a joint inside a body."""
    return cut.uses[edge] == 0 and face_at(cut, cut.nodes[list(edge)].mean(axis=0)) is not None


def face_at(cut, xy):
    return next((i for i, shape in enumerate(cut.shapes) if shapely.contains_xy(shape, *xy)), None)


# ---- gmsh ------------------------------------------------------------------------------------------------

@contextlib.contextmanager
def session():
    """gmsh with a model of its own; one that the caller has open stays open."""
    import gmsh  # here: it loads libraries of the window system

    mine = not gmsh.isInitialized()
    if mine:
        gmsh.initialize(interruptible=False)
    before = None if mine else gmsh.model.getCurrent()
    gmsh.model.add("plan")
    settings = {"General.Terminal": 0, "General.NumThreads": 1, "Mesh.MeshSizeFromPoints": 0, "Mesh.MeshSizeExtendFromBoundary": 0,
                "Mesh.Algorithm": 8, "Mesh.RecombineAll": 0, "Mesh.MshFileVersion": 4.1, "Mesh.Binary": 1, "Mesh.ElementOrder": 1}  # fmt: skip
    for name, value in settings.items():
        gmsh.option.setNumber(name, value)
    try:
        yield gmsh
    finally:
        gmsh.model.mesh.removeSizeCallback()
        gmsh.model.remove()
        if mine:
            gmsh.finalize()
        else:
            gmsh.model.setCurrent(before)


def fill(plan, cut, names, path):
    """Meshes the faces and writes the .msh file."""
    with session() as gmsh:
        geo, counts = gmsh.model.geo, edge_counts(plan, cut, names)
        for tag, (x, y) in enumerate(cut.nodes.tolist(), 1):
            geo.addPoint(x, y, 0.0, 0.0, tag)
        tags = {}
        for tag, (a, b) in enumerate(cut.edges, 1):
            tags[a, b], tags[b, a] = tag, -tag
            geo.addLine(a + 1, b + 1, tag)
        surfaces = defaultdict(list)
        for tag, (region, rings) in enumerate(cut.faces, 1):
            loops = [geo.addCurveLoop([tags[a, b] for a, b in zip(ring, ring[1:] + ring[:1])]) for ring in rings]
            geo.addPlaneSurface(loops, tag)
            surfaces[plan.regions[region].group].append(tag)
        geo.synchronize()
        for edge in cut.edges:
            if edge in counts:
                gmsh.model.mesh.setTransfiniteCurve(tags[edge], counts[edge] + 1)
            elif inner(cut, edge):
                gmsh.model.mesh.embed(1, [tags[edge]], 2, 1 + face_at(cut, cut.nodes[list(edge)].mean(axis=0)))
        embed_points(gmsh, plan, cut)
        for name, found in surfaces.items():
            gmsh.model.addPhysicalGroup(2, found, name=name)
        for name, found in names.items():
            gmsh.model.addPhysicalGroup(1, [tags[edge] for edge in found], name=name)
        if not plan.triangles:
            for tag in range(1, len(cut.faces) + 1):
                gmsh.model.mesh.setRecombine(2, tag)
        gmsh.model.mesh.setSizeCallback(size_function(plan))
        try:
            gmsh.model.mesh.generate(2)
        except Exception as error:  # noqa: BLE001 (gmsh raises this kind only)
            raise MeshError(f"gmsh cannot mesh this: {' '.join(str(error).split())}") from None
        gmsh.write(path)


def embed_points(gmsh, plan, cut):
    """Named points inside a face become vertices."""
    tag = len(cut.nodes)
    for x, y, _ in plan.points.values():
        face = face_at(cut, (x, y))
        if face is not None and np.hypot(*(cut.nodes - [x, y]).T).min() > 3 * plan.grid():
            tag += 1
            gmsh.model.geo.addPoint(x, y, 0.0, 0.0, tag)
            gmsh.model.geo.synchronize()
            gmsh.model.mesh.embed(0, [tag], 2, face + 1)


def edge_counts(plan, cut, names):
    """Blocks along the edges of lines that say how many they have."""
    counts = {}
    for line in plan.lines:
        length = shapely.LineString(line.points).length
        for a, b in names.get(line.name, ()) if line.count else ():
            counts[a, b] = max(1, round(line.count * np.hypot(*(cut.nodes[b] - cut.nodes[a])) / length))
    return counts


def size_function(plan):
    sources, growth = plan.sources(), plan.growth
    for shape, _ in sources:
        shapely.prepare(shape)
    shapes, sizes = np.array([shape for shape, _ in sources]), np.array([size for _, size in sources])

    def size(_dimension, _tag, x, y, _z, _given):
        return float((sizes + growth * shapely.distance(shapes, shapely.Point(x, y))).min())

    return size
