"""The rooms of tools/quoin_tools: who may import whom, how long a module may be, and that its lists of rooms and modules are true."""

import ast
import graphlib
import re
from pathlib import Path

import pytest
from quoin_tools.front import main

ROOT = Path(__file__).resolve().parents[2]
HOUSE = ROOT / "tools" / "quoin_tools"
ROOMS = ("base", "mesh", "assess", "limit", "ensemble", "readings", "show", "front")  # from bottom to top: a room imports only itself and those before it
LONGEST = 500  # lines
MODULES = sorted(HOUSE.rglob("*.py"))


def name_of(path):
    parts = path.relative_to(HOUSE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


NAMES = {name_of(path) for path in MODULES}


def imports(source):
    """Modules of quoin_tools that a text imports, anywhere in it."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"line {node.lineno}: imports are written in full"
            inside = [f"{node.module}.{alias.name}" for alias in node.names]
            found.update(name if name in NAMES else node.module for name in inside)
    return {name for name in found if name.split(".")[0] == "quoin_tools"}


def faults(name, source):
    """What is wrong with the imports of a module of this name: upwards, or from outside the rooms."""
    parts, wrong = name.split("."), []
    for other in imports(source):
        room = other.split(".")[1] if other.count(".") else None
        if other == "quoin_tools" and parts[1:]:
            continue  # the version
        if room not in ROOMS or other not in NAMES:
            wrong.append(f"{name} imports {other}, which is in no room")
        elif parts[1] in ROOMS and ROOMS.index(room) > ROOMS.index(parts[1]):
            wrong.append(f"{name} imports {other}: upwards")
    return wrong


def listed(text, heading):
    """First words of the lines of a list in a docstring, which begins after the line with the heading."""
    block = text.split(heading, 1)[1].split("\n\n")[1]
    return sorted(line.split()[0] for line in block.splitlines())


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_imports_point_down(path):
    assert not faults(name_of(path), path.read_text(encoding="utf-8"))


def test_faults_are_found():
    """The check above sees what it is there for."""
    assert faults("quoin_tools.mesh.dam", "from quoin_tools.show import plots") == ["quoin_tools.mesh.dam imports quoin_tools.show.plots: upwards"]
    assert faults("quoin_tools.base.scene", "def late():\n    import quoin_tools.mesh.dam")
    assert faults("quoin_tools.show.report", "from quoin_tools.results import main")  # in no room
    assert not faults("quoin_tools.show.report", "import quoin_tools, os\nfrom quoin_tools.base.results import Results")


def test_no_circles():
    graph = {name_of(path): imports(path.read_text(encoding="utf-8")) - {name_of(path)} for path in MODULES}
    graphlib.TopologicalSorter(graph).prepare()  # raises CycleError


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_length(path):
    lines = len(path.read_text(encoding="utf-8").splitlines())
    assert lines <= LONGEST, f"{lines} lines: more than {LONGEST}"


def test_one_place_knows_legends_outside():
    """Matplotlib 3.6, which Debian 12 has, knows none: style.legend_below has an answer."""
    assert [path.name for path in MODULES if '"outside ' in path.read_text(encoding="utf-8")] == ["style.py"]


def test_every_folder_is_a_room():
    assert {path.name for path in HOUSE.iterdir() if path.is_dir()} - {"__pycache__", ".mypy_cache"} == set(ROOMS)


def test_lists_of_the_house():
    """`__init__.py` names every room, `__init__.py` of a room every module, each once."""
    text = ast.get_docstring(ast.parse((HOUSE / "__init__.py").read_text(encoding="utf-8")))
    assert listed(text, "Rooms,") == sorted(ROOMS)
    assert [room for room in re.findall(r"^(\w+)", text.split("Rooms,")[1], flags=re.M) if room in ROOMS] == list(ROOMS)
    for room in ROOMS:
        text = ast.get_docstring(ast.parse((HOUSE / room / "__init__.py").read_text(encoding="utf-8")))
        assert listed(text, text.splitlines()[0]) == sorted(path.stem for path in (HOUSE / room).glob("*.py") if path.stem != "__init__")


def test_no_module_outside_the_rooms():
    assert {path.stem for path in HOUSE.glob("*.py")} == {"__init__", "__main__"}


def test_commands_of_the_documents_exist():
    texts = [ROOT / "README.md", *ROOT.glob("docs/**/*.md"), *ROOT.glob("examples/**/*.md"), *ROOT.glob("tools/*.sh"), *ROOT.glob("src/**/*.c")]
    texts = {path: path.read_text(encoding="utf-8") for path in texts}
    named = {(path.name, name) for path, text in texts.items() for name in re.findall(r"(?:^ *|`|; )(?:quoin|python3? -m quoin_tools) ([a-z_]+)\b", text, flags=re.M)}
    assert len({name for _, name in named}) > 10 and not [pair for pair in named if pair[1] not in main.COMMANDS]
    assert not [path.name for path, text in texts.items() if re.search(r"-m\s+quoin_tools\.", text)]
