"""Splits the readings of a sensor into water, season and time by least squares: HST (hydrostatic, season, time) and HTT (hydrostatic, temperature, time).

    answer = analyse(readings, "pendulum.crest")
    answer.final.parts(answer.data)["time"]     # [m], from the first reading

Water is a polynomial of the level (degree 4); season two harmonics of the year, in HTT one or two air temperatures that an exponential kernel delays; time a line, 1 - exp(-t / tau) or
log(1 + t), t in years; `steps` of a sensor are unknowns too. What is not given is chosen by cross-validation by years. Intervals: correlation.py.
"""

import itertools
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
import scipy

from quoin_tools.base.terminal import doing
from quoin_tools.readings import correlation
from quoin_tools.readings.findings import YEAR
from quoin_tools.readings.sensors import ReadingsError

DELAYS = (2, 5, 10, 20, 40, 80)  # [days] of the exponential kernel
TAUS = (0.5, 1.0, 2.0, 5.0)  # [years]
DEGREE = 4
FRESH = 7  # days: an older air temperature is none
DENSE = 3  # days between air temperatures, at most, from which HTT is made
YEARS = 3  # of a record that is cross-validated, after the held-out year
COARSE = 1e8  # condition of the columns, scaled, beyond which the readings do not tell the unknowns apart
CHANCE = 6.0  # about what one coefficient more gains without a reason once in 70 times
DECISIVE = 1 - 1e-7  # leverage of a reading that the fit must go through
BANDS = (0.95, 0.99)
STEPS = 200  # of curves


@dataclass(frozen=True)
class Choice:
    """A form of the fit. tau [years] of an exponential; delays [days] of the air temperatures of HTT."""

    method: str = "HST"
    time: str = "linear"
    tau: float = 0.0
    delays: tuple = ()
    degree: int = DEGREE
    steps: int = 0

    def words(self):
        time = f"{self.time} in time" + (f" (tau {self.tau:g} years)" if self.tau else "") if self.time != "none" else "no time"
        air = f", air delayed by {' and '.join(f'{delay:g}' for delay in self.delays)} days" if self.delays else ""
        steps = f", {self.steps} steps" if self.steps > 1 else ", 1 step" if self.steps else ""
        return f"{self.method}: level to the power {self.degree}{air}, {time}{steps}"

    def unknowns(self):
        return 1 + self.degree + (len(self.delays) or 4) + (self.time != "none") + self.steps


@dataclass
class Fit:
    """Coefficients [SI] of a form, from the readings of `frame`. low, high: the levels [m] it has seen; covariance: of the coefficients; dof: of the intervals."""

    choice: Choice
    start: pd.Timestamp
    end: pd.Timestamp
    low: float
    high: float
    middle: float
    air: np.ndarray
    coefficients: np.ndarray = field(default_factory=lambda: np.zeros(0))
    covariance: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    noise: correlation.Noise | None = None
    dof: float = 1.0

    def water(self, level):
        """Columns of the water: zero at the median level."""
        z, z0 = ((np.asarray(one, dtype=float) - self.low) * 2 / (self.high - self.low) - 1 for one in (level, self.middle))
        return np.column_stack([z**k - z0**k for k in range(1, self.choice.degree + 1)])

    def season(self, dates):
        """Columns of the two harmonics of the year."""
        angle = 2 * np.pi * (pd.DatetimeIndex(dates) - pd.Timestamp("2000-01-01")).total_seconds().to_numpy() / (86400 * YEAR)
        return np.column_stack([np.cos(angle), np.sin(angle), np.cos(2 * angle), np.sin(2 * angle)])

    def time(self, dates):
        """The column of time: zero at the first reading."""
        t = years(dates, self.start)
        kind = self.choice.time
        column = {"none": None, "linear": t, "exponential": -np.expm1(-t / (self.choice.tau or 1.0)), "logarithm": np.log1p(np.maximum(t, 0.0))}[kind]
        return np.zeros((len(t), 0)) if column is None else column[:, None]

    def columns(self, data):
        """Returns {part: (n, k) columns} at the dates of data (level [m], air temperatures delayed [degC])."""
        warmth = data[[f"air {delay}" for delay in self.choice.delays]].to_numpy() - self.air if self.choice.delays else self.season(data.index)
        return {"constant": np.ones((len(data), 1)), "water": self.water(data["level"]), "season": warmth, "time": self.time(data.index), "steps": data[[f"step {k}" for k in range(self.choice.steps)]].to_numpy()}

    def matrix(self, data):
        return np.column_stack(list(self.columns(data).values()))

    def part(self, name, columns):
        """Returns (values, standard errors) [SI] of a part whose columns are given."""
        at = self.places()[name]
        return columns @ self.coefficients[at], np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", columns, self.covariance[at, at], columns), 0.0))

    def places(self):
        """Returns {part: slice of the coefficients}."""
        ends = np.cumsum([1, self.choice.degree, len(self.choice.delays) or 4, self.choice.time != "none", self.choice.steps])
        return {name: slice(int(begin), int(end)) for name, begin, end in zip(("constant", "water", "season", "time", "steps"), (0, *ends[:-1]), ends)}

    def parts(self, data):
        """Returns the parts [SI] at the dates of data, a column each; their sum is the fit."""
        return pd.DataFrame({name: self.part(name, columns)[0] for name, columns in self.columns(data).items()}, index=data.index)

    def predict(self, data):
        """Returns (fit, standard deviation of a reading round it) [SI]: of the noise and of the coefficients."""
        matrix = self.matrix(data)
        return matrix @ self.coefficients, np.sqrt(self.noise.deviation**2 + np.einsum("ij,jk,ik->i", matrix, self.covariance, matrix))

    def times(self, share):
        """Returns how many standard deviations an interval with this share has to each side."""
        return float(scipy.stats.t.ppf(0.5 + share / 2, self.dof))


@dataclass
class Answer:
    """The statistics of a sensor. data: level, air temperatures delayed, and `reading` by date, those used; judged: the fit without the held-out year, else None;
    final: the fit to all; scores: {Choice: error of cross-validation [SI]}; left_out: {reason: count}; notes: what could not be done."""

    name: str
    data: pd.DataFrame
    final: Fit
    judged: Fit | None
    held: np.ndarray
    scores: dict
    left_out: dict
    notes: list


def years(dates, start):
    return (pd.DatetimeIndex(dates) - start).total_seconds().to_numpy() / (86400 * YEAR)


# ---- the data --------------------------------------------------------------------------------------------------

def delayed(air, days):
    """Returns the mean [degC] of the air temperatures before each date, weighted by exp(-age / days)."""
    return air.ewm(halflife=pd.Timedelta(days=days * np.log(2)), times=air.index).mean()


def data_of(readings, name, delays):
    """Returns (readings of a sensor that are used, with level and delayed air temperatures at their dates, {reason: count} of others that have none)."""
    level, air, series = readings.plan.one("level"), readings.plan.one("air temperature"), readings.series(name)
    data = pd.DataFrame({"reading": series, "level": readings.series(level).reindex(series.index)})
    left_out = {"no level": int(data["level"].isna().sum())}
    data = data.dropna()
    for k, line in enumerate(readings.sensors[name].steps):
        data[f"step {k}"] = (readings.lines[data.index] >= line).astype(float)
        if data[f"step {k}"].nunique() < 2:
            raise ReadingsError(f"{readings.plan.path}: sensors.{name}.steps: {line}: expected a line with readings of the sensor before and behind it")
    if delays:
        temperature = readings.series(air)
        for delay in delays:
            data[f"air {delay}"] = delayed(temperature, delay).reindex(data.index, method="ffill", tolerance=pd.Timedelta(days=FRESH))
        early = data.index < temperature.index[0] + pd.Timedelta(days=max(delays))
        data.loc[early, f"air {delays[0]}"] = np.nan
        left_out["no air temperature before it"] = int(data.isna().any(axis=1).sum())
        data = data.dropna()
    return data, {reason: count for reason, count in left_out.items() if count}


def blocks_of(dates):
    """Returns the number of the year of each date, counted back from the last one."""
    return np.floor(years(dates[-1:].repeat(len(dates)), dates[-1]) - years(dates, dates[-1])).astype(int)


# ---- the fit ---------------------------------------------------------------------------------------------------

def prepared(choice, data):
    """Returns a Fit of this form without coefficients."""
    level = data["level"].to_numpy()
    air = data[[f"air {delay}" for delay in choice.delays]].to_numpy().mean(axis=0) if choice.delays else np.zeros(0)
    return Fit(choice, data.index[0], data.index[-1], float(level.min()), float(level.max()), float(np.median(level)), air)


def fitted(choice, data):
    """Returns the Fit of a form to the readings of data by ordinary least squares, with its covariance."""
    import statsmodels.api as sm

    fit = prepared(choice, data)
    found = sm.OLS(data["reading"].to_numpy(), fit.matrix(data)).fit()
    fit.coefficients = found.params
    fit.covariance, fit.noise = correlation.covariance(found.model.exog, found.resid, years(data.index, data.index[0]) * YEAR)
    fit.dof = min(max(fit.noise.effective - choice.unknowns(), 4.0), len(data) - choice.unknowns())
    return fit


def check(readings, name, choice, data):
    """Refuses readings that are too few for the unknowns, or do not tell them apart."""
    where = f"{readings.plan.file}: column {readings.sensors[name].column}"
    if len(data) <= choice.unknowns():
        raise ReadingsError(f"{where}: {len(data)} readings with a level: expected more than {choice.unknowns()}, the unknowns of {choice.words()}")
    length = years(data.index[-1:], data.index[0])[0]
    if length < 0.95:
        raise ReadingsError(f"{where}: its {len(data)} readings span {length:.2g} years: expected one at least, to tell the season")
    level = readings.plan.one("level")
    if np.ptp(data["level"].to_numpy()) == 0:
        raise ReadingsError(f"{where}: the level is {readings.say(level, data['level'].iloc[0])} at all its {len(data)} readings: expected levels that change")
    matrix = prepared(choice, data).matrix(data)
    matrix = matrix / np.linalg.norm(matrix, axis=0).clip(1e-300)
    if not np.linalg.cond(matrix) < COARSE:
        raise ReadingsError(f"{where}: its {len(data)} readings do not tell the {choice.unknowns()} unknowns apart: {length:.2g} years, "
                            f"{data['level'].nunique()} different levels: expected a longer record, more levels, or a smaller statistics.degree")  # fmt: skip
    leverage = np.einsum("ij,ij->i", *2 * (np.linalg.qr(matrix)[0],))
    if leverage.max() > DECISIVE:
        line = readings.lines[data.index[int(leverage.argmax())]]
        raise ReadingsError(f"{where}: line {line}: this reading alone settles an unknown of {choice.words()}: expected more readings like it, or it under `exclude`")


# ---- the choice ------------------------------------------------------------------------------------------------

def errors_of(choice, data, blocks):
    """Returns the squared errors [SI^2] of each year, predicted from the others. Steps are those of the fit to all: the others may have nothing behind a step."""
    fit, y = prepared(choice, data), data["reading"].to_numpy()
    matrix, at = fit.matrix(data), fit.places()["steps"]
    if choice.steps:
        y = y - matrix[:, at] @ np.linalg.lstsq(matrix, y, rcond=None)[0][at]
        matrix = np.delete(matrix, at, axis=1)
    found = []
    for block in np.unique(blocks):
        out = blocks == block
        coefficients = np.linalg.lstsq(matrix[~out], y[~out], rcond=None)[0]
        found.append(float(np.mean((y[out] - matrix[out] @ coefficients) ** 2)))
    return np.array(found)


def chosen(choices, data, blocks, scores):
    """Returns the form with the least error of cross-validation, but the first one, the simplest, unless another is better by more than chance: the logarithm of the ratio of
    the squared errors, times the independent readings, is above CHANCE. Adds to scores."""
    errors = {choice: float(errors_of(choice, data, blocks).mean()) for choice in choices}
    scores |= {choice: found**0.5 for choice, found in errors.items()}
    best = min(errors, key=lambda choice: errors[choice])
    if best == choices[0] or errors[best] == 0:
        return best
    gain = fitted(choices[0], data).noise.effective * np.log(errors[choices[0]] / errors[best])
    return best if gain > CHANCE else choices[0]


def times_of(wanted, length):
    """Returns (kind, tau) of the forms of time that are tried, the simplest first. length [years]."""
    kinds = ("linear", "exponential", "logarithm") if wanted == "auto" else (wanted,)
    taus = [tau for tau in TAUS if tau <= length / 2] or TAUS[:1]
    return [(kind, tau) for kind in kinds for tau in (taus if kind == "exponential" else (0.0,))]


def choose(readings, name, data, common, options):
    """Returns (the form, {form: error of cross-validation [SI]}, notes). data: the readings for HST; common: those that HTT can use too, or None."""
    method, time, degree = options.get("method", "auto"), options.get("time", "auto"), options.get("degree", DEGREE)
    steps = len(readings.sensors[name].steps)
    base = common if method == "HTT" else data
    blocks = blocks_of(base.index)
    length = years(base.index[-1:], base.index[0])[0]
    times = times_of(time, length)
    if len(np.unique(blocks)) < YEARS:
        if method == "HTT":
            raise ReadingsError(f"{readings.plan.file}: column {readings.sensors[name].column}: {length:.2g} years with air temperatures, without the held-out year: expected {YEARS} or more to choose the delays of HTT by cross-validation")
        return Choice("HST", times[0][0], times[0][1], (), degree, steps), {}, [f"{length:.2g} years: too short to cross-validate by years, {times[0][0]} time is taken"]
    scores = {}
    if method == "HST" or common is None:
        return chosen([Choice("HST", kind, tau, (), degree, steps) for kind, tau in times], data, blocks, scores), scores, []
    shared, blocks = common, blocks_of(common.index)
    delays = [(delay,) for delay in DELAYS]
    single = min((Choice("HTT", *times[0], one, degree, steps) for one in delays), key=lambda choice: errors_of(choice, shared, blocks).mean())
    warm = chosen([single, *(Choice("HTT", *times[0], pair, degree, steps) for pair in itertools.combinations(DELAYS, 2))], shared, blocks, scores)
    seasonal = [] if method == "HTT" else [Choice("HST", *times[0], (), degree, steps)]
    best = chosen([*seasonal, warm], shared, blocks, scores)
    return chosen([Choice(best.method, kind, tau, best.delays, degree, steps) for kind, tau in times], shared, blocks, scores), scores, []


# ---- the whole -------------------------------------------------------------------------------------------------

def analyse(readings, name):
    """Returns the Answer of a sensor. ReadingsError where there is no level, or too few readings."""
    options, notes = readings.plan.statistics, []
    if readings.plan.one("level") is None:
        raise ReadingsError(f"{readings.plan.path}: sensors: none of quantity level: expected one, on which the statistics depend")
    air = readings.plan.one("air temperature")
    if options.get("method") == "HTT" and air is None:
        raise ReadingsError(f"{readings.plan.path}: statistics.method: HTT: expected a sensor of quantity air temperature")
    data, left_out = data_of(readings, name, ())
    simple = Choice("HST", "linear" if options.get("time", "auto") == "auto" else options["time"], 1.0 if options.get("time") == "exponential" else 0.0, (), options.get("degree", DEGREE), len(readings.sensors[name].steps))
    check(readings, name, simple, data)
    common, dense = None, air and np.median(np.diff(readings.series(air).index) / np.timedelta64(1, "D")) <= DENSE
    if air and options.get("method") != "HST":
        if dense:
            common, missing = data_of(readings, name, DELAYS)
            common = common if len(common) > simple.unknowns() else None
        if common is None:
            notes.append(f"no HTT: air temperatures are more than {DENSE} days apart, or none lie {max(DELAYS)} days before readings")
        if common is None and options.get("method") == "HTT":
            raise ReadingsError(f"{readings.plan.file}: column {readings.sensors[air].column}: {notes[-1]}: expected daily ones for statistics.method HTT")
    held = held_out(data.index, options.get("held_out"), readings)
    learnt = data[~held] if len(data[~held]) > 2 * simple.unknowns() and years(data.index[~held][-1:], data.index[0])[0] >= 1 else data
    stepped = any(data.loc[~held, f"step {k}"].nunique() < 2 for k in range(simple.steps))
    if len(learnt) == len(data) or stepped:
        notes.append("no year is held out: " + ("the instrument steps in it" if stepped else "too few readings before it"))
        learnt = data
        held = np.zeros(len(data), dtype=bool)
    with doing(f"chooses the form for {name}"):
        choice, scores, more = choose(readings, name, learnt, None if common is None else common[common.index.isin(learnt.index)], options)
    if choice.delays:
        held = held[data.index.isin(common.index)]
        data, left_out = common, missing
    for part in (data, data[~held]):
        check(readings, name, choice, part)
    with doing(f"fits {name}"):
        return Answer(name, data, fitted(choice, data), fitted(choice, data[~held]) if held.any() else None, held, scores, left_out, notes + more)


def held_out(dates, year, readings):
    """Returns which dates are held out: those of a year, else the last twelve months."""
    held = dates.year == year if year else dates > dates[-1] - pd.Timedelta(days=YEAR)
    if year and (not held.any() or held.all()):
        raise ReadingsError(f"{readings.plan.path}: statistics.held_out: {year}: expected a year of the record with readings in others, {dates[0].year} to {dates[-1].year}")
    if year and held.any() and (dates[~held] > dates[held][0]).any():
        raise ReadingsError(f"{readings.plan.path}: statistics.held_out: {year}: expected the last year of the record, {dates[-1].year}")
    return np.asarray(held)


def drift(answer):
    """Returns what time alone has done [SI]: (value, low, high) of the change from the first to the last reading, and of the rate at its end per year, 95 %; None without a time."""
    fit = answer.final
    if fit.choice.time == "none":
        return None
    ends = fit.time([fit.start, fit.end])
    slope = (fit.time([fit.end]) - fit.time([fit.end - pd.Timedelta(days=1)])) * YEAR
    found = []
    for column in (ends[1:] - ends[:1], slope):
        value, error = (float(one[0]) for one in fit.part("time", column))
        wide = fit.times(0.95) * error
        found.append((value, value - wide, value + wide))
    return tuple(found)


def explained(answer):
    """Returns the share of the variance of the readings that the fit to all of them takes (R2)."""
    y = answer.data["reading"].to_numpy()
    error = y - answer.final.predict(answer.data)[0]
    return float(1 - error @ error / max(((y - y.mean()) ** 2).sum(), 1e-300))


def judgement(answer):
    """Returns of the held-out year: number of readings, RMSE and mean error [SI], shares inside the bands, number at levels that the fit has not seen; None without one."""
    if answer.judged is None:
        return None
    out = answer.data[answer.held]
    fit, deviation = answer.judged.predict(out)
    error = out["reading"].to_numpy() - fit
    inside = {share: float(np.mean(np.abs(error) <= answer.judged.times(share) * deviation)) for share in BANDS}
    unseen = (out["level"] < answer.judged.low) | (out["level"] > answer.judged.high)
    return {"readings": len(out), "rmse": float(np.sqrt(np.mean(error**2))), "mean": float(error.mean()), "inside": inside, "unseen": int(unseen.sum())}


def bands(answer):
    """Returns by date: fit, its parts, residual and the deviations to each side of the bands of 95 and 99 % [SI]; of the held-out year as predicted."""
    fit = answer.judged or answer.final
    value, deviation = fit.predict(answer.data)
    found = pd.DataFrame({"reading": answer.data["reading"], "fit": value, "residual": answer.data["reading"] - value}, index=answer.data.index)
    for share in BANDS:
        found[f"band {share:.0%}"] = fit.times(share) * deviation
    return found.join(fit.parts(answer.data))


def influence(answer):
    """Returns Cook's distance and leverage of each reading in the fit to all, by date."""
    import statsmodels.api as sm

    matrix = answer.final.matrix(answer.data)
    found = sm.OLS(answer.data["reading"].to_numpy(), matrix).fit().get_influence()
    return pd.DataFrame({"cook": found.cooks_distance[0], "leverage": found.hat_matrix_diag}, index=answer.data.index)
