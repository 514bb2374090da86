"""Scenes of the hunt, the ways in which each is solved, and the numbers of two runs that must agree."""

import copy
import json
import os
import subprocess
from dataclasses import dataclass, field

import numpy as np
import yaml
from driver import ENVIRONMENT, MODELS, VERDICTS
from quoin_tools.base.results import Results
from quoin_tools.mesh.blockmesh import write
from turns import turn

AGREE = 5e-3  # displacements, forces and limits
UNDECIDED = "undecided"
BESIDE = ("is not within", "outside all blocks", "unit")  # warnings about the scene, which say nothing of a number that is off
LONGEST = 120  # s of one run


@dataclass
class Way:
    """How a scene is solved beside its reference. mesh, keys: those of the scene unless given; bits: the checksums must agree where the run says so; image: what displacements of
    the reference are here; unsigned: T is held by its size; forces: factor on N and T of joints; levels: on the levels of a flood; last: only the last stage is held against the reference; agree: within what; compare: in place of differences."""

    ranks: int = 1
    options: tuple = ()
    mesh: object = None
    keys: dict | None = None
    bits: bool = False
    image: object = None
    unsigned: bool = False
    forces: float = 1.0
    levels: float = 1.0
    last: bool = False
    agree: float = AGREE
    compare: object = None
    slipped: bool = True  # compared also where the reference has slipped


@dataclass
class Scene:
    """A scene of the hunt. ways: name to Way; by_hand: a function of a Run that yields (what, relative difference); files: name to text, beside the scene."""

    kind: str
    mesh: object
    keys: dict
    ways: dict = field(default_factory=dict)
    by_hand: object = None
    files: dict = field(default_factory=dict)
    condensed: list = field(default_factory=list)  # groups that can be
    newton: bool = True  # whether Newton's method can solve it


def solved(scene, *, ranks=(2,), variable=True, newton=True):
    """The scene with the ways that every scene has: other numbers of ranks, Newton's method, variable connectivity, condensed bodies."""
    names = {2: "two ranks", 3: "three ranks"}
    scene.ways |= {names[n]: Way(ranks=n, bits=True) for n in ranks}
    if newton:
        scene.ways["Newton"] = Way(options=("-relaxation_method", "preconditioned"))
    if variable:
        scene.ways["variable"] = Way(options=("-contact_connectivity", "variable"))
    if scene.condensed:
        scene.ways["condensed"] = Way(options=tuple(word for group in scene.condensed for word in (f"-materials_{group}_condensed", "true")))
    return scene


# ---- pieces of scenes ------------------------------------------------------------------------------------

def joint(rng, stiff=(9.5, 11.0), friction=(35, 55)):
    """A random row of a joint that only rubs, most often the one of the default stress model."""
    k_n = 10 ** rng.uniform(*stiff)
    model = "tptm" if rng.random() < 0.6 else str(rng.choice(MODELS))
    return {"k_n": float(k_n), "k_s": float(k_n * rng.uniform(0.2, 0.6)), "friction": float(rng.uniform(*friction)), "stress_model": model}


def elastic(rng, density=2400.0):
    return {"density": density, "young": float(10 ** rng.uniform(9.5, 10.5)), "poisson": float(rng.uniform(0.1, 0.3))}


def frame(**keys):
    return {"relaxation": {"tolerance": 1e-8, "velocity_tolerance": 1e-8, "max_cycles": 400000}, **keys}


def reduction(loads, bracket=0.1, **keys):
    return {"limit": {"type": "strength_reduction", "what": "friction", "loads": loads, "step": 5, "limit": 2, "bracket": bracket, **keys}}


def changed(keys, **others):
    """A deep copy with other sections."""
    return copy.deepcopy(keys) | copy.deepcopy(others)


# ---- runs ------------------------------------------------------------------------------------------------

class Run:
    def __init__(self, quoin, folder, name, way, keys, model):
        self.folder = folder / name.replace(" ", "_")
        scene = folder / f"{self.folder.name}.yaml"
        scene.write_text(yaml.safe_dump(json.loads(json.dumps({"model": model} | keys, default=float)), sort_keys=False), encoding="utf-8")
        command = ["mpirun", "-q", "-n", str(way.ranks), "--oversubscribe", "--bind-to", "none"] if way.ranks > 1 else []
        with turn(alone=way.ranks > 1):
            done = subprocess.run([*command, quoin, "-options_file", scene.name, "-output", str(self.folder), *way.options], cwd=folder,
                                  capture_output=True, text=True, env=ENVIRONMENT | dict(os.environ), timeout=LONGEST)
        self.code, self.said = done.returncode, done.stderr
        self.warned = [line for line in done.stderr.splitlines() if "warning" in line and not any(word in line for word in BESIDE)]
        self.refused = self.code == 2
        if self.code not in VERDICTS:
            raise RuntimeError(f"{name}: exit code {self.code}: {done.stderr[-500:]}")
        self.results = None if self.refused else Results(self.folder)

    def stages(self):
        return {stage["name"]: stage for stage in self.results.summary["stages"]}


def bracket(stage):
    for kind in ("strength_reduction", "load_factor", "flood"):
        if stage.get(kind) is not None:
            return stage[kind]["failing"], stage[kind]["stable"]
    return None


def relative(a, b, size):
    return float(np.max(np.abs(np.asarray(a) - np.asarray(b)), initial=0.0) / size) if size > 0 else 0.0


def gap_of(a, b):
    """How far apart two brackets are, over the value; 0 where they overlap."""
    if None in a or None in b:
        return 0.0 if a == b else np.inf
    (low, high), (other_low, other_high) = sorted(a), sorted(b)
    return max(0.0, low - other_high, other_low - high) / max(abs(high), abs(other_high))


def slips(stage):
    return any(row.get("sliding_length", 0) > 0 for row in stage["joints"].values())


def differences(one, other, way):
    """(what, relative difference) of two runs, stage by stage; infinite where verdicts differ."""
    ours, theirs = one.stages(), other.stages()
    names = list(ours)[-1:] if way.last else list(ours)
    for name in names:
        stage = ours[name]
        if stage["verdict"] == UNDECIDED:
            continue  # it says itself, exit code 4; the run has ended here
        if name not in theirs:
            yield f"{name}: only one run has it", np.inf
            continue
        twin = theirs[name]
        if twin["verdict"] == UNDECIDED:
            continue
        if stage["verdict"] != twin["verdict"]:
            yield f"{name}: {stage['verdict']} against {twin['verdict']}", np.inf
            continue
        if way.bits and stage["ranks_agree"] == twin["ranks_agree"] == "bit for bit":
            yield f"{name}: checksum", 0.0 if stage["checksum"] == twin["checksum"] else np.inf
            continue
        if (limits := bracket(stage)) is not None:
            yield f"{name}: limit", gap_of(tuple(value and value * (way.levels if "flood" in stage else 1.0) for value in limits), bracket(twin))
            continue
        if stage["verdict"] not in ("converged", "completed"):
            continue
        if not way.slipped and slips(stage):
            continue
        u, w = one.results.stage(name).displacement, other.results.stage(name).displacement
        if way.image is not None:
            u = way.image(u)
        size = float(np.abs(u).max())
        if stage["verdict"] == "completed":  # what is left of a motion, over the farthest that it went
            size = max(size, float(np.max(one.results.history["u_max_m"])))
        yield f"{name}: displacement", relative(u, w, size)
        sums = [np.array([[row[key] for key in ("N", "T")] for row in (s["joints"][joint] for joint in sorted(s["joints"]))]) for s in (stage, twin)]
        if sums[0].shape == sums[1].shape:
            sums = [np.abs(s) for s in sums] if way.unsigned else sums
            sums[0] = sums[0] * way.forces
            yield f"{name}: joint forces", relative(*sums, float(np.abs(sums[0]).max()))


# ---- counts ----------------------------------------------------------------------------------------------

@dataclass
class Count:
    runs: int = 0
    worst: float = 0.0
    told: int = 0
    silent: list = field(default_factory=list)


def hunt(seed, scene, quoin, folder, counts, most=None):
    """One scene in all ways, or in `most` of them; lines about what was silent."""
    folder.mkdir(parents=True, exist_ok=True)
    write(str(folder / "model.h5"), scene.mesh)
    for name, text in scene.files.items():
        (folder / name).write_text(text, encoding="utf-8")
    said = []
    reference = Run(quoin, folder, "reference", Way(), scene.keys, "model.h5")
    if reference.refused:
        raise RuntimeError(reference.said)
    if scene.by_hand:
        note(seed, scene.kind, "by hand", list(scene.by_hand(reference)), reference.warned, counts, said, AGREE)
    ways = list(scene.ways.items())
    if most is not None:
        ways = [ways[i] for i in sorted(np.random.default_rng(seed).permutation(len(ways))[:most])]
    for name, way in ways:
        model = "model.h5"
        if way.mesh is not None:
            model = f"{name.replace(' ', '_')}.h5"
            write(str(folder / model), way.mesh)
        run = Run(quoin, folder, name, way, scene.keys if way.keys is None else way.keys, model)
        found = [("refused", np.inf)] if run.refused else list(way.compare(reference, run) if way.compare else differences(reference, run, way))
        if run.refused:
            run.warned = [run.said]
        note(seed, scene.kind, name, found, reference.warned + run.warned, counts, said, way.agree)
        if scene.by_hand and not run.refused and way.mesh is None:
            note(seed, scene.kind, "by hand", list(scene.by_hand(run)), run.warned, counts, said, AGREE, f"{name}, ")
    return said


def note(seed, kind, way, found, warned, counts, said, agree, run=""):
    count = counts[kind, way]
    what, worst = max(found, key=lambda pair: pair[1], default=("nothing to compare", 0.0))
    count.runs += 1
    if worst <= agree:
        count.worst = max(count.worst, worst)
    elif warned:
        count.told += 1
        if os.environ.get("QUOIN_HUNT_TOLD"):
            print(f"  told: seed {seed}, {kind}, {run}{way}: {what}: {100 * worst:.2g} %: {warned[0][:300]}", flush=True)
    else:
        count.silent.append(seed)
        said.append(f"seed {seed}, {kind}, {run}{way}: {what}: {100 * worst:.2g} %, without a warning")
