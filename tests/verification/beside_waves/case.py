"""A harmonic shear wave between two half spaces: how much passes, returns and is lost at a joint that slips (Miller 1978), or is elastic (Pyrak-Nolte et al. 1990).

A pulse in a column comes back and leaves (Code_Aster)."""

import models
import numpy as np

WHAT = "a harmonic shear wave at a joint that slips, or is elastic: transmitted, reflected and lost parts; a pulse in a column"
SOURCE = "Miller 1978: the joint's stress is the incident one cut at its strength; Schoenberg 1980, Pyrak-Nolte et al. 1990; Code_Aster test SDLV121A (examples/published/problems.yaml)"
BY = "closed forms of Miller, of Schoenberg; Code_Aster"

IMPEDANCE, SPEED, LENGTH = np.sqrt(2500 * 4e9), np.sqrt(4e9 / 2500), 31.6227766  # Pa s/m, m/s, m


def run(case):
    ours = {}
    for part in case.some((0.9, 0.1, 0.5)):
        strength = float(IMPEDANCE * 0.1 * part)
        result = case.scene_of("sheared_joint", models.sheared_joint(20), ("joints.joint.cohesion", strength), ("joints.joint.cohesion_residual", strength))
        passed, returned = shares(result)
        ours |= {f"{name}, strength over stress {part}": np.sqrt(share) for name, share in (("T", passed), ("R", returned), ("A", 1 - passed - returned))}
        if part == 0.9 and not case.short:
            finer = case.scene_of("sheared_joint", models.sheared_joint(40), ("joints.joint.cohesion", strength), ("joints.joint.cohesion_residual", strength))
            passed, returned = shares(finer)
            ours |= {"R, strength over stress 0.9, 160 blocks a wave": np.sqrt(returned), "A, strength over stress 0.9, 160 blocks a wave": np.sqrt(1 - passed - returned)}
    case.published("sheared_joint", ours)
    ours = {}
    for part in case.some((2, 0.25, 0.5)):
        passed, returned = shares(case.scene_of("elastic_joint_wave", None, ("joints.default.k_s", float(part * IMPEDANCE * 20 * np.pi))))
        ours |= {f"passes, k = {part} (2 pi f z)": np.sqrt(passed), f"returns, k = {part} (2 pi f z)": np.sqrt(returned)}
    case.published("elastic_joint_wave", ours)
    told = case.scene_of("column_wave").history
    up, back = (told["middle_ux_m"][which].max() for which in (told["time_s"] < 0.355, told["time_s"] > 0.355))
    case.published("column_wave", {"height of the pulse on its way up [m]": up, "on its way back [m]": back}, {"": (told["time_s"], 1e3 * told["middle_ux_m"])})


def shares(result):
    """Parts of the energy of a cycle that pass the joint and that return."""
    t = result.history["time_s"]
    middle = 0.5 * (t[1:] + t[:-1])
    above, below = (np.diff(result.history[f"{place}_ux_m"]) / np.diff(t) for place in ("above", "below"))
    came = 0.1 * np.sin(20 * np.pi * (middle - LENGTH / SPEED))
    cycle = (middle > 0.2) & (middle <= 0.3)
    return (np.mean(v[cycle] ** 2) / np.mean(came[cycle] ** 2) for v in (above, below - came))
