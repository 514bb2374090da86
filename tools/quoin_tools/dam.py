"""python -m quoin_tools.dam: mesh of a gravity dam on rock (mesh/dam.py)"""

import sys

from quoin_tools.base.command import command
from quoin_tools.mesh.dam import main

if __name__ == "__main__":
    sys.exit(command(main))
