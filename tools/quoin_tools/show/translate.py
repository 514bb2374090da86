"""Translates the sheet and its pictures from English to another language, by a catalogue of messages (locale/LANGUAGE/LC_MESSAGES/quoin.po).

    with translate.spoken("pt", names): text = translate.of_page(html)         and translate.of_figure(figure) of each picture

A sheet is made in English; its texts are translated as they are written: between the tags of the page, and in pictures. A text is searched
in the catalogue as a whole, then as a pattern ({0}, {1} stand for the parts that differ), then sentence by sentence and piece by piece. Names that
the user has given stay, as do keys of scenes that are no messages. A text that the catalogue lacks stays English, and the command counts it.
Numbers are written as the catalogue writes NUMERAL; not in names, options, files and versions.
"""

import ast
import contextlib
import functools
import html
import os
import re

from matplotlib.text import Text

from quoin_tools.base import language

FOLDER = language.FOLDER
MESSAGE = re.compile(r'^msgid ((?:".*"\n)+)msgstr ((?:".*"\n?)+)', re.MULTILINE)
HOLE = re.compile(r"\{(\d)(?::[^{}]*)?\}")  # a format in it is for what language.py says
ENGLISH = "en"
NUMERAL = "12345.6"  # a message: how a language writes numbers
NUMBER = r"(?<![^\W\d][-/])(?<![\w.#])[+\-\u2212]?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?!\w|\.\w)"  # none within a word, a version, the name of a file
LIST = re.compile(rf"{NUMBER}(?:, {NUMBER})+")
OPTION = r"--[\w-]+(?:[ =][^\s;)]+)?"  # with its value
FORMULA = r"\mathdefault"  # powers of ten along an axis
LONGEST = 7  # figures that are grouped: longer rows of them are checksums
KEYS = re.compile(r'<td class="[^"]*\bkeys\b')  # cells with words of the scene
WORDS = re.compile(r'<td class="[^"]*\bword\b')  # cells with a word of the sheet, though a name of the user's may be the same
SENTENCES = r"(?<=\.)\s+(?=[A-Z“\d])"
SPECIFIC = 12  # letters that a pattern has besides its holes, to be tried on more than a sentence
PIECES = (r";\s+", r",\s+", r":\s+", r"\s+\((?=.*\)$)", r"^\(|\)$", r"\s+×\s+")  # where a text that is no message is cut
# units, symbols, and words that are the same everywhere
SAME = frozenset(["kN", "kPa", "MPa", "GPa", "Pa", "mm", "min", "Hz", "kJ", "kg", "deg", "rad", "mK", "UTC", "Quoin", "YAML", "CRC", "SHA", "npb", "usbr", "usace", "ferc", "cadam", "Newmark", "Arias", "PGA", "PGV", "PGD", "EM", "FERC", "Portaria", "NPB", "Bretas", "Lemos", "Lourenco", "Small", "Dams", "yaml", "txt", "quoin_tools", "CRC-32", "SHA-256", "Mohr", "Coulomb", "Lysmer", "Rayleigh", "cm", "nkx", "cos", "sin", "tan", "atan", "rot", "log"])


class Words:
    """texts of one language; missing: what it does not have of what it was asked."""

    def __init__(self, language, names=(), keys=()):
        self.keys = frozenset(keys) | SAME
        self.language, rows = language, read(language)
        self.names, self.missing = frozenset(names), []
        self.whole = {english: other for english, other in rows.items() if not HOLE.search(english)}
        patterned = sorted((english for english in rows if HOLE.search(english)), key=lambda text: -len(HOLE.sub("", text)))
        self.specific, self.general = ([(english, pattern_of(english), rows[english]) for english in patterned if (len(HOLE.sub("", english)) >= SPECIFIC) == which] for which in (True, False))
        self.known = {}
        self.between, self.decimal = re.fullmatch("12(.*)345(.)6", rows.get(NUMERAL, NUMERAL)).groups()
        self.kept = re.compile("|".join([OPTION, *(rf"(?<!\w){re.escape(name)}(?!\w)" for name in sorted(self.names, key=len, reverse=True) if re.search(r"[^\W\d]", name) and re.search(r"\d\.\d|\d{5}", name))]))

    def __call__(self, text):
        """The text in this language, with the blanks round it as they are. What language.py has said stays."""
        if language.OPEN in text:
            return "".join(language.bare(part) if part.startswith(language.OPEN) else self(part) for part in language.SAID.split(text) if part)
        return text if text.strip() in self.names else self.numbered(self.spoken(text))

    def numbered(self, text):
        """The text with its numbers as the language writes them; names and options stay."""
        parts, end = [], 0
        for kept in [*self.kept.finditer(text), None]:
            start = kept.start() if kept else len(text)
            listed = LIST.sub(lambda found: found[0].replace(", ", "; ") if "." in found[0] and self.decimal == "," else found[0], text[end:start])
            parts.append(re.sub(NUMBER, lambda found: self.number(found[0]), listed) + (kept[0] if kept else ""))
            end = kept.end() if kept else end
        return language.bare("".join(parts))

    def number(self, text):
        whole, point, rest = text.partition(".")
        figures = whole.lstrip("+-\u2212")
        if 5 <= len(figures) <= LONGEST and figures.isdecimal():
            whole = whole[: len(whole) - len(figures)] + f"{int(figures):,}".replace(",", self.between) if figures[0] != "0" else whole
        return whole + (self.decimal if point else "") + rest

    def spoken(self, text):
        inner = text.strip()
        return text.replace(inner, self.inner(inner), 1) if inner else text

    def inner(self, text):
        if text not in self.known:
            self.known[text] = self.found(text)
        return self.known[text]

    def found(self, text):
        if text in self.names or is_plain(text):
            return text
        if text in self.whole:
            return self.whole[text]
        if text[-1] in ".,:" and text[:-1] in self.whole:
            return self.whole[text[:-1]] + text[-1]
        for sign in (": ", "  "):
            head, found, rest = text.partition(sign)
            if found and head in self.names:
                return head + found + self.spoken(rest)
        return self.matched(text, self.specific) or self.cut(text, SENTENCES) or self.cut(text, r"\n") or self.headed(text) or self.matched(text, self.general) or self.in_pieces(text)

    def headed(self, text):
        """Head: rest."""
        head, colon, rest = text.partition(": ")
        return f"{self.spoken(head)}: {self.spoken(rest)}" if colon and not re.search("[;(]", head) else None

    def matched(self, text, patterns):
        for english, pattern, other in patterns:
            match = pattern.fullmatch(text)
            if match and not any(is_too_much(part, english, patterns is self.general) for part in match.groups()):
                parts = match.groupdict()
                return HOLE.sub(lambda hole, parts=parts: self.spoken(parts["h" + hole[1]]), other)
        return None

    def cut(self, text, where):
        """The pieces, each in this language; None where there is nothing to cut."""
        parts = re.split(f"({where})", text)
        return "".join(self.spoken(part) if k % 2 == 0 else part for k, part in enumerate(parts)) if len(parts) > 1 else None

    def in_pieces(self, text):
        for where in PIECES:
            if found := self.cut(text, where):
                return found
        if text not in self.missing and not self.is_named(text):
            self.missing.append(text)
        return text

    def is_named(self, text):
        """Tells whether all words of a text are names, units or keys."""
        return all(word in self.names or word in self.keys or is_plain(word) for word in re.split(r"[\s,;:()/+]+", text))


def is_too_much(part, english, general):
    """Whether a hole has taken more than its pattern is about: other sentences; of a pattern of few letters other pieces."""
    return bool(re.search(SENTENCES, part) and not re.search(SENTENCES, HOLE.sub("A", english))) or (general and "(" not in english and bool(re.search("[;,] ", part)))


def is_plain(text):
    """Numbers, signs, single letters, hashes, keys of a scene: no words."""
    return all(not re.search(r"[A-Za-zÀ-ÿ]{2}", word) or word in SAME or "_" in word or re.fullmatch(r"[0-9a-f]{8,}|[\d.+-]+e[+-]?\d+|--.*|[\w-]+\.(json|yaml|h5|dxf|csv|py)", word)
               for word in re.split(r"[\s,;:()\[\]/+·≤≥<>=]+", text))  # fmt: skip


def pattern_of(english):
    """A regular expression of a text with holes; each hole takes as little as it can."""
    parts, seen = HOLE.split(english), set()
    for k in range(1, len(parts), 2):
        hole = parts[k]
        parts[k] = f"(?P=h{hole})" if hole in seen else f"(?P<h{hole}>.*?)"
        seen.add(hole)
    return re.compile("".join(part if k % 2 else re.escape(part) for k, part in enumerate(parts)), re.DOTALL)


@functools.cache
def read(language):
    """Returns the catalogue of a language: English text to its text, without what has no translation or a doubtful one (fuzzy)."""
    with open(os.path.join(FOLDER, language, "LC_MESSAGES", "quoin.po"), encoding="utf-8") as file:
        entries = [MESSAGE.search(entry) for entry in file.read().split("\n\n") if not re.search("^#,.*fuzzy", entry, re.MULTILINE)]
    rows = (["".join(map(ast.literal_eval, quoted.splitlines())) for quoted in entry.groups()] for entry in entries if entry)
    return {english: other for english, other in rows if english and other}


def languages():
    return [ENGLISH, *sorted(os.listdir(FOLDER))]


current: Words | None = None  # while a sheet is written; None: English


@contextlib.contextmanager
def spoken(name, names=(), keys=()):
    """Sheets and pictures speak this language inside."""
    global current  # noqa: PLW0603
    with language.spoken(name) as said:
        current = None if said is None else Words(name, names, keys)
        if said is not None:
            said.missing = current.missing  # one list
        try:
            yield current
        finally:
            current = None


def translated(text):
    return current(text) if current else text


def of_figure(figure):
    """A picture in the language that is spoken."""
    if current:
        for text in figure.findobj(Text):
            if language.OPEN in text.get_text() or (text.get_text() and FORMULA not in text.get_text()):
                text.set_text(current(text.get_text()))


def of_page(page):
    """A page in the language that is spoken: texts between tags and descriptions of pictures; styles stay."""
    if not current:
        return page
    parts = re.split(r"(<style\b.*?</style>|<[^>]*>)", page, flags=re.DOTALL)
    for k, part in enumerate(parts):
        if k % 2 == 0 and k and WORDS.search(parts[k - 1]) and language.OPEN not in part:
            head, sign, rest = html.unescape(part).partition(": ")
            parts[k] = html.escape(current.whole.get(head, head) + sign + (current(rest) if rest else ""), quote=True)
        elif k % 2 == 0 and not KEYS.search(parts[k - 1] if k else ""):
            parts[k] = html.escape(current(html.unescape(part)), quote=True)
        elif part.startswith("<img "):
            parts[k] = re.sub(r'alt="([^"]*)"', lambda found: f'alt="{html.escape(current(html.unescape(found[1])), quote=True)}"', part)
    return language.bare("".join(parts))
