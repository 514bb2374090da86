"""Decides by the criterion of a guideline whether a crack starts at an end of a base that has none.

    opens = crack_start.of(guideline, "usual", strength)     a CrackStart for gravity.Base, None: any tension opens the base
    opens.asks(head, drained, unit_weight)                   [Pa] the least compression at that end without a crack

Stress is that of the straight line over the whole base. The tension that its end bears is a part of the tensile strength f_t of the joint. Where the
guideline names a part p of the water pressure there, the stress is that without uplift, and the least compression is p w h - part f_t (US Bureau of
Reclamation; Novak et al., Hydraulic Structures, eq. 3.38). Once a crack has started, the base bears no tension.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class CrackStart:
    """strength: [Pa] tension that counts at the ends of the base; entry: of the guideline; joint: its keys; drained, undrained: part of the water pressure, with drains that work and without, None: uplift is in the stress."""

    strength: float
    entry: dict
    joint: dict
    drained: float | None = None
    undrained: float | None = None

    @property
    def without_uplift(self):
        return self.undrained is not None

    def asks(self, head, drained, unit_weight):
        """[Pa] The least compression at an end with this head of water [m]."""
        part = 0.0 if not self.without_uplift else self.drained if drained else self.undrained
        return part * unit_weight * head - self.strength


def of(guideline, condition, strength):
    """The criterion of a guideline in a condition; None where it has none, or only a blank. strength: keys of the joint."""
    entry = (guideline or {}).get("crack_start", {}).get(condition)
    if entry is None or entry["value"] is None:
        return None
    part, joints = entry.get("pressure") or {}, [own for _, _, own in strength.get("spans") or ()] or [strength]
    return CrackStart(entry["value"] * min(float(own.get("tension") or 0.0) for own in joints), entry, strength, part.get("drained"), part.get("undrained"))
