"""Where benchmarks leave what they found: rows in docs/data/<name>.json, tables between marks of docs/generated/benchmarks.md."""

import json
from pathlib import Path

DOCS = Path(__file__).resolve().parent.parent.parent / "docs"
DATA = DOCS / "data"
TABLES = Path("generated", "benchmarks.md")


def keep(name, rows, identity):
    """Rows of docs/data/<name>.json with `rows` in place of those that agree in the columns `identity`; written back."""
    path, known = DATA / f"{name}.json", {}
    old = json.loads(path.read_text(encoding="utf-8")) if path.exists() else []
    for row in [*old, *rows]:
        rounded = {column: float(f"{value:.6g}") if isinstance(value, float) else value for column, value in row.items()}
        known[tuple(row[column] for column in identity)] = rounded
    path.write_text("[\n" + ",\n".join(" " + json.dumps(row) for row in known.values()) + "\n]\n", encoding="utf-8")
    return list(known.values())


def table(header, rows):
    """Markdown; header and rows are lists of cells."""
    head, *lines = ("| " + " | ".join(str(cell) for cell in line) + " |\n" for line in [header, *rows])
    return head + "|" + "---|" * len(header) + "\n" + "".join(lines)


def replace_between(mark, text):
    """The text between <!-- mark --> and <!-- end mark --> of docs/generated/benchmarks.md."""
    path, start, end = DOCS / TABLES, f"<!-- {mark} -->\n", f"<!-- end {mark} -->"
    head, rest = path.read_text(encoding="utf-8").split(start)
    path.write_text(head + start + text + end + rest.split(end)[1], encoding="utf-8")
