"""Shows the numbers of the sheet in other units than SI: texts of messages, columns of tables, axes of pictures. Results, scene and computation stay SI.

    with shown("us"):
        _("crack {0:.2f} m", 4.0)                  "crack 13.12 ft"
        column("N [kN]")                           ('N [kip]', how its numbers are converted)

One table has each unit that the sheet writes. A number behind which a text has a unit is in that unit, also where others stand between: from {0} to {1} m.
"""

import contextlib
import functools
import math
import re
import string
from dataclasses import dataclass

from quoin_tools.base import language
from quoin_tools.base.figures import Figure

SI = "si"
FOOT, POUND = 0.3048, 4.4482216152605  # m, N
PSI = POUND / (FOOT / 12) ** 2  # Pa
SYSTEMS: dict = {  # unit of the sheet: (unit shown, its size in the unit of the sheet)
    SI: {},
    "us": {
        "m": ("ft", FOOT), "mm": ("in", 25.4), "m²": ("ft²", FOOT**2), "m2": ("ft2", FOOT**2), "m/s": ("ft/s", FOOT), "m/s²": ("ft/s²", FOOT), "m/s$^2$": ("ft/s$^2$", FOOT), "m²/s": ("ft²/s", FOOT**2),
        "m of water": ("ft of water", FOOT), "m de água": ("ft de água", FOOT), "m d'eau": ("ft d'eau", FOOT), "N": ("lbf", POUND), "kN": ("kip", POUND), "MN": ("kip", POUND / 1e3),
        "kN m": ("kip ft", POUND * FOOT), "N/m": ("lbf/ft", POUND / FOOT), "kN/m": ("kip/ft", POUND / FOOT), "Pa": ("psi", PSI), "kPa": ("psi", PSI / 1e3), "MPa": ("psi", PSI / 1e6), "GPa": ("ksi", PSI / 1e6),
        "GPa/m": ("pci", PSI / (FOOT / 12) / 1e9), "kg/m³": ("pcf", POUND / 9.80665 / FOOT**3), "t": ("kip", POUND / 9.80665), "J": ("ft lbf", POUND * FOOT), "K": ("°F", 1 / 1.8), "10⁻⁶/K": ("10⁻⁶/°F", 1.8),
    },
}  # fmt: skip
BRACKET = re.compile(r"\[([^\[\]]+)\]")
WORD = r"(?:to|and|or|of|a|e|à|et|ou|de|para|sur)"
BETWEEN = re.compile(rf"\)? {WORD} \(?|[,;] | \(")  # between two numbers of one unit, the comma within brackets alone
HALF = 0.2  # of a power of ten: a number may lose as much of its precision as it is printed
LEAST = 6  # digits behind the point, at most, that a short number gets

current = SI  # of SYSTEMS, while a sheet is written


@contextlib.contextmanager
def shown(name):
    """Numbers are shown in these units inside."""
    global current  # noqa: PLW0603
    current, language.other_units = name, None if name == SI else filled
    try:
        yield
    finally:
        current, language.other_units = SI, None


@dataclass
class Unit:
    """name: as it is shown; size: of it, in the unit of the sheet."""

    name: str
    size: float

    def digits(self, digits):
        """Returns the digits behind the point that keep the precision of a number that has `digits` in the unit of the sheet."""
        return max(0, digits + math.ceil(math.log10(self.size) - HALF))


def of(name):
    """Returns the Unit that takes the place of one of the sheet; None: it stays."""
    return Unit(*SYSTEMS[current][name]) if name in SYSTEMS[current] else None


def said(text, name):
    """Returns a text that is a number in a unit of the sheet as a number in the unit shown, with its unit."""
    unit = of(name)
    return f"{text} {name}" if unit is None else f"{changed(text, unit)} {unit.name}"


def spelled():
    """Returns a pattern of a number as the language of the sheet writes it."""
    point = re.escape(language.current.decimal if language.current else ".")
    return re.compile(rf"[+\-−]?\d[\d\u202f]*(?:{point}\d+)?(?:e[+\-]?\d+)?")


def changed(text, unit):
    """Returns a text with each of its numbers in another unit."""
    decimal = language.current.decimal if language.current else "."

    def one(found):
        word = found[0].replace("\u202f", "").replace("−", "-").replace(decimal, ".")
        mantissa, power, _exponent = word.partition("e")
        value = text.value if isinstance(text, Figure) and found[0] == text else float(word)
        sign, digits = "+" if word.startswith("+") else "", unit.digits(len(mantissa.partition(".")[2]))
        if value and not isinstance(text, Figure):  # a short number keeps two figures
            digits = max(digits, min(LEAST, 1 - math.floor(math.log10(abs(value) / unit.size))))
        if power:
            text_of = f"{value / unit.size:{sign}.{max(0, len(mantissa.lstrip('+-').replace('.', '')) - 1)}e}"
        else:
            text_of = f"{round(value / unit.size, digits) + 0.0:{sign}.{digits}f}"
        new = language.numeral(text_of)
        return new.replace("-", "−") if "−" in found[0] else new

    new = spelled().sub(one, text)
    return Figure(new, text.value / unit.size) if isinstance(text, Figure) else new


@functools.cache
def units_of(message, system):
    """Returns {hole: unit of the sheet} of a message."""
    pieces, found = list(string.Formatter().parse(message)), {}
    for k, (_literal, name, _form, _conversion) in enumerate(pieces):
        at = k
        while name is not None and at + 1 < len(pieces):
            behind, further = pieces[at + 1][:2]
            if unit := unit_at(behind, system):
                found[name] = unit
                break
            in_brackets = pieces[at][0].endswith("(") or not behind.startswith((",", ";"))
            if further is None or not in_brackets or not BETWEEN.fullmatch(behind):
                break
            at += 1
    return found


def unit_at(text, system):
    """Returns the unit with which a text begins, behind a blank or a bracket."""
    names = [name for name in SYSTEMS[system] if re.match(rf"\)? {re.escape(name)}(?![\w²/])", text) and "water" not in name]
    return max(names, key=len, default=None)


def filled(text, message, values):
    """Fills the holes of a text, the translation of a message, with values, numbers with a unit in the unit shown."""
    units, result, behind, field = units_of(message, current), "", None, language.Holes().format_field
    for literal, name, form, _conversion in string.Formatter().parse(text):
        if behind and unit_at(literal, current):
            literal = literal.replace(behind, of(behind).name, 1)
        result, behind = result + literal, None
        if name is None:
            continue
        value, behind = values[int(name)], units.get(name)
        if behind and isinstance(value, (int, float)) and not isinstance(value, bool):
            unit = of(behind)
            result += field(value / unit.size, re.sub(r"\.(\d+)f", lambda found, unit=unit: f".{unit.digits(int(found[1]))}f", form))
        elif behind and is_numbers(value):
            result += changed(value, of(behind))
        else:
            result += field(value, form)
    return result


def is_numbers(text):
    """Tells whether a text has numbers and no words."""
    return isinstance(text, str) and any(map(str.isdigit, text)) and not re.search(r"[^\W\de_]|×", text)


def column(title):
    """Returns (title of a column or an axis with the unit shown, its Unit); (title, None): it has no unit that changes."""
    found = BRACKET.search(str(title))
    unit = of(found[1]) if found else None
    return (title, None) if unit is None else (title.replace(found[0], f"[{unit.name}]"), unit)


def cell(value, unit):
    """Returns a cell of a column in the unit shown: all numbers of a text that has no words."""
    text = value[0] if isinstance(value, tuple) else value
    text = str(text) if isinstance(text, (int, float)) and not isinstance(text, bool) else text
    text = changed(text, unit) if is_numbers(text) else text
    return (text, *value[1:]) if isinstance(value, tuple) else text


def number(text, name):
    """Returns a text that is a number in a unit of the sheet as the number in the unit shown, without it."""
    unit = of(name)
    return text if unit is None else cell(text, unit)


def in_unit(name, *texts):
    """Returns a unit of the sheet as it is shown, and texts that are numbers in it."""
    unit = of(name)
    return (name, *texts) if unit is None else (unit.name, *(cell(text, unit) for text in texts))


def table(header, rows):
    """Returns header and rows of a table in the units shown. A column has the unit of its title; else a cell that of a text in brackets before it in its row."""
    if current == SI:
        return header, rows
    columns = [column(title) for title in header]
    plain = [not BRACKET.search(str(title)) for title, _ in columns]
    shown_rows = []
    for row in rows:
        cells, own = [], None
        for k, value in enumerate(row):
            title, unit = column(value) if isinstance(value, str) else (value, None)
            if unit is not None:
                own, value = unit, title
            elif k < len(columns):
                unit = columns[k][1] or (own if plain[k] else None)
                value = value if unit is None else cell(value, unit)
            cells.append(value)
        shown_rows.append(cells)
    return [title for title, _ in columns], shown_rows
