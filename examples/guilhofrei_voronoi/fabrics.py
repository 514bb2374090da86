"""What fabrics.sh has found: tables of the least friction and of what explains it, and two figures.

    PYTHONPATH=tools python examples/guilhofrei_voronoi/fabrics.py OUT"""

import os
import sys

import mechanisms
import numpy as np
import scipy
from matplotlib import pyplot
from quoin_tools.base.results import table
from quoin_tools.ensemble import design
from quoin_tools.ensemble.journal import Journal
from quoin_tools.show.style import GREY, LINES, STYLE, save

FACINGS = {"square": "courses of 1 m, square to the face", "level": "courses of 1 m, joints nearly level", "none": "no facing"}
CREST = {"coping_1": "coping of 1 m", "coping_2": "coping of 2 m", "coping_all": "crest of one stone", "bonded": "crest bonded"}
CHANGES = CREST | {"side_1.5": "stones of 1.5 m", "side_3": "stones of 3 m", "even": "even stones", "facing_2": "facing and courses of 2 m"}
PLACES = {"crest": "crest", "body": "from face to face", "facing": "facing alone", "face": "downstream face"}
FABRIC = {"way_crest": "steepest way through the crest", "way": "steepest way through the dam", "piece": "best piece that slides", "across": "stones across the crest", "through": "widest stone at the crest", "side": "mean side"}
MECHANISM = {"moves": "part of the section that moves", "lowest": "lowest point that moves", "dip": "dip of the failing surface", "rough": "its length over its chord"}
PAPER = (18.0, 17.0, 15.0)  # degree, section 4.3: models A, B, C
MOST = 45.0  # degree: friction of the scene; fabrics that do not stand with it count as this
SHARES = (0, 0.1, 0.5, 0.9, 1)


def shares(least):
    """Words for the angles with which these shares of the fabrics stand."""
    return [f"{value:.1f}" if np.isfinite(value) else "-" for value in (least[int(q * (len(least) - 1))] for q in SHARES)]


def column(rows, name):
    values = np.array([getattr(row, name) for row in rows])
    return np.minimum(values, MOST) if name == "least" else values


def explained(least, groups):
    """Part of the variance that the means of groups have."""
    mean = {group: least[groups == group].mean() for group in set(groups)}
    return float(np.var([mean[group] for group in groups]) / np.var(least)) if np.var(least) > 0 else 0.0


def regression(least, measures):
    """R2 of ranks, adjusted for the number of measures."""
    ranks = np.array([scipy.stats.rankdata(values) for values in measures if np.ptp(values) > 0]).T
    n, k = len(least), ranks.shape[1] if ranks.ndim == 2 else 0
    if n < k + 3 or not np.ptp(least) > 0:
        return float("nan")
    y = scipy.stats.rankdata(least)
    columns = np.column_stack([np.ones(n), ranks])
    rest = y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]
    return 1 - (1 - (1 - rest.var() / y.var())) * (n - 1) / (n - k - 1)


def facings_table(found):
    rows = [(words, len(found[name]), *shares(np.sort(column_inf(found[name]))), int(np.isinf(column_inf(found[name])).sum())) for name, words in FACINGS.items() if name in found]
    return table(("least friction [degree]", "fabrics", "least", "10 % stand", "half", "90 %", "most", "not with 45"), rows)


def column_inf(rows):
    return np.array([row.least for row in rows])


def paired(found, name):
    """Least friction of the same fabrics as they are, and changed."""
    bare = {row.sample: row.least for row in found["square"]}
    both = [(bare[row.sample], row.least) for row in found[name] if row.sample in bare]
    return np.minimum(np.array(both).reshape(-1, 2), MOST).T


def changes_table(found):
    rows = []
    for name, words in CHANGES.items():
        if name in found and "square" in found:
            before, after = paired(found, name)
            same = [f"{np.mean(after < before - 0.5):.0%}", f"{np.mean(after > before + 0.5):.0%}"] if name in CREST else ["-", "-"]
            rows.append((words, len(found[name]), *shares(np.sort(column_inf(found[name]))), *same, f"{np.mean(column_of(found[name], 'place') == 'crest'):.0%}"))
    if rows:
        some = [row for row in found["square"] if row.sample in {one.sample for name in CHANGES for one in found.get(name, ())}]
        rows.insert(0, ("as it is", len(some), *shares(np.sort(column_inf(some))), "-", "-", f"{np.mean(column_of(some, 'place') == 'crest'):.0%}"))
    return table(("courses square to the face", "fabrics", "least", "10 % stand", "half", "90 %", "most", "need 0.5 less", "0.5 more", "fail at the crest"), rows)


def column_of(rows, name):
    return np.array([getattr(row, name) for row in rows])


def places_table(found):
    rows = []
    for name in FACINGS | CREST:
        least, places = (column(found[name], "least"), column_of(found[name], "place")) if name in found else (np.zeros(0), np.zeros(0))
        cells = [f"{np.mean(places == key):.0%}, {np.median(least[places == key]):.1f}" if (places == key).any() else "-" for key in PLACES] if len(least) else []
        rows += [((FACINGS | CREST)[name], *cells, f"{explained(least, places):.0%}" if len(set(places)) > 1 else "-")] if cells else []
    return table(("where it fails: share, median [degree]", *PLACES.values(), "explains of the variance"), rows)


def measures_table(found):
    names = [name for name in FACINGS if len(found.get(name, ())) > 3]
    rows = []
    for name, words in (FABRIC | MECHANISM).items():
        rows.append((words, *(f"{correlation(found[facing], name):+.2f}" for facing in names)))
    for words, measures in (("all of the fabric together: R2", FABRIC), ("... and of the mechanism: R2", FABRIC | MECHANISM)):
        rows.append((words, *(f"{regression(column(found[facing], 'least'), [column(found[facing], name) for name in measures]):.2f}" for facing in names)))
    return table(("rank correlation with the least friction", *(FACINGS[name] for name in names)), rows)


def trials_table(folder, found):
    """Trials of the solver beside the bound, fabric by fabric."""
    rows = []
    for name in ("square", "coping_2", "bonded"):
        path = os.path.join(folder, f"trials_{name}.yaml")
        if name in found and os.path.exists(path):
            stable = {row.sample: row.response for row in Journal(os.path.join(folder, f"trials_{name}"), design.read(path)).rows().values() if row.response is not None}
            rows += [((FACINGS | CHANGES)[name], row.seed, row.place, f"{row.least:.2f}", f"{stable[row.sample]:g}", f"{stable[row.sample] - row.least:+.2f}") for row in found[name] if row.sample in stable]
    return table(("fabric", "seed", "fails", "limit analysis", "trials: last that stands", "difference"), rows)


# ---- figure ------------------------------------------------------------------------------------------------

def draw(found, folder):
    """fabrics.png: the distribution by facing; explained.png: by crest, where fabrics fail, what goes with the friction."""
    with pyplot.rc_context(STYLE):
        figure, axes = pyplot.subplots(figsize=(7.2, 4.6))
        curves(axes, {words: found[name] for name, words in FACINGS.items() if name in found}, "Guilhofrei of random polygons without cohesion: limit analysis")
        save(figure, os.path.join(folder, "fabrics.png"))
        figure, axes = pyplot.subplots(1, 3, figsize=(14, 4.6))
        curves(axes[0], {"as it is": found["square"]} | {words: found[name] for name, words in CREST.items() if name in found}, "the crest, courses square to the face")
        axes[0].set_xlim(right=30)  # room for the legend beside the curves
        places(axes[1], found)
        correlations(axes[2], found)
        save(figure, os.path.join(folder, "explained.png"))


def curves(axes, sets, title):
    for colour, (words, rows) in zip(LINES, sets.items()):
        least = np.sort(column_inf(rows))
        axes.step(least, (np.arange(len(least)) + 1) / len(least), color=colour, where="post", label=f"{words} ({len(least)})")
    for k, value in enumerate(PAPER):
        axes.axvline(value, color=GREY, linewidth=1, linestyle="--", label="the paper's models A, B, C" if k == 0 else None)
    axes.set_xlabel("least friction at which the blocks can stand [degree]")
    axes.set_ylabel("part of the fabrics that stand with it [-]")
    axes.set_ylim(0, 1)
    axes.legend(loc="lower right")
    axes.set_title(title)


def places(axes, found):
    """Where fabrics fail beside how much friction they need."""
    for colour, (name, words) in zip(LINES, FACINGS.items()):
        if name in found:
            axes.plot(column(found[name], "least"), column(found[name], "lowest"), ".", color=colour, markersize=5, alpha=0.6, label=words.replace("courses of 1 m, ", ""))
    axes.axhline(mechanisms.BREAK, color=GREY, linewidth=1)
    axes.annotate("change of slope", (MOST, mechanisms.BREAK), ha="right", va="bottom", color=GREY, fontsize=9)
    for value in PAPER:
        axes.axvline(value, color=GREY, linewidth=1, linestyle="--")
    axes.set_xlabel("least friction at which the blocks can stand [degree]")
    axes.set_ylabel("lowest point that moves [m]")
    axes.legend(loc="upper right", bbox_to_anchor=(1, 0.88))
    axes.set_title("where they fail")


def correlations(axes, found):
    """Rank correlations of the two facings whose fabrics scatter."""
    names = {**FABRIC, **MECHANISM}
    for k, facing in enumerate(("square", "none")):
        if len(found.get(facing, ())) > 3:
            values = [correlation(found[facing], name) for name in names]
            axes.barh(np.arange(len(names)) + 0.4 * k, values, height=0.36, color=LINES[list(FACINGS).index(facing)], label=FACINGS[facing])
    axes.set_yticks(np.arange(len(names)) + 0.2, names.values())
    axes.invert_yaxis()
    axes.axvline(0, color=GREY, linewidth=1)
    axes.axhline(len(FABRIC) - 0.3, color=GREY, linewidth=1, linestyle=":")
    axes.set_xlim(-1, 1)
    axes.set_xticks([-1, -0.5, 0, 0.5, 1])
    axes.set_xlabel("rank correlation with the least friction [-]")
    axes.set_title("what explains it: the fabric; how it fails")


def correlation(rows, name):
    values, least = column(rows, name), column(rows, "least")
    return scipy.stats.spearmanr(values, least).statistic if np.ptp(values) > 0 and np.ptp(least) > 0 else 0.0


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    folder = sys.argv[1]
    found = {name: mechanisms.read(os.path.join(folder, f"{name}.csv")) for name in FACINGS | CHANGES}
    found = {name: rows for name, rows in found.items() if rows}
    if "square" not in found:
        sys.exit(f"{folder}: no fabrics: run fabrics.sh")
    for lines in (facings_table(found), changes_table(found), places_table(found), measures_table(found), trials_table(folder, found)):
        print("\n".join(lines), end="\n\n")
    draw(found, folder)


if __name__ == "__main__":
    main()
