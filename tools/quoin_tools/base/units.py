"""Converts numbers with units as the solver does (src/scene/units.c has the same table; a test compares them)."""

import argparse
import math
import re

# unit of a key: (text, power of ten, factor); WEIGHT in place of a factor: over gravity
WEIGHT = -1.0
TABLE = {
    "Pa": (("kPa", 3, 1), ("MPa", 6, 1), ("GPa", 9, 1), ("N/m2", 0, 1), ("kN/m2", 3, 1), ("MN/m2", 6, 1), ("N/mm2", 6, 1), ("bar", 5, 1)),
    "Pa/m": (("kPa/m", 3, 1), ("MPa/m", 6, 1), ("GPa/m", 9, 1), ("MPa/mm", 9, 1), ("N/m3", 0, 1), ("kN/m3", 3, 1), ("MN/m3", 6, 1), ("GN/m3", 9, 1), ("N/mm3", 9, 1)),
    "kg/m3": (("t/m3", 3, 1), ("g/cm3", 3, 1), ("N/m3", 0, WEIGHT), ("kN/m3", 3, WEIGHT)),
    "N": (("kN", 3, 1), ("MN", 6, 1)),
    "N/m": (("kN/m", 3, 1), ("MN/m", 6, 1), ("N/mm", 3, 1), ("J/m2", 0, 1)),
    "N/m2": (("kN/m2", 3, 1), ("MN/m2", 6, 1), ("GN/m2", 9, 1), ("Pa", 0, 1), ("MPa", 6, 1), ("GPa", 9, 1)),
    "m": (("um", -6, 1), ("mm", -3, 1), ("cm", -2, 1), ("km", 3, 1)),
    "m2": (("mm2", -6, 1), ("cm2", -4, 1)),
    "degree": (("deg", 0, 1), ("degrees", 0, 1), ("°", 0, 1), ("rad", 0, 180 / math.pi)),
    "s": (("ms", -3, 1), ("min", 0, 60), ("h", 0, 3600), ("d", 0, 86400)),
    "min": (("h", 0, 60),),
    "Hz": (("kHz", 3, 1),),
    "m/s": (("mm/s", -3, 1), ("cm/s", -2, 1), ("km/h", 0, 1 / 3.6)),
    "m/s2": (("cm/s2", -2, 1), ("g", 0, 9.80665)),
    "K": (("C", 0, 1), ("°C", 0, 1)),
    "1/K": (("1/C", 0, 1), ("1/°C", 0, 1)),
    "Pa s": (("mPa s", -3, 1),),
    "-": (("%", -2, 1),),
    "GB": (("MB", -3, 1),),
}
NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[eE]([+-]?\d{1,4}))?(?: *(\S(?:.*\S)?))?$", re.ASCII)


def number(value):
    """Converts a word such as 10e9, which YAML does not read as a number."""
    if isinstance(value, str):
        try:
            return float(value)
        except ValueError:
            return value
    return value


def quantity(value, unit, gravity=9.81):
    """The number of a text like '12 MPa' in the unit of a key, '12e6' too; anything else, a unit of another kind among it, stays what it is.
    Powers of ten move the decimal point, so that 12 MPa has the bits of 12e6."""
    match = NUMBER.match(value.strip()) if isinstance(value, str) and len(value) < 80 else None
    if not match:
        return value
    digits, power, given = match[1], int(match[2] or 0), match[3]
    if given is None or given == unit:
        return float(f"{digits}e{power}")
    found = next((row for row in TABLE.get(unit, ()) if row[0] == given), None)
    if found is None:
        return value
    number = float(f"{digits}e{power + found[1]}")
    return number / gravity if found[2] == WEIGHT else number * found[2] if found[2] != 1 else number


def known(unit):
    """Returns the units that a key of this unit takes, its own first."""
    return ", ".join([unit, *(text for text, _, _ in TABLE.get(unit, ()))])


def option(unit):
    """Returns the argparse type of an option that is a number with a unit."""
    def number(text):
        value = quantity(text, unit)
        if not isinstance(value, float) or not math.isfinite(value):
            raise argparse.ArgumentTypeError(f"'{text}': expected a number, alone [{unit}] or with a unit: {known(unit)}")
        return value
    return number
