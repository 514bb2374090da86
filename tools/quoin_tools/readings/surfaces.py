"""Response surfaces of the block model: what each instrument would read, over level, season and parameters, from runs; checked against runs that it has not seen.

    model = read("model.yaml")                       scene, variables (as an ensemble has them), level, season
    table = run(model, sensors, box, folder, jobs)   rows of runs: state, normal scores of the variables, numbers
    surface = Surface.of(table, box, name)           a sum of Legendre polynomials; surface.error, in SI

A parameter enters by its normal score z: the value at which its distribution reaches Phi(z). So the prior of z is the standard normal one.
"""

import csv
import functools
import hashlib
import itertools
import json
import math
import os
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from copy import deepcopy
from dataclasses import dataclass, field

import numpy as np
import scipy
import yaml
from numpy.polynomial import legendre

from quoin_tools.base import solver
from quoin_tools.base.files import write_file
from quoin_tools.base.results import Results
from quoin_tools.base.scene import find, yaml_of
from quoin_tools.ensemble import design
from quoin_tools.ensemble.models import last_line, text_of
from quoin_tools.ensemble.variables import EnsembleError
from quoin_tools.readings.responses import numbers
from quoin_tools.readings.sensors import ReadingsError

YEAR = 365.25  # [day]
DELAY = 5.0  # [day] prior deviation of the delay of the season behind the yearly wave of the air, whose crest is known to a day or two
WIDEST = 2.6  # normal score: 99 % of a prior lies within; beyond no run has checked the surface
HELD = 5  # every HELD-th run is held out of the fit
DEGREES, NORMS = (2, 3, 4, 5, 6), (0.5, 0.7, 1.0)  # of polynomials that are tried
MOST_LEVEL, MOST_SEASON = 5, 2  # degree over the level, harmonics of the year
LOGARITHMS = ("discharge",)  # quantities whose logarithm is fitted, read and judged
OWN = ("level", "season", "runs", "states", "rounds")
TAKEN = ("scene", "model", "stage", "options", "variables", "correlation", "seed", "time_limit")  # keys of an ensemble that a model has


@dataclass
class Model:
    """What model.yaml says. level: (keys, least, highest [m]); season: (keys, days after new year at which the air is warmest; None: by the readings)."""

    path: str
    design: design.Design
    level: tuple
    season: tuple | None
    runs: int
    states: int
    rounds: int
    mark: str = field(default="")

    @property
    def names(self):
        return self.design.columns()

    @functools.cached_property
    def read_scene(self):
        """What the file of the scene says (dict), read once for all runs."""
        return yaml_of(self.design.scene, ReadingsError)


def read(path):
    """Reads model.yaml: the keys of an ensemble, and level, season, runs (of a round), states (of a run), rounds."""
    data = yaml_of(path, ReadingsError)
    if not isinstance(data, dict):
        raise ReadingsError(f"{path}: expected a model, a file with scene, stage, variables, level")
    own = {key: data.pop(key) for key in OWN if key in data}
    for key in data:
        if key not in TAKEN:
            raise ReadingsError(f"{path}: {key}: unknown key; there are {', '.join((*TAKEN, *OWN))}")
    try:
        made = design.made(data | {"samples": 1, "seed": data.get("seed", 1)}, path)
    except EnsembleError as error:
        raise ReadingsError(f"{path}: {error}") from error
    choices = [one.name for one in made.variables.each if one.choices or one.kind == "integer"]
    if choices or made.stage is None:
        raise ReadingsError(f"{path}: {f'variables.{choices[0]}: a surface needs numbers without steps' if choices else 'stage: missing: expected that of the scene whose readings these are'}")
    level, season = own.get("level"), own.get("season")
    if not isinstance(level, dict) or set(level) != {"keys", "min", "max"} or not (finite(level["min"]) and finite(level["max"]) and level["min"] < level["max"]):
        raise ReadingsError(f"{path}: level: {level}: expected keys of the scene, min and max [m] between which runs are made")
    if season is not None and (not isinstance(season, dict) or not {"keys"} <= set(season) <= {"keys", "warmest"}):
        raise ReadingsError(f"{path}: season: {season}: expected keys of the scene (a day), and, if you like, warmest: days after new year")
    warmest = season.get("warmest") if season else None
    if warmest is not None and not (finite(warmest) and 0 <= warmest <= 366):
        raise ReadingsError(f"{path}: season.warmest: {warmest}: expected 0 to 366 days after new year")
    counts = [own.get(key, default) for key, default in (("runs", 200), ("states", 3), ("rounds", 3))]
    if not all(type(one) is int and one > 0 for one in counts) or counts[0] < 2 * HELD:
        raise ReadingsError(f"{path}: runs, states, rounds: {counts}: expected whole numbers, runs at least {2 * HELD}")
    check_keys(path, {"level": level, "season": season or {"keys": [None]}}, [key for one in made.variables.each for key in one.keys])
    seasons = (tuple(season["keys"]), warmest) if season else None
    model = Model(path, made, (tuple(level["keys"]), float(level["min"]), float(level["max"])), seasons, *counts)
    model.mark = hashlib.sha256(json.dumps([made.mark, {k: v for k, v in own.items() if k not in ("runs", "rounds")}], default=str).encode()).hexdigest()[:16]
    return model


def finite(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def check_keys(path, sections, taken):
    """Refuses keys of level and season that are no numbers of loads, or that are set twice. taken: keys of the variables."""
    taken = list(taken)
    for section, row in sections.items():
        if not isinstance(row["keys"], list) or not row["keys"]:
            raise ReadingsError(f"{path}: {section}.keys: {row['keys']}: expected a list of numbers of loads, loads.<name>.<key>")
        for key in (key for key in row["keys"] if key is not None or section == "level"):
            if not isinstance(key, str) or key.split(".")[0] != "loads" or len(key.split(".")) != 3:
                raise ReadingsError(f"{path}: {section}.keys: {key}: expected a number of a load, loads.<name>.<key>")
            if key in taken:
                raise ReadingsError(f"{path}: {section}.keys: {key}: expected it once in variables, level and season")
            taken.append(key)


# ---- runs --------------------------------------------------------------------------------------------------


def scene_of_states(model, states):
    """Returns the scene (dict) whose last stages are these states (n, 2) of level and day, each from the start of the wanted stage."""
    scene = deepcopy(model.read_scene)
    if not isinstance(scene, dict) or not all(isinstance(scene.get(key), kind) and scene[key] for key, kind in (("loads", dict), ("stages", list))) or not all(isinstance(one, dict) and len(one) == 1 for one in scene["stages"]):
        raise ReadingsError(f"{model.design.scene}: expected a scene with loads and a list of stages")
    stages = [next(iter(stage.items())) for stage in scene["stages"]]
    at = next((k for k, (name, _keys) in enumerate(stages) if name == model.design.stage), None)
    if at is None:
        raise ReadingsError(f"{model.path}: stage: no stage '{model.design.stage}' in {model.design.scene}")
    name, keys = stages[at]
    keys.setdefault("from", stages[at - 1][0] if at else None)
    scene["stages"] = [{before: what} for before, what in stages[:at]]
    for key, row in ((key, row) for row in scene["loads"].values() for key in design.FILES if isinstance(row.get(key), str)):
        row[key] = os.path.abspath(find(os.path.dirname(model.design.scene), row[key]) or row[key])
    for k, (level, day) in enumerate(states):
        given = {key: float(level) for key in model.level[0]} | ({key: float(day) for key in model.season[0]} if model.season else {})
        renamed = {}
        for key, value in given.items():
            _loads, load, what = key.split(".")
            if load not in scene["loads"] or load not in keys.get("loads", ()):
                raise ReadingsError(f"{model.path}: {key}: stage {name} has no such load")
            renamed[load] = f"{load}_at_{k}"
            scene["loads"].setdefault(renamed[load], dict(scene["loads"][load]))[what] = value
        state = {what: value for what, value in keys.items() if value is not None} | {"loads": [renamed.get(load, load) for load in keys["loads"]]}
        scene["stages"].append({f"state_{k}": state})
    return scene


def copies(model, key, n):
    """Returns the keys of the scene of n states that a key of a variable sets: a load with the level or the day has a copy for each state."""
    moved = {one.split(".")[1] for one in (*model.level[0], *(model.season[0] if model.season else ()))}
    head, _, rest = key.partition(".")
    name, _, last = rest.partition(".")
    return [key, *(f"loads.{name}_at_{k}.{last}" for k in range(n))] if head == "loads" and name in moved else [key]


def responses(model, sensors, states, normal, folder):
    """Runs the states with the variables at these normal scores. Returns {state: {sensor: number}} of those that converged."""
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    path = os.path.join(folder, "scene.yaml")
    write_file(path, yaml.dump(scene_of_states(model, states), Dumper=yaml.CSafeDumper, sort_keys=False))
    mesh = model.design.model or design.named_in(model.design.scene)[0]
    values = model.design.variables.values([normal])[0]
    keys = [word for one, value in zip(model.design.variables.each, values, strict=True) for key in one.keys for copy in copies(model, key, len(states)) for word in (design.option(copy), text_of(value))]
    words = ["-options_file", path, *(["-model", mesh] if mesh else []), *model.design.options, *keys, "-output", folder]
    done = solver.run(solver.command(words), model.design.time_limit, env=solver.environment_of_one(), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    if not os.path.exists(os.path.join(folder, "results.h5")):
        raise ReadingsError(f"{model.path}: run {os.path.basename(folder)} in {folder}: {last_line(done.stderr) or f'exit code {done.returncode} without results'}")
    results = Results(folder)
    found = {int(name.rpartition("_")[2]): numbers(results, name, sensors) for name in results.stages if name.startswith("state_") and results.stage(name).verdict == "converged"}
    shutil.rmtree(folder)
    return found


@dataclass
class Box:
    """Normal scores between which runs are made: centre, half (d,)."""

    centre: np.ndarray
    half: np.ndarray

    def scaled(self, normal):
        return (normal - self.centre) / self.half

    def first(self, d):
        """Returns the box of the first d unknowns."""
        return Box(self.centre[:d], self.half[:d])

    def holds(self, normal, slack=1e-9):
        return (np.abs(self.scaled(normal)) <= 1 + slack).all(axis=-1)


def widest(model):
    return Box(np.zeros(len(model.names)), np.full(len(model.names), WIDEST))


@dataclass
class Table:
    """Rows of runs. run (n,); state (n, 2): level [m], day; normal (n, d); numbers: {sensor: (n,)}. lost: states without a converged stage."""

    run: np.ndarray
    state: np.ndarray
    normal: np.ndarray
    numbers: dict
    lost: int = 0

    def joined(self, other, box):
        """Returns the rows of both that lie in a box, widened by half, so that the polynomials of a narrow box see its surroundings; runs keep apart."""
        near = Box(box.centre, 1.5 * box.half).holds(other.normal)
        shift = self.run.max() + 1
        return Table(np.r_[self.run, other.run[near] + shift], np.r_[self.state, other.state[near]], np.r_[self.normal, other.normal[near]],
                     {name: np.r_[one, other.numbers[name][near]] for name, one in self.numbers.items()}, self.lost)  # fmt: skip


def points(model, box, round_):
    """Returns normal scores (runs, d) that fill the box evenly, and states (runs, states, 2)."""
    d = len(model.names)
    even = scipy.stats.qmc.Sobol(d, scramble=True, rng=np.random.default_rng([model.design.seed, round_])).random(model.runs)
    states = scipy.stats.qmc.Sobol(2, scramble=True, rng=np.random.default_rng([model.design.seed, round_, 1])).random(model.runs * model.states)
    low, high = model.level[1:]
    ends = 0.5 * (1 - np.cos(np.pi * states[:, 0]))  # denser towards both ends, where polynomials are least sure
    return box.centre + (2 * even - 1) * box.half, np.column_stack([low + (high - low) * ends, YEAR * states[:, 1]]).reshape(model.runs, model.states, 2)


def run(model, sensors, box, folder, jobs=1, round_=0, report=None):
    """Makes the runs of a round that are not in the folder yet; returns their Table. A run is written as soon as it ends; begun again it goes on."""
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # the balance of a Sobol sequence needs a power of 2, which no surface needs
        normal, states = points(model, box, round_)
    path = os.path.join(folder, f"surface_{round_}.csv")
    places = [(one.name, one.quantity, one.point, one.direction, one.joint, one.position, one.drain, one.width) for one in sensors.values()]
    header = [f"# {hashlib.sha256(f'{model.mark} {places}'.encode()).hexdigest()[:16]}", "state", "level", "day", *model.names, *sensors]
    os.makedirs(folder, exist_ok=True)
    rows = kept_rows(path, header, normal, model.states)
    there = {row[0] for row in rows}

    def one(k):
        return k, responses(model, sensors, states[k], normal[k], os.path.join(folder, "runs", f"{round_}_{k}"))

    with open(path, "a", encoding="utf-8", newline="") as file, ThreadPoolExecutor(jobs) as pool:
        for done, (k, found) in enumerate(pool.map(one, [k for k in range(model.runs) if k not in there])):
            mine = [[k, j, *states[k, j].tolist(), *normal[k].tolist(), *(found[j][name] for name in sensors)] for j in found] or [[k, -1, *(float("nan") for _ in header[2:])]]
            csv.writer(file, lineterminator="\n").writerows(mine)
            file.flush()
            rows += mine
            if report:
                report(len(there) + done + 1, model.runs)
    numbers_ = np.array(sorted(row for row in rows if row[1] >= 0))
    at = 4 + len(model.names)
    table = Table(numbers_[:, 0].astype(int), numbers_[:, 2:4], numbers_[:, 4:at], {name: numbers_[:, at + n] for n, name in enumerate(sensors)}, model.runs * model.states - len(numbers_))
    if len(set(table.run)) < model.runs / 2:
        raise ReadingsError(f"{model.path}: {model.runs - len(set(table.run))} of {model.runs} runs have no state that converges: expected narrower priors or levels")
    return table


def kept_rows(path, header, normal, states):
    """Returns rows of whole runs at these normal scores in a file of this header, which holds no others afterwards. The last run, where it has not all states, may have been cut off."""
    lines: list = []
    if os.path.exists(path):
        with open(path, encoding="utf-8", newline="") as file:
            lines = list(csv.reader(file))
    rows = [[int(row[0]), int(row[1]), *map(float, row[2:])] for row in lines[1:] if len(row) == len(header)] if lines and lines[0] == header else []
    at = slice(4, 4 + normal.shape[1])
    cut = {rows[-1][0]} if rows and sum(row[0] == rows[-1][0] for row in rows) < states else set()
    rows = [row for row in rows if row[0] not in cut and row[0] < len(normal) and (row[1] < 0 or np.allclose(row[at], normal[row[0]], rtol=0, atol=1e-12))]
    write_file(path, "\n".join([",".join(header), *(",".join(map(repr, row)) for row in rows)]) + "\n")
    return rows


# ---- the surface -------------------------------------------------------------------------------------------


def sums(most, power, norm):
    """Returns all rows of whole numbers from 0 to those of `most` whose norm, sum(x^norm)^(1/norm), is at most `power`."""
    rows: list = [((), power**norm + 1e-9)]
    for one in most:
        rows = [((*row, x), left - x**norm) for row, left in rows for x in range(min(one, power) + 1) if x**norm <= left]
    return [row for row, _left in rows]


@dataclass(frozen=True)
class States:
    """Columns of a state: degrees (level, harmonic, sine or not); low, high [m]."""

    terms: tuple
    low: float
    high: float

    def of(self, state):
        """Returns (n, J). state (n, 2): level [m], days since the air was warmest."""
        x = 2 * (state[:, 0] - self.low) / (self.high - self.low) - 1
        powers, angle = legendre.legvander(x, MOST_LEVEL), 2 * np.pi * state[:, 1] / YEAR
        return np.column_stack([powers[:, a] * (np.sin if sine else np.cos)(h * angle) for a, h, sine in self.terms])

    @functools.cached_property
    def waves(self):
        """Returns (columns of cosines, columns of their sines, harmonics)."""
        found = [(j, self.terms.index((a, h, 1)), h) for j, (a, h, sine) in enumerate(self.terms) if h and not sine]
        return tuple(np.array(found, dtype=int).reshape(-1, 3).T)

    def delayed(self, coefficients, days):
        """Returns the coefficients (n, J) of the same response some days (n,) later in the year: cosine and sine of a harmonic turn into each other."""
        cosines, sines, harmonics = self.waves
        turn, found = 2 * np.pi / YEAR * np.outer(days, harmonics), coefficients.copy()
        cos, sin, turned, across = coefficients[:, cosines], coefficients[:, sines], np.cos(turn), np.sin(turn)
        found[:, cosines], found[:, sines] = cos * turned - sin * across, cos * across + sin * turned
        return found


@dataclass
class Surface:
    """numbers = states.of(state) @ weights @ parameters(normal); log: that is their natural logarithm. error: root mean square over held-out runs; largest: of them; n: how many numbers."""

    box: Box
    states: States
    degrees: np.ndarray  # (M, d) of the Legendre polynomials of the parameters
    weights: np.ndarray  # (J, M)
    error: float
    largest: float
    n: int
    log: bool

    def parameters(self, normal):
        """Returns (n, M)."""
        powers = legendre.legvander(self.box.scaled(normal), int(self.degrees.max(initial=0)))  # n, d, degree
        found = powers[:, 0, self.degrees[:, 0]]
        for k in range(1, self.degrees.shape[1]):
            found = found * powers[:, k, self.degrees[:, k]]
        return found

    def coefficients(self, normal):
        """Returns (n, J), what multiplies the columns of a state. normal (n, d), or (n, d + 1): the last is the delay of the season, over its prior deviation."""
        normal = np.atleast_2d(normal)
        d = len(self.box.centre)
        found = self.parameters(normal[:, :d]) @ self.weights.T
        return self.states.delayed(found, DELAY * normal[:, d]) if normal.shape[1] > d else found

    def at(self, state, normal):
        """Returns (n,) for n states and one point of the parameters, or n of them."""
        return (self.states.of(state) * self.coefficients(normal)).sum(axis=1)

    @classmethod
    def of(cls, table, box, name, low, high, seasonal, log=False):
        """Returns the surface of one sensor."""
        return surfaces_of(table, box, {name: log}, low, high, seasonal)[name]


def surfaces_of(table, box, logs, low, high, seasonal):
    """Returns {sensor: Surface} for logs, {sensor: whether its logarithm is fitted}: the polynomials of which runs left out of the fit (in five parts) are met best; the error is that of
    other runs, which no fit has seen. All sensors have the same columns, whose decomposition takes the time: they are fitted together."""
    values = np.column_stack([np.log(table.numbers[name]) if log else table.numbers[name] for name, log in logs.items()])
    held, folds, x, state = table.run % HELD == 0, (table.run // HELD) % 5, box.scaled(table.normal), table.state
    inside, d = held & box.holds(table.normal), x.shape[1]
    best: list = [(np.inf, None, None)] * len(logs)
    for power, norm in itertools.product(DEGREES, NORMS):
        rows = sums([MOST_LEVEL, MOST_SEASON if seasonal else 0, *[power] * d], power, norm)
        terms = [(a, h, sine, *m) for a, h, *m in rows for sine in ((0, 1) if h else (0,))]
        if len(terms) > 0.6 * (~held).sum():
            continue
        matrix = columns(terms, state, x, low, high)
        missed = np.concatenate([values[part] - matrix[part] @ solved(matrix[fit], values[fit]) for k in range(5) for part, fit in [(~held & (folds == k), ~held & (folds != k))]])
        errors, weights = np.sqrt(np.mean(missed**2, axis=0)), solved(matrix[~held], values[~held])
        best = [(error, terms, weights[:, k]) if error < best[k][0] else best[k] for k, error in enumerate(errors)]
    made = {}
    for (name, log), column, (_error, terms, weights) in zip(logs.items(), values.T, best, strict=True):
        pairs, points_ = sorted({t[:3] for t in terms}), sorted({t[3:] for t in terms})
        table_of_weights = np.zeros((len(pairs), len(points_)))
        for term, weight in zip(terms, weights, strict=True):
            table_of_weights[pairs.index(term[:3]), points_.index(term[3:])] = weight
        one = Surface(box, States(tuple(pairs), low, high), np.array(points_, dtype=int).reshape(-1, d), table_of_weights, 0.0, 0.0, int(inside.sum()), log)
        missed = np.abs(column[inside] - one.at(table.state[inside], table.normal[inside]))
        one.error, one.largest = float(np.sqrt(np.mean(missed**2))), float(missed.max())
        made[name] = one
    return made


def columns(terms, state, x, low, high):
    """Returns the matrix (n, terms) of a fit. x (n, d): scaled normal scores."""
    pairs = sorted({t[:3] for t in terms})
    base = States(tuple(pairs), low, high).of(state)
    powers = legendre.legvander(x, max(max(t[3:], default=0) for t in terms))
    where = {pair: k for k, pair in enumerate(pairs)}
    made = base[:, [where[t[:3]] for t in terms]]
    for k in range(x.shape[1]):
        made *= powers[:, k, [t[3 + k] for t in terms]]
    return made


def solved(matrix, values):
    return np.linalg.lstsq(matrix, values, rcond=1e-10)[0]


def fitted(model, sensors, table, box):
    """Returns {sensor: Surface} of a table. A discharge goes with powers of apertures and conductances: its logarithm is nearly straight over their normal scores."""
    for name in sensors:
        if sensors[name].quantity in LOGARITHMS and not (table.numbers[name] > 0).all():
            raise ReadingsError(f"sensors.{name}: {(table.numbers[name] <= 0).sum()} of {len(table.run)} states of the model have no discharge: expected one in all, or narrower priors and levels")
    return surfaces_of(table, box, {name: sensors[name].quantity in LOGARITHMS for name in table.numbers}, *model.level[1:], model.season is not None)
