"""Makes ten years of readings of a dam whose parameters are known: readings.csv.

    PYTHONPATH=tools python examples/guilhofrei_readings/make_readings.py [OUTPUT.csv]

Level and air daily, instruments weekly. Each weekly state is a run of the block model with the parameters TRUE, at the level and the day of that date; no response
surface has a part in it. Then come what the model does not have (correlated over weeks), a slow creep of the crest, the errors of instruments, and gaps. Two minutes."""

import os
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pandas as pd
import scipy
from quoin_tools.base.files import write_file
from quoin_tools.readings import sensors, surfaces

HERE = os.path.dirname(os.path.abspath(__file__))
SEED = 1938
TRUE = {"E_dam": 9.5e9, "E_rock": 11e9, "k_n": 8e9, "aperture": 0.44e-3, "curtain": 0.32, "drains": 2.2e-6}
WARMEST = 205  # day of the year
CHUNK = 40  # states of a run
FLOOD = ("2022-11-20", 33.0)  # in the last year: a level never seen before
CREEP = {"pendulum.crest": 0.06}  # mm a year
ZERO = {"pendulum.crest": 12.4, "levelling.crest": -3.1, "extensometer.toe": 0.8, "joint.heel": 1.25}  # mm
WITHIN = {  # what the model does not have: standard deviation in the unit of the column, and the days over which it is forgotten
    "pendulum.crest": (0.15, 20), "levelling.crest": (0.15, 20), "extensometer.toe": (0.02, 30), "joint.heel": (0.005, 20),
    "piezometer.P1": (0.10, 30), "piezometer.P2": (0.08, 30), "drain.total": (1.0, 15)}  # fmt: skip


def correlated(random, n, deviation, days, step=1.0):
    """Returns n numbers, `step` days apart, whose correlation is exp(-lag/days)."""
    keep = np.exp(-step / days)
    noise = random.standard_normal(n) * np.r_[1.0, np.full(n - 1, np.sqrt(1 - keep**2))]
    return deviation * scipy.signal.lfilter([1], [1, -keep], noise)


def drivers(random):
    """Returns a frame of level [m] and air [degC] by day."""
    dates = pd.date_range("2013-01-01", "2022-12-31", freq="D")
    year = 2 * np.pi * (dates.day_of_year.to_numpy() / surfaces.YEAR)
    level = np.clip(27.5 + 2.6 * np.cos(year - 2 * np.pi * 0.3) + correlated(random, len(dates), 1.6, 45), 19.5, 31.0)
    flood = (dates - pd.Timestamp(FLOOD[0])).days.to_numpy()
    level = np.maximum(level, np.where(flood < 0, FLOOD[1] + 0.25 * flood, FLOOD[1] - 0.12 * flood))
    air = 14 + 8 * np.cos(year - 2 * np.pi * WARMEST / surfaces.YEAR) + correlated(random, len(dates), 2.5, 4)
    return pd.DataFrame({"level": level, "air": air}, index=dates)


def scores(model, values):
    """Returns the normal scores of values by name; the inverse of Variables.values for variables that do not correlate."""
    return np.array([scipy.stats.norm.ppf(one.shape.cdf(values[one.name])) for one in model.design.variables.each])


def main(output):
    model, plan = surfaces.read(os.path.join(HERE, "model.yaml")), sensors.read(os.path.join(HERE, "readings.yaml"))
    instruments = {name: sensor for name, sensor in plan.sensors.items() if not sensor.drives}
    random = np.random.default_rng(SEED)
    daily = drivers(random)
    weekly = daily.iloc[3::7]
    states = np.column_stack([weekly["level"], (weekly.index.day_of_year.to_numpy() - WARMEST) % surfaces.YEAR])
    table = daily.reindex(columns=["level", "air", *instruments])
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(os.cpu_count()) as pool:
        parts = [states[k : k + CHUNK] for k in range(0, len(states), CHUNK)]
        found = pool.map(lambda k: surfaces.responses(model, instruments, parts[k], scores(model, TRUE), os.path.join(folder, str(k))), range(len(parts)))
        rows = [part.get(j, {}) for part, chunk in zip(found, parts, strict=True) for j in range(len(chunk))]
    for name, sensor in instruments.items():
        exact = sensor.written([row.get(name, np.nan) for row in rows])
        years = (weekly.index - daily.index[0]).days.to_numpy() / surfaces.YEAR
        error = correlated(random, len(weekly), *WITHIN[name], step=7.0) + random.standard_normal(len(weekly)) * float(sensor.shown(sensor.accuracy, True))
        read = exact + ZERO.get(name, 0.0) + CREEP.get(name, 0.0) * years + error
        read[random.random(len(weekly)) < 0.03] = np.nan  # gaps
        table.loc[weekly.index, name] = read.round({"mm": 3, "l/min": 1}.get(sensor.unit, 2))
    table["level"], table["air"] = (table["level"] + plan.sensors["level"].datum + 0.01 * random.standard_normal(len(table))).round(2), table["air"].round(1)
    write_file(output, table.to_csv(index_label="date", lineterminator="\n"))
    print(f"wrote {output}: {len(table)} days, {len(weekly)} weeks; {sum(not row for row in rows)} weeks whose run did not converge")


if __name__ == "__main__":
    if len(sys.argv) > 2 or sys.argv[1:2] and sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    main(sys.argv[1] if len(sys.argv) == 2 else os.path.join(HERE, "readings.csv"))
