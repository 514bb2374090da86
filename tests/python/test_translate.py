"""The language of the sheet: the catalogue is whole and has nothing that nobody says, no English is left on a Portuguese sheet or in its pictures."""

import ast
import base64
import html
import os
import re
import string
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from babel.messages.extract import extract_from_file
from matplotlib import pyplot
from matplotlib.axis import Axis
from matplotlib.text import Text

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from quoin_tools.assess import combinations  # noqa: E402
from quoin_tools.base import language, shared  # noqa: E402
from quoin_tools.mesh import dam  # noqa: E402
from quoin_tools.show import matrix, report, style, translate, verify  # noqa: E402
from test_sheet import EXAMPLE, section, write  # noqa: E402

QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
HOUSE = ROOT / "tools/quoin_tools"
CATALOGUE = Path(translate.FOLDER) / "pt/LC_MESSAGES/quoin.po"
TOGETHER = "#. put together"  # before a message
POINT = re.compile(r"\d\.\d")
ENGLISH = re.compile(r"\b(the|and|with|from|which|stage|joint|joints|load|loads|water|crack|sliding|that|are|is|not|without|between|largest|least|force|of|at|by)\b", flags=re.IGNORECASE)


def test_the_catalogue_is_whole():
    """Each message stands once, has a translation with the same holes, and no English in it."""
    assert translate.languages() == ["en", "pt"]
    rows = translate.read("pt")
    assert len(rows) > 800
    text = CATALOGUE.read_text(encoding="utf-8")
    assert text.count("\nmsgid ") - text.count("\nmsgid_plural ") == len(rows) + 1, "a message twice, without a translation, or fuzzy"
    for english, other in rows.items():
        assert sorted(translate.HOLE.findall(english)) == sorted(translate.HOLE.findall(other)), english
        own = re.sub(r"«[^»]*»|US [\w ]+|--path|--uplift|\(\w+: \w+\)|quoin limit|f = |breaking_force", "", other)
        assert not ENGLISH.search(own), (english, other)


def test_what_is_not_translated_stays_out(tmp_path, monkeypatch):
    monkeypatch.setattr(translate, "FOLDER", tmp_path)
    path = tmp_path / "xx/LC_MESSAGES/quoin.po"
    path.parent.mkdir(parents=True)
    path.write_text('msgid ""\nmsgstr "Language: xx\\n"\n\n#, fuzzy\nmsgid "a"\nmsgstr "b"\n\nmsgid "c"\nmsgstr ""\n\n# of a line\nmsgid ""\n"d "\n"\\"e\\""\nmsgstr "f\\n"\n"g"\n', encoding="utf-8")
    assert translate.read("xx") == {'d "e"': "f\ng"}


def marked():
    """All messages of the tools, as xgettext would find them: a text, or (text for one, text for many)."""
    calls = {"_": None, "N_": None, "ngettext": (1, 2)}
    found = [message for path in HOUSE.rglob("*.py") for _, message, *_ in extract_from_file("python", path, keywords=calls)]
    return [message for message in found if message and any(message)]


def test_no_message_is_within_a_string():
    """The tools of gettext do not look into f-strings."""
    for path in HOUSE.rglob("*.py"):
        strings = [node for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.JoinedStr)]
        calls = [call for node in strings for call in ast.walk(node) if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id in ("_", "N_", "ngettext")]
        assert not [call for call in calls if isinstance(call.args[0], ast.Constant)], path


def holes(text):
    return {(name, form) for _, name, form, _ in string.Formatter().parse(text) if name}


@pytest.mark.parametrize("name", translate.languages()[1:])
def test_every_message_is_in_the_catalogue(name):
    """Each has a translation with the same holes in the same formats; of a plural form hole 0, the number, may be left out."""
    catalogue, lost, wrong = language.read(name), [], []
    for message in marked():
        one, *many = message if isinstance(message, tuple) else (message,)
        found = catalogue.get(one)
        texts = (found.string if many else [found.string]) if found and found.string and bool(many) == found.pluralizable else []
        lost += [message] * (not texts or not all(texts))
        wrong += [text for text in texts if (holes(text) ^ holes(many[0] if many else one)) - ({("0", form) for form in ("", ":")} if many else set())]
    assert not lost and not wrong


def test_every_text_of_a_guideline_is_in_the_catalogue():
    catalogue = language.read("pt")
    for guideline in yaml.safe_load((HOUSE / "assess/guidelines.yaml").read_text(encoding="utf-8"))["guidelines"].values():
        limits = [limit for limits in (guideline["conditions"] or {}).values() for limit in limits.values() if isinstance(limit, dict)]
        rows = guideline.get("combinations") or []
        for text in [*(guideline.get(key, "") for key in ("title", "note", "caution")), *(row[key] for row in [*limits, *rows] for key in ("source", "name", "loads") if key in row)]:
            assert not text or catalogue[text].string, text


@pytest.mark.parametrize("english, other", [
    ("Stage full. Forces of the slice; red arrows at bases: resultants by the gravity method; dashed: its crack.",
     "Etapa full. Forças da fatia; setas vermelhas nas bases: resultantes pelo método da gravidade; a tracejado: a respetiva fenda."),
    ("unbalanced ratio 7e-07 <= 1e-06, increment 3.42e-08 <= 1e-06", "razão de desequilíbrio 7e-07 <= 1e-06, incremento 3,42e-08 <= 1e-06"),
    (" pass, ≥ 2.00 ", " verifica, ≥ 2,00 "),
    ("water", "water"),  # a load is called so
    ("-12345.6", "-12\u202f345,6"),
    ("1234.5", "1234,5"),  # five figures are grouped
    ("12\u202f345", "12\u202f345"),
    ("(1.00, -2.00) m", "(1,00; -2,00) m"),
    ("3, 4, 5", "3, 4, 5"),
    ("1.2-1.4", "1,2-1,4"),
    ("Quoin 0.2.0", "Quoin 0.2.0"),
    ("model_1.5.h5", "model_1.5.h5"),
    ("12345678", "12345678"),  # a checksum
    ("flood_1.5", "flood_1.5"),
    ("flood_1.5: 1.5", "flood_1.5: 1,5"),
    ("--drain 4.72; 4.72", "--drain 4.72; 4,72"),
])  # fmt: skip
def test_texts(english, other):
    spoken = translate.Words("pt", ("full", "base", "water", "flood_1.5", "model_1.5.h5"))
    assert spoken(english) == other
    assert not spoken.missing or re.search(r"--drain", english)


def test_numbers_along_axes():
    """Also those that a formatter makes when the picture is drawn, and its multiplier."""
    with translate.spoken("pt"):
        figure, (axes, other) = pyplot.subplots(2, sharex=True)
        axes.plot([0, 0.7], [0, 1.5e-9])
        figure.colorbar(other.scatter([0.1, 0.5], [0, 23456], c=[0.1, 0.9]), ax=other)
        style.number_axes(figure)
        style.number_axes(figure)
        drawn = axis_labels(figure)
    pyplot.close(figure)
    assert {"0,2", "20\u202f000", "1e−9"} <= set(drawn) and not any(POINT.search(text) for text in drawn)


def test_what_is_missing_is_told():
    spoken = translate.Words("pt", ("base",))
    assert spoken("Nobody has put this; base") == "Nobody has put this; base" and spoken.missing == ["Nobody has put this"]


# ---- whole sheets


def axis_labels(figure):
    """As they will be drawn."""
    return [label for axis in figure.findobj(Axis) for label in [*(one.get_text() for one in axis.get_ticklabels()), axis.get_major_formatter().get_offset()] if label]


def with_points(page):
    """Numbers with a decimal point on a sheet, but for cells with keys of the scene, versions, names of files and options."""
    texts = re.findall(r"(<[^>]*>)([^<]+)", re.sub(r"<style.*?</style>|<title>.*?</title>", "", page, flags=re.DOTALL))
    texts = [text for tag, text in texts if not translate.KEYS.search(tag)] + re.findall(r'alt="([^"]*)"', page)
    for svg in re.findall(r'data:image/svg\+xml;base64,([^"]*)"', page):
        texts += re.findall(r"<!-- (.*?) -->", base64.b64decode(svg).decode("utf-8"))
    return [text for text in texts if POINT.search(re.sub(r"(Quoin|quoin_tools) \d+\.\d+\.\d+|(secção|tabela) \d+\.\d+|--[\w-]+[ =]\S+|\S*/\S*", "", html.unescape(text)))]


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    if not QUOIN.exists():
        pytest.skip("the solver is not built")
    folder = tmp_path_factory.mktemp("engineer")
    write(folder / "model.h5", section.mesh_of(EXAMPLE / "section.yaml")[0])
    other = tmp_path_factory.mktemp("guilhofrei")
    dam.main(["-o", str(other / "model.h5"), "--columns", "8"])
    for scene, run in ((EXAMPLE / "scene.yaml", folder), (ROOT / "examples/guilhofrei/scene.yaml", other)):
        subprocess.run([QUOIN, "-options_file", scene, "-model", run / "model.h5", "-output", run], check=True, stdout=subprocess.DEVNULL)
    return {"engineer": folder, "guilhofrei": other}


@pytest.mark.parametrize("name, arguments", [
    ("engineer", ["--guideline", "npb", "--uplift", "npb"]),
    ("engineer", ["--guideline", "usace", "--path", "way=0,0,0,-4,44,0", "--uplift", "usbr", "--strength", "2e7"]),
    ("guilhofrei", ["--guideline", "ferc", "--condition", "hp=usual", "--condition", "swhp=extreme"]),
])  # fmt: skip
def test_no_english_is_left(name, arguments, runs, monkeypatch, capsys):
    drawn = []
    monkeypatch.setattr(shared, "processors", lambda: 1)  # what is drawn is kept here
    monkeypatch.setattr(style, "save_figure", lambda figure, path, **_: (drawn.extend([*axis_labels(figure), *(text.get_text() for text in figure.findobj(Text))]), Path(path).write_bytes(b"no picture")))
    folder = runs[name]
    assert report.main([str(folder), "--language", "pt", *arguments]) == 0
    assert capsys.readouterr().err == ""
    page = (folder / "report.html").read_text(encoding="utf-8")
    texts = [html.unescape(text) for text in re.findall(r">([^<]+)<", re.sub(r"<style.*?</style>", "", page, flags=re.DOTALL))]
    texts += re.findall(r'alt="([^"]*)"', page)
    left = [text for text in texts + drawn if re.search(r"\b(the|and|with|stage|joint|which|of)\b", text) and not re.search(r"/model.h5|US Army Corps|Reclamation|Dam of 38 m|Gravity Dams|Guilhofrei dam", text)]
    assert not with_points(page) and not [text for text in drawn if POINT.search(text)] and any(re.fullmatch(r"\d+,\d+", text) for text in drawn)
    assert len(re.findall(r"<td[^>]*>[-+]?\d+,\d+</td>", page)) > 100
    assert '<html lang="pt">' in page and not left and any("tensões principais" in text for text in drawn)
    for text in ("Verificado por", "Casos e bases", "derrube: 2 e / L", "subpressão [kN]", "Anexo", "Reservas"):
        assert text in page, text
    assert 'content: "página "' in page and 'content: "Quoin, estado ' in page
    assert verify.main([str(folder / "report.html"), str(folder)]) == 0, "the sheet is held against its files in any language"


def test_english_stays(runs):
    assert report.main([str(runs["guilhofrei"])]) == 0
    page = (runs["guilhofrei"] / "report.html").read_text(encoding="utf-8")
    assert '<html lang="en">' in page and "Prepared by" in page and 'content: "page "' in page and translate.current is None


def test_a_stage_may_have_the_name_of_a_condition():
    """The name stays, the condition is put into the language."""
    case = SimpleNamespace(conditions={"extreme": "usual", "usual": "unusual"}, options=SimpleNamespace(guideline=None))
    with language.spoken("pt"):
        said = {stage: language.bare(condition) for stage, condition in combinations.judged_as(case).items()}
        named = language.bare(matrix.case_name(SimpleNamespace(stage="extreme", condition="usual")))
    assert said == {"extreme": "corrente", "usual": "excecional"} and named == "extreme (corrente)"
