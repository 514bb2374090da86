"""Reads a table of readings, CSV or XLSX, into SI by date, and tells all that is odd in it.

    readings = read("readings.yaml")
    readings.series("pendulum.crest")              # [m], by date, without what cannot be used
    readings.frame(["level", "pendulum.crest"])    # the dates at which both can be used
"""

import dataclasses
import os
from collections import Counter
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from quoin_tools.base.terminal import doing
from quoin_tools.readings import cells, findings, sensors
from quoin_tools.readings.findings import Finding
from quoin_tools.readings.sensors import Plan, ReadingsError


@dataclass
class Readings:
    """The readings of all sensors. data [SI of each sensor]: float64 by date (UTC where zones are written, else as written; ascending, each date once), a column a
    sensor; NaN where there is none. used: bool of the same shape, False where NaN. lines: the line of the file of each date. left_out: {sensor: {reason: count}}."""

    plan: Plan
    data: pd.DataFrame
    used: pd.DataFrame
    lines: pd.Series
    findings: list = field(default_factory=list)
    left_out: dict = field(default_factory=dict)

    @property
    def sensors(self):
        return self.plan.sensors

    @property
    def file(self):
        return os.path.basename(self.plan.file)

    def series(self, name):
        """Returns the readings [SI] of a sensor that are used, by date, without NaN."""
        return self.data.loc[self.used[name], name]

    def frame(self, names):
        """Returns the readings [SI] of the dates at which all these sensors have a reading that is used."""
        names = list(names)
        return self.data.loc[self.used[names].all(axis=1), names]

    def say(self, name, value, difference=False):
        """Says a value [SI] as the table has it, with its unit."""
        sensor = self.sensors[name]
        return f"{float(sensor.written(value, difference)):.6g} {sensor.unit_of(difference)}"


def read(path):
    """Reads readings.yaml and its table. ReadingsError: one line with file, line or key, value and what was expected."""
    plan = sensors.read(path)
    with doing(f"reads {os.path.basename(plan.file)}"):
        names, rows, epoch = cells.rows_of(plan)
        check_columns(plan, names)
        times, offsets = cells.dates_of(plan, names.index(plan.date_column), rows, epoch)
        lines = np.array([line for line, _ in rows])
        found, counts, columns = [], {name: Counter() for name in plan.sensors}, {}
        if offsets:
            said = " and ".join(f"{one:+g}" for one in offsets)
            found.append(Finding("time zone", "", plan.date_column, int(lines[0]), int(lines[-1]), 0, f"{said} h", "times without zone: they are taken as UTC"))
        texts = [line for line, cells_ in rows if isinstance(cells_[names.index(plan.date_column)], str)]
        if plan.date_format == "day first" and 0 < len(texts) < len(rows) and os.path.splitext(plan.file)[1].lower() in (".xlsx", ".xlsm"):
            found.append(Finding("date", "", plan.date_column, texts[0], texts[-1], len(texts), f"{len(texts)} dates are texts, {len(rows) - len(texts)} are dates of the sheet", "one kind: a program that took some texts for dates may have swapped day and month"))
        for name, sensor in plan.sensors.items():
            raw, odd, empty = cells.column_of(plan, sensor.column, names.index(sensor.column), rows)
            columns[name] = sensor.si(raw)
            counts[name] += Counter({"empty": empty, "no number": len(odd)})
            found += [Finding("no number", name, sensor.column, line, line, 1, f"'{text}'", "a number", False) for line, text in odd]
    return complete(plan, times, lines, columns, found, counts)


def check_columns(plan, names):
    """Refuses columns that no sensor knows, and sensors and dates that no column has."""
    known = [plan.date_column, *(sensor.column for sensor in plan.sensors.values())]
    there = ", ".join(name for name in names if name)
    if plan.date_column not in names:
        raise ReadingsError(f"{plan.file}: line {plan.header}: no column '{plan.date_column}' (dates.column of {plan.path}), there are: {there}")
    for name, sensor in plan.sensors.items():
        if sensor.column not in names:
            raise ReadingsError(f"{plan.file}: line {plan.header}: no column '{sensor.column}' for sensors.{name} of {plan.path}, there are: {there}")
    for name in names:
        if name and name not in known and name not in plan.ignore:
            raise ReadingsError(f"{plan.file}: line {plan.header}: column '{name}': expected a sensor of {plan.path} for it, or its name under `ignore`")


def complete(plan, times, lines, columns, found, counts):
    """Orders the rows by date, takes doubled dates apart, looks for all else. Returns the Readings."""
    order = np.argsort(np.array(times, dtype="datetime64[ns]"), kind="stable")
    back = [k for k in range(1, len(times)) if times[k] < times[k - 1]]
    if back:
        found.append(Finding("order", "", plan.date_column, int(lines[back[0]]), int(lines[back[-1]]), len(back), f"{times[back[0]]} after {times[back[0] - 1]}", "dates that ascend: they are put in order"))
    data = pd.DataFrame(columns, index=pd.DatetimeIndex(np.array(times, dtype="datetime64[ns]"), name="date"), dtype=float).iloc[order]
    lines = lines[order]
    data, lines, doubled = single_dates(plan, data, lines, counts)
    readings = Readings(plan, data, data.notna(), pd.Series(lines, index=data.index), found + doubled, counts)
    for name in plan.sensors:
        check_enough(readings, name)
    drivers = sorted(plan.sensors, key=lambda name: (plan.sensors[name].quantity != "level", not plan.sensors[name].drives))
    level = None  # without the readings that are odd
    for name in drivers:
        with doing(f"looks over {name}"):
            odd = look_over(readings, name, level)
        if plan.sensors[name].quantity == "level":
            level = readings.series(name).drop(odd, errors="ignore")
    readings.findings.sort(key=lambda one: (one.first, one.column))
    for name in plan.sensors:
        check_enough(readings, name)
    return readings


def single_dates(plan, data, lines, counts):
    """Keeps each date once. Equal readings of one date are one reading; of different ones none can be used."""
    found, keep, dates = [], [], data.index
    starts = np.flatnonzero(np.r_[True, dates[1:] != dates[:-1]])
    values = data.to_numpy(copy=True)
    for start, end in zip(starts, np.r_[starts[1:], len(dates)]):
        keep.append(start)
        if end - start == 1:
            continue
        for column, name in enumerate(data.columns):
            here = values[start:end, column]
            there = here[~np.isnan(here)]
            differ = len(there) > 1 and np.ptp(there) > 0
            values[start, column] = np.nan if differ or not len(there) else there[0]
            counts[name]["doubled date"] += len(there) - (0 if differ else 1) if len(there) > 1 else 0
            if len(there) > 1:
                sensor = plan.sensors[name]
                said = " and ".join(f"{float(sensor.written(one)):.6g}" for one in there) + f" {sensor.unit} on {dates[start]}"
                found.append(Finding("doubled date", name, sensor.column, int(lines[start:end].min()), int(lines[start:end].max()), len(there) if differ else len(there) - 1, said, "one reading a date", False))
    return pd.DataFrame(values[keep], index=dates[keep], columns=data.columns), lines[keep], found


def look_over(readings, name, level):
    """Adds what is odd in a column; takes out of use what the user's file wants out. level: series of the level [m], or None. Returns the dates of odd readings."""
    plan, sensor = readings.plan, readings.sensors[name]
    series = readings.series(name)
    lines = readings.lines[series.index].to_numpy()
    found, kinds = findings.find(sensor, series.index, series.to_numpy(), lines, None if sensor.drives else level, plan.heights, lambda value, difference=False: readings.say(name, value, difference))
    readings.findings += [dataclasses.replace(one, used=one.kind not in plan.findings) for one in found]
    out = {k: kind for k, kind in kinds.items() if kind in plan.findings}
    for first, last in plan.exclude.get(name, ()):
        here = np.flatnonzero((lines >= first) & (lines <= last))
        if not len(here):
            raise ReadingsError(f"{plan.path}: exclude: {name}, lines {first} to {last}: no reading there that is used: expected lines of {readings.file}")
        out |= {int(k): out.get(int(k), "by the user") for k in here}
        readings.findings.append(Finding("excluded", name, sensor.column, first, last, len(here), f"{len(here)} readings", f"as {os.path.basename(plan.path)} wants", False))
    readings.left_out[name] += Counter(out.values())
    readings.used.loc[series.index[list(out)], name] = False
    return series.index[list(kinds)]


def check_enough(readings, name):
    """Refuses columns without readings, and those that do not change."""
    plan, series, column = readings.plan, readings.series(name), readings.sensors[name].column
    if not len(series):
        raise ReadingsError(f"{plan.file}: column {column}: no reading that can be used: expected numbers")
    if np.ptp(series.to_numpy()) == 0:
        raise ReadingsError(f"{plan.file}: column {column}: all {len(series)} readings are {readings.say(name, series.iloc[0])}: expected readings that change")
