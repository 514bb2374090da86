"""Tables of the terminal."""

import re
import sys

import pytest
from quoin_tools.base import terminal

HEADER = ["stage", "joint", "N kN", "T kN", "sigma start MPa", "at m", "factor peak, c on closed"]
ROWS = [("full", "base", "6696.2", "4191.6", "-0.541", "(24.85, 0.00)", "2.309"), ("earthquake", "seam", "8934.6", "-", "0.000", "-", "-")]


def cells(lines, header=HEADER):
    """{(row, heading): cell}, read by where the rules below the headings are."""
    found = {}
    for i, line in enumerate(lines):
        if set(line.strip()) == {"-", " "}:
            at = [(m.start(), m.end()) for m in re.finditer("-+", line)]
            headings = [lines[i - 1].ljust(200)[a:b].strip() for a, b in at]
            for n, row in enumerate(lines[i + 1 : i + 1 + len(ROWS)]):
                found |= {(n, heading): row.ljust(200)[a:b].strip() for heading, (a, b) in zip(headings, at)}
    return found


def test_a_wide_table_goes_on_below_itself():
    """In parts that fit, each with the names of its rows; no cell is lost, and there is room for as many columns as fit."""
    whole, parts = terminal.table(HEADER, ROWS), terminal.table(HEADER, ROWS, width=60)
    assert max(map(len, whole)) > 80 and len(whole) == 4
    assert max(map(len, parts)) <= 60 and [line.split()[:2] for line in parts if line.startswith("  stage")] == [["stage", "joint"]] * 2
    wanted = {(n, heading): cell for n, row in enumerate(ROWS) for heading, cell in zip(HEADER, row)}
    assert cells(whole) == cells(parts) == wanted
    assert terminal.table(HEADER, ROWS, width=len(whole[1])) == whole


@pytest.mark.parametrize("width", [1, 20])
def test_what_cannot_fit_is_there_all_the_same(width):
    assert cells(terminal.table(HEADER, ROWS, width=width)) == cells(terminal.table(HEADER, ROWS))


def test_only_a_terminal_has_an_end(monkeypatch):
    assert terminal.room() == float("inf")
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    monkeypatch.setenv("COLUMNS", "80")
    assert terminal.room() == 80


def test_what_is_being_done_is_said_and_wiped(monkeypatch, capsys):
    """The outer work is shown again behind an inner one, and nothing is left, also after an error."""
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    with pytest.raises(ZeroDivisionError), terminal.doing("draws the run"):
        with terminal.doing("draws mesh.png"):
            pass
        raise ZeroDivisionError
    wipe = terminal.WIPE
    assert capsys.readouterr().err == f"{wipe}draws the run{wipe}draws mesh.png{wipe}draws the run{wipe}"


def test_a_file_is_told_nothing(capsys):
    with terminal.doing("draws the run"):
        pass
    assert capsys.readouterr().err == ""


def test_tables_without_rows_or_words():
    assert terminal.table(["a", "b"], []) == ["  a  b", "  -  -"]
    assert terminal.table(["a"], [["x"]], width=80) == ["  a", "  -", "  x"]
