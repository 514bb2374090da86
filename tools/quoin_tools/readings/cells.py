"""Reads the cells of a table of readings, CSV or XLSX, as dates and numbers. Lines are those of the file, from 1; rows of a sheet likewise."""

import csv
import datetime
import math
import os
import re

from quoin_tools.base.scene import text_of
from quoin_tools.readings.sensors import ReadingsError

SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t"}
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?\Z", re.ASCII)
COMMA = re.compile(r"[+-]?\d+,\d+\Z", re.ASCII)
POINT = re.compile(r"[+-]?\d*\.\d+\Z", re.ASCII)
ISO = re.compile(r"\d{4}-\d\d-\d\d([ T]\d\d:\d\d(:\d\d(\.\d+)?)?( ?(Z|[+-]\d\d:?\d\d))?)?\Z", re.ASCII)
DAY_FIRST = re.compile(r"(\d{1,2})([./-])(\d{1,2})\2(\d{4})(?:[ T]+(\d{1,2}):(\d\d)(?::(\d\d))?)?\Z", re.ASCII)
EXPECTED = {"iso": "an ISO date such as 2024-03-31 or 2024-03-31 08:30", "day first": "a date such as 31/03/2024, day first", "excel": "a serial number of Excel such as 45382 for 2024-03-31"}
EARLIEST = datetime.datetime(1800, 1, 1)  # no instrument of a dam was read before
EPOCH = datetime.datetime(1899, 12, 30)  # day 0 of Excel, as its dates from 1900-03-01 on are counted
MOST = 1e15  # no reading is as large, in any unit
SERIALS = (61, 73051)  # 1900-03-01 and 2100-01-01


def rows_of(plan):
    """Returns (names of the columns, [(line, cells)], day 0 of its serial dates): empty rows are left out, cells are text, or as a sheet has them."""
    found, epoch = sheet_rows(plan) if os.path.splitext(plan.file)[1].lower() in (".xlsx", ".xlsm") else (text_rows(plan), EPOCH)
    head = next((cells for line, cells in found if line == plan.header), None)
    if head is None:
        raise ReadingsError(f"{plan.file}: line {plan.header}: empty; expected the names of the columns")
    names = [str(cell).strip() if cell is not None else "" for cell in head]
    while names and not names[-1]:
        names.pop()
    rows = [(line, cells) for line, cells in found if line > plan.header]
    for line, cells in rows:
        more = [cell for cell in cells[len(names):] if cell not in ("", None)]
        if more:
            raise ReadingsError(f"{plan.file}: line {line}: '{more[0]}' stands behind the last of {len(names)} columns: expected one cell a column, and no decimal commas unless `decimal: comma` says so")
    if not rows:
        raise ReadingsError(f"{plan.file}: no readings below line {plan.header}: expected a row for each date")
    twice = next((name for name in names if name and names.count(name) > 1), None)
    if twice:
        raise ReadingsError(f"{plan.file}: line {plan.header}: column '{twice}' stands there twice: expected different names")
    return names, rows, epoch


def text_rows(plan):
    try:
        text = text_of(plan.file).removeprefix("\ufeff")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise ReadingsError(f"{plan.file}: line {line}: byte {error.object[error.start]:#x}: expected a text in UTF-8") from error
    lines = text.splitlines()
    head = lines[plan.header - 1] if len(lines) >= plan.header else ""
    mark = SEPARATORS.get(plan.separator) or max(SEPARATORS.values(), key=lambda one: (head.count(one), one == ","))
    reader = csv.reader(lines, delimiter=mark, strict=True)
    rows, begun = [], 1
    try:
        for cells in reader:
            cells = [cell.strip() for cell in cells]
            if any(cells):
                rows.append((begun, cells))
            begun = reader.line_num + 1
    except csv.Error as error:
        raise ReadingsError(f"{plan.file}: line {reader.line_num}: {error}") from error
    return rows


def sheet_rows(plan):
    import openpyxl

    try:
        book = openpyxl.load_workbook(plan.file, read_only=True, data_only=True)
    except OSError:
        raise
    except Exception as error:  # whatever is wrong in a file that is no workbook
        raise ReadingsError(f"{plan.file}: {' '.join(str(error).split())}: expected a workbook (XLSX)") from error
    if plan.sheet and plan.sheet not in book.sheetnames:
        raise ReadingsError(f"{plan.file}: no sheet '{plan.sheet}', there are: {', '.join(book.sheetnames)}")
    sheet = book[plan.sheet] if plan.sheet else book.worksheets[0]
    rows = [(line, [cell.strip() if isinstance(cell, str) else cell for cell in cells]) for line, cells in enumerate(sheet.iter_rows(values_only=True), 1)]
    book.close()
    return [(line, cells) for line, cells in rows if any(cell not in ("", None) for cell in cells)], book.epoch


# ---- dates -----------------------------------------------------------------------------------------------------

def date_of(cell, kind, epoch=EPOCH):
    """Returns the time of a cell, with its zone where it has one; None where it is no date of this format."""
    if isinstance(cell, datetime.datetime):
        return cell
    if isinstance(cell, datetime.date):
        return datetime.datetime(cell.year, cell.month, cell.day)
    try:
        if kind == "excel":
            days = float(cell)
            return epoch + datetime.timedelta(seconds=round(days * 86400)) if SERIALS[0] <= days < SERIALS[1] else None
        if kind == "iso":
            return datetime.datetime.fromisoformat(cell.replace(" Z", "Z").replace(" +", "+").replace(" -", "-")) if ISO.match(cell) else None
        day, _, month, year, *clock = DAY_FIRST.match(cell).groups()
        return datetime.datetime(int(year), int(month), int(day), *(int(part or 0) for part in clock))
    except (AttributeError, TypeError, ValueError):
        return None


def dates_of(plan, column, rows, epoch=EPOCH):
    """Returns the times of all rows, without zone, and the offsets from UTC [h] that were written. Times with a zone become UTC."""
    times, offsets, latest = [], set(), datetime.datetime.now() + datetime.timedelta(days=1)  # noqa: DTZ005 (of any zone)
    for line, cells in rows:
        cell = cells[column] if column < len(cells) else None
        found = date_of(cell, plan.date_format, epoch)
        if found is None:
            raise ReadingsError(f"{plan.file}: line {line}, column {plan.date_column}: '{'' if cell is None else cell}': expected {EXPECTED[plan.date_format]}")
        if not EARLIEST <= found.replace(tzinfo=None) <= latest:
            raise ReadingsError(f"{plan.file}: line {line}, column {plan.date_column}: '{cell}' is {found:%Y-%m-%d}: expected a date from {EARLIEST:%Y} to today, {latest - datetime.timedelta(days=1):%Y-%m-%d}")
        zone = found.utcoffset()
        here = None if zone is None else zone.total_seconds() / 3600
        if offsets and (here is None) != (None in offsets):
            raise ReadingsError(f"{plan.file}: line {line}, column {plan.date_column}: '{cell}': expected a time zone in all lines or in none")
        offsets.add(here)
        zones = sorted(one for one in offsets if one is not None)
        if zones and zones[-1] - zones[0] > 1:  # summer time is one hour
            raise ReadingsError(f"{plan.file}: line {line}, column {plan.date_column}: '{cell}': time zones of {zones[0]:+g} h and {zones[-1]:+g} h are mixed: expected one, with its summer time")
        times.append(found if zone is None else (found - zone).replace(tzinfo=None))
    return times, sorted(one for one in offsets if one is not None)


# ---- numbers ---------------------------------------------------------------------------------------------------

def number_of(cell, decimal):
    """Returns the finite number of a cell; None of an empty one; NaN of anything else. Raises ValueError where its decimal sign is the other one."""
    if cell is None or cell == "":
        return None
    if isinstance(cell, (int, float)) and not isinstance(cell, bool):
        return float(cell) if abs(cell) < MOST else math.nan
    text = str(cell).replace("\u2212", "-")  # the sign that typesetters write
    if (POINT if decimal == "comma" else COMMA).match(text):
        raise ValueError
    text = text.replace(",", ".") if COMMA.match(text) else text
    value = float(text) if NUMBER.match(text) else math.nan
    return value if abs(value) < MOST else math.nan


def column_of(plan, name, column, rows):
    """Returns (numbers as written, NaN where there is none; [(line, text)] of cells that are no numbers; how many cells are empty)."""
    values, odd, empty = [], [], 0
    for line, cells in rows:
        cell = cells[column] if column < len(cells) else None
        try:
            value = number_of(cell, plan.decimal)
        except ValueError:
            wanted = "a decimal comma, as `decimal: comma` says, and no points between thousands" if plan.decimal == "comma" else f"a decimal point, or `decimal: comma` in {plan.path}"
            raise ReadingsError(f"{plan.file}: line {line}, column {name}: '{cell}': expected {wanted}") from None
        if value is None:
            empty += 1
        elif math.isnan(value):
            odd.append((line, str(cell)))
        values.append(math.nan if value is None else value)
    meant = [(line, text) for line, text in odd if any(one.isdigit() for one in text)]
    if len(meant) > max(1, 0.5 * (len(rows) - empty - len(odd) + len(meant))):
        raise ReadingsError(f"{plan.file}: line {meant[0][0]}, column {name}: '{meant[0][1]}', and {len(meant) - 1} more such cells: expected numbers, with a decimal {plan.decimal} and nothing between thousands")
    return values, odd, empty
