"""Unit tests stand beside the files they test, and tests/coverage.md names what covers the others."""

import re
from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]
SRC = TESTS.parent / "src"
ROWS = re.findall(r"^\| `([\w/.]+)` \| (.+) \|$", (TESTS / "coverage.md").read_text(encoding="utf-8"), flags=re.M)
UNIT_TESTS = {path.relative_to(TESTS).as_posix() for path in TESTS.glob("unit/**/test_*.c")}
SOURCES = {path.relative_to(SRC).as_posix() for path in SRC.rglob("*.c")}
COVERED = [(file, by) for file, by in ROWS if not file.startswith("unit/")]


def own_test(file):
    room, _, name = f"unit/{file}".rpartition("/")
    return f"{room}/test_{name}"


def test_unit_tests_are_named_for_a_file_of_their_room():
    """A file test_<name>.c beside src/<room>/<name>.c or .h; those of no one file are in the table."""
    headers = {path.relative_to(SRC).with_suffix(".c").as_posix() for path in SRC.rglob("*.h")}
    strays = UNIT_TESTS - {own_test(file) for file in SOURCES | headers}
    assert strays == {file for file, _ in ROWS if file.startswith("unit/")}


def test_every_file_is_covered_once():
    """By a unit test of its own, or by a row."""
    without = {file for file in SOURCES if own_test(file) not in UNIT_TESTS}
    files = [file for file, _ in COVERED]
    assert sorted(files) == sorted(without), set(files) ^ without


def test_rows_name_what_is_there():
    for file, by in COVERED:
        named = re.findall(r"`([\w/]+/[\w.]+)`", by)
        assert named or by.startswith("every case"), file
        missing = [name for name in named if not (TESTS / name).is_file()]
        assert not missing, (file, missing)
