"""Finds the records that shook a run: the motions of its supports in dynamic stages (docs/reference/motions.md).

    for shaking in of_run(results, scene): shaking.support, shaking.direction, shaking.record
"""

from dataclasses import dataclass

from quoin_tools.base import record
from quoin_tools.base.language import _
from quoin_tools.base.record import Record, RecordError
from quoin_tools.base.scene import find

ALIKE = 1e-6  # largest accelerations, of the file and of the run
INCIDENT = 2.0  # the surface of free ground moves by so many times the wave that comes up


@dataclass
class Shaking:
    """A support that moves along x or y; times of the record are those of dynamic stages."""

    support: str
    direction: str
    boundary: str
    record: Record  # of free ground, also where the scene gives the wave that comes in

    @property
    def words(self):
        return _("{0} along {1}", self.support, self.direction)


def components(path, quantity, direction, name):
    """{x or y: Record} of a file."""
    t, x, fast = record.columns(path)
    along = "xy" if x.shape[1] == 2 else direction
    made = record.from_velocity if quantity == "velocity" or fast else Record
    return {axis: made(name, t, column) for axis, column in zip(along, x.T)}


def of_motion(results, scene, name):
    """Reads a motion of the scene: the file that the run wrote where it was scaled or corrected, else the file of the scene."""
    keys = scene.motions[name]
    changed = keys.get("pga") is not None or float(keys.get("scale", 1)) != 1 or keys.get("baseline", "none") != "none"
    wanted = f"motion_{name}.csv" if changed else str(keys.get("file", ""))
    path = find(results.folder, wanted)
    if path is None:
        raise RecordError(f"{results.folder}: '{wanted}', the record of motion '{name}', is not there")
    return components(path, keys.get("quantity", "acceleration"), keys.get("direction", "xy"), name)


def of_support(results, scene, name):
    """{x or y: Record} that a support follows; {}: it does not move."""
    keys = scene.supports[name]
    followed = keys.get("motion") or []
    followed = [followed] if isinstance(followed, str) else followed
    records = {}
    for motion in map(str, followed):
        if motion in scene.motions:
            records |= of_motion(results, scene, motion)
            continue
        path = find(results.folder, motion)
        if path is None:
            raise RecordError(f"{results.folder}: '{motion}', which support '{name}' follows, is not there")
        records |= components(path, keys.get("quantity", "velocity"), "xy", name)
    free = keys.get("boundary", "fixed") != "fixed"  # waves have both components, whatever the support fixes
    return {axis: r for axis, r in records.items() if (free or axis in keys.get("fix", "xy")) and r.a.any()}


def check(results, shaking):
    """Raises RecordError where the file is no longer that of the run."""
    for stage in results.summary["stages"]:
        was = (stage.get("motion") or {}).get(f"{shaking.support}_{shaking.direction}")
        largest = was and was.get("largest_acceleration")
        if largest and abs(largest - shaking.record.pga) > ALIKE * largest:
            raise RecordError(f"{shaking.record.name}: its largest acceleration is {shaking.record.pga:.6g} m/s2, in the run it was {largest:.6g}")


def of_run(results, scene):
    """Every support that moves, along x and along y; RecordError where a record is not there or another one."""
    found = []
    for name, keys in scene.supports.items():
        for axis, r in of_support(results, scene, name).items():
            found.append(Shaking(name, axis, keys.get("boundary", "fixed"), r))
            check(results, found[-1])
            if keys.get("boundary", "fixed") != "fixed" and keys.get("input", "outcrop") == "incident":
                found[-1].record = r.scaled(INCIDENT)
    return found


def strongest(shakings, direction=None):
    """The one with the largest acceleration; None: nothing moves."""
    mine = [s for s in shakings if direction in (None, s.direction)]
    return max(mine, key=lambda s: s.record.pga, default=None)
