"""Applies the forces of anchors, as the run has found them, to the part above a base in the gravity method."""

import math

import numpy as np
import shapely

from quoin_tools.assess import section_cut
from quoin_tools.base import anchors
from quoin_tools.base.language import _

ON_PATH = 1e-6  # [m] from a dowel to the base that it crosses


def pulls(case, stage, part, path):
    """Returns (X, Y, M) on the part for each anchor that crosses its base: the force along the anchor there, for a dowel also the force across."""
    table, bars = case.results.stage(stage).anchors, case.results.stage(stage).bars
    if table is None:
        return {}
    forces, facts = {}, anchors.facts_of(case.results.stage_summary(stage))
    for row, (name, row_facts) in enumerate(facts.items()):
        bonded = bars is not None and len(bars.of(row)) > 0
        places, tension = (bars.place[bars.of(row)], bars.force[bars.of(row)]) if bonded else (np.array([table.head[row], table.root[row]]), np.full(2, table.force[row]))
        scale, along = case.scene.thickness / table.spacing[row], places[-1] - places[0]
        found = crossing(part, places, tension, scale * along / np.hypot(*along)) + across(path, row_facts.get("dowels", []), scale)
        if found.any():
            forces[_("anchor {0}", name)] = found
    return forces


def crossing(part, places, tension, along):
    """Force and moment of a line of pieces that leaves the part or comes into it; tension at the places, linear between them."""
    inside = shapely.covers(part.region, shapely.points(places))
    total = np.zeros(3)
    for k in np.flatnonzero(inside[1:] != inside[:-1]):
        piece = shapely.LineString(places[k : k + 2])
        share = shapely.intersection(piece, part.region).length / piece.length
        share = share if inside[k] else 1 - share
        pull = (1 if inside[k] else -1) * (tension[k] + share * (tension[k + 1] - tension[k])) * along
        total += section_cut.force_at(pull, places[k] + share * (places[k + 1] - places[k]))
    return total


def across(path, dowels, scale):
    """Returns force and moment on the part above the path, from bars that resist slip of the joint that they cross."""
    total = np.zeros(3)
    for dowel in dowels:
        at = np.array(dowel["place"])
        for a, b in zip(path[:-1], path[1:]):
            if shapely.LineString([a, b]).distance(shapely.Point(at)) < ON_PATH:
                total += section_cut.force_at(scale * dowel["force"] * (b - a) / np.hypot(*(b - a)), at)
                break
    return total


def compare(found, forces, hand, without, factor):
    """Adds the answers with anchors (hand) and without them to the assessment of a base."""
    if not forces:
        return
    total = section_cut.total(forces)
    found.anchored = -float(total[:2] @ found.base.normal), float(total[:2] @ found.base.along)
    found.with_anchors, found.without_anchors = ((None, None) if answer.refused else (factor(answer), answer.crack or 0.0) for answer in (hand, without))
    found.notes += words(forces, without, found)


def words(forces, without, found):
    """Writes notes about the work of anchors at a base."""
    total = section_cut.total(forces)
    sentences = [_("Anchors pull with {0:.1f} kN on the part above ({1}), as in the block model.", math.hypot(*total[:2]) / 1e3, ", ".join(forces))]
    if without.refused:
        sentences.append(_("Without them there is no equilibrium without tension: {0}.", without.refused))
    elif found.with_anchors[1] is not None:
        (with_, opened), (bare, opened_bare) = found.with_anchors, found.without_anchors
        if with_ is not None and bare is not None and math.isfinite(with_ + bare):
            sentences.append(_("Sliding factor by the gravity method {0:.3f}, without them {1:.3f}; open length {2:.2f} m, without them {3:.2f} m.", with_, bare, opened, opened_bare))
    return sentences
