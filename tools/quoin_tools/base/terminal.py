"""Prints tables in the terminal, and the progress of a long command."""

import contextlib
import shutil
import sys

NARROW = 40  # columns that a terminal has at least
WIPE = "\r\x1b[K"
works: list[str] = []  # tasks under way, the innermost last


@contextlib.contextmanager
def doing(work):
    """Shows on a terminal what is under way, in a line of stderr that is wiped at its end."""
    works.append(work)
    try:
        show_work()
        yield
    finally:
        works.pop()
        show_work()


def show_work():
    if sys.stderr.isatty():
        print(WIPE + (works[-1][: shutil.get_terminal_size().columns - 1] if works else ""), end="", file=sys.stderr, flush=True)


def table(header, rows, width=None):
    """Lines of text: words to the left, numbers to the right. In a terminal (or `width` columns) a table that is too wide goes on below itself, with the names of
    its rows again: a terminal would break each of its lines."""
    blocks = parts([column_lines(column) for column in zip(header, *[[str(cell) for cell in row] for row in rows])], width or room())
    return [line for block in blocks for line in (["", *block] if block is not blocks[0] else block)]


def column_lines(column):
    """Returns (the lines of a column, all of one width; whether it holds numbers)."""
    width = max(map(len, column))
    is_number = all(cell[-1:].isdigit() or cell in ("-", "nan", "inf") for cell in column[1:])
    lines = [cell.rjust(width) if is_number else cell.ljust(width) for cell in column]
    return [lines[0], "-" * width, *lines[1:]], is_number


def parts(columns, width):
    """Returns the lines of each part of a table; the leading columns of words, which name a row, stand in all parts."""
    names = 0
    while names < len(columns) - 1 and not columns[names][1]:
        names += 1
    lines = [lines for lines, _ in columns]
    taken = sum(2 + len(column[0]) for column in lines[:names])
    found, used = [[]], taken
    for column in lines[names:]:
        if found[-1] and used + 2 + len(column[0]) > width:
            found.append([])
            used = taken
        found[-1].append(column)
        used += 2 + len(column[0])
    return [["  " + "  ".join(line).rstrip() for line in zip(*lines[:names], *part)] for part in found]


def room():
    """Returns the columns of the terminal; infinite in a file or a pipe."""
    return max(NARROW, shutil.get_terminal_size().columns) if sys.stdout.isatty() else float("inf")
