"""Reads an ensemble from its file (docs/ensembles.md): scene, variables, samples, the condition of failure, levels."""

import hashlib
import itertools
import json
import math
import os
import re
from dataclasses import dataclass, field

import numpy as np
import yaml

from quoin_tools.base import solver
from quoin_tools.base.scene import Loader, find, yaml_of
from quoin_tools.ensemble.drawn import Drawn
from quoin_tools.ensemble.sampling import BLOCK, METHODS
from quoin_tools.ensemble.variables import EnsembleError, Variable, Variables, option, variables

KEYS = ("scene", "model", "mesh", "options", "variables", "correlation", "samples", "seed", "method", "block", "judge", "stage", "raises", "fail", "response", "levels", "stop", "time_limit", "start")
JUDGES = ("solver", "limit")
STARTS = ("shared", "nearest")
MAKERS = ("voronoi", "dam", "walls")  # commands of quoin that make a mesh
FILES = ("model", "file", "levels", "history", "points", "motion")  # last parts of keys that name files; a motion may be one of the scene
MOST = 1e9  # [s]: timers take no longer times
CONDITION = re.compile(r"\s*([A-Za-z_][\w+.-]*|abs\([A-Za-z_][\w+.-]*\))\s*(<=|>=|<|>)\s*(\S+)\s*$")


@dataclass(frozen=True)
class Condition:
    """A condition: a number of a run below or above a value. path: of summary.json within the stage; `limit`: of limit analysis."""

    path: str
    sign: str
    value: float

    def holds(self, number):
        return {"<": number < self.value, "<=": number <= self.value, ">": number > self.value, ">=": number >= self.value}[self.sign]

    def words(self):
        return f"{self.path} {self.sign} {self.value:g}"

    def margin(self, number):
        """Returns the distance to the condition; above 0 where it does not hold."""
        return number - self.value if self.sign[0] == "<" else self.value - number


@dataclass
class Design:
    """level_keys: keys of the scene that all take the value of a level. condition None: collapse alone is failure."""

    path: str
    scene: str
    model: str
    mesh: list  # words of the command that makes the mesh of a sample; {name}: the value of the variable that sets mesh.name
    options: list
    variables: Variables
    samples: int
    seed: int
    method: str
    block: int | None
    judge: str
    stage: str | None
    raises: list | None
    condition: Condition | None
    response: str | None
    level_keys: list = field(default_factory=list)
    levels: list = field(default_factory=lambda: [None])
    half_width: float | None = None
    batch: int = 50
    time_limit: float | None = None
    start: str = "shared"  # start of the samples of a process: its initial state, or the nearest of some that are solved first
    files: dict = field(default_factory=dict)  # (key, value of a choice): path of the file that it names
    mark: str = ""  # of all that a sample depends on
    basis: str = ""  # of scene, mesh, and the files that the scene names
    ranks: int = 1  # of the solver
    drawn: Drawn | None = None  # values of some variables by a posterior

    def columns(self):
        return self.variables.names()

    def words(self):
        """Says what each variable is: its distribution, or what a posterior has of it."""
        return [self.drawn.words(k, one.name) if self.drawn and k in self.drawn.places else one.words() for k, one in enumerate(self.variables.each)]

    def block_size(self):
        """Returns the number of samples that count together."""
        return len(self.columns()) + 2 if self.method == "sobol_indices" else self.block or BLOCK.get(self.method, 1)


def read(path):
    data = yaml_of(path, EnsembleError)
    if not isinstance(data, dict):
        raise EnsembleError(f"{path}: expected an ensemble, a file with the keys {', '.join(KEYS)}")
    try:
        return made(data, path)
    except EnsembleError as error:
        raise EnsembleError(f"{path}: {error}") from error


def made(data, path):
    for key in data:
        if key not in KEYS:
            raise EnsembleError(f"{key}: unknown key; there are {', '.join(KEYS)}")
    scene = beside(path, needed(data, "scene", str))
    if not os.path.isfile(scene):
        raise EnsembleError(f"scene: {scene}: no such file")
    found = variables(data.get("variables"), data.get("correlation"))
    judge, method = one_of(data, "judge", JUDGES, "solver"), one_of(data, "method", METHODS, "monte_carlo")
    condition = condition_of(data.get("fail", "collapsed"), judge)
    stop = data.get("stop") or {}
    if not isinstance(stop, dict) or set(stop) - {"half_width", "batch"}:
        raise EnsembleError("stop: expected half_width and, if you like, batch")
    levels, keys = levels_of(data.get("levels"))
    settled = [key for one in found.each for key in one.keys] + keys
    options_set = [option(key) for key in settled]
    for name in settled:
        if options_set.count(option(name)) > 1:
            raise EnsembleError(f"{name} is set twice, by variables or levels")
    if "model" in settled and data.get("model"):
        raise EnsembleError("model is set twice, by variables and by the key model")
    options = data.get("options") or []
    if not isinstance(options, list):
        raise EnsembleError("options: expected a list of words for the solver, such as [-stages, sw]")
    for key in ("stage", "response"):
        if not isinstance(data.get(key), (str, type(None))):
            raise EnsembleError(f"{key}: {data[key]}: expected {'the name of a stage' if key == 'stage' else 'a number of a stage by its path, such as joints.base.sliding_factor_peak'}")
    response = data.get("response") or (condition.path if condition else None)
    if method == "importance" and (condition is None or len(levels) > 1):
        raise EnsembleError("method: importance needs a number that fails (fail: ... < ...), not collapse alone, and one level")
    design = Design(path, scene, beside(path, str(data["model"])) if data.get("model") else "", mesh_of(data, found), [str(word) for word in options], found, whole(data, "samples", 1), whole(data, "seed", 0, 0),
                    method, whole(data, "block", 2, None), judge, data.get("stage"), raises_of(data, judge), condition, response, keys, levels, number(stop, "half_width"), whole(stop, "batch", 1, 50),
                    number(data, "time_limit"), one_of(data, "start", STARTS, "shared"), files_of(found, path))  # fmt: skip
    if design.start == "nearest" and (judge == "limit" or design.mesh):
        raise EnsembleError(f"start: nearest: samples {'of limit analysis' if judge == 'limit' else 'with a mesh each'} have nothing to start from")
    choices = [one.name for one in found.each if one.choices]
    if method == "importance" and choices:
        raise EnsembleError(f"method: importance: {choices[0]} is a choice, along which there is no design point: take an ensemble for each of its values, and add up by their weights")
    if method == "sobol_indices" and response is None:
        raise EnsembleError("method: sobol_indices needs a number (response: joints.base.sliding_factor_peak, or fail: ... < ...), not stands or falls")
    if method == "sobol_indices" and (design.block or design.half_width):
        raise EnsembleError("method: sobol_indices has no block and no stop")
    design.mark = mark_of(design, data)
    design.basis = checksum(files_behind(design), hashlib.sha256())
    return design


def of_values(scene, varied, options, ranks):
    """Returns the design of a study: all combinations of the values (words) of some keys. Its mark has the solver too, since nobody says that it has changed."""
    found = Variables(tuple(Variable(name, "choice", None, keys=(name,), choices=tuple(values)) for name, values in varied.items()), np.eye(len(varied)))
    samples = math.prod(len(values) for values in varied.values())
    design = Design("", scene, "", [], options, found, samples, 0, "all", None, "solver", None, None, None, None, ranks=ranks)
    design.files = {("", path): path for path in files_among(itertools.chain(*varied.values()), scene)}
    design.mark = mark_of(design, {"varied": list(varied.items()), "options": options, "ranks": ranks, "solver": os.stat(solver.find()).st_mtime_ns})
    return design


def beside(path, name):
    return name if os.path.isabs(name) else os.path.join(os.path.dirname(path), name)


def files_of(found, path):
    """Returns {(key, value): path} of choices that name files: beside the ensemble, or from the working directory."""
    files = {}
    for one in found.each:
        for key in (key for key in one.keys if key.split(".")[-1] in FILES):
            for value in map(str, one.choices):
                there = next((name for name in (beside(path, value), value) if os.path.isfile(name)), None)
                if there:
                    files[key, value] = there
                elif not key.endswith(".motion"):
                    raise EnsembleError(f"variables.{one.name}.values: {value}: no such file, neither beside the ensemble nor in the working directory")
    return files


def files_among(words, scene):
    """Returns the paths of the words that name files: from the working directory, or beside the scene, as the solver looks for a mesh."""
    found = (next(filter(os.path.isfile, (word, beside(scene, word))), None) for word in words)
    return [path for path in found if path]


def needed(data, key, kind):
    if not isinstance(data.get(key), kind):
        raise EnsembleError(f"{key}: {data.get(key)}: expected {'a path' if kind is str else kind.__name__}")
    return data[key]


def one_of(data, key, allowed, default):
    value = data.get(key, default)
    if value not in allowed:
        raise EnsembleError(f"{key}: {value}: expected one of {', '.join(allowed)}")
    return value


def whole(data, key, least, *default):
    value = data.get(key, *default) if default else data.get(key)
    if value is None and default:
        return None
    if not isinstance(value, int) or isinstance(value, bool) or not least <= value < 2**63:  # samples.h5 stores it in 64 bits
        raise EnsembleError(f"{key}: {value}: expected a whole number >= {least}" + (" and < 2^63" if isinstance(value, int) and value > least else ""))
    return value


def number(data, key):
    value = data.get(key)
    if value is not None and (not isinstance(value, (int, float)) or isinstance(value, bool) or not 0 < value <= MOST):
        raise EnsembleError(f"{key}: {value}: expected a number > 0 and <= {MOST:g}; without the key there is no limit")
    return None if value is None else float(value)


def condition_of(text, judge):
    if text == "collapsed":
        if judge == "limit":
            raise EnsembleError("fail: limit analysis does not collapse: expected a condition such as limit < 1")
        return None
    match = CONDITION.match(str(text))
    try:
        value = float(match[3])
        if not math.isfinite(value):
            raise ValueError(value)
    except (TypeError, ValueError) as error:
        raise EnsembleError(f"fail: {text}: expected collapsed, or a condition such as joints.base.sliding_factor_peak < 1.2") from error
    if judge == "limit" and match[1] != "limit":
        raise EnsembleError(f"fail: {match[1]}: limit analysis gives `limit` only")
    return Condition(match[1], match[2], value)


def mesh_of(data, found):
    words = data.get("mesh") or []
    if not isinstance(words, list) or (words and words[0] not in MAKERS):
        raise EnsembleError(f"mesh: expected words of a command that makes a mesh ({', '.join(MAKERS)}), such as [voronoi, --seed, '{{seed}}']")
    if words and data.get("model"):
        raise EnsembleError("mesh: with model, too; one of them makes the mesh")
    words = [str(word) for word in words]
    wanted = {name for word in words for name in re.findall(r"{(\w+)}", word)}
    there = {key.partition(".")[2] for one in found.each for key in one.keys if key.startswith("mesh.")}
    if wanted != there:
        raise EnsembleError(f"mesh: {{{'}, {'.join(sorted(wanted ^ there))}}}: expected each mesh.<name> of the variables in the words of mesh, and the other way round")
    return words


def raises_of(data, judge):
    raises = data.get("raises")
    if raises is not None and (judge != "limit" or not isinstance(raises, list) or not raises):
        raise EnsembleError("raises: expected a list of loads that limit analysis multiplies (judge: limit)")
    return raises


def levels_of(data):
    """Returns (values, keys that take them)."""
    if data is None:
        return [None], []
    if not isinstance(data, dict) or set(data) != {"keys", "values"}:
        raise EnsembleError("levels: expected keys (of the scene) and values")
    keys = [data["keys"]] if isinstance(data["keys"], str) else data["keys"]
    values = data["values"]
    if not isinstance(keys, list) or not keys or not all(isinstance(key, str) for key in keys):
        raise EnsembleError("levels.keys: expected names of keys of the scene")
    if not isinstance(values, list) or not values or not all(isinstance(value, (int, float)) and math.isfinite(value) for value in values):
        raise EnsembleError("levels.values: expected numbers")
    if sorted(set(values)) != values:
        raise EnsembleError("levels.values: expected numbers that rise, each once")
    return [float(value) for value in values], keys


def mark_of(design, data):
    """Returns a checksum of all on which samples depend: the file without the number of samples, scene, mesh, records, files of options. Levels count by their keys: their values are in the rows."""
    kept = {key: value for key, value in data.items() if key not in ("samples", "stop", "levels", "time_limit", "scene", "model")}
    kept |= {"level_keys": design.level_keys} if design.level_keys else {}
    digest = hashlib.sha256(json.dumps(kept, sort_keys=True, default=str).encode())
    return checksum([*files_behind(design), *files_among(design.options, design.scene), *design.files.values()], digest)


def checksum(paths, digest):
    """Returns the checksum with the files added."""
    for path in paths:
        with open(path, "rb") as file:
            digest.update(file.read())
    return digest.hexdigest()[:16]


def files_behind(design):
    """Returns the paths of scene, mesh, records and tables that are there."""
    mesh, others = named_in(design.scene)
    return [path for path in (design.scene, design.model or mesh, *others) if path and os.path.isfile(path)]


def named_in(path):
    """Returns (path of the mesh that a scene names, paths of its records and tables); None, none where they are not there."""
    try:
        with open(path, encoding="utf-8") as file:
            data = yaml.load(file, Loader)  # noqa: S506 (a SafeLoader)
    except (yaml.YAMLError, ValueError, RecursionError):  # the solver says what is wrong
        return None, []
    if not isinstance(data, dict):
        return None, []
    rows = [row for name in ("motions", "supports", "loads") for row in (data[name].values() if isinstance(data.get(name), dict) else ())]
    named = [row[key] for row in rows if isinstance(row, dict) for key in FILES if isinstance(row.get(key), str)]
    return find(os.path.dirname(os.path.abspath(path)), data.get("model")), [name for name in named if os.path.isfile(name)]
