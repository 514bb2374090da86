"""Python tools of Quoin. `quoin -h` has them all; quoin.py runs scenes from Python.

Commands, also as `python -m quoin_tools.NAME --help` with PYTHONPATH=tools; each is a file here of a few lines that calls the main() of its room:

results      table of stages, probes, joints and extreme stresses of a run
whole        are the files of a run what it wrote?
blockmesh    check a block mesh, or say what is in it
section      mesh of a dam declared in a YAML file
dam          mesh of a gravity dam on rock
voronoi      mesh of a dam of random polygons
walls        meshes of walls, arches and slopes
gmsh_import  block mesh from a Gmsh file
assessment   the gravity method beside a run, in the terminal
hinges       how a limit moves with the stiffness of the joints
plot_mesh    picture of a block mesh
plots        pictures of a run
animate      film of a stage in time, or of how a stage fails
motion       what is in a record: spectrum, Newmark's block; points of a run
report       the sheet of a run, HTML and PDF
verify       is a sheet as written, and about these files?
export       a run as CSV
compare      two runs: what differs, by how much

Rooms, from bottom to top; a room imports only what stands above it in this list:

base         reads scenes and the files of runs, writes files, ends a command
mesh         makes, reads and checks block meshes
assess       the gravity method, guidelines and limits beside the block model
limit        limit analysis: what rigid blocks can bear at most
ensemble     samples of a scene whose properties scatter
show         pictures, the sheet, CSV, the comparison of runs
front        the command `quoin`, its Python interface

Of scipy a room imports the name alone: its parts load where they are first used, and a sheet that needs no statistics comes half a
second sooner.
"""

import re
import sys
from pathlib import Path

PACKAGES = Path(__file__).resolve().parents[1] / "packages"  # of the Debian package: what Debian has too old
if PACKAGES.is_dir():
    sys.path.insert(0, str(PACKAGES))


def version():
    """As CMakeLists.txt of a checkout has it, or as this package is installed."""
    project = Path(__file__).resolve().parents[2] / "CMakeLists.txt"
    found = re.search(r"^project\(quoin VERSION (\S+)", project.read_text(encoding="utf-8"), flags=re.M) if project.is_file() else None
    if found:
        return found[1]
    import importlib.metadata  # here: it takes as long to load as half of the rest of a command

    try:
        return importlib.metadata.version("quoin")
    except importlib.metadata.PackageNotFoundError:
        return "unknown"  # a copy of the folder


__version__ = version()
