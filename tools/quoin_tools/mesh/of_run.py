"""Finds the block mesh of a run, which has more than results.h5: face sets, points, groups without output."""

import os

import numpy as np

from quoin_tools.base import scene
from quoin_tools.base.results import ResultsError
from quoin_tools.mesh import blockmesh
from quoin_tools.mesh.meshing import separated


def mesh_of(results, used):
    """Returns (mesh, its path), with blocks separated as in the scene; ResultsError where it is missing, or another mesh."""
    named = results.summary.get("model")
    path = scene.find(results.folder, named, ("model.h5",))
    if path is None:
        raise ResultsError(f"{results.folder}: the mesh of the run, '{named}', is not there")
    mesh = mesh_at(path, used)
    rows = results.mesh.vertex_file
    if rows.max(initial=-1) >= len(mesh.vertices) or not np.array_equal(mesh.vertices[rows], results.mesh.vertices):
        raise ResultsError(f"{path}: not the mesh of this run, its vertices differ from those of results.h5")
    return mesh, path


def mesh_at(path, used):
    """Reads the block mesh of a file, with blocks separated as in the scene."""
    single = [name for name, keys in used.materials.items() if keys.get("macroblocks", True) in (False, 0)]
    return separated(blockmesh.read(path), single)


def mesh_of_scene(used):
    """Returns (mesh, its path) that a scene names, from the working directory or beside its file; ResultsError where it is missing."""
    path = scene.find(os.path.dirname(os.path.abspath(used.path)), used.model)
    if not used.model or path is None:
        raise ResultsError(f"{used.path}: the block mesh '{used.model}' is not there")
    return mesh_at(path, used), path
