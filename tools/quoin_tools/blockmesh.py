"""python -m quoin_tools.blockmesh: check a block mesh, or say what is in it (mesh/blockmesh.py)"""

import sys

from quoin_tools.base.command import command
from quoin_tools.mesh.blockmesh import main

if __name__ == "__main__":
    sys.exit(command(main))
