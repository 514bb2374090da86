"""Reads a YAML file of the user's key by key: every mistake is one line with the file, its line, the key, the value and what was expected."""

import csv
import math
import os
import re

import yaml

from quoin_tools.base.scene import Loader, text_of
from quoin_tools.base.units import TABLE, known, number, quantity
from quoin_tools.mesh.blockmesh import NAME, MeshError

REQUIRED = object()
MOST = 100_000  # keys and values
FAR, NEAR = 1e6, 1e-4  # m: no section is larger, no part of one smaller


class DeclaredError(MeshError):
    """The file has mistakes: `faults` has one line for each."""

    def __init__(self, faults):
        super().__init__("\n".join(faults))
        self.faults = list(faults)


def in_order(faults):
    """By their lines in the file."""
    return sorted(faults, key=lambda fault: int(match[1]) if (match := re.search(r":(\d+): ", fault)) else 0)


class Keys:
    """The keys of one mapping of the file. A reader returns the value, or None where it has noted a mistake."""

    def __init__(self, path, place, values, lines, faults):
        self.path, self.place, self.values, self.lines, self.faults, self.used = path, place, values, lines, faults, set()

    def __contains__(self, key):
        return key in self.values

    def fault(self, key, expected, value=None):
        place = (*self.place, *key) if isinstance(key, tuple) else (*self.place, key) if key else self.place
        line = next((self.lines[place[:n]] for n in range(len(place), -1, -1) if place[:n] in self.lines), 1)
        given = "" if value is None else f": {shown(value)}"
        self.faults.append(f"{self.path}:{line}: {'.'.join(map(str, place)) or 'the file'}{given}: {expected}")

    def get(self, key, default=REQUIRED, expected="a value"):
        self.used.add(key)
        value = self.values.get(key)
        if value is None and default is REQUIRED:
            self.fault(None if key not in self.values else key, f"'{key}' is missing, expected {expected}" if key not in self.values else f"expected {expected}")
        return (None if default is REQUIRED else default) if value is None else value

    def number(self, key, default=REQUIRED, above=-math.inf, least=-math.inf, most=math.inf, unit="m"):
        bounds = [f"above {above:g}"] * (above > -math.inf) + [f"at least {least:g}"] * (least > -math.inf) + [f"at most {most:g}"] * (most < math.inf)
        expected = f"a number [{unit}]{' ' if bounds else ''}{' and '.join(bounds)}"
        value = quantity(self.get(key, default, expected), unit)
        if value is None or key not in self.values:
            return value
        if isinstance(value, str) and unit in TABLE:
            return self.fault(key, f"expected {expected}, or with a unit: {known(unit)}", value)
        if not is_number(value) or not (value > above and least <= value <= most):
            return self.fault(key, f"expected {expected}", value)
        if unit == "m" and (abs(value) > FAR or (above == 0 and value < NEAR)):
            return self.fault(key, f"expected {expected}, of the size of a dam or a stone", value)
        return float(value)

    def whole(self, key, default=REQUIRED, least=1):
        value = self.get(key, default, f"a whole number, at least {least}")
        if value is None or key not in self.values:
            return value
        if not is_number(value) or value != int(value) or value < least:
            return self.fault(key, f"expected a whole number, at least {least}", value)
        return int(value)

    def choice(self, key, words, default=REQUIRED):
        value = self.get(key, default, " or ".join(words))
        if value is not None and value not in words:
            return self.fault(key, f"expected {' or '.join(words)}", value)
        return value

    def flag(self, key, default=False):
        value = self.get(key, default)
        return value if isinstance(value, bool) else self.fault(key, "expected true or false", value)

    def text(self, key, default=REQUIRED, expected="a text"):
        value = self.get(key, default, expected)
        return value if value is None or isinstance(value, str) else self.fault(key, f"expected {expected}", value)

    def name(self, key, default=REQUIRED):
        value = self.text(key, default, "a name")
        return self.checked_name(key, value)

    def checked_name(self, key, value):
        if value is not None and not NAME.match(value):
            return self.fault(key, "a name is a letter, then letters, digits, _ or -, at most 63 characters", value)
        return value

    def point(self, key, default=REQUIRED, far=FAR):
        value = self.get(key, default, "a point [x, y]")
        value = in_metres(value) if far == FAR else value  # else it is in units of a drawing
        return value if value is None or is_point(value, far) else self.fault(key, "expected a point [x, y], in m", value)

    def numbers(self, key, expected="a list of numbers"):
        value = in_metres(self.get(key, REQUIRED, expected))
        good = value is None or (isinstance(value, list) and value and all(map(is_number, value)))
        return [float(v) for v in value or []] if good else self.fault(key, f"expected {expected}", value)

    def points(self, key, default=REQUIRED, least=2, leans=1):
        """[(x, y), ...] of a list of points, or of a CSV file with x, y in its rows. A row {to: y, batter: b} leads to an elevation; leans: +1 where
        a face with a batter goes right as it rises, -1 where it goes left."""
        expected = f"a list of at least {least} points [x, y], or a CSV file of them"
        value = self.get(key, default, expected)
        if isinstance(value, str):
            value = self.table(key, value)
        if value is None or key not in self.values:
            return value
        if not isinstance(value, list) or len(value) < least:
            return self.fault(key, f"expected {expected}", value)
        found = []
        for i, row in enumerate(value):
            row = {k: quantity(v, "m") if k == "to" else v for k, v in row.items()} if isinstance(row, dict) else in_metres(row)
            if is_point(row):
                found.append((float(row[0]), float(row[1])))
            elif isinstance(row, dict) and set(row) == {"to", "batter"} and is_point([*row.values()]) and found:
                found.append((found[-1][0] + leans * row["batter"] * (row["to"] - found[-1][1]), float(row["to"])))
            else:
                return self.fault((key, i), "expected [x, y], or behind a point {to: elevation, batter: horizontal per vertical}", row)
        return found

    def table(self, key, name):
        """Reads the rows of a CSV file beside the YAML file; a first row of words is a header."""
        path = os.path.join(os.path.dirname(self.path), name)
        try:
            with open(path, encoding="utf-8-sig", newline="") as file:
                rows = [(i, row) for i, row in enumerate(csv.reader(file), 1) if row and not row[0].lstrip().startswith("#")]
        except (OSError, UnicodeDecodeError) as error:
            return self.fault(key, f"cannot be read ({getattr(error, 'strerror', None) or error})", name)
        found = [(i, [number(cell.strip()) for cell in row]) for i, row in rows]
        if found and not any(map(is_number, found[0][1])):
            found = found[1:]
        bad = next(((i, row) for i, row in found if not is_point(row)), None)
        if bad:
            return self.fault(key, f"its row {bad[0]} is {bad[1]}, expected x, y", name)
        return [row for _, row in found]

    def below(self, key, required=False):
        """Keys of a mapping under this one, or None."""
        value = self.get(key, REQUIRED if required else None, "keys behind it")
        if value is None:
            return None
        if not isinstance(value, dict):
            return self.fault(key, "expected keys behind it", value)
        return Keys(self.path, (*self.place, key), value, self.lines, self.faults)

    def named(self, key, free=False):
        """Returns (name, Keys) of every name under a key; free: names may be anything."""
        below = self.below(key)
        rows = []
        for name in below.values if below else ():
            good, found = name if free else below.checked_name(name, str(name)), below.below(name, required=True)
            if good and found is not None:
                rows.append((good, found))
        return rows

    def one_of(self, *keys):
        """Returns the one of these keys that is given."""
        given = [key for key in keys if key in self.values]
        if len(given) != 1:
            self.used.update(given)
            words = " or ".join(keys)
            return self.fault(given[1] if given else None, f"expected only one of {words}" if given else f"expected {words}")
        return given[0]

    def done(self, *known):
        """Notes keys that no one has asked for; known: keys that are right, though a mistake may have kept them from being asked for."""
        known = self.used.union(known)
        for key in self.values:
            if key not in known:
                self.fault(key, f"unknown key, expected {', '.join(sorted(map(str, known)))}")


def in_metres(value):
    """A list, its numbers with units in m."""
    return [quantity(item, "m") for item in value] if isinstance(value, list) else value


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def is_point(value, far=FAR):
    return isinstance(value, (list, tuple)) and len(value) == 2 and all(is_number(v) and abs(v) <= far for v in value)


def shown(value):
    text = str(value)
    return text if len(text) <= 60 else text[:57] + "..."


def read(path):
    """Keys of the file's top; DeclaredError where it is no YAML mapping."""
    path = os.fspath(path)
    try:
        node = yaml.compose(text_of(path), Loader)
    except (OSError, UnicodeDecodeError) as error:
        raise DeclaredError([f"{path}: {getattr(error, 'strerror', None) or error}"]) from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        reason = getattr(error, "problem", None) or " ".join(str(error).split())
        raise DeclaredError([f"{path}:{mark.line + 1 if mark else 1}: not YAML: {reason}"]) from None
    if not isinstance(node, yaml.MappingNode):
        raise DeclaredError([f"{path}:1: expected keys with their values"])
    lines, faults = {(): 1}, []
    try:
        values = value_of(node, (), lines, faults, path)
    except (RecursionError, yaml.YAMLError) as error:
        mark = getattr(error, "problem_mark", None)
        raise DeclaredError([f"{path}{f':{mark.line + 1}' if mark else ''}: not YAML that can be read: {getattr(error, 'problem', None) or ' '.join(str(error).split())}"]) from None
    return Keys(path, (), values, lines, faults)


def value_of(node, place, lines, faults, path):
    """Python value of a YAML node; the line of every key goes to `lines`."""
    if len(lines) > MOST:
        raise yaml.YAMLError(f"more than {MOST} values")
    lines.setdefault(place, node.start_mark.line + 1)
    if isinstance(node, yaml.MappingNode):
        values = {}
        for key, item in node.value:
            name = key.value if isinstance(key, yaml.ScalarNode) else str(key.start_mark)
            if name in values:
                faults.append(f"{path}:{key.start_mark.line + 1}: {'.'.join(map(str, (*place, name)))}: given twice")
            lines[(*place, name)] = key.start_mark.line + 1
            values[name] = value_of(item, (*place, name), lines, faults, path)
        return values
    if isinstance(node, yaml.SequenceNode):
        return [value_of(item, (*place, i), lines, faults, path) for i, item in enumerate(node.value)]
    return number(Loader("").construct_object(node)) if node.tag.startswith("tag:yaml.org") else number(node.value)
