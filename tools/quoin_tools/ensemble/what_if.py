"""Runs the dams of the section what_if of a scene: for each item the scene with some keys changed, by the runner of studies, each into a folder of its own.

    items = run(folder, scene, model, jobs)      folder: of the run; scene: that of the run, with every key in force; model: path of its mesh

An item that has been run is not run again, unless scene, mesh or solver have changed.
"""

import copy
import os
import re
import tempfile
from dataclasses import dataclass, field

import yaml

from quoin_tools.base import solver
from quoin_tools.base.files import write_file
from quoin_tools.base.scene import Loader, Scene, numbers, section
from quoin_tools.ensemble import design, running
from quoin_tools.ensemble.journal import Journal
from quoin_tools.ensemble.models import FALLS, Named, Refused
from quoin_tools.ensemble.variables import EnsembleError

SECTION = "what_if"  # of the scene, and folder of the runs within that of the run
LOST = "lost"
MAY_BE_LOST = ("anchors", "loads")
TIMES = "x "  # before a factor
REFUSED = "refused: "  # before the line of the solver, in the row of an item


@dataclass
class Item:
    """changes: [(path of a key, value as it is, as it was changed to)]; kept: (path, stage) of joints' keys that a stage gives itself, so that the change does not reach it; idle: paths of keys that have this value already; why: the item cannot be run, in a line."""

    name: str
    folder: str = ""
    changes: list = field(default_factory=list)
    kept: list = field(default_factory=list)
    idle: list = field(default_factory=list)
    why: str = ""


def parsed(scene: Scene):
    """Returns (the scene as a mapping, its items: name to {path: value})."""
    data = yaml.load(scene.text, Loader)  # noqa: S506 (a SafeLoader)
    items = section(data.pop(SECTION, None), SECTION, scene.path)
    return data, {name: dict(paths("", keys)) for name, keys in items.items()}


def paths(above, keys):
    """Yields (path, value) of the changes of an item; keys may stand below each other, or with dots."""
    for key, value in keys.items():
        path = f"{above}.{key}" if above else str(key)
        if isinstance(value, dict):
            yield from paths(path, value)
        else:
            yield path, value


def changed(data, name, changes):
    """Returns (the scene of an item, the Item)."""
    other, item = copy.deepcopy(data), Item(name)
    for path, value in changes.items():
        where = f"{SECTION}.{name}.{path}"
        *above, key = path.split(".")
        rows = other
        for one in above:
            rows = rows.get(one) if isinstance(rows, dict) else None
        if not isinstance(rows, dict):
            raise EnsembleError(f"{where}: the scene has no {'.'.join(above)}")
        was = rows.get(key)
        if value == LOST:
            lose(other, where, above, key)
            item.changes.append((path, "", LOST))
            continue
        if isinstance(was, dict):
            raise EnsembleError(f"{where}: {value}: expected keys below it, or {LOST} for one of the {' or '.join(MAY_BE_LOST)}")
        now = times(where, value, was) if isinstance(value, str) and value.startswith(TIMES) else value
        item.changes.append((path, words(was), words(now)))
        item.idle += [path] if numbers(now) == numbers(was) else []
        item.kept += [(path, stage) for stage, keys in (other.get("stages") or {}).items() if above[:1] == ["joints"] and key in ((keys.get("joints") or {}).get(above[1]) or {})]
        rows[key] = now
    return other, item


def times(where, value, was):
    """Returns a number of the scene, or each of a list, times the factor of a change."""
    try:
        factor = float(value.removeprefix(TIMES))
    except ValueError as error:
        raise EnsembleError(f"{where}: {value}: expected x and a factor, such as x 0.5") from error
    before = numbers(was)
    if isinstance(before, list) and before and all(isinstance(one, (int, float)) for one in before):
        return [factor * one for one in before]
    if not isinstance(before, (int, float)) or isinstance(before, bool):
        raise EnsembleError(f"{where}: {value}: the scene has no number there that a factor may change" + (f": {words(was)}" if was is not None else ""))
    return factor * before


def lose(data, where, above, name):
    """Takes an anchor or a load out of the scene, and out of the lists of its stages."""
    if above not in ([one] for one in MAY_BE_LOST) or name not in data[above[0]]:
        raise EnsembleError(f"{where}: {LOST}: expected one of the {' or '.join(MAY_BE_LOST)} of the scene")
    del data[above[0]][name]
    for keys in data["stages"].values():
        for key, value in list((keys or {}).items()):
            if isinstance(value, list) and name in value:
                keys[key] = [one for one in value if one != name]
                if not keys[key] and key != "loads":
                    del keys[key]


def words(value):
    """A value of the scene as people write it."""
    if isinstance(value, list):
        return "[" + ", ".join(map(words, value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    value = numbers(value)
    return f"{value:.6g}" if isinstance(value, float) else "none" if value is None else str(value)


class Dams(Named):
    """Runs each item, by its own scene, into a folder with its number."""

    def words(self, values, level, output, mesh=""):
        return solver.command(["-options_file", scene_of(self.folder, values[0]), "-model", self.design.model, "-output", output])

    def judge(self, values, sample, level):
        try:
            return super().judge(values, sample, level)
        except Refused as error:
            return ("fails", None, FALLS) if FALLS in str(error) else ("undecided", None, REFUSED + without_place(str(error).partition(": ")[2]))


def without_place(line):
    """A line of the solver without its name and the line of the file, which is one that nobody has written."""
    return re.sub(r"^(quoin: )?(error: )?(\S+\.yaml:(\d+: )?)?", "", line)


def scene_of(folder, name):
    return os.path.join(folder, f"{name}.yaml")


def run(folder, scene, model, jobs):
    """Returns the items, each with the folder of its run, or with why it cannot be run."""
    above = os.path.join(folder, SECTION)
    os.makedirs(above, exist_ok=True)
    found = written(scene, above)
    right = [item for item in found if not item.why]
    if not right:
        return found
    wanted = design.of_values(scene.path, {SECTION: [item.name for item in right]}, [], 1)
    wanted.model = model
    journal = Journal(above, wanted)
    running.forget_others(journal, lambda row: row.why.startswith(REFUSED) or os.path.isfile(os.path.join(above, str(row.sample + 1), "summary.json")))
    with solver.stopping():
        rows = running.run(wanted, above, jobs, judge=Dams)
    for number, item in enumerate(right):
        item.folder = os.path.join(above, str(number + 1))
        item.why = rows[number, None].why.removeprefix(REFUSED) if rows[number, None].why.startswith(REFUSED) else ""
    return found


def written(scene, folder):
    """Writes the scene of each item into a folder. Returns the items; one whose changes cannot be made has no scene, and says why."""
    data, items = parsed(scene)
    found = []
    for name, changes in items.items():
        try:
            other, item = changed(data, name, changes)
            write_file(scene_of(folder, name), yaml.safe_dump(other, sort_keys=False, allow_unicode=True, width=1000))
        except EnsembleError as error:
            item = Item(name, why=str(error))
        found.append(item)
    return found


def complaints(scene, model):
    """Returns a line for each item that cannot be run: wrong changes, or a scene that the solver refuses. model: path of the mesh."""
    with tempfile.TemporaryDirectory() as folder:
        for item in written(scene, folder):
            if not item.why:
                try:
                    solver.settled(scene_of(folder, item.name), ["-model", model])
                except solver.SolverError as error:
                    item.why = f"{SECTION}.{item.name}: {without_place(str(error))}"
            if item.why:
                yield item.why
