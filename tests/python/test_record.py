"""Data and tables of the benchmarks (tests/benchmark/record.py): rows that are not measured again stay, text outside the marks too."""

import re
import sys
from pathlib import Path

import pytest

BENCHMARK = Path(__file__).resolve().parents[1] / "benchmark"
sys.path.insert(0, str(BENCHMARK))

import record  # noqa: E402


@pytest.fixture
def docs(tmp_path, monkeypatch):
    monkeypatch.setattr(record, "DOCS", tmp_path)
    monkeypatch.setattr(record, "DATA", tmp_path)
    return tmp_path


def test_rows_of_other_sizes_stay(docs):
    record.keep("cycle", [{"side": 1, "ns": 3.0}, {"side": 2, "ns": 4.0}], ("side",))
    rows = record.keep("cycle", [{"side": 1, "ns": 5.123456789}, {"side": 3, "ns": 6.0}], ("side",))
    assert rows == [{"side": 1, "ns": 5.12346}, {"side": 2, "ns": 4.0}, {"side": 3, "ns": 6.0}]
    assert record.keep("cycle", [], ("side",)) == rows


def test_only_the_text_between_the_marks_changes(docs):
    page = docs / record.TABLES
    page.parent.mkdir()
    page.write_text("before\n<!-- cycle -->\nold\n<!-- end cycle -->\nafter\n")
    record.replace_between("cycle", record.table(["a", "b"], [[1, "x"]]))
    assert page.read_text() == "before\n<!-- cycle -->\n| a | b |\n|---|---|\n| 1 | x |\n<!-- end cycle -->\nafter\n"


def test_every_table_has_its_marks():
    text = "".join(path.read_text(encoding="utf-8") for path in BENCHMARK.glob("*.py"))
    page = (record.DOCS / record.TABLES).read_text(encoding="utf-8")
    marks = set(re.findall(r'replace_between\("([\w ]+)"', text))
    assert marks == set(re.findall(r"<!-- (?!end )([\w ]+) -->", page))
    for mark in marks:
        assert page.count(f"<!-- {mark} -->\n") == page.count(f"<!-- end {mark} -->\n") == 1
