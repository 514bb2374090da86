"""Cantilever 10 m by 1 m in plane stress: how stiff the full Q4 and the T3 are in bending (V03)."""

import sys
from pathlib import Path

import numpy as np
from driver import changed, load
from quoin_tools.mesh.stacks import cantilever
from triangle_dam import triangle_dam

sys.path.insert(0, str(Path(__file__).parent))
import qm6  # noqa: E402

WHAT = "bending of one row of Q4 and T3: deflection over the exact one (V03); blocks of one point on trapezoids (V14)"
SOURCE = ("pure bending: 1 / ([1/(1+nu)] [1/(1-nu) + r^2/2]), r = length/height of an element; tip load: implicit solution; "
          "qm6.py: independent incompatible modes")
BY = "closed form by hand; independent finite elements of this project"

E, LENGTH, MOMENT, LOAD = 1e9, 10.0, 1e3, 1e2
INERTIA = 1.0 / 12
SCENE = {
    "plane": "stress", "strain": "small",
    "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "ramp": 100, "max_cycles": 10000000, "history_every": 10000},
    "materials": {"body": {"density": 0, "young": E, "poisson": 0.0}},
}
BENT = changed(SCENE, ("supports", {"left": {"fix": "x"}, "bottom_left": {"fix": "y"}}),
               ("loads", {"top": {"type": "point_force", "point": "top_right", "value": [-MOMENT, 0]},
                          "bottom": {"type": "point_force", "point": "bottom_right", "value": [MOMENT, 0]}}),
               ("stages", [{"bend": {"loads": ["top", "bottom"]}}]))
LOADED = changed(SCENE, ("supports", {"left": {"fix": "xy"}}),
                 ("loads", {"tip": {"type": "traction", "faces": "right", "value": [0, LOAD]}}),
                 ("stages", [{"tip": {"loads": ["tip"]}}]))

# nx, ny, triangles, deflection over Timoshenko's (nu = 0, shear factor 5/6), four digits
TIP = [(8, 1, False, 0.5608), (16, 1, False, 0.8358), (32, 1, False, 0.9525), (16, 4, False, 0.8363),
       (16, 1, True, 0.2821), (64, 1, True, 0.3323)]


# the same of element: bending; on rectangles the incompatible modes of Wilson and Taylor (QM6) give these numbers
TIP_BENDING = [(8, 1, 0.9951), (16, 1, 0.9980)]


def run(case):
    rows = [(nx, nu) for nu in (0.0, 0.2, 0.3) for nx in (5, 10, 20)]
    results = case.run_all([(cantilever(nx, 1), changed(BENT, ("materials.body.poisson", nu))) for nx, nu in rows])
    exact = MOMENT * LENGTH**2 / (2 * E * INERTIA)
    for (nx, nu), result in zip(rows, results):
        r = LENGTH / nx
        stiff = (1 / (1 - nu) + r**2 / 2) / (1 + nu)
        deflection = [result.probe("bend", point)[1] for point in ("bottom_right", "top_right")]
        case.check(f"pure bending, {nx} x 1 Q4, nu = {nu}", np.array(deflection) / exact, 1 / stiff, relative=1e-4)

    results = case.run_all([(cantilever(nx, ny, triangles=triangles), LOADED) for nx, ny, triangles, _ in TIP])
    exact = LOAD * LENGTH**3 / (3 * E * INERTIA) + LOAD * LENGTH / (5 / 6 * E / 2)
    for (nx, ny, triangles, expected), result in zip(TIP, results):
        deflection = np.mean([result.probe("tip", point)[1] for point in ("bottom_right", "top_right")])
        case.check(f"tip load, {nx} x {ny} {'T3' if triangles else 'Q4'}", deflection / exact, expected, absolute=1e-4)

    # one-point blocks of exact bending: pure bending of rectangles for any Poisson's ratio
    results = case.run_all([(cantilever(nx, 1), changed(BENT, ("materials.body.poisson", nu), ("materials.body.element", "bending")))
                            for nx, nu in rows])
    exact = MOMENT * LENGTH**2 / (2 * E * INERTIA)
    for (nx, nu), result in zip(rows, results):
        deflection = [result.probe("bend", point)[1] for point in ("bottom_right", "top_right")]
        case.check(f"pure bending, {nx} x 1 Q4, element: bending, nu = {nu}", np.array(deflection) / exact, 1.0, relative=1e-4)

    results = case.run_all([(cantilever(nx, ny), changed(LOADED, ("materials.body.element", "bending"))) for nx, ny, _ in TIP_BENDING])
    exact = LOAD * LENGTH**3 / (3 * E * INERTIA) + LOAD * LENGTH / (5 / 6 * E / 2)
    for (nx, ny, expected), result in zip(TIP_BENDING, results):
        deflection = np.mean([result.probe("tip", point)[1] for point in ("bottom_right", "top_right")])
        case.check(f"tip load, {nx} x {ny} Q4, element: bending", deflection / exact, expected, absolute=1e-4)
    trapezoids(case)


def trapezoids(case):
    """The dam of Fig. 6. On trapezoids `bending` is not QM6: its toe is nearer to where finer meshes go, its crest farther; both
    go to the same numbers."""
    case.check("independent QM6, Fig. 6, n = 16: heel, toe [MPa], as published", qm6.dam(16)[:2], [1.643, -0.628], absolute=5e-4)
    rows = [(n, element) for n in (16, 32) for element in ("full", "bending")]
    scene = changed(load("fig6").SCENE, ("relaxation.method", "preconditioned"))
    results = case.run_all([(triangle_dam(n, "M"), changed(scene, ("materials.dam.element", element))) for n, element in rows])
    found = {}
    for row, result in zip(rows, results):
        base = result.stage_summary("full")["joints"]["base"]
        found[row] = np.array([base["start"]["sigma"] * 1e-6, base["end"]["sigma"] * 1e-6, result.probe("full", "crest")[0] * 1e3])
    for n in (16, 32):
        case.check(f"Fig. 6, n = {n}, element: full: heel, toe [MPa], crest [mm]", found[n, "full"], qm6.dam(n, incompatible=False),
                   relative=1e-4)
        for i, what in enumerate(("heel [MPa]", "toe [MPa]", "crest [mm]")):
            case.report(f"... element: bending, beside QM6: {what}", found[n, "bending"][i], qm6.dam(n)[i])
    coarse, fine = (np.abs(found[n, "bending"] - found[n, "full"]) for n in (16, 32))
    case.check("... from 16 to 32 blocks bending and full come nearer: part that is left of heel, toe, crest, at most",
               bool(np.all(fine < 0.75 * coarse)), True)
