"""Reads the options of the assessment and of the sheet from the command line."""

import argparse
import os
from dataclasses import dataclass, field

from quoin_tools.assess import guidelines, uplift
from quoin_tools.base import units
from quoin_tools.base.command import Parser


@dataclass
class Options:
    """Facts that the scene does not have: uplift, paths, guideline, conditions. None or empty: not given."""

    guideline: str | None = None
    conditions: dict = field(default_factory=dict)  # stage: usual, unusual, extreme
    uplift: str | None = None
    uplift_on: list = field(default_factory=list)
    drain: float | None = None
    efficiency: float | None = None
    tailwater: float | None = None
    gallery: float | None = None
    drain_head: float | None = None
    direction: str = "normal"
    in_crack: str | None = None
    strength: float | None = None  # [Pa], compressive, of the dam
    paths: dict = field(default_factory=dict)  # name: [[x, y], ...]
    strengths: dict = field(default_factory=dict)  # of paths and joints: friction, cohesion and residual ones
    ky: float | str | None = None  # yield coefficient for Newmark's block, or the run that found it; None: the coefficient of this run
    lifts: int = 10  # level sections over the height where there are no bed joints; 0: none
    merged: list = field(default_factory=list)  # names of joints that are one base, in a list each
    guidelines: str | None = None  # file of the user whose guidelines stand over those of Quoin
    given: dict = field(default_factory=dict)  # inputs of the guideline and their choices: {"tests": "with"}
    spectrum: str | None = None  # file of a design spectrum
    planes: dict = field(default_factory=dict)  # kinds of bases: {"seam": "foundation"}
    no_case: dict = field(default_factory=dict)  # load combinations of the guideline that do not concern the dam, and why

    def check(self):
        """Refuses options that would have no effect or contradict each other."""
        of_rule = {"--drain": self.drain, "--efficiency": self.efficiency, "--drain-head": self.drain_head, "--gallery": self.gallery, "--tailwater": self.tailwater, "--uplift-on": self.uplift_on or None,
                   "--uplift-direction": "vertical" if self.direction == "vertical" else None, "--uplift-in-crack": self.in_crack}  # fmt: skip
        for name, value in of_rule.items():
            if value is not None and not self.uplift:
                raise OptionError(f"{name}: it belongs to a rule of uplift, and --uplift names none; without it uplift is that of the scene")
            if value is not None and name in IDLE.get(self.uplift, ()):
                raise OptionError(f"{name}: rule {self.uplift} has no use for it")
        if self.efficiency is not None and not 0 <= self.efficiency <= 1:
            raise OptionError(f"--efficiency {self.efficiency:g}: expected 0 to 1")
        if self.lifts < 0:
            raise OptionError(f"--lifts {self.lifts}: expected 0 (none) or more")
        if self.strength is not None and not self.strength >= LEAST_STRENGTH:
            raise OptionError(f"--strength {self.strength:g} Pa: expected {LEAST_STRENGTH:g} Pa or more; a unit may stand with it: '12 MPa'")
        for names in self.merged:
            if len(names) < 2 or len(set(names)) < len(names) or "" in names:
                raise OptionError(f"--merge {','.join(names)}: expected two different joints or more")
        for name, own in self.strengths.items():
            for key, value in own.items():
                if "friction" in key and not 0 <= value < 90:
                    raise OptionError(f"--strength-on {name}: friction {value:g} degrees: expected 0 or more, below 90")
                if "cohesion" in key and value != 0 and not value >= LEAST_COHESION:
                    raise OptionError(f"--strength-on {name}: cohesion {value:g} Pa: expected 0, or {LEAST_COHESION:g} Pa or more; a unit may stand with it: '0.2 MPa'")


IDLE = {"none": ("--drain", "--efficiency", "--drain-head", "--gallery", "--tailwater", "--uplift-direction", "--uplift-in-crack"), "linear": ("--drain", "--efficiency", "--drain-head", "--gallery"),
        "npb": ("--efficiency", "--gallery"), "usbr": ("--efficiency", "--gallery")}  # options that a rule does not read
LEAST_STRENGTH, LEAST_COHESION = 1e5, 100.0  # [Pa] less is likely to be in another unit


class OptionError(ValueError):
    """An option that would do nothing or cannot be meant, in one line."""


def once(option, pairs):
    """{name: value} of an option that may come again, once for each name."""
    found = {}
    for name, value in pairs:
        if name in found and found[name] != value:
            raise OptionError(f"{option}: {name} is given twice, and differs")
        found[name] = value
    return found


def named(text, what):
    name, equals, value = text.partition("=")
    if not equals or not name or not value:
        raise argparse.ArgumentTypeError(f"'{text}': expected {what}")
    return name, value


def path(text):
    name, value = named(text, "NAME=x,y,x,y,...")
    try:
        numbers = [units.option("m")(word) for word in value.split(",")]
    except argparse.ArgumentTypeError as error:
        raise argparse.ArgumentTypeError(f"{name}={error}") from error
    if len(numbers) < 4 or len(numbers) % 2:
        raise argparse.ArgumentTypeError(f"'{text}': expected two points or more")
    return name, [numbers[i : i + 2] for i in range(0, len(numbers), 2)]


def strengths(text):
    name, value = named(text, "NAME=friction,cohesion[,friction,cohesion]: degree, Pa; the second pair residual")
    try:
        numbers = [units.option("degree" if k % 2 == 0 else "Pa")(word) for k, word in enumerate(value.split(","))]
    except argparse.ArgumentTypeError as error:
        raise argparse.ArgumentTypeError(f"{name}={error}") from error
    if len(numbers) not in (2, 4):
        raise argparse.ArgumentTypeError(f"'{text}': expected two or four numbers")
    if len(numbers) == 2:
        numbers += [numbers[0], 0.0]
    return name, dict(zip(("friction", "cohesion", "friction_residual", "cohesion_residual"), numbers))


def condition(text):
    name, value = named(text, "STAGE=" + "|".join(guidelines.CONDITIONS))
    if value not in guidelines.CONDITIONS:
        raise argparse.ArgumentTypeError(f"'{text}': expected {', '.join(guidelines.CONDITIONS)}")
    return name, value


def given_input(text):
    return named(text, "INPUT=CHOICE")


def no_case(text):
    return named(text, "COMBINATION=WHY")


def plane(text):
    name, value = named(text, "NAME=" + "|".join(guidelines.PLANES))
    if value not in guidelines.PLANES:
        raise argparse.ArgumentTypeError(f"'{text}': expected {', '.join(guidelines.PLANES)}")
    return name, value


def coefficient(text):
    """A number, or the output folder of a run that has found it."""
    if os.path.isdir(text):
        return text
    try:
        value = float(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"'{text}': {error}") from error
    if not 0 < abs(value) < 100:
        raise argparse.ArgumentTypeError(f"'{text}': expected a number, > 0 for sliding along +x, < 0 along -x, or the output folder of a run with a stage load_factor")
    return value


def parser(program, description, epilog=None):
    result = Parser(prog=f"quoin {program}", description=description, epilog=epilog)
    add = result.add_argument
    add("folder", help="output folder of a run")
    add("--guideline", metavar="NAME", help="whose limits are held against the numbers: " + ", ".join(guidelines.read()) + ", or one of --guidelines")
    add("--guidelines", metavar="FILE", help="YAML with limits that complete or correct those of Quoin, or with other guidelines (docs/guidelines.md)")
    add("--given", action="append", default=[], type=given_input, metavar="INPUT=CHOICE", help="fact on which limits of the guideline depend (again for more): "
        + "; ".join(f"{name} {key}={'|'.join(choices)}" for name, guideline in guidelines.read().items() for key, choices in guideline["inputs"].items()))  # fmt: skip
    add("--condition", action="append", default=[], type=condition, metavar="STAGE=KIND",
        help="judge this stage as " + ", ".join(guidelines.CONDITIONS) + " (again for more); default: the last static stage, usual or by its pseudo-static loads")  # fmt: skip
    add("--no-case", action="append", default=[], type=no_case, metavar="COMBINATION=WHY", help="a load combination of the guideline that does not concern this dam, and why: the sheet is not INCOMPLETE without a case of it (again for more)")
    add("--path", action="append", default=[], type=path, metavar="NAME=X,Y,X,Y,...", help="another plane or path [m]")
    add("--plane", action="append", default=[], type=plane, metavar="NAME=KIND", help="a joint or path is " + ", ".join(guidelines.PLANES) + ", where a guideline has limits for each; default: by the blocks on both sides (again for more)")
    add("--merge", action="append", default=[], metavar="NAME,NAME", help="joints in one straight line that are to be one base")
    add("--lifts", type=int, default=10, metavar="N", help="level sections over the height in N steps where the dam has no bed joints (10); 0: none")
    add("--strength-on", action="append", default=[], type=strengths, metavar="NAME=PHI,C[,PHI,C]",
        help="strength of a path, or another one of a joint, or of all lifts: friction [degree], cohesion [Pa]; the second pair residual")  # fmt: skip
    add("--strength", type=units.option("Pa"), metavar="PA", help="compressive strength of the dam [Pa], for limits of stress")
    add("--ky", type=coefficient, metavar="K|FOLDER", help="yield coefficient for Newmark's block beside stages that are shaken, or a run whose stage load_factor "
        "has found it; default: that of the run itself")  # fmt: skip
    add("--spectrum", metavar="FILE", help="design spectrum of an earthquake: coefficient, first mode and all modes beside each other (docs/safety.md)")
    water = result.add_argument_group("uplift, in the gravity method (docs/safety.md)")
    add = water.add_argument
    add("--uplift", choices=list(uplift.RULES), help="rule")
    add("--uplift-on", action="append", default=[], metavar="NAME", help="joint or path (again for more); default: all")
    add("--drain", type=units.option("m"), metavar="M", help="distance of the drain line from the heel, along the base; default: that of the scene's uplift load there")
    add("--efficiency", type=units.option("-"), metavar="E", help="of the drain, 0 to 1: rules usace and ferc; default: as in the scene")
    add("--drain-head", type=units.option("m"), metavar="M", help="measured head at the drain, above the base")
    add("--tailwater", type=units.option("m"), metavar="Y", help="level; default: a reservoir on the downstream side, else as in the scene")
    add("--gallery", type=units.option("m"), metavar="Y", help="level of the gallery's drains: rules usace and ferc; default: as in the scene")
    add("--uplift-direction", choices=("normal", "vertical"), default="normal",
        help="pressure normal to the base, or its vertical part only")  # fmt: skip
    add("--uplift-in-crack", choices=uplift.SHAKEN, help="uplift in a crack that an earthquake opens; full: at rest too, where the rule ignores the crack; default: as the rule says")
    return result


def options_from(given):
    return Options(given.guideline, once("--condition", given.condition), given.uplift, given.uplift_on, given.drain, given.efficiency,
                   given.tailwater, given.gallery, given.drain_head, given.uplift_direction, given.uplift_in_crack,
                   given.strength, once("--path", given.path), once("--strength-on", given.strength_on), given.ky, given.lifts, [text.split(",") for text in given.merge], given.guidelines, once("--given", given.given), given.spectrum, once("--plane", given.plane), once("--no-case", given.no_case))  # fmt: skip


def check_named(options, stages):
    """Names on the command line, before anything is worked out. A stage that the run has not reached may be named."""
    known = guidelines.read(options.guidelines)
    if options.guideline and options.guideline not in known:
        raise guidelines.GuidelineError(f"--guideline: no guideline '{options.guideline}', there are: {', '.join(known)}")
    if options.planes and not (options.guideline and any(known[options.guideline].get("planes", {}).values())):
        raise OptionError("--plane: it says whose limits hold, and the guideline has the same limits for all planes")
    combinations = [one["name"] for one in known[options.guideline].get("combinations") or ()] if options.guideline else []
    for name in options.no_case:
        if name not in combinations:
            raise guidelines.GuidelineError(f"--no-case: no load combination '{name}', there are: {', '.join(combinations) or 'none'}")
    inputs = known[options.guideline]["inputs"] if options.guideline else {}
    for name, choice in options.given.items():
        if choice not in inputs.get(name, ()):
            there = ", ".join(f"{key}={'|'.join(choices)}" for key, choices in inputs.items()) or "none"
            raise guidelines.GuidelineError(f"--given {name}={choice}: inputs of guideline {options.guideline or '(none is named)'}: {there}")
    for name in options.conditions:
        if name not in stages:
            raise guidelines.GuidelineError(f"--condition: no stage '{name}', there are: {', '.join(stages)}")
