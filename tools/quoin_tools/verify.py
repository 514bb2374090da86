"""python -m quoin_tools.verify: is a sheet as written, and about these files? (show/verify.py)"""

import sys

from quoin_tools.base.command import command
from quoin_tools.show.verify import main

if __name__ == "__main__":
    sys.exit(command(main))
