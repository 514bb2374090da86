"""Checks that a sheet is unchanged, and that it is about these files: compares their SHA-256.

    quoin report --verify out/report.html out [--program build/quoin]

One line for each file. Exit code 0: all are those of the sheet; 1: one is not, or is missing; 2: the sheet or the folder cannot be read.
"""

import hashlib
import os
import re

from quoin_tools.assess import guidelines
from quoin_tools.base import scene
from quoin_tools.base.command import Parser
from quoin_tools.base.integrity import crc32, sheet_is_whole
from quoin_tools.base.language import N_
from quoin_tools.base.results import Results, ResultsError

ROW = re.compile(r"<td>([\w. ]+)</td><td(?: class=\"long\")?>([^<]*)</td><td(?: class=\"long\")?>([0-9a-f]{64}|CRC-32 [0-9a-f]{8})</td>")


def digest(path):
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def signed(text):
    """The sheet with its own SHA-256 behind it."""
    return text + f"<!-- sha256 of all before: {hashlib.sha256(text.encode('utf-8')).hexdigest()} -->\n"


def rows_of(results, scene_path, mesh_path, limits=None):
    """Returns (what, name, hash) of every file and program behind the numbers of a sheet. limits: the file of guidelines of the user."""
    summary = results.summary
    files = [("results.h5", results.path), ("summary.json", os.path.join(results.folder, "summary.json")), (N_("scene"), scene_path),
             (N_("mesh"), mesh_path), (N_("guidelines"), guidelines.PATH)]  # fmt: skip
    rows = [(what, os.path.basename(path), digest(path)) for what, path in files]
    own = [(N_("own guidelines"), os.path.basename(limits), digest(limits))] if limits else []
    return [*rows, (N_("program"), f"Quoin {summary['quoin']}", f"CRC-32 {summary['program']}"), *own]


def rows_there(folder, limits=None):
    """Computes the same rows from the files of today."""
    results = Results(folder)
    summary = results.summary
    used = scene.of_run(folder, summary)
    mesh = scene.find(folder, summary.get("model"), ("model.h5",))
    if mesh is None:
        raise ResultsError(f"{folder}: the mesh of the run, '{summary.get('model')}', is not there")
    return rows_of(results, used.path, mesh, limits or scene.find(folder, used.guidelines))


def verify(sheet, folder, program=None, limits=None):
    """Lines, and whether all is as it was."""
    with open(sheet, "rb") as file:
        data = file.read()
    good = sheet_is_whole(data)
    lines = [f"sheet {os.path.basename(sheet)}: {'as it was written' if good else 'CHANGED since it was written, or cut off'}"]
    there = rows_there(folder, limits)
    values = [value for _, _, value in ROW.findall(data.decode("utf-8", "replace"))]  # in the same order, whatever the language
    wanted = {what: value for (what, _, _), value in zip(there, values)}
    for what, name, value in there:
        same = wanted.get(what) == value
        good &= same
        lines.append(f"{what} {name}: {'that of the sheet' if same else 'ANOTHER than that of the sheet'}")
    if len(values) > len(there):
        good = False
        lines.append("own guidelines: not looked at; --guidelines names the file")
    if program:
        with open(program, "rb") as file:
            same = wanted.get("program") == f"CRC-32 {crc32(file)[0]:08x}"
        good &= same
        lines.append(f"program {program}: {'that of the run' if same else 'ANOTHER than that of the run'}")
    return lines, good


def main(arguments=None):
    parser = Parser(prog="quoin report --verify", description="Is a sheet as it was written, and about these files?")
    parser.add_argument("sheet", help="report.html")
    parser.add_argument("folder", help="output folder of the run")
    parser.add_argument("--guidelines", help="the file of guidelines of the user, where the sheet names one")
    parser.add_argument("--program", help="the solver, to be held against the one that ran")
    given = parser.parse_args(arguments)
    lines, good = verify(given.sheet, given.folder, given.program, given.guidelines)
    print("\n".join(lines))
    return 0 if good else 1
