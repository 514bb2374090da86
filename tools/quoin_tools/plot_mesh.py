"""python -m quoin_tools.plot_mesh: picture of a block mesh (show/plot_mesh.py)"""

import sys

from quoin_tools.base.command import command
from quoin_tools.show.plot_mesh import main

if __name__ == "__main__":
    sys.exit(command(main))
