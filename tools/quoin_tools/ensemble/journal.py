"""Stores the rows of an ensemble: a line as soon as a sample is done, so that a kill loses only samples under way; on the disk a second later, for a loss of power.

Each process writes a file of its own, rows_<part>.csv; all files of the folder count. A line that a kill has cut is dropped; a sample that two files have counts once, and must be the same in both.
"""

import csv
import glob
import io
import os
import time
import zlib
from dataclasses import dataclass

from quoin_tools.ensemble.variables import EnsembleError

FIXED = ("sample", "level", "weight", "outcome", "response", "seconds", "why")
OUTCOMES = ("stands", "fails", "undecided")


@dataclass(frozen=True)
class Row:
    sample: int
    level: float | None
    weight: float
    outcome: str
    response: float | None
    seconds: float
    why: str
    values: tuple

    def key(self):
        return self.sample, self.level

    def same(self, other):
        return (self.outcome, self.response, self.values, self.weight) == (other.outcome, other.response, other.values, other.weight)


class Journal:
    """Stores the rows of a folder; `write` adds one to the file of this part."""

    def __init__(self, folder, design, part="1"):
        self.folder, self.design, self.name = folder, design, "study" if design.method == "all" else "rows"
        self.path = os.path.join(folder, f"{self.name}_{part}.csv")
        self.header = f"# quoin ensemble {design.mark}; {','.join((*FIXED, *design.columns()))}\n"

    def rows(self):
        """Reads {(sample, level): Row} of all files."""
        found = {}
        for path in sorted(glob.glob(os.path.join(glob.escape(self.folder), f"{self.name}_*.csv"))):
            for row in self.read(path):
                other = found.setdefault(row.key(), row)
                if not row.same(other):
                    raise EnsembleError(f"{path}: sample {row.sample} is another one than in the other files: they are not of one ensemble")
        return found

    def read(self, path):
        with open(path, encoding="utf-8", newline="") as file:
            lines = file.read().split("\n")
        if lines[0] + "\n" != self.header:
            if len(lines) == 1 and self.header.startswith(lines[0]):
                return []  # a kill in the first line
            raise EnsembleError(f"{path}: rows of another ensemble (scene, mesh, variables, seed, posterior or what counts as failure have changed): use another folder, or remove it")
        rows = []
        for line in lines[1:]:
            body, _, check = line.rpartition(",")
            if check != checksum(body):
                continue  # cut by a kill, or empty
            cells = next(csv.reader([body]))
            sample, level, weight, outcome, response, seconds, why, *values = cells
            rows.append(Row(int(sample), float(level) if level else None, float(weight), outcome, float(response) if response else None, float(seconds), why, tuple(one.kept(v) for one, v in zip(self.design.variables.each, values, strict=True))))
        return rows

    def open(self):
        """Begins the file of this part, or continues behind the last whole line."""
        os.makedirs(self.folder, exist_ok=True)
        self.synced = 0.0
        fresh = not os.path.exists(self.path) or os.path.getsize(self.path) < len(self.header.encode())
        self.file = open(self.path, "w" if fresh else "a", encoding="utf-8", newline="")  # noqa: SIM115
        self.put(self.header if fresh else "\n")

    def put(self, text):
        self.file.write(text)
        self.file.flush()
        if time.monotonic() > self.synced + 1:
            self.sync()

    def sync(self):
        os.fsync(self.file.fileno())
        self.synced = time.monotonic()

    def write(self, row):
        text = io.StringIO()
        cells = [row.sample, "" if row.level is None else repr(row.level), repr(row.weight), row.outcome, "" if row.response is None else repr(row.response), f"{row.seconds:.3f}", row.why]
        csv.writer(text, lineterminator="").writerow([*cells, *(v if isinstance(v, str) else repr(v) for v in row.values)])
        body = text.getvalue().replace("\n", " ")
        self.put(f"{body},{checksum(body)}\n")

    def close(self):
        self.sync()
        self.file.close()


def checksum(text):
    return f"{zlib.crc32(text.encode()):08x}"
