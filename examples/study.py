"""The paper's numbers of section 4 and ours, in one table.

    PYTHONPATH=tools python examples/study.py OUT

OUT holds the folders guilhofrei, guilhofrei_local, guilhofrei_voronoi and guilhofrei_sliding, as tools/study.sh leaves them; writes
OUT/study/table.md and table.csv. The section is a reconstruction from the paper's text: examples/guilhofrei/README.md."""

import csv
import importlib.util
import os
import sys

from quoin_tools.results import ResultsError, table

PARTS = {"4.1": "guilhofrei", "4.2": "guilhofrei_local", "4.3": "guilhofrei_voronoi", "4.4": "guilhofrei_sliding"}
HEADER = ("section", "quantity", "unit", "paper", "ours", "independent")


def rows_of(name, folder):
    """Rows of an example's compare.py: quantity, unit, paper, ours, an independent number."""
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), name, "compare.py")
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.study(folder)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    rows, missing = [], []
    for section, name in PARTS.items():
        try:
            rows += [(section, *row) for row in rows_of(name, os.path.join(sys.argv[1], name))]
        except (ResultsError, KeyError) as error:
            missing.append(f"{section}: no numbers: {error}")
    os.makedirs(os.path.join(sys.argv[1], "study"), exist_ok=True)
    target = os.path.join(sys.argv[1], "study", "table")
    with open(target + ".csv", "w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([HEADER, *rows])
    with open(target + ".md", "w", encoding="utf-8") as file:
        lines = [HEADER, ["---"] * 3 + ["---:"] * 3, *rows]
        file.writelines("| " + " | ".join(line) + " |\n" for line in lines)
    print("\n".join(table(list(HEADER), [[cell or "-" for cell in row] for row in rows]) + missing))
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
