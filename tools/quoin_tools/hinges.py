"""python -m quoin_tools.hinges: how a limit moves with the stiffness of the joints (assess/hinges.py)"""

import sys

from quoin_tools.assess.hinges import main
from quoin_tools.base.command import command

if __name__ == "__main__":
    sys.exit(command(main))
