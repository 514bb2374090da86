"""Runs a notebook without Jupyter, in the working directory, and holds what its cells print against what it has stored.

    python examples/notebook.py examples/dam.ipynb            exit code 1: a cell prints something else
    python examples/notebook.py examples/dam.ipynb --write    stores texts and pictures anew
"""

import argparse
import base64
import contextlib
import io
import json
import sys
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
from matplotlib import pyplot  # noqa: E402


def run(notebook):
    """Outputs of each code cell: what it has printed, and its pictures. All cells share one namespace, as in Jupyter."""
    names, found = {"__name__": "__main__"}, []
    for number, cell in enumerate(notebook["cells"]):
        if cell["cell_type"] != "code":
            continue
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile("".join(cell["source"]), f"cell {number}", "exec"), names)  # noqa: S102
        found.append((cell, printed.getvalue(), pictures()))
    return found


def pictures():
    """Figures that are open, as PNG; they are closed."""
    drawn = []
    for number in pyplot.get_fignums():
        file = io.BytesIO()
        pyplot.figure(number).savefig(file, format="png", dpi=60, bbox_inches="tight")
        drawn.append(base64.b64encode(file.getvalue()).decode("ascii"))
    pyplot.close("all")
    return drawn


def stored(cell):
    """Text that a cell has stored."""
    return "".join(line for output in cell["outputs"] if output["output_type"] == "stream" for line in output["text"])


def store(cell, text, drawn):
    streams = [{"name": "stdout", "output_type": "stream", "text": text.splitlines(keepends=True)}] if text else []
    shown = [{"data": {"image/png": png, "text/plain": ["<Figure>"]}, "metadata": {}, "output_type": "display_data"} for png in drawn]
    cell["outputs"] = streams + shown


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("notebook")
    parser.add_argument("--write", action="store_true", help="store what the cells print and draw")
    options = parser.parse_args(arguments)
    path = Path(options.notebook)
    notebook = json.loads(path.read_text(encoding="utf-8"))
    others = 0
    for cell, text, drawn in run(notebook):
        if options.write:
            store(cell, text, drawn)
        elif text != stored(cell):
            others += 1
            print(f"{''.join(cell['source'])}\n-- stored:\n{stored(cell)}-- now:\n{text}", file=sys.stderr)
    if options.write:
        path.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return 1 if others else 0


if __name__ == "__main__":
    sys.exit(main())
