"""Cuts a block mesh along a path, and sums the loads of a stage on the part above it by plane statics.

    part = cut(mesh, path)                   the material to the left of the path: above it when it runs to the right
    forces, left_out = stage_forces(mesh, scene, "full", part, results.stage("full").loads)

A force system is an array (X, Y, M): resultant [N] and moment about the origin [N m], positive anticlockwise. Geometry is that
of the mesh, undeformed. The path must cut the body right through.
"""

from dataclasses import replace

import numpy as np
import shapely
from shapely.geometry import LineString

from quoin_tools.base.language import _
from quoin_tools.mesh.blockmesh import closed_rings, face_ends

SAMPLES = 33  # places per piece of the path where its two sides are examined
GAP = 0.005  # [m] joints of the mesh no wider than this hold the body together
NEAR = 1e-3  # of the way to the middle of a block
WHOLE = None  # a part that is the whole mesh


class GravityError(ValueError):
    """The gravity method does not apply; the message is one line."""


class Part:
    """Material on one side of a path: its region, and how much of each block belongs to it."""

    def __init__(self, mesh, region, thin):
        polygons = shapely.polygons(mesh.vertices[closed_rings(mesh)])
        self.region, self.thin = region.buffer(8 * thin, join_style="mitre"), thin
        shapely.prepare(self.region)
        self.pieces = shapely.intersection(polygons, self.region)
        self.areas = shapely.area(self.pieces)
        self.share = self.areas / shapely.area(polygons)


def sides(path, offset):
    """Points just left and just right of each piece of the path."""
    at = (np.arange(SAMPLES) + 0.5) / SAMPLES
    left, right = [], []
    for a, b in zip(path[:-1], path[1:]):
        normal = np.array([a[1] - b[1], b[0] - a[0]]) / np.hypot(*(b - a))
        points = a + at[:, None] * (b - a)
        left.append(points + offset * normal)
        right.append(points - offset * normal)
    return shapely.points(np.concatenate(left)), shapely.points(np.concatenate(right))


def checked_path(path):
    path = np.asarray(path, dtype=float).reshape(-1, 2)
    if len(path) < 2 or not np.isfinite(path).all():
        raise GravityError(_("a path needs two points or more"))
    if (np.hypot(*np.diff(path, axis=0).T) == 0).any() or np.all(path[0] == path[-1]):
        raise GravityError(_("a path must not stand still or close"))
    start, end = path[0], path[-1]
    backwards = end[0] < start[0] or (end[0] == start[0] and end[1] < start[1])
    return path[::-1] if backwards else path


def body(mesh):
    """The union of all blocks, with joints closed."""
    union = shapely.union_all(shapely.polygons(mesh.vertices[closed_rings(mesh)]))
    return union.buffer(GAP / 2, join_style="mitre").buffer(-GAP / 2, join_style="mitre")


def cut(mesh, path, whole=None):
    """The Part to the left of the path. whole: body(mesh), where many paths cut one mesh."""
    path = checked_path(path)
    size = np.ptp(mesh.vertices, axis=0).max()
    thin = 1e-9 * size
    first, last = path[1] - path[0], path[-1] - path[-2]
    longer = np.concatenate([[path[0] - 2 * GAP * first / np.hypot(*first)], path[1:-1],
                             [path[-1] + 2 * GAP * last / np.hypot(*last)]])  # fmt: skip
    rest = shapely.difference(body(mesh) if whole is None else whole,
                              LineString(longer).buffer(4 * thin, cap_style="flat", join_style="mitre"))  # fmt: skip
    left, right = sides(path, 16 * thin)
    chosen = []
    for region in shapely.get_parts(rest):
        shapely.prepare(region)
        is_left = shapely.contains(region, left).any()
        if is_left and shapely.contains(region, right).any():
            raise GravityError(_("the path does not cut the body right through, from surface to surface: the two sides hang together"))
        if is_left:
            chosen.append(region)
    if not chosen:
        raise GravityError(_("there is no material above the path"))
    return Part(mesh, shapely.union_all(chosen), thin)


def trimmed(path, body):
    """The path from where it first meets the body to where it leaves it for the last time."""
    inside = LineString(path).intersection(body)
    places = np.concatenate([np.array(line.coords) for line in shapely.get_parts(inside)])
    along = np.array([LineString(path).project(shapely.Point(p)) for p in places])
    corners = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    first, last = along.min(), along.max()
    between = path[(corners > first + 1e-9) & (corners < last - 1e-9)]
    return np.concatenate([places[[along.argmin()]], between, places[[along.argmax()]]])


def straightened(path):
    """Drops corners that lie on the straight line between their neighbours, within a millimetre."""
    kept = [path[0]]
    for point, following in zip(path[1:-1], path[2:]):
        a, b = point - kept[-1], following - kept[-1]
        if abs(a[0] * b[1] - a[1] * b[0]) > 1e-3 * np.hypot(*b):
            kept.append(point)
    return np.array(kept + [path[-1]])


# ---- loads ---------------------------------------------------------------------------------------------------

def force_at(force, point):
    """A single force as (X, Y, M)."""
    return np.array([force[0], force[1], point[0] * force[1] - point[1] * force[0]])


def densities(mesh, scene, load):
    """[kg/m3] of each block, 0 for groups that the load leaves out."""
    groups = load.get("groups")
    groups = [groups] if isinstance(groups, str) else groups
    groups = None if groups == ["all"] and "all" not in mesh.group_names else groups
    per_group = []
    for name in mesh.group_names:
        counts = not groups or name in groups
        per_group.append(float(scene.materials.get(name, {}).get("density", 0.0)) if counts else 0.0)
    return np.array(per_group)[mesh.block_group]


def weight(mesh, scene, load, part=WHOLE):
    """The load's coefficient times the weight of its groups: of self_weight (0, -1)."""
    coefficient = np.array(load.get("coefficient", (0.0, -1.0)), dtype=float)
    pieces = shapely.polygons(mesh.vertices[closed_rings(mesh)]) if part is WHOLE else part.pieces
    weights = scene.gravity * scene.thickness * densities(mesh, scene, load) * shapely.area(pieces)
    used = weights > 0
    centroids = shapely.centroid(pieces[used])
    x, y = weights[used] @ shapely.get_x(centroids), weights[used] @ shapely.get_y(centroids)
    return np.array([*(weights.sum() * coefficient), x * coefficient[1] - y * coefficient[0]])


def wet_segments(mesh, load, part=WHOLE):
    """Ends (n, 2, 2) of the faces of a load, counter-clockwise round their blocks, as far as they belong to the part."""
    name = load["faces"]
    if name not in mesh.face_sets:
        raise GravityError(f"the mesh has no face set '{name}'")
    faces = mesh.face_sets[name]
    segments = mesh.vertices[face_ends(mesh, faces)]
    if part is WHOLE:
        return segments
    share, kept = part.share[faces[:, 0]], []
    for segment, portion in zip(segments, share):
        if portion > 1 - 1e-6:
            kept.append(segment)
        elif portion > 1e-12:
            inside = shapely.intersection(LineString(segment), part.region)
            pieces = [np.array(line.coords) for line in shapely.get_parts(inside) if line.length > 0]
            direction = segment[1] - segment[0]
            kept += [line if (line[-1] - line[0]) @ direction > 0 else line[::-1] for line in pieces]
    return np.array([[line[0], line[-1]] for line in kept]).reshape(-1, 2, 2)


def point_force(mesh, scene, load, part=WHOLE):
    if load["point"] not in mesh.points:
        raise GravityError(f"the mesh has no point '{load['point']}'")
    vertex = mesh.points[load["point"]]
    if part is not WHOLE:
        centres = mesh.centres()[(mesh.blocks == vertex).any(axis=1)]  # just inside the blocks around it: a path may cut them
        if shapely.contains_xy(part.region, *(mesh.vertices[vertex] + NEAR * (centres - mesh.vertices[vertex])).T).mean() < 0.5:
            return np.zeros(3)
    return force_at(scene.thickness * np.array(load["value"], dtype=float), mesh.vertices[vertex])


IN_JOINTS = ("uplift", "head", "drain", "curtain", "inflow")  # types of loads of water in joints
HEAVY = ("self_weight", "pseudo_static")  # types of loads of the weight or inertia of blocks


def standing(mesh, scene, stage):
    """Mesh and scene without the weight and the faces of groups that are placed later; blocks keep their numbers."""
    absent = scene.absent(stage)
    if not absent:
        return mesh, scene
    there = ~np.isin(mesh.block_group, [row for row, name in enumerate(mesh.group_names) if name in absent])
    faces = {name: rows[there[rows[:, 0]]] for name, rows in mesh.face_sets.items()}
    materials = {name: keys | {"density": 0.0} if name in absent else keys for name, keys in scene.materials.items()}
    return replace(mesh, face_sets=faces), replace(scene, materials=materials)


def on_faces(pressed, part):
    """Returns (X, Y, M) on the part of the rows of FaceLoads; a face that the path cuts counts as far as it is in the part."""
    if part is WHOLE:
        return pressed.systems().sum(axis=0)
    share, single = part.share[pressed.face[:, 0]], pressed.single()
    total = pressed.systems()[share > 1 - 1e-6].sum(axis=0)
    for i in np.flatnonzero((share > 1e-12) & (share <= 1 - 1e-6)):
        (a, b), line = pressed.point[i], LineString(pressed.point[i])
        if single[i]:
            total += pressed.systems()[i] * shapely.intersects_xy(part.region, *a)
            continue
        inward = GAP * np.array([a[1] - b[1], b[0] - a[0]]) / line.length
        for piece in shapely.get_parts(shapely.intersection(line, part.region)):
            if piece.length > 0 and shapely.contains_xy(part.region, *(np.mean(piece.coords, axis=0) + inward)):  # else the part ends at this face
                total += pressed.between(i, *sorted((np.array(end) - a) @ (b - a) / line.length**2 for end in (piece.coords[0], piece.coords[-1])))
    return total


def stage_forces(mesh, scene, stage, part=WHOLE, pressed=None):
    """Returns (X, Y, M) of each load of a stage on the part, and the names of loads that this method does not know. pressed: FaceLoads of the stage; None: no load presses on a face.

    Water in joints is left to base_water.py: it presses on both sides of a joint, and may follow a crack or flow. An added mass is no force at rest, and a temperature none on a part as a whole."""
    forces, left_out = {}, []
    mesh, scene = standing(mesh, scene, stage)
    for name, load in scene.stage_loads(stage).items():
        kind = load.get("type")
        if kind in (*IN_JOINTS, "added_mass", "temperature"):
            continue
        if kind not in (*HEAVY, "point_force") and not load.get("faces"):
            left_out.append(f"{name} ({kind})")
            continue
        forces[name] = weight(mesh, scene, load, part) if kind in HEAVY else point_force(mesh, scene, load, part) if kind == "point_force" else np.zeros(3)
        if pressed is not None:
            forces[name] += on_faces(pressed.of(name), part)
    return forces, left_out


def meets(mesh, load, force):
    """Returns the place (2,) where the resultant (X, Y, M) of a load meets its faces, or the place nearest to it, or the load's point; None: it has neither."""
    if "point" in load:
        return mesh.vertices[mesh.points[load["point"]]]
    segments = wet_segments(mesh, load) if "faces" in load else ()
    if not len(segments):  # on blocks that are not placed yet
        return None
    places = (segments[:, :1] + np.linspace(0, 1, 33)[:, None] * (segments[:, 1:] - segments[:, :1])).reshape(-1, 2)
    return places[np.abs(places[:, 0] * force[1] - places[:, 1] * force[0] - force[2]).argmin()]


def total(forces):
    return sum(forces.values(), np.zeros(3))
