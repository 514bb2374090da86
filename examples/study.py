"""The paper's numbers of section 4 and ours, in one table.

    PYTHONPATH=tools python examples/study.py OUT

OUT holds the folders guilhofrei, guilhofrei_local, guilhofrei_voronoi and guilhofrei_sliding, as tools/study.sh leaves them; writes
OUT/study/table.md and table.csv. The section is a reconstruction from the paper's text: examples/guilhofrei/README.md."""

import csv
import os
import sys

from compare import EXAMPLES
from quoin_tools.base.results import ResultsError, table

PARTS = {"4.1": "guilhofrei", "4.2": "guilhofrei_local", "4.3": "guilhofrei_voronoi", "4.4": "guilhofrei_sliding"}
HEADER = ("section", "quantity", "unit", "paper", "ours", "independent")


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    rows, missing = [], []
    for section, name in PARTS.items():
        try:
            example = EXAMPLES[name]
            rows += [(section, *example.study(row)) for row in example.rows(os.path.join(sys.argv[1], name))]
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
