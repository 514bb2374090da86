"""Friction in Code_Aster's tests: an elastic plate is pressed on a rigid plane and pushed along it (SSNV128A), a joint is closed and sheared (SSNP162D),
a mass on a spring slides to and fro until it rests (SDND100A)."""

import numpy as np

WHAT = "elastic plate pushed along a rigid plane with friction, a joint closed and sheared, a mass on a spring, beside Code_Aster and GRECO"
SOURCE = "Code_Aster tests SSNV128A, SSNP162D, SDND100A (examples/published/problems.yaml)"
BY = "GRECO, Code_Aster"


def along(result):
    """x [mm] and motion [1e-5 m] of the foot of the plate, where it slides."""
    stage, mesh = result.stage("pressed"), result.mesh
    foot = np.flatnonzero((abs(mesh.vertices[:, 1]) < 1e-9) & (mesh.vertices[:, 0] < 0.0151) & (mesh.vertices[:, 0] > -1e-9))
    foot = foot[np.argsort(mesh.vertices[foot, 0])]
    return 1e3 * mesh.vertices[foot, 0], 1e5 * stage.displacement[foot, 0]


def run(case):
    result = case.scene_of("plate_on_friction")
    places = {"A, x = 0": "A", "B, x = 1.25 mm": "B", "C, x = 5 mm": "C", "D, x = 7.5 mm": "D", "E, x = 11.25 mm": "E"}
    case.published("plate_on_friction", {f"sliding of {where} [m]": result.probe("pressed", point)[0] for where, point in places.items()}, {"": along(result)})
    found = case.scene_of("joint_friction").stage_summary("sheared")["load_factor"]
    case.published("joint_friction", {"largest shear stress [Pa]": 1e6 * (found["stable"] + found["failing"]) / 2})
    told = case.scene_of("friction_oscillator").history
    moves = told["time_s"] > 0
    # the test gives the part of the motion along an axis at 45 degrees; it begins to the other side
    turns = [-np.cos(np.pi / 4) * np.interp(i * np.pi / 100, told["time_s"][moves], told["middle_ux_m"][moves]) for i in (1, 2, 3, 4)]
    case.published("friction_oscillator", dict(zip(("turn after half a cycle [m]", "after one cycle [m]", "after one and a half [m]", "after two [m]"), turns, strict=True)),
                   {"": (told["time_s"][moves], -1e3 * np.cos(np.pi / 4) * told["middle_ux_m"][moves])})  # fmt: skip
