"""Crest over heel in boxes of rock of three sizes, by what is at their edge: table and OUTPUT/boxes.png.

PYTHONPATH=tools python examples/guilhofrei_earthquake/boxes.py OUTPUT"""

import os
import sys

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402
from quoin_tools.base.files import save_figure  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402

EDGES = {"held": "held all around and shaken", "rollers": "base lets waves out, sides on rollers", "free": "base lets waves out, free ground beside the sides"}
EXTENTS = {"1": "#d55e00", "2": "#009e73", "3": "#0072b2"}  # heights of the dam to each side and down


def crest(folder):
    """Times [s] and displacement of the crest over the heel [mm] since the shaking began."""
    history = Results(folder).history
    rows = history["stage"] == "shake"
    over = 1e3 * (history["crest_upstream_ux_m"] - history["heel_ux_m"])[rows]
    return history["time_s"][rows], over - over[0]


def draw(out):
    figure, panels = pyplot.subplots(3, 1, figsize=(8, 7), sharex=True, layout="constrained")
    for axes, (edge, words) in zip(panels, EDGES.items(), strict=True):
        largest = []
        for extent, colour in EXTENTS.items():
            t, over = crest(os.path.join(out, f"{edge}_{extent}"))
            axes.plot(t, over, color=colour, lw=0.9, label=f"{33 * int(extent)} m of rock")
            largest.append(max(abs(over)))
        print(f"{words}: " + ", ".join(f"{x:.1f}" for x in largest) + " mm")
        axes.set_title(words, fontsize=9, loc="left")
        axes.set_ylabel("crest over heel [mm]")
        axes.grid(alpha=0.3)
    panels[0].legend(fontsize=8, loc="upper left")
    panels[-1].set_xlabel("time [s]")
    save_figure(figure, os.path.join(out, "boxes.png"))


if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    draw(sys.argv[1])
