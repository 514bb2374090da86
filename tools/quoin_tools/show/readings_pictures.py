"""Pictures of the readings of a sensor: readings with the fit and its band, the parts, residuals with alert bands, the held-out year."""

import os

import numpy as np
import pandas as pd
from matplotlib import pyplot

from quoin_tools.readings import statistics
from quoin_tools.show.style import GREY, LINES, STYLE, save

CAPTIONS = {
    "fit": "Readings, the fit (to those before the dashed line, where there is one), and the band that should hold 95 % of them",
    "parts": "The parts of the fit to all readings, each with its 95 % interval; points: readings without the other parts",
    "residuals": "Residuals with the bands that should hold 95 and 99 % of them; readings beyond 99 % are alerts",
    "held_out": "The held-out year: readings that the fit has not seen",
}
ALERT = LINES[1]


def draw(readings, answer, folder):
    """Writes the pictures of a sensor. Returns {kind: path}."""
    shown = {"fit": fit_picture, "parts": parts_picture, "residuals": residuals_picture} | ({"held_out": held_out_picture} if answer.judged else {})
    found = {}
    with pyplot.rc_context(STYLE):
        for kind, picture in shown.items():
            found[kind] = os.path.join(folder, f"{answer.name}.{kind}.png")
            save(picture(readings, answer), found[kind])
    return found


def label(sensor, what, difference=True):
    return f"{what} [{sensor.unit_of(difference)}]"


def banded(readings, answer):
    """Returns the bands of statistics.bands in the unit of the sensor."""
    sensor, found = readings.sensors[answer.name], statistics.bands(answer)
    whole = {"reading", "fit"}
    return pd.DataFrame({name: sensor.shown(found[name], name not in whole) for name in found}, index=found.index)


def mark_held_out(axes, answer):
    if answer.judged:
        axes.axvline(answer.data.index[answer.held][0], color=GREY, linestyle="--", linewidth=1)


def broken(found):
    """Returns a table with an empty row behind each gap, where lines and bands break."""
    days = np.diff(found.index) / np.timedelta64(1, "D")
    gaps = found.index[:-1][days > 5 * np.median(days)] + pd.Timedelta(seconds=1)
    return pd.concat([found, pd.DataFrame(np.nan, index=gaps, columns=found.columns)]).sort_index()


def fit_picture(readings, answer):
    figure, axes = pyplot.subplots(figsize=(9.5, 4.2))
    sensor, found = readings.sensors[answer.name], banded(readings, answer)
    draw_fit(axes, found)
    unused = readings.data.loc[~readings.used[answer.name] & readings.data[answer.name].notna(), answer.name]
    if len(unused):
        low, high = found["reading"].min(), found["reading"].max()
        axes.plot(unused.index, np.clip(sensor.shown(unused), low, high), "x", color=GREY, markersize=5, label=f"{len(unused)} not used (beyond the axis: at its edge)")
    mark_held_out(axes, answer)
    axes.set_ylabel(label(sensor, answer.name, False))
    axes.set_title(answer.final.choice.words())
    axes.legend(loc="best", ncols=4)
    return figure


def draw_fit(axes, found, size=2.5):
    found = broken(found)
    axes.fill_between(found.index, found["fit"] - found["band 95%"], found["fit"] + found["band 95%"], color=LINES[5], alpha=0.35, linewidth=0, label="95 % of readings")
    axes.plot(found.index, found["reading"], ".", color=GREY, markersize=size, label="readings")
    axes.plot(found.index, found["fit"], color=LINES[0], linewidth=1.2, label="fit")


def parts_picture(readings, answer):
    figure, panels = pyplot.subplots(1, 3, figsize=(13, 4.2), sharey=True)
    sensor, fit, data = readings.sensors[answer.name], answer.final, answer.data
    own, noise = fit.parts(data), data["reading"] - fit.predict(data)[0]
    level = readings.sensors[readings.plan.one("level")]
    heights = np.linspace(fit.low, fit.high, statistics.STEPS)
    draw_part(panels[0], sensor, level.shown(heights), fit.part("water", fit.water(heights)), level.shown(data["level"]), own["water"] + noise)
    panels[0].set_xlabel(label(level, "level", False))
    panels[0].set_title("water")
    start = pd.Timestamp("2001-01-01")
    days = pd.date_range(start, periods=365)
    day = data.index.day_of_year.to_numpy()
    if fit.choice.delays:
        panels[1].plot(day, sensor.shown(own["season"], True), ".", color=LINES[0], markersize=2)
        panels[1].set_title(f"air temperature, delayed by {' and '.join(f'{delay:g}' for delay in fit.choice.delays)} days")
    else:
        draw_part(panels[1], sensor, np.arange(1, 366), fit.part("season", fit.season(days)), day, own["season"] + noise)
        panels[1].set_title("season")
    panels[1].set_xlabel("day of the year [d]")
    dates = pd.date_range(fit.start, fit.end, periods=statistics.STEPS)
    if fit.choice.time != "none":
        draw_part(panels[2], sensor, dates, fit.part("time", fit.time(dates)), data.index, own["time"] + noise)
    panels[2].set_title(f"time: {fit.choice.time}")
    panels[2].tick_params(axis="x", rotation=30)
    panels[0].set_ylabel(label(sensor, f"part of {answer.name}"))
    return figure


def draw_part(axes, sensor, x, part, x_readings, readings):
    """A part with its 95 % interval over x, and the readings without the other parts."""
    value, error = part
    axes.plot(x_readings, sensor.shown(readings, True), ".", color=GREY, markersize=1.5, alpha=0.35)
    axes.fill_between(x, sensor.shown(value - 1.96 * error, True), sensor.shown(value + 1.96 * error, True), color=LINES[5], alpha=0.5, linewidth=0)
    axes.plot(x, sensor.shown(value, True), color=LINES[0], linewidth=1.6)


def residuals_picture(readings, answer):
    figure, axes = pyplot.subplots(figsize=(9.5, 3.8))
    found = broken(banded(readings, answer))
    for share, colour, alpha in (("99%", LINES[4], 0.25), ("95%", LINES[5], 0.45)):
        axes.fill_between(found.index, -found[f"band {share}"], found[f"band {share}"], color=colour, alpha=alpha, linewidth=0, label=f"{share[:-1]} %")
    beyond = found["residual"].abs() > found["band 99%"]
    axes.plot(found.index, found["residual"], ".", color=GREY, markersize=2.5)
    axes.plot(found.index[beyond], found["residual"][beyond], "o", color=ALERT, markersize=4, label=f"{int(beyond.sum())} alerts")
    mark_held_out(axes, answer)
    axes.set_ylabel(label(readings.sensors[answer.name], f"{answer.name}: reading - fit"))
    axes.legend(loc="best", ncols=3)
    return figure


def held_out_picture(readings, answer):
    figure, axes = pyplot.subplots(figsize=(9.5, 4.2))
    sensor, found = readings.sensors[answer.name], banded(readings, answer)[answer.held]
    draw_fit(axes, found, 5)
    judged = statistics.judgement(answer)
    unit = sensor.unit_of(True)
    axes.set_title(f"{judged['readings']} readings: RMSE {float(sensor.shown(judged['rmse'], True)) * sensor.sign:.3g} {unit}, {judged['inside'][0.95]:.1%} inside the 95 % band".replace("%", " %", 1))
    axes.set_ylabel(label(sensor, answer.name, False))
    axes.legend(loc="best", ncols=3)
    return figure
