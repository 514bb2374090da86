"""python -m quoin_tools.animate: film of a dynamic stage, or of how a stage fails (show/animate.py)"""

import sys

from quoin_tools.base.command import command
from quoin_tools.show.animate import main

if __name__ == "__main__":
    sys.exit(command(main))
