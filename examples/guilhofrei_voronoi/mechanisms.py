"""Least friction of the fabrics of an ensemble by limit analysis, how each fails, and measures of it; begun again it goes on.

    PYTHONPATH=tools python examples/guilhofrei_voronoi/mechanisms.py [-j JOBS] ENSEMBLE.yaml...

A row a fabric goes into ENSEMBLE.csv; samples are those of `quoin ensemble ENSEMBLE.yaml`. Beside the linear programme a minimal cut finds the best single piece that slides: a fabric that stood with less friction than that would be an error,
which is checked."""

import csv
import math
import os
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import asdict, dataclass, fields

import numpy as np
import scipy
import shapely
from quoin_tools.base.command import Parser, command
from quoin_tools.ensemble import design
from quoin_tools.ensemble.models import Limit
from quoin_tools.ensemble.running import Samples
from quoin_tools.limit import bounds, program
from quoin_tools.mesh.blockmesh import areas, closed_rings
from quoin_tools.mesh.dam import G1

BREAK, CREST = G1.break_[1], G1.crest_upstream[1]  # m: levels where the slope changes and of the crest
WIDTH = G1.crest_downstream[0] - G1.crest_upstream[0]  # m
STONE = 2.0  # m: mean side of a stone
MOVES = 0.01  # of the fastest: what is slower rests
STEPS = (2.0, 1.0, 0.5, 0.25, 0.1, 0.03)  # degrees between directions in which a piece is pushed
GAIN = 0.02  # degrees by which a direction must be better than those before
OVERHANG = 120.0  # degrees below the horizontal, downstream: a way that turns back farther is none
FLOW = 10**9  # capacity of what cannot be cut


@dataclass
class Fabric:
    """A row; lengths in m, angles in degrees."""

    sample: int
    seed: int
    least: float  # friction with which the blocks can stand; inf: they do not with that of the scene
    place: str  # where it fails: crest, facing, face, body
    moves: float  # part of the section that does
    lowest: float  # level of the lowest point that moves
    dip: float  # of the line from the upstream to the downstream end of the failing surface
    rough: float  # length of that surface over the line
    way: float  # dip that a way along joints from face to face nowhere falls short of, the steepest of all ways
    way_crest: float  # the same, above the change of slope
    piece: float  # friction that the best single piece that slides needs
    across: float  # stones that a level cut of the crest crosses, on average
    through: float  # widest stone at the crest over the width of the crest
    side: float  # mean side between polygons


NAMES = [field.name for field in fields(Fabric)]


def fabric(judge, sample, values):
    """One of an ensemble."""
    mesh = judge.mesh_of(values, sample)
    found = bounds.bound(mesh, judge.scene, judge.stage)
    parts, loads = found.parts, sum(found.loads.values())
    least = math.inf if found.value is None else float(found.value)
    motion = found.limit.motion if found.limit else program.missing(parts, loads).limit.motion
    bodies = shapely.union_all(np.append(shapely.polygons(mesh.vertices[closed_rings(mesh)]), None)[rows_of(parts.body, parts.n)], axis=1)
    facing = np.zeros(parts.n, dtype=bool)
    facing[parts.body[np.array(mesh.group_names)[mesh.block_group] == "facing"]] = True
    moving, size = moving_of(mesh, parts, motion), np.bincount(parts.body, np.abs(areas(mesh)), parts.n)
    left, low, right, high = shapely.bounds(bodies).T
    upper = (parts.centre[:, 1] > BREAK) & ~facing
    cuts = np.arange(BREAK + 0.1, CREST, 0.1)[:, None]
    inner = ~facing[parts.contacts.a] & ~facing[parts.contacts.b] & (parts.contacts.length > 0)
    ends, core = np.stack([parts.contacts.p, parts.contacts.q], axis=1)[inner], shapely.union_all(bodies[~facing])
    return Fabric(sample, int(values[0]), least, place(mesh, parts, moving, low, facing, size), float(size[moving].sum() / size.sum()), float(low[moving].min()),
                  *surface(parts.contacts, moving), steepest_way(ends, core), steepest_way(ends, core, BREAK - STONE), checked(piece(parts, loads), least, values),
                  float(((low < cuts) & (high > cuts)).sum(axis=1).mean()), float((right - left)[upper].max(initial=0.0) / WIDTH), float(parts.contacts.length[inner].mean()))  # fmt: skip


def rows_of(body, n):
    """(n, most) blocks of each body; -1 where it has no more."""
    order, count = np.argsort(body, kind="stable"), np.bincount(body, minlength=n)
    rows = np.full((n, count.max()), -1)
    rows[np.arange(count.max()) < count[:, None]] = order
    return rows


def checked(needed, least, values):
    if needed > least + GAIN:
        sys.exit(f"seed {values[0]:g}: limit analysis stands with {least:.3f} degrees, but one piece slides with {needed:.3f}")
    return needed


# ---- how it fails ------------------------------------------------------------------------------------------

def moving_of(mesh, parts, motion):
    """Bodies that move."""
    used = mesh.blocks >= 0
    speed = np.zeros(parts.n)
    np.maximum.at(speed, np.repeat(parts.body, used.sum(axis=1)), np.hypot(*program.velocities(parts, motion)[mesh.blocks[used]].T))
    return speed > MOVES * speed.max()


def place(mesh, parts, moving, low, facing, size):
    """crest: nothing that moves reaches lower than a stone below the change of slope. facing: all but a tenth of what moves is facing. face: stones
    that the water does not press leave the downstream face. body: a part of the dam from face to face."""
    wet = np.zeros(parts.n, dtype=bool)
    wet[parts.body[mesh.face_sets["upstream"][:, 0]]] = True
    if low[moving].min() > BREAK - STONE:
        return "crest"
    if size[moving & facing].sum() > 0.9 * size[moving].sum():
        return "facing"
    return "body" if (moving & wet).any() else "face"


def surface(contacts, moving):
    """(dip of the line from the upstream to the downstream end of what parts those that move from the others, its length over that line)."""
    border = (moving[contacts.a] != moving[contacts.b]) & (contacts.length > 0)
    ends = np.concatenate([contacts.p[border], contacts.q[border]])
    first, last = ends[np.argmin(ends[:, 0])], ends[np.argmax(ends[:, 0])]
    return float(np.degrees(np.arctan2(first[1] - last[1], last[0] - first[0]))), float(contacts.length[border].sum() / max(math.dist(first, last), 1e-9))


# ---- how smooth it is --------------------------------------------------------------------------------------

def steepest_way(ends, core, above=-math.inf):
    """Of all ways along joints (ends: (n, 2, 2)) from the upstream to the downstream side of the polygons, the dip that the best nowhere falls short of. above: level below which no way goes."""
    ends = ends[ends[:, :, 1].min(axis=1) > above]
    points, at = np.unique(ends.reshape(-1, 2).round(6), axis=0, return_inverse=True)
    one, two = at.reshape(-1, 2).T
    one, two = np.concatenate([one, two]), np.concatenate([two, one])
    step = points[two] - points[one]
    dip = np.degrees(np.arctan2(-step[:, 1], step[:, 0]))
    outline = core.exterior
    on = shapely.dwithin(shapely.points(points), outline, 1e-5) & (points[:, 1] < CREST - 1e-5)
    middle = np.array([np.mean(shapely.intersection(core, shapely.LineString([(-1e3, y), (1e3, y)])).bounds[::2]) for y in points[on, 1]])
    side = np.zeros(len(points), dtype=int)  # 1 upstream, 2 downstream
    side[on] = np.where(points[on, 0] < middle, 1, 2)
    n = len(points)

    def passes(least):
        use = (dip >= least) & (dip <= OVERHANG)
        start = np.flatnonzero(side == 1)
        rows, columns = np.concatenate([one[use], np.full(len(start), n)]), np.concatenate([two[use], start])
        graph = scipy.sparse.csr_matrix((np.ones(len(rows)), (rows, columns)), shape=(n + 1, n + 1))
        reached = scipy.sparse.csgraph.breadth_first_order(graph, n, return_predecessors=False)
        return (side[reached[reached < n]] == 2).any()

    steps = np.unique(dip)
    low, high = -1, len(steps)  # of those that pass, of those that do not
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if passes(steps[middle]) else (low, middle)
    return float(steps[low]) if low >= 0 else -180.0


# ---- one piece that slides ---------------------------------------------------------------------------------

def piece(parts, loads):
    """The largest friction at which some bodies can still leave all others in one direction, while every joint between them opens by the angle of friction."""
    best, at = 0.0, None
    for step in STEPS:
        for direction in np.arange(-180.0, 180.0, step) if step == STEPS[0] else () if at is None else (at - step, at + step):
            if best + GAIN < 89.0 and leaves(parts, loads, direction, best + GAIN):
                low, high = best + GAIN, 89.0
                while high - low > 1e-3:
                    middle = 0.5 * (low + high)
                    low, high = (middle, high) if leaves(parts, loads, direction, middle) else (low, middle)
                best, at = low, direction
    return float(best)


def leaves(parts, loads, direction, friction):
    """Whether loads do work on some bodies that move this way while the others rest. A body whose joint would close takes the one behind the joint with it: the best such set is a minimal cut."""
    way = np.array([math.cos(math.radians(direction)), math.sin(math.radians(direction))])
    gain = np.where(parts.ground, 0.0, loads[:, :2] @ way)
    if not (total := gain[gain > 0].sum()) > 0:
        return False
    contacts, n = parts.contacts, parts.n
    opening, sliding = contacts.normal @ way, math.tan(math.radians(friction)) * np.abs(contacts.along @ way) - 1e-9
    not_b, not_a = opening < sliding, -opening < sliding  # cannot go without the other
    whole = np.where(parts.ground, FLOW, np.round(np.abs(gain) * (1e8 / total)).clip(max=FLOW)).astype(np.int32)
    up, down = np.flatnonzero(gain > 0), np.flatnonzero((gain < 0) | parts.ground)
    rows = np.concatenate([contacts.b[not_b], contacts.a[not_a], np.full(len(up), n), down])
    columns = np.concatenate([contacts.a[not_b], contacts.b[not_a], up, np.full(len(down), n + 1)])
    capacity = np.concatenate([np.full(not_b.sum() + not_a.sum(), FLOW, dtype=np.int32), whole[up], whole[down]])
    pairs = np.unique(np.column_stack([rows, columns]), axis=0, return_index=True)[1]  # two joints between the same bodies are one
    graph = scipy.sparse.csr_matrix((capacity[pairs], (rows[pairs], columns[pairs])), shape=(n + 2, n + 2))
    return scipy.sparse.csgraph.maximum_flow(graph, n, n + 1).flow_value < int(whole[up].sum()) - n


# ---- rows --------------------------------------------------------------------------------------------------

def read(path, mark=None):
    """[Fabric] of a file; none if it is of another ensemble. A line that a kill has cut is dropped."""
    if not os.path.exists(path):
        return []
    with open(path, encoding="utf-8", newline="") as file:
        text = file.read()
    head, *rows = list(csv.reader(text[: text.rfind("\n") + 1].splitlines()))[:] or [[]]
    if head[1:] != NAMES or (mark and head[0] != mark):
        return []
    kinds = [field.type for field in fields(Fabric)]
    return [Fabric(*(kind(cell) for kind, cell in zip(kinds, row[1:]))) for row in rows]


def ensemble(path, jobs):
    """The fabrics of one file that are missing."""
    wanted, rows = design.read(path), os.path.splitext(path)[0] + ".csv"
    known = read(rows, wanted.mark)
    done = {one.sample for one in known}
    todo = [i for i in range(wanted.samples) if i not in done]
    with open(rows + ".new", "w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow([wanted.mark, *NAMES])
        table.writerows(["", *asdict(one).values()] for one in known)
    os.replace(rows + ".new", rows)
    if not todo:
        return
    judge, samples = Limit(wanted, os.path.splitext(path)[0]), Samples(wanted)
    with open(rows, "a", encoding="utf-8", newline="") as file, (ProcessPoolExecutor(jobs) if jobs > 1 else ThreadPoolExecutor(1)) as pool:
        table = csv.writer(file, lineterminator="\n")
        for one in pool.map(fabric, [judge] * len(todo), todo, [samples.of(i)[0] for i in todo]):
            table.writerow(["", *asdict(one).values()])
            file.flush()


def main(words=None):
    parser = Parser(prog="mechanisms.py", description=__doc__.splitlines()[0])
    parser.add_argument("ensembles", nargs="+", metavar="ENSEMBLE.yaml")
    parser.add_argument("-j", "--jobs", type=int, default=1, help="fabrics at a time")
    given = parser.parse_args(words)
    for path in given.ensembles:
        ensemble(path, given.jobs)
    return 0


if __name__ == "__main__":
    sys.exit(command(main))
