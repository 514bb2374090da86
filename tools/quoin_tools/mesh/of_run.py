"""The block mesh that a run was about, with what results.h5 leaves out: face sets, points, groups without output."""

import numpy as np

from quoin_tools.base import scene
from quoin_tools.base.results import ResultsError
from quoin_tools.mesh import blockmesh
from quoin_tools.mesh.meshing import separated


def mesh_of(results, used):
    """(mesh, its path), blocks separated as the scene has them; ResultsError where it is not there, or another one."""
    named = results.summary.get("model")
    path = scene.find(results.folder, named, ("model.h5",))
    if path is None:
        raise ResultsError(f"{results.folder}: the mesh of the run, '{named}', is not there")
    single = [name for name, keys in used.materials.items() if keys.get("macroblocks", True) in (False, 0)]
    mesh = separated(blockmesh.read(path), single)
    rows = results.mesh.vertex_file
    if rows.max(initial=-1) >= len(mesh.vertices) or not np.array_equal(mesh.vertices[rows], results.mesh.vertices):
        raise ResultsError(f"{path}: not the mesh of this run, its vertices differ from those of results.h5")
    return mesh, path
