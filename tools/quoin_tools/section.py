"""python -m quoin_tools.section: block mesh of a section declared in a YAML file (mesh/section.py)"""

import sys

from quoin_tools.base.command import command
from quoin_tools.mesh.section import main

if __name__ == "__main__":
    sys.exit(command(main))
