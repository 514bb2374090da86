"""Least friction of fabrics over facings, of the ensembles that fabrics.sh leaves: table and picture.

    PYTHONPATH=tools python examples/guilhofrei_voronoi/fabrics.py OUT"""

import os
import sys

import h5py
import numpy as np
from matplotlib import pyplot
from quoin_tools.base.results import table
from quoin_tools.show.style import GREY, LINES, STYLE, save

FACINGS = {"square": "courses of 1 m, square to the face", "level": "courses of 1 m, joints nearly level", "none": "no facing"}
PAPER = (18.0, 17.0, 15.0)  # degree, section 4.3: models A, B, C


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    folder, rows = sys.argv[1], []
    with pyplot.rc_context(STYLE):
        figure, axes = pyplot.subplots(figsize=(7.2, 4.6))
        for colour, (name, words) in zip(LINES, FACINGS.items()):
            path = os.path.join(folder, name, "samples.h5")
            with h5py.File(path) as file:
                angle = np.sort(file["response"][file["level"][:] != file["level"][:]])  # of no level
            angle = np.where(np.isfinite(angle), angle, np.inf)  # they do not stand with the 45 degrees of the scene
            axes.step(angle, (np.arange(len(angle)) + 1) / len(angle), color=colour, where="post", label=f"{words} ({len(angle)} fabrics)")
            rows.append((words, len(angle), *(f"{angle[int(q * (len(angle) - 1))]:.1f}" for q in (0, 0.1, 0.5, 0.9)), int(np.isinf(angle).sum())))
        for k, value in enumerate(PAPER):
            axes.axvline(value, color=GREY, linewidth=1, linestyle="--", label="the paper's models A, B, C" if k == 0 else None)
        axes.set_xlabel("least friction at which the blocks can stand [degree]")
        axes.set_ylabel("part of the fabrics that stand with it [-]")
        axes.set_ylim(0, 1)
        axes.legend(loc="lower right")
        axes.set_title("Guilhofrei of random polygons without cohesion: limit analysis")
        save(figure, os.path.join(folder, "fabrics.png"))
    print("\n".join(table(("facing", "fabrics", "least", "10 %", "half", "90 %", "not with 45"), rows)))


if __name__ == "__main__":
    main()
