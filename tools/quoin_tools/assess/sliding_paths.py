"""Finds a path through a joint that the gravity method cannot take alone: a seam that ends inside the rock, or that is bent.

    for way in through(case, stage, "seam"): print(way.name, way.path)

It runs along the joint. From an end inside the body it goes on to the free surface of the groups that the joint lies in: along joints that are
there, the shortest way, but none between other groups (in the dam above its base); where no joint leads out, straight through intact rock. The
left end goes out to the left and the right one to the right where that can be.
"""

from dataclasses import dataclass

import numpy as np
import scipy
import shapely

from quoin_tools.assess import section_cut
from quoin_tools.assess.strength import ON_PATH, contacts_on, lies_on
from quoin_tools.base.joints import is_elastic
from quoin_tools.base.language import _
from quoin_tools.mesh import blockmesh

MOST = 6  # of the lines of a joint set: the longest
WHOLE = 0.99  # of a plane must be joints, else its strength is not theirs


@dataclass(frozen=True)
class SlidingPath:
    """name: of the joints and groups along the path; path: its corners [m]; ends (2, 2): of the joint for which it was found; intact: length [m] through rock without joints."""

    name: str
    path: np.ndarray
    ends: np.ndarray
    intact: float


class Net:
    """Joints of a stage: places where ends of contacts lie together, and contacts between them."""

    def __init__(self, case, stage):
        contacts, mesh = case.results.stage(stage).contacts, case.results.mesh
        points = contacts.point.reshape(-1, 2)
        self.near = min(ON_PATH, 1e-4 * np.ptp(case.mesh.vertices, axis=0).max())
        pairs = scipy.spatial.cKDTree(points).query_pairs(self.near, output_type="ndarray")
        graph = scipy.sparse.coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(points), len(points)))
        count, label = scipy.sparse.csgraph.connected_components(graph, directed=False)
        self.places = np.zeros((count, 2))
        self.places[label] = points
        self.ends, self.length, self.joint = label.reshape(-1, 2), contacts.length, contacts.joint
        self.names = mesh.joint_names
        written = contacts.face[:, [0, 2]] >= 0
        self.groups = np.where(written, mesh.block_group[np.where(written, contacts.face[:, [0, 2]], 0)], -1)  # of both sides

    def chains(self, name):
        """The lines of a joint, the longest first: (places in order, contacts between them); None in the place of one that branches or closes."""
        rows = np.flatnonzero((self.joint == self.names.index(name)) & (self.ends[:, 0] != self.ends[:, 1]))
        _, local = np.unique(self.ends[rows], return_inverse=True)
        local = local.reshape(-1, 2)
        size = local.max(initial=-1) + 1
        _, label = scipy.sparse.csgraph.connected_components(scipy.sparse.coo_matrix((np.ones(len(rows)), local.T), shape=(size, size)), directed=False)
        found = [self.chain(rows[label[local[:, 0]] == k]) for k in range(label.max(initial=-1) + 1)]
        return sorted(found, key=lambda chain: 0.0 if chain is None else -self.length[chain[1]].sum())

    def chain(self, rows):
        places, degree = np.unique(self.ends[rows], return_counts=True)
        tips = places[degree == 1]
        if len(tips) != 2 or degree.max() > 2:
            return None
        at = {}
        for row in rows:
            for place in self.ends[row]:
                at.setdefault(place, []).append(row)
        order = np.lexsort((self.places[tips, 1], np.round(self.places[tips, 0] / self.near)))
        nodes, mine = [tips[order[0]]], at[tips[order[0]]][:]
        while len(mine) < len(rows):
            nodes.append(self.ends[mine[-1]].sum() - nodes[-1])
            mine.append(next(row for row in at[nodes[-1]] if row != mine[-1]))
        return [*nodes, self.ends[mine[-1]].sum() - nodes[-1]], mine

    def out(self, end, right, others, groups, surface):
        """Places from an end of a joint out to the surface, contacts between them, and the last step through intact rock (2,) or None. others: places not to come to."""
        usable = np.isin(self.groups, groups).any(axis=1) & ~np.isin(self.ends, others).any(axis=1) & (self.ends[:, 0] != self.ends[:, 1])
        rows = np.flatnonzero(usable)
        size = len(self.places)
        graph = scipy.sparse.coo_matrix((np.maximum(self.length[rows], 1e-12), self.ends[rows].T), shape=(size, size))
        far, before = scipy.sparse.csgraph.dijkstra(graph.tocsr(), directed=False, indices=end, return_predecessors=True)
        reached = np.flatnonzero(np.isfinite(far))
        sides = [side for side in (on_side(surface, self.places[end, 0], right, self.near), surface) if not side.is_empty]
        gaps = [shapely.distance(shapely.points(self.places[reached]), side) for side in sides]
        foot, last = None, None
        for gap in gaps:
            if (gap <= self.near).any():
                last = reached[np.where(gap <= self.near, far[reached], np.inf).argmin()]
                break
        else:
            if not sides:
                return None
            last = reached[(gaps[0] + 1e-6 * far[reached]).argmin()]
            foot = np.array(shapely.shortest_line(shapely.Point(self.places[last]), sides[0]).coords[-1])
        nodes = [last]
        while nodes[-1] != end:
            nodes.append(before[nodes[-1]])
        nodes.reverse()
        used = [rows[(np.isin(self.ends[rows], pair).all(axis=1)).argmax()] for pair in zip(nodes[:-1], nodes[1:])]
        return nodes, used, foot


def on_side(surface, x, right, near):
    low, high = (x - near, np.inf) if right else (-np.inf, x + near)
    bounds = np.clip([low, high], *(np.array(surface.bounds)[[0, 2]] + [-1, 1]))
    return shapely.intersection(surface, shapely.box(bounds[0], surface.bounds[1] - 1, bounds[1], surface.bounds[3] + 1)) if bounds[0] < bounds[1] else shapely.LineString()


def free_surface(case, groups):
    """Outer faces of groups, but for those that supports hold. groups: their names."""
    mesh = case.mesh
    faces = blockmesh.outer_faces(mesh)
    faces = faces[np.isin(mesh.block_group[faces[:, 0]], [mesh.group_names.index(name) for name in groups])]
    held = {tuple(face) for name in case.scene.supports for face in mesh.face_sets.get(name, np.zeros((0, 2), dtype=int)).tolist()}
    faces = np.array([face for face in faces.tolist() if tuple(face) not in held]).reshape(-1, 2)
    segments = mesh.vertices[blockmesh.face_ends(mesh, faces)]
    outside = shapely.union_all([polygon.exterior for polygon in shapely.get_parts(case.whole)])
    return shapely.multilinestrings(segments[shapely.distance(shapely.points(segments.mean(axis=1)), outside) <= section_cut.GAP])


def supported(case):
    """Numbers of the groups of the run's mesh that supports hold: the ground."""
    mesh, held = case.mesh, [case.mesh.face_sets[name][:, 0] for name in case.scene.supports if name in case.mesh.face_sets]
    names = {mesh.group_names[row] for row in np.unique(mesh.block_group[np.concatenate(held)])} if held else set()
    return [row for row, name in enumerate(case.results.mesh.group_names) if name in names]


def through(case, stage, name):
    """Ways through a joint that is one line, straight or bent; of several lines through the longest that lie in the ground. None where it is a net."""
    if name not in case.sliding_paths:
        net = Net(case, stage)
        chains = net.chains(name)
        taken = [chain for chain in chains if chain]
        if len(chains) > 1:  # beds of a dam are no ways, though one of them may be a line by itself
            ground = supported(case)
            taken = [chain for chain in taken if np.isin(net.groups[chain[1]], ground).all()][:MOST]
        ways = [path_along(case, net, *chain) for chain in taken]
        if None in ways or len(ways) < len(chains):
            case.in_part.add(name)
        case.sliding_paths[name] = [way for way in ways if way is not None and not on_a_path(case, way)]
    return case.sliding_paths[name]


def on_a_path(case, way):
    """Tells whether the options name a path through the joint of this one."""
    return any(all(lies_on(path, end) for end in way.ends) for path in case.options.paths.values())


def path_along(case, net, nodes, rows):
    """The way along a line of a joint; None where no path leads out that does not cross itself."""
    groups = np.unique(net.groups[rows])
    groups = groups[groups >= 0]
    names = [case.results.mesh.group_names[row] for row in groups]
    surface = free_surface(case, names)
    outside = shapely.union_all([polygon.exterior for polygon in shapely.get_parts(case.whole)])
    intact, corners, labels, taken = 0.0, list(net.places[nodes]), [net.names[net.joint[row]] for row in rows], list(nodes)
    for right, tip in ((False, nodes[0]), (True, nodes[-1])):
        if shapely.distance(shapely.Point(net.places[tip]), outside) <= net.near:
            continue
        found = net.out(tip, right, [place for place in taken if place != tip], groups, surface)
        if found is None:
            return None
        more, used, foot = found
        taken += more
        added, said = list(net.places[more[1:]]), [net.names[net.joint[row]] for row in used]
        if foot is not None:
            intact += float(np.hypot(*(foot - net.places[more[-1]])))
            added, said = [*added, foot], [*said, *names[-1:]]
        corners, labels = (corners + added, labels + said) if right else (added[::-1] + corners, said[::-1] + labels)
    path = np.array(corners)
    if not shapely.LineString(path).is_simple:
        return None
    turned = section_cut.checked_path(path)
    labels = labels if (turned[0] == path[0]).all() else labels[::-1]
    ends = net.places[[nodes[0], nodes[-1]]]
    return SlidingPath("+".join(dict.fromkeys(labels)), section_cut.straightened(turned), ends, intact)


def strength(case, stage, way, plane):
    """Returns the strength of the joints along the plane on which the part above slides, each with its own; empty where the path leads through intact rock, or a joint is elastic."""
    if given := case.options.strengths.get(way.name):
        return given
    contacts = case.results.stage(stage).contacts
    mine = contacts_on(plane.ends() if plane.path is None else plane.path, contacts)
    places = np.sort((contacts.point[mine] - plane.start) @ plane.along, axis=1)
    if way.intact > 0 or np.diff(places, axis=1).sum() < WHOLE * plane.length:
        return {}
    keys = {row: case.scene.joint(case.results.mesh.joint_names[row], stage) for row in np.unique(contacts.joint[mine])}
    if any(is_elastic(own) for own in keys.values()):
        return {}
    return next(iter(keys.values())) | {"spans": [(low, high, keys[row]) for (low, high), row in zip(places, contacts.joint[mine])]}


def words(way):
    """Writes what a reader of the numbers of this path must know."""
    (x, y), (u, v) = way.path[0], way.path[-1]
    said = [_("The way {0} from ({1:.2f}, {2:.2f}) to ({3:.2f}, {4:.2f}) m is found by itself, as the shortest one along joints out of the rock: --path names another one.", way.name, x, y, u, v)]
    if way.intact > 0:
        said.append(_("The way {0} leaves the joints: {1:.2f} m of it are intact rock, whose strength the scene does not have: --strength-on {0}=PHI,C gives that of the way.", way.name, way.intact))
    return said
