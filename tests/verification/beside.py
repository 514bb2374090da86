"""Writes docs/generated/beside.md, Quoin beside other programs, its chart and pictures from the records of the cases that hold published numbers (driver.py --beside)."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

READ = {"document": "read there", "program": "a program that was evaluated", "quoted": "quoted from a second source", "formula": "method published, numbers computed for this project"}
LINEAR = 1.0  # [%] the chart is linear to this, then logarithmic


def found(records, problems):
    """{problem: its rows, in the order of the table}; a row: quantity, ours, others {name: number}, changed, judged, seconds."""
    rows = {name: [] for name in problems}
    for record in records:
        for check in record["checks"]:
            told = check["published"]
            if told:
                about = problems[told["problem"]]["numbers"][told["quantity"]]
                rows[told["problem"]].append({"quantity": told["quantity"], "ours": told["ours"], "others": about["others"], "changed": about.get("changed", False),
                                              "wrong": about.get("wrong", False), "curves": told["curves"], "seconds": told["processor"], "case": record["case"]})  # fmt: skip
    return {name: told for name, told in rows.items() if told}


def deviations(row):
    """Ours, and the least and largest of the others, off the first of them [%]."""
    values = np.array(list(row["others"].values()), dtype=float)
    off = 100 * (np.array([row["ours"], *values]) / values[0] - 1)
    return off[0], off[1:].min(), off[1:].max()


def own(rows):
    """The rows that count: those of changed models only explain, and where the others are wrong there is nothing to be off from."""
    return [row for row in rows if not row["wrong"] and not row["changed"]]


def percent(value):
    return "0" if value == 0 else f"{value:+.2g} %" if abs(value) < 10 else f"{value:+.0f} %"


def span(rows):
    """Ours of the quantity that is farthest off, and the least and largest of the others over all quantities [%]."""
    ours, low, high = np.array([deviations(row) for row in rows]).T
    return ours[abs(ours).argmax()], low.min(), high.max()


def seconds(rows):
    spent = rows[0]["seconds"]
    return "< 1" if spent < 1 else f"{spent:.0f}"


def cells(*words):
    return "| " + " | ".join(str(word).replace("|", "\\|") for word in words) + " |"


def number(value):
    return f"{value:.5g}"


def page(rows, problems):
    """The page: the table of all problems, then each with its numbers."""
    words = {"document": "were read in the document that is named", "program": "are those of published programs, evaluated", "quoted": "are quoted from a second source",
             "formula": "follow from a published method, computed for this project"}  # fmt: skip
    counts = [(sum(problems[name]["read"] == kind for name in rows), told) for kind, told in words.items()]
    lines = [
        "# Quoin beside other programs", "",
        "Written by `tests/verification/driver.py` (`--beside build/beside`) from `examples/published/problems.yaml` and the runs.", "",
        f"{len(rows)} problems: the numbers of " + ", of ".join(f"{many} {told}" for many, told in counts if many) + ". Deviations are from the first of the others. Of several quantities the worst is shown, and the range of the others over all of them.", "",
        cells("problem", "kind", "others", "quantities", "ours off, worst", "others apart", "processor time [s]", "case"), "|---|---|---|---:|---:|---:|---:|---|",
    ]  # fmt: skip
    for name, told in rows.items():
        about, mine = problems[name], own(told)
        off, low, high = span(mine)
        names = dict.fromkeys(other for row in told for other in row["others"])
        place = about["title"].lower()
        anchor = "".join(c for c in place if c.isalnum() or c in "- _").replace(" ", "-")
        lines.append(cells(f"[{about['title']}](#{anchor})", about["kind"], ", ".join(names), len(mine), percent(off),
                           "" if low == high else f"{percent(low)} to {percent(high)}", seconds(told), told[0]["case"]))
    lines += ["", "![Deviation by problem](../img/beside.png)", "", "Each row runs by one command, `PYTHONPATH=tools python examples/published/problem.py NAME`, unless its case has the model; "
              "a case runs by `python tests/verification/driver.py CASE`. Time is that of all runs of a problem, with its mesh and the runs of changed models.", ""]  # fmt: skip
    for name, told in rows.items():
        about = problems[name]
        lines += [f"## {about['title']}", "", f"{about['source']}: {about['address']} ({READ[about['read']]}).", ""]
        lines += [f"Scene: [{name}.yaml](../../examples/published/{name}.yaml).", ""] if "scene" not in about else [f"Scene: {about['scene']}.", ""]
        names = list(dict.fromkeys(other for row in told for other in row["others"]))
        lines += [cells("quantity", *names, "ours", "off"), "|---|" + "---:|" * (len(names) + 2)]
        for row in told:
            lines.append(cells(row["quantity"] + (" (changed model)" if row["changed"] else ""), *(number(row["others"][n]) if n in row["others"] else "" for n in names),
                               number(row["ours"]), percent(deviations(row)[0])))
        lines += ["", about["why"], ""] if "why" in about else [""]
        lines += [f"![{about['title']}](../img/beside_{name}.png)", ""] if "picture" in about else []
    return "\n".join(lines)


def scaled(value):
    """Linear to LINEAR %, a decade of the same length beyond."""
    value = np.asarray(value, dtype=float)
    return np.where(abs(value) <= LINEAR, value / LINEAR, np.sign(value) * (1 + np.log10(np.maximum(abs(value), LINEAR) / LINEAR)))


def chart(rows, problems, path):
    figure, axis = plt.subplots(figsize=(9, 1.2 + 0.34 * len(rows)))
    for at, told in enumerate(rows.values()):
        mine = own(told)
        offs = np.array([deviations(row)[0] for row in mine])
        _, low, high = span(mine)
        if low < high:
            axis.barh(at, scaled(high) - scaled(low), left=scaled(low), height=0.62, color="#f0c987", label="the others among themselves" if not axis.patches else None, zorder=1)
        axis.plot(scaled(offs), np.full(len(offs), at), "o", color="#1f4e79", markersize=5, alpha=0.75, zorder=3, label="Quoin, a point a quantity" if at == 0 else None)
    axis.axvline(0, color="0.4", linewidth=0.8, zorder=2)
    ticks = np.array([-30, -10, -3, -1, -0.5, 0, 0.5, 1, 3, 10, 30])
    axis.set_xticks(scaled(ticks), [f"{tick:g}" for tick in ticks])
    axis.set_yticks(range(len(rows)), [problems[name]["title"] for name in rows], fontsize=8)
    axis.set_xlim(-2.55, 2.55)
    axis.set_ylim(len(rows) - 0.4, -0.6)
    axis.set_xlabel("off the first of the others [%]; linear to 1 %, then logarithmic")
    axis.grid(axis="x", color="0.9", zorder=0)
    axis.legend(loc="upper center", bbox_to_anchor=(0.3, -0.9 / (0.34 * len(rows) + 1.2)), ncols=2, frameon=False, fontsize=8)
    figure.savefig(path, dpi=130, bbox_inches="tight")
    plt.close(figure)


def picture(about, told, path):
    """Our curves, and the points of the others."""
    figure, axis = plt.subplots(figsize=(7, 3.2))
    for row in told:
        for (name, (x, y)), style in zip(row["curves"].items(), ("-", "--", ":"), strict=False):
            axis.plot(x, y, style, color="#1f4e79", linewidth=1.3, label=f"Quoin, {name}" if name else "Quoin")
    for (name, points), marker in zip(about["picture"]["points"].items(), "os^v", strict=False):
        axis.plot(*np.array(points, dtype=float).T, marker, color="#c0504d", markersize=5, markerfacecolor="none", label=name)
    axis.set_xlabel(about["picture"]["x"])
    axis.set_ylabel(about["picture"]["y"])
    axis.axhline(0, color="0.7", linewidth=0.6)
    axis.legend(frameon=False, fontsize=8)
    figure.savefig(path, dpi=120, bbox_inches="tight")
    plt.close(figure)


def write(records, problems, root):
    rows = found(records, problems)
    for name, told in rows.items():
        if "picture" in problems[name]:
            picture(problems[name], told, root / "docs" / "img" / f"beside_{name}.png")
    (root / "docs" / "generated" / "beside.md").write_text(page(rows, problems), encoding="utf-8")
    chart(rows, problems, root / "docs" / "img" / "beside.png")
