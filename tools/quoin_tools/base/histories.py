"""Reads joint_history.csv and the peaks of a dynamic stage in summary.json (docs/results_format.md), for base/results.py."""

import csv
import os
from dataclasses import dataclass

import numpy as np

from quoin_tools.base.integrity import ResultsError, check_history, expecting
from quoin_tools.base.language import _

# column of the file: name for people
COLUMNS = {"time_s": "time", "stage": "stage", "N_N": "N", "T_N": "T", "factor_peak": "factor_peak", "factor_residual": "factor_residual",
           "slip_m": "slip", "slip_largest_m": "slip_largest", "opening_m": "opening", "open_length_m": "open_length", "length_m": "length"}  # fmt: skip


def read_joint_history(path):
    """Joint to its columns: arrays over its looks; the last row may be cut off in a run that goes on."""
    with open(path, encoding="utf-8", newline="") as file:
        rows = [row for row in csv.reader(file) if row]
    header, rows = rows[0], [row for row in rows[1:] if len(row) == len(rows[0])]
    columns = {name: [row[header.index(column)] for row in rows] for column, name in COLUMNS.items()}
    joints = np.array([row[header.index("joint")] for row in rows], dtype=str)
    arrays = {name: np.array(column, dtype=str if name == "stage" else float) for name, column in columns.items()}
    return {joint: {name: array[joints == joint] for name, array in arrays.items()} for joint in dict.fromkeys(joints.tolist())}


@dataclass
class ContactEnvelope:
    """Extremes at the ends of contacts (nc, 2), rows as those of `contacts`."""

    sigma_max: np.ndarray
    sigma_min: np.ndarray
    opening_max: np.ndarray
    slip_max: np.ndarray


@dataclass
class Envelope:
    """Extremes of blocks (nb,) over the samples of a dynamic stage, and their times; None: no material has strengths."""

    every: int
    samples: int
    contacts: ContactEnvelope
    s1_max: np.ndarray
    s1_max_time: np.ndarray
    s2_min: np.ndarray
    s2_min_time: np.ndarray
    safety_factor_min: np.ndarray | None = None
    safety_factor_min_time: np.ndarray | None = None
    safety_mode_min: np.ndarray | None = None


def envelope_of(group, array):
    """Reads the group `envelope` of a stage; array: reads a dataset."""
    blocks = {name: array(item) for name, item in group.items() if name != "contacts"}
    contacts = {name: array(item) for name, item in group["contacts"].items()}
    return Envelope(int(group.attrs["every"]), int(group.attrs["samples"]), ContactEnvelope(**contacts), **blocks)


def joint_history(folder, summary):
    """Reads the joint history of an output folder, by the name in its summary; {} where no stage ran in time."""
    path = os.path.join(folder, "joint_history.csv")
    if "joint_history" not in summary:
        return {}
    try:
        check_history(path, summary, "joint_history")
    except OSError as error:
        raise ResultsError(f"{path}: {error.strerror}") from error
    with expecting(path, "a history of joints"):
        return read_joint_history(path)


# ---- tables of peaks; fixed: a number for people, "-" where there is none


def at(found, key, scale, digits, fixed, time="time"):
    """A value and when it was."""
    return (fixed(found[key], scale, digits), fixed(found[time] if found[key] is not None else None))


def larger(found):
    """The end of a range that is larger in size, and when it was."""
    ends = [(found[key], found[f"time_{key}"]) for key in ("least", "largest") if found[key] is not None]
    return max(ends, key=lambda end: abs(end[0]), default=(None, None))


def joint_rows(s, fixed):
    """Joints: slip since the stage began, openings, factors, with their times."""
    return [(name, fixed(j["slip"]["start"], 1e3), fixed(j["slip"]["end"], 1e3), *at(j["slip"], "largest", 1e3, 3, fixed),
             *at(j["open_length"], "largest", 1, 3, fixed), *at(j["factor_peak"], "least", 1, 3, fixed), *at(j["factor_residual"], "least", 1, 3, fixed))
            for name, j in s.get("peaks", {}).get("joints", {}).items()]  # fmt: skip


def support_rows(s, fixed):
    """Largest force of each support and of all, along x and y."""
    peaks = s.get("peaks", {})
    supports = peaks.get("supports", {})
    named = list(supports.items()) + ([(_("all"), peaks["base_shear"])] if len(supports) > 1 else [])
    return [(name, *(cell for x in "xy" for cell in (fixed(larger(force[x])[0], 1e-3, 1), fixed(larger(force[x])[1])))) for name, force in named]


def probe_rows(s, fixed):
    """Largest displacement of each point, and that over the ground."""
    rows = []
    for name, p in s.get("peaks", {}).get("probes", {}).items():
        ends = [larger(p[key]) if key in p else (None, None) for key in ("u_x", "u_y", "relative_x", "relative_y")]
        rows.append((name, *(cell for value, time in ends for cell in (fixed(value, 1e3), fixed(time)))))
    return rows


def body_rows(s, fixed):
    """Bodies of a dynamic stage that have left their place, in the order of time; times [s] as they happened first."""
    fates = ("overturned", "fallen", "slid")
    bodies = sorted(s.get("bodies", []), key=lambda b: min(b[fate] for fate in fates if b[fate] is not None))
    return [(b["macroblock"], b["group"], _("({0:.2f}, {1:.2f})", b["x"], b["y"]), *("-" if b[fate] is None else fixed(b[fate]) for fate in fates),
             fixed(b["moved_x"]), fixed(b["moved_y"]), fixed(b["turned"], 180 / np.pi, 1)) for b in bodies]  # fmt: skip


SECTIONS = (  # title, columns after the stage, rows of one stage
    ("Peaks of joints in time, at looks", "joint|slip before mm|slip after mm|largest mm|at s|open m|at s|least factor peak|at s|residual|at s", joint_rows),
    ("Largest force of each support in time", "support|x kN|at s|y kN|at s", support_rows),
    ("Largest displacement of named points in time, and over the ground", "point|u_x mm|at s|u_y mm|at s|over x mm|at s|over y mm|at s", probe_rows),
    ("Bodies that left their place", "macroblock|group|at m|overturned s|fallen s|slid s|moved x m|moved y m|turned deg", body_rows),
)  # fmt: skip
