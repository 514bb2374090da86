"""Reads a scene (docs/scene.md) for Python tools: sections as dictionaries, numbers as numbers, joints stage by stage.

The solver checks scenes and completes them: tools read the scene that a run leaves in its output folder, or that solver.settled returns, with every
key in force.
"""

import itertools
import os
import stat
from dataclasses import dataclass, field

import yaml

from quoin_tools.base import joints
from quoin_tools.base.units import number, quantity

ECHO = "scene_echo.yaml"  # every key in force, written by the solver into the output folder


MOST_VALUES = 40000  # the solver takes as many
MOST_NODES = 100_000  # keys and values of any file
DEEPEST = 100
MOST_DIGITS = 200  # of a whole number
MOST_BYTES = 1 << 24  # the solver takes as many


class SceneError(ValueError):
    """A scene file is wrong; the message is one line."""


class Loader(yaml.SafeLoader):
    """A YAML loader without merge keys, which the solver does not know: nested, they double the text each time. It refuses a text that is too deep or long as it reads."""

    def __init__(self, stream):
        super().__init__(stream)
        self.nodes, self.depth = 0, 0

    def flatten_mapping(self, node):
        pass

    def compose_node(self, parent, index):
        mark = self.peek_event().start_mark
        self.nodes += 1
        self.depth += 1
        if self.nodes > MOST_NODES:
            raise yaml.composer.ComposerError(None, None, f"more than {MOST_NODES} keys and values", mark)
        if self.depth > DEEPEST:
            raise yaml.composer.ComposerError(None, None, f"nested more than {DEEPEST} deep", mark)
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node

    def construct_object(self, node, deep=False):
        """Any scalar that looks like a number or a date and is none ends PyYAML in its own way."""
        if isinstance(node, yaml.ScalarNode) and node.tag.endswith(":int") and len(node.value) > MOST_DIGITS:
            raise yaml.constructor.ConstructorError(None, None, f"a number of {len(node.value)} digits, expected at most {MOST_DIGITS}", node.start_mark)
        try:
            return super().construct_object(node, deep)
        except (ValueError, ArithmeticError, AttributeError, LookupError, TypeError) as error:
            if isinstance(error, yaml.YAMLError) or not isinstance(node, yaml.ScalarNode):
                raise
            shown = node.value if len(node.value) < 60 else node.value[:57] + "..."
            raise yaml.constructor.ConstructorError(None, None, f"'{shown}' is no value ({' '.join(str(error).split())})", node.start_mark) from None


def text_of(path):
    """Reads a file that people write; OSError or UnicodeDecodeError say why it cannot."""
    status = os.stat(path)
    if stat.S_ISCHR(status.st_mode) or stat.S_ISBLK(status.st_mode) or status.st_size > MOST_BYTES:
        raise OSError(None, f"not a file of up to {MOST_BYTES} bytes", os.fspath(path))
    with open(path, encoding="utf-8") as file:
        return file.read(MOST_BYTES)


def values_of(text):
    """Returns what a YAML text says, with numbers as the solver reads them."""
    return numbers(yaml.load(text, Loader))  # noqa: S506 (a SafeLoader)


def yaml_of(path, refusal, values=values_of):
    """Returns what a YAML file says; raises a refusal, one line with its path, where it cannot be read. values: function of the text."""
    try:
        return values(text_of(path))
    except (OSError, yaml.YAMLError, ArithmeticError, LookupError, RecursionError, TypeError, ValueError) as error:
        raise refusal(f"{path}: {getattr(error, 'strerror', None) or ' '.join(str(error).split())}") from error


@dataclass
class Scene:
    """A scene. text: the file as it is; sections map names to their keys."""

    path: str
    text: str
    title: str = ""
    model: str = ""
    output: str = "out"
    thickness: float = 1.0
    gravity: float = 9.81
    contact: dict = field(default_factory=dict)
    materials: dict = field(default_factory=dict)
    joints: dict = field(default_factory=dict)
    motions: dict = field(default_factory=dict)
    supports: dict = field(default_factory=dict)
    loads: dict = field(default_factory=dict)
    anchors: dict = field(default_factory=dict)
    stages: dict = field(default_factory=dict)
    trials: dict = field(default_factory=dict)  # stage: its trials of summary.json, or its steps, of a run
    guidelines: str = ""  # file of the user with limits of guidelines

    def condition(self, stage):
        """As what the scene wants a stage judged; None: it does not say."""
        given = self.stages.get(stage, {}).get("condition", "auto")
        return None if given == "auto" else given

    def stage_loads(self, stage):
        """Returns the loads that act at the end of a stage: name to keys. A flood or load factor has the loads of its last stable trial, a transient stage those of its last step."""
        if stage not in self.stages:
            raise SceneError(f"{self.path}: no stage '{stage}', there are: {', '.join(self.stages)}")
        names = self.stages[stage].get("loads") or []
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise SceneError(f"{self.path}: stages.{stage}.loads: expected a list of names")
        missing = [name for name in names if name not in self.loads]
        if missing:
            raise SceneError(f"{self.path}: stages.{stage}.loads: no load named '{missing[0]}', there are: {', '.join(self.loads)}")
        loads = {name: with_partial_factor(self.loads[name]) for name in names}
        found = self.trials.get(stage, {})
        if "steps" not in found and (found.get("stable") is None or "what" in found or "forces" in found):
            return loads
        if "raises" in found:
            return {name: factored(load, found["stable"]) if name in found["raises"] else load for name, load in loads.items()}
        last = found["steps"][-1:] if "steps" in found else [t for t in found["trials"] if t["value"] == found["stable"]]
        waters = next((t["waters"] for t in last if "waters" in t), None)
        if waters is None:
            raise SceneError(f"{self.path}: stage '{stage}': the run, of an older Quoin, does not say which waters its flood has raised")
        return {name: raised(load, waters[name]) if name in waters else load for name, load in loads.items()}

    def strength_factors(self, stage):
        """Returns the partial factors of a stage on friction and on cohesion."""
        keys = self.stages.get(stage, {})
        return tuple(float(keys.get(key, 1)) for key in ("friction_factor", "cohesion_factor"))

    def is_design(self, stage):
        """Tells whether a stage has partial factors: on the strengths of joints, or on one of its loads."""
        return self.strength_factors(stage) != (1, 1) or any(self.loads.get(name, {}).get("partial_factor", 1) != 1 for name in self.stages.get(stage, {}).get("loads") or ())

    def stages_before(self, stage):
        """Returns the stages before a stage, the first one first: each starts from the stage before it in the scene, or from the stage of its key `from`."""
        names, chain = list(self.stages), []
        if stage not in self.stages:
            raise SceneError(f"{self.path}: no stage '{stage}', there are: {', '.join(self.stages)}")
        while at := names.index(stage):
            named = self.stages[stage].get("from")
            if named is not None and named not in names[:at]:
                raise SceneError(f"{self.path}: stages.{stage}.from: no stage named '{named}' before it")
            stage = names[at - 1] if named is None else named
            chain.insert(0, stage)
        return chain

    def placed(self, stage):
        """Returns the groups that a stage places as it begins."""
        names = self.stages.get(stage, {}).get("build") or []
        return [names] if isinstance(names, str) else [str(name) for name in names]

    def absent(self, stage):
        """Returns the groups that are not there in a stage: some stage places them, but neither this one nor those before it."""
        there = {name for one in [*self.stages_before(stage), stage] for name in self.placed(one)}
        return {name for one in self.stages for name in self.placed(one)} - there

    def joint(self, name, stage):
        """Keys of a joint in a stage, completed by `default` and the defaults of the table, divided by the partial factors of the stage. Of a strength
        reduction, with the strengths of its last stable trial; of a search for the force of anchors, divided by what is required."""
        own = dict(self.joints.get(name, {}))
        base = dict(self.joints.get("default", {}))
        for other in [*self.stages_before(stage), stage]:
            changes = section(self.stages[other].get("joints"), f"stages.{other}.joints", self.path)
            own |= changes.get(name, {})
            base |= changes.get("default", {})
        keys = joints.divided(joints.completed(base | own), *self.strength_factors(stage))
        found, only = self.trials.get(stage, {}), self.stages[stage].get("reduce")
        only = [only] if isinstance(only, str) else only
        what, value = ("strengths", 1 / found["required"]) if "forces" in found else (found.get("what"), found.get("stable"))
        if value is None or what is None or (only and name not in only):
            return keys
        return joints.reduced(keys, what, value)


def raised(load, water):
    """Returns a load of water with the levels of a trial. drain_level: the level by which the pressure at the drain stays."""
    higher = load | {key: level for key, level in water.items() if level is not None}
    return higher | {"drain_level": float(load["level"])} if load.get("raise") == "to_drain" else higher


SUMMED_HERE = ("self_weight", "pseudo_static", "point_force")  # types of loads whose forces Python sums from their keys


def with_partial_factor(load):
    """Returns a load that Python sums with its partial factor in its numbers; of other loads the solver has the forces, and is asked with the factor."""
    factor = float(load.get("partial_factor", 1))
    return load if factor == 1 or load.get("type") not in SUMMED_HERE else factored(load, factor) | {"partial_factor": 1}


def factored(load, factor):
    """Returns a load with its force multiplied by a load factor. Other keys than these stay: the forces come from the run."""
    if load.get("type") == "self_weight":
        return load | {"coefficient": [factor * x for x in load.get("coefficient", (0.0, -1.0))]}
    if load.get("type") == "temperature":
        return load | {key: factor * float(load[key]) for key in ("change", "mean", "amplitude") if key in load}
    single = {"ice": "force", "pressure": "pressure"}.get(load.get("type"))
    if single:
        return load | {single: factor * float(load[single])}
    pairs = {key: [factor * value for value in load[key]] for key in ("coefficient", "value") if key in load}
    return load | (pairs or {key: factor * float(load[key]) for key in ("density",) if key in load})


def numbers(value, seen=None):
    """Converts numbers throughout lists and mappings; aliases can make a short text long, or a circle."""
    seen = itertools.count() if seen is None else seen
    if next(seen) > MOST_VALUES:
        raise ValueError(f"more than {MOST_VALUES} values")
    if isinstance(value, dict):
        return {str(key): numbers(item, seen) for key, item in value.items()}
    if isinstance(value, list):
        return [numbers(item, seen) for item in value]
    return number(value)


def section(value, name, path):
    """Reads a mapping, or a list of one-key mappings."""
    if value is None:
        return {}
    if isinstance(value, list):
        if not all(isinstance(row, dict) and len(row) == 1 for row in value):
            raise SceneError(f"{path}: {name}: expected one name per row")
        value = {key: keys for row in value for key, keys in row.items()}
    if not isinstance(value, dict):
        raise SceneError(f"{path}: {name}: expected names with their keys")
    rows = {str(key): keys or {} for key, keys in value.items()}
    if not all(isinstance(keys, dict) for keys in rows.values()):
        raise SceneError(f"{path}: {name}: expected keys behind each name")
    return rows


def parse(text, path):
    try:
        data = values_of(text)
    except (yaml.YAMLError, ArithmeticError, LookupError, RecursionError, TypeError, ValueError) as error:
        raise SceneError(f"{path}: {' '.join(str(error).split())}") from error
    if not isinstance(data, dict):
        raise SceneError(f"{path}: not a scene")
    names = ("materials", "joints", "motions", "supports", "loads", "anchors", "stages")
    sections = {name: section(data.get(name), name, path) for name in names}
    scalars = {name: quantity(data.get(name, value), unit) for name, value, unit in (("thickness", 1.0, "m"), ("gravity", 9.81, "m/s2"))}
    for name, value in scalars.items():
        if not isinstance(value, (int, float)):
            raise SceneError(f"{path}: {name}: expected a number")
    contact = data.get("contact") if isinstance(data.get("contact"), dict) else {}
    return Scene(path, text, str(data.get("title") or ""), str(data.get("model") or ""), str(data.get("output") or "out"), guidelines=str(data.get("guidelines") or ""), **scalars, contact=contact, **sections)


def read(path):
    try:
        return parse(text_of(path), os.fspath(path))
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(f"{path}: {getattr(error, 'strerror', None) or error}") from error


def find(folder, named, extra=()):
    """Finds a file of a run: in its output folder under one of the extra names, as named, or as named beside the folder."""
    folder = os.path.abspath(folder)
    candidates = [os.path.join(folder, name) for name in extra]
    if named:
        candidates.append(os.path.abspath(named))
        parents = [folder]
        while os.path.dirname(parents[-1]) != parents[-1]:
            parents.append(os.path.dirname(parents[-1]))
        candidates += [os.path.join(parent, named) for parent in parents]
        candidates.append(os.path.join(folder, os.path.basename(named)))
    for path in candidates:
        if os.path.isfile(path):
            return path
    return None


def of_run(folder, summary):
    """Reads the scene of a run."""
    if not os.path.isfile(path := os.path.join(folder, ECHO)):
        raise SceneError(f"{folder}: no {ECHO} there, the scene of the run with every key in force")
    used = read(path)
    used.trials = {s["name"]: found for s in summary["stages"] if (found := s.get("strength_reduction") or s.get("flood") or s.get("load_factor") or s.get("anchor_force"))}
    used.trials |= {s["name"]: {"steps": s["steps"]} for s in summary["stages"] if s.get("steps")}
    return used
