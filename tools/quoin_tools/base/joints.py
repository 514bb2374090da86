"""Reads the joint law of a scene: the keys of a joint in force, and its strengths in a trial.

Keys are those of docs/reference/joints.md: friction, cohesion, tension, compression and the residual ones. This module alone completes them and lowers them for a
trial; the gravity method and limit analysis read what it returns.
"""

import functools
import json
import math
from importlib import resources

from quoin_tools.base.units import number

ANGLES = ("friction", "friction_residual")
STRESSES = ("cohesion", "tension", "compression", "cohesion_residual", "tension_residual")


@functools.cache
def defaults():
    """Returns the values of the keys of a joint that nobody gives, from the solver's table of keys (scene.schema.json)."""
    schema = json.loads(resources.files("quoin_tools.front").joinpath("scene.schema.json").read_text(encoding="utf-8"))
    return {key: number(row["default"]) for key, row in schema["definitions"]["joints"]["properties"].items() if "default" in row}


def completed(keys):
    """Returns all keys of a joint. Without a residual friction the joint keeps its friction."""
    keys = defaults() | keys
    keys.setdefault("friction_residual", keys.get("friction"))
    return keys


def reduced(keys, what, value):
    """Returns the keys of a joint in a trial: friction of at most `value` degrees, or all strengths times `value`. Elastic joints have no strength to reduce."""
    if is_elastic(keys):
        return keys
    if what == "friction":
        return keys | {key: min(keys[key], value) for key in ANGLES}
    angles = {key: math.degrees(math.atan(value * math.tan(math.radians(keys[key])))) for key in ANGLES}
    return keys | angles | {key: value * float(keys[key]) for key in STRESSES}


def divided(keys, on_friction, on_cohesion):
    """Returns the keys of a joint with design strengths: tan(friction) over one partial factor, cohesion and tensile strength over the other."""
    if is_elastic(keys) or (on_friction, on_cohesion) == (1, 1):
        return keys
    angles = {key: math.degrees(math.atan(math.tan(math.radians(keys[key])) / on_friction)) for key in ANGLES}
    return keys | angles | {key: float(keys[key]) / on_cohesion for key in STRESSES if key != "compression"}


def is_elastic(keys):
    """Tells whether a joint has no limits, in tension either."""
    return keys.get("law") == "elastic"


def softens(keys):
    """Tells whether a joint loses a strength along a slope, by a fracture energy [N/m]."""
    return not is_elastic(keys) and any(float(keys.get(key) or 0) > 0 for key in ("fracture_energy", "fracture_energy_shear"))


def is_brittle(keys):
    """Tells whether a joint loses cohesion or tensile strength when it fails."""
    return not is_elastic(keys) and any(float(keys[f"{name}_residual"]) < float(keys[name]) for name in ("cohesion", "tension"))
