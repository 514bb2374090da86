"""Anchors: the table of a stage in results.h5, and what summary.json says of them (docs/results_format.md).

anchors = Results("out").stage("full").anchors   # None: the scene has none
anchors.force, anchors.per_metre()               # a row for each anchor, in the order of the scene
"""

from dataclasses import dataclass, fields

import numpy as np

from quoin_tools.base.flow import at_end, printed

STATES = ("absent", "stressed", "slack", "elastic", "yielded", "broken")
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


def column_names():
    return [field.name for field in fields(Anchors)]


def facts_of(s):
    """What summary.json says of anchors at the end of a stage, or in the last stable trial of its flood or load factor; empty: there are none."""
    return at_end(s).get("anchors") or {}


def is_idle(a):
    """Whether a passive anchor has hardly begun to act, though it could."""
    reserve = a.get("reserve")
    return a["state"] in ("slack", "elastic") and a["work"] == 0 and reserve is not None and abs(a["force"]) < IDLE * (abs(a["force"]) + reserve * a["stiffness"])


def remarks(s):
    """Sentences about anchors that do next to nothing, and that are broken."""
    said = []
    for name, a in facts_of(s).items():
        if is_idle(a):
            said.append(f"{name} carries {a['force'] / 1e3:.1f} kN: a passive anchor acts as the joints it crosses open or slide; "
                        f"it yields after {1e3 * a['reserve']:.2g} mm more along its line.")  # fmt: skip
        if a["state"] == "broken":
            said.append(f"{name} is broken: it carried {a['largest'] / 1e3:.1f} kN at most.")
    return said


# ---- rows of the table for the terminal; s: a stage of summary.json


def rows(s):
    return [(name, a["state"], printed(a["force"], ".2f", 1e-3), printed(a["force_per_metre"], ".2f", 1e-3), printed(a["largest"], ".2f", 1e-3),
             printed(a["elongation"], ".3f", 1e3), printed(a["plastic"], ".3f", 1e3), printed(a.get("reserve") if a["state"] in ("slack", "elastic", "yielded") else None, ".2f", 1e3))
            for name, a in facts_of(s).items()]  # fmt: skip


COLUMNS = ("anchor", "state", "force [kN]", "per metre [kN/m]", "largest so far [kN]", "elongation [mm]", "plastic [mm]", "to yield or break [mm]")
SECTIONS = (  # as those of results.py
    ("Anchors, each", "anchor|state|force kN|per metre kN/m|largest kN|elongation mm|plastic mm|to yield mm", rows),
    ("What to know of them", "what", lambda s: [(line,) for line in remarks(s)]),
)
