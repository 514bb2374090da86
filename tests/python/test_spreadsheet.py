"""The sheet as a spreadsheet (quoin report FOLDER --xlsx): the cells of its tables, numbers as numbers, texts as texts."""

import os
import re
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import pytest
from openpyxl import load_workbook
from quoin_tools.base.results import Results
from quoin_tools.show import report, spreadsheet

ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))


@pytest.mark.skipif(not QUOIN.exists(), reason="the program is not built")
def test_the_spreadsheet_has_the_tables_of_the_sheet(tmp_path, monkeypatch, capsys):
    subprocess.run([sys.executable, ROOT / "examples/anchored_dam/mesh.py", tmp_path / "model.h5"], check=True, env=os.environ | {"PYTHONPATH": str(ROOT / "tools")})
    command = [QUOIN, "-options_file", ROOT / "examples/anchored_dam/scene.yaml", "-model", tmp_path / "model.h5", "-output", tmp_path]
    subprocess.run(command, check=True, capture_output=True)
    monkeypatch.setattr(report.plots, "drawing", lambda *_, **__: nullcontext(list))  # the pictures are not in it
    assert report.main([str(tmp_path), "--xlsx", "--guideline", "usace"]) == 0
    assert capsys.readouterr().out.split() == [f"{tmp_path}/report.html", f"{tmp_path}/report.xlsx"]
    page, book = (tmp_path / "report.html").read_text(encoding="utf-8"), load_workbook(tmp_path / "report.xlsx")
    headings = [heading for heading in re.findall(r"<h2>(.*?)</h2>", page) if heading[:31] in book.sheetnames]
    assert book.sheetnames[0] == "Sheet" and [name for name in book.sheetnames if name != "Sheet"] == [heading[:31] for heading in headings] and len(headings) >= 6
    in_page = len(re.findall(r"<t[dh][ >]", re.sub(r"<(pre|svg)\b.*?</\1>", "", page, flags=re.S)))
    cells = [cell for tab in book for row in tab.iter_rows() for cell in row if cell.value is not None]
    empty = len(re.findall(r"<t[dh][^>]*></t[dh]>", page))
    assert in_page - empty <= len(cells) < in_page + 60  # titles and notes besides
    stages, results = {row[0]: row for row in book["Stages"].iter_rows(values_only=True) if row[0]}, Results(tmp_path)
    assert stages["stage"][3] == "applied x [kN]"
    for s in results.summary["stages"]:
        assert stages[s["name"]][3] == pytest.approx(s["applied"]["x"] / 1e3, rel=1e-12) and stages[s["name"]][2] == s["verdict"]
    shown = next(cell for row in book["Stages"].iter_rows() for cell in row if cell.column == 4 and isinstance(cell.value, float))
    assert shown.number_format == "0.0" and "data-full" not in page  # in full, and shown as on the page
    verdict = re.search(r'<div class="verdict \w+"><b>(.*?)</b>', page)[1]
    assert verdict in {cell.value for cell in cells if cell.parent.title == "Sheet"}


def test_texts_stay_texts():
    """What looks like a formula is none; thin spaces and a true minus are those of numbers; checksums, dates and places are not numbers; tabs have names that spreadsheets take."""
    page = ("<h1>=1+1</h1><h2>A/B: a very long heading that goes on</h2><h3>one</h3><table><tr><th>12</th><th>x</th></tr>"
            "<tr><td class='n'>12\u202f345.5</td><td>\u22123.2</td><td>1e-07</td><td>=SUM(A1)</td><td>0x12</td><td>(1.00, 2.00)</td><td>-</td><td class='fail'>a<br>b \x01</td></tr></table>"
            "<h2>A/B: a very long heading that goes off</h2><p>said <b>loud</b></p>")  # fmt: skip
    (_, first), (_, rows), (_, last) = spreadsheet.chapters_of(page)
    assert first[0] == [("=1+1", "title")] and last == [[("said loud", "note")]]
    import io

    book = load_workbook(io.BytesIO(spreadsheet.workbook(page)))
    assert book.sheetnames == ["Sheet", "A B  a very long heading that g", "A B  a very long heading th 2"] and len(rows) == 4
    assert book["Sheet"]["A1"].data_type == "s" and book["Sheet"]["A1"].value == "=1+1"
    tab = book.worksheets[1]
    assert [cell.value for cell in tab[2]][:2] == ["12", "x"]  # a heading
    assert [cell.value for cell in tab[3]] == [12345.5, -3.2, 1e-7, "=SUM(A1)", "0x12", "(1.00, 2.00)", "-", "a b"]
    assert tab["D3"].data_type == "s" and tab["H3"].font.bold


def test_numbers_of_another_language():
    """A cell with a decimal comma is the same number; one with a point is none, but for keys of the scene."""
    cells = [("12\u202f345,5", "n"), ("-0,25", ""), ("1,5e-07", ""), ("1.5", ""), ("1.5", "keys"), ("1,00; 2,00", ""), ("1,5", "note")]
    assert [spreadsheet.value_of(*cell, ",") for cell in cells] == [12345.5, -0.25, 1.5e-7, "1.5", 1.5, "1,00; 2,00", "1,5"]
