"""Compares a dynamic stage with Newmark's block: the yield coefficient of a stage `load_factor` of the same run, the record, the joints that slide.

    block = block_of(results, used, shakings, ky=None)     # None: nothing to compare with
    block.slip, block.stable, block.from_stage, block.joints
"""

import os
from dataclasses import dataclass

from quoin_tools.assess import newmark
from quoin_tools.base import scene
from quoin_tools.base.ground import Shaking, strongest
from quoin_tools.base.language import _
from quoin_tools.base.results import Results, ResultsError

NEVER = 1e3  # yield coefficient of the way that no stage has tried


@dataclass
class Block:
    """A rigid block with the yield coefficient of the run on its record; slip [m] along +x where way is 1, else along -x."""

    stable: float
    failing: float | None
    way: int
    from_stage: str | None  # None: the coefficient was given
    joints: list  # those that slide in the mechanism of that stage
    shaking: Shaking
    slip: newmark.Slip


def coefficients(results, used):
    """Returns (stage, k_h that stands, least that does not or None, joints that slide) of every stage that raised an earthquake along x by trials."""
    found = []
    for facts in results.summary["stages"]:
        for load, ends in ((facts.get("load_factor") or {}).get("raises") or {}).items():
            if ends.get("k_h_stable") and used.loads.get(load, {}).get("type") == "pseudo_static":
                slides = [name for name, m in (facts.get("mechanism") or {}).items() if "slides" in m["moves"]]
                found.append((facts["name"], ends["k_h_stable"], ends["k_h_failing"], slides))
    return found


def of_other(folder):
    """Coefficients that another run has found."""
    results = Results(folder)
    found = coefficients(results, scene.of_run(folder, results.summary))
    if not found:
        raise ResultsError(f"{folder}: no stage load_factor that raises an earthquake along x")
    return [(_("{0} of {1}", stage, os.path.basename(os.path.abspath(folder))), *others) for stage, *others in found]


def block_of(results, used, shakings, ky=None):
    """Returns Newmark's block for the given coefficient or output folder, else for the last stage that has a coefficient; None: no coefficient, or nothing shakes along x."""
    shaking = strongest(shakings, "x")
    found = of_other(ky) if isinstance(ky, str) else [(None, ky, None, [])] if ky is not None else coefficients(results, used)
    if shaking is None or not found:
        return None
    stage, stable, failing, joints = found[-1]
    way = 1 if stable > 0 else -1
    resistance = newmark.yielding(abs(stable), NEVER, used.gravity)
    if way < 0:
        resistance = newmark.yielding(NEVER, abs(stable), used.gravity)
    return Block(stable, failing, way, stage, joints, shaking, newmark.slide(shaking.record, resistance)[0])
