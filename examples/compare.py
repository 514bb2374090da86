"""The paper's numbers of section 4 (the Guilhofrei dam) against those of a run: a table in the terminal, and the paper's figures.

    PYTHONPATH=tools python examples/compare.py EXAMPLE OUTPUT

EXAMPLE   guilhofrei          4.1 stresses: OUTPUT is the folder of the run; Fig. 11 and 12
          guilhofrei_local    4.2 local failure factors: OUTPUT holds the runs 1, 2 and 3; Fig. 13
          guilhofrei_voronoi  4.3 friction angles at failure: the runs 1, 2, 3, and one_rank/1 to 3 on one rank; Fig. 14
          guilhofrei_sliding  4.4 sliding and flood: the runs s1, s2, s3, s3_brittle, s4 and, for Fig. 17, s4_2, s4_5; Fig. 15 to 18

The figures go to OUTPUT as fig_NN.png. EXAMPLE/reference.csv says where each number comes from and what it is compared with. The section G1 is
reconstructed, so the paper's numbers are a guide; finite elements and statics used the same section."""

import csv
import math
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import paper_figures
from quoin_tools.base.results import Results, ResultsError, table

HERE = os.path.dirname(os.path.abspath(__file__))
SECTION = "Section G1 is a reconstruction from the paper's text: see examples/guilhofrei/README.md"


@dataclass(frozen=True)
class Example:
    title: str
    note: str
    header: tuple
    rows: Callable  # folder of the run -> rows of reference.csv with our numbers, as dicts
    cells: Callable  # row -> what the terminal shows
    study: Callable  # row -> quantity, unit, the paper's number, ours, the independent one (examples/study.py)
    draw: Callable  # rows, folder: writes the figures


def references(example, *columns):
    """Rows of an example's reference.csv, as dicts; these columns as numbers, None where empty."""
    with open(os.path.join(HERE, example, "reference.csv"), encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return [row | {name: float(row[name]) if row[name] else None for name in columns} for row in rows]


def number(x):
    return "-" if x is None else f"{x:.0f}" if abs(x) >= 100 else f"{x:.2f}"


# ---- 4.1 stresses

MPA = 1e-6


def stress_value(summary, key):
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


def stress_rows(folder):
    """`ours` is the run's number; paper stays as the paper prints it."""
    results = Results(folder)
    return [dict(row, ours=stress_value(results.stage_summary(row["stage"]), row["key"])) for row in references("guilhofrei", "fe")]


def stress_cells(row):
    ours = row["ours"]
    return (row["quantity"], row["stage"], row["unit"], row["paper"] or "-", number(ours), difference(ours, float(row["paper"] or 0)),
            number(row["fe"]), difference(ours, row["fe"]))  # fmt: skip


def difference(ours, other):
    """In percent; nothing where the other is zero or small."""
    return "-" if other is None or abs(other) < 0.01 else f"{100 * (ours / other - 1):+.1f} %"


def stress_study(row):
    return f"{row['stage'].upper()}: {row['quantity']}", row["unit"], row["paper"] or "-", number(row["ours"]), f"{number(row['fe'])} (finite elements)"


def stress_draw(_, folder):
    paper_figures.figure_11(Results(folder), os.path.join(folder, "fig_11.png"))
    paper_figures.figure_12(Results(folder), os.path.join(folder, "fig_12.png"))


# ---- 4.2 local failure

LOCAL_STAGE = "swhp"


def local_rows(folder):
    """`ours` is the least factor of the dam: value, mode, x, y, area."""
    found = []
    for row in references("guilhofrei_local", "paper"):
        results = Results(os.path.join(folder, row["scenario"]))
        found.append(dict(row, results=results, ours=results.stage_summary(LOCAL_STAGE)["safety"]["dam"]))
    return found


def local_paper(row):
    return "above 2.5" if row["paper"] is None else f"{row['paper']:g}"


def local_cells(row):
    ours = row["ours"]
    return (row["scenario"], row["tension_MPa"], row["cohesion_MPa"], row["paper"] or "-", f"{ours['value']:.2f}",
            f"{ours['mode']} at ({ours['x']:.1f}, {ours['y']:.1f})")  # fmt: skip


def local_study(row):
    return f"scenario {row['scenario']}: least local failure factor", "-", local_paper(row), f"{row['ours']['value']:.2f}", ""


def local_draw(rows, folder):
    runs = [(f"scenario {row['scenario']}", row["results"], local_paper(row)) for row in rows]
    paper_figures.figure_13(runs, os.path.join(folder, "fig_13.png"), LOCAL_STAGE)


# ---- 4.3 Voronoi polygons without cohesion

VORONOI_STAGE = "reduction"
MOVING = 0.1  # of the largest velocity of a block: it belongs to the mechanism


def lowest_moving(results):
    """Level [m] of the lowest centre of a block that moves; None where nothing failed."""
    mesh, velocity = results.mesh, results.stage(VORONOI_STAGE).mechanism
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


def voronoi_rows(folder):
    """The last stable and the first failing angle, crest displacement in between, and where it moves."""
    rows = []
    for row in references("guilhofrei_voronoi"):
        results = Results(os.path.join(folder, row["seed"]))
        found = results.stage_summary(VORONOI_STAGE)["strength_reduction"]
        stable = [trial for trial in found["trials"] if trial["outcome"] == "stable"]
        rows.append(dict(row, results=results, stable=found["stable"], failing=found["failing"], lowest=lowest_moving(results),
                         crest=stable[-1]["probes"]["crest_upstream"]["u_x"] if stable else None,
                         same=same_bits(folder, results, row["seed"])))  # fmt: skip
    return rows


def tenths(value, scale=1.0):
    return "-" if value is None else f"{scale * value:.1f}"


def ends(row):
    """Failing angle as text; where nothing fails, a trial stayed undecided or the last angle was reached."""
    return f"{row['failing']:g}" if row["failing"] is not None else "not decided"


def voronoi_cells(row):
    words = {None: "-", True: "yes", False: "NO"}
    return (row["model"], row["paper_degree"], row["seed"], tenths(row["stable"]), ends(row), tenths(row["crest"], 1e3),
            tenths(row["lowest"]), words[row["same"]])  # fmt: skip


def voronoi_study(row):
    return f"seed {row['seed']}: friction angle at failure (the paper: model {row['model']})", "degree", row["paper_degree"], ends(row), ""


def voronoi_draw(rows, folder):
    runs = [(f"seed {row['seed']}: stands at {row['stable']:g}°, fails: {ends(row)}\n(the paper's model {row['model']}: {row['paper_degree']}°)",
             row["results"], VORONOI_STAGE) for row in rows]  # fmt: skip
    paper_figures.figure_14(runs, os.path.join(folder, "fig_14.png"))


# ---- 4.4 sliding and flood

CREST = 33.0  # m
HAND = [(0, 0, 0.700), (2, 2.26, 0.825), (5, 7.41, 1.109), (6, 9.10, 1.248)]  # S4 of the rigid section: rise, crack [m], toe [MPa]


def last_stages(folder):
    """Last stage of each run; s2_ground: the state from which the crest moves in S2."""
    runs = {run: Results(os.path.join(folder, run)).summary["stages"] for run in ("s1", "s2", "s3", "s3_brittle", "s4")}
    return {run: stages[-1] for run, stages in runs.items()} | {"s2_ground": runs["s2"][0]}


def crack(trial):
    """Open length of the whole base joint [m]: the key is its first part."""
    return sum(joint["open_length"] for joint in trial["joints"].values())


def toe(trial):
    """Compression at the toe [MPa]."""
    return -trial["joints"]["base"]["end"]["sigma"] / 1e6


def sliding_values(stages):
    """What the runs give for the keys of reference.csv."""
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


def sliding_rows(folder):
    ours = sliding_values(last_stages(folder))
    return [dict(row, ours=ours.get(row["key"])) for row in references("guilhofrei_sliding", "paper", "hand")]


def sliding_cells(row):
    return row["quantity"], row["unit"], number(row["paper"]), number(row["ours"]), number(row["hand"])


def sliding_study(row):
    return row["quantity"], row["unit"], number(row["paper"]), number(row["ours"]), f"{number(row['hand'])} (by hand)"


def sliding_draw(_, folder):
    runs = {run: Results(os.path.join(folder, run)) for run in ("s1", "s2", "s3", "s4", "s4_2", "s4_5")}
    pictures = [os.path.join(folder, f"fig_{k}.png") for k in (15, 16, 17, 18)]
    paper_figures.figure_15([("S1: base, no key", runs["s1"], "s1", None), ("S2: plane through the rock (assumed)", runs["s2"], "s2", None),
                             ("S3: base with a shear key", runs["s3"], "s3", "key")], pictures[0])  # fmt: skip
    paper_figures.figure_16([("S1, no key", runs["s1"], "s1", 1.9), ("S2, rock", runs["s2"], "s2", 2.1), ("S3, key", runs["s3"], "s3", 2.4)], pictures[1])
    levels = [(0.0, runs["s4"], "swhpu"), (2.0, runs["s4_2"], "s4"), (5.0, runs["s4_5"], "s4")]
    paper_figures.figure_17(levels, (runs["s4"], "s4", CREST), pictures[2], HAND)
    failing = runs["s4"].stage_summary("s4")["flood"]["failing"]
    paper_figures.figure_18([("S1: friction", runs["s1"], "s1"), ("S2: plane through the rock", runs["s2"], "s2"),
                             ("S4: nothing fails" if failing is None else f"S4: water {failing - CREST:+g} m", runs["s4"], "s4")], pictures[3])  # fmt: skip


EXAMPLES = {
    "guilhofrei": Example("Guilhofrei dam, block DE: the paper, this run, independent finite elements (24 columns)", SECTION,
                          ("quantity", "stage", "unit", "paper", "ours", "off paper", "FE", "off FE"), stress_rows, stress_cells, stress_study, stress_draw),
    "guilhofrei_local": Example("Guilhofrei dam, block DE, least local failure factor: the paper, this run", SECTION,
                                ("scenario", "tension MPa", "cohesion MPa", "paper", "ours", "where"), local_rows, local_cells, local_study, local_draw),
    "guilhofrei_voronoi": Example("Guilhofrei dam, block DE, friction angle [degree] at failure without cohesion: the paper, this run",
                                  "Section G1 is a reconstruction, and the polygons are not the paper's: compare the ranges only",
                                  ("model", "paper", "seed", "stable", "fails", "crest u_x mm", "moves above y m", "same bits on 1 rank"),
                                  voronoi_rows, voronoi_cells, voronoi_study, voronoi_draw),
    "guilhofrei_sliding": Example("Guilhofrei dam, block DE, sliding: the paper, this run, statics of the rigid section", SECTION,
                                  ("quantity", "unit", "paper", "ours", "by hand"), sliding_rows, sliding_cells, sliding_study, sliding_draw),
}  # fmt: skip


def main():
    if len(sys.argv) != 3 or sys.argv[1] not in EXAMPLES:
        sys.exit(__doc__)
    example, folder = EXAMPLES[sys.argv[1]], sys.argv[2]
    try:
        rows = example.rows(folder)
    except ResultsError as error:
        sys.exit(f"compare: {error}")
    print(f"{example.title}\n{example.note}\n")
    print("\n".join(table(list(example.header), [example.cells(row) for row in rows])))
    example.draw(rows, folder)
    if any(row.get("same") is False for row in rows):
        sys.exit("compare: one rank and several do not give the same bits")


if __name__ == "__main__":
    main()
