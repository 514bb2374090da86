"""A folder to begin with: section.yaml, scene.yaml and model.h5 of a gravity dam on rock.

Change the section, and mesh it again by `quoin import section.yaml -o model.h5`;
change the scene: its reservoir is full. For a mesh of your own (`quoin import`
makes it of a Gmsh file) put its names into the scene."""

import errno
import os
import shlex
from pathlib import Path

from quoin_tools.base import units
from quoin_tools.base.command import Parser

TEMPLATES = Path(__file__).parent
CREST_FACE = 0.15  # of the height is the vertical face below the crest


NUMBERS = {"pool": ("m", "normal level of the reservoir (the crest)"), "flood": ("m", "level of the highest flood"), "tailwater": ("m", "level downstream"), "silt": ("m", "surface of the silt"),
           "ice": ("N/m", "thrust of the ice"), "drain": ("m", "distance of the drains from the heel"), "efficiency": ("-", "of the drains"), "obe": ("-", "k_h of the operating basis earthquake"),
           "quake": ("-", "k_h of the largest earthquake")}  # fmt: skip
SPECTRUM = """# The design spectrum of the largest earthquake: quoin report out --guideline NAME --spectrum spectrum.yaml
# Change type, ground and a_g to yours; docs/safety.md has ASCE 7 and tables, and keys of the reservoir and the rock.
rule: eurocode8
type: 1
ground: A
a_g: @A_G@
unit: g
condition: earthquake
"""


class NewError(ValueError):
    """Such a dam cannot be; the message is one line."""


def main(words):
    options = parser().parse_args(words)
    from quoin_tools.base.files import write_file
    from quoin_tools.mesh import section

    numbers = numbers_of(options)
    folder = Path(options.folder)
    for name in ("section.yaml", "scene.yaml", "model.h5", *(["spectrum.yaml"] if options.spectrum else [])):
        if os.path.lexists(folder / name):
            raise OSError(errno.EEXIST, "is there already, and stays as it is", str(folder / name))
    title, cases = {"TITLE": quoted(folder.resolve().name)}, cases_of(options)
    for name in ("section.yaml", "scene.yaml"):
        text = (TEMPLATES / name).read_text(encoding="utf-8")
        if name == "scene.yaml" and cases:
            text = with_cases(text, options, *cases)
        write_file(folder / name, filled(text, numbers | title))
    if options.spectrum:
        write_file(folder / "spectrum.yaml", filled(SPECTRUM, {"A_G": f"{options.spectrum:g}"}))
    code = section.main([str(folder / "section.yaml"), "-o", str(folder / "model.h5")])
    if code == 0:
        what = f"the cases of guideline {options.guideline}" if options.guideline else "self-weight, full reservoir with uplift, sliding"
        print(f"wrote {folder / 'section.yaml'}, {folder / 'scene.yaml'}: {what}\n"
              f"next: {'' if folder == Path() else f'cd {shlex.quote(str(folder))}; '}quoin run -n 2 scene.yaml; quoin show out")  # fmt: skip
    return code


def parser():
    words = Parser(prog="quoin new", description=__doc__.splitlines()[0], epilog=" ".join(__doc__.splitlines()[2:]))
    words.add_argument("folder")
    words.add_argument("--height", type=units.option("m"), default=33.0, help="crest above the base [m] (33)")
    words.add_argument("--crest-width", type=units.option("m"), default=5.0, help="[m] (5)")
    words.add_argument("--batter", type=float, default=0.05, help="upstream face, horizontal per vertical (0.05)")
    words.add_argument("--slope", type=float, default=0.7, help="downstream face, horizontal per vertical (0.7)")
    words.add_argument("--guidelines", metavar="FILE", help="with --guideline: YAML with guidelines of yours (docs/guidelines.md); the scene names it")
    words.add_argument("--guideline", metavar="NAME", help="write the load combinations that this guideline asks for; those whose numbers are not given stand as comments: " + ", ".join(with_combinations()))
    for name, (unit, what) in NUMBERS.items():
        words.add_argument(f"--{name}", type=units.option(unit), metavar=unit.upper() if unit != "-" else "X", help=f"with --guideline: {what}")
    words.add_argument("--spectrum", type=units.option("-"), metavar="A_G", help="with --guideline: stages of modes, and spectrum.yaml by Eurocode 8 with this acceleration of the ground [g]")
    words.add_argument("--columns", type=int, default=16, help="blocks along the base (16)")
    return words


def with_combinations(file=None):
    from quoin_tools.assess import guidelines

    return [name for name, guideline in guidelines.read(file).items() if guideline.get("combinations")]


def cases_of(options):
    """Returns the lines of the loads and of the stages that a guideline asks for; None without one."""
    given = {name: getattr(options, name) for name in NUMBERS if getattr(options, name) is not None}
    if options.spectrum is not None and not 0 < options.spectrum < 10:
        raise NewError(f"--spectrum: {options.spectrum:g}: expected the acceleration of the ground in g, above 0 and below 10")
    if not options.guideline:
        if options.guidelines:
            raise NewError("--guidelines: it belongs to the cases of a guideline, and --guideline names none")
        if given or options.spectrum:
            raise NewError(f"--{next(iter(given), 'spectrum')}: it belongs to the cases of a guideline, and --guideline names none")
        return None
    from quoin_tools.assess import guidelines
    from quoin_tools.front import cases

    try:
        if options.guideline not in guidelines.read(options.guidelines):
            raise NewError(f"--guideline: no guideline '{options.guideline}', there are: {', '.join(with_combinations(options.guidelines))}")
        loads, stages, usual = cases.of_guideline(options.guideline, cases.Numbers(height=options.height, **given), options.guidelines)
    except guidelines.GuidelineError as error:
        raise NewError(str(error)) from error
    if options.spectrum:
        pool = options.height if options.pool is None else options.pool
        loads.append(f"  hydro: {{type: added_mass, faces: upstream, level: {pool:g}}}")
        stages = ["  # modes of the empty dam and of the dam with its reservoir, for quoin report --spectrum spectrum.yaml", "  - dry: {type: modes, from: empty, count: 10}", *stages,
                  f"  - wet: {{type: modes, from: {usual.name}, count: 10, loads: [hydro]}}"]  # fmt: skip
    sliding = f"  - sliding: {{type: strength_reduction, from: {usual.name}, loads: [{', '.join(usual.loads)}], step: 2, limit: 10, bracket: 0.5, displacement_limit: 0.02}}"
    return loads, [*stages, sliding]


def with_cases(text, options, loads, stages):
    """The template of the scene with these loads and stages in place of its own, which are its end."""
    head = text[: text.index("loads:\n")].replace("report out  ", f"report out --guideline {options.guideline}  ")
    if options.spectrum:
        head = head.replace("  rock: {density: 2500, young: 10e9, poisson: 0.2}", "  rock: {density: 1, young: 10e9, poisson: 0.2}  # rock with mass would swing as a box of its own")
    if options.guidelines:
        head = head.replace("output: out\n", f"output: out\nguidelines: {quoted(os.path.relpath(options.guidelines, options.folder))}\n")
    return head + "\n".join(["loads:", *loads, "", "stages:", "  - empty: {loads: [weight]}", *stages, ""])


def numbers_of(options):
    """Returns the numbers of the templates."""
    height, slope = options.height, options.slope
    if not (0 < height < 1e4 and 0 < options.crest_width < 1e4 and 0 <= options.batter < 10 and 0 <= slope < 10 and options.columns >= 1):
        raise NewError("expected a height, a crest and columns above zero, and faces that do not overhang")
    upper = round((1 - CREST_FACE) * height, 2)
    toe = options.batter * height + options.crest_width + slope * upper
    values = {"HEIGHT": height, "BREAK": upper, "TOE": round(toe, 2), "BATTER": options.batter, "SLOPE": slope, "COLUMNS": options.columns,
              "ROCK": round(3 * height, 1)}  # fmt: skip
    return {name: f"{value:g}" for name, value in values.items()}


def filled(text, values):
    for name, value in values.items():
        text = text.replace(f"@{name}@", value)
    return text


def quoted(text):
    """Returns a text as YAML."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
