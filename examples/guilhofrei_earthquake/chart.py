"""Slip of guilhofrei_earthquake over time, beside Newmark's block with its yield coefficient: table and OUTPUT/slip.png.

PYTHONPATH=tools python examples/guilhofrei_earthquake/chart.py OUTPUT"""

import os
import sys

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402
from quoin_tools.assess import newmark  # noqa: E402
from quoin_tools.base import record  # noqa: E402
from quoin_tools.base.files import save_figure  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402

MODELS = {"record": ("base that lets waves out, sides on rollers", "#0072b2"), "free": ("base that lets waves out, free ground beside the sides", "#009e73"),
          "box": ("rock box that is held all around", "#d55e00")}


def slip_of(folder):
    """Times [s] and slip of the heel on its rock [m] since the shaking began."""
    history = Results(folder).history
    rows = history["stage"] == "shake"
    slip = (history["heel_ux_m"] - history["rock_heel_ux_m"])[rows]
    return history["time_s"][rows], slip - slip[0]


def yields(folder):
    """k_h that stands and the least that does not."""
    found = Results(folder).stage_summary("yield")["load_factor"]
    return found["stable"], found["failing"]


def draw(out):
    quake = record.read(os.path.join(out, "quake.csv"))
    stands, fails = yields(os.path.join(out, "yield"))
    block = newmark.slide(quake, newmark.yielding(stands, 1.0))[0]
    figure, (above, below) = pyplot.subplots(2, 1, figsize=(8, 5.5), sharex=True, height_ratios=(1, 2), layout="constrained")
    above.plot(quake.t, quake.a, color="black", lw=0.8)
    above.set_ylabel("record [m/s2]")
    print(f"k_y {stands:.4f} to {fails:.4f}; Newmark's block {1e3 * abs(block.final):.1f} mm")
    for name, (words, colour) in MODELS.items():
        t, slip = slip_of(os.path.join(out, name))
        below.plot(t, 1e3 * slip, color=colour, label=words)
        print(f"{words}: {1e3 * slip[-1]:.0f} mm")
    below.plot(block.t, 1e3 * abs(block.slip), color="black", ls="--", label="Newmark's rigid block")
    below.set(xlabel="time [s]", ylabel="slip of the heel, downstream [mm]")
    below.legend(fontsize=8)
    for axes in (above, below):
        axes.grid(alpha=0.3)
    save_figure(figure, os.path.join(out, "slip.png"))


if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    draw(sys.argv[1])
