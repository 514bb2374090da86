"""python -m quoin_tools.motion: what is in a record, its response spectrum, a block that slides on it (show/motion.py)"""

import sys

from quoin_tools.base.command import command
from quoin_tools.show.motion import main

if __name__ == "__main__":
    sys.exit(command(main))
