"""python -m quoin_tools.walls: meshes of walls, arches and slopes (mesh/walls.py)"""

import sys

from quoin_tools.base.command import command
from quoin_tools.mesh.walls import main

if __name__ == "__main__":
    sys.exit(command(main))
