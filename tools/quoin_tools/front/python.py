"""Provides run() and mesh() for Python programs; results are arrays of numpy (quoin_tools.base.results)."""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Sequence
from typing import Any

import yaml

from quoin_tools.base import solver
from quoin_tools.base.results import Results
from quoin_tools.base.scene import Loader
from quoin_tools.mesh.blockmesh import BlockMesh, MeshError

__all__ = ["BlockMesh", "MeshError", "Results", "RunError", "mesh", "run"]

VERDICTS = (0, 3, 4, 6)  # exit codes of runs that have come to their end: done, diverged, undecided, collapsed


class RunError(ValueError):
    """The solver gave no results; the message is the solver's, code its exit code."""

    def __init__(self, message, code):
        super().__init__(message)
        self.code = code


def run(scene: str | os.PathLike[str] | dict[str, Any], ranks: int = 1, keys: dict[str, Any] | None = None, output: str | os.PathLike[str] | None = None, progress: bool = False) -> Results:
    """Results of a scene: a file, or a dictionary as the file would have it. keys: values of keys by their names, "loads.water.level": 33;
    output: folder of results in place of the scene's; progress: the solver's lines go to the terminal. A run whose stages did not all converge has
    results too: results.summary["stages"][-1]["verdict"]. RunError: there are none."""
    given = dict(keys or {}) | ({} if output is None else {"output": os.fspath(output)})
    if not isinstance(scene, dict):
        return run_file(os.fspath(scene), ranks, given, progress)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scene.yaml")
        with open(path, "w", encoding="utf-8") as file:
            yaml.safe_dump(scene, file, sort_keys=False)
        return run_file(path, ranks, given, progress)


def mesh(source: str | os.PathLike[str], output: str | os.PathLike[str] | None = None, interfaces: Sequence[str] = (), rigid: Sequence[str] = (), unit: str | None = None) -> BlockMesh:
    """Block mesh of a section, of the table of a drawing (YAML) or of a mesh of Gmsh (.msh); output: the file to write, model.h5. Of a mesh of Gmsh: interfaces are
    the curves that open as joints, rigid the groups of rigid blocks, unit that of its coordinates. MeshError: why there is none."""
    from quoin_tools.mesh import blockmesh, gmsh_import, section  # here: gmsh is slow to load

    path = os.fspath(source)
    if path.lower().endswith(".msh"):
        made = gmsh_import.import_msh(path, interfaces, rigid, unit)
        blockmesh.check(made)
    elif interfaces or rigid or unit:
        raise MeshError(f"{path}: interfaces, rigid and unit are of a mesh of Gmsh (.msh); a section has keys of its own for them")
    else:
        made = section.mesh_of(path)[0]
    if output is not None:
        blockmesh.write(os.fspath(output), made)
    return made


def run_file(path, ranks, keys, progress):
    words = solver.command(["-options_file", path, *options(keys)], ranks)
    done = solver.run(words, env=solver.environment(ranks), stderr=subprocess.PIPE, stdout=None if progress else subprocess.DEVNULL)
    if done.returncode not in VERDICTS:
        lines = [line for line in done.stderr.splitlines() if line.strip()]
        raise RunError(lines[-1] if lines else f"the solver ended with code {done.returncode} and said nothing", done.returncode)
    return Results(str(keys.get("output") or output_of(path)))


def output_of(path):
    """Returns the output folder that a scene names. Its numbers may carry units, which only the solver knows."""
    with open(path, encoding="utf-8") as file:
        return str((yaml.load(file, Loader) or {}).get("output") or "out")  # noqa: S506 (a SafeLoader)


def options(keys):
    """Returns words of the command line that give keys of the scene their values."""
    words = []
    for key, value in keys.items():
        words += ["-" + key.replace(".", "_"), value_word(value)]
    return words


def value_word(value):
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        return ",".join(value_word(item) for item in value)
    return repr(value) if isinstance(value, float) else str(value)
