"""Blocks: a wedge that raises a block (textbook), columns that topple (Goodman and Bray 1976), a block that rocks back (Housner)
and one that a pulse overturns, a tendon in a beam (Code_Aster)."""

import os
from pathlib import Path

import assemblies
import models
import numpy as np
import yaml
from driver import PUBLISHED
from quoin_tools.limit.bounds import bound

WHAT = "blocks: a wedge that raises a block, columns that topple, a block that rocks back, one that a pulse overturns; periods of a column; a tendon in a beam"
SOURCE = "a textbook whose solutions are public programs; Goodman and Bray 1976; Housner; Cundall et al. 1979; Code_Aster test SSNP109A (examples/published/problems.yaml)"
BY = "solutions of textbooks (FOSSEE); Goodman and Bray; Housner; Code_Aster"


def run(case):
    os.environ["QUOIN_SOLVER"] = str(Path(case.quoin).resolve())
    found = case.scene_of("wedge").stage_summary("push")["load_factor"]
    case.published("wedge", {"force on the wedge [kN]": (found["stable"] + found["failing"]) / 2})
    ours = {}
    for what, model in (("least friction, middle of what stands and falls [degree]", "pt"), ("... faces in full contact [degree]", "tptm")):
        found = case.scene_of("toppling_slope", None, ("joints.default.stress_model", model)).stage_summary("weaker")["strength_reduction"]
        ours[what] = (found["stable"] + found["failing"]) / 2
    case.check("columns with faces in full contact stand by the contacts as drawn [degree]", ours["... faces in full contact [degree]"], 37.97, absolute=0.1)  # beyond them down to 36.7
    scene = assemblies.scene_of(yaml.safe_load((PUBLISHED / "toppling_slope.yaml").read_text(encoding="utf-8")))
    ours["... with dilation (quoin limit) [degree]"] = bound(models.MESHES["toppling_slope"](), scene, "weaker").value
    case.published("toppling_slope", ours)
    told = case.scene_of("rocking_block").history
    lean = 2 * np.sin(0.5 * np.arctan(0.2)) + told["top_ux_m"] - told["foot_ux_m"]  # of the top over the foot [m]
    upright = int(np.argmax(lean < 0)) + 1
    case.published("rocking_block", {"time from half of the slenderness to upright [s]": np.interp(0, -lean[:upright], told["time_s"][:upright])})
    pulse(case)
    column(case)
    result = case.scene_of("prestressed_beam")
    pulled, anchored = (1e-3 * result.stage_summary(stage)["anchors"]["tendon"]["force"] for stage in ("pulled", "anchored"))
    moved = {where: result.probe("anchored", point) for where, point in (("a quarter along", "quarter"), ("half way", "half"))}
    case.published("prestressed_beam", {"force of the tendon [kN]": anchored, "force while the jack holds 200 kN [kN]": pulled}
                   | {f"shortening, {where} [m]": -x for where, (x, _) in moved.items()} | {f"rise, {where} [m]": y for where, (_, y) in moved.items()})  # fmt: skip


def pulse(case):
    """The acceleration that overturns a block by a pulse, over that which begins to rock it, between bounds by bisection."""
    def between(low, high, trials, k=1e10):
        for _ in range(trials):
            middle = 0.5 * (low + high)
            told = case.scene_of("pulse_block", None, ("motions.pulse.scale", 0.981 * middle), ("joints.default.k_n", k), ("joints.default.k_s", k)).stage_summary("pulse")
            low, high = (low, middle) if "overturned" in told["evidence"] else (middle, high)
        return 0.5 * (low + high)

    ours = {"acceleration that overturns, over that which begins to rock it": between(1.9, 2.1, 4 if case.short else 7)}
    if not case.short:
        ours |= {"... k_n of 1 GPa/m": between(1.8, 2.0, 7, 1e9), "... k_n of 100 GPa/m": between(1.95, 2.05, 6, 1e11)}
    case.published("pulse_block", ours)


def column(case):
    """The longest period [s] along the axis, with its sides held and free, and across it, while nothing moves along it."""
    def period(along, *changes):
        modes = case.scene_of("column_of_blocks", None, *changes).stage_summary("free")["modes"]["list"]
        return max(1 / mode["f"] for mode in modes if mode[f"mass_{along}"] > 0.3 * max(other[f"mass_{along}"] for other in modes))

    held = ("supports.sides", {"target": "block", "fix": "x"}), ("plane", "strain")
    sheared = ("supports.sides", {"target": "block", "fix": "y"}), ("materials.block.young", 22.5e6), ("materials.block.poisson", 0.125)
    soft = ("joints.default.k_n", 1e7), ("joints.default.k_s", 1e7)
    case.published("column_of_blocks", {"confined compression [s]": period("y", *held), "free compression [s]": period("y"), "shear [s]": period("x", *sheared),
                                        "shear, joints of 10 MPa/m [s]": period("x", *sheared, *soft)})  # fmt: skip
