"""Holds the limits of guidelines (guidelines.yaml) against the numbers of a base.

    guideline = read()["usace"]
    for judged in judge(guideline, "usual", values): print(judged.text, judged.verdict)
"""

import functools
import os
from dataclasses import dataclass

import yaml

from quoin_tools.base.language import N_, _, numeral

PATH = os.path.join(os.path.dirname(os.path.abspath(__file__)), "guidelines.yaml")
CONDITIONS = (N_("usual"), N_("unusual"), N_("extreme"), N_("earthquake"), N_("after_earthquake"))
PASS, FAIL, OPEN, OTHER = N_("pass"), N_("FAIL"), N_("not judged"), N_("see alternative")
KINDS = (N_("water"), N_("overflow"), N_("tailwater"), N_("uplift"), N_("drains"), N_("silt"), N_("ice"), N_("wave"), N_("earthquake"), "shaken", "reversed", N_("temperature"))  # words of combinations for loads
QUANTITIES = {  # name: (words, whether the limit is the least or the largest allowed, digits, factor for printing, unit)
    "sliding_peak": (N_("sliding factor, peak strength"), "least", 2, 1.0, ""),
    "sliding_residual": (N_("sliding factor, residual strength"), "least", 2, 1.0, ""),
    "friction_only": (N_("sliding factor, no cohesion"), "least", 2, 1.0, ""),
    "middle": (N_("resultant within the middle part of the base"), "largest", 3, 1.0, ""),
    "crack": (N_("crack over length of the base"), "largest", 3, 1.0, ""),
    "strength": (N_("largest compression over strength"), "largest", 3, 1.0, ""),
    "tension": (N_("tension at an end of the base, straight line"), "largest", 1, 1e-3, "kPa"),
    "local_factor": (N_("local safety factor of the material"), "least", 2, 1.0, ""),
}
ROUNDING = 1e-4  # relative: a limit of 0.33333 is a third


class GuidelineError(ValueError):
    """guidelines.yaml, or a request to it, is wrong; the message is one line."""


@dataclass
class Judged:
    """A limit, the number held against it, and the verdict."""

    quantity: str
    limit: float | None
    value: float | None
    verdict: str
    source: str
    check: bool
    instead_of: str = ""

    @property
    def text(self):
        return QUANTITIES[self.quantity][0]

    def printed(self, number):
        digits, factor, unit = QUANTITIES[self.quantity][2:]
        return "-" if number is None else numeral(f"{number * factor:.{digits}f} {unit}".strip())

    @property
    def bound(self):
        sign = "≥" if QUANTITIES[self.quantity][1] == "least" else "≤"
        return _("to be filled in") if self.limit is None else f"{sign} {self.printed(self.limit)}"


@functools.cache
def read(path=PATH):
    """Reads and checks guidelines once in a process. Returns them by name; callers leave them as they are."""
    try:
        with open(path, encoding="utf-8") as file:
            guidelines = yaml.safe_load(file)["guidelines"]
        for name, guideline in guidelines.items():
            for condition, limits in guideline["conditions"].items():
                check_limits(f"{path}: {name}.{condition}", condition, limits)
            for one in guideline.get("combinations") or ():
                check_combination(f"{path}: {name}.combinations", one)
    except (OSError, yaml.YAMLError, KeyError, TypeError, AttributeError) as error:
        raise GuidelineError(f"{path}: {' '.join(str(error).split())}") from error
    return guidelines


def messages(file, *_ignored, **_options):
    """Yields the texts of guidelines.yaml in the form that pybabel extract asks for (locale/babel.cfg)."""
    for guideline in yaml.safe_load(file)["guidelines"].values():
        limits = [limit for limits in guideline["conditions"].values() for limit in limits.values() if isinstance(limit, dict)]
        for row in (guideline, *limits, *(guideline.get("combinations") or ())):
            yield from ((1, None, row[key], []) for key in ("title", "note", "caution", "source", "name", "loads") if row.get(key))


def check_limits(where, condition, limits):
    if condition not in CONDITIONS:
        raise GuidelineError(f"{where}: expected {', '.join(CONDITIONS)}")
    for quantity, limit in limits.items():
        if quantity not in QUANTITIES:
            raise GuidelineError(f"{where}: no quantity '{quantity}', there are: {', '.join(QUANTITIES)}")
        if not isinstance(limit["value"], (int, float, type(None))) or not limit["source"]:
            raise GuidelineError(f"{where}.{quantity}: expected a number or null, and a source")


def check_combination(where, one):
    if not all(one.get(key) for key in ("name", "conditions", "loads", "source")):
        raise GuidelineError(f"{where}: expected name, conditions, loads and source of each")
    wrong = [word for key in ("with", "without", "asks") for word in one.get(key, ()) if word not in KINDS] + [word for word in one["conditions"] if word not in CONDITIONS]
    if wrong:
        raise GuidelineError(f"{where}: {one['name']}: no word '{wrong[0]}', there are: {', '.join(KINDS)}; conditions {', '.join(CONDITIONS)}")


def verdict_of(quantity, limit, value):
    if limit is None or value is None:
        return OPEN
    room = ROUNDING * abs(limit)
    good = value >= limit - room if QUANTITIES[quantity][1] == "least" else value <= limit + room
    return PASS if good else FAIL


def judge(guideline, condition, values):
    """Judged of every limit of a condition. values: quantity to number, None or missing where there is none.

    A limit with instead_of is an alternative: where one of the two passes, the other's failure does not count.
    """
    rows = []
    for quantity, limit in guideline["conditions"].get(condition, {}).items():
        value = values.get(quantity)
        verdict = verdict_of(quantity, limit["value"], value)
        rows.append(Judged(quantity, limit["value"], value, verdict, limit["source"], bool(limit.get("check")),
                           limit.get("instead_of", "")))  # fmt: skip
    named = {row.quantity: row for row in rows}
    for row in rows:
        other = named.get(row.instead_of)
        if other and {row.verdict, other.verdict} == {PASS, FAIL}:
            (row if row.verdict == FAIL else other).verdict = OTHER
    return rows


def overall(rows, complete=True):
    """Returns one word for many limits: a failure counts most, then a limit that could not be judged."""
    verdicts = [row.verdict for row in rows]
    if FAIL in verdicts:
        return "FAIL"
    if not rows or OPEN in verdicts or not complete:
        return N_("INCOMPLETE")
    return N_("PASS, limits to be confirmed") if any(row.check for row in rows) else N_("PASS")
