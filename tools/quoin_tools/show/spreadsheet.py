"""Writes the tables of the sheet as a spreadsheet: a tab for each chapter, with the words and numbers of report.html; numbers in full, shown as there.

    quoin report FOLDER --xlsx ...    also FOLDER/report.xlsx
"""

import datetime
import io
import re
from html.parser import HTMLParser

from quoin_tools.base.figures import Figure
from quoin_tools.base.files import write_file
from quoin_tools.base.language import N_, _
from quoin_tools.show.hypertext import FULL

FIRST = N_("Sheet")  # tab of the text before the first chapter
LONGEST = 31  # letters of a tab's name
WIDEST = 60  # [letters] of a column
NUMBER = re.compile(r"[+\-\u2212]?\d[\d\u202f]*(\.\d+)?(e[+\-]?\d+)?")
POINT = "."
COLOURS = {"pass": "10692E", "fail": "A81919", "open": "8A5A00"}


class Chapters(HTMLParser):
    """chapters: [name, rows]; a row is a list of (text, kind): kind is "head", "title", "note", or the class of a cell."""

    def __init__(self):
        super().__init__()
        self.chapters, self.text, self.row, self.kind, self.begun, self.full = [[_(FIRST), []]], None, None, "", "", None

    def handle_starttag(self, tag, attributes):
        kinds, full = dict(attributes).get("class", "") or "", dict(attributes).get(FULL)
        if tag == "tr":
            self.row = []
        elif tag == "br":
            self.handle_data(" ")
        elif self.text is None and (tag in ("td", "th", "h1", "h2", "h3") or (tag in ("b", "p", "span") and self.row is None)):
            self.text, self.kind, self.begun, self.full = [], kinds, tag, full

    def handle_data(self, data):
        if self.text is not None:
            self.text.append(data)

    def handle_endtag(self, tag):
        if tag == "table":
            self.chapters[-1][1].append([])
        if tag == "tr" and self.row is not None:
            self.chapters[-1][1].append(self.row)
            self.row = None
        elif self.text is not None and tag == self.begun:
            words, self.text = " ".join("".join(self.text).split(" ")).strip(), None
            if tag in ("td", "th"):
                self.row.append((words if self.full is None else Figure(words, self.full), "head" if tag == "th" else self.kind))
            elif tag == "h2":
                self.chapters.append([words, []])
            elif words:
                self.chapters[-1][1].append([(words, "title" if tag in ("h1", "h3", "b") else "note")])


def chapters_of(page):
    parser = Chapters()
    parser.feed(re.sub(r"<(style|pre|svg)\b.*?</\1>", "", page, flags=re.S))
    return [(name, rows) for name, rows in parser.chapters if any(rows)]


def value_of(words, kind, decimal=POINT):
    """A number where the cell is one; decimal: how the page writes it."""
    if isinstance(words, Figure):
        return words.value
    text = words.replace(POINT, " ").replace(decimal, POINT) if decimal != POINT and "keys" not in kind.split() else words
    if NUMBER.fullmatch(text) and kind not in ("head", "title", "note"):
        return float(text.replace("\u202f", "").replace("\u2212", "-"))
    return words


def format_of(words, decimal=POINT):
    """Returns the format of a number: as many digits as the page shows."""
    digits = len(words.partition(decimal)[2])
    return "0" + ("." + "0" * digits if digits else "")


def tab_names(chapters):
    """Returns names of tabs: short, without characters that spreadsheets forbid, each once."""
    names = []
    for name, __ in chapters:
        short, number = re.sub(r"[\[\]:*?/\\]", " ", name)[:LONGEST], 2
        while short.lower() in (other.lower() for other in names):
            short, number = f"{short[: LONGEST - 4]} {number}", number + 1
        names.append(short)
    return names


def workbook(page, decimal=POINT):
    """Bytes of the file. Texts that begin with = stay texts."""
    from openpyxl import Workbook
    from openpyxl.cell.cell import ILLEGAL_CHARACTERS_RE
    from openpyxl.styles import Alignment, Font
    from openpyxl.utils import get_column_letter

    fonts = {"head": Font(bold=True), "title": Font(bold=True, size=13), "note": Font(italic=True, color="5B6570")} | {kind: Font(bold=True, color=colour) for kind, colour in COLOURS.items()}
    book, chapters = Workbook(), chapters_of(page)
    book.remove(book.active)
    for (__, rows), name in zip(chapters, tab_names(chapters)):
        tab, widths = book.create_sheet(name), {}
        for r, row in enumerate(rows, 1):
            for c, (words, kind) in enumerate(row, 1):
                cell = tab.cell(r, c)
                full = isinstance(words, Figure)
                cell.value = value_of(words if full else ILLEGAL_CHARACTERS_RE.sub(" ", words).strip(), kind, decimal)
                if full:
                    cell.number_format = format_of(words, decimal)
                if isinstance(cell.value, str):
                    cell.data_type = "s"
                cell.font = fonts.get(next((k for k in kind.split() if k in fonts), ""), Font())
                if kind not in ("title", "note"):
                    widths[c] = min(WIDEST, max(widths.get(c, 8), len(words) + 2))
                    cell.alignment = Alignment(wrap_text=len(words) + 2 > WIDEST, vertical="top")
        for column, width in widths.items():
            tab.column_dimensions[get_column_letter(column)].width = width
    book.properties.created = book.properties.modified = datetime.datetime(2000, 1, 1)
    data = io.BytesIO()
    book.save(data)
    return data.getvalue()


def write(path, page, decimal=POINT):
    write_file(path, workbook(page, decimal))
