"""python -m quoin_tools.plots: pictures of a run (show/plots.py)"""

import sys

from quoin_tools.base.command import command
from quoin_tools.show.plots import main

if __name__ == "__main__":
    sys.exit(command(main))
