"""A rigid block on n contacts under an eccentric force: all models converge to the diagram without tension (V06)."""

import numpy as np
from driver import MODELS, changed, load
from quoin_tools.mesh.meshing import join, rectangle, renamed

WHAT = "n contacts under an eccentric force converge to the exact diagram (V06)"
SOURCE = "closed part x = 3 (L/2 - e), edge stress 2 N/x; order: slope of log(error) over log(n)"
BY = "by hand"

eccentric = load("eccentric")
# the closed part, 2/3 of the base, ends at 2/3 of the length of a contact for each n
E_OVER_L, FORCE, COUNTS = 0.5 - 2 / 9, eccentric.SMALL, (4, 16, 64)


def base_in_parts(n):
    """A rigid block on a rigid base whose top has n faces of equal length; points at the ends of the joint."""
    base = rectangle(0, -1, 1, 1, n, 1, "base", rigid=True)
    block = rectangle(0, 0, 1, 1, 1, 1, "block", rigid=True)
    corners = {name: name for name in ("bottom_left", "bottom_right")}
    return join([renamed(base, {"joint": "top"}), renamed(block, {"joint": "bottom"}, corners)])


def run(case):
    exact = 2 / (3 * (0.5 - E_OVER_L)) * FORCE
    for model in MODELS:
        scene = changed(eccentric.scene(model, E_OVER_L, FORCE), ("joints.joint", {}))
        results = case.run_all([(base_in_parts(n), scene) for n in COUNTS])
        stress = np.array([-r.stage_summary("press")["joints"]["joint"]["end"]["sigma"] for r in results])
        error = np.abs(stress / exact - 1)
        if model == "tptm":
            case.check("tptm: edge stress [Pa], exact for any n", stress, exact, relative=1e-6)
            continue
        order = -np.polyfit(np.log(COUNTS), np.log(error), 1)[0]
        case.report(f"{model}: edge stress [Pa], n = {', '.join(map(str, COUNTS))}", stress, exact)
        case.check(f"{model}: order", order, 2.0, absolute=0.1)
