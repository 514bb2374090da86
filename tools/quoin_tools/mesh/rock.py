"""Rock that sets of parallel joints cut into blocks.

Every block between joints is a macroblock; a face set for each set of joints."""

from dataclasses import dataclass

import numpy as np
import shapely

from quoin_tools.mesh import polygons
from quoin_tools.mesh.blockmesh import BlockMesh, MeshError
from quoin_tools.mesh.meshing import double_vertices, faces_on_edges


@dataclass(frozen=True)
class JointSet:
    """Parallel joints, one of them through a point. dip: degrees below the horizontal to the right, -90 to 90."""

    name: str
    dip: float
    spacing: float  # m
    through: tuple = (0.0, 0.0)  # m

    def along(self):
        angle = np.radians(self.dip)
        return np.array([np.cos(angle), -np.sin(angle)])


def jointed_rock(outline, sets, shortest=None, refine=0, group="rock"):
    """Mesh of an outline (corners [m], counter-clockwise) and its joints.

    Sides of blocks shorter than `shortest` (default: a fifth of the least spacing) are merged, which bends joints near
    the outline and lets some of them end in it. refine: times every block is cut in quadrilaterals."""
    outline = np.asarray(outline, dtype=float)
    if not sets or not all(np.isfinite([s.dip, s.spacing]).all() and s.spacing > 0 and -90 < s.dip <= 90 for s in sets):
        raise MeshError("joints: expected at least one set, with a positive spacing and a dip above -90 and up to 90 degrees")
    least = min(s.spacing for s in sets)
    tess = polygons.tessellation(cells(outline, sets), outline, 1e-6 * least)
    tidied = polygons.tidy(tess, 0.2 * least if shortest is None else shortest, 0.1 * least**2, 0)
    tess = polygons.tessellation(tidied.polygons(), outline, 1e-6 * least)  # without the nodes that are left over
    vertices, blocks, _ = polygons.blocks_of(tess)
    edges = sorted(polygons.inner_edges(tess.rings))
    owner = nearest_set(tess.nodes, edges, sets)
    for _ in range(refine):
        vertices, blocks, edges = polygons.refined(vertices, blocks, edges)
        owner = np.repeat(owner, 2)
    mesh = BlockMesh(vertices, blocks, np.zeros(len(blocks)), [group], [0])
    for i, joints in enumerate(sets):
        mesh.face_sets[joints.name] = faces_on_edges(mesh, np.array(edges).reshape(-1, 2)[owner == i])
    return double_vertices(mesh, edges)


def cells(outline, sets):
    """Polygons between the joints, from left to right."""
    area = shapely.Polygon(outline)
    lines = [area.exterior, *(area.intersection(line) for joints in sets for line in lines_across(outline, joints))]
    found = [part for part in shapely.polygonize([shapely.union_all(lines)]).geoms if area.contains(part.representative_point())]
    rings = [np.array(shapely.geometry.polygon.orient(part).exterior.coords)[:-1] for part in found]
    return sorted(rings, key=lambda ring: tuple(ring.mean(axis=0).round(6)))


def lines_across(outline, joints):
    along = joints.along()
    across = np.array([-along[1], along[0]])
    offset, reach = (outline - joints.through) @ across / joints.spacing, np.ptp(outline, axis=0).sum()
    middle = outline.mean(axis=0) - joints.through
    for k in range(int(np.ceil(offset.min())), int(np.floor(offset.max())) + 1):
        foot = joints.through + k * joints.spacing * across + (middle @ along) * along
        yield shapely.LineString([foot - reach * along, foot + reach * along])


def nearest_set(nodes, edges, sets):
    """Row of the set to which each edge is most nearly parallel."""
    ends = nodes[np.array(edges).reshape(-1, 2)]
    along = ends[:, 1] - ends[:, 0]
    return np.argmax([np.abs(along @ joints.along()) for joints in sets], axis=0)
