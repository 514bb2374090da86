"""python -m quoin_tools.results: table of stages, probes, joints and extreme stresses of a run (base/results.py)"""

import sys

from quoin_tools.base.command import command
from quoin_tools.base.results import main

if __name__ == "__main__":
    sys.exit(command(main))
