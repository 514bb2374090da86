"""Table and picture of the local failure factors of three scenarios against the paper's numbers.

    PYTHONPATH=tools python examples/guilhofrei_local/compare.py OUTPUT

OUTPUT holds the runs 1, 2 and 3; fig_13.png goes there too. The section is reconstructed, so the paper's numbers are a guide."""

import os
import sys

from quoin_tools.paper_figures import figure_13, references
from quoin_tools.results import Results, ResultsError, table

STAGE = "swhp"


def compare(folder):
    """Rows of reference.csv with the least factor of the dam: value, mode, x, y, area."""
    found = []
    for row in references(__file__, "paper"):
        results = Results(os.path.join(folder, row["scenario"]))
        found.append(dict(row, results=results, ours=results.stage_summary(STAGE)["safety"]["dam"]))
    return found


def paper(row):
    return "above 2.5" if row["paper"] is None else f"{row['paper']:g}"


def study(folder):
    """Rows of the study (examples/study.py)."""
    return [(f"scenario {row['scenario']}: least local failure factor", "-", paper(row), f"{row['ours']['value']:.2f}", "")
            for row in compare(folder)]  # fmt: skip


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    try:
        rows = compare(sys.argv[1])
    except ResultsError as error:
        sys.exit(f"compare: {error}")
    print("Guilhofrei dam, block DE, least local failure factor: the paper, this run")
    print("Section G1 is a reconstruction from the paper's text: see examples/guilhofrei/README.md\n")
    cells = [(row["scenario"], row["tension_MPa"], row["cohesion_MPa"], row["paper"] or "-", f"{row['ours']['value']:.2f}",
              f"{row['ours']['mode']} at ({row['ours']['x']:.1f}, {row['ours']['y']:.1f})") for row in rows]  # fmt: skip
    print("\n".join(table(["scenario", "tension MPa", "cohesion MPa", "paper", "ours", "where"], cells)))
    figure_13([(f"scenario {row['scenario']}", row["results"], paper(row)) for row in rows], os.path.join(sys.argv[1], "fig_13.png"), STAGE)


if __name__ == "__main__":
    main()
