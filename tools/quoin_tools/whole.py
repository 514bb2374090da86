"""python -m quoin_tools.whole: are the files of a run what it wrote? (base/integrity.py)"""

import sys

from quoin_tools.base.command import command
from quoin_tools.base.integrity import main

if __name__ == "__main__":
    sys.exit(command(main))
