"""MacNeal's patch of five irregular quadrilaterals, or ten triangles, in one body.

Prescribed displacements are not a support of Quoin, so the uniform stress of the linear displacement field acts as tractions on
the four sides, and three dofs at two corners hold the rigid motions: the field is then that of the plan, turned by -5e-4 rad."""

import numpy as np
from driver import changed
from quoin_tools.mesh.stacks import patch_test

WHAT = "patch test of one body: uniform stress under tractions (V01)"
SOURCE = "Hooke's law; MacNeal's patch, E = 1 MPa, nu = 0.25, strains 1e-3, 1e-3, shear 1e-3"
BY = "MacNeal's patch, Hooke's law by hand"

E, NU, STRAIN = 1e6, 0.25, np.array([1e-3, 1e-3, 1e-3])  # e_xx, e_yy, gamma_xy
G = E / (2 * (1 + NU))

SCENE = {
    "strain": "small",
    "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "ramp": 100},
    "materials": {"body": {"density": 0, "young": E, "poisson": NU}},
    "supports": {"outer_0": {"fix": "xy"}, "outer_1": {"fix": "y"}},
    "stages": [{"pull": {"loads": ["left", "right", "bottom", "top"]}}],
}


def stress(plane):
    """s_xx, s_yy, s_xy"""
    factor = E / (1 - NU**2) if plane == "stress" else E / ((1 + NU) * (1 - 2 * NU))
    on, off = (1, NU) if plane == "stress" else (1 - NU, NU)
    return np.array([factor * (on * STRAIN[0] + off * STRAIN[1]), factor * (off * STRAIN[0] + on * STRAIN[1]), G * STRAIN[2]])


def displacement(x, y):
    """u = 1e-3 (x + y/2), v = 1e-3 (y + x/2) of the plan, turned so that v = 0 on the lower side"""
    return np.column_stack([1e-3 * (x + y), 1e-3 * y])


def run(case):
    for plane in ("strain", "stress"):
        xx, yy, xy = stress(plane)
        sides = {"left": (-xx, -xy), "right": (xx, xy), "bottom": (-xy, -yy), "top": (xy, yy)}
        loads = {name: {"type": "traction", "faces": name, "value": value} for name, value in sides.items()}
        for kind, triangles in (("quadrilaterals", False), ("triangles", True)):
            mesh = patch_test(triangles)
            result = case.run(mesh, changed(SCENE, ("plane", plane), ("loads", loads)))
            stage = result.stage()
            case.check(f"{kind}, plane {plane}: stress at Gauss points / expected",
                       (stage.gauss_stress / stress(plane))[~np.isnan(stage.gauss_stress)], 1.0, relative=1e-6)
            case.check(f"{kind}, plane {plane}: displacement of vertices [m], of 3e-4",
                       stage.displacement, displacement(*mesh.vertices.T), absolute=3e-10)
