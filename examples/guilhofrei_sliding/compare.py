"""Table and picture of the sliding analyses S1, S3 and S4 against the paper's numbers.

    PYTHONPATH=tools python examples/guilhofrei_sliding/compare.py OUTPUT [PICTURE.png]

OUTPUT holds the runs s1, s3 and s4. The section is reconstructed, so the paper's numbers are a guide."""

import csv
import math
import os
import sys

import matplotlib
from quoin_tools.results import Results, ResultsError, table

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402
from quoin_tools.plots import LINES, STYLE  # noqa: E402

CREST = 33.0  # m


def references():
    """Rows of reference.csv; paper and hand as numbers or None."""
    with open(os.path.join(os.path.dirname(__file__), "reference.csv"), encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    for row in rows:
        for column in ("paper", "hand"):
            row[column] = float(row[column]) if row[column] else None
    return rows


def load(folder):
    """Last stage of each run."""
    return {run: Results(os.path.join(folder, run)).summary["stages"][-1] for run in ("s1", "s3", "s4")}


def crack(trial):
    """Open length of the whole base joint [m]: the key is its first part."""
    return sum(joint["open_length"] for joint in trial["joints"].values())


def toe(trial):
    """Compression at the toe [MPa]."""
    return -trial["joints"]["base"]["end"]["sigma"] / 1e6


def values(stages):
    s1, s3, s4 = stages["s1"]["strength_reduction"], stages["s3"]["strength_reduction"], stages["s4"]["flood"]
    uplift = s1["trials"][0]["uplift"]["uplift"]
    floods = {round(trial["value"] - CREST): trial for trial in s4["trials"]}
    ours = {
        "uplift_to_drain": uplift["to_drain"] * math.cos(math.atan(0.1)) / 1e3,
        "uplift_beyond_drain": uplift["beyond_drain"] * math.cos(math.atan(0.1)) / 1e3,
        "s1_angle": s1["failing"],
        "s1_factor": s1["safety_factor_stable"],
        "s3_factor": s3["safety_factor_stable"],
        "s3_gain": s3["safety_factor_stable"] / s1["safety_factor_stable"],
        "s4_stable": s4["stable"] - CREST,
    }
    for rise in (2, 5):
        ours[f"s4_crack_{rise}"], ours[f"s4_toe_{rise}"] = crack(floods[rise]), toe(floods[rise])
    return ours


def draw(stages, path):
    with pyplot.rc_context(STYLE):
        figure, (left, right) = pyplot.subplots(1, 2, figsize=(11, 4.6))
        for colour, run, name in ((LINES[0], "s1", "S1, no key"), (LINES[1], "s3", "S3, key")):
            rows = sorted((angle(run, t["value"]), t) for t in stages[run]["strength_reduction"]["trials"]
                          if t["outcome"] == "stable")  # fmt: skip
            left.plot([a for a, _ in rows], [t["probes"]["crest_upstream"]["u_x"] * 1e3 for _, t in rows], "o-",
                      color=colour, label=f"{name}: ours, stable trials")  # fmt: skip
            left.axvline(angle(run, stages[run]["strength_reduction"]["failing"]), color=colour, lw=1)
            paper = math.degrees(math.atan(1 / {"s1": 1.9, "s3": 2.4}[run]))
            left.axvline(paper, color=colour, ls="--", lw=1, label=f"{name}: the paper's failure ({paper:.1f}°)")
        left.invert_xaxis()
        left.set_xlabel("friction angle [degree] (S3: of the reduced strengths)")
        left.set_ylabel("crest $u_x$ [mm]")
        left.set_title("Sliding; solid lines: our first failing trial")
        left.legend(fontsize=8)
        trials = [t for t in stages["s4"]["flood"]["trials"] if t["outcome"] == "stable"]
        rise = [t["value"] - CREST for t in trials]
        right.plot(rise, [crack(t) for t in trials], "o-", color=LINES[0], label="crack [m]: ours")
        right.plot([2, 5, 6], [2.26, 7.41, 9.10], "x", color=LINES[0], label="crack [m]: rigid section, by hand")
        right.axvline(5, color=LINES[3], ls="--", lw=1, label="paper: stable up to +5 m")
        right.set_xlabel("water above the crest [m]")
        right.set_ylabel("crack [m]")
        second = right.twinx()
        second.plot(rise, [toe(t) for t in trials], "s-", color=LINES[1], label="toe [MPa]: ours (peak)")
        second.plot([0, 2, 5, 6], [0.700, 0.825, 1.109, 1.248], "+", color=LINES[1], label="toe [MPa]: by hand")
        second.set_ylabel("compression at the toe [MPa]")
        second.set_ylim(bottom=0)
        handles = [axes.get_legend_handles_labels() for axes in (right, second)]
        right.legend(handles[0][0] + handles[1][0], handles[0][1] + handles[1][1], fontsize=8, loc="upper left")
        right.set_title("Flood S4")
        figure.suptitle("Guilhofrei dam, section G1 (a reconstruction), 15 columns")
        figure.savefig(path)


def angle(run, value):
    """Friction angle of a trial [degree]; S3 goes by factors of 45 degrees' tangent."""
    return value if run == "s1" else math.degrees(math.atan(value))


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    try:
        stages = load(sys.argv[1])
    except ResultsError as error:
        sys.exit(f"compare: {error}")
    ours = values(stages)
    print("Guilhofrei dam, block DE, sliding: the paper, this run, statics of the rigid section")
    print("Section G1 is a reconstruction from the paper's text: see examples/guilhofrei/README.md\n")
    def number(x):
        return "-" if x is None else f"{x:.0f}" if abs(x) >= 100 else f"{x:.2f}"
    cells = [(row["quantity"], row["unit"], number(row["paper"]), number(ours.get(row["key"])), number(row["hand"]))
             for row in references()]  # fmt: skip
    print("\n".join(table(["quantity", "unit", "paper", "ours", "by hand"], cells)))
    draw(stages, sys.argv[2] if len(sys.argv) == 3 else os.path.join(sys.argv[1], "sliding.png"))


if __name__ == "__main__":
    main()
