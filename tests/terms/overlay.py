"""The sources that the diff of docs/extend.md changes or adds, written into a folder of their own.

    python tests/terms/overlay.py docs/extend.md src build/tests/springs
"""

import re
import sys
from pathlib import Path


def changes(text):
    """{path: [(old lines, new lines), ...]} of the first diff of a page; old lines that stand in no row are found by content."""
    diff = re.search(r"^```diff\n(.*?)^```", text, re.MULTILINE | re.DOTALL).group(1)
    files = {}
    for part in re.split(r"^--- .*\n", diff, flags=re.MULTILINE)[1:]:
        head, *lines = part.splitlines()
        path = head.removeprefix("+++ b/src/")
        hunks, old, new = [], [], []
        for line in lines:
            if line[:1] == "-" and new:  # the next change
                hunks.append((old, new))
                old, new = [], []
            if line[:1] in "- ":
                old.append(line[1:])
            if line[:1] in "+ ":
                new.append(line[1:])
        files[path] = [*hunks, (old, new)]
    return files


def main(page, sources, folder):
    for path, hunks in changes(Path(page).read_text(encoding="utf-8")).items():
        source = Path(sources) / path
        text = source.read_text(encoding="utf-8") if hunks[0][0] else ""
        for old, new in hunks:
            before, after = ("\n".join(lines) + "\n" if lines else "" for lines in (old, new))
            if text.count(before) != 1 and before:
                sys.exit(f"{page}: {source}: these lines are there {text.count(before)} times:\n{before}")
            text = text.replace(before, after) if before else after
        there = Path(folder) / path
        there.parent.mkdir(parents=True, exist_ok=True)
        if not there.exists() or there.read_text(encoding="utf-8") != text:
            there.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
