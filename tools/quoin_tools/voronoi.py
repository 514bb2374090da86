"""python -m quoin_tools.voronoi: mesh of a dam of random polygons (mesh/voronoi.py)"""

import sys

from quoin_tools.base.command import command
from quoin_tools.mesh.voronoi import main

if __name__ == "__main__":
    sys.exit(command(main))
