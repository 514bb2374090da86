"""Prints help about keys of the scene and chapters of the documents (80 columns).

    quoin help                     topics
    quoin help loads               keys of a section of the scene
    quoin help level               keys of this name, wherever they are
    quoin help silt                keys of a type of load or stage
    quoin help safety              a document: what it has
    quoin help "a dynamic stage"   a chapter, by (a part of) its heading
    quoin help --site              all pages with a search, in the browser
    quoin help --schema [FILE]     JSON Schema of the scene, for editors
"""

import difflib
import json
import re
import textwrap
from importlib import resources
from pathlib import Path

import quoin_tools
from quoin_tools.base.solver import CHECKOUT

WIDTH = 80
DOCUMENTS = ("install", "scene", "mesh_format", "results_format", "generators", "safety", "limit_analysis", "ensembles", "rigid_blocks", "performance", "reliability", "versions",
             "theory", "deviations", "verification", "glossary")  # those of users first  # fmt: skip


class TopicError(ValueError):
    """There is no such topic; the message is one line."""


def folder():
    """Returns the folder of the documents, of an installed package or of the checkout."""
    installed = Path(quoin_tools.__file__).parent / "docs"
    return installed if installed.is_dir() else CHECKOUT / "docs"


def read(name):
    return (folder() / f"{name}.md").read_text(encoding="utf-8")


def main(words):
    if words[:1] in (["-h"], ["--help"]):
        print(__doc__.strip())
    elif not words:
        print(overview())
    else:
        print(topic(" ".join(words)))
    return 0


# ---- topics


def key_rows():
    """Returns the rows of the table of keys: key, default, unit, value, meaning."""
    rows = [line for line in read("generated/keys").splitlines() if line.startswith("| `")]
    return [tuple(plain(cell.strip()) for cell in row.strip().strip("|").split("|")) for row in rows]


def pages():
    """Returns the names of the pages of docs/reference, in the order in which docs/scene.md has them."""
    return list(dict.fromkeys(re.findall(r"\(reference/(\w+)\.md\)", read("scene"))))


def chapters():
    """Returns (document, heading, text) of every chapter, in the order of DOCUMENTS, then of the reference; a heading within code does not count."""
    found = []
    for document in (*DOCUMENTS, *(f"reference/{name}" for name in pages())):
        heading, lines, code = document, [], False
        for line in read(document).splitlines():
            code ^= line.startswith("```")
            if line.startswith("## ") and not code:
                found.append((document, heading, "\n".join(lines)))
                heading, lines = line[3:], []
            else:
                lines.append(line)
        found.append((document, heading, "\n".join(lines)))
    return found


def sections():
    """Returns the first words of the keys: materials, joints, ..."""
    return list(dict.fromkeys(row[0].split(".")[0] for row in key_rows() if "." in row[0]))


def overview():
    single = [row[0] for row in key_rows() if "." not in row[0]]
    parts = [("The scene", pages()), ("Single keys", single), ("Documents", DOCUMENTS)]
    lines = ["quoin help TOPIC", ""]
    for title, names in parts:
        lines += [title, *textwrap.wrap(", ".join(names), WIDTH, initial_indent="  ", subsequent_indent="  ", break_on_hyphens=False), ""]
    lines += ["Chapters, whole or by a part of their heading:"]
    lines += [f"  {heading}" for document, heading, _ in chapters() if document in ("install", "scene", "safety", "generators") and heading != document]
    return "\n".join(lines)


# ---- one topic


def topic(name):
    wanted = name.lower().strip()
    page = wanted.replace(" ", "_")
    if wanted in DOCUMENTS:
        return document(wanted)
    rows = rows_of_page(page) if page in pages() else []
    rows += [row for row in key_rows() if wanted in (row[0], row[0].split(".")[-1]) and row not in rows]
    exact = [chapter for chapter in chapters() if chapter[1].lower() == wanted]
    near = exact or [chapter for chapter in chapters() if re.search(rf"\b{re.escape(wanted)}\b", plain(chapter[1]).lower()) and chapter[1] != chapter[0]]
    if page not in pages() and not rows and not near:
        raise TopicError(unknown(wanted))
    parts = [page_text(page)] if page in pages() else []
    parts += [key_text(rows)] if rows else []
    if near and not parts:
        parts += [chapter_text(chapter) for chapter in near[:1]]
        near = near[1:]
    if near:
        parts.append("\n".join(["More:", *(f'  quoin help "{heading.lower()}"    ({document}.md)' for document, heading, _ in near)]))
    return "\n\n".join(parts)


def types():
    """Returns (section, type) of loads and stages."""
    found = [(key.split(".")[0], value) for key, _, _, value, _ in key_rows() if key.endswith(".<name>.type")]
    return [(section, name) for section, value in found for name in value.split(", ")]


def rows_of_page(page):
    """Returns the keys of a page of the reference: those that its line of keys names, or those of the section or type whose name it has."""
    named = re.findall(r"`([^`]+)`", re.search(r"^\*\*Keys\*\*.*?(?=\n\n|\Z)", read(f"reference/{page}"), flags=re.M | re.S)[0])
    if named:
        return [row for row in key_rows() if row[0] in named]
    if page in sections():
        return [row for row in key_rows() if row[0].startswith(f"{page}.")]
    return rows_of_type(page) if page in dict(map(reversed, types())) else [row for row in key_rows() if "." not in row[0]]


def rows_of_type(name):
    """Returns the keys of a type of load or stage, by the schema; of two rows of a key the one with its meaning there."""
    section = dict(map(reversed, types()))[name]
    schema = json.loads(resources.files("quoin_tools.front").joinpath("scene.schema.json").read_text(encoding="utf-8"))
    keys = next(part["then"]["properties"] for part in schema["definitions"][section]["allOf"] if part["if"]["properties"]["type"]["const"] == name)
    of_section = {row: row[0].removeprefix(f"{section}.<name>.").removesuffix(".<name>") for row in key_rows() if row[0].startswith(f"{section}.")}
    return [row for row, key in of_section.items() if key in keys and plain(keys[key].get("description", row[4])).startswith(row[4])]


def page_text(name):
    """A page of the reference; its keys follow it."""
    text = read(f"reference/{name}")
    return "\n".join(laid_out(re.sub(r"^\*\*Keys\*\*.*?(\n\n|\Z)", "", text, flags=re.M | re.S).strip()))


def unknown(wanted):
    names = [*pages(), *DOCUMENTS, *(row[0].split(".")[-1] for row in key_rows()), *(heading.lower() for _, heading, _ in chapters())]
    close = difflib.get_close_matches(wanted, names, 1)
    return f"no topic '{wanted}'" + (f"; did you mean '{close[0]}'?" if close else "; `quoin help` lists them")


def key_text(rows):
    lines = []
    for key, default, unit, value, meaning in rows:
        facts = "; ".join(filter(None, [value, unit and unit != "-" and f"[{unit}]", f"default: {default}" if default != "required" else "required"]))
        lines += [key, *indented(facts), *indented(meaning), ""]
    return "\n".join(lines).rstrip()


def indented(text):
    return textwrap.wrap(text, WIDTH, initial_indent="    ", subsequent_indent="    ", break_on_hyphens=False)


def document(name):
    own = [chapter for chapter in chapters() if chapter[0] == name]
    head = chapter_text((name, "", own[0][2]))
    headings = [f'  quoin help "{heading.lower()}"' for _, heading, _ in own[1:]]
    return "\n".join([head, "", "Chapters:", *headings] if headings else [head])


def chapter_text(chapter):
    document, heading, text = chapter
    lines = [f"{heading} ({document}.md)", ""] if heading else []
    return "\n".join([*lines, *laid_out(text.strip())]).strip()


def laid_out(text):
    """Lays Markdown out in 80 columns: paragraphs and lists are filled, code stays as it is, rows of tables are paragraphs, pictures are left out."""
    lines, block, code = [], [], False

    def flush():
        if block:
            first = re.match(r"(\s*(?:[-*]|\d+\.)\s+)?", block[0])[0]
            filled = plain(" ".join(line.strip() for line in block))
            start = len(first.strip()) + 1 if first else 0
            lines.extend(textwrap.wrap(filled, WIDTH, subsequent_indent=" " * start, break_on_hyphens=False, break_long_words=False))
            block.clear()

    for line in text.splitlines():
        if line.startswith("```"):
            flush()
            code = not code
        elif code:
            lines.extend(code_line(line))
        elif line.startswith("|"):
            flush()
            cells = [plain(cell.strip()) for cell in line.strip().strip("|").split("|")]
            if any(set(cell) - set("-: ") for cell in cells):
                lines.extend(textwrap.wrap(" | ".join(cells), WIDTH, initial_indent="  ", subsequent_indent="      ", break_on_hyphens=False))
        elif not line.strip():
            flush()
            lines.append("")
        elif not line.startswith("!["):
            if re.match(r"\s*([-*]|\d+\.)\s", line) or line.startswith("#"):
                flush()
            block.append(line.lstrip("#").lstrip() if line.startswith("#") else line)
    flush()
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)).split("\n")


def code_line(line):
    """Keeps code as it is; a comment behind it moves above it where the line is too long."""
    indent = "    "
    if len(indent + line) <= WIDTH:
        return [indent + line]
    found = re.match(r"(\s*)(.*\S)\s+#\s(.*)$", line)
    if found and len(indent + found[1] + found[2]) <= WIDTH:
        comment = textwrap.wrap(found[3], WIDTH, initial_indent=indent + found[1] + "# ", subsequent_indent=indent + found[1] + "# ")
        return [*comment, indent + found[1] + found[2]]
    return textwrap.wrap(line, WIDTH, initial_indent=indent, subsequent_indent=indent + "        ", break_on_hyphens=False, drop_whitespace=False)


def plain(text):
    """Removes the marks of Markdown: links, emphasis, code."""
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    return text.replace("**", "").replace("`", "")
