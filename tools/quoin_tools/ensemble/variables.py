"""Defines random variables: a distribution for a key of the scene, with its cut-offs, or a choice of values, and numbers for it that depend on seed, sample and name alone.

So any sample can be run again by itself, on any number of processes the samples are the same, and one more variable changes no other.
"""

import hashlib
import math
from dataclasses import dataclass

import numpy as np
import scipy

EULER = 0.5772156649015329
EVEN = 4000


class EnsembleError(ValueError):
    """An ensemble is wrong; the message is one line."""


KINDS = {  # distribution: names of its two numbers, others that may stand for the second
    "normal": ("mean", "deviation", "cov"),
    "lognormal": ("mean", "deviation", "cov"),
    "weibull": ("mean", "deviation", "cov"),
    "gumbel": ("mean", "deviation", "cov"),
    "uniform": ("min", "max"),
    "integer": ("min", "max"),
    "choice": ("values", "weights"),
}
COMMON = ("distribution", "min", "max", "of", "keys")


def option(key):
    """Returns the option of the solver that sets a key: a point and an underscore are the same."""
    return "-" + key.replace(".", "_")


@dataclass(frozen=True)
class Variable:
    """One number that sets one or several keys. of: value, or tan: what is distributed is the tangent of the key's angle. low, high: where it is cut off; what is beyond is shared out by the rest."""

    name: str
    kind: str
    shape: object  # frozen distribution of scipy; None: a choice
    low: float = -math.inf
    high: float = math.inf
    of: str = "value"
    keys: tuple = ()  # of the scene that take the value
    choices: tuple = ()  # of a choice: its values, all of them numbers or all of them words
    weights: tuple = ()

    def has_words(self):
        return isinstance(self.choices[0], str) if self.choices else False

    def kept(self, value):
        """Returns the value as rows store it."""
        return str(value) if self.has_words() else float(value)

    def at(self, u):
        """Returns the values of the key at which the distribution, with its cut-offs, reaches u (array)."""
        if self.choices:
            place = np.searchsorted(np.cumsum(self.weights), u, side="right")
            return np.array(self.choices, dtype=object)[np.minimum(place, len(self.choices) - 1)]
        below, above = self.shape.cdf(self.low), self.shape.cdf(self.high)
        value = self.shape.ppf(below + u * (above - below))
        if self.kind == "integer":
            return np.floor(value).astype(int)
        value = np.clip(value, self.low, self.high)  # rounding
        return np.degrees(np.arctan(value)) if self.of == "tan" else value

    def spread(self):
        """Returns (mean, deviation) of the values of the keys, by EVEN quantiles."""
        values = self.at((np.arange(EVEN) + 0.5) / EVEN).astype(float)
        return float(values.mean()), float(values.std())

    def words(self):
        cut = f", cut off at {self.low:g} and {self.high:g}" if self.kind not in ("uniform", "integer") and (math.isfinite(self.low) or math.isfinite(self.high)) else ""
        what = f"tan({self.name})" if self.of == "tan" else self.name
        if self.choices:
            return f"{what}: " + ", ".join(f"{value} ({100 * weight:.4g} %)" for value, weight in zip(self.choices, self.weights, strict=True))
        if self.kind == "integer":
            return f"{what}: whole numbers {self.shape.support()[0]:g} to {self.shape.support()[1] - 1:g}"
        return f"{what}: {self.kind}, mean {self.shape.mean():.6g}, deviation {self.shape.std():.6g}{cut}"


def variable(name, keys):
    """Reads a variable from its keys in the file; EnsembleError where they are not enough, or too many."""
    if not isinstance(keys, dict):
        raise EnsembleError(f"variables.{name}: expected a distribution and its numbers")
    kind = keys.get("distribution")
    if kind not in KINDS:
        raise EnsembleError(f"variables.{name}.distribution: {kind}: expected one of {', '.join(KINDS)}")
    for key, value in keys.items():
        if key not in (*COMMON, *KINDS[kind]):
            raise EnsembleError(f"variables.{name}.{key}: unknown; {kind} has {', '.join(KINDS[kind])}, and {', '.join(COMMON[1:])}")
        if kind == "choice" and key in ("min", "max", "of"):
            raise EnsembleError(f"variables.{name}.{key}: a choice has no {key}: it has values, and weights if you like")
        if key not in ("distribution", "of", "keys", "values", "weights") and (not isinstance(value, (int, float)) or isinstance(value, bool) or not math.isfinite(value)):
            raise EnsembleError(f"variables.{name}.{key}: {value}: expected a number")
    of = keys.get("of", "value")
    if of not in ("value", "tan"):
        raise EnsembleError(f"variables.{name}.of: {of}: expected value or tan")
    given = keys.get("keys", [name])
    if not isinstance(given, list) or not given or not all(isinstance(key, str) for key in given):
        raise EnsembleError(f"variables.{name}.keys: {given}: expected a list of keys of the scene")
    if kind == "choice":
        return Variable(name, kind, None, keys=tuple(given), **chosen(name, keys))
    low, high = keys.get("min", -math.inf), keys.get("max", math.inf)
    if kind in ("uniform", "integer"):
        if not (math.isfinite(low) and math.isfinite(high)):
            raise EnsembleError(f"variables.{name}: {kind} needs min and max")
        if kind == "integer" and (low != int(low) or high != int(high)):
            raise EnsembleError(f"variables.{name}: integer needs whole numbers as min and max")
        shape = scipy.stats.uniform(low, high - low + (kind == "integer"))
        high = high + 1 - 1e-9 if kind == "integer" else high
    else:
        shape = shaped(name, kind, *moments(name, keys))
    if not high > low:
        raise EnsembleError(f"variables.{name}: max {high:g} is not above min {low:g}")
    if not shape.cdf(high) - shape.cdf(low) > 1e-6:
        raise EnsembleError(f"variables.{name}: hardly anything of the distribution lies between min {low:g} and max {high:g}")
    return Variable(name, kind, shape, low, high, of, tuple(given))


def chosen(name, keys):
    """Returns values and weights of a choice."""
    values, weights = keys.get("values"), keys.get("weights")
    if not isinstance(values, list) or len(values) < 2 or not all(isinstance(value, (int, float, str)) and value != "" and str(value).isprintable() for value in values):
        raise EnsembleError(f"variables.{name}.values: {values}: expected a list of two or more numbers or words; what does not scatter is a key of the scene")
    if any(isinstance(value, (str, bool)) for value in values):
        values = [str(value).lower() if isinstance(value, bool) else str(value) for value in values]
    elif not all(math.isfinite(value) for value in values):
        raise EnsembleError(f"variables.{name}.values: {values}: expected finite numbers")
    for value in values:
        if values.count(value) > 1:
            raise EnsembleError(f"variables.{name}.values: {value} is there twice: give it one weight")
    weights = [1 / len(values)] * len(values) if weights is None else weights
    if not isinstance(weights, list) or len(weights) != len(values) or not all(isinstance(one, (int, float)) and not isinstance(one, bool) and 0 < one < math.inf for one in weights):
        raise EnsembleError(f"variables.{name}.weights: {weights}: expected a number above 0 for each of the {len(values)} values")
    if abs(math.fsum(weights) - 1) > 1e-6:
        raise EnsembleError(f"variables.{name}.weights: their sum is {math.fsum(weights):.9g}: expected 1")
    return {"choices": tuple(values), "weights": tuple(weights)}


def moments(name, keys):
    """Returns (mean, standard deviation)."""
    if "mean" not in keys or ("cov" in keys) == ("deviation" in keys):
        raise EnsembleError(f"variables.{name}: expected mean and one of deviation, cov")
    mean = float(keys["mean"])
    deviation = float(keys["deviation"]) if "deviation" in keys else float(keys["cov"]) * abs(mean)
    if not deviation > 0:
        raise EnsembleError(f"variables.{name}: its deviation is {deviation:g}: expected more than 0; what does not scatter is a key of the scene")
    return mean, deviation


def shaped(name, kind, mean, deviation):
    if kind == "normal":
        return scipy.stats.norm(mean, deviation)
    if kind == "gumbel":
        scale = deviation * math.sqrt(6) / math.pi
        return scipy.stats.gumbel_r(mean - EULER * scale, scale)
    if not mean > 0:
        raise EnsembleError(f"variables.{name}: {kind} has a mean above 0, not {mean:g}")
    cov = deviation / mean
    if kind == "lognormal":
        spread = math.sqrt(math.log1p(cov**2))
        return scipy.stats.lognorm(spread, scale=mean * math.exp(-0.5 * spread**2))
    if not 0.01 < cov < 10:
        raise EnsembleError(f"variables.{name}: weibull with a coefficient of variation of {cov:g}: expected 0.01 to 10")
    power = scipy.optimize.brentq(lambda k: math.sqrt(scipy.special.gamma(1 + 2 / k) / scipy.special.gamma(1 + 1 / k) ** 2 - 1) - cov, 0.15, 150)
    return scipy.stats.weibull_min(power, scale=mean / scipy.special.gamma(1 + 1 / power))


# ---- numbers for them --------------------------------------------------------------------------------------


def stream(seed, name, index):
    """Returns a number in (0, 1) for this seed, name and sample, by a counter-based generator (Philox)."""
    key = int.from_bytes(hashlib.sha256(f"{seed}/{name}".encode()).digest()[:16], "little")
    raw = int(np.random.Philox(key=key, counter=int(index)).random_raw())
    return ((raw >> 11) + 0.5) * 2.0**-53


@dataclass(frozen=True)
class Variables:
    """In the order of the file. root: Cholesky's of the correlation of the normal numbers behind them (Gaussian copula); of lognormal ones that of the logarithms."""

    each: tuple
    root: np.ndarray

    def names(self):
        return [one.name for one in self.each]

    def values(self, normal):
        """Returns values of the keys (n, k) from independent normal numbers (n, k)."""
        u = scipy.special.ndtr(np.asarray(normal) @ self.root.T)
        columns = [one.at(u[:, k]).tolist() for k, one in enumerate(self.each)]
        return [list(row) for row in zip(*columns)]


def variables(rows, correlation):
    """Reads the variables from the sections of the file: name to keys; list of [name, name, number]."""
    if not isinstance(rows, dict) or not rows:
        raise EnsembleError("variables: expected at least one, with its distribution")
    each = tuple(variable(str(name), keys) for name, keys in rows.items())
    names, matrix = [one.name for one in each], np.eye(len(each))
    if not isinstance(correlation, (list, type(None))):
        raise EnsembleError(f"correlation: {correlation}: expected rows of two variables and a number")
    for row in correlation or []:
        if not isinstance(row, list) or len(row) != 3 or row[0] not in names or row[1] not in names or row[0] == row[1]:
            raise EnsembleError(f"correlation: {row}: expected two different variables and a number")
        if not isinstance(row[2], (int, float)) or not -1 < row[2] < 1:
            raise EnsembleError(f"correlation: {row[2]}: expected a number between -1 and 1")
        i, j = names.index(row[0]), names.index(row[1])
        matrix[i, j] = matrix[j, i] = float(row[2])
    try:
        return Variables(each, np.linalg.cholesky(matrix))
    except np.linalg.LinAlgError as error:
        raise EnsembleError("correlation: these numbers cannot be together (the matrix is not positive definite)") from error
