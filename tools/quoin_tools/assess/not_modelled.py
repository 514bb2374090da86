"""What a dynamic stage leaves out of an earthquake, as far as its scene shows it; sentences for the sheet."""

import numpy as np

from quoin_tools.assess.cut import wet_segments
from quoin_tools.assess.hydrodynamic import Wall

OUTGROWN = 0.1  # of a contact's length: with fixed connectivity it has slid out of its place
LOOKS = 2000  # depths at which the pressure of moving water is held against that at rest


def listed(names):
    names = list(names)
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def deforms(case, name):
    """Whether the support of this name holds blocks that deform."""
    target, mesh = case.scene.supports[name].get("target") or name, case.mesh
    if target in mesh.face_sets:
        groups = mesh.block_group[mesh.face_sets[target][:, 0]]
    elif target in mesh.group_names:
        groups = [mesh.group_names.index(target)]
    else:
        return False  # a point
    written = case.results.mesh
    rigid = dict(zip(written.group_names, written.group_rigid, strict=True))
    return not all(rigid.get(mesh.group_names[row], 0) for row in groups)


def directions(case, shakings):
    if not shakings:
        return []
    missing = [word for axis, word in (("x", "Horizontal"), ("y", "Vertical")) if axis not in {s.direction for s in shakings}]
    records = "One record is one earthquake: others of the same size move the structure by more or less."
    return [f"{word} motion of the ground is absent." for word in missing] + [records]


def edges(case):
    """What happens to waves at the supports."""
    fixed = [name for name, keys in case.scene.supports.items() if keys.get("boundary", "fixed") == "fixed"]
    moved = [name for name in fixed if case.scene.supports[name].get("motion")]
    box = [name for name in moved if deforms(case, name)]
    held = [name for name in fixed if name not in moved and deforms(case, name)]
    said = []
    if box:
        said.append(f"The ground is a box that is held and shaken ({listed(box)}): waves that the structure sends out come back from its edge.")
    elif moved:
        said.append(f"The ground ({listed(moved)}) is rigid: it neither gives way nor takes energy away.")
    if held:
        said.append(f"{listed(held)} {'hold' if len(held) > 1 else 'holds'} the ground: waves that come there are sent back.")
    return said


def suction(case, load, a):
    """[m] Depth down to which water pulls more than it presses at rest, where the face moves away with acceleration a [m/s2]."""
    faces = wet_segments(case.mesh, load)
    wall = Wall(faces, load)
    z = np.linspace(0, wall.depth, LOOKS + 1)[1:]
    normal = max(abs(wall.side) * np.cos(np.radians(wall.lean)), 1e-9)
    pulls = a * np.abs(np.array([wall.pressure(depth, normal) for depth in z])) > case.scene.gravity * z
    return float(z[pulls][-1]) if pulls.any() else 0.0


def waters(case, stage, shakings):
    loads = case.scene.stage_loads(stage)
    moving = {name: load for name, load in loads.items() if load.get("type") == "added_mass"}
    faces = {load.get("faces") for load in moving.values()}
    still = [name for name, load in loads.items() if load.get("type") == "reservoir" and load.get("faces") not in faces]
    said = [f"The water of {listed(still)} does not move with the faces: no added_mass is in the stage."] if still else []
    strongest = max((s.record.pga for s in shakings if s.direction == "x"), default=0.0)
    for name, load in moving.items():
        depth = suction(case, load, strongest) if strongest else 0.0
        pull = f" Where the face moves with no more than the record's largest acceleration it pulls down to {depth:.2f} m below the surface; real water comes off there, here it does not." if depth else ""
        said.append(f"The water of {name} is incompressible: waves of pressure, waves at its surface and its heave by vertical motion are left out.{pull}")
    uplifts = [name for name, load in loads.items() if load.get("type") == "uplift"]
    if uplifts:
        said.append(f"Uplift ({listed(uplifts)}) stays as it is at rest: no crack that opens on the way changes it.")
    flow = case.results.stage_summary(stage).get("flow") or {}
    if flow.get("state") == "frozen":
        said.append("Water in joints keeps its pressures of before the earthquake.")
    return said


def joints(case, stage, courses):
    said, facts = [], case.results.stage_summary(stage)
    elastic = [name for name, j in facts["joints"].items() if j["law"] == "elastic"]
    if elastic:
        said.append(f"Joints of law elastic neither slide nor open: {listed(elastic)}.")
    variable = case.scene.stages.get(stage, {}).get("variable")
    variable = case.scene.contact.get("connectivity") == "variable" if variable is None else variable
    contacts = case.results.stage(stage).contacts
    rows = case.results.mesh.joint_names
    for name, c in courses.joints.items() if not variable else ():
        mine = contacts.joint == rows.index(name) if name in rows else np.zeros(0, bool)
        if mine.any() and np.abs(c["slip_largest"]).max() > OUTGROWN * contacts.length[mine].min():
            said.append(f"Contacts are fixed, and {name} has slid by more than a tenth of one: its contacts kept their places.")
    return said


def not_modelled(case, stage, shakings, courses):
    """Sentences, the most telling first."""
    said = edges(case) + directions(case, shakings) + waters(case, stage, shakings) + joints(case, stage, courses)
    if not case.results.mesh.group_rigid.all():
        said.append("Blocks are linear elastic: nothing cracks or crushes but joints.")
    return said
