"""Reads the response spectrum for which a dam is designed: of Eurocode 8, of ASCE 7 or of a table, from a small YAML file.

    s = read("spectrum.yaml")
    s.horizontal(0.35, 0.05)     [m/s2] pseudo-acceleration of an oscillator of 0.35 s with 5 % of damping
    s.vertical(0.1, 0.05)        0 where the file asks for none
    s.ground, s.ground_vertical  [m/s2] largest acceleration of the ground itself: the spectrum at period 0

Eurocode 8: EN 1998-1:2004, (3.2)-(3.9), tables 3.2 to 3.4 with the recommended values. They are as two public programs that agree have them; the standard itself
could not be read. ASCE 7-10, 11.4.5, likewise. Other damping changes all three as Eurocode 8 has it, (3.2)-(3.5): by eta = sqrt(10/(5 + 100 xi)) >= 0.55 from the
period on at which the plateau begins; before it the motion of the ground stays, and what is beyond it changes with the plateau.
"""

import csv
import difflib
import os
from dataclasses import dataclass, field

import numpy as np

from quoin_tools.assess.guidelines import CONDITIONS
from quoin_tools.base.record import STANDARD
from quoin_tools.base.scene import yaml_of

UNITS = {"g": STANDARD, "m/s2": 1.0}
HORIZONTAL = {  # of Eurocode 8 by type and ground: S, T_B, T_C, T_D
    1: {"A": (1.0, 0.15, 0.4, 2.0), "B": (1.2, 0.15, 0.5, 2.0), "C": (1.15, 0.20, 0.6, 2.0), "D": (1.35, 0.20, 0.8, 2.0), "E": (1.4, 0.15, 0.5, 2.0)},
    2: {"A": (1.0, 0.05, 0.25, 1.2), "B": (1.35, 0.05, 0.25, 1.2), "C": (1.5, 0.10, 0.25, 1.2), "D": (1.8, 0.10, 0.30, 1.2), "E": (1.6, 0.05, 0.25, 1.2)},
}  # fmt: skip
VERTICAL = {1: (0.9, 0.05, 0.15, 1.0), 2: (0.45, 0.05, 0.15, 1.0)}  # by type: a_vg over a_g, T_B, T_C, T_D
AMPLIFIED, AMPLIFIED_VERTICAL = 2.5, 3.0  # plateau over the acceleration of the ground, damping 5 %
FIVE = 0.05  # damping of both standards
FLAT = 0.999  # of the largest value of a table: its plateau, where numbers are rounded


class SpectrumError(ValueError):
    """A file of a spectrum is wrong; the message is one line: file, key, value, what is expected."""


@dataclass
class DesignSpectrum:
    """curve, curve_vertical: functions of period [s] and damping [-] that give pseudo-accelerations [m/s2]; curve_vertical is None where there is no vertical motion."""

    title: str
    damping: float
    curve: object
    curve_vertical: object = None
    longest: float = np.inf  # [s] last period of a table
    dam: dict = field(default_factory=dict)  # keys of the file for the dam, its water and its rock (by_spectrum.py)

    def horizontal(self, period, damping=None):
        return self._of(self.curve, period, damping)

    def vertical(self, period, damping=None):
        return np.zeros_like(np.asarray(period, float)) if self.curve_vertical is None else self._of(self.curve_vertical, period, damping)

    def _of(self, curve, period, damping):
        period = np.asarray(period, float)
        if (period > self.longest).any():
            raise SpectrumError(f"{self.title}: the table ends at {self.longest:g} s; a period of {period.max():.4g} s is asked for")
        return curve(period, self.damping if damping is None else damping)

    @property
    def condition(self):
        """The condition of a guideline whose limits the planes are held against."""
        return self.dam.get("condition", "earthquake")

    @property
    def ground(self):
        return float(self.horizontal(0.0))

    @property
    def ground_vertical(self):
        return float(self.vertical(0.0))


# ---- shapes

def eta(damping):
    """[-] Returns the correction of Eurocode 8 for damping; 1 at 5 %."""
    return np.maximum(np.sqrt(10 / (5 + 100 * np.asarray(damping, float))), 0.55)


def eurocode_shape(period, ground, amplified, begins, ends, long):
    """[m/s2] (3.2)-(3.5) and (3.8)-(3.11) at 5 % of damping. ground: S a_g or a_vg [m/s2]; begins, ends, long: T_B, T_C, T_D [s]."""
    period = np.asarray(period, float)
    falling = amplified * np.where(period <= long, ends / np.maximum(period, ends), ends * long / np.maximum(period, long) ** 2)
    return ground * np.where(period < begins, 1 + period / begins * (amplified - 1), falling)


def asce_shape(period, short, one, long):
    """[m/s2] 11.4-5 to 11.4-7. short, one: S_DS and S_D1 [m/s2]; long: T_L [s]."""
    period, ends = np.asarray(period, float), one / short
    begins = 0.2 * ends
    falling = np.where(period <= long, one / np.maximum(period, ends), one * long / np.maximum(period, long) ** 2)
    return np.where(period < begins, short * (0.4 + 0.6 * period / begins), falling)


def damped(shape, begins, own=FIVE):
    """Returns the function of period and damping of a shape(period) [m/s2] that has the damping `own`. begins: period [s] of its plateau; 0: it has none."""
    ground, plateau = shape(0.0), shape(begins)

    def curve(period, damping):
        full, value = eta(damping) / eta(own), shape(period)
        before = ground + (value - ground) * (full * plateau - ground) / (plateau - ground) if begins > 0 else value
        return np.where(np.asarray(period) < begins, before, full * value)

    return curve


# ---- the file

def is_number(value, low=0.0, high=np.inf):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and low < value < high


POSITIVE = (is_number, "a number > 0")
DAMPING = (lambda value: is_number(value, 0, 0.5), "a ratio > 0 and < 0.5, such as 0.05")
COMMON = {
    "rule": (lambda value: value in RULES, "eurocode8, asce7 or table"),
    "unit": (lambda value: value in UNITS, "the unit of all accelerations, g or m/s2"),
}
OPTIONAL = {
    "damping": DAMPING,
    "vertical": (lambda value: value is False or value is True or is_number(value, 0, 2), "false, true (eurocode8), or the vertical spectrum over the horizontal one, such as 0.67"),
}
DAM = {
    "condition": (lambda value: value in CONDITIONS, "the condition whose limits hold, " + ", ".join(CONDITIONS)),
    "combine": (lambda value: value in ("cqc", "srss"), "cqc or srss"),
    "reflection": (lambda value: is_number(value, -1e-12, 1 + 1e-12), "wave reflection of the reservoir's bottom, a number from 0 to 1"),
    "sound": (is_number, "speed of sound in the water [m/s], a number > 0"),
    "rock_period": (lambda value: is_number(value, 1 - 1e-12), "period on the rock over that on rigid rock, R_f, a number >= 1"),
    "rock_damping": (lambda value: is_number(value, -1e-12, 0.5), "damping that the rock adds, xi_f, a ratio from 0 to 0.5"),
}
RULES: dict = {
    "eurocode8": {"type": (lambda value: value in (1, 2) and value is not True, "1 or 2"), "ground": (lambda value: value in HORIZONTAL[1], "a ground type, A, B, C, D or E"), "a_g": POSITIVE},
    "asce7": {"s_ds": POSITIVE, "s_d1": POSITIVE, "t_l": POSITIVE},
    "table": {"file": (lambda value: isinstance(value, str) and value, "a CSV file of period [s] and S_a"), "table_damping": DAMPING},
}  # fmt: skip


def read(path):
    """Returns the DesignSpectrum of a YAML file."""
    keys = yaml_of(path, SpectrumError)
    if not isinstance(keys, dict):
        raise SpectrumError(f"{path}: expected keys: rule, unit and those of the rule")
    check(path, keys)
    unit, vertical = UNITS[keys["unit"]], keys.get("vertical", False)
    title, curve, upright, longest = {"eurocode8": eurocode, "asce7": asce, "table": table}[keys["rule"]](path, keys, unit)
    if vertical is True:
        if upright is None:
            raise SpectrumError(f"{path}: vertical: true: expected a number, the vertical spectrum over the horizontal one; only eurocode8 has a spectrum of its own")
    elif vertical is not False:
        def upright(period, damping):
            return float(vertical) * curve(period, damping)
    return DesignSpectrum(title, float(keys.get("damping", FIVE)), curve, upright if vertical is not False else None, longest, {name: keys[name] for name in DAM if name in keys})


def check(path, keys):
    """Refuses keys that are missing, unknown or wrong."""
    for name in ("rule", "unit"):
        demand(path, keys, name, *COMMON[name])
    own = RULES[keys["rule"]]
    for name, (test, expected) in own.items():
        demand(path, keys, name, test, expected)
    known = COMMON | OPTIONAL | DAM | own
    for name, value in keys.items():
        if name not in known:
            close = difflib.get_close_matches(str(name), known, 1)
            raise SpectrumError(f"{path}: {name}: no such key" + (f"; did you mean {close[0]}?" if close else f"; with rule {keys['rule']} there are: {', '.join(known)}"))
        if not known[name][0](value):
            raise SpectrumError(f"{path}: {name}: {value}: expected {known[name][1]}")


def demand(path, keys, name, test, expected):
    if name not in keys:
        raise SpectrumError(f"{path}: {name}: missing; expected {expected}")
    try:
        good = test(keys[name])
    except TypeError:  # a list or a mapping, which is in no set
        good = False
    if not good:
        raise SpectrumError(f"{path}: {name}: {keys[name]}: expected {expected}")


def eurocode(path, keys, unit):
    factor, *corners = HORIZONTAL[keys["type"]][keys["ground"]]
    ground, (ratio, *upright) = keys["a_g"] * unit, VERTICAL[keys["type"]]
    title = f"Eurocode 8, type {keys['type']}, ground {keys['ground']}, a_g {ground / STANDARD:.3g} g"
    return (title, damped(lambda period: eurocode_shape(period, ground * factor, AMPLIFIED, *corners), corners[0]),
            damped(lambda period: eurocode_shape(period, ground * ratio, AMPLIFIED_VERTICAL, *upright), upright[0]), np.inf)  # fmt: skip


def asce(path, keys, unit):
    short, one, long = keys["s_ds"] * unit, keys["s_d1"] * unit, float(keys["t_l"])
    if long < one / short:
        raise SpectrumError(f"{path}: t_l: {long:g}: expected no less than S_D1/S_DS, {one / short:.4g} s")
    title = f"ASCE 7, S_DS {short / STANDARD:.3g} g, S_D1 {one / STANDARD:.3g} g"
    return title, damped(lambda period: asce_shape(period, short, one, long), 0.2 * one / short), None, np.inf


def table(path, keys, unit):
    period, value = rows(os.path.join(os.path.dirname(path), keys["file"]))
    value, own = value * unit, float(keys["table_damping"])
    title = f"{os.path.basename(keys['file'])}, {value[0] / STANDARD:.3g} g at rest"
    return title, damped(lambda t: np.interp(t, period, value), float(period[(value >= FLAT * value.max()).argmax()]), own), None, float(period[-1])


def rows(path):
    """Returns periods [s] and values of a CSV; one line of words may stand first, and a comment behind #."""
    found = []
    try:
        with open(path, encoding="utf-8", newline="") as file:
            lines = [line.split("#")[0].replace(";", ",") for line in file]
    except (OSError, UnicodeDecodeError) as error:
        raise SpectrumError(f"{path}: {getattr(error, 'strerror', None) or error}") from error
    for number, cells in enumerate(csv.reader(lines), 1):
        cells = [cell.strip() for cell in cells if cell.strip()]
        if not cells:
            continue
        try:
            pair = [float(cell) for cell in cells]
        except ValueError:
            if found or number > 1:
                raise SpectrumError(f"{path}: line {number}: {','.join(cells)}: expected two numbers, period [s] and S_a") from None
            continue
        if len(pair) != 2 or not np.isfinite(pair).all() or pair[1] <= 0:
            raise SpectrumError(f"{path}: line {number}: {','.join(cells)}: expected two numbers, period [s] and S_a > 0")
        if found and pair[0] <= found[-1][0]:
            raise SpectrumError(f"{path}: line {number}: period {pair[0]:g} after {found[-1][0]:g}: expected periods that ascend")
        found.append(pair)
    if len(found) < 2 or found[0][0] != 0:
        raise SpectrumError(f"{path}: expected two rows or more, the first with period 0: the largest acceleration of the ground")
    return np.array(found).T
