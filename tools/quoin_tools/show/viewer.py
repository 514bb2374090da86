"""Writes one page to look into a run: section, stages or time, stresses, joints, water, anchors, histories.

    quoin show FOLDER --html

writes FOLDER/view.html. It is whole in itself: it needs no network and opens from a file. Its script and style are the files in page/.
"""

import json
import os
from pathlib import Path

from quoin_tools.base.command import Parser
from quoin_tools.base.files import write_file
from quoin_tools.base.results import Results
from quoin_tools.show.hypertext import esc
from quoin_tools.show.verify import signed
from quoin_tools.show.viewer_data import Page

PARTS = Path(__file__).parent / "page"
STYLES = ("uPlot.min.css", "page.css")
SCRIPTS = ("uPlot.iife.min.js", "data.js", "picture.js", "layers.js", "charts.js", "controls.js")  # uPlot: MIT licence, uPlot.LICENSE
NAME = "view.html"
MOST = 6_000_000  # numbers of the steps in the page: 32 MB


def page(results, most=MOST):
    """Text of the page."""
    content = Page(results, most)
    described = json.dumps(finite(content.content()), allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    scripts, styles = ("\n".join(read(name) for name in names) for names in (SCRIPTS, STYLES))
    text = read("page.html")
    for mark, part in (("TITLE", esc(results.title or results.model)), ("STYLE", styles), ("DESCRIBED", described), ("NUMBERS", content.numbers.text()), ("SCRIPT", scripts)):
        text = text.replace(f"<!--{mark}-->", part)
    return text


def read(name):
    return (PARTS / name).read_text(encoding="utf-8")


def finite(value):
    """Numbers that JSON does not know become null."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and value - value != 0 else value


def write(folder, most=MOST):
    path = os.path.join(folder, NAME)
    write_file(path, signed(page(Results(folder), most)))
    return path


def main(arguments=None):
    parser = Parser(prog="quoin show --html", description=f"One self-contained page about a run, FOLDER/{NAME}.")
    parser.add_argument("folder", metavar="FOLDER")
    parser.add_argument("--numbers", type=int, default=MOST, metavar="N", help="about how many numbers of the steps it may hold, four bytes each; beyond, it leaves out some, and says so")
    given = parser.parse_args(arguments)
    if given.numbers < 1:
        parser.error("--numbers: expected at least 1")
    print(write(given.folder, given.numbers))
    return 0
