"""Pages that run: every command of docs/tutorials and docs/coming_from, what the pages say it prints, their numbers and pictures; notebooks."""

import json
import os
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
NOTEBOOK = runpy.run_path(str(ROOT / "examples/notebook.py"))
PAGES = [path for folder in ("tutorials", "coming_from") for path in sorted((ROOT / "docs" / folder).glob("*.md")) if path.name != "README.md"]
LONG = ("04_strength_reduction", "06_earthquake", "07_stones", "08_how_sure")  # many trials, a record, samples


@pytest.fixture
def shell(tmp_path, monkeypatch):
    """The shell of tools/setup.sh: the command, the program of this build, the checkout."""
    (tmp_path / "bin").mkdir()
    command = tmp_path / "bin/quoin"
    command.write_text(f'#!/bin/sh\nexec python3 "{ROOT}/tools/quoin.py" "$@"\n', encoding="utf-8")
    command.chmod(0o755)
    monkeypatch.setenv("PATH", f"{command.parent}:{os.environ['PATH']}")
    monkeypatch.setenv("PYTHONPATH", str(ROOT / "tools"))
    monkeypatch.setenv("QUOIN_SOLVER", str(QUOIN))
    monkeypatch.setenv("QUOIN_ROOT", str(ROOT))
    monkeypatch.setenv("MPLBACKEND", "Agg")
    (tmp_path / "page").mkdir()
    return tmp_path / "page"


@pytest.mark.skipif(not QUOIN.exists(), reason="the program is not built")
@pytest.mark.parametrize("page", [pytest.param(path, marks=[pytest.mark.long] * (path.stem in LONG), id=path.stem) for path in PAGES])
def test_page(page, shell):
    if page.stem == "10_extend" and not (ROOT / "build/tests/quoin_recipes").exists():
        pytest.skip("build/tests/quoin_recipes is not built")
    _, wrong = NOTEBOOK["run"](page.read_text(encoding="utf-8"), shell)
    assert not wrong, "\n".join([*wrong, f"python examples/notebook.py {page.relative_to(ROOT)} --write, after a look"])


PAGE = """# A page
It says 3.14 and 2.7, and {prose}.
```sh
echo 'a 3.14 b 12 s'; echo other; echo 'c 2.718'
```
```text
{told}
```
"""


@pytest.mark.parametrize("prose, told, wrong", [
    ("no more", "a 3.14 b ...\n...\nc 2.718", []),
    ("no more", "a 3.15 b ...\nc 2.718", []),  # one of the last digit
    ("no more", "a 3.24 b ...\nc 2.718", ["a 3.24 b ..."]),
    ("no more", "a 3.14 b 11 s\nc 2.718", ["a 3.14 b 11 s"]),  # whole numbers are exact
    ("no more", "a 3.14 ...\nd 2.718", ["d 2.718"]),
    ("no more", "c 2.718\na 3.14 ...", ["a 3.14 ..."]),  # in order
    ("99 of them", "a 3.14 ...\nc 2.718", ["99 stands in the prose and in no block"]),
])  # fmt: skip
def test_what_a_page_says_wrong_is_found(shell, prose, told, wrong):
    _, found = NOTEBOOK["run"](PAGE.format(prose=prose, told=told), shell)
    assert [line.splitlines()[0] for line in found if "2.7 " not in line] == wrong


def test_a_page_written_anew_has_the_numbers_of_the_run(shell):
    now, _ = NOTEBOOK["run"](PAGE.format(prose="no more", told="a 9.99 b 1 s\n...\nc 1"), shell)
    assert "a 3.14 b 12 s\n...\nc 2.718\n" in now


def test_a_command_that_fails_ends_the_page(shell):
    with pytest.raises(SystemExit, match="exit code 3"):
        NOTEBOOK["run"]("```sh\nexit 3\n```\n", shell)


def test_notebooks_have_all_of_their_page():
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        cells = json.loads(json.dumps(NOTEBOOK["notebook"](text, page.parent)))["cells"]
        code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
        runs = [body for kind, body in NOTEBOOK["FENCE"].findall(text) if kind in ("sh", "python")]
        assert [body for body in runs if not any(cell.endswith(body) for cell in code)] == []
        compiled = [compile(cell, page.name, "exec") for cell in code if not cell.startswith("%%")]
        assert len(compiled) == len([kind for kind, _ in NOTEBOOK["FENCE"].findall(text) if kind == "python"])


def test_a_notebook_stands_alone(tmp_path):
    """Its pictures are in it, and its links lead from its own folder to what is there."""
    assert NOTEBOOK["main"]([*map(str, PAGES), "--notebook", str(tmp_path / "made/here")]) == 0
    for page in PAGES:
        cells = json.loads((tmp_path / f"made/here/{page.stem}.ipynb").read_text(encoding="utf-8"))["cells"]
        prose = "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown")
        pictures = [Path(file).name for _, file in NOTEBOOK["PICTURE"].findall(page.read_text(encoding="utf-8"))]
        assert [name for name in pictures if f"](attachment:{name})" not in prose] == [] and pictures == [name for cell in cells for name in cell.get("attachments", ())]
        assert [link for link in NOTEBOOK["LINK"].findall(prose) if not (tmp_path / "made/here" / link.partition("#")[0]).exists()] == []
