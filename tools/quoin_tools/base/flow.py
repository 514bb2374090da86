"""Reads water that flows in joints: the table of a stage in results.h5, and its part of summary.json (docs/results_format.md).

flow = Results("out").stage("full").flow      # None: no water flows in this stage
flow.pressure, flow.discharge, ...            # a row for each piece of a joint between two nodes; (n, 2): at its two ends
"""

from dataclasses import dataclass, fields

import numpy as np

from quoin_tools.base.language import numeral

LITRES = 6e4  # m2/s in litres per minute and metre of thickness
STILL = 1e-12  # [m2/s] smaller flow is rounding: the water stands still
WEDGE, CARRIES = 2.0, 0.1  # ratio of apertures, and part of the largest pressure head, from which a piece is too coarse
EQUAL = 1e-9  # [-] saturations that are the same


@dataclass
class Flow:
    """Pieces of joints. From its first end to its second a piece carries `discharge`."""

    point: np.ndarray  # [m] (n, 2, 2)
    head: np.ndarray  # [m] (n, 2) elevation and pressure head
    pressure: np.ndarray  # [Pa] (n, 2) that presses on the blocks
    aperture: np.ndarray  # [m] (n, 2)
    saturation: np.ndarray  # [-] (n, 2) 1: below the free surface
    discharge: np.ndarray  # [m2/s] (n,)
    length: np.ndarray  # [m] (n,)
    joint: np.ndarray  # (n,) row of joint_names

    def __post_init__(self):
        n = len(self.length)
        self.point, self.joint = self.point.reshape(-1, 2, 2), self.joint.astype(int)
        if any(len(getattr(self, field.name)) != n for field in fields(self)) or self.pressure.shape != (n, 2):
            raise ValueError("flow: its columns do not belong together")

    def __len__(self):
        return len(self.length)

    @property
    def pressure_head(self):
        """[m] (n, 2)"""
        return self.head - self.point[:, :, 1]

    def wet(self):
        """Which pieces are full of water from end to end."""
        return (self.saturation >= 1 - EQUAL).all(axis=1)

    def along(self, joint, start, end):
        """Distance from start towards end [m], pressure [Pa] and aperture [m]: each (m, 2), the pieces of a joint in order."""
        mine = np.flatnonzero(self.joint == joint)
        distance = (self.point[mine] - start) @ (end - start) / np.hypot(*(end - start))
        order = np.argsort(distance, axis=1, kind="stable")
        columns = [np.take_along_axis(array, order, axis=1) for array in (distance, self.pressure[mine], self.aperture[mine])]
        rows = np.argsort(columns[0].sum(axis=1), kind="stable")
        return tuple(array[rows] for array in columns)

    def too_coarse(self):
        """Rows of wedges in which the pressure is far from the straight line that presses on the blocks."""
        ratio = self.aperture.max(axis=1) / self.aperture.min(axis=1)
        loss = np.abs(self.head[:, 0] - self.head[:, 1])
        return np.flatnonzero(self.wet() & (ratio > WEDGE) & (loss > CARRIES * self.pressure_head.max(initial=0.0)))


def column_names():
    return [field.name for field in fields(Flow)]


def at_end(s):
    """Returns the stage of summary.json, or the last stable trial of its flood or load factor: the part with the members `flow` and `uplift`."""
    raised = s.get("flood") or s.get("load_factor")
    return next((t for t in raised["trials"] if t["value"] == raised["stable"]), {}) if raised else s


def facts_of(s):
    """Returns the facts of the water at the end of a stage in summary.json; empty: no water flows."""
    return at_end(s).get("flow") or {}


# ---- rows of the table for the terminal; s: a stage of summary.json


def printed(value, form, factor=1.0):
    """null of summary.json is what is no number."""
    return "-" if value is None else numeral(f"{value * factor:{form}}")


def state_rows(s):
    """Describes how the flow was found."""
    flow, forms = facts_of(s), {"change": ".1e", "inflow": ".4e", "error": ".1e", "cut_off_length": ".3f"}
    return [(flow["state"], flow["rounds"], *(printed(flow[key], form) for key, form in forms.items()))] if flow else []


def condition_rows(s):
    """Returns the flow out of the joints by heads and drains."""
    return [(name, printed(c["discharge"], "+.4e"), printed(c["discharge"], "+.4f", LITRES)) for name, c in facts_of(s).get("conditions", {}).items()]


def joint_rows(s):
    """Force of the water in each joint: of a line with its centre, of a net as the sum of all sizes."""
    lines = {name for name, joint in s["joints"].items() if joint["line"]}
    return [(name, printed(j["length"], ".3f"), printed(j["uplift"], ".1f", 1e-3),
             *(printed(j[at] if name in lines else None, ".3f") for at in ("centre_x", "centre_y")), printed(j["widest"], ".4f", 1e3),
             printed(j["at_residual"], ".3f"), printed(j["at_max"], ".3f"), printed(j["reynolds"], ".3g"))
            for name, j in facts_of(s).get("joints", {}).items()]  # fmt: skip


SECTIONS = (  # as the tables of results.py
    ("Water that flows in joints", "state|rounds|change|inflow m2/s|error|cut off m", state_rows),
    ("Water that leaves the joints (negative: enters)", "by|m2/s|litres per minute and metre", condition_rows),
    ("Force of the water in joints", "joint|length m|kN|centre x m|centre y m|widest mm|at residual|at max|Reynolds", joint_rows),
)  # fmt: skip
