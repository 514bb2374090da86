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


class NewError(ValueError):
    """Such a dam cannot be; the message is one line."""


def main(words):
    options = parser().parse_args(words)
    from quoin_tools.base.files import write_file
    from quoin_tools.mesh import section

    numbers = numbers_of(options)
    folder = Path(options.folder)
    for name in ("section.yaml", "scene.yaml", "model.h5"):
        if os.path.lexists(folder / name):
            raise OSError(errno.EEXIST, "is there already, and stays as it is", str(folder / name))
    title = {"TITLE": quoted(folder.resolve().name)}
    for name in ("section.yaml", "scene.yaml"):
        write_file(folder / name, filled((TEMPLATES / name).read_text(encoding="utf-8"), numbers | title))
    code = section.main([str(folder / "section.yaml"), "-o", str(folder / "model.h5")])
    if code == 0:
        print(f"wrote {folder / 'section.yaml'}, {folder / 'scene.yaml'}: self-weight, full reservoir with uplift, sliding\n"
              f"next: cd {shlex.quote(str(folder))}; quoin run -n 2 scene.yaml; quoin show out")  # fmt: skip
    return code


def parser():
    words = Parser(prog="quoin new", description=__doc__.splitlines()[0], epilog=" ".join(__doc__.splitlines()[2:]))
    words.add_argument("folder")
    words.add_argument("--height", type=units.option("m"), default=33.0, help="crest above the base [m] (33)")
    words.add_argument("--crest-width", type=units.option("m"), default=5.0, help="[m] (5)")
    words.add_argument("--batter", type=float, default=0.05, help="upstream face, horizontal per vertical (0.05)")
    words.add_argument("--slope", type=float, default=0.7, help="downstream face, horizontal per vertical (0.7)")
    words.add_argument("--columns", type=int, default=16, help="blocks along the base (16)")
    return words


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
