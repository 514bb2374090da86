"""python -m quoin_tools.compare: two runs: what differs, by how much (show/compare.py)"""

import sys

from quoin_tools.base.command import command
from quoin_tools.show.compare import main

if __name__ == "__main__":
    sys.exit(command(main))
