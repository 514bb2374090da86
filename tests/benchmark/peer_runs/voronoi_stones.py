"""Voronoi dams of section G1 whose stones are all convex, as LMGC90 asks for: the one or two stones with a corner that enters are cut there.

Every program gets the same rings, and so the same joints."""

import numpy as np
from quoin_tools.mesh import polygons
from quoin_tools.mesh.dam import G1
from quoin_tools.mesh.voronoi import Options, block_mesh, checked_section, tessellate

STRAIGHT = 180.001  # [degree] a corner beyond enters the stone


def dam(side, seed):
    """BlockMesh; rings (list of (n, 2) corners, counter-clockwise) [m] and whether each stands on the base."""
    options = Options(side=side, seed=seed)
    section = checked_section(G1.corners(), options)
    tess, facing = tessellate(section, options)
    pieces = [(piece, wing) for ring, wing in zip(tess.rings, facing) for piece in convex(list(ring), tess.nodes)]
    tess.rings = [piece for piece, _ in pieces]
    mesh = block_mesh(tess, np.array([wing for _, wing in pieces]), section, options)
    rings = [tess.nodes[ring] for ring in tess.rings]
    heel, toe = section[:2]
    normal = np.array([heel[1] - toe[1], toe[0] - heel[0]]) / np.hypot(*(toe - heel))
    return mesh, rings, [bool((np.abs((ring - heel) @ normal) < 1e-6).sum() > 1) for ring in rings]


def convex(ring, nodes):
    """The ring cut until no corner enters, each time to the corner that leaves the least sharp turn."""
    angles, n = polygons.corner_angles(nodes[ring]), len(ring)
    k = int(np.argmax(angles))
    if angles[k] < STRAIGHT:
        return [ring]
    turned = ring[k:] + ring[:k]
    halves = [(turned[:j + 1], turned[j:] + turned[:1]) for j in range(2, n - 1)]
    return [piece for half in min(halves, key=lambda pair: max(polygons.corner_angles(nodes[part]).max() for part in pair)) for piece in convex(half, nodes)]
