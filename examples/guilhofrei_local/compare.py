"""Table and picture of the local failure factors of three scenarios against the paper's numbers.

    PYTHONPATH=tools python examples/guilhofrei_local/compare.py OUTPUT [PICTURE.png]

OUTPUT holds the runs 1, 2 and 3. The section is reconstructed, so the paper's numbers are a guide."""

import csv
import os
import sys

import matplotlib
import numpy as np
from quoin_tools.results import Results, ResultsError, table

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402
from matplotlib.colors import BoundaryNorm  # noqa: E402
from quoin_tools.plots import STYLE  # noqa: E402

STAGE = "swhp"
LEVELS = (1, 1.5, 2, 2.5, 3, 4, 5, 7.5, 10, 15, 20)
MODES = {1: "t", 2: "c", 3: "s"}  # as in Fig. 13; numbers of results.h5


def references():
    """Rows of reference.csv; paper as number or None."""
    with open(os.path.join(os.path.dirname(__file__), "reference.csv"), encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    for row in rows:
        row["paper"] = float(row["paper"]) if row["paper"] else None
    return rows


def compare(folder):
    """Rows of reference.csv with the least factor of the dam: value, mode, x, y, area."""
    found = []
    for row in references():
        results = Results(os.path.join(folder, row["scenario"]))
        found.append(dict(row, results=results, ours=results.stage_summary(STAGE)["safety"]["dam"]))
    return found


def draw(rows, path):
    """Factors of all blocks of the dam, the governing mode, a ring at the least."""
    with pyplot.rc_context(STYLE):
        figure, panels = pyplot.subplots(1, len(rows), figsize=(12, 5.2), sharey=True)
        norm = BoundaryNorm(LEVELS, 256, extend="both")
        for axes, row in zip(panels, rows):
            mesh, factor, mode = row["results"].mesh, *fields(row["results"])
            dam = mesh.block_group == mesh.group_names.index("dam")
            cells = PolyCollection(mesh.rings()[dam], array=factor[dam], cmap="RdYlBu", norm=norm, edgecolors="#8a8a8a",
                                   linewidths=0.2)  # fmt: skip
            axes.add_collection(cells)
            for k in np.flatnonzero(dam):
                if MODES.get(mode[k], "s") != "s":  # shear governs nearly everywhere
                    axes.text(*mesh.centres()[k], MODES[mode[k]], ha="center", va="center", color="white", fontsize=6)
            axes.plot(row["ours"]["x"], row["ours"]["y"], "o", ms=9, mfc="none", mec="black")
            paper = "above 2.5" if row["paper"] is None else f"{row['paper']:g}"
            axes.set_title(f"scenario {row['scenario']}: least {row['ours']['value']:.2f} (ring)\nthe paper: {paper}")
            axes.set_aspect("equal")
            axes.autoscale_view()
            axes.set_xlabel("x [m]")
        panels[0].set_ylabel("y [m]")
        figure.colorbar(cells, ax=panels, label="local failure factor; t, c: tension, compression governs, else shear")
        figure.suptitle("Guilhofrei dam, section G1 (a reconstruction), self-weight and full reservoir")
        figure.savefig(path)


def fields(results):
    """Factor and mode of every block."""
    import h5py

    with h5py.File(results.path) as file:
        group = file["stages"][STAGE]
        return np.array(group["safety_factor"]), np.array(group["safety_mode"])


def main():
    if len(sys.argv) not in (2, 3):
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
    draw(rows, sys.argv[2] if len(sys.argv) == 3 else os.path.join(sys.argv[1], "local.png"))


if __name__ == "__main__":
    main()
