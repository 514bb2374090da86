"""Runs the pages of docs/tutorials and docs/coming_from, and makes notebooks of them: a page is the one source of both.

    python examples/notebook.py docs/tutorials/01_first_dam.md ...     exit code 1: a run prints something else than its page says
    python examples/notebook.py PAGE ... --write                      writes the page's outputs and picture anew
    python examples/notebook.py PAGE ... --notebook FOLDER            FOLDER/PAGE.ipynb, for Jupyter

What a page has in fences, by the word behind the fence: `sh` and `python` run in order, in one empty folder; `text` behind them is
what they print, where a line may be missing, and `...` stands for what is not shown. Any other block whose first line is a comment with
a file's name becomes that file. Behind `<!-- from FILE -->` stands a picture that the run has made as FILE. Every number of two and
more digits in the prose, but for years, stands, to its digits, in a block of the page: so no number outlives the run that gave it.
"""

import argparse
import base64
import contextlib
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path

NUMBER = r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", flags=re.M | re.S)
FILE = re.compile(r"^(?:#|//|/\*) ([\w./-]+\.\w+)\b.*\n")
PICTURE = re.compile(r"<!-- from (\S+) -->\n!\[[^\]]*\]\(([^)]+)\)")
LINK = re.compile(r"\]\((?!\w+:|#)([^)]+)\)")  # to a file
MAY_END = (0, 6)  # done; collapsed, which is a result


def run_shell(source, folder):
    """What the lines print; the first that fails ends them."""
    done = subprocess.run(["bash", "-ec", source], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode not in MAY_END:
        raise SystemExit(f"{source}exit code {done.returncode}:\n{done.stdout}")
    return done.stdout


def run_python(source, folder, names):
    """What a cell prints; all cells of a page share their names, as in Jupyter."""
    printed = io.StringIO()
    with contextlib.chdir(folder), contextlib.redirect_stdout(printed):
        exec(compile(source, "cell", "exec"), names)  # noqa: S102
    return printed.getvalue()


def as_printed(told, printed):
    """The lines of a page with the numbers of what was printed, and the lines that were not printed or have other numbers."""
    if not told:
        return printed, ["an empty block: --write fills it"]
    found, wrong, lines = [], [], iter(printed.splitlines())
    for line in told.splitlines():
        words = re.split(rf"({NUMBER})", line.strip())
        pattern = "".join(rf"({NUMBER})" if index % 2 else re.sub(r"(?:\\ )+", r"\\s+", re.escape(word)).replace(r"\.\.\.", ".*?") for index, word in enumerate(words))
        match = None if line.strip() != "..." else ...
        while match is None and (candidate := next(lines, None)) is not None:
            match = re.fullmatch(pattern, candidate.strip())
        if match is ...:
            found.append(line)
            continue
        pieces = re.split(f"({NUMBER})", line)
        pieces[1::2] = match.groups() if match else pieces[1::2]
        found.append(now := "".join(pieces))
        if not match or not all(map(same, words[1::2], match.groups())):
            wrong.append(f"{line}\n   {now if match else 'was not printed'}")
    return "".join(f"{line}\n" for line in found), wrong


def same(told, printed):
    """Two numbers as they are written: within one of the last digit."""
    digits = len(told.split("e")[0].partition(".")[2])
    power = int(told.split("e")[1]) if "e" in told else 0
    return abs(float(told) - float(printed)) <= 1.01 * 10.0 ** (power - digits) * (digits > 0 or power != 0)


def without_source(page):
    """Prose: no blocks, code, links, headings, comments."""
    return re.sub(r"`[^`]*`|\]\([^)]*\)|^#+ [^\n]*$|<!--.*?-->|<a [^>]*>", " ", FENCE.sub("", page), flags=re.M | re.S)


def numbers_from_nowhere(page):
    """Numbers of the prose that no block of the page has, to their digits."""
    known = [float(number) for _, body in FENCE.findall(page) for number in re.findall(NUMBER, body)]
    told = re.findall(r"(?<![\w.-])\d+(?:\.\d+)?(?![\w.]*\d)", without_source(page))
    return [number for number in told if len(number) > 1 and not re.fullmatch(r"(18|19|20)\d\d", number) and not any(
        abs(abs(one) - float(number)) <= 0.5001 * 10.0 ** -len(number.partition(".")[2]) for one in known)]  # fmt: skip


def run(page, folder):
    """The page as a run in the folder writes it, and what is not as the page says."""
    names, printed, wrong, pieces, end = {"__name__": "__main__"}, None, [], [], 0
    for block in FENCE.finditer(page):
        kind, body = block.groups()
        if kind == "sh":
            printed = run_shell(body, folder)
        elif kind == "python":
            printed = run_python(body, folder, names)
        elif kind == "text" and printed is not None:
            now, others = as_printed(body, printed)
            wrong += others
            pieces += [page[end:block.start(2)], now]
            end = block.end(2)
        elif file := FILE.match(body):
            (folder / file[1]).parent.mkdir(parents=True, exist_ok=True)
            (folder / file[1]).write_text(body, encoding="utf-8")
    page = "".join(pieces) + page[end:]
    wrong += [f"the run has made no {made}" for made, _ in PICTURE.findall(page) if not (folder / made).exists()]
    return page, wrong + [f"{number} stands in the prose and in no block" for number in numbers_from_nowhere(page)]


def notebook(page, beside, links=str):
    """The page as a notebook: prose with its pictures in it, cells, what they print. beside: folder of the page; links: function of a link in it to that of the notebook."""
    cells, end = [], 0

    def prose(text):
        if not text.strip():
            return
        pictures = {Path(file).name: beside / file for _, file in PICTURE.findall(text)}
        for _, file in PICTURE.findall(text):
            text = text.replace(f"]({file})", f"](attachment:{Path(file).name})")
        text = LINK.sub(lambda link: f"]({links(link[1])})", text)
        cells.append({"cell_type": "markdown", "metadata": {}, "source": text.strip().splitlines(keepends=True)})
        if pictures:
            cells[-1]["attachments"] = {name: {"image/png": base64.b64encode(file.read_bytes()).decode("ascii")} for name, file in pictures.items()}

    for block in FENCE.finditer(page):
        kind, body = block.groups()
        file = FILE.match(body)
        if kind == "text" and cells and cells[-1]["cell_type"] == "code":
            cells[-1]["outputs"] = [{"name": "stdout", "output_type": "stream", "text": body.splitlines(keepends=True)}]
        elif kind in ("sh", "python") or file:
            prose(page[end:block.start()])
            source = "%%bash -e\n" + body if kind == "sh" else body if kind == "python" else f"%%writefile {file[1]}\n{body}"
            cells.append({"cell_type": "code", "execution_count": None, "metadata": {}, "outputs": [], "source": source.splitlines(keepends=True)})
        else:
            prose(page[end:block.end()])
        end = block.end()
    prose(page[end:])
    kernel = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    return {"cells": cells, "metadata": kernel, "nbformat": 4, "nbformat_minor": 4}


def link_from(folder, path, pages, link):
    """A link of a page as its notebook in a folder has it: to another notebook that is made with it, else to the file."""
    file, anchor, heading = link.partition("#")
    target = (path.parent / file).resolve()
    if target in [page.resolve() for page in pages]:
        return f"{target.stem}.ipynb"
    return os.path.relpath(target, folder.resolve()) + anchor + heading


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pages", nargs="+", type=Path)
    parser.add_argument("--write", action="store_true", help="write outputs and pictures of the pages anew")
    parser.add_argument("--notebook", type=Path, metavar="FOLDER", help="make notebooks there, run nothing")
    options = parser.parse_args(arguments)
    os.environ.setdefault("MPLBACKEND", "Agg")
    failed = 0
    for path in options.pages:
        page = path.read_text(encoding="utf-8")
        if options.notebook:
            options.notebook.mkdir(parents=True, exist_ok=True)
            (options.notebook / f"{path.stem}.ipynb").write_text(json.dumps(notebook(page, path.parent, partial(link_from, options.notebook, path, options.pages)), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
            continue
        with tempfile.TemporaryDirectory() as folder:
            now, wrong = run(page, Path(folder))
            if options.write:
                path.write_text(now, encoding="utf-8")
                for made, picture in PICTURE.findall(now):
                    shutil.copyfile(Path(folder, made), path.parent / picture)
                wrong = [line for line in wrong if line.endswith(("was not printed", "in no block"))]
        failed += bool(wrong)
        print("".join(f"{path}: {line}\n" for line in wrong), end="", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
