"""Block mesh of section G1 of the Guilhofrei dam on its rock foundation.

    PYTHONPATH=tools python examples/guilhofrei_yielding/mesh.py OUTPUT.h5 [COLUMNS]

COLUMNS of blocks across the base of the dam, 12 by default."""

import sys

from quoin_tools.mesh.dam import main

if __name__ == "__main__":
    if len(sys.argv) not in (2, 3) or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    sys.exit(main(["-o", sys.argv[1], "--columns", sys.argv[2] if len(sys.argv) > 2 else "12"]))
