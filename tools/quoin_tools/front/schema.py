"""Writes the JSON Schema of the scene, by which editors complete and check (scene.schema.json, as the solver's -schema prints it)."""

from importlib import resources
from pathlib import Path

from quoin_tools.base.command import Parser
from quoin_tools.base.files import write_file

DESCRIPTION = """The JSON Schema of the scene: an editor that knows it completes keys, says what they mean and marks what is wrong. For VS Code with its
extension YAML: write it beside the scene, and `# yaml-language-server: $schema=scene.schema.json` into the first line of the scene."""


def main(words):
    parser = Parser(prog="quoin help --schema", description=DESCRIPTION)
    parser.add_argument("file", nargs="?", metavar="FILE", help="such as scene.schema.json; none: to the terminal")
    file = parser.parse_args(words).file
    text = resources.files("quoin_tools.front").joinpath("scene.schema.json").read_text(encoding="utf-8")
    if file is None:
        print(text, end="")
    else:
        write_file(file, text)
        print(f"wrote {file}; first line of a scene beside it: # yaml-language-server: $schema={Path(file).name}")
