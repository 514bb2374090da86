"""Quoin from Python, and the command `quoin` (quoin_tools.front).

import quoin

results = quoin.run("scene.yaml", ranks=2)      # or quoin.run({"model": "model.h5", ...}); keys={"joints.base.friction": 40}
quoin.mesh("dam.yaml", "model.h5")              # block mesh of a section, a drawing, a mesh of Gmsh
results.stage("full").displacement              # arrays: docs/results_format.md; results = quoin.Results("out") reads an older run
"""

import sys
from typing import TYPE_CHECKING

from quoin_tools import __version__ as __version__
from quoin_tools.front.main import main

if TYPE_CHECKING:  # for editors and checkers of types
    from quoin_tools.front.python import BlockMesh, MeshError, Results, RunError, mesh, run

LATER = ("BlockMesh", "MeshError", "Results", "RunError", "mesh", "run")
__all__ = ["BlockMesh", "MeshError", "Results", "RunError", "__version__", "main", "mesh", "run"]


def __getattr__(name):
    """What needs numpy comes when it is asked for, so that the command starts without it."""
    if name not in LATER:
        raise AttributeError(f"module 'quoin' has no attribute '{name}'")
    from quoin_tools.front import python

    return getattr(python, name)


def __dir__():
    return sorted([*globals(), *LATER])


if __name__ == "__main__":
    sys.exit(main())
