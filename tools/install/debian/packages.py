"""Copies Python packages of the environment that runs this into a folder, each file beside the others: packages.py FOLDER NAME...

Only what runs is copied, and the licences, those to FOLDER/licences/NAME. Prints name and version of each."""

import importlib.metadata
import shutil
import sys
from pathlib import Path


def place_of(name, file):
    """Where a file goes, below the folder; None: nowhere."""
    parts = [part for part in file.parts if part != ".."]
    if parts[-1].startswith(("LICENSE", "CREDITS")):
        return Path("licences", name, parts[-1])
    if file.suffix in (".pyc", ".pxd") or {"tests", "conftest.py"} & set(parts) or ".dist-info" in parts[0]:
        return None
    if file.parts[0] == ".." and ".so" not in file.name:  # of the environment, not of the package
        return None
    return Path(*parts)


def main(folder, *names):
    for name in names:
        distribution = importlib.metadata.distribution(name)
        for file in distribution.files:
            place = place_of(name, file)
            if place is not None:
                (Path(folder) / place).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(file.locate(), Path(folder) / place)
        print(f"{distribution.name} {distribution.version}")


if __name__ == "__main__":
    main(*sys.argv[1:])
