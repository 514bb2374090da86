"""Table and pictures of the sliding analyses S1 to S4 against the paper's numbers.

    PYTHONPATH=tools python examples/guilhofrei_sliding/compare.py OUTPUT

OUTPUT holds the runs s1, s2, s3, s3_brittle, s4 and, for Fig. 17, s4_2 and s4_5; fig_15.png to fig_18.png go there too. The section is
reconstructed, so the paper's numbers are a guide."""

import math
import os
import sys

from quoin_tools.paper_figures import figure_15, figure_16, figure_17, figure_18, references
from quoin_tools.results import Results, ResultsError, table

CREST = 33.0  # m
HAND = [(0, 0, 0.700), (2, 2.26, 0.825), (5, 7.41, 1.109), (6, 9.10, 1.248)]  # S4 of the rigid section: rise, crack [m], toe [MPa]


def load(folder):
    """Last stage of each run; s2_ground: the state from which the crest moves in S2."""
    runs = {run: Results(os.path.join(folder, run)).summary["stages"] for run in ("s1", "s2", "s3", "s3_brittle", "s4")}
    return {run: stages[-1] for run, stages in runs.items()} | {"s2_ground": runs["s2"][0]}


def crack(trial):
    """Open length of the whole base joint [m]: the key is its first part."""
    return sum(joint["open_length"] for joint in trial["joints"].values())


def toe(trial):
    """Compression at the toe [MPa]."""
    return -trial["joints"]["base"]["end"]["sigma"] / 1e6


def values(stages):
    s1, s3, s4 = stages["s1"]["strength_reduction"], stages["s3"]["strength_reduction"], stages["s4"]["flood"]
    uplift = s1["trials"][0]["uplift"]["uplift"]
    s2, brittle = stages["s2"]["strength_reduction"], stages["s3_brittle"]["strength_reduction"]
    floods = {round(trial["value"] - CREST): trial for trial in s4["trials"]}
    ours = {
        "uplift_to_drain": uplift["to_drain"] * math.cos(math.atan(0.1)) / 1e3,
        "uplift_beyond_drain": uplift["beyond_drain"] * math.cos(math.atan(0.1)) / 1e3,
        "s1_angle": s1["failing"],
        "s1_factor": s1["safety_factor_stable"],
        "s2_angle": s2["failing"],
        "s2_factor": s2["safety_factor_stable"],
        "s3_factor": s3["safety_factor_stable"],
        "s3_brittle": brittle["safety_factor_stable"],
        "s3_gain": s3["safety_factor_stable"] / s1["safety_factor_stable"],
        "s4_stable": s4["stable"] - CREST,
        "s4_failing": None if s4["failing"] is None else s4["failing"] - CREST,
    }
    for name, facts in (("s1", s1), ("s2", s2), ("s3", s3)):
        ours[f"{name}_crest"] = facts["trials"][0]["probes"]["crest_upstream"]["u_x"] * 1e3
    ours["s2_crest"] -= stages["s2_ground"]["probes"]["crest_upstream"]["u_x"] * 1e3
    for rise in (2, 5):
        ours[f"s4_crack_{rise}"], ours[f"s4_toe_{rise}"] = crack(floods[rise]), toe(floods[rise])
    return ours


def draw(folder):
    """Figures 15 to 18."""
    runs = {run: Results(os.path.join(folder, run)) for run in ("s1", "s2", "s3", "s4", "s4_2", "s4_5")}
    figure_15([("S1: base, no key", runs["s1"], "s1", None), ("S2: plane through the rock (assumed)", runs["s2"], "s2", None),
               ("S3: base with a shear key", runs["s3"], "s3", "key")], os.path.join(folder, "fig_15.png"))  # fmt: skip
    figure_16([("S1, no key", runs["s1"], "s1", 1.9), ("S2, rock", runs["s2"], "s2", 2.1), ("S3, key", runs["s3"], "s3", 2.4)],
              os.path.join(folder, "fig_16.png"))  # fmt: skip
    levels = [(0.0, runs["s4"], "swhpu"), (2.0, runs["s4_2"], "s4"), (5.0, runs["s4_5"], "s4")]
    figure_17(levels, (runs["s4"], "s4", CREST), os.path.join(folder, "fig_17.png"), HAND)
    failing = runs["s4"].stage_summary("s4")["flood"]["failing"]
    figure_18([("S1: friction", runs["s1"], "s1"), ("S2: plane through the rock", runs["s2"], "s2"),
               ("S4: nothing fails" if failing is None else f"S4: water {failing - CREST:+g} m", runs["s4"], "s4")],
              os.path.join(folder, "fig_18.png"))  # fmt: skip


def number(x):
    return "-" if x is None else f"{x:.0f}" if abs(x) >= 100 else f"{x:.2f}"


def study(folder):
    """Rows of the study (examples/study.py)."""
    ours = values(load(folder))
    return [(row["quantity"], row["unit"], number(row["paper"]), number(ours.get(row["key"])), f"{number(row['hand'])} (by hand)")
            for row in references(__file__, "paper", "hand")]  # fmt: skip


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    try:
        stages = load(sys.argv[1])
    except ResultsError as error:
        sys.exit(f"compare: {error}")
    ours = values(stages)
    print("Guilhofrei dam, block DE, sliding: the paper, this run, statics of the rigid section")
    print("Section G1 is a reconstruction from the paper's text: see examples/guilhofrei/README.md\n")
    cells = [(row["quantity"], row["unit"], number(row["paper"]), number(ours.get(row["key"])), number(row["hand"]))
             for row in references(__file__, "paper", "hand")]  # fmt: skip
    print("\n".join(table(["quantity", "unit", "paper", "ours", "by hand"], cells)))
    draw(sys.argv[1])


if __name__ == "__main__":
    main()
