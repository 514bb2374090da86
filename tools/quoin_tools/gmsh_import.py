"""python -m quoin_tools.gmsh_import: block mesh from a Gmsh file (mesh/gmsh_import.py)"""

import sys

from quoin_tools.base.command import command
from quoin_tools.mesh.gmsh_import import main

if __name__ == "__main__":
    sys.exit(command(main))
