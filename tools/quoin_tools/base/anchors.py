"""Reads anchors of a run: the table of a stage in results.h5, and their part of summary.json (docs/results_format.md).

anchors = Results("out").stage("full").anchors   # None: the scene has none
anchors.force, anchors.per_metre()               # a row for each anchor, in the order of the scene
"""

import csv
import os
from dataclasses import dataclass, fields

import numpy as np

from quoin_tools.base.flow import at_end, printed
from quoin_tools.base.language import N_, _

STATES = (N_("absent"), N_("stressed"), N_("slack"), N_("elastic"), N_("yielded"), N_("broken"), N_("slipped"))
IDLE = 0.05  # of the force at which it yields: a passive anchor that carries less has hardly begun to act


@dataclass
class Anchors:
    head: np.ndarray  # [m] (n, 2)
    root: np.ndarray  # [m] (n, 2)
    spacing: np.ndarray  # [m]
    force: np.ndarray  # [N] of one anchor
    state: np.ndarray  # row of STATES
    elongation: np.ndarray  # [m] since it was without force
    plastic: np.ndarray  # [m]
    lost: np.ndarray  # [J] of one anchor

    def __post_init__(self):
        self.head, self.root, self.state = self.head.reshape(-1, 2), self.root.reshape(-1, 2), self.state.astype(int)
        if any(len(getattr(self, field.name)) != len(self.force) for field in fields(self)):
            raise ValueError("anchors: their columns do not belong together")

    def __len__(self):
        return len(self.force)

    def per_metre(self):
        """[N/m] of thickness."""
        return self.force / self.spacing

    def pull(self, thickness):
        """[N] (n, 2) on the block at the head, in the thickness of the model; the block at the root gets the opposite. Along the first line."""
        along = self.root - self.head
        return (thickness * self.per_metre() / np.hypot(*along.T))[:, None] * along


@dataclass
class Bars:
    """Along bonded bars, from the head of each to its root."""

    anchor: np.ndarray  # row of Anchors
    from_head: np.ndarray  # [m]
    place: np.ndarray  # [m] (n, 2) in the reference state
    force: np.ndarray  # [N] of one bar, there
    bond: np.ndarray  # [N/m] of the bonded part behind it, as all that follows
    bond_use: np.ndarray  # over the strength
    slip: np.ndarray  # [m] (n, 2) of the steel in the grout, for good
    plastic: np.ndarray  # [m] elongation of the piece before

    def __post_init__(self):
        self.place, self.slip, self.anchor = self.place.reshape(-1, 2), self.slip.reshape(-1, 2), self.anchor.astype(int)
        if any(len(getattr(self, field.name)) != len(self.force) for field in fields(self)):
            raise ValueError("bars: their columns do not belong together")

    def of(self, anchor):
        """Rows of one anchor."""
        return np.flatnonzero(self.anchor == anchor)


def read_history(folder):
    """Anchor to its columns of anchor_history.csv (docs/results_format.md)."""
    with open(os.path.join(folder, "anchor_history.csv"), encoding="utf-8", newline="") as file:
        header, *rows = (row for row in csv.reader(file) if row)
    rows = [row for row in rows if len(row) == len(header)]  # the last one may be cut off in a run that goes on
    columns = {name: np.array([row[i] for row in rows], dtype=str if name in ("stage", "anchor") else float) for i, name in enumerate(header)}
    return {str(one): {name: array[columns["anchor"] == one] for name, array in columns.items() if name != "anchor"} for one in dict.fromkeys(columns["anchor"])}


def column_names(table=Anchors):
    return [field.name for field in fields(table)]


def facts_of(s):
    """Returns the facts of anchors in summary.json at the end of a stage, or in the last stable trial of its flood or load factor; empty: there are none."""
    return at_end(s).get("anchors") or {}


def is_idle(a):
    """Tells whether a passive anchor has hardly begun to act, though it could."""
    reserve = a.get("reserve")
    return a["state"] in ("slack", "elastic", "slipped") and a["work"] == 0 and reserve is not None and abs(a["force"]) < IDLE * (abs(a["force"]) + reserve * a["stiffness"])


def remarks(s):
    """Sentences about anchors that do next to nothing, and that are broken."""
    sentences = []
    for name, a in facts_of(s).items():
        if is_idle(a):
            facts = name, a["force"] / 1e3, 1e3 * a["reserve"]
            sentences.append(_("{0} carries {1:.1f} kN: a passive anchor acts as the joints it crosses open or slide; it yields after {2:.2g} mm more where a joint opens.", *facts) if "bond_use" in a else
                             _("{0} carries {1:.1f} kN: a passive anchor acts as the joints it crosses open or slide; it yields after {2:.2g} mm more along its line.", *facts))
        if a["state"] == "broken":
            sentences.append(_("{0} is broken: it carried {1:.1f} kN at most.", name, a["largest"] / 1e3))
    return sentences


# ---- rows of the table for the terminal; s: a stage of summary.json


def rows(s):
    return [(name, _(a["state"]), printed(a["force"], ".2f", 1e-3), printed(a["force_per_metre"], ".2f", 1e-3), printed(a["largest"], ".2f", 1e-3),
             printed(a["elongation"], ".3f", 1e3), printed(a["plastic"], ".3f", 1e3), printed(a.get("reserve") if a["state"] in ("slack", "elastic", "yielded", "slipped") else None, ".2f", 1e3))
            for name, a in facts_of(s).items()]  # fmt: skip


def bar_rows(s):
    return [(name, printed(a["bond_use"], ".3f"), printed(a["slip"], ".3f", 1e3), printed(a["slipped_length"], ".2f"), printed(a["yielded_length"], ".2f"),
             printed(a["stored"], ".4g"), printed(a["lost_yield"], ".4g"), printed(a["lost_bond"], ".4g"), printed(a.get("lost_dowel"), ".4g"))
            for name, a in facts_of(s).items() if "bond_use" in a]  # fmt: skip


def dowel_rows(s):
    return [(name, printed(d["place"][0], ".2f"), printed(d["place"][1], ".2f"), printed(d["force"], ".2f", 1e-3), printed(d["slip"], ".3f", 1e3), printed(d["plastic"], ".3f", 1e3),
             printed(d["use"], ".3f"))
            for name, a in facts_of(s).items() for d in a.get("dowels", [])]  # fmt: skip


def needed_rows(s):
    """Returns rows on a stage of anchor_force."""
    found = s.get("anchor_force") or {}
    return [(name, printed(found["required"], ".3g"), *(printed(f[key], ".2f", 1e-3) for key in ("failing", "stable", "failing_per_metre", "stable_per_metre")))
            for name, f in found.get("forces", {}).items()]  # fmt: skip


COLUMNS = (N_("anchor"), N_("state"), N_("force [kN]"), N_("per metre [kN/m]"), N_("largest so far [kN]"), N_("elongation [mm]"), N_("plastic [mm]"), N_("to yield or break [mm]"))
SECTIONS = (  # as the tables of results.py
    ("Anchors, each", "anchor|state|force kN|per metre kN/m|largest kN|elongation mm|plastic mm|to yield mm", rows),
    ("Bonded bars", "bar|bond use|slip mm|slipped m|yielded m|stored J|lost in yield J|in bond J|in dowels J", bar_rows),
    ("Bars as dowels", "bar|x m|y m|force kN|slip mm|plastic mm|use", dowel_rows),
    ("Force that anchors need, each", "anchor|factor|fails with kN|stands with kN|per metre, fails kN/m|stands kN/m", needed_rows),
    ("What to know of them", "what", lambda s: [(line,) for line in remarks(s)]),
)
