"""Python tools of Quoin. `quoin -h`, also `python -m quoin_tools -h` with PYTHONPATH=tools, lists the commands; quoin.py runs scenes from Python.

Rooms, from bottom to top; a room imports only what stands above it in this list:

base         reads scenes and the files of runs, writes files, ends a command
mesh         makes, reads and checks block meshes
assess       the gravity method, guidelines and limits beside the block model
limit        limit analysis: what rigid blocks can bear at most
ensemble     samples of a scene whose properties scatter
readings     readings of instruments, and the statistics of them
show         pictures, the sheet, CSV, the comparison of runs
front        the command `quoin`, its Python interface

Of scipy a room imports the name alone: its parts load where they are first used, and a sheet that needs no statistics comes half a
second sooner.
"""

import re
import sys
from pathlib import Path

PACKAGES = Path(__file__).resolve().parents[1] / "packages"  # of the Debian package: newer packages than Debian's
if PACKAGES.is_dir():
    sys.path.insert(0, str(PACKAGES))


def version():
    """As CMakeLists.txt of a checkout has it, or as this package is installed."""
    project = Path(__file__).resolve().parents[2] / "CMakeLists.txt"
    found = re.search(r"^project\(quoin VERSION (\S+)", project.read_text(encoding="utf-8"), flags=re.M) if project.is_file() else None
    if found:
        return found[1]
    import importlib.metadata  # here: it takes as long to load as half of the rest of a command

    try:
        return importlib.metadata.version("quoin")
    except importlib.metadata.PackageNotFoundError:
        return "unknown"  # a copy of the folder


__version__ = version()
