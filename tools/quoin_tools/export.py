"""python -m quoin_tools.export: a run as CSV (show/export.py)"""

import sys

from quoin_tools.base.command import command
from quoin_tools.show.export import main

if __name__ == "__main__":
    sys.exit(command(main))
