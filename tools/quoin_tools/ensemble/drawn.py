"""Takes variables of an ensemble from the posterior that readings have left (posterior.yaml of quoin readings) in place of their distributions.

    design = with_posterior(design.read("ensemble.yaml"), "posterior.yaml")

A sample takes a whole row of the posterior, so that what the readings have tied together stays together. Which row depends on seed and number of the sample alone. Variables that the
readings do not know keep their distributions, and their numbers of the ensemble before the readings.
"""

import hashlib
import math
import os
from dataclasses import dataclass, replace

import numpy as np

from quoin_tools.base.scene import yaml_of
from quoin_tools.ensemble.variables import EnsembleError, option, stream

FORMAT = "quoin-posterior"
SPREADS = ("prior_sd", "sd", "ratio")
NUMBERS = ("prior_mean", "mean", "low", "high", *SPREADS)
ROUNDING = 1e-5  # of numbers of six digits
LONGEST = 200  # part of a line that is shown


@dataclass(frozen=True)
class Drawn:
    """rows (n, k) of values; places: of the columns among the variables of the ensemble; unused: variables of the posterior that the ensemble has not;
    variables: what posterior.yaml says of those that it has; warnings: {instrument, variable or file: sentence}."""

    path: str
    rows: np.ndarray
    places: tuple
    unused: tuple
    seed: int
    variables: dict
    warnings: dict

    def over(self, values, index):
        """Returns the values of a sample with those of its row of the posterior."""
        row = self.rows[int(stream(self.seed, "row of the posterior", index) * len(self.rows))]
        return tuple(float(row[self.places.index(k)]) if k in self.places else value for k, value in enumerate(values))

    def words(self, k, name):
        column = self.rows[:, self.places.index(k)]
        return f"{name}: by the readings, mean {column.mean():.6g}, deviation {column.std():.6g}"


def with_posterior(design, path):
    """Returns the design with values from the posterior. EnsembleError: no posterior, or it does not fit the ensemble."""
    found = posterior_of(path)
    if design.method != "monte_carlo":
        raise EnsembleError(f"{design.path}: method: {design.method}: expected monte_carlo with --posterior, whose rows are drawn at random")
    table = os.path.join(os.path.dirname(path), found["samples"])
    names, rows = table_of(table)
    if list(found["variables"]) != names:
        raise EnsembleError(f"{table}: columns {', '.join(names)}: expected those of {path}: {', '.join(found['variables'])}")
    for name, column in zip(names, rows.T, strict=True):
        check_column(f"{path}: variables.{name}", found["variables"][name], column, table)
    mine = {one.name: one for one in design.variables.each}
    shared = [name for name in names if name in mine]
    for one in mine.values():
        check_variable(f"{design.path}: variables.{one.name}", one, path, found["variables"])
    if not shared:
        raise EnsembleError(f"{path}: its variables {', '.join(names)} are none of {design.path}: {', '.join(mine)}")
    tied = np.abs(design.variables.root @ design.variables.root.T) > 1e-12
    for name in shared:
        other = next((other for other in mine if other not in shared and tied[list(mine).index(name), list(mine).index(other)]), None)
        if other:
            raise EnsembleError(f"{design.path}: correlation: {name}, {other}: the posterior has {name} alone: expected none between the two")
    warnings = dict(found.get("warnings", {}))
    if found.get("basis") != design.basis:
        warnings[os.path.basename(design.scene)] = f"nothing says that the runs behind {path} are of this scene and its mesh as they are"
    if len(rows) < design.samples:
        warnings[os.path.basename(table)] = f"it has {len(rows)} rows for {design.samples} samples: rows count several times, and intervals are too narrow"
    with open(table, "rb") as file:
        digest = hashlib.sha256(file.read())
    drawn = Drawn(path, rows[:, [names.index(name) for name in shared]], tuple(list(mine).index(name) for name in shared), tuple(name for name in names if name not in mine), design.seed, {name: found["variables"][name] for name in shared}, warnings)
    return replace(design, drawn=drawn, mark=hashlib.sha256(f"{design.mark} {digest.hexdigest()}".encode()).hexdigest()[:16])


def posterior_of(path):
    """Returns what posterior.yaml says; EnsembleError where it is none."""
    found = yaml_of(path, EnsembleError)
    if not isinstance(found, dict) or found.get("format") != FORMAT or not isinstance(found.get("variables"), dict) or not isinstance(found.get("samples"), str):
        raise EnsembleError(f"{path}: expected the posterior.yaml of quoin readings")
    if found.get("version") != 1:
        raise EnsembleError(f"{path}: version: {found.get('version')}: expected 1")
    for name, row in found["variables"].items():
        if not isinstance(row, dict) or not isinstance(row.get("keys"), list) or not all(isinstance(key, str) for key in row["keys"]):
            raise EnsembleError(f"{path}: variables.{name}: {row}: expected its keys, a list of keys of the scene")
        for key in NUMBERS:
            if type(row.get(key)) not in (int, float) or not math.isfinite(row[key]) or (key in SPREADS and row[key] < 0):
                raise EnsembleError(f"{path}: variables.{name}.{key}: {row.get(key)}: expected a number{' >= 0' if key in SPREADS else ''}")
    warnings = found.get("warnings", {})
    if not isinstance(warnings, dict) or not all(isinstance(text, str) for pair in warnings.items() for text in pair):
        raise EnsembleError(f"{path}: warnings: {warnings}: expected names, each with a sentence")
    return found


def check_column(place, row, column, table):
    """Refuses numbers of posterior.yaml that are not those of its samples, as one of the two files has been changed by hand or is another's."""
    spread = column.std()
    for key, value in (("mean", column.mean()), ("sd", spread), *zip(("low", "high"), np.quantile(column, [0.025, 0.975]), strict=True)):
        if abs(row[key] - value) > ROUNDING * abs(value) + 0.01 * spread:
            raise EnsembleError(f"{place}.{key}: {row[key]:g}: expected {value:.6g}, as the samples of {table} have")


def check_variable(place, one, path, known):
    """Refuses a variable of the ensemble that has keys of the posterior under another name or in part, or another distribution than the prior, which would not be before the readings."""
    options = set(map(option, one.keys))
    for name, row in known.items():
        if (name == one.name or options & set(map(option, row["keys"]))) and (name != one.name or tuple(row["keys"]) != one.keys):
            raise EnsembleError(f"{place}: keys {', '.join(one.keys)}: expected variable {name} with those of {path}: {', '.join(row['keys'])}")
    if one.name in known:
        prior = known[one.name]["prior_mean"], known[one.name]["prior_sd"]
        mine = (math.nan, math.nan) if one.has_words() else one.spread()
        if not all(abs(a - b) <= 10 * ROUNDING * max(map(abs, prior)) for a, b in zip(mine, prior, strict=True)):
            raise EnsembleError(f"{place}: {one.words() if one.has_words() else f'mean {mine[0]:.6g}, deviation {mine[1]:.6g}'}: expected the prior of {path}, mean {prior[0]:.6g}, deviation {prior[1]:.6g}")


def table_of(path):
    """Returns (names, rows) of a CSV file of numbers with a line of names."""
    try:
        with open(path, encoding="utf-8-sig") as file:
            first, *lines = file.read().splitlines() or [""]
    except (OSError, ValueError) as error:
        raise EnsembleError(f"{path}: {' '.join(str(error).split())}: expected the samples of a posterior") from error
    names, rows = first.split(","), []
    for k, line in enumerate(lines, 2):
        try:
            rows.append([float(cell) for cell in line.split(",")])
            if len(rows[-1]) != len(names) or not np.isfinite(rows[-1]).all():
                raise ValueError(line)
        except ValueError as error:
            raise EnsembleError(f"{path}: line {k}: {line[:LONGEST]}: expected {len(names)} finite numbers, as there are names") from error
    if not rows:
        raise EnsembleError(f"{path}: no samples: expected a line of names, and a line of numbers for each sample")
    return names, np.array(rows)
