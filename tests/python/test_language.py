"""The language of the sheet: a catalogue has all that is marked and nothing else, no English is left on a Portuguese or French sheet or in its pictures."""

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
from babel.messages.frontend import CommandLineInterface
from babel.messages.pofile import read_po
from matplotlib import pyplot
from matplotlib.axis import Axis
from matplotlib.text import Text

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from quoin_tools.assess import combinations  # noqa: E402
from quoin_tools.base import language, shared, solver_sentences  # noqa: E402
from quoin_tools.front.main import ended  # noqa: E402
from quoin_tools.mesh import dam  # noqa: E402
from quoin_tools.show import matrix, report, style, verify  # noqa: E402
from test_sheet import EXAMPLE, section, write  # noqa: E402

QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
HOUSE = ROOT / "tools/quoin_tools"
POINT = re.compile(r"\d\.\d")
ENGLISH = re.compile(r"\b(the|and|with|from|which|stage|joint|joints|load|loads|water|crack|sliding|that|are|is|not|without|between|largest|least|force|of|at|by)\b", flags=re.IGNORECASE)

SHARED = {"pt": set(), "fr": {"joint", "joints", "force"}}  # words of another language that English has too


# ---- the catalogue


@pytest.fixture(scope="module")
def marked(tmp_path_factory):
    """All messages of the tools and guidelines, as docs/extend.md extracts them: singular to (singular,) or (singular, plural)."""
    template = tmp_path_factory.mktemp("messages") / "quoin.pot"
    CommandLineInterface().run(["pybabel", "-q", "extract", "-F", str(HOUSE / "base/locale/babel.cfg"), "-o", str(template), str(HOUSE)])
    with template.open("rb") as file:
        return by_singular(read_po(file))


def by_singular(catalogue):
    return {texts[0]: texts for texts in (message.id if message.pluralizable else (message.id,) for message in catalogue if message.id)}


def holes(text):
    return {(name, form, kind) for _, name, form, kind in string.Formatter().parse(text) if name}


@pytest.mark.parametrize("name", language.languages()[1:])
def test_a_catalogue_has_what_is_marked(name, marked):
    """Each message has a translation with the same holes in the same formats; of a plural form hole 0, the number, may be left out. Nothing else is there."""
    catalogue, wrong = language.read(name), []
    assert len(marked) > 900 and marked == by_singular(catalogue)
    for message in catalogue:
        if message.id:
            texts, many = (message.string, message.id[1]) if message.pluralizable else ((message.string,), message.id)
            count = {("0", "", None)} if message.pluralizable else set()
            wrong += [message.id for text in texts if not text or message.fuzzy or (holes(text) ^ holes(many)) - count]
    assert not wrong


@pytest.mark.parametrize("name", language.languages()[1:])
def test_no_english_is_in_the_catalogue(name):
    texts = [text for message in language.read(name) if message.id for text in (message.string if message.pluralizable else (message.string,))]
    assert not [text for text in texts if set(ENGLISH.findall(re.sub(r"«[^»]*»|US [\w ]+|IS 6512|--path|--uplift|\(\w+: \w+\)|quoin limit|f = |breaking_force|use what: strengths|-restart|loads\.\{", "", text).lower())) - SHARED[name]]


def test_each_mark_is_found(marked):
    """The tools of gettext look neither into f-strings nor into calls within a message's call."""
    for path in HOUSE.rglob("*.py"):
        calls = [node for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("_", "N_", "ngettext")]
        assert not [call.args[0].value for call in calls if isinstance(call.args[0], ast.Constant) and call.args[0].value not in marked], path


def test_what_is_not_translated_stays_english(tmp_path, monkeypatch):
    monkeypatch.setattr(language, "FOLDER", tmp_path)
    path = tmp_path / "xx/LC_MESSAGES/quoin.po"
    path.parent.mkdir(parents=True)
    path.write_text('msgid ""\nmsgstr "Language: xx\\n"\n\n#, fuzzy\nmsgid "a {0}"\nmsgstr "b {0}"\n\nmsgid "c"\nmsgstr ""\n\nmsgid "d"\nmsgstr "e"\n\nmsgid "{0} g"\nmsgid_plural "{0} gs"\nmsgstr[0] ""\nmsgstr[1] ""\n', encoding="utf-8")
    with language.spoken("xx") as spoken:
        assert [language._("a {0:.1f}", 0.5), language._("c"), language._("d"), *(language.ngettext(f"{{0}} {one}", f"{{0}} {one}s", 2) for one in "fg")] == ["a 0.5", "c", "e", "2 fs", "2 gs"]
    assert spoken.missing == ["12345.6", "a {0:.1f}", "c", "{0} f", "{0} g"]


def test_without_babel(monkeypatch, tmp_path, capsys):
    """Another language than English needs it."""
    monkeypatch.setitem(sys.modules, "babel", None)
    monkeypatch.setitem(sys.modules, "babel.messages.pofile", None)
    monkeypatch.setattr(report, "load_case", lambda *_: None)
    language.read.cache_clear()
    assert ended("report", lambda: report.main([str(tmp_path), "--language", "pt"])) == 2
    found = capsys.readouterr().err
    assert found.startswith("quoin report: needs the Python package ") and "babel" in found and found.count("\n") == 1


# ---- sentences and numbers


@pytest.mark.parametrize("english, other", [
    ("unbalanced ratio 7e-07 <= 1e-06, increment 3.42e-08 <= 1e-06", "razão de desequilíbrio 7e-07 <= 1e-06, incremento 3,42e-08 <= 1e-06"),
    ("5 trials: stable at 53.25 m, fails at 53.3125 m, where it rests but beyond displacement_limit; moved 0.002 m since the stage began (displacement_limit 0.38 m, 1 % of the size)",
     "5 tentativas: estável a 53,25 m, falha a 53,3125 m, onde fica em repouso mas além de displacement_limit; moveu-se 0,002 m desde o início da etapa (displacement_limit 0,38 m, 1 % do tamanho)"),
    ("7 trials: stable at 29.2 degree, the limit; nothing fails; factor 1.034 to 1.036; moved 0.1 m since the stage began", "7 tentativas: estável a 29,2 graus, o limite; nada falha; fator de 1,034 a 1,036; moveu-se 0,1 m desde o início da etapa"),
    ("trial 3 is collapsed: a force or displacement is not a finite number, first in block 12 of group collapsed", "tentativa 3 (colapsou): uma força ou deslocamento não é um número finito, primeiro em bloco 12 do grupo collapsed"),
    ("overturned: macroblock 3 (water) at 0.52 s; 2 s in 20000 steps; energy balance -1.2e-06 J, finding contacts again 0 J of 100 J moved; contacts verified 7 times, 0 made, 3 lost",
     "derrube: macrobloco 3 (water) aos 0,52 s; 2 s em 20\u202f000 passos; balanço de energia -1,2e-06 J, redeteção de contactos 0 J de 100 J movimentados; contactos verificados 7 vezes, 0 criados, 3 perdidos"),
])  # fmt: skip
def test_sentences_of_the_solver(english, other):
    assert solver_sentences.solver_says(english) == english
    with language.spoken("pt") as spoken:
        assert solver_sentences.solver_says(english) == other and not spoken.missing
        assert solver_sentences.solver_says("nobody says this; nothing fails") == "nobody says this; nada falha" and spoken.missing == ["nobody says this"]


def words_of(text):
    """Words without the s of a plural."""
    return re.findall(r"\w+?(?=s?\b)", re.sub(r"%[-+.\d]*l?[a-z]", " ", text))


def test_the_solver_says_these_sentences():
    """The words between the holes stand in its source."""
    source = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "src").rglob("*.c"))
    source = re.sub(r'"\s*(PetscInt(64)?_FMT)?\s*"', "", source).replace("%%", "%")
    source = f" {' '.join(words_of(source))} "
    lost = []
    for sentence in solver_sentences.SENTENCES:
        for piece in re.split(r"\{\d(?:!s)?\}", sentence):
            words = words_of(piece)
            lost += [f"{sentence}: {' '.join(words[k : k + 2])}" for k in range(len(words) - 1) if f" {words[k]} {words[k + 1]} " not in source]
    assert not lost


def test_verdicts_and_methods_are_words():
    """Those that the solver gives a stage; none is the verdict of one that has not ended."""
    named = re.findall(r'"([a-z_, ]{2,})"', (ROOT / "src/result/stage/stage_result.c").read_text(encoding="utf-8"))
    assert len(named) > 8 and set(named) - {"none"} <= set(solver_sentences.WORDS)


@pytest.mark.parametrize("english, other", [("-12345.6", "-12\u202f345,6"), ("1234.5", "1234,5"), ("1.50e-06", "1,50e-06"), ("12345678", "12345678"), ("+0.5", "+0,5"), ("2e7", "2e7")])
def test_numerals(english, other):
    with language.spoken("pt"):
        assert language.numeral(english) == other
        assert language._("{0:g} m thick; forces are those of the slice", 0.5) == "0,5 m de espessura; as forças são as da fatia"
    assert language.numeral(english) == english


def test_a_stage_may_have_the_name_of_a_condition():
    """The name stays, the condition is put into the language."""
    case = SimpleNamespace(conditions={"extreme": "usual", "usual": "unusual"}, options=SimpleNamespace(guideline=None))
    with language.spoken("pt"):
        assert combinations.judged_as(case) == {"extreme": "corrente", "usual": "excecional"}
        assert matrix.case_name(SimpleNamespace(stage="extreme", condition="usual")) == "extreme (corrente)"


def axis_labels(figure):
    """As they will be drawn."""
    return [label for axis in figure.findobj(Axis) for label in [*(one.get_text() for one in axis.get_ticklabels()), axis.get_major_formatter().get_offset()] if label]


def test_numbers_along_axes():
    """Also those that a formatter makes when the picture is drawn, and its multiplier."""
    with language.spoken("pt"):
        figure, (axes, other) = pyplot.subplots(2, sharex=True)
        axes.plot([0, 0.7], [0, 1.5e-9])
        figure.colorbar(other.scatter([0.1, 0.5], [0, 23456], c=[0.1, 0.9]), ax=other)
        style.number_axes(figure)
        style.number_axes(figure)
        drawn = axis_labels(figure)
    pyplot.close(figure)
    assert {"0,2", "20\u202f000", "1e−9"} <= set(drawn) and not any(POINT.search(text) for text in drawn)


# ---- whole sheets


def with_points(page):
    """Numbers with a decimal point on a sheet, but for cells with keys of the scene, versions, names of files and options."""
    texts = re.findall(r"(<[^>]*>)([^<]+)", re.sub(r"<style.*?</style>|<title>.*?</title>", "", page, flags=re.DOTALL))
    texts = [text for tag, text in texts if not re.match(r'<td class="[^"]*\bkeys\b', tag)] + re.findall(r'alt="([^"]*)"', page)
    for svg in re.findall(r'data:image/svg\+xml;base64,([^"]*)"', page):
        texts += re.findall(r"<!-- (.*?) -->", base64.b64decode(svg).decode("utf-8"))
    return [text for text in texts if POINT.search(re.sub(r"(Quoin|quoin_tools) \d+\.\d+\.\d+|(secção|tabela|section|tableau) \d+\.\d+|--[\w-]+[ =]\S+|\S*/\S*", "", html.unescape(text)))]


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


SAID = {"pt": ("tensões principais", 'content: "página "', 'content: "Quoin, estado ', "Verificado por", "Casos e bases", "derrube: 2 e / L", "subpressão [kN]", "Anexo", "Reservas"),
        "fr": ("contraintes principales", 'content: "page "', 'content: "Quoin, état ', "Vérifié par", "Cas et bases", "renversement : 2 e / L", "sous-pression [kN]", "Annexe", "Réserves", "barrage-poids")}  # fmt: skip


@pytest.mark.parametrize("speaks, name, arguments", [
    ("pt", "engineer", ["--guideline", "npb", "--uplift", "npb"]),
    ("pt", "engineer", ["--guideline", "usace", "--path", "way=0,0,0,-4,44,0", "--uplift", "usbr", "--strength", "2e7"]),
    ("pt", "guilhofrei", ["--guideline", "ferc", "--condition", "hp=usual", "--condition", "swhp=extreme"]),
    ("fr", "engineer", ["--guideline", "usace", "--path", "way=0,0,0,-4,44,0", "--uplift", "usbr", "--strength", "2e7"]),
])  # fmt: skip
def test_no_english_is_left(speaks, name, arguments, runs, monkeypatch, capsys):
    drawn = []
    monkeypatch.setattr(shared, "processors", lambda: 1)  # what is drawn is kept here
    monkeypatch.setattr(style, "save_figure", lambda figure, path, **_: (drawn.extend([*axis_labels(figure), *(text.get_text() for text in figure.findobj(Text))]), Path(path).write_bytes(b"no picture")))
    folder = runs[name]
    assert report.main([str(folder), "--language", speaks, *arguments]) == 0
    assert capsys.readouterr().err == ""
    page = (folder / "report.html").read_text(encoding="utf-8")
    texts = [html.unescape(text) for text in re.findall(r">([^<]+)<", re.sub(r"<style.*?</style>", "", page, flags=re.DOTALL))]
    texts += re.findall(r'alt="([^"]*)"', page)
    left = [text for text in texts + drawn if re.search(r"\b(the|and|with|stage|which|of)\b" + (r"|\bjoint\b" if speaks == "pt" else ""), text) and not re.search(r"/model.h5|US Army Corps|Reclamation|Dam of 38 m|Gravity Dams|Guilhofrei dam", text)]
    assert not with_points(page) and not [text for text in drawn if POINT.search(text)] and any(re.fullmatch(r"\d+,\d+", text) for text in drawn)
    assert len(re.findall(r"<td[^>]*>[-+]?\d+,\d+</td>", page)) > 100
    assert f'<html lang="{speaks}">' in page and not left and any(SAID[speaks][0] in text for text in drawn)
    for text in SAID[speaks][1:]:
        assert text in page, text
    assert verify.main([str(folder / "report.html"), str(folder)]) == 0, "the sheet is held against its files in any language"


def test_english_stays(runs):
    assert report.main([str(runs["guilhofrei"])]) == 0
    page = (runs["guilhofrei"] / "report.html").read_text(encoding="utf-8")
    assert '<html lang="en">' in page and "Prepared by" in page and 'content: "page "' in page and language.current is None
