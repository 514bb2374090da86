"""Table and picture of the friction angles at failure of three Voronoi dams against the paper's.

    PYTHONPATH=tools python examples/guilhofrei_voronoi/compare.py OUTPUT

OUTPUT holds the runs 1, 2 and 3, and one_rank/1 to 3 on one rank; fig_14.png goes there too. Section and polygons are not the
paper's: only the ranges can be compared."""

import os
import sys

import numpy as np
from quoin_tools.paper_figures import figure_14, references
from quoin_tools.results import Results, ResultsError, table

STAGE = "reduction"
MOVING = 0.1  # of the largest velocity of a block: it belongs to the mechanism


def lowest_moving(results):
    """Level [m] of the lowest centre of a block that moves; None where nothing failed."""
    mesh, velocity = results.mesh, results.stage(STAGE).mechanism
    if velocity is None:
        return None
    speed = np.hypot(*np.moveaxis(mesh.rings(velocity).mean(axis=1), 1, 0))
    return mesh.centres()[speed > MOVING * speed.max(), 1].min()


def same_bits(folder, results, seed):
    """Whether the run on one rank ended with the same bits in every stage; None without it."""
    try:
        one = Results(os.path.join(folder, "one_rank", seed)).summary["stages"]
    except ResultsError:
        return None
    return [stage["checksum"] for stage in one] == [stage["checksum"] for stage in results.summary["stages"]]


def compare(folder):
    """Rows of reference.csv with the last stable and the first failing angle, crest displacement in between, and where it moves."""
    rows = []
    for row in references(__file__):
        results = Results(os.path.join(folder, row["seed"]))
        found = results.stage_summary(STAGE)["strength_reduction"]
        stable = [trial for trial in found["trials"] if trial["outcome"] == "stable"]
        rows.append(dict(row, results=results, stable=found["stable"], failing=found["failing"], lowest=lowest_moving(results),
                         crest=stable[-1]["probes"]["crest_upstream"]["u_x"] if stable else None,
                         same=same_bits(folder, results, row["seed"])))  # fmt: skip
    return rows


def number(value, scale=1.0):
    return "-" if value is None else f"{scale * value:.1f}"


def ends(row):
    """Failing angle as text; where nothing fails, a trial stayed undecided or the last angle was reached."""
    return f"{row['failing']:g}" if row["failing"] is not None else "not decided"


def study(folder):
    """Rows of the study (examples/study.py)."""
    return [(f"seed {row['seed']}: friction angle at failure (the paper: model {row['model']})", "degree", row["paper_degree"], ends(row), "")
            for row in compare(folder)]  # fmt: skip


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    try:
        rows = compare(sys.argv[1])
    except ResultsError as error:
        sys.exit(f"compare: {error}")
    print("Guilhofrei dam, block DE, friction angle [degree] at failure without cohesion: the paper, this run")
    print("Section G1 is a reconstruction, and the polygons are not the paper's: compare the ranges only\n")
    words = {None: "-", True: "yes", False: "NO"}
    cells = [(row["model"], row["paper_degree"], row["seed"], number(row["stable"]), ends(row), number(row["crest"], 1e3),
              number(row["lowest"]), words[row["same"]]) for row in rows]  # fmt: skip
    header = ["model", "paper", "seed", "stable", "fails", "crest u_x mm", "moves above y m", "same bits on 1 rank"]
    print("\n".join(table(header, cells)))
    figure_14([(f"seed {row['seed']}: stands at {row['stable']:g}°, fails: {ends(row)}\n(the paper's model {row['model']}: {row['paper_degree']}°)", row["results"],
                STAGE) for row in rows], os.path.join(sys.argv[1], "fig_14.png"))  # fmt: skip
    if any(row["same"] is False for row in rows):
        sys.exit("compare: one rank and several do not give the same bits")


if __name__ == "__main__":
    main()
