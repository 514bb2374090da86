"""Runs the command `quoin` as `python -m quoin_tools COMMAND ...`, with PYTHONPATH=tools."""

import sys

from quoin_tools.front.main import main

if __name__ == "__main__":
    sys.exit(main())
