"""Meshes a plane of regions, joints and named lines by gmsh: sections and drawings both end here.

Every line is cut where others meet it, gmsh fills what lies between, and `gmsh_import` opens the joints."""

import contextlib
import os
import tempfile
from collections import Counter, defaultdict
from dataclasses import dataclass, field

import numpy as np
import scipy
import shapely
import shapely.ops

from quoin_tools.mesh import polygons
from quoin_tools.mesh.blockmesh import MeshError, check, xy_text
from quoin_tools.mesh.gmsh_import import import_msh
from quoin_tools.mesh.meshing import vertex_at

FINE = 1e-9  # grid of coordinates over the power of ten of the model's size
THIN = 1e-3  # a region thinner than this part of the size of blocks is no region
MEET, MISS = 5e-5, 0.01  # of the size of the plan, at most of the size of blocks: lines that come so near are meant to meet; coordinates are rounded
MOST_BLOCKS = 2_000_000
FEW = 10  # nodes round a face: up to as many it is cut by diagonals
# Ways of gmsh: its algorithm, and whether triangles are joined. In rare shapes one gives blocks on top of each other, and the next is tried.
QUADRILATERALS = ((8, True), (6, True), (5, False))
TRIANGLES = ((5, False),)


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

    title: str = ""
    regions: list = field(default_factory=list)
    lines: list = field(default_factory=list)
    points: dict = field(default_factory=dict)
    fine: list = field(default_factory=list)
    growth: float = 0.15
    triangles: bool = False
    drains: dict = field(default_factory=dict)  # name to two ends
    anchors: dict = field(default_factory=dict)  # name to head and root
    patterns: list = field(default_factory=list)  # (region, pattern, keys) of stones to be laid
    rough: float = 0.0  # by how much lines that are meant to meet may miss each other
    notes: list = field(default_factory=list)

    def extent(self):
        low, high = shapely.total_bounds([region.shape for region in self.regions]).reshape(2, 2)
        return (high - low).max()

    def grid(self):
        return FINE * 10.0 ** np.floor(np.log10(self.extent()))

    def meet(self):
        """[m] Lines that miss by less are joined, with a note: some millimetres in the section of a dam."""
        return max(THIN * self.least(), min(MISS * self.least(), MEET * self.extent()))

    def near(self):
        return max(3 * self.grid(), self.rough)

    def least(self):
        return min(size for _, size in self.sources())

    def sources(self):
        return [(region.shape, region.size) for region in self.regions if region.size] + self.fine


@dataclass
class Cut:
    """Cuts the plan into nodes, edges between them, faces as (region, rings of nodes), and the number of faces at each edge."""

    nodes: np.ndarray
    edges: list
    faces: list
    uses: Counter
    shapes: list


class NearlyMeet(MeshError):
    """Lines miss each other by less than they are meant to."""


def mesh_of(plan):
    """Checked block mesh; MeshError says what cannot be and where."""
    expected_size(plan)
    bring_points(plan)
    try:
        cut = arranged(plan, plan.meet())
    except NearlyMeet as miss:
        cut = brought_together(plan, miss)
    names = named_edges(plan, cut)
    joints = sorted({line.name for line in plan.lines if line.joint and line.name in names})
    rigid = sorted({region.group for region in plan.regions if region.rigid})
    for attempt, way in enumerate(TRIANGLES if plan.triangles else QUADRILATERALS, 1):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "plan.msh")
            fill(plan, cut, names, way, path)
            mesh = import_msh(path, joints, rigid, "m")
        mesh.points = {name: named_vertex(mesh, name, place, plan.near()) for name, place in plan.points.items()}
        try:
            check(mesh)
            break
        except MeshError:
            if attempt == len(QUADRILATERALS) or plan.triangles:
                raise
    return mesh


def brought_together(plan, miss):
    """Cuts the plan with lines joined that nearly meet; as drawn, where that fails and nothing is nearer than a thousandth of the blocks."""
    before = plan.rough
    plan.rough = max(before, plan.meet())
    try:
        cut = arranged(plan, THIN * plan.least())
        plan.notes.append(f"{miss}: joined, as all that misses by less than {plan.meet():.2g} m")
    except MeshError:
        plan.rough = before
        cut = arranged(plan, THIN * plan.least())
    return cut


def bring_points(plan):
    """Moves points that nearly lie on a line to its corner or onto it."""
    lines = shapely.union_all([region.shape.boundary for region in plan.regions] + [shapely.LineString(line.points) for line in plan.lines])
    corners = shapely.get_coordinates(lines)
    for name, (x, y, groups) in plan.points.items():
        at, distance = shapely.Point(x, y), lines.distance(shapely.Point(x, y))
        if not plan.near() < distance <= plan.meet():
            continue
        to_corner = np.hypot(*(corners - [x, y]).T)
        place = corners[to_corner.argmin()] if to_corner.min() <= plan.meet() else shapely.get_coordinates(shapely.ops.nearest_points(lines, at)[0])[0]
        plan.points[name] = (*place.tolist(), groups)
        plan.notes.append(f"point {name!r}: ({x:g}, {y:g}) is {distance:.2g} m from a line: brought to it, as all that misses by less than {plan.meet():.2g} m")


def named_vertex(mesh, name, place, near):
    x, y, groups = place
    for group in [g for g in groups if g in mesh.group_names] or [None]:
        with contextlib.suppress(MeshError):
            return vertex_at(mesh, x, y, group, max(1e-6, near))
    raise MeshError(f"point {name!r}: ({x:g}, {y:g}) is not in a body" + (f" of {' or '.join(groups)}" if groups else ""))


def expected_size(plan):
    """Refuses, before gmsh would run for hours, a size that asks for too many blocks."""
    count = sum(shape.area / size**2 for shape, size in plan.sources())
    if count > MOST_BLOCKS:
        raise MeshError(f"size: about {count:.2g} blocks, expected at most {MOST_BLOCKS:g}")


# ---- lines cut where they meet ---------------------------------------------------------------------------

def arranged(plan, apart):
    """Faces between all lines; apart [m]: what comes nearer without meeting is a mistake."""
    grid = plan.grid()
    check_regions(plan, grid)
    wanted = shapely.multipoints(np.array([place[:2] for place in plan.points.values()]).reshape(-1, 2))
    lines = [region.shape.boundary for region in plan.regions] + [shapely.LineString(line.points) for line in plan.lines]
    whole = shapely.union_all(shapely.snap(lines, wanted, 2 * grid), grid_size=grid)
    nodes, edges = joined(whole, plan.near())
    check_close(plan, nodes, np.array(edges), apart)
    key = {tuple(xy): i for i, xy in enumerate(nodes.tolist())}
    faces, shapes, uses = [], [], Counter()
    tree = shapely.STRtree([region.shape for region in plan.regions])
    for shape in shapely.polygonize(shapely.linestrings(nodes[np.array(edges)])).geoms:
        inside = tree.query(shape.representative_point(), predicate="within")
        if len(inside) == 0:
            continue
        check_thin(plan, plan.regions[inside[0]], shape)
        rings = []
        for ring in (shape.exterior, *shape.interiors):
            rings.append([key[xy] for xy in ring.coords[:-1]])
            uses.update((min(a, b), max(a, b)) for a, b in zip(rings[-1], rings[-1][1:] + rings[-1][:1]))
        faces.append((int(inside[0]), rings))
        shapes.append(shape)
    return Cut(nodes, edges, faces, uses, shapes)


def joined(whole, near):
    """Nodes and edges of lines that are cut where they cross. Nodes nearer than `near` are one, and one so near to an edge cuts it: a line that two
    parts of a drawing share has the nodes of both."""
    coords, owner = shapely.get_coordinates(shapely.get_parts(whole), return_index=True)
    pairs = scipy.spatial.cKDTree(coords).query_pairs(near, output_type="ndarray")
    graph = scipy.sparse.coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(coords), len(coords)))
    label = scipy.sparse.csgraph.connected_components(graph, directed=False)[1]
    _, first, number = np.unique(label, return_index=True, return_inverse=True)
    nodes, together = coords[first], owner[:-1] == owner[1:]
    edges = np.unique(np.sort(np.column_stack([number[:-1], number[1:]])[together], axis=1), axis=0)
    edges = edges[edges[:, 0] != edges[:, 1]]
    tree = shapely.STRtree(shapely.linestrings(nodes[edges]))
    node, edge = tree.query(shapely.points(nodes), predicate="dwithin", distance=near)
    between = (edges[edge] != node[:, None]).all(axis=1)
    along = ((nodes[node] - nodes[edges[edge, 0]]) * (nodes[edges[edge, 1]] - nodes[edges[edge, 0]])).sum(axis=1)
    inside = defaultdict(list)
    for k, _, at in sorted(zip(edge[between].tolist(), along[between].tolist(), node[between].tolist())):
        inside[k].append(at)
    chains = [[a, *inside.get(k, ()), b] for k, (a, b) in enumerate(edges.tolist())]
    return nodes, sorted({(min(a, b), max(a, b)) for chain in chains for a, b in zip(chain[:-1], chain[1:])})


def check_regions(plan, grid):
    for region in plan.regions:
        if not region.shape.is_valid or region.shape.is_empty:
            raise MeshError(f"group {region.group!r}: its outline crosses itself ({shapely.is_valid_reason(region.shape)})")
    shapes = [region.shape for region in plan.regions]
    for i, j in sorted(shapely.STRtree(shapes).query(shapes, predicate="intersects").T.tolist()):
        if i < j:
            common = shapely.intersection(shapes[i], shapes[j])
            if common.area > (1e3 * grid) ** 2 and 2 * common.area > max(plan.near(), 1e-6) * common.length:
                at = common.representative_point()
                raise MeshError(f"group {plan.regions[i].group!r} and group {plan.regions[j].group!r}: overlap by {common.area:.4g} m2 at {xy_text((at.x, at.y))}")


def check_close(plan, nodes, edges, least):
    """Refuses lines that nearly meet, and a point beside a line: they would leave blocks with corners of no angle."""
    lines = shapely.linestrings(nodes[edges])
    tree = shapely.STRtree(lines)
    node, edge = tree.query(shapely.points(nodes), predicate="dwithin", distance=least)
    apart = (edges[edge] != node[:, None]).all(axis=1)
    node, edge = node[apart], edge[apart]
    distance = shapely.distance(shapely.points(nodes[node]), lines[edge])
    bad = np.flatnonzero(distance < THIN * shapely.length(lines[edge]))
    if len(bad):
        raise NearlyMeet(f"lines nearly meet at {xy_text(nodes[node[bad[0]]])}, where another one is {distance[bad[0]]:.2g} m away")
    for name, (x, y, _) in plan.points.items():
        distance = shapely.distance(shapely.Point(x, y), lines[tree.nearest(shapely.Point(x, y))])
        if plan.near() < distance < THIN * plan.least():
            raise MeshError(f"point {name!r}: ({x:g}, {y:g}) is {distance:.2g} m from a line, expected on it or at least {THIN * plan.least():.2g} m away")


def check_thin(plan, region, shape):
    """Refuses a sliver between lines that nearly coincide: it is a mistake of the drawing, not a body."""
    thickness = 2 * shape.area / shape.length
    if thickness < THIN * plan.least():
        at = shape.representative_point()
        raise MeshError(f"group {region.group!r}: a sliver {thickness:.2g} m thick at {xy_text((at.x, at.y))}: two lines nearly coincide there")


def named_edges(plan, cut):
    """Returns for each name its edges. An edge of a joint has blocks on both sides, an edge of faces is on the outline or on a joint."""
    near, found, opened = plan.near(), defaultdict(set), set()
    edges = np.array(cut.edges)
    ends = cut.nodes[edges]
    tree = shapely.STRtree(shapely.points(ends.mean(axis=1)))
    for line in sorted(plan.lines, key=lambda line: not line.joint):
        drawn = shapely.LineString(line.points)
        mine = [tuple(edge) for edge in edges[np.sort(tree.query(drawn, predicate="dwithin", distance=2 * near))].tolist()]
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
    """Tells whether an edge that bounds no face lies in one: the end of a joint inside a body."""
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
    settings = {"General.Terminal": 0, "General.NumThreads": 1, "Mesh.MeshSizeFromPoints": 0, "Mesh.MeshSizeExtendFromBoundary": 1,
                "Mesh.Algorithm": 8, "Mesh.RecombineAll": 0, "Mesh.MshFileVersion": 2.2, "Mesh.Binary": 1, "Mesh.ElementOrder": 1}  # fmt: skip
    for name, value in settings.items():
        gmsh.option.setNumber(name, value)
    try:
        yield gmsh
    finally:
        gmsh.model.remove()
        if mine:
            gmsh.finalize()
        else:
            gmsh.model.setCurrent(before)


def fill(plan, cut, names, way, path):
    """Meshes the faces and writes the .msh file."""
    nodes, chains = divided(plan, cut, names)
    algorithm, joined_up = way
    pieces, nodes = cut_faces(plan, cut, nodes, chains)
    with session() as gmsh:
        gmsh.option.setNumber("Mesh.Algorithm", algorithm)
        geo, lines, surfaces = gmsh.model.geo, {}, defaultdict(list)
        for tag, (x, y) in enumerate(nodes.tolist(), 1):
            geo.addPoint(x, y, 0.0, 0.0, tag)
        for (a, b), chain in chains.items():
            lines[a, b] = [geo.addLine(i + 1, j + 1) for i, j in zip(chain[:-1], chain[1:])]
            lines[b, a] = [-tag for tag in lines[a, b][::-1]]
            for i, j, tag in zip(chain[:-1], chain[1:], list(lines[a, b])):
                lines[i, j], lines[j, i] = [tag], [-tag]
        for tag, (region, rings) in enumerate(cut.faces, 1):
            if tag - 1 in pieces:
                surfaces[plan.regions[region].group] += add_pieces(gmsh, lines, pieces[tag - 1], plan.triangles, len(cut.faces))
                continue
            loops = [geo.addCurveLoop([line for edge in zip(ring, ring[1:] + ring[:1]) for line in lines[edge]]) for ring in rings]
            geo.addPlaneSurface(loops, tag)
            surfaces[plan.regions[region].group].append(tag)
        geo.synchronize()
        for _, line in gmsh.model.getEntities(1):
            gmsh.model.mesh.setTransfiniteCurve(line, 2)
        for edge in chains:
            if inner(cut, edge):
                gmsh.model.mesh.embed(1, lines[edge], 2, 1 + face_at(cut, cut.nodes[list(edge)].mean(axis=0)))
        embed_points(gmsh, plan, cut, len(nodes))
        for name, found in surfaces.items():
            gmsh.model.addPhysicalGroup(2, found, name=name)
        for name, found in names.items():
            gmsh.model.addPhysicalGroup(1, [line for edge in found for line in lines[edge]], name=name)
        for _, tag in gmsh.model.getEntities(2) if joined_up else ():
            if tag <= len(cut.faces):
                gmsh.model.mesh.setRecombine(2, tag)
        try:
            gmsh.model.mesh.generate(2)
        except Exception as error:  # noqa: BLE001 (gmsh raises this kind only)
            raise MeshError(f"gmsh cannot mesh this: {' '.join(str(error).split())}") from None
        gmsh.write(path)


def cut_faces(plan, cut, nodes, chains):
    """Of faces with few nodes and nothing inside: their blocks, as rings of nodes, the best cut there is; and the nodes with centres of fans.
    gmsh, with little room for vertices inside, gives such faces bad corners."""
    kept = {face_at(cut, cut.nodes[list(edge)].mean(axis=0)) for edge in chains if inner(cut, edge)}
    kept.update(face_at(cut, place[:2]) for place in plan.points.values())
    nodes, pieces = nodes.tolist(), {}
    for i, (_, rings) in enumerate(cut.faces):
        chain = [node for a, b in zip(rings[0], rings[0][1:] + rings[0][:1]) for node in (chains[a, b] if a < b else chains[b, a][::-1])[:-1]]
        if len(rings) > 1 or len(chain) > FEW or i in kept:
            continue
        if not cut.shapes[i].exterior.is_ccw:
            chain.reverse()
        found, centre = polygons.cut(np.array([nodes[node] for node in chain]))
        if centre is not None:
            chain.append(len(nodes))
            nodes.append(list(centre))
        pieces[i] = [[chain[k] for k in piece] for piece in found]
    return pieces, np.array(nodes)


def add_pieces(gmsh, lines, pieces, triangles, first):
    """Adds surfaces of one block each. Returns their tags, which begin behind those of faces."""
    geo, found = gmsh.model.geo, []
    for ring in pieces:
        edges = list(zip(ring, ring[1:] + ring[:1]))
        for a, b in edges:
            if (a, b) not in lines:
                tag = geo.addLine(a + 1, b + 1)
                lines[a, b], lines[b, a] = [tag], [-tag]
        tag = max(first, geo.getMaxTag(2)) + 1
        geo.addPlaneSurface([geo.addCurveLoop([lines[edge][0] for edge in edges])], tag)
        geo.mesh.setTransfiniteSurface(tag)
        if not triangles and len(ring) == 4:
            geo.mesh.setRecombine(2, tag)
        found.append(tag)
    return found


def embed_points(gmsh, plan, cut, tag):
    """Makes vertices of named points inside a face, one for all points at one place; tag: of the last point."""
    there = cut.nodes
    for x, y, _ in plan.points.values():
        face = face_at(cut, (x, y))
        if face is not None and np.hypot(*(there - [x, y]).T).min() > plan.near():
            there = np.vstack([there, [x, y]])
            tag += 1
            gmsh.model.geo.addPoint(x, y, 0.0, 0.0, tag)
            gmsh.model.geo.synchronize()
            gmsh.model.mesh.embed(0, [tag], 2, face + 1)


def divided(plan, cut, names):
    """Places nodes along each edge, as far apart as blocks are large there. Returns nodes and chains; gmsh keeps them, and sizes inside follow from them."""
    counts = {}
    for line in plan.lines:
        for edge in names.get(line.name, ()) if line.count else ():
            counts[edge] = line.count / shapely.LineString(line.points).length
    nodes, chains = cut.nodes.tolist(), {}
    used = [edge for edge in cut.edges if cut.uses[edge] or inner(cut, edge)]
    ends = cut.nodes[np.array(used)]
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    long = length > 8 * plan.least()
    for mine, samples in ((~long, 17), (long, 257)):
        at = np.linspace(0, 1, samples)
        points = ends[mine][:, :1] * (1 - at)[:, None] + ends[mine][:, 1:] * at[:, None]
        density = 1 / size_at(plan, points)
        steps = 0.5 * (density[:, 1:] + density[:, :-1]) * length[mine][:, None] / (samples - 1)
        total = np.concatenate([np.zeros((len(steps), 1)), np.cumsum(steps, axis=1)], axis=1)
        for k, row in zip(np.flatnonzero(mine).tolist(), total):
            a, b = used[k]
            if used[k] in counts:
                row = at * counts[used[k]] * length[k]
            n = max(1, round(row[-1]))
            inside = np.interp(np.arange(1, n) / n * row[-1], row, at)
            chains[a, b] = [a, *range(len(nodes), len(nodes) + n - 1), b]
            nodes += (cut.nodes[a] * (1 - inside)[:, None] + cut.nodes[b] * inside[:, None]).tolist()
    return np.array(nodes), {edge: chains[edge] for edge in used}


def size_at(plan, points):
    """Size of blocks at points (..., 2)."""
    geometry = shapely.points(points)
    return np.min([size + plan.growth * shapely.distance(shape, geometry) for shape, size in plan.sources()], axis=0)
