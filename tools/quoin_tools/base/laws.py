"""Reads blocks that yield or crack from summary.json and results.h5 (docs/results_format.md).

for group, facts in laws_of(stage_summary).items(): ...     # the largest plastic strain or damage, where, how much yields, energy
lengths = open_cracks(results.mesh, results.stage("full"))   # [m] by block
"""

import numpy as np

from quoin_tools.base.flow import printed
from quoin_tools.base.language import N_, _

MOSTLY = 0.5  # damage beyond which a block counts as cracked through


def laws_of(s):
    """Returns the facts of the groups that can yield or crack, from a stage of summary.json; empty: there are none."""
    return s.get("laws") or {}


def most_of(facts):
    """Returns (word, the largest plastic strain or damage of a group, its unit)."""
    return (N_("damage"), facts["damage"]) if "damage" in facts else (N_("plastic strain"), facts["plastic_strain"])


def open_cracks(mesh, stage):
    """[m] (n_blocks,) Returns the mean width of a crack through each block, where more than half of its stiffness is gone and the crack is open now; 0 elsewhere.

    The crack runs across the largest principal stress; the way is the area over the block's extent across the crack."""
    lengths = np.zeros(len(mesh.blocks))
    if stage.crack_width is None:
        return lengths
    with np.errstate(invalid="ignore"):
        chosen = np.flatnonzero((stage.damage > MOSTLY) & (stage.crack_width > 0) & np.isfinite(stage.angle))
    across = np.stack([np.cos(stage.angle[chosen]), np.sin(stage.angle[chosen])], axis=1)
    lengths[chosen] = mesh.areas()[chosen] / np.ptp(np.einsum("nkx,nx->nk", mesh.rings()[chosen], across), axis=1)
    return lengths


def areas_of(mesh):
    """[m2] Returns the area of each group, by name."""
    area = np.bincount(mesh.block_group, mesh.areas(), minlength=len(mesh.group_names))
    return dict(zip(mesh.group_names, area, strict=True))


def energies(s):
    """Returns (kind, [J]) of the energy that a stage has stored, and of the energy lost for good since the start of the run, in this order."""
    energy, stored = s["energy"], [(N_("stored in blocks"), "strain"), (N_("stored in joints"), "joints"), (N_("kinetic"), "kinetic")]
    rows = [(_(words), energy.get(name)) for words, name in stored]
    for group, facts in laws_of(s).items():
        rows.append((_("lost in {0}, which cracked", group) if "damage" in facts else _("lost in {0}, which yielded", group), facts["lost"]))
    anchors = sum(a["lost"] for a in (s.get("anchors") or {}).values())
    return rows + ([(_("lost in anchors"), anchors)] if anchors else [])


# ---- rows of the table for the terminal; s: a stage of summary.json


def rows(s):
    found = []
    for group, facts in laws_of(s).items():
        word, most = most_of(facts)
        at = "-" if facts["x"] is None else _("({0:.2f}, {1:.2f})", facts["x"], facts["y"])
        found.append((group, _(word), printed(most, ".4g"), at, facts["blocks"], printed(facts["area"], ".2f"), printed(facts.get("crack_width"), ".4g", 1e3), printed(facts["lost"], ".4g")))
    return found


SECTIONS = (("Blocks that yield or crack", "group|measure|largest|at m|blocks with any|area m2|widest crack mm|lost J", rows),)  # as the tables of results.py
