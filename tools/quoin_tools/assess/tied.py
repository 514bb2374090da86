"""Anchors in the gravity method: their forces, as the run has found them, on the part above a base."""

import math

import shapely

from quoin_tools.assess import cut
from quoin_tools.base import anchors


def pulls(case, stage, part):
    """(X, Y, M) of each anchor of which one end is in the part."""
    table = case.results.stage(stage).anchors
    if table is None:
        return {}
    forces = {}
    names = anchors.facts_of(case.results.stage_summary(stage))
    for name, head, root, pull in zip(names, table.head, table.root, table.pull(case.scene.thickness), strict=True):
        ends = [bool(part.region.covers(shapely.Point(at))) for at in (head, root)]
        if ends[0] != ends[1] and pull.any():
            forces[f"anchor {name}"] = cut.force_at(pull if ends[0] else -pull, head if ends[0] else root)
    return forces


def words(forces, hand, without, factor):
    """Notes about what anchors do at a base: with them (hand) and without."""
    if not forces:
        return []
    total = cut.total(forces)
    found = [f"Anchors pull with {(total[0] ** 2 + total[1] ** 2) ** 0.5 / 1e3:.1f} kN on the part above ({', '.join(forces)}), as in the block model."]
    if without.refused:
        found.append(f"Without them there is no equilibrium without tension: {without.refused}.")
    elif not hand.refused:
        with_, bare = factor(hand), factor(without)
        if with_ is not None and bare is not None and math.isfinite(with_ + bare):
            found.append(f"Sliding factor by the gravity method {with_:.3f}, without them {bare:.3f}; open length {hand.crack or 0:.2f} m, without them {without.crack or 0:.2f} m.")
    return found
