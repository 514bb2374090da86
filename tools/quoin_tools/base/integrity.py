"""Checks whether the files of an output folder are undamaged and belong together (docs/results_format.md, "Checksums").

quoin check FOLDER [...]    one line for each file; exit code 0: all are whole, 2: not
"""

import contextlib
import csv
import hashlib
import json
import os
import re
import zlib

import h5py

from quoin_tools.base.command import Parser

VERSION = 2  # of results.h5 and summary.json
HEADER = 512  # bytes of text before the HDF5 data of results.h5
TEXTS = {  # text before and after the CRC-32 of the data before it
    "summary.json": (b'  "crc32": "', b'"\n}\n'),
    "results.xdmf": (b"<!-- crc32 ", b" -->\n"),
}
SIGNATURE = re.compile(rb"<!-- sha256 of all before: ([0-9a-f]{64}) -->\n\Z")  # of a sheet
FILM = re.compile(r"animation_.*\.(gif|mp4)")  # names that the tools give
PNG = b"\x89PNG\r\n\x1a\n"


class ResultsError(ValueError):
    """A file is damaged; the message is one line."""


# errors of h5py, json, csv and numpy where the content of a file is wrong
UNREADABLE = (ArithmeticError, AttributeError, LookupError, MemoryError, OSError, RuntimeError, TypeError, ValueError, csv.Error)


@contextlib.contextmanager
def expecting(path, what):
    """Turns the errors of UNREADABLE into one line that names the file."""
    try:
        yield
    except ResultsError:
        raise
    except UNREADABLE as error:
        raise ResultsError(f"{path}: not {what} ({type(error).__name__}: {' '.join(str(error).split())})") from error


def crc32(file, size=None, chunk=1 << 20):
    """Returns the CRC-32 of the next size bytes (None: of all that follow), and their number."""
    crc = count = 0
    while size is None or count < size:
        data = file.read(chunk if size is None else min(chunk, size - count))
        if not data:
            break
        crc, count = zlib.crc32(data, crc), count + len(data)
    return crc, count


def check_results(path):
    """Raises ResultsError where results.h5 is damaged."""
    with open(path, "rb") as file:
        head = file.read(HEADER)
        found = re.fullmatch(rb"quoin-results\nbytes (\d+)\ncrc32 ([0-9a-f]{8})\n\0*", head)
        if not found or len(head) != HEADER:
            raise ResultsError(f"{path}: no results file of this version of Quoin, or its head is damaged")
        crc, count = crc32(file)
    if count != int(found[1]) or crc != int(found[2], 16):
        raise ResultsError(f"{path}: it is damaged: its {count} bytes are not the {int(found[1])} that were written")


def read_text(path):
    """Returns the text of summary.json or results.xdmf; raises ResultsError where it is damaged."""
    before, after = TEXTS[os.path.basename(path)]
    with open(path, "rb") as file:
        data = file.read()
    at = data.rfind(before)
    if at < 0 or data[at:] != before + b"%08x" % zlib.crc32(data[:at]) + after:
        raise ResultsError(f"{path}: it is damaged, or not of this version of Quoin: its checksum is wrong")
    return data.decode("utf-8", "replace")


def read_summary(path):
    """Reads summary.json as a dict."""
    with expecting(path, "a summary"):
        summary = json.loads(read_text(path))
        if summary["format"] != "quoin-summary" or summary["version"] != VERSION:
            raise ResultsError(f"{path}: format {summary['format']!r:.80}, version {summary['version']!r:.80}; this program reads {VERSION}")
    return summary


def check_history(path, summary, member="history"):
    """Raises ResultsError where a history lacks rows that it had when the summary was written; more rows may follow."""
    wanted = summary[member]
    with open(path, "rb") as file:
        crc, count = crc32(file, wanted["bytes"])
    if count != wanted["bytes"] or crc != int(wanted["crc32"], 16):
        raise ResultsError(f"{path}: it is damaged: its first {count} bytes are not the {wanted['bytes']} that summary.json names")


def sheet_is_whole(data):
    """Tells whether a sheet ends with the SHA-256 of the text before it."""
    found = SIGNATURE.search(data)
    return bool(found) and hashlib.sha256(data[: found.start()]).hexdigest() == found[1].decode()


def picture_is_whole(data):
    """Checks a PNG: each of its chunks has a CRC-32 of its own, the last one is IEND."""
    at, name = len(PNG), b""
    if not data.startswith(PNG):
        return False
    while name != b"IEND":
        size = int.from_bytes(data[at : at + 4], "big")
        name, crc = data[at + 4 : at + 8], data[at + 8 + size : at + 12 + size]
        if len(crc) < 4 or zlib.crc32(data[at + 4 : at + 8 + size]) != int.from_bytes(crc, "big"):
            return False
        at += 12 + size
    return at == len(data)


def signed_gif(data):
    """Returns a GIF with its CRC-32 as its last comment, which programs that show it skip."""
    body = data[:-1]
    return body + b"!\xfe\x0e" + b"crc32 %08x" % zlib.crc32(body) + b"\0;"


def signed_mp4(data):
    """Returns an MP4 with its CRC-32 in a last box of free space."""
    return data + b"\0\0\0\x16free" + b"crc32 %08x" % zlib.crc32(data)


def film_is_whole(data):
    """Checks the CRC-32 of a GIF or MP4 that a tool has signed."""
    for frame in (b"!\xfe\x0ecrc32 %08x\0;", b"\0\0\0\x16freecrc32 %08x"):
        size = len(frame % 0)
        if data[-size:] == frame % zlib.crc32(data[:-size]):
            return True
    return False


def check_made(folder):
    """Returns the paths of the files that the tools have made of the run; raises ResultsError at the first damaged one."""
    paths = []
    for name in sorted(os.listdir(folder)):
        is_whole = sheet_is_whole if name in ("report.html", "view.html") else picture_is_whole if name.endswith(".png") else None
        is_whole = film_is_whole if FILM.fullmatch(name) else is_whole
        if is_whole is None:
            continue
        paths.append(os.path.join(folder, name))
        with open(paths[-1], "rb") as file:
            if not is_whole(file.read()):
                raise ResultsError(f"{paths[-1]}: it is damaged: its checksum is wrong")
    return paths


# ---- files that belong together: results.h5, results.xdmf, summary.json and checkpoints of one run, with the same stages


def decoded(text):
    return text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text)


def stages_in(path):
    """Returns run, (name, verdict, cycles, checksum) of each stage of results.h5 in order, and the names of all its groups, frames too. Older programs wrote no checksum: None."""
    with expecting(path, "a complete results file"), h5py.File(path, "r") as file:
        found = {name: dict(group.attrs) for name, group in file["stages"].items()}
        run = f"{int(file.attrs['run']):016x}"
        names = sorted((n for n in found if not found[n].get("frame", 0)), key=lambda n: found[n]["index"])
        rows = [(n, decoded(found[n]["verdict"]), int(found[n]["cycles"]), decoded(found[n]["checksum"]) if "checksum" in found[n] else None) for n in names]
    return run, rows, set(found)


def check_stages(folder, summary):
    """Raises ResultsError where results.h5 and summary.json are not of one run, or do not have the same stages."""
    results, summary_path = os.path.join(folder, "results.h5"), os.path.join(folder, "summary.json")
    run, rows, _ = stages_in(results)
    with expecting(summary_path, "a summary"):
        if summary["run"] != run:
            raise ResultsError(f"{summary_path}: of another run than {results}: a run is on its way, or was ended between the two")
        lost, stages = summary.get("not_in_results", []), {stage["name"]: stage for stage in summary["stages"]}
        wanted, there = [name for name in stages if name not in lost], [row[0] for row in rows]
        for name in wanted:
            if name not in there:
                raise ResultsError(f"{results}: does not hold stage '{name}', which summary.json has")
        for name, verdict, cycles, checksum in rows:
            if name not in wanted:
                raise ResultsError(f"{results}: holds stage '{name}', which summary.json does not have: a run is on its way, or was ended between the two")
            stage = stages[name]
            if (verdict, cycles) != (stage["verdict"], stage["cycles"]) or checksum not in (None, stage.get("checksum")):
                raise ResultsError(f"{results}: stage '{name}' is of another run than that of summary.json")


def newest_checkpoint(folder):
    """Returns the path of the newest checkpoint; None: there is none."""
    names = os.listdir(folder) if os.path.isdir(folder) else []
    numbers = {int(found[1]): name for name in names if (found := re.fullmatch(r"checkpoint_(\d{1,9})\.h5", name))}
    return os.path.join(folder, numbers[max(numbers)]) if numbers else None


def read_checkpoint(path):
    """Returns run, and (name, checksum) of each completed stage of a checkpoint. Only its length is checked: the solver checks its checksum."""
    with open(path, "rb") as file:
        head = file.read(HEADER)
    found = re.match(rb"quoin-checkpoint \d+\nversion \S+\nbytes (\d+)\n", head)
    if not found or os.path.getsize(path) != HEADER + int(found[1]):
        raise ResultsError(f"{path}: it is damaged, or no checkpoint")
    with expecting(path, "a checkpoint"), h5py.File(path, "r") as file:
        counts = file["output/counts"][:].ravel()
        texts = [file[f"output/stage_{i}"][:].tobytes() for i in range(int(counts[0]))]
        stages = [json.loads(text) for text in texts if text]
        return f"{int(counts[5]) & (2**64 - 1):016x}", [(stage["name"], stage["checksum"]) for stage in stages]


def check_checkpoint(folder, summary):
    """Returns the newest checkpoint, None where there is none; raises ResultsError where it has completed more stages than the summary, or other ones."""
    path = newest_checkpoint(os.path.join(folder, "checkpoints"))
    if path is None:
        return None
    run, stages = read_checkpoint(path)
    if run != summary["run"]:
        raise ResultsError(f"{path}: of another run than {os.path.join(folder, 'summary.json')}: a run is on its way, or was ended before its first stage was written")
    known = [(stage["name"], stage["checksum"]) for stage in summary["stages"]]
    for k, stage in enumerate(stages):
        if k >= len(known) or known[k] != stage:
            raise ResultsError(f"{os.path.join(folder, 'summary.json')}: does not have stage '{stage[0]}' as {path} has it: files of several runs, or a file of before was put back")
    return path


def check_further(folder, summary):
    """Raises ResultsError where the newest checkpoint has completed a stage that results and summary lack. Another run may be writing into the folder."""
    path = newest_checkpoint(os.path.join(folder, "checkpoints"))
    try:
        run, stages = read_checkpoint(path) if path else (None, [])
    except (ResultsError, OSError):
        return  # a restart passes it over
    names = {stage["name"] for stage in summary["stages"]}
    for name, _ in stages if run == summary["run"] else ():
        if name not in names:
            raise ResultsError(f"{folder}: results.h5 and summary.json do not have stage '{name}', which {path} has: a file of before was put back")


def check_xdmf(folder, text):
    """Raises ResultsError where results.xdmf names other stages and frames than results.h5 holds."""
    path = os.path.join(folder, "results.xdmf")
    named = set(re.findall(r'\n    <Grid Name="([^"]*)" GridType="Collection" CollectionType="Spatial">', text))
    held = stages_in(os.path.join(folder, "results.h5"))[2]
    if named != held:
        raise ResultsError(f"{path}: names other stages or frames than results.h5 holds: {', '.join(sorted(named ^ held))}")


def check_folder(folder):
    """Returns lines about the files of an output folder; raises ResultsError or OSError at the first file that is damaged or does not belong to the others."""
    paths = {name: os.path.join(folder, name) for name in ("results.h5", "results.xdmf", "summary.json", "history.csv")}
    check_results(paths["results.h5"])
    xdmf = read_text(paths["results.xdmf"])
    summary = read_summary(paths["summary.json"])
    check_stages(folder, summary)
    check_xdmf(folder, xdmf)
    check_history(paths["history.csv"], summary)
    for member in ("joint_history", "anchor_history"):  # a run with a dynamic stage, with anchors
        if member in summary:
            paths[f"{member}.csv"] = os.path.join(folder, f"{member}.csv")
            check_history(paths[f"{member}.csv"], summary, member)
    lines = [f"{path}: whole, {os.path.getsize(path)} bytes" for path in (*paths.values(), *check_made(folder))]
    if lost := summary.get("not_in_results"):
        lines.append(f"{paths['results.h5']}: without {'stages' if len(lost) > 1 else 'stage'} {', '.join(map(str, lost))}: a restart had not found them")
    path = check_checkpoint(folder, summary)
    return [*lines, f"{path}: of this run"] if path else lines


def main(arguments=None):
    parser = Parser(prog="quoin check", description="Finds damaged files in output folders.")
    parser.add_argument("folders", nargs="+", metavar="FOLDER")
    for folder in parser.parse_args(arguments).folders:
        print("\n".join(check_folder(folder)))
    return 0
