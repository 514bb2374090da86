"""Table of the paper's numbers for the Guilhofrei dam against those of a run.

    PYTHONPATH=tools python examples/guilhofrei/compare.py OUTPUT

OUTPUT is the folder of the run; fig_11.png and fig_12.png go there too. reference.csv beside this file says where each number comes from and what it is
compared with. The section G1 is reconstructed, so the paper's numbers are a guide; the finite elements used the same
section and mesh (24 columns)."""

import os
import sys

from quoin_tools.paper_figures import figure_11, figure_12, references
from quoin_tools.results import Results, ResultsError, table

MPA = 1e-6


def value(summary, key):
    """What the run gives for a key of reference.csv; summary: of its stage."""
    base, dam = summary["joints"]["base"], summary["stress_by_group"]["dam"]
    applied = summary["applied"]
    return {
        "weight": -applied["y"] / 1e3,
        "thrust": applied["x"] / 1e3,
        "thrust_ratio": -100 * applied["y"] / applied["x"] if applied["x"] else None,
        "crest_ux": summary["probes"]["crest_upstream"]["u_x"] * 1e3,
        "compression": -dam["s2_min"]["value"] * MPA,
        "tension": dam["s1_max"]["value"] * MPA,
        "joint_toe": base["end"]["sigma"] * MPA,
        "joint_heel": base["start"]["sigma"] * MPA,
        "linear_toe": base["sigma_linear_end"] * MPA,
        "linear_heel": base["sigma_linear_start"] * MPA,
        "open_length": base["open_length"],
    }[key]


def compare(folder):
    """Rows of reference.csv with the run's number as `ours`; paper stays as the paper prints it."""
    results = Results(folder)
    return [dict(row, ours=value(results.stage_summary(row["stage"]), row["key"])) for row in references(__file__, "fe")]


def study(folder):
    """Rows of the study: quantity, unit, the paper's number, ours, the independent one (examples/study.py)."""
    return [(f"{row['stage'].upper()}: {row['quantity']}", row["unit"], row["paper"] or "-", number(row["ours"]),
             f"{number(row['fe'])} (finite elements)") for row in compare(folder)]  # fmt: skip


def number(x):
    if x is None:
        return "-"
    return f"{x:.0f}" if abs(x) >= 100 else f"{x:.2f}"


def difference(ours, other):
    """In percent; nothing where the other is zero or small."""
    return "-" if other is None or abs(other) < 0.01 else f"{100 * (ours / other - 1):+.1f} %"


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    try:
        rows = compare(sys.argv[1])
    except ResultsError as error:
        sys.exit(f"compare: {error}")
    print("Guilhofrei dam, block DE: the paper, this run, independent finite elements (24 columns)")
    print("Section G1 is a reconstruction from the paper's text: see examples/guilhofrei/README.md\n")
    header = ["quantity", "stage", "unit", "paper", "ours", "off paper", "FE", "off FE"]
    cells = [(r["quantity"], r["stage"], r["unit"], r["paper"] or "-", number(r["ours"]),
              difference(r["ours"], float(r["paper"] or 0)), number(r["fe"]), difference(r["ours"], r["fe"])) for r in rows]
    print("\n".join(table(header, cells)))
    figure_11(Results(sys.argv[1]), os.path.join(sys.argv[1], "fig_11.png"))
    figure_12(Results(sys.argv[1]), os.path.join(sys.argv[1], "fig_12.png"))


if __name__ == "__main__":
    main()
