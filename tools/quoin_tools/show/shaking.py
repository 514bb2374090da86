"""Draws a dynamic stage over its time.

time_<joint>_<stage>.png   forces, sliding factor, slip with Newmark's block beside it, opening of a joint
shaking_<stage>.png        the record, what the supports carry, points relative to the ground and absolute
spectrum_<stage>.png       response spectra of the ground and of the highest point, and their ratio
"""

import os
import sys

import numpy as np
from matplotlib import pyplot
from matplotlib.ticker import FixedLocator, NullFormatter

from quoin_tools.assess import spectrum
from quoin_tools.assess.shaken import block_of
from quoin_tools.base import ground, scene, sheet_units
from quoin_tools.base.language import _
from quoin_tools.base.record import RecordError, from_history
from quoin_tools.base.time_series import TimeSeries, dynamic_stages, is_shaken
from quoin_tools.show.export import write
from quoin_tools.show.style import GREY, LINES, plain, save

MOST = 6  # joints, and points, in pictures
TOP = 4.0  # sliding factors are drawn up to here
ROWS = 20  # of history.csv in the shortest period of a spectrum


# ---- facts of a run


class Shaken:
    """The dynamic stages of a run: courses, records, Newmark's block; `missing` says why records are not known."""

    def __init__(self, results, ky=None):
        self.results, self.missing, self.shakings, self.block = results, None, [], None
        self.stages = dynamic_stages(results)
        if not self.stages:
            return
        try:
            self.scene = scene.of_run(results.folder, results.summary)
            self.shakings = ground.of_run(results, self.scene)
            self.block = block_of(results, self.scene, self.shakings, ky)
        except (OSError, RecordError, scene.SceneError) as error:
            self.missing = str(error)

    def series(self, stage):
        return TimeSeries(self.results, stage)

    def is_shaken(self, stage):
        return is_shaken(self.results.stage_summary(stage))

    def block_beside(self, stage, joint):
        """Newmark's block where it belongs to a joint: one of its mechanism, in the first stage that is shaken."""
        shaken = [name for name in self.stages if self.is_shaken(name)]
        if self.block is None or not shaken or stage != shaken[0]:
            return None
        return self.block if not self.block.joints or joint in self.block.joints else None


# ---- panels


def panels(rows, heights):
    figure, axes = pyplot.subplots(rows, 1, figsize=(9.0, 0.6 + 1.45 * sum(heights)), sharex=True, height_ratios=heights, squeeze=False)
    return figure, axes[:, 0]


def dress(figure, axes, title, end):
    for panel in axes:
        panel.grid(alpha=0.3)
        panel.margins(x=0.01)
        if panel.get_legend_handles_labels()[0]:
            panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    axes[0].set_xlim(*end)
    axes[-1].set_xlabel(_("time [s]"))
    figure.suptitle(title)
    figure.align_ylabels(axes)


def draw_records(panel, shakings):
    """The strongest along x and along y."""
    for axis, colour in zip("xy", (LINES[0], LINES[2])):
        mine = ground.strongest(shakings, axis)
        if mine:
            panel.plot(mine.record.t, mine.record.a, color=colour, lw=0.9, label=mine.words)
    panel.axhline(0, color=GREY, lw=0.6)
    panel.set_ylabel(_("record\n[m/s$^2$]"))


def span(time):
    room = 0.01 * np.ptp(time)
    return time[0] - room, time[-1] + room


# ---- pictures


def plot_joint_in_time(shaken, stage, joint, path):
    c = shaken.series(stage).joints[joint]
    time, block = c["time"], shaken.block_beside(stage, joint)
    figure, axes = panels(5, (0.8, 1.2, 1, 1.2, 1.2)) if shaken.shakings else panels(4, (1.2, 1, 1.2, 1.2))
    if shaken.shakings:
        draw_records(axes[0], shaken.shakings)
    forces, factors, slips, openings = axes[-4:]
    line = shaken.results.stage_summary(stage)["joints"][joint]["line"]
    for key, words, colour in (("N", _("N, compression +"), LINES[0]), ("T", _("T, towards the end +") if line else _("T, sum of sizes"), LINES[1])):
        forces.plot(time, c[key] / 1e3, color=colour, lw=0.9, label=words)
    forces.axhline(0, color=GREY, lw=0.6)
    forces.set_ylabel(_("force [kN]"))
    finite = np.isfinite(c["factor_peak"])
    factors.plot(time, np.where(finite, np.minimum(c["factor_peak"], TOP), TOP), color=LINES[0], lw=0.9, label=_("peak strength"))
    if not np.allclose(c["factor_peak"][finite], c["factor_residual"][finite], rtol=1e-6):
        residual = np.where(np.isfinite(c["factor_residual"]), np.minimum(c["factor_residual"], TOP), TOP)
        factors.plot(time, residual, color=LINES[1], lw=0.9, label=_("residual"))
    factors.axhline(1, color="#a81919", lw=0.8, ls="--")
    factors.set_ylim(0, 1.02 * TOP)
    factors.set_ylabel(_("sliding factor at\nthe time, cut at {0:g}", TOP))
    draw_slip(slips, c, block, _("mean over the joint") if line else _("mean size"))
    openings.plot(time, 1e3 * np.maximum(c["opening"], 0), color=LINES[0], lw=0.9, label=_("largest opening [mm]"))
    openings.set_ylabel(_("opening [mm]"))
    lengths = openings.twinx()
    lengths.plot(time, c["open_length"], color=LINES[4], lw=0.9)
    lengths.set_ylabel(_("open length [m]\nof {0}", sheet_units.number(plain(c["length"].max()), "m")), color=LINES[4])
    openings.set_zorder(lengths.get_zorder() + 1)
    openings.patch.set_visible(False)
    dress(figure, axes, _("Stage {0}, joint {1}", stage, joint), span(time))
    openings.get_legend().remove()
    save(figure, path)


def draw_slip(panel, c, block, mean):
    """Slip since the stage began; Newmark's beside it."""
    slip, largest = (1e3 * (c[key] - c[key][0]) for key in ("slip", "slip_largest"))
    panel.plot(c["time"], slip, color=LINES[3], lw=1.3, label=mean)
    panel.plot(c["time"], largest, color=LINES[3], lw=0.8, ls=":", label=_("where it is largest"))
    if block is not None:
        t, newmark = np.append(block.slip.t, max(c["time"][-1], block.slip.t[-1])), np.append(block.slip.slip, block.slip.final)
        panel.plot(t, 1e3 * newmark, color="black", lw=1.1, ls="--", label=_("Newmark's rigid block,\nk_y {0:.4g}", block.stable))
    panel.axhline(0, color=GREY, lw=0.6)
    panel.set_ylabel(_("slip since the\nstage began [mm]"))


def plot_shaking(shaken, stage, path):
    """Draws record, base shear, points; False where nothing of these is known."""
    c = shaken.series(stage)
    shears = {axis: c.shear(axis) for axis in "xy"}
    relative = c.probes and c.probe(c.probes[0], "x", True) is not None
    rows = [name for name, there in (("record", shaken.shakings), ("shear", shears["x"] is not None), ("relative", relative), ("absolute", c.probes)) if there]
    if not rows:
        return False
    figure, axes = panels(len(rows), [0.8 if name == "record" else 1.3 for name in rows])
    for name, panel in zip(rows, axes):
        if name == "record":
            draw_records(panel, shaken.shakings)
        elif name == "shear":
            for axis, colour in zip("xy", (LINES[0], LINES[2])):
                panel.plot(c.time, shears[axis] / 1e3, color=colour, lw=0.9, label=_("along {0}", axis))
            panel.set_ylabel(_("all supports\n[kN]"))
        else:
            draw_probes(panel, c, name == "relative")
    dress(figure, axes, _("Stage {0}: motion", stage), span(c.time))
    save(figure, path)
    return True


def draw_probes(panel, c, relative):
    """u_x of the points that move most; absolute or less the ground."""
    names = sorted(c.probes, key=lambda name: -np.abs(c.probe(name, "x", relative)).max())
    for name in sorted(names[:MOST]):
        panel.plot(c.time, 1e3 * c.probe(name, "x", relative), lw=0.9, color=LINES[sorted(names[:MOST]).index(name)], label=name)
    panel.axhline(0, color=GREY, lw=0.6)
    panel.set_ylabel(_("u_x less that of\nthe ground [mm]") if relative else "u_x [mm]")
    if len(names) > MOST:
        panel.plot([], [], " ", label=_("{0} that move less\nleft out", len(names) - MOST))


# ---- spectra


def spectra_of(shaken, stage, damping=spectrum.DAMPING):
    """Returns (names, spectra) of the ground and of the highest named point, along x, or along y where nothing shakes along x; None: one is not known."""
    shaking = ground.strongest(shaken.shakings, "x") or ground.strongest(shaken.shakings)
    c = shaken.series(stage)
    probes = shaken.results.stage_summary(stage)["probes"]
    names = [name for name in c.probes if name in probes]
    if shaking is None or not names or len(c.time) < ROWS:
        return None
    top = max(names, key=lambda name: (probes[name]["y"], name))
    moved = from_history(even_rows(c.time), c.probe(top, shaking.direction), top)
    shortest = max(0.02, ROWS * float(np.median(np.diff(moved.t))))
    if shortest >= 2.0:
        return None
    periods = spectrum.periods(shortest, 4.0)
    return shaking, top, [spectrum.of(r, periods, damping) for r in (shaking.record, moved)]


def even_rows(time):
    """Returns the times of rows that are equally far apart, but for the first and the last one, free of the rounding of their ten digits; others as they are."""
    inner = np.linspace(time[1], time[-2], len(time) - 2) if len(time) > 3 else time[1:-1]
    even = np.abs(inner - time[1:-1]).max(initial=0.0) <= 1e-9 * time[-1]
    return np.concatenate([time[:1], inner, time[-1:]]) if even else time


def ratio_of(above, below):
    """Returns the ratio of pseudo-accelerations; none where the lower one is 0."""
    return np.divide(above.acceleration, below.acceleration, out=np.full(len(above.period), np.nan), where=below.acceleration > 0)


def period_axis(panel):
    """Sets the ticks of a logarithmic axis of periods [s]."""
    panel.xaxis.set_major_locator(FixedLocator([0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10]))
    panel.xaxis.set_major_formatter(pyplot.FuncFormatter(lambda x, _: f"{x:g}"))
    panel.xaxis.set_minor_formatter(NullFormatter())  # else a short axis has numbers between these, upon them


def draw_ratio(panel, pairs):
    """pairs: (words, colour, spectrum above, spectrum below)."""
    for words, colour, above, below in pairs:
        panel.plot(above.period, ratio_of(above, below), color=colour, lw=1.2, label=words)
    panel.axhline(1, color=GREY, lw=0.8)
    panel.set_ylabel(_("ratio [-]"))
    panel.set_ylim(bottom=0)
    panel.grid(alpha=0.3, which="both")
    panel.legend(fontsize=8)


def plot_spectrum(shaken, stage, path):
    found = spectra_of(shaken, stage)
    if found is None:
        return False
    shaking, top, (below, above) = found
    figure, (panel, ratio) = pyplot.subplots(2, 1, figsize=(7.5, 6.4), sharex=True, height_ratios=(1.6, 1))
    for s, words, colour in ((below, _("record, {0}", shaking.words), "black"), (above, top, LINES[1])):
        panel.plot(s.period, s.acceleration, color=colour, lw=1.3, label=words)
    panel.set_ylabel(_("pseudo-acceleration [m/s$^2$]"))
    panel.set_ylim(bottom=0)
    panel.set_xscale("log")
    panel.set_xlim(below.period[[0, -1]])
    period_axis(panel)
    panel.grid(alpha=0.3, which="both")
    panel.legend()
    draw_ratio(ratio, [(_("{0} over record", top), LINES[1], above, below)])
    ratio.set_xlabel(_("period [s]"))
    figure.suptitle(_("Stage {0}: response spectra along {1}, damping {2:g} %", stage, shaking.direction, 100 * below.damping))
    save(figure, path)
    table = np.array([below.period, below.acceleration, above.acceleration, ratio_of(above, below)]).T
    write(path.removesuffix(".png") + ".csv", ("period [s]", "record S_a [m/s2]", f"{top} S_a [m/s2]", "ratio"), table)
    return True


# ---- all


def plot_stage(shaken, stage):
    """Pictures of a dynamic stage; their paths."""

    def path(name):
        return os.path.join(shaken.results.folder, f"{name}_{stage}.png")

    written = []
    for joint in shaken.series(stage).sliding(MOST):
        written.append(path(f"time_{joint}"))
        plot_joint_in_time(shaken, stage, joint, written[-1])
    if shaken.is_shaken(stage):
        written += [path("shaking")] if plot_shaking(shaken, stage, path("shaking")) else []
        written += [path("spectrum")] if plot_spectrum(shaken, stage, path("spectrum")) else []
    return written


def plot_stages(results, shaken=None):
    shaken = shaken or Shaken(results)
    if shaken.missing:
        print(f"plots: pictures have no record: {shaken.missing}", file=sys.stderr)
    return [path for stage in shaken.stages for path in plot_stage(shaken, stage)]
