"""The main part of the sheet: page 1 with its matrix, four pages at most, remarks once; the scene as a file in the PDF."""

import os
import re
import subprocess
import sys
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from pypdf import PdfReader

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from quoin_tools.assess import assessment, combinations, guidelines  # noqa: E402
from quoin_tools.assess.assessment_options import options_from, parser  # noqa: E402
from quoin_tools.base import scene as scenes  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh import dam, section  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.show import browser, caveats, matrix, report  # noqa: E402
from quoin_tools.show.spreadsheet import chapters_of  # noqa: E402
from test_engineers_dam import by_hand  # noqa: E402

QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
EXAMPLE = ROOT / "examples/engineers_dam"
UPLIFT = ["--uplift", "npb", "--drain", "5"]  # the scenes of many cases have no uplift
MAIN = 4  # pages before the annex, at most
CASES = 8

pytestmark = pytest.mark.skipif(not QUOIN.exists(), reason="the solver is not built")
chromium = pytest.mark.skipif(browser.find() is None, reason=f"no Chromium to print the sheet: {browser.HOW}")


def first_page_of_annex(book):
    """How many pages are before it."""
    pages = [page.extract_text() for page in book.pages]
    return next(k for k, text in enumerate(pages) if {"Annex", "Anexo", "Annexe"} & set(text.splitlines()))


@pytest.fixture
def blank(monkeypatch):
    """Empty pictures of the shapes of the real ones, which are drawn elsewhere."""
    from PIL import Image

    def drawn(results, **_):
        paths = []
        for stage in results.stages:
            for name, size in ((f"stress_{stage}", (900, 400)), (f"joint_base_{stage}", (500, 420)), (f"mechanism_{stage}", (400, 500))):
                paths.append(os.path.join(results.folder, name + ".png"))
                Image.new("L", size, 200).save(paths[-1])
        return paths

    monkeypatch.setattr(report.plots, "drawing", lambda *given, **_: nullcontext(partial(drawn, *given)))
    monkeypatch.setattr(report, "limit_part", lambda case: "")  # it has tests of its own


@pytest.fixture(scope="module")
def engineer(tmp_path_factory):
    folder = tmp_path_factory.mktemp("engineer")
    write(folder / "model.h5", section.mesh_of(EXAMPLE / "section.yaml")[0])
    subprocess.run([QUOIN, "-options_file", EXAMPLE / "scene.yaml", "-model", folder / "model.h5", "-output", folder], check=True, stdout=subprocess.DEVNULL)
    return folder


@pytest.fixture(scope="module")
def many(tmp_path_factory):
    """More cases, loads and joints than the main part has room for."""
    folder = tmp_path_factory.mktemp("many")
    dam.main(["-o", str(folder / "model.h5"), "--columns", "8"])
    scene = yaml.safe_load((ROOT / "examples/guilhofrei/scene.yaml").read_text(encoding="utf-8"))
    scene["joints"]["base"] = {"k_n": 10e9, "k_s": 3e9, "friction": 45}
    scene["loads"] |= {f"flood_{k}": {"type": "reservoir", "faces": "upstream", "level": 30.0 + 0.3 * k} for k in range(CASES)}
    scene["stages"] = [{"empty": {"loads": ["weight"]}}] + [{f"case_{k}": {"from": "empty", "loads": ["weight", f"flood_{k}"]}} for k in range(CASES)]
    scene["stages"].append({"reduction": {"type": "strength_reduction", "from": "case_7", "loads": ["weight", "flood_7"], "start": 45, "step": 5, "bracket": 2}})
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene), encoding="utf-8")
    subprocess.run([QUOIN, "-options_file", folder / "scene.yaml", "-model", folder / "model.h5", "-output", folder], check=True, stdout=subprocess.DEVNULL)
    return folder


def written(folder, *arguments):
    assert report.main([str(folder), *arguments]) == 0
    return (folder / "report.html").read_text(encoding="utf-8")


def assessed(folder, *arguments):
    case = assessment.load_case(str(folder), options_from(parser("assessment", "").parse_args([str(folder), *arguments])))
    return case, *assessment.assess(case)


def rows_of(text, chapter):
    return [[cell for cell, _ in row] for row in dict(chapters_of(text))[chapter]]


PATHS = [word for k in range(3) for word in ("--path", f"lift_{k}=-5,{8 + 8 * k},30,{8 + 8 * k}")]


@chromium
@pytest.mark.parametrize("name, arguments", [
    pytest.param("engineer", ["--guideline", "usace", "--given", "tests=with", "--uplift", "npb"], marks=pytest.mark.long),
    ("many", ["--language", "pt", "--guideline", "cadam", "--given", "tests=without", *UPLIFT, *PATHS, *(word for k in range(4) for word in ("--condition", f"case_{k}=usual"))]),
])  # fmt: skip
def test_four_pages_before_the_annex(name, arguments, request, blank):
    """Also where tables and remarks have more rows than there is room for."""
    folder = request.getfixturevalue(name)
    assert report.main([str(folder), "--pdf", *arguments]) == 0
    book = PdfReader(folder / "report.pdf")
    assert 3 <= first_page_of_annex(book) <= MAIN < len(book.pages)
    first, second = (book.pages[k].extract_text() for k in (0, 1))
    for words in (("Cases and bases", "Casos e bases"), ("Prepared by", "Elaborado por"), ("Reservations:", "Reservas:")):
        assert any(word in first for word in words) and not any(word in second for word in words)
    assert [(file, data[0]) for file, data in book.attachments.items()] == [("scene_echo.yaml", (folder / "scene_echo.yaml").read_bytes())]
    assert not any("velocity_tolerance" in page.extract_text() for page in book.pages), "the scene is printed"


def test_the_matrix_has_the_numbers_of_both_methods(many, blank):
    arguments = ["--guideline", "cadam", "--given", "tests=without", *UPLIFT, "--condition", "case_2=usual", "--condition", "case_6=unusual"]
    case, found, _ = assessed(many, *arguments)
    by = {(a.stage, a.name): a for a in found}
    rows = rows_of(written(many, *arguments), "Cases and bases")
    header, rows = rows[0], [row for row in rows[1:] if len(row) == len(rows[0])]
    assert [row[0] for row in rows] == ["case_2 (usual)", "", "FAIL", "case_6 (unusual)", "", "INCOMPLETE"]
    for k, stage in enumerate(("case_2", "case_6")):
        a, (block, hand, limit) = by[stage, "base"], (dict(zip(header, row)) for row in rows[3 * k : 3 * k + 3])
        assert block["sliding, peak strength"] == f"{a.block['peak']:.2f}" and hand["uplift [kN]"] == f"{a.with_uplift.uplift / 1e3:.0f}"
        assert hand["overturning: 2 e / L"] == f"{2 * abs(a.with_uplift.eccentricity) / a.base.length:.3f}" != block["overturning: 2 e / L"]
        assert hand["crack / L"] == f"{a.with_uplift.crack / a.base.length:.3f}"
        least = {limit.quantity: limit for limit in a.limits}["sliding_peak"]
        assert limit["sliding, peak strength"] == f"{least.verdict}, ≥ {least.limit:.2f}"


def test_a_factor_without_shear_is_infinite():
    """Construction has no shear but the residual of the iteration; no column of sliding prints N over it."""
    sliding = [column[1] for column in matrix.COLUMNS if column[0].startswith("sliding")]
    assert len(sliding) == 4 and {matrix.words(6.2e13, 1, 2, key) for key in sliding} == {"∞"} and matrix.words(1.5, 1, 2, "friction_only") == "1.50"


def test_every_case_is_on_the_first_page(many, blank):
    """Of more cases than the page has room for, each has a row with its numbers; the least safe base has those of both methods."""
    case, found, _ = assessed(many, "--guideline", "cadam", "--given", "tests=without", *UPLIFT)
    judged = [a for a in found if a.condition]
    worst = min(judged, key=lambda a: (-sum(j.verdict == guidelines.FAIL for j in a.limits), matrix.of_hand(a)["peak"] or 0))
    text = written(many, "--guideline", "cadam", "--given", "tests=without", *UPLIFT)
    assert f"{len(judged) - 1} more bases are in the annex: this one is the least safe" in text and worst.stage == "case_7"
    rows = rows_of(text, "Cases and bases")
    lines = [dict(zip(rows[0], row)) for row in rows if len(row) == len(rows[0]) and row[0].endswith("(usual)")][:CASES]
    assert [row["case"] for row in lines] == [f"case_{k} (usual)" for k in range(CASES)] and rows[0][3:7] == ["N [kN]", "T [kN]", "M [kN m]", "uplift [kN]"]
    for k, row in enumerate(lines):
        (a,) = (a for a in judged if a.stage == f"case_{k}")
        hand = a.with_uplift
        assert [row[key] for key in ("N [kN]", "T [kN]", "M [kN m]", "uplift [kN]")] == [f"{x / 1e3:.0f}" for x in (hand.N, hand.T, hand.M, hand.uplift)]
        assert [row[f"stress at the {end} [kPa]"] for end in ("heel", "toe")] == [assessment.cell(x / 1e3, 0) for x in hand.linear]


@pytest.mark.parametrize("stage, guideline, condition", [
    ("flood", "usace", "unusual"), ("pmf", "usace", "extreme"), ("PMF-2000", "ferc", "unusual"), ("after_earthquake", "ferc", "after_earthquake"),
    ("post_quake", None, "after_earthquake"), ("full", "usace", "usual"), ("clogged_drains", "usbr", "unusual")])  # fmt: skip
def test_a_name_says_a_condition(stage, guideline, condition):
    """FERC judges every flood as unusual: its extreme case is the earthquake."""
    text = f"loads:\n  weight: {{type: self_weight}}\n  water: {{type: reservoir, faces: upstream, level: 33}}\nstages:\n  {stage}: {{loads: [weight, water]}}\n"
    options = SimpleNamespace(guidelines=None, guideline=guideline, uplift=None, drain=None, conditions={})
    case = SimpleNamespace(scene=scenes.parse(text, "scene.yaml"), options=options, conditions={stage: condition})
    assert combinations.by_name(case, stage) == condition
    assert combinations.taken_from_names(case) == ({} if condition == "usual" else {stage: condition})


def test_a_seam_gets_its_way(engineer, blank):
    """From the heel down the crack and along the seam, with the strength of the seam: T and N by hand. The base alone would pass."""
    N, T = by_hand()
    for arguments in ([], ["--path", "way=0,0,0,-4,44,0", "--strength-on", "way=30,0"]):
        _, found, complaints = assessed(engineer, "--guideline", "usbr", *arguments)
        own = next(a for a in found if a.condition and a.name == ("way" if arguments else "crack+seam"))
        assert own.complete and own.hand.N == pytest.approx(N, rel=1e-3) and own.hand.T == pytest.approx(T, rel=1e-3)
        assert f"{assessment.factors(own.hand, own.strength)['peak']:.2f}" == f"{own.hand.sliding_factor(30):.2f}" == "1.03" and own.block["peak"] == pytest.approx(1.03, abs=0.01)
        assert any("found by itself" in note for note in own.notes) == (not arguments) == (not complaints["full"])
    text = written(engineer, "--guideline", "usbr", "--strength", "20e6")
    assert "<b>FAIL</b>" in text and "in stage full on crack+seam" in text and "does not take them" not in text


def test_a_joint_without_the_gravity_method_is_no_pass(engineer, blank, monkeypatch):
    """The seam of the dam stands by 1.03; the base alone would pass."""
    monkeypatch.setattr(assessment.sliding_paths, "through", lambda *_: [])
    text = written(engineer, "--guideline", "usbr", "--strength", "20e6", "--condition", "full=extreme")
    assert "<b>INCOMPLETE</b>" in text and "Not judged, because the gravity method does not take them: joints seam (full); crack (full)" in text
    header, *rows = rows_of(text, "Cases and bases")
    rows = [row for row in rows if row[1:2] == ["seam"]]
    factor = Results(engineer).stage_summary("full")["joints"]["seam"]["sliding_factor_peak"]
    assert len(rows) == 1 and rows[0][:3] == ["full: not judged", "seam", "block model alone"] and rows[0][header.index("sliding, peak strength")] == f"{factor:.2f}" == "1.03"
    whole = written(engineer, "--guideline", "usbr", "--path", "way=0,0,0,-4,44,0", "--condition", "full=extreme")
    assert "does not take them" in whole  # the path goes through both, and has no strength


def test_the_drain_is_that_of_the_scene(engineer, blank, capsys):
    """5 m under the base, 5.02 m in the seam; what the command line says otherwise is reported."""
    of_scene, same, other = (assessed(engineer, "--uplift", "npb", *words)[1] for words in ([], ["--drain", "5"], ["--drain", "6"]))
    drain = {key: {a.name: a.water.heads.drain for a in found if a.stage == "full" and a.with_uplift} for key, found in (("scene", of_scene), ("same", same), ("other", other))}
    assert drain["scene"]["base"] == drain["same"]["base"] == 5 and drain["other"]["base"] == 6
    base = {key: next(a for a in found if a.stage == "full" and a.name == "base") for key, found in (("scene", of_scene), ("same", same), ("other", other))}
    assert base["scene"].with_uplift.uplift == base["same"].with_uplift.uplift == pytest.approx(base["scene"].hand.uplift) != base["other"].with_uplift.uplift
    assert not [note for key in ("scene", "same") for note in base[key].notes if "command line" in note]
    assert "The command line has the drain 6.00 m from the heel, the scene has the drain 5.00 m from the heel: the numbers of the rule are those of the command line." in base["other"].notes
    assert "<td>5 m under base, as in the scene</td>" in written(engineer, "--uplift", "npb")
    assert report.main([str(engineer), "--drain", "5"]) == 2 and "--drain: it belongs to a rule of uplift" in capsys.readouterr().err


def test_each_remark_stands_once(many, blank):
    arguments = ["--guideline", "ferc", "--given", "hazard=high", *UPLIFT, *PATHS]
    case, found, complaints = assessed(many, *arguments)
    text, said = written(many, *arguments), caveats.Caveats(case, found, complaints)
    assert len(said.texts) > caveats.MOST and said.judged > 2
    from quoin_tools.show.hypertext import esc

    assert [text.count(f"</b> {esc(remark)} <small>") for remark in said.texts] == [1] * len(said.texts)
    assert sorted(map(int, re.findall(r'<p class="note"><b>(\d+)</b>', text))) == list(range(1, len(said.texts) + 1))
    marked = {int(number) for line in re.findall("<p class='soft'>Reservations ([^<]*)\\.</p>", text) for number in line.split(", ")}
    assert marked == {said.number(note) for a in found for note in a.notes}
