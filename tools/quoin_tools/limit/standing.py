"""Runs the trials of a stage near its limit, and checks the forces of the last one that stands apart from the solver.

    found = standing(mesh, scene, stage, parts, raised, raised.trials(near, bracket, last), CORNERS)
    found.measure, found.fails, found.error

The run has small displacements and the stages on the way to this one; blocks and all else are as in the scene, joints too but for the changes that are asked for. Its forces are read from results.h5: with the loads of limit/forces.py they must be
in equilibrium on each body, and within the strengths at each contact.
"""

import os
import subprocess
import tempfile
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import yaml

from quoin_tools.base import solver
from quoin_tools.base.results import Results, trials_of
from quoin_tools.limit import LimitError, program
from quoin_tools.mesh import blockmesh

CYCLES, FEW = 200_000, 100_000  # of a trial at most, the latter of the run as the scene is: one that is open then is no limit of either side
FALLS = "does not stand at its start"  # in what the solver says where the first trial of the first stage fails
CORNERS, POINTS = "corners", {"stress_model": "pt"}  # a run with forces in the corners of the faces
AS_IS = "as is"  # a run with the joints and the method of the scene
DECIDES = "preconditioned"  # method of runs whose hinges are pressed over a length, where the scene leaves it to the solver: explicit cycles come to rest slowly there, and are not decided at times
TIGHT = 1e-7  # tolerance of the trials
SURE = 1e-5  # of the heaviest load: a state with a larger error does not count as checked


@dataclass
class Standing:
    measure: float  # last that stands
    fails: float | None  # first that fails
    error: float  # of equilibrium and strengths, over the heaviest load


class Last(NamedTuple):
    """The last trial that stands and the first that fails (None: there is none), as the stage counts, and the forces and bodies of the former."""

    stands: float
    fails: float | None
    contacts: object
    mesh: object


def standing(mesh, scene, stage, parts, raised, ways, what):
    """Returns the Standing of a run; None: it stands at none of the first trials. raised: what its trials raise. ways: keys of its trials, the next where the first trial of one does not stand. what: CORNERS, AS_IS, or k_n and k_s over those of the scene."""
    return checked(parts, raised, last_of(mesh, scene, stage, ways, what))


def last_of(mesh, scene, stage, ways, what, running=None):
    """Returns the Last of a run; None: it stands at none of the first trials. running: of solver.run."""
    for trials in ways:
        with tempfile.TemporaryDirectory() as folder:
            results = run(mesh, scene, stage, folder, trials, what, running)
            found = trials_of(results.stage_summary(stage)) if results and stage in results.stages else None
            if found and found["stable"] is not None:
                return Last(found["stable"], found["failing"], results.stage(stage).contacts, results.mesh)
    return None


def checked(parts, raised, last):
    """Returns the Standing of a Last; None: there is none."""
    if last is None:
        return None
    measure, fails = (None if end is None else raised.measure(end) for end in last[:2])
    return Standing(measure, fails, error(parts, last.contacts, last.mesh, raised.loads(measure), raised.reduction(measure)))


def run(mesh, scene, stage, folder, trials, what, running=None):
    """Returns the Results of a run in a folder with other trials of a stage, and other joints; None: no stage stands."""
    keys = yaml.safe_load(scene.text)
    rows = keys["stages"] if isinstance(keys["stages"], list) else [{name: row} for name, row in keys["stages"].items()]
    keys["stages"] = [{name: row} for rows_of_name in rows for name, row in rows_of_name.items() if name in (*scene.stages_before(stage), stage)]
    last = keys["stages"][-1][stage]
    for key in ("step", "factor"):
        last.pop(key, None)
    last.update({key: float(value) for key, value in trials.items()}, tolerance=TIGHT, max_cycles=min(FEW if what == AS_IS else CYCLES, int(float(last.get("max_cycles") or CYCLES))))
    keys.update(model=os.path.join(folder, "model.h5"), strain="small")
    relaxation = keys.setdefault("relaxation", {})
    factor = 1.0 if what in (CORNERS, AS_IS) else what
    if what not in (CORNERS, AS_IS) and relaxation.get("method", "auto") == "auto":
        relaxation["method"] = DECIDES
    for name, row in scene.joints.items():
        keys["joints"][name].update({key: factor * float(row[key]) for key in ("k_n", "k_s") if key in row})
    for row in (*keys["joints"].values(), *(row for one in keys["stages"] for stage_keys in one.values() for row in (stage_keys.get("joints") or {}).values())):
        row.update(POINTS if what == CORNERS else {})
    blockmesh.write(keys["model"], mesh)
    path, out = os.path.join(folder, "scene.yaml"), os.path.join(folder, "out")
    with open(path, "w", encoding="utf-8") as file:
        yaml.safe_dump(keys, file, sort_keys=False)
    done = solver.run([solver.find(), "-options_file", path, "-output", out], running=running, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=solver.environment_of_one())
    if os.path.exists(os.path.join(out, "results.h5")):
        return Results(out)
    said = (done.stderr.strip() or f"{stage}: the run has no results").splitlines()[-1]
    if FALLS not in said:
        raise LimitError(said.replace(folder + os.sep, ""))
    return None


def error(parts, contacts, mesh, loads, reduction):
    """Returns by how much forces of a run miss equilibrium with loads (n, 3), beside reactions, or leave the strengths, over the heaviest load."""
    body = np.full(mesh.macroblock.max() + 1, -1)
    body[mesh.macroblock] = parts.body
    force, missing = contacts.on_b(), np.array(loads, dtype=float)
    for side, sign in ((0, -1.0), (1, 1.0)):
        owner = body[contacts.macroblock[:, side]]
        moment = blockmesh.cross(contacts.point - parts.centre[owner][:, None], force)
        np.add.at(missing, owner, sign * np.concatenate([force, moment[..., None]], axis=2).sum(axis=1))
    p = program.programme(parts, loads)
    missing = p.rows(missing)
    if len(parts.held):
        held = p.equilibrium[:, 3 * len(parts.contacts) :][:, : len(parts.held)].toarray()
        missing = missing - held @ np.linalg.lstsq(held, missing, rcond=None)[0]
    table = parts.strengths(*(reduction or ()))
    strength = np.array([[s.friction, s.cohesion, s.tension] for s in (table[mesh.joint_names[row]] for row in contacts.joint)]).reshape(-1, 3)
    area = contacts.length * parts.thickness
    pull, shear = contacts.force[..., 0], np.abs(contacts.force[..., 1].sum(axis=1))
    return float(max(np.abs(missing).max(), (pull - (strength[:, 2] * area)[:, None]).max() / p.force, (shear + strength[:, 0] * pull.sum(axis=1) - strength[:, 1] * area).max() / p.force, 0.0))
