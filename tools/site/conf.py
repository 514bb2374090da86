"""Settings of the site (tools/docs.sh): the Markdown pages of the repository as they are, with what a git host cannot show.

What comes to the pages here: the tables of contents, the keys of each page of docs/reference, and the reference of docs/python.md
and docs/c.md from the source. Pages stand in the site as they stand in the repository, so their links lead there too.
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
sys.path += map(str, ROOT.glob("build/venv/lib/python*/site-packages"))  # what the tools import

from quoin_tools import __version__  # noqa: E402
from quoin_tools.front import topics  # noqa: E402

project = "Quoin"
release = version = __version__
html_title = f"Quoin {version}"
root_doc = "README"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx_copybutton"]
include_patterns = ["README.md", "CHANGELOG.md", "docs/**.md", "examples/*/README.md"]
exclude_patterns = ["build*", "src", "tests", "tools", "**/.*"]
source_suffix = {".md": "markdown"}
myst_heading_anchors = 4
myst_links_external_new_tab = False
suppress_warnings = ["myst.header"]  # a heading may stand below one two levels up
highlight_language = "none"
copybutton_exclude = ".linenos, .gp, .go"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
nitpick_ignore_regex = [("py:.*", ".*")]  # types of numpy and pandas; links of pages are MyST's

html_theme = "furo"
html_css_files = ["site.css"]
html_static_path = [str(Path(__file__).parent / "static")]
html_search_scorer = str(Path(__file__).parent / "scorer.js")
html_show_search_summary = False  # it reads pages by requests, which a browser refuses in a folder
html_show_sourcelink = False
html_copy_source = False
html_show_copyright = False

FIRST = ["docs/install", "docs/generators", "docs/scene", "docs/generated/keys", "docs/static_stage", "docs/safety", "docs/front_door"]
MORE = ["docs/guidelines", "docs/limit_analysis", "docs/ensembles", "docs/readings", "docs/rigid_blocks", "docs/performance", "docs/reliability"]
FILES = ["docs/mesh_format", "docs/results_format", "docs/versions", "docs/python", "docs/c"]
CHECKS = ["docs/theory", "docs/deviations", "docs/verification", "docs/glossary"]
PARTS = ["docs/design", "docs/extend", "docs/licences", "CHANGELOG"]


PYTHON = """
## Functions and classes

```{eval-rst}
.. autofunction:: quoin.run
.. autofunction:: quoin.mesh
.. autoclass:: quoin.BlockMesh
   :members: write, centres
.. autoclass:: quoin.Results
   :members:
.. autoclass:: quoin_tools.base.results.Stage
.. autoclass:: quoin_tools.base.results.Mesh
   :members: rings, areas, centres, outline
.. autoclass:: quoin_tools.base.results.Contacts
   :members:
.. autoexception:: quoin.RunError
.. autoexception:: quoin.MeshError
```
"""
C = """
## `quoin.h`

```{literalinclude} ../include/quoin.h
:language: c
```

## A program

```{literalinclude} ../tests/install/solve.c
:language: c
```
"""


def pages(pattern):
    """Returns the pages of the repository that a pattern names."""
    return sorted(str(path.relative_to(ROOT).with_suffix("")) for path in ROOT.glob(pattern))


def contents():
    """Returns (caption, pages) of the table of contents."""
    there = [("First", FIRST), ("Tutorials", pages("docs/tutorials/*.md")), ("Coming from", pages("docs/coming_from/*.md")), ("The scene, page by page", [f"docs/reference/{name}" for name in topics.pages()]), ("Questions", MORE), ("Files and programs", FILES),
             ("Examples", pages("examples/*/README.md")), ("Theory and checks", [*CHECKS, *(page for page in pages("docs/generated/*.md") if page not in FIRST)]), ("The program", PARTS)]  # fmt: skip
    listed = [page for _, names in there for page in names]
    there[4][1].extend(page for page in pages("docs/*.md") if page not in listed)
    return [(caption, [page for page in names if (ROOT / f"{page}.md").exists()]) for caption, names in there]


def table_of_keys(page):
    """Returns the keys of a page of the reference as a table; what their names have in common stands above it."""
    rows = topics.rows_of_page(page)
    first = rows[0][0].rpartition("<name>.")[0] + "<name>." if "<name>" in rows[0][0] else ""
    first = first if all(row[0].startswith(first) for row in rows) else ""
    lines = ["## Keys" + (f" of `{first[:-1]}`" if first else ""), "", "| key | value, unit, default; meaning |", "|---|---|"]
    for key, default, unit, value, meaning in rows:
        value = page if key.endswith(".type") and page in value else value
        facts = f"{value}{f' [{unit}]' if unit else ''}, {default if default.startswith('required') else f'default: {default}'}"
        lines.append(f"| `{key.removeprefix(first)}` | *{facts.replace('<', '&lt;').replace('*', '')}*<br>{meaning.replace('<', '&lt;')} |")
    return "\n".join(lines)


def add(app, name, source):
    """Adds to the text of a page, as it is read, what the site alone has."""
    source[0] = source[0].replace("```mermaid", "```text")  # a git host draws it
    if name.startswith("docs/reference/"):
        table = table_of_keys(Path(name).name)
        source[0] = re.sub(r"^\*\*Keys\*\*.*?(?=\n\n|\Z)", lambda _: table, source[0].rstrip(), flags=re.M | re.S)
    source[0] += {"docs/python": PYTHON, "docs/c": C}.get(name, "")
    if name == root_doc:
        source[0] += "".join(f"\n```{{toctree}}\n:hidden:\n:caption: {caption}\n\n" + "".join(f"/{page}\n" for page in names) + "```\n" for caption, names in contents() if names)


def setup(app):
    app.connect("source-read", add)
