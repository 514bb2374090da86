"""python -m quoin_tools.report: the sheet of a run, HTML and PDF (show/report.py)"""

import sys

from quoin_tools.base.command import command
from quoin_tools.show.report import main

if __name__ == "__main__":
    sys.exit(command(main))
