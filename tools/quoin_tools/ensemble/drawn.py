"""Takes variables of an ensemble from the posterior that readings have left (posterior.yaml of quoin readings) in place of their distributions.

    design = with_posterior(design.read("ensemble.yaml"), "posterior.yaml")

A sample takes a whole row of the posterior, so that what the readings have tied together stays together. Which row depends on seed and number of the sample alone. Variables that the
readings do not know keep their distributions, and their numbers of the ensemble before the readings.
"""

import hashlib
import os
from dataclasses import dataclass, replace

import numpy as np

from quoin_tools.base.scene import yaml_of
from quoin_tools.ensemble.variables import EnsembleError, stream

FORMAT = "quoin-posterior"


@dataclass(frozen=True)
class Drawn:
    """rows (n, k) of values; places: of the columns among the variables of the ensemble; unused: variables of the posterior that the ensemble has not;
    variables: what posterior.yaml says of those that it has; warnings: {instrument: sentence} of it."""

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
    found = yaml_of(path, EnsembleError)
    if not isinstance(found, dict) or found.get("format") != FORMAT or not isinstance(found.get("variables"), dict) or not isinstance(found.get("samples"), str):
        raise EnsembleError(f"{path}: expected the posterior.yaml of quoin readings")
    if found.get("version") != 1:
        raise EnsembleError(f"{path}: version: {found.get('version')}: expected 1")
    for name, row in found["variables"].items():
        if not isinstance(row, dict) or not isinstance(row.get("keys"), list) or not all(isinstance(key, str) for key in row["keys"]):
            raise EnsembleError(f"{path}: variables.{name}: {row}: expected its keys, a list of keys of the scene")
    warnings = found.get("warnings", {})
    if not isinstance(warnings, dict) or not all(isinstance(text, str) for pair in warnings.items() for text in pair):
        raise EnsembleError(f"{path}: warnings: {warnings}: expected instruments, each with a sentence")
    if design.method != "monte_carlo":
        raise EnsembleError(f"{design.path}: method: {design.method}: expected monte_carlo with --posterior, whose rows are drawn at random")
    table = os.path.join(os.path.dirname(path), found["samples"])
    names, rows = table_of(table)
    keys = {name: tuple(row["keys"]) for name, row in found["variables"].items()}
    if list(keys) != names:
        raise EnsembleError(f"{table}: columns {', '.join(names)}: expected those of {path}: {', '.join(keys)}")
    mine = {one.name: tuple(one.keys) for one in design.variables.each}
    for name in (name for name in names if name in mine and mine[name] != keys[name]):
        raise EnsembleError(f"{design.path}: variables.{name}: keys {', '.join(mine[name])}: expected those of {path}: {', '.join(keys[name])}")
    shared = [name for name in names if name in mine]
    if not shared:
        raise EnsembleError(f"{path}: its variables {', '.join(names)} are none of {design.path}: {', '.join(mine)}")
    tied = np.abs(design.variables.root @ design.variables.root.T) > 1e-12
    for name in shared:
        other = next((other for other in mine if other not in shared and tied[list(mine).index(name), list(mine).index(other)]), None)
        if other:
            raise EnsembleError(f"{design.path}: correlation: {name}, {other}: the posterior has {name} alone: expected none between the two")
    with open(table, "rb") as file:
        digest = hashlib.sha256(file.read())
    drawn = Drawn(path, rows[:, [names.index(name) for name in shared]], tuple(list(mine).index(name) for name in shared), tuple(name for name in names if name not in mine), design.seed, {name: found["variables"][name] for name in shared}, warnings)
    return replace(design, drawn=drawn, mark=hashlib.sha256(f"{design.mark} {digest.hexdigest()}".encode()).hexdigest()[:16])


def table_of(path):
    """Returns (names, rows) of a CSV file of numbers with a line of names."""
    try:
        with open(path, encoding="utf-8") as file:
            names = file.readline().strip().split(",")
            lines = file.readlines()
        rows = np.loadtxt(lines, delimiter=",", ndmin=2) if any(map(str.strip, lines)) else np.zeros((0, len(names)))
    except (OSError, ValueError) as error:
        raise EnsembleError(f"{path}: {' '.join(str(error).split())}: expected the samples of a posterior") from error
    if not len(rows) or rows.shape[1] != len(names) or not np.isfinite(rows).all():
        raise EnsembleError(f"{path}: expected rows of {len(names)} finite numbers")
    return names, rows
