"""The pages of docs/reference: each has its parts, its scene runs, its keys are those of the table and of the schema."""

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml
from quoin_tools.front import running, topics
from quoin_tools.mesh import dam

ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
PAGES = sorted(path.stem for path in (ROOT / "docs/reference").glob("*.md"))
SHORT = ("silt", "flow", "trials", "dynamic")  # run in the first lane too
solver = pytest.mark.skipif(not QUOIN.exists(), reason="needs the solver")


def text(page):
    return (ROOT / f"docs/reference/{page}.md").read_text(encoding="utf-8")


def scene(page):
    return re.search(r"^```yaml\n(.*?)^```", text(page), flags=re.M | re.S)[1]


@pytest.fixture(scope="module")
def mesh(tmp_path_factory):
    """The mesh that the first lines of all scenes make."""
    path = tmp_path_factory.mktemp("mesh") / "dam.h5"
    assert dam.main(["--height", "12", "--columns", "4", "-o", str(path)]) == 0
    return path


@pytest.fixture
def folder(mesh, tmp_path, monkeypatch):
    """Writes the scene of a page and what its first lines make."""
    monkeypatch.chdir(tmp_path)

    def written(page):
        commands = re.findall(r"^# (.*?)(?:   #.*)?$", scene(page), flags=re.M)
        assert "quoin import dam --height 12 --columns 4 -o dam.h5" in commands
        shutil.copy(mesh, "dam.h5")
        for command in commands:
            if not command.startswith("quoin import"):
                subprocess.run(["bash", "-c", command], check=True)
        Path("scene.yaml").write_text(scene(page), encoding="utf-8")
        return tmp_path

    return written


def test_the_scene_lists_every_page_once():
    assert sorted(topics.pages()) == PAGES and len(PAGES) > 40
    assert {name for _, name in topics.types()} | set(topics.sections()) - {"what_if"} <= set(PAGES)


@pytest.mark.parametrize("page", PAGES)
def test_a_page_has_its_parts(page):
    """Title, what it is in a sentence or two, a scene that uses it, keys, related pages, and what verifies it."""
    assert re.match(r"# \S.*\n\n[A-Z](?:[^\n]+\n)+\n```yaml\n", text(page))
    assert re.search(r"^\*\*Keys\*\*: .*\n\n(\*\*Refused\*\*: [^*]+\n\n)?\*\*Related\*\*: ", text(page), flags=re.M | re.S)
    assert topics.rows_of_page(page)
    used = yaml.safe_load(scene(page))
    if page in dict(map(reversed, topics.types())):
        rows = [row for load in (used["loads"], *used["stages"]) for row in load.values()]
        assert page == "static" or page in [row.get("type") for row in rows]
        cases = re.findall(r"verification/(\w+)/case\.py", text(page))
        programs = "".join(path.read_text(encoding="utf-8") for case in cases for path in (ROOT / "tests/verification" / case).glob("*.py"))
        assert page == "static" or re.search(rf"\b{page}\b", programs), f"{page}: no case of the page has it"


def test_every_key_is_on_a_page_with_the_words_of_the_schema():
    """Rows of the table, which the program prints, and descriptions of the schema, which the program writes."""
    rows = {row for page in PAGES for row in topics.rows_of_page(page)}
    assert rows == set(topics.key_rows())
    of_types = {row for _, name in topics.types() for row in topics.rows_of_type(name)}
    assert of_types == {row for row in rows if row[0].startswith(("loads.", "stages."))}
    schema = topics.plain(json.dumps(json.loads((ROOT / "tools/quoin_tools/front/scene.schema.json").read_text(encoding="utf-8")), ensure_ascii=False))
    assert [row[0] for row in rows if json.dumps(row[4], ensure_ascii=False)[1:-1] not in schema and row[3] != "keys"] == []


def test_help_prints_the_page_and_its_keys():
    for page in ("silt", "trials", "run"):
        told = " ".join(topics.topic(page).split())
        first = " ".join(topics.plain(text(page).split("\n\n")[1]).split())
        assert first in told and all(row[0] in told for row in topics.rows_of_page(page))


@solver
@pytest.mark.parametrize("page", PAGES)
def test_the_scene_is_right(page, folder, capfd):
    folder(page)
    assert running.check(["scene.yaml"]) == 0, capfd.readouterr().err


@solver
@pytest.mark.parametrize("page", [page if page in SHORT else pytest.param(page, marks=pytest.mark.long) for page in PAGES])
def test_the_scene_runs(page, folder):
    """To the end of its last stage; a stage of trials finds its bracket, a pushover its path."""
    done = subprocess.run([QUOIN, "-options_file", "scene.yaml"], cwd=folder(page), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    output = Path(yaml.safe_load(scene(page)).get("output", "out"))
    stages = json.loads((output / "summary.json").read_text(encoding="utf-8"))["stages"]
    assert [stage["verdict"] for stage in stages if stage["verdict"] not in ("converged", "completed")] == []
