"""Hunt for silent differences: random dams, walls, slopes and columns, each solved in several ways that must agree.

    python tests/verification/hunt.py --seeds 1-8                            # minutes
    python tests/verification/hunt.py --minutes 60 --table docs/generated/hunt.md
    python tests/verification/hunt.py --seeds 17 --keep /tmp/17              # one scene, its folders stay for a look

The explicit method on one rank with fixed connectivity is held against two and three ranks (the same bits), Newton's method, condensed bodies,
variable connectivity, and images of the scene (mirrored, blocks and vertices renumbered, coordinates rounded): displacements, forces of joints
and limits of trials within 0.5 %, the same verdicts. A larger difference must be told
by a warning of one of the two runs; one that ends undecided says so itself. Exit code 0: nothing silent; 1: something was; 2: a run could not be made."""

import argparse
import copy
import os
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import yaml

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from driver import ENVIRONMENT, MODELS, ROOT, VERDICTS  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh.blockmesh import BlockMesh, write  # noqa: E402
from quoin_tools.mesh.dam import dam_mesh, gravity_section  # noqa: E402
from quoin_tools.mesh.meshing import join, rectangle, renamed  # noqa: E402
from quoin_tools.mesh.stacks import block_on_plane  # noqa: E402
from quoin_tools.mesh.walls import wall  # noqa: E402

AGREE = 5e-3  # displacements, forces and limits
ROUNDED = {"dam": 3, "slope": 5, "wall": 5, "column": 5}  # digits of coordinates [m]: 1 mm of a dam, 0.01 mm of small blocks
UNDECIDED = "undecided"
LONGEST = 300  # s of one run


@dataclass
class Scene:
    """A scene of the hunt; deformable: groups that can be condensed; exact: (stage, limit) by hand."""

    kind: str
    mesh: object
    keys: dict
    deformable: list = field(default_factory=list)
    exact: tuple | None = None


def joint(rng, stiff=(9.5, 11.0), friction=(35, 55)):
    """A random row of a joint that only rubs, most often the one of the default stress model."""
    k_n = 10 ** rng.uniform(*stiff)
    model = "tptm" if rng.random() < 0.6 else str(rng.choice(MODELS))
    return {"k_n": float(k_n), "k_s": float(k_n * rng.uniform(0.2, 0.6)), "friction": float(rng.uniform(*friction)), "stress_model": model}


def elastic(rng, density=2400.0):
    return {"density": density, "young": float(10 ** rng.uniform(9.5, 10.5)), "poisson": float(rng.uniform(0.1, 0.3))}


def frame(**keys):
    return {"relaxation": {"tolerance": 1e-8, "velocity_tolerance": 1e-8, "max_cycles": 400000}, **keys}


def reduction(loads, bracket=0.1):
    return {"limit": {"type": "strength_reduction", "what": "friction", "loads": loads, "step": 5, "limit": 2, "bracket": bracket}}


def dam(rng):
    section = gravity_section(float(rng.uniform(20, 80)), float(rng.uniform(3, 8)), float(rng.uniform(0, 0.1)),
                              slope=float(rng.uniform(0.65, 0.85)), base_slope=float(rng.choice([0.0, 0.03, 0.08])))
    level = float(rng.uniform(0.6, 0.95) * section.height())
    loads = {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": {"type": "reservoir", "faces": "upstream", "level": level}}
    keys = frame(materials={"dam": elastic(rng), "rock": elastic(rng)}, joints={"default": {"law": "elastic", "k_n": 1e10, "k_s": 3e9}, "base": {"law": "mohr_coulomb"} | joint(rng, friction=(45, 60))},
                 supports={"rock_sides": {"fix": "x"}, "rock_bottom": {"fix": "y"}}, loads=loads,
                 stages=[{"sw": {"loads": ["weight"]}}, {"swhp": {"loads": ["weight", "water"]}}, reduction(["weight", "water"])])
    keys["relaxation"]["groups"] = ["dam"]
    return Scene("dam", dam_mesh(section, int(rng.integers(5, 11)), rock_extent=1.5), keys, ["dam", "rock"])


def slope(rng):
    dip = float(rng.uniform(10, 35))
    rigid = bool(rng.random() < 0.5)
    mesh = block_on_plane(float(rng.uniform(1, 3)), float(rng.uniform(0.2, 0.8)), dip, rigid=rigid)
    block = {"density": 2400.0} if rigid else elastic(rng)
    row = joint(rng, (9, 10.5), (dip + 8, dip + 25))
    keys = frame(materials={"base": {"density": 2400}, "block": block}, joints={"default": row}, supports={"base": {"fix": "xy"}},
                 loads={"weight": {"type": "self_weight", "groups": ["block"]}},
                 stages=[{"stand": {"loads": ["weight"]}}, reduction(["weight"])])
    return Scene("slope", mesh, keys, [] if rigid else ["block"], ("limit", dip))


def masonry(rng):
    rigid = bool(rng.random() < 0.5)
    blocks, courses = int(rng.integers(3, 7)), int(rng.integers(4, 9))
    mesh = wall(blocks, courses, divide=(1, 1), rigid=rigid)
    block = {"density": 2200.0} if rigid else elastic(rng, 2200.0)
    weight = 2200 * 9.81 * blocks * courses * 0.5
    push = float(rng.uniform(0.02, 0.1) * weight / (0.5 * courses))
    keys = frame(materials={"base": {"density": 2200}, "block": block}, joints={"default": joint(rng, (9, 10.5), (30, 45))},
                 supports={"base": {"fix": "xy"}},
                 loads={"weight": {"type": "self_weight", "groups": ["block"]}, "push": {"type": "traction", "faces": "left", "value": [push, 0.0]}},
                 stages=[{"sw": {"loads": ["weight"]}}, {"pushed": {"loads": ["weight", "push"]}}, reduction(["weight", "push"], 0.25)])
    return Scene("wall", mesh, keys, [] if rigid else ["block"])


def column(rng):
    n, size = int(rng.integers(2, 7)), float(rng.uniform(0.5, 2))
    rigid = bool(rng.random() < 0.3)
    divide = 1 if rigid else int(rng.integers(1, 4))
    bodies = [rectangle(-size, -size, 3 * size, size, group="base", rigid=True)]
    bodies += [rectangle(0, i * size, size, size, divide, divide, group="block", rigid=rigid) for i in range(n)]
    mesh = join([renamed(body, {"pushed": "left"} if i else {}, {f"block_{i}": "top_left"}) for i, body in enumerate(bodies)])
    block = {"density": 2400.0} if rigid else elastic(rng)
    push = float(rng.uniform(0.05, 0.25) * 2400 * 9.81 * size / n)  # it overturns at size/n of the weight
    keys = frame(materials={"base": {"density": 2400}, "block": block}, joints={"default": joint(rng, (9, 11), (35, 50))},
                 supports={"base": {"fix": "xy"}},
                 loads={"weight": {"type": "self_weight", "groups": ["block"]}, "push": {"type": "traction", "faces": "pushed", "value": [push, 0.0]}},
                 stages=[{"sw": {"loads": ["weight"]}}, {"pushed": {"loads": ["weight", "push"]}}])
    return Scene("column", mesh, keys, [] if rigid else ["block"])


KINDS = (dam, slope, masonry, column)


def scene_of(seed):
    return KINDS[seed % len(KINDS)](np.random.default_rng(seed))


# ---- images ----------------------------------------------------------------------------------------------

@dataclass
class Image:
    """The same problem written otherwise; vertices: where each vertex of the scene is in the image; sign: of its displacement."""

    mesh: object
    keys: dict
    vertices: np.ndarray
    sign: tuple = (1.0, 1.0)

    def back(self, displacement):
        return displacement[self.vertices] * self.sign


def images(scene, seed):
    mesh = scene.mesh
    return {"mirrored": mirrored(mesh, scene.keys), "renumbered": renumbered(mesh, scene.keys, np.random.default_rng(seed)),
            "rounded": Image(with_vertices(mesh, np.round(mesh.vertices, ROUNDED[scene.kind])), scene.keys, np.arange(len(mesh.vertices)))}


def with_vertices(mesh, vertices):
    return BlockMesh(vertices, mesh.blocks, mesh.block_group, mesh.group_names, mesh.group_rigid, mesh.face_sets, mesh.points)


def mirrored(mesh, keys):
    """x becomes -x: rings turn round, so face k of a block with n corners becomes n - 1 - k; tractions change their side."""
    corners = np.where(mesh.blocks[:, 3] < 0, 3, 4)
    blocks = np.where(corners[:, None] == 4, mesh.blocks[:, [0, 3, 2, 1]], mesh.blocks[:, [0, 2, 1, 3]])
    sets = {name: np.column_stack([rows[:, 0], corners[rows[:, 0]] - 1 - rows[:, 1]]) for name, rows in mesh.face_sets.items()}
    keys = copy.deepcopy(keys)
    for load in keys["loads"].values():
        if "value" in load:
            load["value"][0] *= -1
    image = BlockMesh(mesh.vertices * [-1, 1], blocks, mesh.block_group, mesh.group_names, mesh.group_rigid, sets, mesh.points)
    return Image(image, keys, np.arange(len(mesh.vertices)), (-1.0, 1.0))


def renumbered(mesh, keys, rng):
    """Blocks and vertices in a random order, rows of materials and joints in the opposite one."""
    vertex, block = rng.permutation(len(mesh.vertices)), rng.permutation(len(mesh.blocks))
    place, row = np.argsort(vertex), np.argsort(block)
    sets = {name: np.column_stack([row[rows[:, 0]], rows[:, 1]]) for name, rows in mesh.face_sets.items()}
    points = {name: place[at] for name, at in mesh.points.items()}
    blocks = np.where(mesh.blocks < 0, -1, place[mesh.blocks])[block]
    image = BlockMesh(mesh.vertices[vertex], blocks, mesh.block_group[block], mesh.group_names, mesh.group_rigid, sets, points)
    turned = {name: dict(reversed(rows.items())) if name in ("materials", "joints") else rows for name, rows in keys.items()}
    return Image(image, turned, place)


# ---- runs ------------------------------------------------------------------------------------------------

def ways(scene):
    """Name to (ranks, options): the first is the reference."""
    found = {"explicit": (1, ()), "two ranks": (2, ()), "Newton": (1, ("-relaxation_method", "preconditioned")),
             "variable": (1, ("-contact_connectivity", "variable"))}
    if scene.kind != "slope":  # it has two bodies
        found["three ranks"] = (3, ())
    if scene.deformable:
        found["condensed"] = (1, tuple(word for group in scene.deformable for word in (f"-materials_{group}_condensed", "true")))
    return found


class Run:
    def __init__(self, quoin, folder, way, ranks, options, scene="scene.yaml"):
        self.folder = folder / way.replace(" ", "_")
        command = ["mpirun", "-q", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"] if ranks > 1 else []
        done = subprocess.run([*command, quoin, "-options_file", scene, "-output", str(self.folder), *options], cwd=folder,
                              capture_output=True, text=True, env=ENVIRONMENT | dict(os.environ), timeout=LONGEST)
        self.code, self.said = done.returncode, done.stderr
        self.warned = [line for line in done.stderr.splitlines() if "warning" in line]
        self.refused = self.code == 2
        if self.code not in VERDICTS:
            raise RuntimeError(f"{way}: exit code {self.code}: {done.stderr[-500:]}")
        self.results = None if self.refused else Results(self.folder)

    def stages(self):
        return {stage["name"]: stage for stage in self.results.summary["stages"]}


def bracket(stage):
    trials = stage.get("strength_reduction")
    return None if trials is None else (trials["failing"], trials["stable"])


def relative(a, b, size):
    return float(np.max(np.abs(np.asarray(a) - np.asarray(b)), initial=0.0) / size) if size > 0 else 0.0


def differences(one, other, same_bits=False, image=None):
    """(what, relative difference) of two runs, stage by stage; infinite where verdicts differ."""
    ours, theirs = one.stages(), other.stages()
    for name, stage in ours.items():
        if name not in theirs:
            yield f"{name}: only one run has it", np.inf
            continue
        twin = theirs[name]
        if UNDECIDED in (stage["verdict"], twin["verdict"]):
            continue  # it says itself, exit code 4
        if stage["verdict"] != twin["verdict"]:
            yield f"{name}: {stage['verdict']} against {twin['verdict']}", np.inf
            continue
        if same_bits:
            yield f"{name}: checksum", 0.0 if stage["checksum"] == twin["checksum"] else np.inf
            continue
        if (limits := bracket(stage)) is not None:
            yield f"{name}: limit", gap_of(limits, bracket(twin))
            continue
        if stage["verdict"] != "converged":
            continue
        u, w = one.results.stage(name).displacement, other.results.stage(name).displacement
        w = image.back(w) if image else w
        yield f"{name}: displacement", relative(u, w, float(np.abs(u).max()))
        forces = [[abs(s["joints"][joint][key]) for joint in sorted(s["joints"]) for key in ("N", "T")] for s in (stage, twin)]
        if len(forces[0]) == len(forces[1]):
            yield f"{name}: joint forces", relative(*forces, float(np.abs(forces[0]).max()))


def gap_of(a, b):
    """How far apart two brackets are, over the value; 0 where they overlap."""
    if None in a or None in b:
        return 0.0 if a == b else np.inf
    (low, high), (other_low, other_high) = sorted(a), sorted(b)
    return max(0.0, low - other_high, other_low - high) / max(high, other_high)


@dataclass
class Count:
    runs: int = 0
    worst: float = 0.0
    told: int = 0
    silent: list = field(default_factory=list)


def hunt(seed, quoin, folder, counts):
    """One scene in all ways; lines about what was silent."""
    scene = scene_of(seed)
    folder.mkdir(parents=True, exist_ok=True)
    put(folder, "scene", scene.mesh, scene.keys)
    reference, said = None, []
    for way, (ranks, options) in ways(scene).items():
        run = Run(quoin, folder, way, ranks, options)
        if reference is None:
            if run.refused:
                raise RuntimeError(run.said)
            reference = run
            if scene.exact:
                note(seed, scene.kind, "by hand", [by_hand(run, scene.exact)], run.warned, counts, said)
            continue
        found = [("refused", np.inf)] if run.refused else list(differences(reference, run, way.endswith(" ranks")))
        if run.refused:
            run.warned = [run.said]
        note(seed, scene.kind, way, found, reference.warned + run.warned, counts, said)
    for way, image in images(scene, seed).items():
        put(folder, way, image.mesh, image.keys)
        run = Run(quoin, folder, way, 1, (), f"{way}.yaml")
        if run.refused:
            run.warned = [run.said]
        found = [("refused", np.inf)] if run.refused else list(differences(reference, run, image=image))
        note(seed, scene.kind, way, found, reference.warned + run.warned, counts, said)
    return said


def put(folder, name, mesh, keys):
    write(str(folder / f"{name}.h5"), mesh)
    text = yaml.safe_dump({"model": f"{name}.h5"} | copy.deepcopy(keys), sort_keys=False)
    (folder / f"{name}.yaml").write_text(text, encoding="utf-8")


def by_hand(run, exact):
    stage, value = exact
    limits = bracket(run.stages()[stage])
    return f"{stage}: limit by hand {value:.3f}", gap_of(limits, (value, value))


def note(seed, kind, way, found, warned, counts, said):
    count = counts[kind, way]
    what, worst = max(found, key=lambda pair: pair[1], default=("nothing to compare", 0.0))
    count.runs += 1
    if worst <= AGREE:
        count.worst = max(count.worst, worst)
    elif warned:
        count.told += 1
    else:
        count.silent.append(seed)
        said.append(f"seed {seed}, {kind}, {way}: {what}: {100 * worst:.2g} %, without a warning")


def table(counts):
    lines = ["| scene | way | runs | largest difference of those that agree | told by a warning | silent |", "|---|---|---|---|---|---|"]
    for (kind, way), count in sorted(counts.items()):
        lines.append(f"| {kind} | {way} | {count.runs} | {100 * count.worst:.2g} % | {count.told} | {len(count.silent)} |")
    return lines


def seeds_of(text):
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--seeds", type=seeds_of, help="such as 1-8")
    parser.add_argument("--minutes", type=float, help="as many seeds as fit in, from 1 on")
    parser.add_argument("--keep", type=Path, help="folder for the runs, which stay there")
    parser.add_argument("--table", type=Path, help="document to write (Markdown)")
    given = parser.parse_args()
    start, counts, silent, broken = time.monotonic(), defaultdict(Count), [], []
    seeds = given.seeds or range(1, 10**9 if given.minutes else 9)
    with tempfile.TemporaryDirectory(prefix="quoin_hunt_") as temporary:
        n = 0
        for seed in seeds:
            if given.minutes and time.monotonic() - start > 60 * given.minutes:
                break
            n += 1
            try:
                said = hunt(seed, str(Path(given.quoin).resolve()), (given.keep or Path(temporary)) / str(seed), counts)
            except (RuntimeError, subprocess.TimeoutExpired, ValueError) as error:
                broken.append(f"seed {seed}, {KINDS[seed % len(KINDS)].__name__}: {error}")
                said = broken[-1:]
            silent += said
            print("\n".join(said) if said else f"seed {seed}: agree, or told", flush=True)
    minutes = (time.monotonic() - start) / 60
    lines = [f"{n} scenes, {sum(count.runs for count in counts.values())} comparisons, {minutes:.0f} min.", "", *table(counts)]
    print("\n".join(lines))
    if given.table:
        head = ["# The hunt", "", "Written by `tests/verification/hunt.py`; [verification](../verification.md#the-hunt) says what it is.", ""]
        given.table.write_text("\n".join([*head, *lines, ""]), encoding="utf-8")
    return 2 if broken else int(bool(silent))


if __name__ == "__main__":
    sys.exit(main())
