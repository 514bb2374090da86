"""What the readings have said of the parameters of the model: lines for the terminal, pictures."""

import itertools
import os

import numpy as np
import pandas as pd
import scipy
from matplotlib import pyplot

from quoin_tools.base.terminal import table
from quoin_tools.readings import hybrid, posterior
from quoin_tools.readings.surfaces import HELD, WIDEST, YEAR
from quoin_tools.show.style import GREY, LINES, STYLE, legend_below, save


def lines(readings, found):
    """Returns the lines of `quoin readings --model`."""
    said = ["surfaces of the block model, beside runs that no fit has seen:"]
    said += table(("instrument", "error (rms)", "largest", "accuracy", "held-out states"), [surface_row(readings, found, name) for name in found.surfaces])
    said += [f"{found.lost} states did not converge and are left out"] if found.lost else []
    said += table(("parameter", "prior mean", "prior sd", "mean", "sd", "2.5 %", "97.5 %", "sd / prior (scores)", "effective", "R-hat"),
                  [(row["name"], *(f"{row[key]:.4g}" for key in ("prior_mean", "prior_sd", "mean", "sd", "low", "high")), f"{row['ratio']:.2f}", f"{row['effective']:.0f}", f"{row['r_hat']:.3f}") for row in found.rows])  # fmt: skip
    said += [text.format(*values) for text, *values in posterior.identified(found.rows, found.correlation)]
    said += [f"WARNING: {name}: {text}" for name, text in hybrid.warnings(found).items()]
    said += table(("instrument", "model error (sd)", "over [days]", "rate a year", "+- (95 %)", "in the band", "readings", "rms"), [instrument_row(readings, found, k) for k in range(len(found.posterior.channels))])
    return said + drift_lines(found)


def surface_row(readings, found, name):
    surface, sensor = found.surfaces[name], readings.sensors[name]
    error, largest = (hybrid.error_of(surface, readings, name, of) for of in ("error", "largest"))
    return name, f"{float(sensor.shown(error, True)):.3g} {sensor.unit_of(True)}", f"{float(sensor.shown(largest, True)):.3g}", f"{float(sensor.shown(sensor.accuracy, True)):.3g}", surface.n


def instrument_row(readings, found, k):
    name = found.posterior.channels[k].name
    sensor, (size, days), rate, held = readings.sensors[name], hybrid.model_error(readings, found.posterior, k), found.posterior.rate(k), hybrid.coverage(readings, found, name)
    shown = [f"{float(sensor.shown(value, True)):.3g}" for value in (size, *((rate[0], 1.96 * rate[1]) if rate else ()), *((held[2],) if held else ()))]
    rates = shown[1:3] if rate else ["-", "-"]
    return name, f"{shown[0]} {sensor.unit_of(True)}", f"{days:.0f}", *rates, *((f"{100 * held[0]:.1f} %", held[1], shown[-1]) if held else ("-", "-", "-"))


def drift_lines(found):
    one = found.drift

    def date(day):
        return f"{found.start + pd.Timedelta(days=day):%Y-%m}"

    if not one.alarm:
        largest = list(one.probability)[one.gains.max(axis=1).argmax()]
        return [f"drift of a parameter: none is found (nearest: {largest}, chance {one.chance:.2g} without drift)"]
    named = one.named()
    who = f"{one.name} drifts," if len(named) == 1 else f"one of {', '.join(f'{name} ({100 * share:.0f} %)' for name, share in named.items())} drifts; if {one.name},"
    return [f"ALARM: {who} by {one.rate:+.2f} +- {1.96 * one.deviation:.2f} prior deviations a year, from {date(one.start)} (between {date(one.first)} and {date(one.last)}); chance {one.chance:.1g} without drift"]


# ---- pictures ----------------------------------------------------------------------------------------------


def pictures(readings, found, folder):
    """Returns the paths of the pictures."""
    with pyplot.rc_context(STYLE):
        return [corner_picture(found, os.path.join(folder, "posterior.png")), rounds_picture(found, os.path.join(folder, "rounds.png")), drift_picture(found, os.path.join(folder, "drift.png")),
                *(picture(readings, found, os.path.join(folder, f"{name}.png")) for name, picture in (("hybrid", bands_picture), ("surfaces", water_picture), ("checks", checks_picture)))]  # fmt: skip


def panels(names, height=2.2):
    """Returns (figure, {name: panel}) with two panels a row."""
    rows = (len(names) + 1) // 2
    figure, axes = pyplot.subplots(rows, 2, figsize=(8, height * rows + 0.4), squeeze=False)
    for panel in axes.ravel()[len(names) :]:
        panel.set_visible(False)
    for panel, name in zip(axes.ravel(), names):
        panel.set_title(name, fontsize=9, loc="left")
    return figure, dict(zip(names, axes.ravel()))


def rounds_picture(found, path):
    """Prior and posterior of each variable, and the boxes between which the rounds made runs, by normal scores."""
    figure, axes = panels(found.model.names, 2.0)
    z = np.linspace(-WIDEST - 0.4, WIDEST + 0.4, 120)
    for k, panel in enumerate(axes.values()):
        panel.fill_between(z, scipy.stats.norm.pdf(z), color=GREY, alpha=0.4, linewidth=0, label="prior")
        counts, ends = np.histogram(found.posterior.normal[:, k], bins=30)
        panel.stairs(0.5 * counts / counts.max(), ends, fill=True, color=LINES[0], alpha=0.6, label="posterior (its height is no density)")
        for round_, box in enumerate(found.boxes):
            panel.plot(box.centre[k] + np.array([-1, 1]) * box.half[k], np.full(2, -0.08 * (round_ + 1)), color=LINES[1], linewidth=2, label=None if round_ else "runs, round by round")
        panel.set_yticks([])
    for panel in list(axes.values())[-2:]:
        panel.set_xlabel("normal score: prior deviations from its median")
    legend_below(figure, axes[found.model.names[0]].get_legend_handles_labels()[0], 3)
    figure.suptitle("What is not known: prior, runs, posterior")
    save(figure, path)
    return path


def checks_picture(readings, found, path):
    """Surface less run at the states of runs that no fit has seen, with half of the accuracy to each side."""
    held = found.table.run % HELD == 0
    held &= found.boxes[-1].holds(found.table.normal)
    figure, axes = panels(list(found.surfaces))
    for name, panel in axes.items():
        sensor, surface, run = readings.sensors[name], found.surfaces[name], found.table.numbers[name][held]
        made = surface.at(found.table.state[held], found.table.normal[held])
        panel.plot(sensor.shown(run), sensor.shown((np.exp(made) if surface.log else made) - run, True), ".", color=LINES[1] if name in found.refused else LINES[0], markersize=3)
        for side in (-hybrid.SURE, hybrid.SURE):
            panel.axhline(side * float(sensor.shown(sensor.accuracy, True)), color=GREY, linestyle="--", linewidth=1)
        panel.set_title(name + (" (refused)" if name in found.refused else ""), fontsize=9, loc="left")
        panel.locator_params(axis="x", nbins=5)
        panel.set_xlabel(f"run [{sensor.unit_of()}]")
        panel.set_ylabel(f"surface less run [{sensor.unit_of(True)}]")
    figure.suptitle("Surfaces beside runs that no fit has seen; dashed: half of the accuracy, for the rms")
    save(figure, path)
    return path


def drift_picture(found, path):
    """How much better a drift of each parameter would explain the readings, over the day at which it starts."""
    figure, axes = pyplot.subplots(figsize=(8, 3.6))
    dates = found.start + pd.to_timedelta(found.drift.starts, unit="D")
    for name, gains, colour in zip(found.drift.probability, found.drift.gains, itertools.cycle(LINES)):
        axes.plot(dates, gains, color=colour, label=name)
    axes.axhline(found.drift.least(), color=GREY, linestyle="--", label="alarm")
    axes.set_xlabel("start of the drift")
    axes.set_ylabel("gain in chi-square")
    axes.legend(loc="center right", ncols=2, fontsize=7)
    axes.set_title("Does a parameter drift?", fontsize=10)
    save(figure, path)
    return path


def corner_picture(found, path):
    """Samples of the posterior over their prior means, pair by pair; on the diagonal each with the density of its prior."""
    variables, names = found.model.design.variables, found.model.names
    scale = np.array([row["prior_mean"] for row in found.rows[: len(names)]])
    values, before = (np.array(variables.values(normal), dtype=float) / scale for normal in (found.posterior.normal[:, : len(names)], np.random.default_rng(0).standard_normal((20000, len(names)))))
    span = [(one.mean() - 4.5 * one.std(), one.mean() + 4.5 * one.std()) for one in values.T]
    figure, axes = pyplot.subplots(len(names), len(names), figsize=(1.7 * len(names) + 0.6, 1.7 * len(names) + 0.6), squeeze=False)
    for i, j in np.ndindex(axes.shape):
        panel = axes[i, j]
        panel.set_visible(j <= i)
        if j < i:
            panel.plot(values[:, j], values[:, i], ".", color=LINES[0], markersize=1, alpha=0.3, rasterized=True)
            panel.set_ylim(span[i])
        elif j == i:
            panel.hist(values[:, i], bins=30, density=True, color=LINES[0], alpha=0.6)
            at = np.linspace(*span[i], 50)
            panel.plot(at, scipy.stats.gaussian_kde(before[:, i])(at), color=GREY)
            panel.set_title(names[i], fontsize=9)
        panel.set_xlim(span[j])
        panel.tick_params(labelsize=6)
    figure.suptitle("Posterior (blue) over the prior means; grey: density of the prior", fontsize=10)
    save(figure, path)
    return path


def bands_picture(readings, found, path):
    """Readings and the hybrid model with its 95 % band, the last two years; the held-out year shaded."""
    names = [channel.name for channel in found.posterior.channels]
    figure, axes = pyplot.subplots(len(names), 1, figsize=(8, 1.9 * len(names) + 0.6), sharex=True, squeeze=False)
    level = readings.plan.one("level")
    for panel, name in zip(axes[:, 0], names):
        frame, sensor = readings.frame([level, name]), readings.sensors[name]
        frame = frame[frame.index > frame.index[-1] - pd.Timedelta(days=2 * YEAR)]
        low, mean, high = found.predicted(name, frame.index, frame[level])
        low, high = sensor.shown(low), sensor.shown(high)
        panel.fill_between(frame.index, low, high, color=LINES[0], alpha=0.25, linewidth=0, label="95 % band")
        panel.plot(frame.index, sensor.shown(mean), color=LINES[0], linewidth=0.9, label="model and time")
        panel.plot(frame.index, sensor.shown(frame[name]), ".", color="black", markersize=2.5, label="readings")
        if found.held:
            panel.axvspan(pd.Timestamp(found.held, 1, 1), pd.Timestamp(found.held, 12, 31), color=GREY, alpha=0.15, linewidth=0)
        panel.set_title(name, fontsize=9, loc="left")
        panel.set_ylabel(f"[{sensor.unit_of()}]")
    axes[0, 0].legend(loc="best", fontsize=7)
    figure.suptitle("Hybrid model" + (f"; no reading of {found.held} (shaded) is in the fit" if found.held else ""))
    save(figure, path)
    return path


def water_picture(readings, found, path):
    """What each instrument would read over the level, warm and cold, by the posterior: mean and 95 %."""
    names = [channel.name for channel in found.posterior.channels]
    figure, axes = panels(names)
    levels = np.linspace(*found.model.level[1:], 60)
    for name, panel in axes.items():
        sensor, surface = readings.sensors[name], found.surfaces[name]
        for day, colour, season in ((0.0, LINES[1], "warmest day"), (0.5 * YEAR, LINES[0], "coldest day")):
            sampled = surface.states.of(np.column_stack([levels, np.full(60, day)])) @ surface.coefficients(found.posterior.normal[::20]).T
            low, middle, high = sensor.shown(np.quantile(np.exp(sampled) if surface.log else sampled, [0.025, 0.5, 0.975], axis=1))
            panel.fill_between(levels, low, high, color=colour, alpha=0.25, linewidth=0)
            panel.plot(levels, middle, color=colour, linewidth=1, label=season)
        panel.set_ylabel(f"[{sensor.unit_of()}]")
        panel.set_xlabel("level [m]")
    axes[names[0]].legend(loc="best", fontsize=7)
    figure.suptitle("Response of the block model, with its posterior (95 %), without zero and time")
    save(figure, path)
    return path
