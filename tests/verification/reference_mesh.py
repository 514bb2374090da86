"""The meshes of tests/data/reference as block meshes: same vertices, same blocks, same order."""

import json
import os

import numpy as np
from quoin_tools.mesh.blockmesh import BlockMesh, MeshError, face_ends, outer_faces
from quoin_tools.mesh.meshing import faces_on_edges
from triangle_dam import assemble


def from_reference(json_path, kind=None):
    """Block mesh of a reference file; kind fig6 or guilhofrei, by default from the name of the file."""
    name = os.path.basename(os.fspath(json_path))
    kind = kind or ("fig6" if "fig6" in name else "guilhofrei")
    if kind not in KINDS:
        raise MeshError(f"kind of reference mesh {kind!r}: expected {' or '.join(KINDS)}")
    with open(json_path, encoding="utf-8") as file:
        data = json.load(file)
    try:
        return KINDS[kind](data)
    except KeyError as error:
        raise MeshError(f"{json_path}: no {error} in it, is this a {kind} mesh?") from None


def from_fig6(data):
    """The ground of the reference is a line of fixed nodes without blocks: hang rigid blocks below it."""
    nodes, ground = np.array(data["nodes"]), data["fixed_ground_nodes"]
    dam_nodes = len(nodes) - len(ground)
    if ground != list(range(dam_nodes, len(nodes))):
        raise MeshError("fig6 reference: the fixed ground nodes are not the last ones")
    return assemble(nodes[:dam_nodes], data["quads"], data["triangles"], nodes[ground, 0])


def from_guilhofrei(data):
    """Dam and rock with their doubled base; face sets and points as in mesh/dam.py."""
    blocks = np.array(data["quads"])
    if data["triangles"]:
        blocks = np.concatenate([blocks, np.pad(data["triangles"], ((0, 0), (0, 1)), constant_values=-1)])
    names = ["dam", "rock"]
    groups = [names.index(name) for name in data["group"]]
    mesh = BlockMesh(data["nodes"], blocks, groups, names, [0, 0])
    segments = np.array(data["joint_segments_lower_then_upper"])
    upstream = np.array(data["upstream_face_nodes_bottom_to_top"])
    crest_left, crest_right = data["crest_upstream_node"], data["crest_downstream_node"]
    heel, toe, rock_heel, rock_toe = segments[0, 2], segments[-1, 3], segments[0, 0], segments[-1, 1]
    mesh.face_sets["base"] = faces_on_edges(mesh, np.concatenate([segments[:, :2], segments[:, 2:]]))
    mesh.face_sets["upstream"] = faces_on_edges(mesh, np.column_stack([upstream[:-1], upstream[1:]]))
    mesh.face_sets["rock_sides"] = faces_between(mesh, data["fixed_x"])
    mesh.face_sets["rock_bottom"] = faces_between(mesh, data["fixed_y"])
    mesh.points = {"crest_upstream": crest_left, "crest_downstream": crest_right, "heel": heel, "toe": toe,
                   "rock_heel": rock_heel, "rock_toe": rock_toe}
    name_free_faces(mesh)
    return mesh


def faces_between(mesh, nodes):
    """Outer faces, both of whose vertices are listed."""
    faces = outer_faces(mesh)
    return faces[np.isin(face_ends(mesh, faces), nodes).all(axis=1)]


def name_free_faces(mesh):
    """What is left of the boundary: crest and downstream face of the dam, top of the rock on both sides."""
    outer = outer_faces(mesh)
    named = {tuple(row) for rows in mesh.face_sets.values() for row in rows.tolist()}
    free = np.array([row for row in outer.tolist() if tuple(row) not in named])
    middle = mesh.vertices[face_ends(mesh, free)].mean(axis=1)
    dam = mesh.block_group[free[:, 0]] == mesh.group_names.index("dam")
    xy = {name: mesh.vertices[vertex] for name, vertex in mesh.points.items()}
    crest = dam & (np.abs(middle[:, 1] - xy["crest_upstream"][1]) < 1e-6)
    mesh.face_sets["crest"] = free[crest]
    mesh.face_sets["downstream"] = free[dam & ~crest]
    mesh.face_sets["rock_top_upstream"] = free[~dam & (middle[:, 0] < xy["heel"][0])]
    mesh.face_sets["rock_top_downstream"] = free[~dam & (middle[:, 0] > xy["toe"][0])]


KINDS = {"fig6": from_fig6, "guilhofrei": from_guilhofrei}
