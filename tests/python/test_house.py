"""The house of src/ stands: rooms in their order, one header each, includes and calls that lead down only, no circle.

    python tests/python/test_house.py --files    # writes docs/generated/files.md: what each file does, and what tests it
    python tests/python/test_house.py --table    # rooms: files, lines, what each takes from the others, who includes each header"""

import functools
import os
import re
import shutil
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SRC = ROOT / "src"
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
OBJECTS = QUOIN.parent / "CMakeFiles/libquoin.dir/src"

# From the bottom to the top: a room knows itself and what stands before it, by these headers.
ROOMS = {
    "base": ["base.h", "eigen.h", "lanes.h", "memory.h", "reproducible.h", "lanes_sums.h", "shared.h"],  # tools, each included where it is used
    "result/stage": ["stage_result.h"],  # what every room from archive/ up fills
    "scene": ["scene.h", "reader.h"],  # what was read; the reader, for those who complete keys
    "mesh": ["mesh.h"],
    "model": ["model.h"],
    "archive": ["archive.h"],
    "term": ["term.h"],
    "boundary": ["boundary.h"],
    "contacts/law": ["law.h", "stress_models.h"],  # of one contact; of the lanes of the kernels
    "contacts": ["contacts.h"],
    "blocks": ["blocks.h"],
    "loads": ["loads.h"],
    "water": ["water.h"],
    "seepage": ["seepage.h"],
    "anchors": ["anchors.h"],
    "forces": ["forces.h"],
    "motion": ["motion.h"],
    "result": ["result.h"],
    "verdict": ["verdict.h", "thresholds.h"],
    "output": ["output.h"],
    "solve": ["solve.h"],
    "stages": ["stages.h"],
    "run": ["run.h"],
    "study": ["study.h"],
    "": [],  # main.c
}
HEIGHT = {room: i for i, room in enumerate(ROOMS)}
LONGEST_FILE = 500


def room_of(path):
    return path.parent.relative_to(SRC).as_posix().removeprefix(".")


def sources():
    return sorted(path for path in SRC.rglob("*.[ch]"))


def test_every_file_has_a_room():
    assert sorted({room_of(path) for path in sources()}) == sorted(ROOMS)


def test_names_of_files_say_which():
    """Documents name a file without its room."""
    names = [path.name for path in sources()]
    assert len(names) == len(set(names)), sorted(name for name in names if names.count(name) > 1)


def test_includes_lead_down_and_to_public_headers():
    faults = []
    for path in sources():
        room = room_of(path)
        for line in re.findall(r'^#include "([^"]+)"', path.read_text(), re.MULTILINE):
            if line == "quoin.h":
                continue
            target = SRC / line
            assert target.exists(), f"{path}: {line}"
            there = room_of(target)
            if there != room and HEIGHT[there] > HEIGHT[room]:
                faults.append(f"{path.relative_to(SRC)} includes upwards: {line}")
            if there != room and target.name not in ROOMS[there]:
                faults.append(f"{path.relative_to(SRC)} includes what {there} keeps for itself: {line}")
    assert not faults, "\n".join(faults)


def test_no_file_is_long():
    long = {path.relative_to(SRC).as_posix(): n for path in sources() if (n := len(path.read_text().splitlines())) > LONGEST_FILE}
    assert not long, long


@functools.cache
def calls():
    """Of each C file those whose functions or data it uses: {file: {other: [names]}}, by the symbols of the objects."""
    objects = {}
    for path in SRC.rglob("*.c"):
        name = path.relative_to(SRC).as_posix()
        objects[name] = QUOIN.parent / "CMakeFiles/quoin.dir/src/main.c.o" if name == "main.c" else OBJECTS / f"{name}.o"
        if not objects[name].exists():
            pytest.skip(f"no {objects[name]}: another generator")
    names = {str(path): name for name, path in objects.items()}
    defined, used = {}, {name: set() for name in objects}
    for line in subprocess.run(["nm", "-A", *names], check=True, capture_output=True, text=True).stdout.splitlines():
        place, _, rest = line.partition(".o:")
        name, words = names[place + ".o"], rest.split()
        if words[-2] == "U":
            used[name].add(words[-1])
        elif words[-2] in "TDRBC":
            defined[words[-1]] = name
    graph = {name: defaultdict(list) for name in used}
    for name, symbols in used.items():
        for symbol in sorted(symbols):
            if defined.get(symbol, name) != name:
                graph[name][defined[symbol]].append(symbol)
    return graph


def test_calls_lead_down():
    faults = []
    for name, others in calls().items():
        room = room_of(SRC / name)
        for other, symbols in others.items():
            if HEIGHT[room_of(SRC / other)] > HEIGHT[room]:
                faults.append(f"{name} calls {other}: {', '.join(symbols)}")
    assert not faults, "\n".join(faults)


def test_no_circle_of_files():
    """Files that call each other in a circle, found by taking away again and again those that call none that is left."""
    graph = {name: set(others) for name, others in calls().items()}
    while True:
        free = [name for name, others in graph.items() if not others & graph.keys()]
        if not free:
            break
        for name in free:
            del graph[name]
    assert not graph, sorted(graph)


# ---- unit tests stand beside the files they test; tests/coverage.md names what covers the other files

TESTS = ROOT / "tests"
ROWS = re.findall(r"^\| `([\w/.]+)` \| (.+) \|$", (TESTS / "coverage.md").read_text(encoding="utf-8"), flags=re.M)
UNIT_TESTS = {path.relative_to(TESTS).as_posix() for path in TESTS.glob("unit/**/test_*.c")}
C_FILES = {path.relative_to(SRC).as_posix() for path in sources() if path.suffix == ".c"}
COVERED = [(file, by) for file, by in ROWS if not file.startswith("unit/")]


def own_test(file):
    room, _, name = f"unit/{file}".rpartition("/")
    return f"{room}/test_{name}"


def test_unit_tests_are_named_for_a_file_of_their_room():
    """A file test_<name>.c beside src/<room>/<name>.c or .h; those of no one file are in the table."""
    headers = {path.relative_to(SRC).with_suffix(".c").as_posix() for path in SRC.rglob("*.h")}
    strays = UNIT_TESTS - {own_test(file) for file in C_FILES | headers}
    assert strays == {file for file, _ in ROWS if file.startswith("unit/")}


def test_every_file_is_covered_once():
    """By a unit test of its own, or by a row."""
    without = {file for file in C_FILES if own_test(file) not in UNIT_TESTS}
    files = [file for file, _ in COVERED]
    assert sorted(files) == sorted(without), set(files) ^ without


def test_rows_name_what_is_there():
    for file, by in COVERED:
        named = re.findall(r"`([\w/]+/[\w.]+)`", by)
        assert named or by.startswith("every case"), file
        missing = [name for name in named if not (TESTS / name).is_file()]
        assert not missing, (file, missing)


# ---- the page of files

PAGE = ROOT / "docs" / "generated" / "files.md"


def purpose(path):
    """The first sentence of a file, which says after its name what the file does."""
    head = re.match(r"/\* (?:[\w/]+\.[ch]): (.*?)\*/", path.read_text(encoding="utf-8"), flags=re.S)
    assert head, f"{path.relative_to(SRC)} does not begin with /* {path.name}: what it does"
    words = " ".join(head.group(1).split())
    sentence = re.match(r".*?(?<!Fig)[.;](?= |$)|.*", words).group().rstrip(".; ")
    return sentence.replace("|", "\\|")


def covered_by(path):
    file = path.relative_to(SRC).with_suffix(".c").as_posix()
    return f"`{own_test(file)}`" if own_test(file) in UNIT_TESTS else dict(COVERED).get(path.relative_to(SRC).as_posix(), "")


def page_of_files():
    lines = ["# What each file does, and what tests it", "",
             "Written by `tests/python/test_house.py` from the first sentence of each file, its unit test, and `tests/coverage.md`. Rooms as in",
             "[design](../design.md#the-rooms), from the top to the bottom.", ""]  # fmt: skip
    for room in reversed(ROOMS):
        lines += [f"## src/{room}", "", "| file | what it does | tested by |", "|---|---|---|"]
        lines += [f"| `{path.name}` | {purpose(path)} | {covered_by(path)} |" for path in sources() if room_of(path) == room]
        lines.append("")
    return "\n".join(lines)


def test_page_of_files_is_that_of_the_files():
    assert PAGE.read_text(encoding="utf-8") == page_of_files(), "python tests/python/test_house.py --files"


# ---- commits

def git(*words):
    return subprocess.run(["git", "-C", ROOT, *words], capture_output=True, text=True)


def test_subjects_of_commits_are_short():
    """Below 72 characters since the last release; a tree without git or without the tag has no such commits to judge."""
    top = git("rev-parse", "--show-toplevel") if shutil.which("git") else None
    if not top or top.returncode or Path(top.stdout.strip()).resolve() != ROOT:
        pytest.skip("no git history")
    tag = git("describe", "--tags", "--abbrev=0", "--match", "v[0-9]*")
    if tag.returncode:
        pytest.skip("no tag of a release in the history")
    log = git("log", "--no-merges", "--format=%h %s", f"{tag.stdout.strip()}..HEAD")
    assert log.returncode == 0, log.stderr
    long = [line for line in log.stdout.splitlines() if len(line.split(" ", 1)[1]) >= 72]
    assert not long, f"subjects of 72 characters or more: {long}"


# ---- the table of rooms

def includes():
    """How many files outside its room include each header: {header: files}."""
    users = defaultdict(set)
    for path in sources():
        for line in re.findall(r'^#include "([^"]+)"', path.read_text(encoding="utf-8"), re.MULTILINE):
            if (SRC / line).exists() and room_of(SRC / line) != room_of(path):
                users[line].add(path)
    return {header: len(files) for header, files in users.items()}


def table_of_rooms():
    """Of each room its files, lines, the rooms it calls with the number of functions and data it takes there, and its headers."""
    arrows = defaultdict(lambda: defaultdict(set))
    for name, others in calls().items():
        for other, symbols in others.items():
            if room_of(SRC / name) != room_of(SRC / other):
                arrows[room_of(SRC / name)][room_of(SRC / other)].update(symbols)
    counts = includes()
    lines = [f"{'room':22} {'files':>5} {'lines':>6}  calls (names taken) | headers (files outside that include them)"]
    for room in reversed(ROOMS):
        files = [path for path in sources() if room_of(path) == room]
        length = sum(len(path.read_text(encoding="utf-8").splitlines()) for path in files)
        takes = ", ".join(f"{other} {len(names)}" for other, names in sorted(arrows[room].items(), key=lambda pair: -len(pair[1])))
        headers = ", ".join(f"{name} {counts.get(f'{room}/{name}', 0)}" for name in ROOMS[room])
        lines.append(f"{room or 'main.c':22} {len(files):5} {length:6}  {takes} | {headers}")
    total = sum(len(path.read_text(encoding="utf-8").splitlines()) for path in sources())
    return "\n".join([*lines, f"{'all':22} {len(sources()):5} {total:6}"])


if __name__ == "__main__":
    if sys.argv[1:] == ["--table"]:
        print(table_of_rooms())
    elif sys.argv[1:] == ["--files"]:
        PAGE.write_text(page_of_files(), encoding="utf-8")
    else:
        sys.exit(__doc__)
