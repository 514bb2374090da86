"""Finds what is odd in a column of readings: values in a wrong unit, outliers, jumps of the instrument, one that is stuck, gaps.

Each finding has its line, the value, and what was expected there. Expected is a provisional fit: level, season and a trend by robust regression (Huber),
and the median of the neighbours' residuals. Nothing is taken out here."""

import warnings
from dataclasses import dataclass

import numpy as np
import pandas as pd

from quoin_tools.readings.sensors import ELEVATIONS, QUANTITIES, SEA

YEAR = 365.25  # days
MAD = 1.4826  # standard deviation of a normal distribution over its median deviation
FAR, SOME, CLOSE = 6.0, 4.0, 3.0  # deviations: of an outlier, of each of some readings in a wrong unit, of a reading in its right unit
SPIKE = 10.0  # deviations of a level from the median of five
NEIGHBOURS = 11  # readings of a running median
SIDE = 30  # readings on each side of a jump
NEAR = 5  # lines between a jump as found and as the user has it
JUMP = 5.5  # deviations
GAP = 5.0  # times the usual distance of readings
FEW = 30  # readings: below, no provisional fit
MOST = 0.5  # of a column that is written in a wrong unit as a whole
STUCK = 1e-6  # chance of as many equal readings, below which an instrument is stuck
RUN = 3  # readings in a wrong unit that make a run; others between them may be less clear
PLAUSIBLE = {"air temperature": (-60.0, 60.0), "displacement": (-1.0, 1.0), "joint opening": (-1.0, 1.0)}  # [degC, m]


@dataclass(frozen=True)
class Finding:
    """Something odd in the lines `first` to `last` of a column; count: readings of it. used: whether the statistics use them all the same."""

    kind: str
    sensor: str
    column: str
    first: int
    last: int
    count: int
    value: str
    expected: str
    used: bool = True

    def words(self, file):
        lines = f"line {self.first}" if self.first == self.last else f"lines {self.first} to {self.last}"
        return f"{file}: {lines}, column {self.column}: {self.kind}: {self.value}; expected {self.expected}" + ("" if self.used else f"; {self.count} not used")


def spread(values):
    """The standard deviation [unit of the values] by the median deviation."""
    return MAD * float(np.median(np.abs(values - np.median(values)))) if len(values) else 0.0


def running_median(values, width):
    return pd.Series(values).rolling(width, center=True, min_periods=1).median().to_numpy()


def alternatives(sensor, si):
    """Yields (unit, SI) of readings as if they were written in each other unit of the quantity, and of an elevation above the sea from the datum of the mesh."""
    factor, offset = sensor.scale
    raw = (si - offset) / factor
    for unit, scale in QUANTITIES[sensor.quantity][1].items():
        other, shift = scale if isinstance(scale, tuple) else (scale, 0.0)
        if unit != sensor.unit and (not unit.endswith(SEA) or sensor.unit.endswith(SEA)):
            yield unit, raw * other * sensor.sign / (sensor.width or 1.0) + shift - (sensor.datum if unit.endswith(SEA) else 0.0)


def provisional(dates, values, level):
    """Returns a robust fit to the readings of a response at their dates; level: series of the level, or None."""
    if len(values) < FEW:
        return np.full(len(values), np.median(values))
    import statsmodels.api as sm

    t = (dates - dates[0]) / pd.Timedelta(days=YEAR)
    columns = [np.ones(len(t)), t, np.cos(2 * np.pi * t), np.sin(2 * np.pi * t)]
    if level is not None and len(level):
        at = np.interp(dates.to_numpy().astype("datetime64[s]").astype(float), level.index.to_numpy().astype("datetime64[s]").astype(float), level.to_numpy())
        span = np.ptp(at)
        z = (at - at.mean()) / span if span > 0 else at * 0
        columns += [z, z * z, z**3] if span > 0 else []
    matrix = np.column_stack(columns)
    near = np.abs(values - np.median(values)) <= 20 * max(spread(values[moving(values)]), 1e-300)  # a thousand times too large: no start for a fit
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of convergence: a provisional fit may be rough
        fit = sm.RLM(values[near], matrix[near], M=sm.robust.norms.HuberT()).fit(maxiter=20)
    return matrix @ fit.params


def odd_values(sensor, dates, values, level, heights):
    """Returns (units, outliers, fit): {position: unit} of readings that fit in another unit, positions of outliers, and what was expected at each reading [SI].
    heights: lowest and highest point of the mesh [m], or None."""
    low, high = allowed(sensor, heights)
    outside = (values < low) | (values > high)
    if outside.mean() > MOST:
        for unit, other in alternatives(sensor, values):
            if ((other >= low) & (other <= high)).mean() > 1 - 0.2 * MOST:
                return dict.fromkeys(range(len(values)), unit), [], other
    if sensor.quantity == "level":
        fit, far, close = odd_levels(sensor, dates, values, outside)
        some, clear, local = far, np.ones(len(values), dtype=bool), fit
    else:
        fit = provisional(dates, values, level)
        fit += np.median(values - fit)
        scale = max(spread((values - fit)[moving(values)]), floor_of(sensor, values))
        off, close = np.abs(values - fit), CLOSE * scale
        far, some, clear = (off > FAR * scale) | outside, (off > SOME * scale) | outside, (np.abs(fit) > close) | sensor.drives
    units, nearest = {}, np.full(len(values), np.inf)
    for unit, other in alternatives(sensor, values):
        fits = np.abs(other - fit) < np.minimum(close, nearest)
        for run in runs_of(np.flatnonzero(some & fits & clear & (other >= low) & (other <= high)), NEIGHBOURS):
            inner = np.arange(run[0], run[-1] + 1) if len(run) >= RUN else run[far[run]]
            inner = inner[fits[inner]]
            units |= dict.fromkeys(map(int, inner), unit)
            nearest[inner] = np.abs(other - fit)[inner]
    if sensor.quantity != "level":  # an outlier stands out of its neighbours too, which share what no provisional fit knows
        around = running_median(np.where(far | np.isin(np.arange(len(values)), list(units)), np.nan, values - fit), NEIGHBOURS)
        local = fit + np.where(np.isfinite(around), around, 0.0)
        far = outside | (np.abs(values - local) > FAR * max(spread((values - local)[moving(values)]), floor_of(sensor, values)))
    return units, [int(k) for k in np.flatnonzero(far) if int(k) not in units], local


def level_steps(sensor, dates, values):
    """Returns (scale [m] of the usual change from one level to the next, positions of levels that have changed by far more than is usual, not across a gap)."""
    change, days = np.abs(np.diff(values)), np.diff(dates.to_numpy()) / np.timedelta64(1, "D")
    scale = max(float(np.quantile(change, 0.95)) / 2 if len(values) > 1 else 0.0, floor_of(sensor, values))
    return scale, np.flatnonzero((change > SPIKE * scale) & (days <= GAP * np.median(days))) + 1 if len(values) > 1 else np.zeros(0, dtype=int)


def odd_levels(sensor, dates, values, outside):
    """Returns (what was expected [SI], which levels are odd, how close to it a level in its right unit lies): floods are not odd, single spikes are, and stretches
    after a step that lie far from the longest one, and near it in another unit."""
    fit = running_median(values, 5)
    scale, steps = level_steps(sensor, dates, values)
    parts = np.split(np.arange(len(values)), steps)
    inside = np.arange(len(values)) if outside.all() else np.flatnonzero(~outside)
    low, high = np.quantile(values[inside], [0.02, 0.98])
    room = (high - low) + SPIKE * scale
    bad = outside | (np.abs(values - fit) > SPIKE * scale) | (values < low - room) | (values > high + room)
    longest = np.intersect1d(max(parts, key=lambda part: len(np.intersect1d(part, inside))), inside)
    low, high = np.quantile(values[longest], [0.02, 0.98])
    room = 0.5 * (high - low) + SPIKE * scale
    usual = [low - room <= np.median(values[part]) <= high + room for part in parts]
    for _unit, other in alternatives(sensor, values):
        for part in (part for part, well in zip(parts, usual, strict=True) if not well):
            bad[part] |= low - room <= np.median(other[part]) <= high + room
    around = running_median(np.where(bad, np.nan, values), NEIGHBOURS)
    usual = float(np.median(values if bad.all() else values[~bad]))
    return np.where(np.isfinite(around), around, usual), bad, max(SPIKE * scale, 0.6 * (high - low))


def allowed(sensor, heights):
    """Returns the lowest and highest reading [SI] that can be: as the user expects, or as the mesh and nature have it."""
    if sensor.expected:
        return sorted(float(one) for one in sensor.si(sensor.expected))
    if sensor.quantity == "level" and heights:
        return heights[0], heights[1] + 0.5 * (heights[1] - heights[0])
    return PLAUSIBLE.get(sensor.quantity, (-np.inf, np.inf))


def floor_of(sensor, values):
    """The least scatter [SI] that is taken for real: the accuracy, else a thousandth of the range of the middle 90 %."""
    return sensor.accuracy or max(1e-3 * float(np.ptp(np.quantile(values, [0.05, 0.95]))), 1e-300)


def runs_of(positions, reach=1):
    """Splits ascending positions into runs whose neighbours are at most so far apart."""
    return np.split(positions, np.flatnonzero(np.diff(positions) > reach) + 1) if len(positions) else []


def jumps(sensor, residual):
    """Returns [(position, step [SI])] of lasting steps in residuals: the readings from the position on are shifted. A step stands out of all local steps
    (difference of the means of 30 readings on each side, with a common slope, so that no drift is a step), whatever the autocorrelation is."""
    if len(residual) < 4 * SIDE:
        return []
    k = np.arange(2 * SIDE)
    weights = np.linalg.pinv(np.column_stack([np.ones(2 * SIDE), k, k >= SIDE]))[2]
    steps = np.convolve(residual, weights[::-1], mode="valid")  # of position i + SIDE
    scale = max(spread(steps), 1e-300)
    found, left = [], np.abs(steps)
    while left.max() > max(JUMP * scale, sensor.accuracy or 0.0):
        i = int(left.argmax())
        found.append((i + SIDE, float(steps[i])))
        left[max(0, i - 2 * SIDE) : i + 2 * SIDE] = 0.0
    return sorted(found)


def level_jumps(sensor, dates, values):
    """Returns [(position, step [m])] of levels that have changed by far more than is usual, and stay there: of a gauge that was moved, not of a flood."""
    scale, steps = level_steps(sensor, dates, values)
    lasting = {int(k): abs(np.median(values[k : k + SIDE]) - np.median(values[max(k - SIDE, 0) : k])) for k in steps if min(k, len(values) - k) >= RUN}
    found = [(k, float(values[k] - values[k - 1])) for k in lasting]
    return [(k, step) for k, step in found if lasting[k] > max(SPIKE * scale, 0.5 * abs(step))]


def stuck(values):
    """Returns runs of positions at which an instrument reads what it read before, longer than chance has it for a column with so many equal neighbours. A run at the
    lowest or highest reading is none: a drain is dry, a reservoir is full."""
    same = np.flatnonzero(np.diff(values) == 0) + 1
    inner = same[(values[same] > values.min()) & (values[same] < values.max())]
    found, left = [], len(same)
    for run in sorted(runs_of(inner), key=len, reverse=True):
        left -= len(run)
        if len(run) < RUN or len(values) * (max(left, 1) / len(values)) ** len(run) > STUCK:
            break
        found.append(run)
    return found


def moving(values):
    """Returns which readings differ from the one before, of which the scatter is taken; all, where they are few."""
    found = np.r_[True, np.diff(values) != 0]
    return found if found.sum() >= FEW else np.ones(len(values), dtype=bool)


def gaps(dates):
    """Returns [(position before, days)] of dates that lie far farther apart than usual."""
    days = np.diff(dates) / np.timedelta64(1, "D")
    usual = np.median(days) if len(days) else 0.0
    return [(int(k), float(days[k])) for k in np.flatnonzero(days > GAP * usual)] if usual > 0 else []


def find(sensor, dates, values, lines, level, heights, say):
    """Returns (findings of a column, {position: kind} of readings that are stuck, wrong by unit or outlying). values [SI], without NaN; say(si): a text with its unit."""
    still = stuck(values)
    kinds = {int(k): "stuck" for run in still for k in run}
    rest = np.array([k for k in range(len(values)) if k not in kinds], dtype=int)
    units, outliers, local = odd_values(sensor, dates[rest], values[rest], level, heights)
    units, outliers = {int(rest[k]): unit for k, unit in units.items()}, [int(rest[k]) for k in outliers]
    fit = np.full(len(values), np.nan)
    fit[rest] = local
    kinds |= dict.fromkeys(units, "unit") | dict.fromkeys(outliers, "outlier")
    found = [Finding("stuck", sensor.name, sensor.column, int(lines[run[0]]), int(lines[run[-1]]), len(run), f"{say(values[run[0]])}, as on the line before, {len(run)} times", "readings that change") for run in still]
    found += [finding(sensor, "unit", run, lines, values, say, f"{say(fit[run[0]])}: likely written in {units[int(run[0])]}" + (", or from another datum" if sensor.unit in ELEVATIONS and sensor.quantity != "displacement" else ""))
             for unit in dict.fromkeys(units.values()) for run in runs_of(np.array(sorted(k for k in units if units[k] == unit)))]  # fmt: skip
    found += [finding(sensor, "outlier", run, lines, values, say, say(fit[run[0]])) for run in runs_of(np.array(outliers, dtype=int))]
    kept = np.array([k for k in range(len(values)) if k not in kinds], dtype=int)
    if sensor.quantity == "level" and len(kept):
        for at, step in level_jumps(sensor, dates[kept], values[kept]):
            found.append(Finding("jump", sensor.name, sensor.column, int(lines[kept[at]]), int(lines[kept[at]]), 1, f"all levels from here on lie {say(step, True)} off", "no such step from one level to the next, or another `datum` for them"))
    if not sensor.drives and len(kept):
        for at, step in jumps(sensor, values[kept] - provisional(dates[kept], values[kept], level)):
            if any(abs(int(lines[kept[at]]) - line) <= NEAR for line in sensor.steps):
                continue
            found.append(Finding("jump", sensor.name, sensor.column, int(lines[kept[at]]), int(lines[kept[at]]), 1, f"all readings from here on lie {say(step, True)} off", f"no lasting step, or `steps: [{int(lines[kept[at]])}]` of the sensor"))
    for k, days in gaps(dates.to_numpy()):
        found.append(Finding("gap", sensor.name, sensor.column, int(lines[k]), int(lines[k + 1]), 0, f"no reading for {days:.0f} days from {dates[k]:%Y-%m-%d}", f"one about every {np.median(np.diff(dates.to_numpy()) / np.timedelta64(1, 'D')):.3g} days"))
    return found, kinds


def finding(sensor, kind, run, lines, values, say, expected):
    value = say(values[run[0]]) + (f" and {len(run) - 1} more" if len(run) > 1 else "")
    return Finding(kind, sensor.name, sensor.column, int(lines[run].min()), int(lines[run].max()), len(run), value, expected)
