"""The JSON Schema of the scene: a validator judges by it as the solver does. That it is that of the table: test_docs.py."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from bad_input import catalogue
from jsonschema import Draft7Validator

ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
SCHEMA = ROOT / "tools/quoin_tools/front/scene.schema.json"
solver = pytest.mark.skipif(not QUOIN.exists(), reason="needs the solver")
validator = Draft7Validator(json.loads(SCHEMA.read_text(encoding="utf-8")))


class Loader(yaml.CSafeLoader):
    """Values as YAML 1.2 has them, and editors: 10e9 is a number, yes a word."""


Loader.yaml_implicit_resolvers = {}
for tag, pattern in (("bool", "true|True|TRUE|false|False|FALSE"), ("null", "~|null|Null|NULL|"), ("int", "[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+"),
                     ("float", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")):  # fmt: skip
    Loader.add_implicit_resolver(f"tag:yaml.org,2002:{tag}", re.compile(f"^(?:{pattern})$"), None)
Loader.add_constructor("tag:yaml.org,2002:float", lambda loader, node: float(node.value.lower().replace(".inf", "inf").replace(".nan", "nan")))
Loader.flatten_mapping = lambda self, node: None


def faults(text):
    return [f"{'.'.join(map(str, error.path))}: {error.message[:200]}" for error in validator.iter_errors(yaml.load(text, Loader))]  # noqa: S506


def scenes():
    found = [path for folder in ("examples", "tools/quoin_tools/front") for path in sorted((ROOT / folder).rglob("*.yaml"))]
    return [path for path in found if re.search(r"^stages:", text := path.read_text(encoding="utf-8"), re.M) and re.search(r"^model:", text, re.M)]


def test_it_is_a_schema():
    Draft7Validator.check_schema(validator.schema)


@pytest.mark.parametrize("path", scenes(), ids=lambda path: str(path.relative_to(ROOT)))
def test_examples_are_good(path):
    assert faults(re.sub(r"@\w+@", "1", path.read_text(encoding="utf-8"))) == []  # in the scene of quoin new words stand for values


def test_scenes_of_the_documents_are_good():
    pages = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "docs").glob("**/*.md"))
    whole = [text for text in re.findall(r"```yaml\n(.*?)```", pages, re.S) if re.search(r"^model:", text, re.M) and re.search(r"^stages:", text, re.M)]
    whole = [text for text in whole if "type: backfill" not in text]  # the load that the tutorial on C adds
    assert len(whole) > 40
    assert [faults(text) for text in whole] == [[]] * len(whole)


MERE = re.compile(r"unknown key|is not one of: |out of range: must be|is not a number|is not a whole number|neither true nor false|does not belong to a |a single value expected"
                  r"|a value expected, not keys|keys below it expected|two numbers expected|has another unit|it has no unit|takes no unit|: missing( \[[^]]*\])?$|no value given"
                  r"|is not a name|' twice$|too large for a number|longer than|the list is empty|a list must hold plain|names with keys below them")  # fmt: skip
# what joins keys, though it sounds the same: joints that stages name, keys that another row of joints may have, loads of a stage;
# numbers to the base 16, which YAML has read before the schema sees them; and numbers that are too large with their unit, which it does not compute
JOINED = re.compile(r"joints\.\w+: unknown key|joints\.\w+\.\w+: missing|(raises|pushes): the list is empty|'0x10' is not a number|1e10002 is too large")


def entries():
    """(what, scene, message) of each fault of scene_faults.py that stands in the scene itself."""
    messages = catalogue.messages()
    for what, scene, options in catalogue.scene_faults():
        if not options:
            yield what, scene, messages[catalogue.cell(what)]


def test_faults_of_one_key_are_refused_and_others_are_not():
    wrong, counted = [], [0, 0]
    assert faults(catalogue.good_scene()) == []
    for what, scene, message in entries():
        try:
            found = faults(scene)
        except yaml.YAMLError:
            continue
        mere = bool(MERE.search(message)) and not JOINED.search(message)
        counted[mere] += 1
        if mere != bool(found):
            wrong.append(f"{what}\n    solver: {message}\n    schema: {found[:2]}")
    assert not wrong, "\n".join(wrong)
    assert min(counted) > 50, counted


def test_values_of_every_kind():
    good = catalogue.good_scene()
    for key, values in {"thickness": ["0.5", "2", "1e0", "'3'", "150 cm", "1e3mm"], "gravity": ["0", "981 cm/s2", "1 g"], "title": ["5", "no", "x: 1".replace(":", "")]}.items():
        for value in values:
            text = re.sub(rf"^{key}:.*$", "", good, flags=re.M) + f"\n{key}: {value}\n"
            assert faults(text) == [], value
    for key, values in {"thickness": ["0", "-1", "-2 m", "3 kg", "m", ".inf", "[1]", "1e400", "{a: 1}"], "gravity": ["-1"], "plane": ["stres", "1"], "sttages": ["1"]}.items():
        for value in values:
            text = re.sub(rf"^{key}:.*$", "", good, flags=re.M) + f"\n{key}: {value}\n"
            assert faults(text) != [], value


@solver
def test_what_a_run_writes_down_is_good(tmp_path):
    """Every key in force, defaults among them."""
    (tmp_path / "scene.yaml").write_text(catalogue.WATER, encoding="utf-8")
    catalogue.write(str(tmp_path / "model.h5"), catalogue.water_mesh())
    subprocess.run([QUOIN, "-options_file", "scene.yaml"], cwd=tmp_path, capture_output=True, check=False)
    echo = (tmp_path / "out/scene_echo.yaml").read_text(encoding="utf-8")
    assert faults(echo) == [] and "flow: true" in echo


@solver
def test_the_command_writes_it(tmp_path):
    command = [sys.executable, ROOT / "tools/quoin.py", "help", "--schema"]
    subprocess.run([*command, "mine.json"], cwd=tmp_path, env=os.environ | {"QUOIN_SOLVER": str(QUOIN)}, check=True)
    assert (tmp_path / "mine.json").read_bytes() == SCHEMA.read_bytes()
    assert subprocess.run(command, capture_output=True, check=True).stdout == SCHEMA.read_bytes()
