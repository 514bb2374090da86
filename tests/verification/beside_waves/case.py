"""A joint that slips under a harmonic shear wave between two half spaces (Miller 1978): how much of the wave passes, returns and is lost."""

import models
import numpy as np

WHAT = "a joint that slips under a harmonic shear wave: transmitted, reflected and lost parts"
SOURCE = "Miller 1978: the joint's stress is the incident one cut at its strength (examples/published/problems.yaml)"
BY = "closed form of Miller"

IMPEDANCE, SPEED, LENGTH = np.sqrt(2500 * 4e9), np.sqrt(4e9 / 2500), 31.6227766  # Pa s/m, m/s, m


def run(case):
    ours = {}
    for part in case.some((0.9, 0.1, 0.5)):
        strength = float(IMPEDANCE * 0.1 * part)
        result = case.scene_of("sheared_joint", models.sheared_joint(20), ("joints.joint.cohesion", strength), ("joints.joint.cohesion_residual", strength))
        t = result.history["time_s"]
        middle = 0.5 * (t[1:] + t[:-1])
        above, below = (np.diff(result.history[f"{place}_ux_m"]) / np.diff(t) for place in ("above", "below"))
        came = 0.1 * np.sin(20 * np.pi * (middle - LENGTH / SPEED))
        cycle = (middle > 0.2) & (middle <= 0.3)
        passed, returned = (np.mean(v[cycle] ** 2) / np.mean(came[cycle] ** 2) for v in (above, below - came))
        ours |= {f"{name}, strength over stress {part}": np.sqrt(share) for name, share in (("T", passed), ("R", returned), ("A", 1 - passed - returned))}
    case.published("sheared_joint", ours)
