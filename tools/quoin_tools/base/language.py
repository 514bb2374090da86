"""Says texts of sheets and pictures in the language of the sheet, by the catalogue of messages locale/LANGUAGE/LC_MESSAGES/quoin.po.

    _("Judged: {0}.", names)                            a message, and the values of its holes; a hole may have a format: {0:.2f}
    ngettext("joint {1}", "joints {1}", n, names)       one or the other message by the number n, which is hole 0
    numeral(f"{x:.3f}")                                 a number outside a message
    N_("uplift [kN]")                                   marks a message of a table; it is said where it is written: _(title)

Outside `spoken` the language is English: messages stay as they are in the code. A message that the catalogue lacks stays English and is counted.
"""

import contextlib
import functools
import gettext
import os
import re
import string

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "locale")
ENGLISH = "en"
NUMBER = re.compile(r"(\d+)(?:\.(\d+))?(?=e|\D*$)")  # of a text that is one number
LONGEST = 7  # figures that are grouped


class Language:
    """One language. missing: messages that its catalogue lacks of those it was asked for; between: what it writes between thousands; decimal: its decimal sign."""

    def __init__(self, name):
        self.name, self.catalogue, self.missing = name, read(name), []
        # Translators: how the language writes a number: what stands between thousands, and the decimal sign
        self.between, self.decimal = re.fullmatch("12(.*)345(.)6", self.text(N_("12345.6"))).groups()

    def text(self, message):
        entry = self.entry(message)
        return entry.string if entry else message

    def counted(self, one, many, number):
        entry = self.entry(one)
        return entry.string[gettext.c2py(self.catalogue.plural_expr)(number)] if entry else one if number == 1 else many

    def entry(self, message):
        """Returns the entry of a message; None: it has no translation, or a doubtful one."""
        entry = self.catalogue.get(message)
        if entry and not entry.fuzzy and all(entry.string if entry.pluralizable else (entry.string,)):
            return entry
        self.missing += [message] * (message not in self.missing)
        return None

    def numeral(self, text):
        return NUMBER.sub(lambda found: self.grouped(found[1]) + (self.decimal + found[2] if found[2] else ""), text, count=1)

    def grouped(self, figures):
        return f"{int(figures):,}".replace(",", self.between) if 5 <= len(figures) <= LONGEST and figures[0] != "0" else figures


@functools.cache
def read(name):
    """Returns the catalogue (babel) of a language."""
    from babel.messages.pofile import read_po

    with open(os.path.join(FOLDER, name, "LC_MESSAGES", "quoin.po"), encoding="utf-8") as file:
        return read_po(file, locale=name)


def languages():
    return [ENGLISH, *sorted(entry.name for entry in os.scandir(FOLDER) if entry.is_dir())]


current: Language | None = None  # while a sheet is written; None: English
other_units = None  # function of sheet_units that fills holes with numbers in other units; None: they stay


@contextlib.contextmanager
def spoken(name):
    """Messages and numbers are said in this language inside. Yields the Language; None: English."""
    global current  # noqa: PLW0603
    current = None if name == ENGLISH else Language(name)
    try:
        yield current
    finally:
        current = None


class Holes(string.Formatter):
    """Fills holes with values; numbers as the language writes them."""

    def format_field(self, value, form):
        text = format(value, form)
        return text if isinstance(value, str) else numeral(text)


def _(message, *values):
    text = current.text(message) if current else message
    return filled(text, message, values) if values else text


def filled(text, message, values):
    """Fills the holes of a text, the translation of a message."""
    return other_units(text, message, values) if other_units else Holes().format(text, *values)


def ngettext(one, many, number, *values):
    text = current.counted(one, many, number) if current else one if number == 1 else many
    return filled(text, many, (number, *values))


def N_(message):  # noqa: N802
    return message


def numeral(text):
    return current.numeral(text) if current else text
