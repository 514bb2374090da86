"""Friction in Code_Aster's tests: an elastic plate is pressed on a rigid plane and pushed along it (SSNV128A), a joint is closed and sheared (SSNP162D),
a mass on a spring slides to and fro until it rests (SDND100A); a block with a crack that slips (Olsson, Brady); Barton's curve replaced by a line."""

import models
import numpy as np

WHAT = "elastic plate pushed along a rigid plane with friction, a joint closed and sheared, a mass on a spring, beside Code_Aster and GRECO; a crack that slips and comes back; a line for Barton's curve"
SOURCE = "Code_Aster tests SSNV128A, SSNP162D, SDND100A; Olsson 1982, Brady et al. 1985; Barton 1973 (examples/published/problems.yaml)"
BY = "GRECO, Code_Aster; springs of Brady et al.; Barton's formula"


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
    cycle(case)
    strengths(case)


FORCES = {"up": 20, "top": 40, "back": 39, "held": 24, "down": 20, "low": 10}  # MN, by stage


def cycle(case):
    """Stiffness along the path of the load [GN/m] from shortenings [m] of the block."""
    def stiffness(result):
        short = {stage: -result.probe(stage, "push")[1] for stage in FORCES}
        return short, [1e-3 * (FORCES[b] - FORCES.get(a, 0)) / (short[b] - short.get(a, 0)) for a, b in ((None, "top"), ("top", "back"), ("down", "low"))]

    def slips(rises, turns):
        return 1e3 * FORCES["top"] * (1 / rises - 1 / turns)

    short, (rises, turns, back) = stiffness(case.scene_of("slipping_crack"))
    coarse, stiff = (stiffness(case.scene_of("slipping_crack", *changes))[1] for changes in ((models.slipping_crack(16),), (None, ("materials.block.young", 88.9e11))))
    ours = {"load rises [GN/m]": rises, "load turns, nothing slips [GN/m]": turns, "slips back [GN/m]": back, "shortening by slip at 40 MN [1e-6 m]": slips(rises, turns),
            "load rises, 16 blocks across, not 32 [GN/m]": coarse[0], "shortening by slip at 40 MN, block 100 times as stiff [1e-6 m]": slips(*stiff[:2])}  # fmt: skip
    case.published("slipping_crack", ours, {"at the ends of stages": ([0, *FORCES.values()], [0, *(1e6 * u - 1e3 * FORCES[stage] / 38.8934 for stage, u in short.items())])})


def strengths(case):
    """Shear strength of the joint [MPa] under normal stresses [MPa]."""
    def strength(stress, *changes):
        told = case.scene_of("barton", None, ("loads.closed.value", [0, -1e6 * stress]), ("stages.1.sheared.bracket", 2e-4), *changes).stage_summary("sheared")["load_factor"]
        return (told["stable"] + told["failing"]) / 2

    def barton(stress):
        return stress * np.tan(np.radians(30 + 9.5 * np.log10(100 / stress)))

    ours = {f"strength under {stress:g} MPa [MPa]": strength(stress) for stress in (0.5, 1, 1.5, 0.2, 3)}
    slope = (barton(0.4) - barton(0.1)) / 0.3
    cohesion = float(1e6 * (barton(0.1) - 0.1 * slope))
    low = [("joints.default.friction", float(np.degrees(np.arctan(slope)))), ("joints.default.cohesion", cohesion), ("joints.default.cohesion_residual", cohesion)]
    case.published("barton", ours | {"strength under 0.2 MPa, line through 0.1 and 0.4 MPa [MPa]": strength(0.2, *low)})
