"""Makes pieces of HTML for the sheet. Text from files is escaped."""

import base64
import html
import re

from quoin_tools.base import sheet_units
from quoin_tools.base.figures import Figure
from quoin_tools.base.language import ngettext, numeral

FULL = "data-full"  # attribute of a cell: its number in full, for the spreadsheet
LONG = 20  # letters of a word that may be broken within a cell
WIDE = 1.6  # a picture wider than so many heights takes the whole page


def esc(value):  # for text and for attributes
    return html.escape(str(value), quote=True)


def head(text, level=2):
    return f"<h{level}>{esc(text)}</h{level}>"


def small(*texts):
    """A paragraph in small letters; empty texts are left out."""
    return f"<p><small>{esc(' '.join(filter(None, texts)))}</small></p>"


def soft(text):
    return f"<p class='soft'>{esc(text)}</p>"


def box(kind, word, text):
    """A verdict: pass, fail or open."""
    return f'<div class="verdict {kind}"><b>{esc(word)}</b><br><span>{esc(text)}</span></div>'


def more_rows(number):
    return small(ngettext("{0} more row is in the annex.", "{0} more rows are in the annex.", number))


def table(header, rows, numeric=()):
    """Cells are escaped; a cell that is a pair is (text, class). numeric: columns to the right."""
    def of(tag, value, column):
        value, kind = value if isinstance(value, tuple) else (value, "")
        long = tag == "td" and any(len(word) > LONG for word in str(value).split())
        kinds = " ".join(filter(None, ("n" if column in numeric else "", kind, "long" if long else "")))
        full = f" {FULL}={chr(34)}{value.value!r}{chr(34)}" if isinstance(value, Figure) else ""
        return f"<{tag}{f' class={chr(34)}{kinds}{chr(34)}' if kinds else ''}{full}>{esc(numeral(str(value)) if isinstance(value, int) else value)}</{tag}>"

    header, rows = sheet_units.table(list(header), rows)
    head = "".join(of("th", value, i) for i, value in enumerate(header))
    body = "".join("<tr>" + "".join(of("td", value, i) for i, value in enumerate(row)) + "</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def without_full(page):
    """A page without the numbers in full."""
    return re.sub(rf' {FULL}="[^"]*"', "", page)


def notes(texts):
    return "".join(f'<p class="note">{esc(text)}</p>' for text in texts)


def picture(data, kind, caption, name=""):
    """name: class of the figure."""
    code = base64.b64encode(data).decode("ascii")
    text, kinds = esc(caption), f' class="{name}"' if name else ""
    return f'<figure{kinds}><img alt="{text}" src="data:image/{kind};base64,{code}"><figcaption>{text}</figcaption></figure>'


def is_wide(png):
    """Tells whether a picture is far wider than high, by the size at the head of a PNG."""
    width, height = int.from_bytes(png[16:20], "big"), int.from_bytes(png[20:24], "big")
    return width > WIDE * max(height, 1)


def file_picture(path, caption):
    with open(path, "rb") as file:
        data = file.read()
    return picture(data, "png", caption, "wide" if is_wide(data) else "")


def verdict_class(text):
    return "pass" if text.lower().startswith("pass") else "fail" if text.startswith("FAIL") else "open"
