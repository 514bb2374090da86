"""Lists the parts of an earthquake that a dynamic stage leaves out, as far as its scene shows them; sentences for the sheet."""

import numpy as np

from quoin_tools.assess.planes import held_by
from quoin_tools.assess.surface import WATERS
from quoin_tools.base.language import _, ngettext
from quoin_tools.mesh.supports import target_of

OUTGROWN = 0.1  # of a contact's length: with fixed connectivity it has slid out of its place


def listed(names):
    names = list(names)
    return names[0] if len(names) == 1 else _("{0} and {1}", ", ".join(names[:-1]), names[-1])


def deforms(case, name):
    """Tells whether the support of this name holds blocks that deform."""
    mesh = case.mesh
    if target_of(mesh, name, case.scene.supports[name])[0] == "point":
        return False
    written = case.results.mesh
    rigid = dict(zip(written.group_names, written.group_rigid, strict=True))
    return not all(rigid.get(mesh.group_names[row], 0) for row in mesh.block_group[held_by(case, name)])


def directions(case, shakings):
    if not shakings:
        return []
    known = (("x", _("Horizontal motion of the ground is absent.")), ("y", _("Vertical motion of the ground is absent.")))
    return [*(words for axis, words in known if axis not in {s.direction for s in shakings}), _("One record is one earthquake: others of the same size move the structure by more or less.")]


def edges(case):
    """Describes how waves behave at the supports."""
    fixed = [name for name, keys in case.scene.supports.items() if keys.get("boundary", "fixed") == "fixed"]
    moved = [name for name in fixed if case.scene.supports[name].get("motion")]
    box = [name for name in moved if deforms(case, name)]
    fixed_supports = [name for name in fixed if name not in moved and deforms(case, name)]
    sentences = []
    if box:
        sentences.append(_("The ground is a box that is held and shaken ({0}): waves that the structure sends out come back from its edge.", listed(box)))
    elif moved:
        sentences.append(_("The ground ({0}) is rigid: it neither gives way nor takes energy away.", listed(moved)))
    if fixed_supports:
        sentences.append(ngettext("{1} holds the ground: waves that come there are sent back.", "{1} hold the ground: waves that come there are sent back.", len(fixed_supports), listed(fixed_supports)))
    return sentences


def suction(facts):
    """Words about moving water that has pulled more than it presses at rest (its part of summary.json)."""
    found = facts.get("suction") or {}
    if not found.get("pressure"):
        return ""
    return " " + _("It has pulled more than it presses at rest over {0:.1f} m of its faces, to {1:.0f} kPa at ({2:.2f}, {3:.2f}) at {4:.2f} s: real water comes off there, here it does not.",
                   found["length"], found["pressure"] / 1e3, found["x"], found["y"], found["time"])  # fmt: skip


def waters(case, stage):
    loads, facts = case.scene.stage_loads(stage), case.results.stage_summary(stage)
    moving = {name: load for name, load in loads.items() if load.get("type") == "added_mass"}
    faces = {load.get("faces") for load in moving.values()}
    still = [name for name, load in loads.items() if load.get("type") in WATERS and load.get("faces") not in faces]
    sentences = [_("The water of {0} does not move with the faces: no added_mass is in the stage.", listed(still))] if still else []
    for name in moving:
        pull = suction((facts.get("added_mass") or {}).get(name, {}))
        sentences.append(_("The water of {0} is incompressible: waves of pressure, waves at its surface and its heave by vertical motion are left out.", name) + pull)
    uplifts = [name for name, load in loads.items() if load.get("type") == "uplift"]
    if uplifts:
        sentences.append(_("Uplift ({0}) stays as it is at rest: no crack that opens on the way changes it.", listed(uplifts)))
    if (facts.get("flow") or {}).get("state") == "frozen":
        sentences.append(_("Water in joints keeps its pressures of before the earthquake."))
    return sentences


def joints(case, stage, series):
    sentences, facts = [], case.results.stage_summary(stage)
    elastic = [name for name, j in facts["joints"].items() if j["law"] == "elastic"]
    if elastic:
        sentences.append(_("Joints of law elastic neither slide nor open: {0}.", listed(elastic)))
    variable = facts.get("connectivity") == "variable"
    contacts = case.results.stage(stage).contacts
    rows = case.results.mesh.joint_names
    for name, c in series.joints.items() if not variable else ():
        mine = contacts.joint == rows.index(name) if name in rows else np.zeros(0, bool)
        if mine.any() and np.abs(c["slip_largest"]).max() > OUTGROWN * contacts.length[mine].min():
            sentences.append(_("Contacts are fixed, and {0} has slid by more than a tenth of one: its contacts kept their places.", name))
    return sentences


def not_modelled(case, stage, shakings, series):
    """Sentences, the most telling first."""
    sentences = edges(case) + directions(case, shakings) + waters(case, stage) + joints(case, stage, series)
    if not case.results.mesh.group_rigid.all():
        sentences.append(_("Blocks are linear elastic: nothing cracks or crushes but joints."))
    return sentences
