"""From readings to a posterior: rounds of runs about what the readings allow, surfaces, checks, samples; files for the ensemble.

    found = updated(readings, "model.yaml", "out/readings", jobs=2)     Updated
"""

import json
import os
import tempfile
from dataclasses import dataclass

import numpy as np
import pandas as pd
import yaml

from quoin_tools.base.files import write_file
from quoin_tools.ensemble import design
from quoin_tools.ensemble.drawn import FORMAT
from quoin_tools.mesh import blockmesh
from quoin_tools.readings import drift, posterior, responses, surfaces
from quoin_tools.readings.sensors import ReadingsError
from quoin_tools.readings.surfaces import Table

MORE = 2  # rounds that may follow those of the model
REACH = 4.0  # posterior deviations that the box of the next round reaches
INSIDE = 3.0  # posterior deviations that must lie in a box whose runs are there
CUT = 1.25  # times as far it reaches where samples crowd at an end: a cut posterior is narrower in all that goes with the cut parameter, too
SURE = 0.5  # of the accuracy of an instrument: a surface that errs more is refused
NARROWEST = 0.3  # half width of a box
TOO_LARGE = 3.0  # of the accuracy of an instrument: nine tenths of what a larger model error leaves of its readings are the model's
NORMAL_95 = 1.959964
FEWEST_EFFECTIVE, FARTHEST_R_HAT = 400, 1.05  # of samples: beyond these, the posterior is not yet sure
EDGE = 0.01  # part of the samples so close to an end of the box (a tenth of its half) that the posterior goes on beyond


@dataclass
class Updated:
    """refused: {instrument: its surface, whose error is above half of the accuracy}. held: year that the fit has not seen, None: none; rows, correlation: of posterior.py.
    boxes: of the rounds; table: the runs behind the surfaces; doubts: {instrument: sentence} on a model that is wrong in kind."""

    model: surfaces.Model
    surfaces: dict
    refused: dict
    posterior: posterior.Posterior
    drift: drift.Drift
    rows: list
    correlation: np.ndarray
    start: pd.Timestamp
    warmest: float
    held: int | None
    lost: int
    edges: list
    boxes: list
    table: Table
    doubts: dict

    def predicted(self, name, dates, level):
        """Returns (low, median, high) [SI] of what an instrument reads at these dates and levels [m]; 95 % lie between low and high."""
        k = [channel.name for channel in self.posterior.channels].index(name)
        mean, deviation = self.posterior.predicted(k, days_since(dates, self.start), states_of(dates, level, self.warmest))
        ends = mean - NORMAL_95 * deviation, mean, mean + NORMAL_95 * deviation
        return tuple(map(np.exp, ends)) if self.surfaces[name].log else ends


def days_since(dates, start):
    return np.asarray((dates - start) / pd.Timedelta(days=1), dtype=float)


def states_of(dates, level, warmest):
    """Returns (n, 2): level [m], days since the air was warmest."""
    day = dates.day_of_year.to_numpy() + dates.hour.to_numpy() / 24
    return np.column_stack([np.asarray(level, dtype=float), (day - warmest) % surfaces.YEAR])


def warmest_day(readings, model):
    """Returns the day of the year at which the air is warmest: of the model, else the crest of the yearly wave through the readings of the air."""
    if model.season is None or model.season[1] is not None:
        return float(model.season[1] or 0) if model.season else 0.0
    air = readings.plan.one("air temperature")
    if air is None:
        raise ReadingsError(f"{model.path}: season.warmest: missing: expected the day of the year at which the air is warmest, as no sensor reads the air")
    series = readings.series(air)
    angle = 2 * np.pi * (series.index.day_of_year.to_numpy() + series.index.hour.to_numpy() / 24) / surfaces.YEAR
    a, b = np.linalg.lstsq(np.column_stack([np.cos(angle), np.sin(angle), np.ones(len(angle))]), series.to_numpy(), rcond=None)[0][:2]
    return float(np.arctan2(b, a) / (2 * np.pi) * surfaces.YEAR % surfaces.YEAR)


def error_of(surface, readings, name, of="error"):
    """Returns the error of a surface [SI]; of a logarithm, at the median reading."""
    return getattr(surface, of) * (float(readings.series(name).median()) if surface.log else 1.0)


def thinned(frame, most=posterior.MOST):
    return frame if len(frame) <= most else frame.iloc[np.linspace(0, len(frame) - 1, most).round().astype(int)]


def instruments_of(readings, model):
    """Returns {name: Sensor} of what the model can read; refuses a level outside those of the model."""
    level = readings.plan.one("level")
    if level is None:
        raise ReadingsError(f"{readings.plan.path}: sensors: no level: the model needs that of the water")
    series = readings.series(level)
    low, high = model.level[1:]
    out = series[(series < low) | (series > high)]
    if len(out):
        raise ReadingsError(f"{model.path}: level: {low:g} to {high:g} m: expected {series.min():.2f} to {series.max():.2f} m or more, as the readings have ({out.index[0]:%Y-%m-%d}: {out.iloc[0]:.2f} m)")
    found = {name: sensor for name, sensor in readings.sensors.items() if not sensor.drives}
    for name, sensor in found.items():
        if sensor.accuracy is None:
            raise ReadingsError(f"{readings.plan.path}: sensors.{name}.accuracy: missing: expected the standard deviation of a reading, on which the posterior depends")
    return level, found


def checked(readings, path):
    """Returns (model, level, instruments). Refuses what does not fit, before a run or a file."""
    model = surfaces.read(path)
    surfaces.scene_of_states(model, [(model.level[1], 0.0)])
    return model, *instruments_of(readings, model)


def tried(readings, path):
    """Makes one run of the model, with the medians of the priors at the middle level: what it cannot read is refused before anything is written. Returns sentences on where displacements are taken."""
    model, _level, instruments = checked(readings, path)
    with tempfile.TemporaryDirectory() as folder:
        try:
            surfaces.responses(model, instruments, [(0.5 * sum(model.level[1:]), 0.0)], np.zeros(len(model.names)), os.path.join(folder, "run"))
        except ReadingsError as error:
            raise ReadingsError(f"{readings.plan.path}: {error}" if str(error).startswith("sensors.") else str(error)) from error
    mesh = model.design.model or design.named_in(model.design.scene)[0]
    points = {name: sensor for name, sensor in instruments.items() if sensor.quantity == "displacement"} if mesh else {}
    return [f"{name}: {one}" for name, sensor in points.items() for one in responses.told(blockmesh.read(mesh), sensor)]


def channels_of(readings, level, instruments, made, start, warmest, held):
    """Returns the channels of the readings that are not of the held-out year."""
    channels: list = []
    for name, surface in made.items():
        frame = readings.frame([level, name])
        frame = thinned(frame[frame.index.year != held] if held else frame)
        times = days_since(frame.index, start)
        like = next((one for one in channels if np.array_equal(one.time, times)), None)
        channels.append(posterior.Channel.of(name, instruments[name].accuracy, times, states_of(frame.index, frame[level], warmest), frame[name].to_numpy(), surface,
                                             instruments[name].quantity not in posterior.HAS_ZERO, like))  # fmt: skip
    return channels


def crowded(found, d):
    """Returns (2, d): which of the first d unknowns crowd with their samples at the lower and at the upper end of the box, where the prior goes on: the box is too narrow for them."""
    box = found.box.first(d)
    scaled, ends = box.scaled(found.normal[:, :d]), np.array([box.half - box.centre, box.half + box.centre])
    return (np.array([(scaled < -0.9).mean(axis=0), (scaled > 0.9).mean(axis=0)]) > EDGE) & (ends < surfaces.WIDEST - 1e-9)


def narrowed(found, d, reach=REACH, least=NARROWEST):
    """Returns the box about the first d unknowns of a posterior, within the widest one. Where samples crowd at an end of the last box, nobody knows how far they would go: it reaches half
    a box past that end, and farther in all unknowns."""
    below, above = crowded(found, d)
    reach *= CUT if (below | above).any() else 1
    mean, half, last = found.mean()[:d], np.maximum(reach * found.normal[:, :d].std(axis=0), least), found.box.first(d)
    low = np.where(below, np.minimum(mean - half, last.centre - 2 * last.half), mean - half)
    high = np.where(above, np.maximum(mean + half, last.centre + 2 * last.half), mean + half)
    low, high = np.maximum(low, -surfaces.WIDEST), np.minimum(high, surfaces.WIDEST)
    return surfaces.Box(0.5 * (low + high), 0.5 * (high - low))


def kept_box(path, mark, needed):
    """Returns the box of runs that are there, if it holds the needed one: runs are made anew only where new readings have moved the posterior. None: there is none."""
    try:
        with open(path, encoding="utf-8") as file:
            kept = json.load(file)
        box = surfaces.Box(np.array(kept["centre"]), np.array(kept["half"]))
    except (OSError, ValueError, KeyError):
        return None
    return box if kept["model"] == mark and (np.abs(needed.centre - box.centre) + needed.half <= box.half + 1e-9).all() else None


def updated(readings, path, folder, jobs=1, seed=1, report=None):
    """Returns Updated. Each round makes runs in a narrower box, about what the readings allow; instruments whose surface is less sure than they are themselves do not count. While samples
    crowd at an end of the last box there are MORE rounds."""
    model, level, instruments = checked(readings, path)
    start, warmest, held = readings.data.index[0], warmest_day(readings, model), readings.plan.statistics.get("held_out")
    d, boxes, table, found = len(model.names), [surfaces.widest(model)], None, None
    for round_ in range(model.rounds + MORE):
        if found is not None:
            boxes.append(kept_box(os.path.join(folder, f"box_{round_}.json"), model.mark, narrowed(found, d, INSIDE, 0.0)) or narrowed(found, d))
        box = boxes[-1]
        os.makedirs(folder, exist_ok=True)
        write_file(os.path.join(folder, f"box_{round_}.json"), json.dumps({"model": model.mark, "centre": box.centre.tolist(), "half": box.half.tolist()}) + "\n")
        new = surfaces.run(model, instruments, box, folder, jobs, round_, report)
        table = new if table is None else new.joined(table, box)
        made = surfaces.fitted(model, instruments, table, box)
        last = round_ >= model.rounds - 1
        refused = {name: surface for name, surface in made.items() if last and not error_of(surface, readings, name) <= SURE * instruments[name].accuracy}
        kept = {name: surface for name, surface in made.items() if name not in refused}
        if not kept:
            errors = {name: error_of(surface, readings, name) for name, surface in refused.items()}
            name = min(errors, key=lambda one: errors[one] / instruments[one].accuracy)
            said = [f"{abs(float(instruments[name].shown(value, True))):.3g} {instruments[name].unit_of(True)}" for value in (errors[name], instruments[name].accuracy)]
            raise ReadingsError(f"{path}: no surface is twice as sure as its instrument (the nearest is {name}: error {said[0]}, accuracy {said[1]}): expected more runs or rounds, or narrower priors")
        names, whole = (model.names, box) if model.season is None else ([*model.names, "season.delay"], surfaces.Box(np.r_[box.centre, 0.0], np.r_[box.half, surfaces.WIDEST]))
        found = posterior.sample(names, channels_of(readings, level, instruments, kept, start, warmest, held), whole, seed, *(() if last else (300, 1500)))
        if last and not crowded(found, d).any():
            break
    variables = model.design.variables
    rows, correlation = posterior.summary(found, variables), posterior.correlations(found, variables)
    edges = [name for name, there in zip(model.names, crowded(found, d).any(axis=0), strict=True) if there]
    return Updated(model, made, refused, found, drift.search(found), rows, correlation, start, warmest, held, table.lost, edges, boxes, table, doubts(readings, model, found, rows))


def model_error(readings, found, k):
    """Returns (standard deviation [SI], days that it lasts) of the model error of channel k of a posterior."""
    channel, (spread, tau) = found.channels[k], found.spread(k)
    return float(np.sqrt((spread**2).mean())) * (float(readings.series(channel.name).median()) if channel.surface.log else 1.0), float(np.median(tau))


def doubts(readings, model, found, rows):
    """Returns {instrument: sentence} where readings say that the model is wrong in kind, which no band of a parameter tells: of large model errors, and of contradictions."""
    said, d = {}, len(model.names)
    for name, peak in posterior.contradictions(found).items():
        values = [*model.design.variables.values(peak[None, :d])[0], *(surfaces.DELAY * peak[d:])]
        moves = ", ".join(f"{row['name']} {value:.3g} (with it {row['low']:.3g} to {row['high']:.3g})" for row, value in zip(rows, values, strict=True) if not row["low"] <= value <= row["high"])
        said[name] = f"in this model it contradicts the other instruments; without it they want {moves or 'several parameters elsewhere'}"
    for k, channel in enumerate(found.channels):
        sensor, (size, days) = readings.sensors[channel.name], model_error(readings, found, k)
        if size > TOO_LARGE * sensor.accuracy:
            shown = [f"{abs(float(sensor.shown(value, True))):.3g} {sensor.unit_of(True)}" for value in (size, sensor.accuracy)]
            text = f"the model errs by {shown[0]} (one deviation) for {days:.0f} days, {size / sensor.accuracy:.1f} times the accuracy of {shown[1]}"
            said[channel.name] = "; ".join([text, *([said[channel.name]] if channel.name in said else [])])
    return {name: f"{text}. The bands of the parameters do not cover a model that is wrong in kind: look at this instrument, or change the model" for name, text in said.items()}


def warnings(found):
    """Returns {instrument or parameter: sentence} of all that makes the posterior less than it looks."""
    said = dict.fromkeys(found.refused, "refused, its surface errs by more than half of the accuracy, so its readings do not count: more runs, or narrower priors")
    said |= found.doubts
    for row in found.rows:
        texts = [f"the samples are not enough yet (effective {row['effective']:.0f}, R-hat {row['r_hat']:.3f})"] if row["effective"] < FEWEST_EFFECTIVE or row["r_hat"] > FARTHEST_R_HAT else []
        texts += ["its samples crowd at the end of what runs have checked, so its band is cut off: one round more"] if row["name"] in found.edges else []
        said |= {row["name"]: "; ".join(texts)} if texts else {}
    return said


def write(found, folder):
    """Writes posterior.csv, a row for each sample with values as the scene takes them, and posterior.yaml, which quoin ensemble --posterior reads. Returns their paths."""
    paths = [os.path.join(folder, name) for name in ("posterior.csv", "posterior.yaml")]
    values = found.model.design.variables.values(found.posterior.normal[:, : len(found.model.names)])
    write_file(paths[0], "\n".join([",".join(found.model.names), *(",".join(f"{value:.8g}" for value in row) for row in values)]) + "\n")
    keys = {one.name: list(one.keys) for one in found.model.design.variables.each}
    variables = {row["name"]: {"keys": keys[row["name"]]} | {key: float(f"{row[key]:.6g}") for key in row if key != "name"} for row in found.rows if row["name"] in keys}
    write_file(paths[1], yaml.safe_dump({"format": FORMAT, "version": 1, "samples": "posterior.csv", "model": os.path.basename(found.model.path), "basis": found.model.design.basis, "warnings": warnings(found), "variables": variables,
                                         "correlation": [[round(float(x), 4) for x in row[: len(keys)]] for row in found.correlation[: len(keys)]]}, sort_keys=False))  # fmt: skip
    return paths


def coverage(readings, found, name):
    """Returns (share of the readings of the held-out year in the 95 % band, their number, root mean square of the error [SI]); None without any."""
    level = readings.plan.one("level")
    frame = readings.frame([level, name])
    frame = frame[frame.index.year == found.held] if found.held else frame.iloc[:0]
    if not len(frame):
        return None
    low, middle, high = found.predicted(name, frame.index, frame[level])
    read = frame[name].to_numpy()
    return float(((read > low) & (read < high)).mean()), len(frame), float(np.sqrt(np.mean((read - middle) ** 2)))
