"""Reads records in time as the solver does (docs/reference/motions.md): tables of t and one or two components, and files of PEER (AT2, VT2).

Between its rows a record is linear; what is said of it is exact for that.
"""

import os
import re
from dataclasses import dataclass

import numpy as np

STANDARD = 9.80665  # [m/s2] of files in units of g
UNITS = {"G": STANDARD, "CM/S/S": 0.01, "CM/SEC/SEC": 0.01, "CM/S2": 0.01, "CM/S**2": 0.01, "CM/SEC**2": 0.01, "GAL": 0.01, "M/S2": 1.0, "M/S/S": 1.0}
SPEEDS = {"CM/S": 0.01, "CM/SEC": 0.01, "M/S": 1.0}
SECONDS = {"": 1.0, "S": 1.0, "SEC": 1.0, "SECS": 1.0, "SECOND": 1.0, "SECONDS": 1.0, "MS": 1e-3, "MSEC": 1e-3, "MILLISECONDS": 1e-3}
HEAD = 10  # lines, at most, of a file of PEER


class RecordError(ValueError):
    """A record is wrong; the message is one line."""


@dataclass
class Record:
    """Accelerations [m/s2] at times [s]; two at the same time are a step. It begins at rest."""

    name: str
    t: np.ndarray
    a: np.ndarray

    def __post_init__(self):
        h = np.diff(self.t)
        self.v = np.concatenate([[0.0], np.cumsum(h * (self.a[1:] + self.a[:-1]) / 2)])
        self.u = np.concatenate([[0.0], np.cumsum(h * (self.v[:-1] + h * (2 * self.a[:-1] + self.a[1:]) / 6))])

    @property
    def pga(self):
        return np.abs(self.a).max()

    @property
    def pgv(self):
        """[m/s] Largest velocity at rows, and between them where the acceleration is 0."""
        a, h = self.a, np.diff(self.t)
        turns = np.flatnonzero(a[:-1] * a[1:] < 0)
        part = a[turns] / (a[turns] - a[turns + 1])
        return max(np.abs(self.v).max(), np.abs(self.v[turns] + a[turns] * part * h[turns] / 2).max(initial=0.0))

    @property
    def pgd(self):
        """[m] Largest displacement at rows."""
        return np.abs(self.u).max()

    def arias(self, g=9.81):
        """[m/s] Arias intensity up to each row, by the trapezium rule, as is usual: rows sample a smooth acceleration."""
        square = np.diff(self.t) * (self.a[:-1] ** 2 + self.a[1:] ** 2) / 2
        return np.pi / (2 * g) * np.concatenate([[0.0], np.cumsum(square)])

    def significant(self, start=0.05, end=0.95):
        """[s] Returns the times at which the Arias intensity reaches these parts of its final value."""
        grown = self.arias()
        if grown[-1] == 0:
            raise RecordError(f"{self.name}: all accelerations are 0")
        return tuple(float(np.interp(part, grown / grown[-1], self.t)) for part in (start, end))

    def scaled(self, factor):
        return Record(self.name, self.t, factor * self.a)


def numbers(path, line, text):
    try:
        row = [float(word) for word in re.split(r"\s*,\s*|\s+", text.strip())]
    except ValueError as error:
        raise RecordError(f"{path}: line {line}: {' '.join(str(error).split())}") from error
    if not np.isfinite(row).all():
        raise RecordError(f"{path}: line {line}: expected finite numbers")
    return row


def read_peer(path, lines):
    """Reads a file of PEER: times, one column, whether they are velocities."""
    factor = size = None
    for i, line in enumerate(lines[:HEAD]):
        head = line.upper()
        units = re.search(r"UNITS OF\s+(\S+?)[.;:)]*(\s|$)", head)
        if units and factor is None:
            factor = UNITS.get(units[1]) or SPEEDS.get(units[1])
            fast = units[1] in SPEEDS
            if factor is None:
                raise RecordError(f"{path}: line {i + 1}: units of '{units[1]}': expected G, CM/S2 or M/S2, or of a velocity CM/S or M/S")
        if "NPTS" in head:
            size = re.search(r"NPTS\s*=\s*(\S+?),?\s.*DT\s*=\s*([^\s,]+)", head) or re.match(r"\s*(\S+)\s+(\S+)\s+NPTS", head)
            unit = re.search(r"DT\s*=\s*[^\s,]+ *([^\s,.;:)]*)", head)
            second = SECONDS.get(unit[1] if unit else "")
            if second is None:
                raise RecordError(f"{path}: line {i + 1}: DT in '{unit[1]}': expected SEC or MSEC")
            break
    if factor is None or size is None:
        raise RecordError(f"{path}: expected 'UNITS OF ...', then 'NPTS= ..., DT= ...' in the head of a file of PEER")
    n, step = numbers(path, i + 1, f"{size[1]} {size[2]}")
    step *= second
    x = [value for k, text in enumerate(lines[i + 1 :], i + 2) if text.strip() for value in numbers(path, k, text)]
    if len(x) != n or n < 2 or step <= 0:
        raise RecordError(f"{path}: {len(x)} values of step {step:g} s: NPTS says {n:g}, and the step is to be > 0")
    return step * np.arange(len(x)), factor * np.array(x)[:, None], fast


def read_table(path, lines):
    rows, named = [], False
    for i, line in enumerate(lines, 1):
        text = line.split("#")[0].strip()
        if not text:
            continue
        if not rows and not named and (text[0].isalpha() or text[0] == '"') and text[:3].lower() not in ("nan", "inf"):
            named = True
            continue
        rows.append(numbers(path, i, text))
        if len(rows[-1]) not in (2, 3) or len(rows[-1]) != len(rows[0]):
            raise RecordError(f"{path}: line {i}: {len(rows[-1])} numbers: expected t and one or two components")
        if len(rows) > 1 and rows[-1][0] < rows[-2][0]:
            raise RecordError(f"{path}: line {i}: t = {rows[-1][0]:g} after {rows[-2][0]:g}: expected times that ascend")
    if len(rows) < 2 or rows[-1][0] <= rows[0][0]:
        raise RecordError(f"{path}: {len(rows)} rows: expected two times or more")
    table = np.array(rows)
    return table[:, 0], table[:, 1:]


def columns(path):
    """Reads times, components (n, 1 or 2) as the file has them, and whether a file of PEER holds velocities (None: a table says nothing)."""
    with open(path, encoding="utf-8-sig", errors="replace") as file:
        lines = file.read().splitlines()
    if os.path.splitext(path)[1].lower() in (".at2", ".vt2"):
        return read_peer(path, lines)
    return *read_table(path, lines), None


def read(path, direction="x", scale=1.0):
    """Reads a Record of accelerations; direction: the component, where the file has two."""
    t, x, fast = columns(path)
    if fast:
        raise RecordError(f"{path}: it gives velocities: expected accelerations")
    column = "xy".index(direction) if x.shape[1] == 2 else 0
    return Record(os.path.basename(path), t, scale * x[:, column])


def from_velocity(name, t, v):
    """Returns the accelerations of velocities that are linear between rows: steps. A first row that moves is refused: it is an impact, which has no acceleration."""
    if v[0] != 0:
        raise RecordError(f"{name}: it begins with a velocity of {v[0]:g} m/s: a blow, no acceleration")
    keep = np.diff(t) > 0
    if np.any(np.diff(v)[~keep] != 0):
        raise RecordError(f"{name}: its velocity jumps: a blow, no acceleration")
    a = np.diff(v)[keep] / np.diff(t)[keep]
    return Record(name, np.stack([t[:-1][keep], t[1:][keep]], axis=1).ravel(), np.repeat(a, 2))


def from_history(t, u, name):
    """Returns the accelerations of displacements in time: second differences, which resolve periods of ten rows and more."""
    h = np.diff(t)
    keep = np.concatenate([[True], h > 1e-9 * t[-1]])
    t, u = t[keep], u[keep]
    if len(t) < 3:
        raise RecordError(f"{name}: {len(t)} rows in time: expected three or more (relaxation.history_every)")
    h = np.diff(t)
    slope = np.diff(u) / h
    a = np.zeros(len(t))
    a[1:-1] = 2 * np.diff(slope) / (h[1:] + h[:-1])
    return Record(name, t, a)
