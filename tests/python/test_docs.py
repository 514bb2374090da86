"""The documents against the source: functions that the documents name, versions of files.

    python tests/python/test_docs.py --thresholds    # writes the table of docs/static_stage.md from src/verdict/thresholds.h
    python tests/python/test_docs.py --guidelines    # writes docs/generated/guidelines.md from guidelines.yaml
    python tests/python/test_docs.py --keys          # writes docs/generated/keys.md from build/quoin -help"""

import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
SOURCES = {path.name: path for path in (ROOT / "src").rglob("*.[ch]")}
EQUATIONS = 41  # the paper's last one


def text(name):
    return (ROOT / name).read_text(encoding="utf-8")


def table_rows(name):
    """Cells of every row of every table, without headers' rules."""
    rows = [line for line in text(name).splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in rows if not set(row) <= set("|-: ")]


def named_functions(name):
    """(file, function) of every `file: function` in the text."""
    return sorted(set(re.findall(r"`([a-z_0-9]+\.[ch]):\s+([A-Za-z_0-9]+)`", text(name))))


def without_comments(source):
    return re.sub(r"/\*.*?\*/|//[^\n]*", "", source, flags=re.S)


@pytest.mark.parametrize("file, function", [pair for page in ("theory", "deviations", "design", "extend", "static_stage") for pair in named_functions(f"docs/{page}.md")])
def test_function_exists(file, function):
    """Defined: its name, arguments, and a body behind them."""
    assert file in SOURCES, f"src/ has no {file}"
    source = without_comments(SOURCES[file].read_text(encoding="utf-8"))
    assert re.search(rf"\b{function}\s*\([^;{{}}]*\)\s*\{{", source), f"{SOURCES[file]} does not define {function}"


def test_evidence_leads_to_its_line():
    """Each sentence of "Which line decided?" stands in the file of its row, and no file that sets a verdict of a static stage is left out."""
    page = text("docs/static_stage.md")
    rows = re.findall(r'^\| "([^"]+)".* \| (\w+) \| `(\w+\.c): \w+`', page, flags=re.M)
    assert len(rows) > 10
    for sentence, _, file in rows:
        source = re.sub(r'"\s*"', "", without_comments(SOURCES[file].read_text(encoding="utf-8")))
        missing = [words for words in sentence.split("...") if words.strip(" ,") not in source]
        assert not missing, f"{file} says nothing like {missing}"
    decided = {(file, verdict) for _, verdict, file in rows}
    judge = SOURCES["judge.c"].read_text(encoding="utf-8")
    conditions = re.findall(r"^\| [A-Z].*\. \| (`\w+`.*) \| (`[A-Z_]+`.*) \|$", page, flags=re.M)
    assert len(conditions) == 6
    for name in re.findall(r"`(\w+)`", " ".join(name for name, _ in conditions)):
        assert re.search(rf"\b{name}\b", judge), f"judge.c has no {name}"
    for name in re.findall(r"`(\w+)`", " ".join(names for _, names in conditions)):
        assert f"| `{name}` |" in page, f"docs/static_stage.md has no row of {name}"
    for path in (path for room in ("verdict", "solve") for path in (ROOT / "src" / room).glob("*.c")):
        for verdict in re.findall(r"verdict = VERDICT_(CONVERGED|COLLAPSED|DIVERGED|UNDECIDED)", path.read_text(encoding="utf-8")):
            assert (path.name, verdict.lower()) in decided, f"no row of docs/static_stage.md says that {path.name} decides {verdict}"


def thresholds():
    """The rows of docs/static_stage.md that src/verdict/thresholds.h makes: name, value, what it decides, why it has this value."""
    header = text("src/verdict/thresholds.h")
    rows = []
    for comment, line in re.findall(r"^/\* ((?:(?!\*/).)*?) \*/\n((?:static|enum) [^\n]+)$", header, flags=re.M | re.S):
        name, value = re.search(r"(\w+) = ([^;}]+?)(?: \})?;", line).groups()
        value = re.sub(r"\.(?!\d)", "", value)
        users = any(path.parent.name in ("verdict", "solve", "stages") and file != "thresholds.h" and re.search(rf"\b{name}\b", without_comments(path.read_text(encoding="utf-8"))) for file, path in SOURCES.items())
        what, why = " ".join(comment.split()).split(". ", 1)
        assert users, f"thresholds.h: nothing uses {name}"
        rows.append(f"| `{name}` | {value} | {what} | {why.removesuffix('.')} |")
    return rows


def with_thresholds(page):
    """The page with these rows in place of those below their heading."""
    head = "| name | value | it decides | why this value |\n|---|---|---|---|\n"
    before, after = page.split(head)
    return before + head + "\n".join(thresholds()) + "\n" + re.sub(r"^(\|[^\n]*\n)*", "", after)


HEAD_OF_LIMITS = """# The limits of guidelines, and where each stands

Written by `tests/python/test_docs.py` (`--guidelines`) from `tools/quoin_tools/assess/guidelines.yaml`. [Guidelines](../guidelines.md) says what the last column means and how to confirm a limit.
"""


def limits_of_guidelines():
    """The page docs/generated/guidelines.md: a table for each guideline."""
    sys.path.insert(0, str(ROOT / "tools"))
    from quoin_tools.assess import guidelines

    def of(value):
        return "to be filled in" if value is None else "; ".join(f"{choice}: {number}" for choice, number in value.items()) if isinstance(value, dict) else f"{value}"

    parts = [HEAD_OF_LIMITS]
    for name, guideline in guidelines.read().items():
        rows = [(f"{condition}, {plane}" if plane else condition, "sliding with partial factors" if limit.get("friction", 0) is None else guidelines.QUANTITIES[quantity][0].format(limit.get("friction", 0), limit.get("cohesion", 0)), of(None if limit.get("friction", 0) is None else limit["value"]), limit["place"], limit["read"] + (f" by {limit['quoted']}" if "quoted" in limit else ""))
                for plane, condition, limits in guidelines.tables(guideline) for quantity, limit in limits.items()]  # fmt: skip
        rows += [(where, *said_in_cracks(entry, of), entry["place"], entry["read"] + (f" by {entry['quoted']}" if "quoted" in entry else "")) for where, entry in guidelines.others(guideline)]
        rows += [("combination " + one["name"], one["loads"], ", ".join(one["conditions"]), one["place"], one["read"] + (f" by {one['quoted']}" if "quoted" in one else "")) for one in guideline.get("combinations") or ()]
        inputs = "".join(f"- `--given {key}={choice}`: {words}\n" for key, choices in guideline["inputs"].items() for choice, words in choices.items())
        parts.append(f"## {name}\n\n{guideline['title']}. Document: {guideline['document']}. {guideline['note']}\n\n" + inputs + "\n" * bool(inputs) + "| condition | limit of | limit | place | read |\n|---|---|---|---|---|\n" + "".join(f"| {' | '.join(row)} |\n" for row in rows))
    return "\n".join(parts)


def said_in_cracks(entry, of):
    """(words, value) of an entry of crack_start or in_crack."""
    if "pressure" in entry:
        return "part of the tensile strength f_t that counts; compression without uplift at least p w h less that", f"{entry['value']}; p {entry['pressure']['drained']} with drains, {entry['pressure']['undrained']} without"
    if "drains" in entry:
        return "uplift in the crack, and drains", f"{of(entry['value'])}; {entry['drains']}"
    return ("part of the tensile strength that the end of the base bears" if isinstance(entry["value"], (int, float)) else "in cracks"), of(entry["value"])


def test_limits_of_guidelines():
    assert text("docs/generated/guidelines.md") == limits_of_guidelines(), "python tests/python/test_docs.py --guidelines"


def test_thresholds_of_a_static_stage():
    """The keys of docs/static_stage.md stand in keys.h with the value of their row; all other rows are made from thresholds.h."""
    page = text("docs/static_stage.md")
    assert page == with_thresholds(page), "python tests/python/test_docs.py --thresholds"
    assert len(thresholds()) > 40
    keys = " ".join(without_comments(text("src/scene/keys.h")).split())
    rows = re.findall(r"^\| `(\w+)` \| ([\de.+-]+) \| [^`|]+ \| [^|]+ \|$", page[page.index("## All thresholds"):page.index("| name | value |")], flags=re.M)
    assert len(rows) == 6
    for name, value in rows:
        assert re.search(rf'KEY\((?:RELAXATION|STAGE_DEFAULTS), "{name}",[^"]*"{re.escape(value)}"', keys), f"keys.h: {name} is not {value}"


def test_thresholds_stand_in_one_place():
    """No file that decides has a number of its own: constants of src/verdict are in thresholds.h."""
    for path in (ROOT / "src/verdict").glob("*.c"):
        own = re.findall(r"^(?:static const PetscReal|#define) (\w+)", without_comments(path.read_text(encoding="utf-8")), flags=re.M)
        assert not own, f"{path.name}: {own}"


def test_every_equation_is_in_a_table():
    found = set()
    for row in table_rows("docs/theory.md"):
        found.update(int(number) for number in re.findall(r"\((\d+)\)", row[0]))
    missing = sorted(set(range(1, EQUATIONS + 1)) - found)
    assert not missing, f"docs/theory.md: no row for the equations {missing}"


def test_every_equation_row_names_a_function():
    rows = [row for row in table_rows("docs/theory.md") if len(row) == 4 and re.search(r"\(\d+\)|sect\.", row[0])]
    assert len(rows) > 20
    for row in rows:
        assert re.search(r"`[a-z_0-9]+\.[ch]: \w+`", row[2]), f"docs/theory.md: {row[0]}: names no function"


def test_deviations_are_explained():
    """Every letter in the last column of a table has its paragraph, and the other way round."""
    letters = set()
    for row in table_rows("docs/theory.md"):
        if len(row) == 4 and re.fullmatch(r"[a-z](, [a-z])*", row[3]):
            letters.update(row[3].split(", "))
    explained = set(re.findall(r"^\*\*([a-z])\. ", text("docs/deviations.md"), flags=re.M))
    assert letters == explained


@pytest.mark.parametrize("document", sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("examples/*/*.md")]),
                         ids=lambda path: str(path.relative_to(ROOT)))
def test_links_lead_somewhere(document):
    """Relative links and pictures of the documents; #place is a heading there."""
    for target, place in re.findall(r"\]\(([^)#]*)(?:#([^)]*))?\)", document.read_text(encoding="utf-8")):
        if not re.match(r"[a-z]+://", target):
            path = document.parent / target if target else document
            assert path.exists(), f"{document.name}: {target} does not exist"
            assert not place or place in places(path), f"{document.name}: {path.name} has no heading #{place}"


def test_every_picture_is_in_a_document_and_every_table_of_data_in_a_program():
    documents = "".join(path.read_text(encoding="utf-8") for path in (*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("examples/**/*.md")))
    assert [path.name for path in (ROOT / "docs" / "img").iterdir() if path.suffix != ".csv" and path.name not in documents] == []
    programs = "".join(path.read_text(encoding="utf-8") for path in ROOT.glob("tests/benchmark/*.py"))
    assert [path.name for path in (ROOT / "docs" / "data").iterdir() if path.name not in programs] == []


def places(path):
    """What headings of a document are linked by: small letters, hyphens for spaces."""
    headings = re.findall(r"^#+ (.*)$", path.read_text(encoding="utf-8"), flags=re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("table", sorted((ROOT / "docs" / "generated").glob("*.md")), ids=lambda path: path.name)
def test_generated_tables(table):
    """They name their programs and are linked from pages written by hand; a file of many tables, each of them."""
    programs = re.findall(r"[Ww]ritten by (?:the programs of )?`([\w/.]+)`", table.read_text(encoding="utf-8"))
    assert programs and (ROOT / programs[0]).exists()
    pages = "".join(path.read_text(encoding="utf-8") for path in ROOT.glob("docs/*.md"))
    assert f"(generated/{table.name}" in pages
    if table.name == "benchmarks.md":
        assert places(table) - {"tables-of-the-benchmarks"} == set(re.findall(rf"\(generated/{table.name}#([^)]*)\)", pages))


def test_verification_table_names_every_case():
    named = re.findall(r"^\| \[(\w+)\]", text("docs/generated/verification.md"), flags=re.M)
    cases = sorted(path.parent.name for path in ROOT.glob("tests/verification/*/case.py"))
    assert named == cases, "tests/verification/driver.py --all --record build/verification, then --tables build/verification"


def test_every_published_problem_has_its_scene_its_source_and_its_place_in_the_page():
    problems = yaml.safe_load(text("examples/published/problems.yaml"))
    page = text("docs/generated/beside.md")
    for name, about in problems.items():
        assert {"title", "kind", "source", "address", "read", "numbers"} <= set(about), name
        assert f"## {about['title']}\n" in page, f"docs/generated/beside.md has no {name}: tests/verification/driver.py --beside build/beside"
        scene = ROOT / "examples" / "published" / f"{name}.yaml"
        assert "scene" in about or len(scene.read_text(encoding="utf-8").splitlines()) <= 40, scene.name


def test_tables_of_faults_and_of_fuzzing_name_every_fault_and_target():
    faults = re.findall(r'^    return \("([^"]+)"', text("tests/reliability/faults.py"), flags=re.M)
    targets = re.findall(r'"(\w+)": \d+', re.search(r"TARGETS = \{.*?\}", text("tests/fuzz/run.py"), flags=re.S).group())
    assert len(faults) > 10 and len(targets) > 5
    for page, command, names in (("faults", "tests/reliability/run.py --table", faults), ("fuzzing", "tests/fuzz/run.py --table", targets)):
        missing = [name for name in names if f"| {name}" not in text(f"docs/generated/{page}.md")]
        assert not missing, f"docs/generated/{page}.md has no row of {missing}: {command}"


def test_one_command_makes_all_data_of_the_benchmarks():
    """tests/benchmark/all.py names every file of docs/data, once, and the program that writes it."""
    writes = runpy.run_path(str(ROOT / "tests/benchmark/all.py"))["WRITES"]
    assert sorted(file for files in writes.values() for file in files) == sorted(path.name for path in ROOT.glob("docs/data/*"))
    for name, files in writes.items():
        program = text(f"tests/benchmark/{name}.py")
        missing = [file for file in files if file not in program]
        assert not missing, f"tests/benchmark/{name}.py does not name {missing}"


def test_every_table_of_the_benchmarks_has_its_program():
    """Marks of docs/generated/benchmarks.md, each written by one program."""
    marks = re.findall(r"^<!-- (?!end )([\w ]+) -->$", text("docs/generated/benchmarks.md"), flags=re.M)
    programs = "".join(path.read_text(encoding="utf-8") for path in ROOT.glob("tests/benchmark/*.py"))
    assert len(marks) > 10 and [mark for mark in marks if f'"{mark}"' not in programs] == []


def test_verification_table_stays_as_it_is_when_written_anew():
    """No times, and no errors of rounding, which are others on each machine."""
    rows = [re.split(r" (?<!\\)\| ?", line) for line in text("docs/generated/verification.md").splitlines() if line.startswith("| [")]
    assert len(rows) > 70 and {len(row) for row in rows} == {8}
    for *_, nearest, end in rows:
        share = re.match(r"([\d.e+-]+) of \S+", nearest)
        assert end == "" and (nearest in ("equalities only", "all below 0.01 of their tolerance") or float(share[1]) >= 0.01), nearest


def test_pages_by_hand_have_no_tables_of_programs():
    for path in ROOT.glob("docs/*.md"):
        assert not re.search(r"^<!-- (end )?[\w ]+ -->$", path.read_text(encoding="utf-8"), flags=re.M), path.name


def source_versions():
    """Version of each kind of file, as the solver writes or asks for it."""
    places = {"model.h5": ("mesh_file.c", r"version != (\d+)\)"),
              "results.h5": ("results_file.c", r'Hdf5WriteCount\(file, "version", (\d+)\)'),
              "summary.json": ("summary.c", r'JsonNumber\(json, "version", (\d+)\)'),
              "checkpoint": ("archive_file.c", r"CHECKPOINT_FORMAT = (\d+)")}  # fmt: skip
    return {kind: int(re.search(pattern, SOURCES[file].read_text(encoding="utf-8")).group(1))
            for kind, (file, pattern) in places.items()}  # fmt: skip


def test_versions_of_files():
    rows = {re.match(r"`?([\w.]+)", row[0]).group(1): row for row in table_rows("docs/versions.md")[1:]}
    assert {kind: int(row[1]) for kind, row in rows.items()} == source_versions()
    headings = {"model.h5": "docs/mesh_format.md", "results.h5": "docs/results_format.md"}
    for kind, page in headings.items():
        assert f"`{kind}`, version {rows[kind][1]}" in text(page)


def test_versions_of_the_tools():
    """The tools read what the solver writes."""
    from quoin_tools.base import integrity
    from quoin_tools.mesh import blockmesh

    versions = source_versions()
    assert (blockmesh.VERSION, integrity.VERSION, integrity.VERSION) == tuple(
        versions[kind] for kind in ("model.h5", "results.h5", "summary.json"))  # fmt: skip


HEAD_OF_KEYS = """# The keys of a scene

Written by `tests/python/test_docs.py` (`--keys`) from `build/quoin -help`. `<name>` is a name of the user's choice (in `stages.<name>.joints.<name>` the second is that of a joint). [The scene](../scene.md) has a page for each section and type.
"""


def table_of_keys():
    """The page docs/generated/keys.md: a table for each section of the scene."""
    told = subprocess.run([QUOIN, "-help"], capture_output=True, text=True, check=True).stdout
    head, rule, *rows = [line for line in told.splitlines() if line.startswith("|")]
    parts: dict[str, list[str]] = {}
    for row in rows:
        words = re.match(r"\| `([^`]+)`", row)[1].split(".")
        parts.setdefault(words[0] if len(words) > 1 and words[0] != "what_if" else "run", []).append(row)
    return "\n".join([HEAD_OF_KEYS, *("\n".join([f"## {name}\n", head, rule, *of_it, ""]) for name, of_it in parts.items())])


@pytest.mark.skipif(not QUOIN.exists(), reason="the program is not built")
def test_keys_are_those_of_the_program():
    assert text("docs/generated/keys.md") == table_of_keys(), "python tests/python/test_docs.py --keys"


@pytest.mark.skipif(not QUOIN.exists(), reason="the program is not built")
def test_schema_is_that_of_the_table():
    name = "tools/quoin_tools/front/scene.schema.json"
    told = subprocess.run([QUOIN, "-schema"], capture_output=True, text=True, check=True).stdout
    assert told == text(name), f"keys have changed: build/quoin -schema > {name}"


def test_changelog_begins_with_what_is_new():
    assert re.search(r"^## (.*)$", text("CHANGELOG.md"), flags=re.M).group(1) == "[Unreleased]"


def test_names_of_the_glossary():
    """What its column "in code" names is in the source."""
    rows = [row for row in table_rows("docs/glossary.md") if len(row) == 4][1:]
    names = {name for row in rows for name in re.findall(r"`([^`]+)`", row[2])}
    assert len(names) > 30
    everything = "".join(path.read_text(encoding="utf-8") for path in SOURCES.values())
    for name in names:
        file, _, word = name.rpartition(": ")
        assert not file or file in SOURCES, f"docs/glossary.md: no file {file}"
        source = SOURCES[file].read_text(encoding="utf-8") if file else everything
        word = word.rstrip(".").split(".")[-1] if not word.endswith((".c", ".h")) else word
        assert word in SOURCES or word in source, f"docs/glossary.md: no {name} in the source"


if __name__ == "__main__":
    writes = {"--thresholds": ("docs/static_stage.md", lambda: with_thresholds(text("docs/static_stage.md"))), "--guidelines": ("docs/generated/guidelines.md", limits_of_guidelines),
              "--keys": ("docs/generated/keys.md", table_of_keys)}  # fmt: skip
    assert sys.argv[1:] in [[name] for name in writes], "test_docs.py --thresholds, --guidelines or --keys writes what the head of this file says"
    page, made = writes[sys.argv[1]]
    (ROOT / page).write_text(made(), encoding="utf-8")
