"""A hundred dams with known parameters, each with ten years of readings: how often is what is said of them true?

    PYTHONPATH=tools python examples/guilhofrei_readings/repetitions.py OUTPUT [REPETITIONS]
    PYTHONPATH=tools python examples/guilhofrei_readings/repetitions.py OUTPUT beyond [DAMS]

OUTPUT: a folder of quoin readings --model, whose runs are taken (surfaces of its first round, over the whole prior). Each dam has parameters drawn from the prior, its
own levels, weather, zeros, creep and errors. The surfaces stand for the dam, so that their own error has no part in this. Writes OUTPUT/repetitions.csv.

beyond: plain HST beside the hybrid model at the levels of a flood that no reading of the fit has, for the first dams. Writes OUTPUT/beyond.png, of the first one."""

import functools
import os
import sys
import warnings
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pandas as pd
from make_readings import CREEP, HERE, WARMEST, WITHIN, correlated, drivers
from matplotlib import pyplot
from quoin_tools.base.terminal import table
from quoin_tools.readings import drift, posterior, sensors, statistics, surfaces
from quoin_tools.show.style import GREY, LINES, STYLE, save

EVERY = 21  # [day] between readings of an instrument
HELD = 9 * surfaces.YEAR  # from here on the fit sees none
DRIFT = ("curtain", 5 * surfaces.YEAR, 0.5)  # in the second record: from this day its normal score rises by so much a year, its apertures by a fifth
LOOK = 0.25 * surfaces.YEAR  # between two looks for a drift
FINE = 3  # [day] between the readings beside which HST and hybrid stand; every seventh is in the fit
DRAWN = ("pendulum.crest", "joint.heel", "piezometer.P2", "drain.total")


@functools.cache
def setting(folder):
    """Returns (names, instruments, box, surfaces of the first round)."""
    model, plan = surfaces.read(os.path.join(HERE, "model.yaml")), sensors.read(os.path.join(HERE, "readings.yaml"))
    instruments, box = {name: sensor for name, sensor in plan.sensors.items() if not sensor.drives}, surfaces.widest(model)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        made = surfaces.fitted(model, instruments, surfaces.run(model, instruments, box, folder), box)
        return [*model.names, "season.delay"], instruments, surfaces.Box(np.r_[box.centre, 0.0], np.r_[box.half, surfaces.WIDEST]), made


def record(random, instruments, made, names, z, drifts, every=EVERY):
    """Returns (time, state, {instrument: readings [SI]})."""
    daily = drivers(random)
    some = daily.iloc[::every]
    time = np.arange(len(daily))[::every].astype(float)
    state = np.column_stack([np.clip(some["level"], None, 33.4), (some.index.day_of_year.to_numpy() - WARMEST) % surfaces.YEAR])
    scores = np.tile(z, (len(time), 1))
    if drifts:
        scores[:, names.index(DRIFT[0])] += DRIFT[2] * np.maximum(time - DRIFT[1], 0) / surfaces.YEAR
    readings = {}
    for name, surface in made.items():
        sensor = instruments[name]
        unit = 1 / abs(float(sensor.shown(1.0, True)))  # in SI
        creep = CREEP.get(name, 0.0) * unit * time / surfaces.YEAR
        own = (random.normal(0, 0.01) + creep) if sensor.quantity not in posterior.HAS_ZERO else 0.0
        deviation, days = WITHIN[name]
        exact = np.exp(surface.at(state, scores)) if surface.log else surface.at(state, scores)
        readings[name] = exact + own + correlated(random, len(time), deviation * unit, days, every) + sensor.accuracy * random.standard_normal(len(time))
    return time, state, readings


def channels(instruments, made, time, state, readings, kept):
    found: list = []
    for name, surface in made.items():
        exact = surfaces.Surface(**{**surface.__dict__, "error": 0.0})  # the surface is the dam
        found.append(posterior.Channel.of(name, instruments[name].accuracy, time[kept], state[kept], readings[name][kept], exact, instruments[name].quantity not in posterior.HAS_ZERO, found[0] if found else None))
    return found


def extended(found, other):
    """Returns a posterior whose channels are others, of more readings."""
    return posterior.Posterior(found.names, other, found.box, found.normal, found.errors, found.r_hat, found.effective, found.steps)


def looks(found, first, last):
    """Returns (day of the first look at which there is an alarm, or nan; the parameters it names, the likeliest first)."""
    for day in np.arange(first, last + 1, LOOK):
        one = drift.search(drift.until(found, day))
        if one.alarm:
            return day, " ".join(one.named())
    return np.nan, ""


def dam(k, folder):
    """Returns (names, instruments, box, surfaces, random, normal scores drawn from the prior within the box) of dam k."""
    names, instruments, box, made = setting(folder)
    random = np.random.default_rng([1938, k])
    z = random.standard_normal(len(names))
    while not box.holds(z):
        z = random.standard_normal(len(names))
    return names, instruments, box, made, random, z


def one(k, folder):
    names, instruments, box, made, random, z = dam(k, folder)
    time, state, readings = record(random, instruments, made, names, z, False)
    found = posterior.sample(names, channels(instruments, made, time, state, readings, time < HELD), box, k, 300, 1000)
    low, high = np.quantile(found.normal, [0.025, 0.975], axis=0)
    row = {"repetition": k, "effective": found.effective.min(), "r_hat": found.r_hat.max()}
    row |= {f"in:{name}": bool(a < x < b) for name, x, a, b in zip(names, z, low, high)} | {f"ratio:{name}": s for name, s in zip(names, found.normal.std(axis=0))}
    new = time >= HELD
    for i, name in enumerate(made):
        mean, deviation = found.predicted(i, time[new], state[new])
        read = np.log(readings[name][new]) if made[name].log else readings[name][new]
        row[f"held:{name}"] = float((np.abs(read - mean) < 1.959964 * deviation).mean())
    row["false"], row["false_of"] = looks(extended(found, channels(instruments, made, time, state, readings, time < np.inf)), 2 * surfaces.YEAR, time[-1])
    time, state, readings = record(random, instruments, made, names, z, True)
    found = posterior.sample(names, channels(instruments, made, time, state, readings, time < DRIFT[1]), box, k, 50, 500)
    day, row["drift_of"] = looks(extended(found, channels(instruments, made, time, state, readings, time < np.inf)), 2 * surfaces.YEAR, time[-1])
    row["delay"] = (day - DRIFT[1]) / surfaces.YEAR
    return row


def beyond(k, folder):
    """Returns (time of the held-out year, which of its readings stand at levels that no reading of the fit has, {instrument: (readings [SI], {method: (mean, half width of the 95 % band)})})."""
    names, instruments, box, made, random, z = dam(k, folder)
    time, state, readings = record(random, instruments, made, names, z, False, FINE)
    fit, new = (time < HELD) & (np.arange(len(time)) % (EVERY // FINE) == 0), time >= HELD
    found = posterior.sample(names, channels(instruments, made, time, state, readings, fit), box, k, 300, 1000)
    dates, answers = pd.Timestamp("2013-01-01") + pd.to_timedelta(time, unit="D"), {}
    for i, name in enumerate(made):
        data = pd.DataFrame({"level": state[:, 0], "reading": readings[name]}, index=dates)
        plain = statistics.fitted(statistics.Choice(), data[fit])
        usual, wide = plain.predict(data[new])
        mean, deviation = found.predicted(i, time[new], state[new])
        half = 1.959964 * deviation
        if made[name].log:
            mean, half = np.exp(mean), np.exp(mean) * np.sinh(half)  # a band of logarithms, about as wide
        answers[name] = readings[name][new], {"HST": (usual, plain.times(0.95) * wide), "hybrid": (mean, half)}
    return dates[new], state[new, 0] > state[fit, 0].max(), answers


def beyond_of_all(folder, dams):
    """Prints errors and shares in the bands at levels never seen; draws the first dam."""
    rows: dict = {}
    for k in range(dams):
        dates, unseen, answers = beyond(k, folder)
        for name, (read, methods) in answers.items():
            for method, (mean, half) in methods.items():
                error = (read - mean)[unseen]
                rows.setdefault((name, method), []).append((np.sum(error**2), np.sum(np.abs(error) < half[unseen]), unseen.sum()))
        if k == 0:
            beyond_picture(dates, unseen, answers, os.path.join(folder, "beyond.png"))
    plan, lines = sensors.read(os.path.join(HERE, "readings.yaml")), []
    for name in dict.fromkeys(name for name, _method in rows):
        sums = {method: np.sum(rows[name, method], axis=0) for method in ("HST", "hybrid")}
        shown = [(f"{float(plan.sensors[name].shown(np.sqrt(square / n), True)):.3g}", f"{100 * inside / n:.0f} %") for square, inside, n in sums.values()]
        lines.append((name, plan.sensors[name].unit_of(True), *(word for pair in shown for word in pair), int(sums["HST"][2])))
    print("\n".join(table(("instrument", "unit", "HST rms", "in its band", "hybrid rms", "in its band", "readings"), lines)))


def beyond_picture(dates, unseen, answers, path):
    plan, last = sensors.read(os.path.join(HERE, "readings.yaml")), dates > dates[-1] - pd.Timedelta(days=150)
    with pyplot.rc_context(STYLE):
        figure, axes = pyplot.subplots(len(DRAWN), 1, figsize=(8, 2 * len(DRAWN) + 0.6), sharex=True)
        for panel, name in zip(axes, DRAWN, strict=True):
            sensor, (read, methods) = plan.sensors[name], answers[name]
            for (method, (mean, half)), colour in zip(methods.items(), (LINES[1], LINES[0]), strict=True):
                panel.fill_between(dates[last], *(sensor.shown(mean + side * half)[last] for side in (-1, 1)), color=colour, alpha=0.25, linewidth=0)
                panel.plot(dates[last], sensor.shown(mean)[last], color=colour, linewidth=0.9, label=f"{method}, 95 % band")
            panel.plot(dates[last], sensor.shown(read)[last], ".", color="black", markersize=3, label="readings, none in the fit")
            panel.axvspan(dates[unseen].min(), dates[unseen].max(), color=GREY, alpha=0.2, linewidth=0)
            panel.set_title(name, fontsize=9, loc="left")
            panel.set_ylabel(f"[{sensor.unit_of()}]")
        axes[0].legend(loc="best", fontsize=7)
        figure.suptitle("A flood (shaded) higher than all levels of the fit")
        save(figure, path)


def main(folder, repetitions):
    path = os.path.join(folder, "repetitions.csv")
    rows = pd.read_csv(path).to_dict("records") if os.path.exists(path) else []
    todo = sorted(set(range(repetitions)) - {row["repetition"] for row in rows})
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for row in pool.map(one, todo, [folder] * len(todo)):  # begun again it goes on
            rows.append(row)
            pd.DataFrame(rows).to_csv(path, index=False)
    print("\n".join(said(pd.DataFrame(rows))))


def said(frame):
    """Returns the lines of the tables."""
    names = [column.split(":", 1)[1] for column in frame if column.startswith("in:")]
    held = [column for column in frame if column.startswith("held:")]
    lines = table(("parameter", "true value in its 95 % band", "of", "sd / prior, median"), [(name, int(frame[f"in:{name}"].sum()), len(frame), f"{frame[f'ratio:{name}'].median():.2f}") for name in names])
    lines += table(("instrument", "readings of the held-out year in the 95 % band"), [(column[5:], f"{100 * frame[column].mean():.1f} %") for column in held])
    found = frame["delay"].between(0, 1 + 1e-9)
    lines.append(f"all: {100 * np.mean([frame[f'in:{name}'].mean() for name in names]):.1f} % of parameters, {100 * frame[held].mean().mean():.1f} % of held-out readings in their bands")
    named = frame["drift_of"][found].str.split()
    lines.append(f"drift of {DRIFT[0]}: found within a year in {int(found.sum())} of {len(frame)} (median {frame['delay'][found].median():.2f} years); before its start in {int((frame['delay'] < 0).sum())}")
    lines.append(f"... of those {int(found.sum())}, it is among the named in {int(named.map(lambda names: DRIFT[0] in names).sum())}, named first in {int(named.map(lambda names: names[0] == DRIFT[0]).sum())}, alone in {int(named.map(lambda names: names == [DRIFT[0]]).sum())}; named are " + ", ".join(f"{n} in {count}" for n, count in named.map(len).value_counts().sort_index().items()))
    lines.append(f"without drift: {int(frame['false'].notna().sum())} of {len(frame)} records have a false alarm")
    return lines


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3, 4) or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    if sys.argv[2:3] == ["beyond"]:
        sys.exit(beyond_of_all(sys.argv[1], int(sys.argv[3]) if len(sys.argv) == 4 else 5))
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) == 3 else 100)
