"""python -m quoin_tools.assessment: the gravity method beside a run, in the terminal (assess/terminal.py)"""

import sys

from quoin_tools.assess.terminal import main
from quoin_tools.base.command import command

if __name__ == "__main__":
    sys.exit(command(main))
