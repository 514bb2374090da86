"""Asks the solver for the loads on faces of a scene that has not been run: results.h5 has those of a run.

    loads = SceneLoads(mesh, scene)
    loads.of(scene, "flood", rise=1.5).table     FaceLoads, None: nothing presses; blocks are those of the mesh

The solver gets the mesh and, of the scene, what loads on faces depend on. All blocks are rigid and no stage runs. A process keeps the mesh and answers for other
numbers of the loads and other levels of a flood.
"""

import itertools
import os
import re
import shutil
import tempfile
import weakref
from dataclasses import dataclass

import numpy as np
import yaml

from quoin_tools.base.face_loads import FaceLoads
from quoin_tools.base.sample_rows import Rows
from quoin_tools.base.solver import SolverError
from quoin_tools.mesh import blockmesh

BESIDE = ("self_weight", "point_force", "head", "drain", "curtain", "inflow", "added_mass", "temperature")  # types of loads without forces on faces
NO_KEYS = ("groups", "drain_level", "levels", "history")  # of the inertia of blocks, of a trial, of stages in time
WIDTHS = (1, 2, 4, 4)  # numbers of load, face, point and force in a row
HELD = {"default": {"k_n": 1e9, "k_s": 1e9, "law": "elastic"}}  # any joints
MOST = 60  # numbers in a row
ANY_LEVEL = {"limit": 1e9, "bracket": 1.0}  # of a flood: the levels are those asked for


@dataclass
class StageLoads:
    """Loads on faces of a stage. start, rises: of a flood its level [m] before it rises, and the names of the loads that rise."""

    table: FaceLoads | None
    start: float | None = None
    rises: tuple = ()


class SceneLoads:
    """uplift: with uplift along joints, which are closed. floods: they can rise; False: the loads have the levels of a trial. The process starts at once, and ends with this object or this program."""

    def __init__(self, mesh, scene, uplift=False, floods=True):
        self.mesh, self.uplift, self.floods, self.end = mesh, uplift, floods, None
        if any(self.asks(load) for load in scene.loads.values()):
            self.start(scene)

    def start(self, scene, stage=None, columns=()):
        """Starts a process with the loads of the scene; of a stage, whatever trials have made of them."""
        if self.end:
            self.end()
        self.last = ("", None)
        loads = scene.loads | (scene.stage_loads(stage) if stage else {})
        self.loads, self.columns = {name: keys_of(load) for name, load in loads.items() if self.asks(load)}, columns
        self.folder, self.owner = tempfile.mkdtemp(), os.getpid()
        blockmesh.write(self.path("model.h5"), self.mesh)
        with open(self.path("scene.yaml"), "w", encoding="utf-8") as file:
            yaml.dump(self.written(scene), file, Dumper=yaml.CSafeDumper, sort_keys=False)
        self.rows = Rows(["-options_file", self.path("scene.yaml"), "-model", self.path("model.h5")], ",".join(["sample", *columns, "rise", "loads"]))
        self.end = weakref.finalize(self, ended, self.rows, self.folder, self.owner)

    def path(self, name):
        return os.path.join(self.folder, name)

    def asks(self, load):
        """Tells whether the solver is asked for a load. A load factor of 0 leaves no density, which the solver refuses."""
        faces = self.mesh.face_sets.get(load.get("faces"), ())
        return len(faces) > 0 and load.get("density") != 0 and load["type"] not in (BESIDE if self.uplift else (*BESIDE, "uplift"))

    def written(self, scene):
        """Returns the sections of the scene that the solver gets."""
        materials = {name: {"density": float(scene.materials.get(name, {}).get("density", 0.0)), "rigid": True} for name in self.mesh.group_names}
        contact = {key: value for key, value in scene.contact.items() if key in ("tolerance", "relative")} | {"overlap": 1e9}
        stages = {}
        for name, keys in scene.stages.items():
            mine = [load for load in keys.get("loads") or () if load in self.loads]
            rises = [keys["rises"]] if isinstance(keys.get("rises"), str) else keys.get("rises") or []
            flood = ANY_LEVEL | ({"rises": given} if (given := [load for load in rises if load in mine]) else {})
            if mine:
                stages[name] = {"loads": mine} | ({"type": "flood"} | flood if self.floods and keys.get("type") == "flood" else {})
        return {"thickness": scene.thickness, "gravity": scene.gravity, "contact": contact, "relaxation": {"allow_floating": True}, "materials": materials, "joints": HELD,
                "loads": self.loads, "stages": [{name: keys} for name, keys in stages.items()]}  # fmt: skip

    def of(self, scene, stage, rise=0.0):
        """Returns the StageLoads of a stage of the scene, whose loads may have other numbers than before; waters of a flood are raised by `rise` [m]."""
        if not any(self.asks(load) for load in scene.stage_loads(stage).values()):
            return StageLoads(None)
        if not self.end or not self.end.alive or self.owner != os.getpid():  # a fork has the process of another program
            self.start(scene, stage)
        now = {name: keys_of(load) for name, load in scene.stage_loads(stage).items() if name in self.loads or self.asks(load)}
        was, wanted = (dict(flat("loads", loads)) for loads in (self.loads, self.loads | now))
        new = [path for path, value in wanted.items() if path not in was or was[path] != value]
        if was.keys() != wanted.keys() or not all(isinstance(wanted[path], float) for path in new):
            self.start(scene, stage)
        elif not set(new) <= set(self.columns):
            columns = tuple(dict.fromkeys((*self.columns, *new)))
            self.start(scene, stage, columns if len(columns) <= MOST else ())
        numbers = [repr(wanted[path]) for path in self.columns]
        row = ",".join(["a", *numbers, repr(float(rise)), stage])
        if self.last[0] != row:
            self.last = row, self.asked(row)
        return self.last[1]

    def asked(self, row):
        answer = self.rows.answer(row)
        if answer is None or answer["outcome"] != "asked":
            raise SolverError(re.sub(rf"(quoin: error: )?({re.escape(self.path('scene.yaml'))}:\d+: )?", "", answer["why"] if answer else self.end(), count=1))
        names, flood = list(self.loads), answer["flood"].split()
        table = np.fromstring(answer["on_faces"], sep=" ").reshape(-1, sum(WIDTHS))
        columns = np.split(table, np.cumsum(WIDTHS)[:-1], axis=1)
        return StageLoads(FaceLoads(names, columns[0][:, 0], *columns[1:]), float(flood[0]) if flood else None, tuple(names[int(row)] for row in flood[1:]))


def ended(rows, folder, owner):
    """Ends the process, in the midst of its set-up too, where this program has started it. Returns its last line."""
    if owner != os.getpid():
        return ""
    shutil.rmtree(folder, ignore_errors=True)
    rows.stop()
    return rows.close()[1]


def keys_of(load):
    return {key: value for key, value in load.items() if value is not None and key not in NO_KEYS}


def flat(path, value):
    """Yields (path, value) of all keys below a path, in lists too; numbers as float."""
    below = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else None
    if below is None:
        yield path, float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else value
        return
    yield from itertools.chain.from_iterable(flat(f"{path}.{key}" if isinstance(value, dict) else f"{path}[{key}]", one) for key, one in below)
