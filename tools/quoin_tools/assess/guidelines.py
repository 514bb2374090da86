"""Reads the limits of guidelines (guidelines.yaml, and a file of the user) and holds them against the numbers of a base.

    guideline = read()["usace"]
    for judged in judge(guideline, "usual", values, {"tests": "with"}): print(judged.words, judged.verdict)
"""

import copy
import functools
import json
import math
import os
from dataclasses import dataclass

import yaml

from quoin_tools.base import sheet_units
from quoin_tools.base.language import N_, _, numeral
from quoin_tools.base.results import NO_SHEAR
from quoin_tools.base.scene import yaml_of

HERE = os.path.dirname(os.path.abspath(__file__))
PATH, SCHEMA = os.path.join(HERE, "guidelines.yaml"), os.path.join(HERE, "guidelines.schema.json")
CONDITIONS = (N_("usual"), N_("unusual"), N_("extreme"), N_("earthquake"), N_("after_earthquake"), N_("quasi_permanent"), N_("frequent"), N_("rare"))  # the last three: of service
PLANES = (N_("contact"), N_("lift"), N_("foundation"))  # kinds of bases: of dam and ground, within the dam, within the ground
PASS, MET, FAIL, OPEN, OTHER = N_("pass"), N_("met"), N_("FAIL"), N_("not judged"), N_("see alternative")
KINDS = (N_("water"), N_("overflow"), N_("tailwater"), N_("uplift"), N_("drains"), N_("silt"), N_("ice"), N_("wave"), N_("earthquake"), N_("shaken"), N_("reversed"), N_("temperature"))  # words of combinations for loads
QUANTITIES = {  # name: (words, whether the limit is the least or the largest allowed, digits, factor for printing, unit)
    "sliding_peak": (N_("sliding factor, peak strength"), "least", 2, 1.0, ""),
    "sliding_residual": (N_("sliding factor, residual strength"), "least", 2, 1.0, ""),
    "friction_only": (N_("sliding factor, no cohesion"), "least", 2, 1.0, ""),
    "sliding_partial": (N_("sliding with partial factors {0:g} on friction, {1:g} on cohesion"), "least", 2, 1.0, ""),
    "stands": (N_("the block model stands with design strengths, {0:g} on friction, {1:g} on cohesion"), "least", 0, 1.0, ""),
    "flotation": (N_("normal force without uplift over uplift"), "least", 2, 1.0, ""),
    "middle": (N_("resultant within the middle part of the base"), "largest", 3, 1.0, ""),
    "crack": (N_("crack over length of the base"), "largest", 3, 1.0, ""),
    "strength": (N_("largest compression over strength"), "largest", 3, 1.0, ""),
    "tension": (N_("tension at an end of the base, straight line"), "largest", 1, 1e-3, "kPa"),
    "lift_strength": (N_("largest compression of lifts over strength"), "largest", 3, 1.0, ""),
    "lift_tension": (N_("largest tension of lifts over compressive strength"), "largest", 3, 1.0, ""),
    "local_factor": (N_("local safety factor of the material"), "least", 2, 1.0, ""),
}
ACTIONS = {"self_weight": N_("self weight"), "water": N_("water"), "tailwater": N_("tailwater"), "uplift": N_("uplift"), "silt": N_("silt"), "ice": N_("ice"), "earthquake": N_("earthquake"), "other": N_("other actions")}
OF_LIFTS = ("lift_strength", "lift_tension")  # held against the lifts, not against the bases
ROUNDING = 1e-4  # relative: a limit of 0.33333 is a third


class GuidelineError(ValueError):
    """A file of guidelines, or a request to it, is wrong; the message is one line."""


@dataclass
class Judged:
    """A limit, the number held against it, and the verdict. wanting: the input that is not given and on which the limit depends; refused: why the gravity method finds no equilibrium, where the value is 0 for that."""

    quantity: str
    limit: float | None
    value: float | None
    verdict: str
    entry: dict
    wanting: str = ""
    refused: str = ""

    @property
    def words(self):
        if self.quantity not in ("sliding_partial", "stands"):
            return _(QUANTITIES[self.quantity][0])
        if None in (self.entry["friction"], self.entry["cohesion"]):
            return _("sliding with partial factors that are to be filled in")
        said = _(QUANTITIES[self.quantity][0], self.entry["friction"], self.entry["cohesion"])
        return _("{0}; on actions {1}", said, ", ".join(action_words(*action) for action in self.entry["actions"].items())) if self.entry.get("actions") else said

    @property
    def confirmed(self):
        return self.entry["read"] == "document"

    @property
    def source(self):
        return source_of(self.entry)

    def printed(self, number):
        digits, factor, unit = QUANTITIES[self.quantity][2:]
        if self.quantity == "stands" and number is not None:
            return _("yes") if number else _("no")
        if number is not None and number > NO_SHEAR and QUANTITIES[self.quantity][1] == "least":
            return "∞"
        text = "-" if number is None else numeral(f"{number * factor:.{digits}f}")
        text = f"{text} ({_('no equilibrium')})" if self.refused and number == 0 else text
        return sheet_units.said(text, unit) if unit and number is not None else text

    @property
    def bound(self):
        if self.limit is None:
            return _("depends on {0}", self.wanting) if self.wanting else _("to be filled in")
        if self.quantity == "stands":
            return self.printed(self.limit)
        sign = "≥" if QUANTITIES[self.quantity][1] == "least" else "≤"
        return f"{sign} {self.printed(self.limit)}"


def action_words(kind, factors):
    """Says the factors on a kind of actions, as in `water 1.2` or `self weight 0.9 or 1.1`."""
    values = list(factors.values()) if isinstance(factors, dict) else [factors]
    return f"{_(ACTIONS[kind])} " + _("{0} or {1}", *map(numeral, map(str, values))) if len(values) > 1 else f"{_(ACTIONS[kind])} {numeral(str(values[0]))}"


def source_of(entry):
    """Says where a limit or a combination stands, and how it got here."""
    if entry["read"] == "quoted":
        return _("{0}; not held against the document, as quoted by {1}", _(entry["place"]), _(entry["quoted"]))
    return _(entry["place"]) if entry["read"] == "document" else _("{0}; not held against the document, from memory", _(entry["place"]))


# ---- the files ------------------------------------------------------------------------------------------------

def loaded(path):
    """Returns the guidelines of a file by name; merges of YAML are resolved."""
    data = yaml_of(path, GuidelineError, lambda text: yaml.load(text, yaml.CSafeLoader))  # noqa: S506 (a SafeLoader)
    if path != PATH:  # a test checks that of Quoin
        check_form(path, data)
    return data["guidelines"]


def check_form(path, data):
    """Refuses what the schema does not allow, with the place in the file."""
    import jsonschema

    with open(SCHEMA, encoding="utf-8") as file:
        wrong = jsonschema.exceptions.best_match(jsonschema.Draft7Validator(json.load(file)).iter_errors(data))
    if wrong:
        raise GuidelineError(f"{path}: {'.'.join(map(str, wrong.absolute_path)) or 'the file'}: {' '.join(wrong.message.split())}")
    odd = next(endless(data), None)
    if odd:
        raise GuidelineError(f"{path}: {odd}: expected a finite number")


def endless(data, where=""):
    """Yields the paths of numbers that are not finite: against them any number would be held, or none."""
    for key, value in data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ():
        path = f"{where}.{key}" if where else str(key)
        if isinstance(value, float) and not math.isfinite(value):
            yield path
        yield from endless(value, path)


def completed(base, own):
    """A guideline with the entries of another one over it: a limit takes the place of the limit of the same condition and quantity."""
    within = "inputs", "crack_start", "in_crack"
    result = copy.deepcopy(base) | {key: value for key, value in own.items() if key not in ("conditions", "planes")}
    result |= {key: base.get(key, {}) | own.get(key, {}) for key in within if key == "inputs" or key in result}
    result["conditions"] = over(base.get("conditions", {}), own.get("conditions", {}))
    result["planes"] = {plane: over(base.get("planes", {}).get(plane, {}), own.get("planes", {}).get(plane, {})) for plane in PLANES}
    return result


def over(base, own):
    """Limits by condition, those of `own` in the place of those of `base`."""
    return {name: base.get(name, {}) | own.get(name, {}) for name in CONDITIONS if name in base or name in own}


def tables(guideline):
    """Yields (plane, condition, limits) of a guideline; plane "": of all planes that have no limit of their own."""
    for plane, conditions in {"": guideline["conditions"], **guideline.get("planes", {})}.items():
        yield from ((plane, condition, limits) for condition, limits in conditions.items())


def others(guideline):
    """Yields (name, entry) of what a guideline says beside limits: where a crack starts, and the water in it."""
    for part in ("crack_start", "in_crack"):
        yield from ((f"{part}.{name}", entry) for name, entry in guideline.get(part, {}).items())


def in_crack(guideline, what, given):
    """(value, entry, wanting) of the water in a crack: value None where the guideline does not say it; wanting: the input on which it depends and that is not given. what: at_rest, earthquake or after_earthquake."""
    entry = (guideline or {}).get("in_crack", {}).get(what)
    value = (entry or {}).get("value")
    if not isinstance(value, dict):
        return value, entry, ""
    return value.get(given.get(entry["by"])), entry, "" if entry["by"] in given else entry["by"]


def limits_of(guideline, condition, plane="contact"):
    """Returns the limits of a condition on a kind of plane, by quantity."""
    return guideline["conditions"].get(condition, {}) | guideline.get("planes", {}).get(plane, {}).get(condition, {})


@functools.cache
def read(path=None):
    """Reads guidelines once in a process, those of a user's file over those of Quoin. Returns them by name; callers leave them as they are."""
    known = {name: {"note": "", "inputs": {}} | guideline for name, guideline in loaded(PATH).items()}
    for name, own in (loaded(path) if path else {}).items():
        like = own.get("like", name)
        if like not in known and "like" in own:
            raise GuidelineError(f"{path}: guidelines.{name}.like: no guideline '{like}', there are: {', '.join(known)}")
        known[name] = completed(known.get(like, {"note": "", "inputs": {}}), own)
    for name, guideline in known.items():
        check(f"{path or PATH}: guidelines.{name}", guideline)
    return known


def check(where, guideline):
    """Refuses what the schema cannot see: parts that a complete guideline must have, inputs without choices."""
    for key in ("title", "document", "conditions"):
        if not guideline.get(key):
            raise GuidelineError(f"{where}.{key}: missing; expected in a guideline that is like no other")
    for plane, condition, limits in tables(guideline):
        where_it_is = f"{where}.planes.{plane}.{condition}" if plane else f"{where}.conditions.{condition}"
        for quantity, limit in limits.items():
            if QUANTITIES[quantity][1] == "least" and 0 in (limit["value"].values() if isinstance(limit["value"], dict) else [limit["value"]]):
                raise GuidelineError(f"{where_it_is}.{quantity}.value: 0 is kept by any number: expected more than 0, or null for what is to be filled in")
            check_choices(f"{where_it_is}.{quantity}.value", guideline, limit, "a number")
    for name, entry in others(guideline):
        check_choices(f"{where}.{name}.value", guideline, entry, "a word")


def check_choices(where, guideline, entry, what):
    """Refuses a value by choices that no input has."""
    choices = guideline["inputs"].get(entry.get("by"), {})
    if isinstance(entry["value"], dict) and not (entry.get("by") and set(entry["value"]) <= set(choices)):
        raise GuidelineError(f"{where}: expected {what}, or {what} for choices of an input that `by` names: {', '.join(choices) or 'there is no such input'}")


def of(options):
    """Returns the guideline of the options; None where none is named."""
    return read(options.guidelines).get(options.guideline) if options.guideline else None


def messages(file, *_ignored, **_options):
    """Yields the texts of guidelines.yaml in the form that pybabel extract asks for (locale/babel.cfg)."""
    for guideline in yaml.safe_load(file)["guidelines"].values():
        limits = [limit for _plane, _condition, limits in tables(guideline) for limit in limits.values() if isinstance(limit, dict)]
        choices = [text for choices in guideline.get("inputs", {}).values() for text in choices.values()]
        for row in (guideline, *limits, *(entry for _name, entry in others(guideline)), *(guideline.get("combinations") or ())):
            yield from ((1, None, row[key], []) for key in ("title", "note", "caution", "place", "quoted", "name", "loads") if row.get(key))
        yield from ((1, None, text, []) for text in choices)


# ---- the verdicts ---------------------------------------------------------------------------------------------

def verdict_of(quantity, limit, value, confirmed):
    if limit is None or value is None:
        return OPEN
    room = ROUNDING * abs(limit)
    good = value >= limit - room if QUANTITIES[quantity][1] == "least" else value <= limit + room
    return (PASS if confirmed else MET) if good else FAIL


def worst_first(row):
    """Sorts Judged of one limit and several planes: what fails, then what has no number, then by the distance from the limit."""
    distance = 0.0 if None in (row.value, row.limit) else row.value - row.limit
    return [FAIL, OPEN].index(row.verdict) if row.verdict in (FAIL, OPEN) else 2, distance if QUANTITIES[row.quantity][1] == "least" else -distance


def partial_numbers(entry):
    """Lists the partial factors of a limit; None: to be filled in."""
    actions = [list(each.values()) if isinstance(each, dict) else [each] for each in (entry.get("actions") or {}).values()]
    return [entry["friction"], entry["cohesion"], *(value for values in actions for value in values)]


def is_filled(entry):
    """Tells whether a limit has a number to hold against."""
    return entry["value"] is not None and ("friction" not in entry or None not in partial_numbers(entry))


def judge(guideline, condition, values, given=None, lifts=False, plane="contact", sure=True):
    """Judged of every limit of a condition on bases, or on lifts. values: quantity to number (sliding_partial: to a function of the
    entry), None or missing where there is none; given: inputs of the guideline and their choices; plane: one of PLANES; sure: the numbers hang on nothing that was not read in the document.

    A limit with instead_of is an alternative: where one of the two holds or depends on what is not given, the other's failure does not count.
    """
    rows, given = [], given or {}
    for quantity, entry in limits_of(guideline, condition, plane).items():
        limit, wanting = entry["value"], ""
        if isinstance(limit, dict):
            wanting = "" if entry["by"] in given else entry["by"]
            if not wanting and given[entry["by"]] not in limit:
                continue  # this choice has no such limit
            limit = None if wanting else limit[given[entry["by"]]]
        if (quantity in OF_LIFTS) != lifts:
            continue
        value = values.get(quantity)
        if quantity == "sliding_partial" and None in partial_numbers(entry):
            limit = value = None
        elif quantity == "sliding_partial" and value is not None:
            value = value(entry)
        rows.append(Judged(quantity, limit, value, verdict_of(quantity, limit, value, sure and entry["read"] == "document"), entry, wanting))
    named = {row.quantity: row for row in rows}
    for row in rows:
        other = named.get(row.entry.get("instead_of"))
        if other and FAIL in (row.verdict, other.verdict) and ({PASS, MET} & {row.verdict, other.verdict} or row.wanting or other.wanting):
            (row if row.verdict == FAIL else other).verdict = OTHER
    return rows


def overall(rows, complete=True):
    """Returns one word for many limits: a failure counts most, then a limit that could not be judged, then one that was not read in the document."""
    verdicts = [row.verdict for row in rows]
    if FAIL in verdicts:
        return "FAIL"
    if not rows or OPEN in verdicts or not complete:
        return N_("INCOMPLETE")
    return N_("NOT CONFIRMED: limits are met, but were not read in the document") if MET in verdicts else N_("PASS")
