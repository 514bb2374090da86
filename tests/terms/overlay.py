"""The sources that tests/terms/*.diff change or add, one after the other, written into a folder of their own.

    python tests/terms/overlay.py build/tests/recipes src tests/terms/*.diff     prints the paths of what it wrote
"""

import re
import sys
from pathlib import Path


def changes(diff):
    """(path, [(old lines, new lines), ...]) of each file; the old lines are found by content."""
    for part in re.split(r"^--- .*\n", diff, flags=re.MULTILINE)[1:]:
        head, *lines = part.splitlines()
        hunks, old, new = [], [], []
        for line in lines:
            if line[:1] == "-" and new:  # the next change
                hunks.append((old, new))
                old, new = [], []
            if line[:1] in "- ":
                old.append(line[1:])
            if line[:1] in "+ ":
                new.append(line[1:])
        yield head.removeprefix("+++ b/src/"), [*hunks, (old, new)]


def changed(page, path, text, hunks):
    for old, new in hunks:
        before, after = ("\n".join(lines) + "\n" if lines else "" for lines in (old, new))
        if before and text.count(before) != 1:
            sys.exit(f"{page}: {path}: these lines are there {text.count(before)} times:\n{before}")
        text = text.replace(before, after) if before else after
    return text


def main(folder, sources, *pages):
    texts = {}
    for page in pages:
        for path, hunks in changes(Path(page).read_text(encoding="utf-8")):
            if path not in texts:
                texts[path] = (Path(sources) / path).read_text(encoding="utf-8") if hunks[0][0] else ""
            texts[path] = changed(page, path, texts[path], hunks)
    for old in Path(folder).rglob("*.[ch]"):
        if old.relative_to(folder).as_posix() not in texts:
            old.unlink()
    for path, text in texts.items():
        there = Path(folder) / path
        there.parent.mkdir(parents=True, exist_ok=True)
        if not there.exists() or there.read_text(encoding="utf-8") != text:
            there.write_text(text, encoding="utf-8")
    print(*texts, sep="\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
