"""Whether the files of an output folder are what the run has written (docs/results_format.md, "Checksums").

quoin whole FOLDER [...]    one line a file; exit code 0: all are whole, 2: not
"""

import contextlib
import csv
import hashlib
import json
import os
import re
import zlib

from quoin_tools.base.command import Parser

VERSION = 2  # of results.h5 and summary.json
HEADER = 512  # bytes of text before the HDF5 data of results.h5
TEXTS = {  # what stands before and after the CRC-32 of all that is before it
    "summary.json": (b'  "crc32": "', b'"\n}\n'),
    "results.xdmf": (b"<!-- crc32 ", b" -->\n"),
}
SIGNATURE = re.compile(rb"<!-- sha256 of all before: ([0-9a-f]{64}) -->\n\Z")  # of a sheet
FILM = re.compile(r"animation_.*\.(gif|mp4)")  # names that the tools give
PNG = b"\x89PNG\r\n\x1a\n"


class ResultsError(ValueError):
    """What is wrong with a file, in one line."""


# what h5py, json, csv and numpy raise where a file does not hold what it should
UNREADABLE = (ArithmeticError, AttributeError, LookupError, MemoryError, OSError, RuntimeError, TypeError, ValueError, csv.Error)


@contextlib.contextmanager
def expecting(path, what):
    """In place of UNREADABLE, one line that says so."""
    try:
        yield
    except ResultsError:
        raise
    except UNREADABLE as error:
        raise ResultsError(f"{path}: not {what} ({type(error).__name__}: {' '.join(str(error).split())})") from error


def crc32(file, size=None, chunk=1 << 20):
    """CRC-32 of the next size bytes (None: all that follow), and how many there were."""
    crc = count = 0
    while size is None or count < size:
        data = file.read(chunk if size is None else min(chunk, size - count))
        if not data:
            break
        crc, count = zlib.crc32(data, crc), count + len(data)
    return crc, count


def check_results(path):
    """Raises ResultsError where results.h5 is not whole."""
    with open(path, "rb") as file:
        head = file.read(HEADER)
        found = re.fullmatch(rb"quoin-results\nbytes (\d+)\ncrc32 ([0-9a-f]{8})\n\0*", head)
        if not found or len(head) != HEADER:
            raise ResultsError(f"{path}: no results file of this version of Quoin, or its head is damaged")
        crc, count = crc32(file)
    if count != int(found[1]) or crc != int(found[2], 16):
        raise ResultsError(f"{path}: it is damaged: its {count} bytes are not the {int(found[1])} that were written")


def read_text(path):
    """Text of summary.json or results.xdmf; raises ResultsError where it is not whole."""
    before, after = TEXTS[os.path.basename(path)]
    with open(path, "rb") as file:
        data = file.read()
    at = data.rfind(before)
    if at < 0 or data[at:] != before + b"%08x" % zlib.crc32(data[:at]) + after:
        raise ResultsError(f"{path}: it is damaged, or not of this version of Quoin: its checksum is wrong")
    return data.decode("utf-8", "replace")


def read_summary(path):
    """summary.json as a dict."""
    with expecting(path, "a summary"):
        summary = json.loads(read_text(path))
        if summary["format"] != "quoin-summary" or summary["version"] != VERSION:
            raise ResultsError(f"{path}: format {summary['format']!r:.80}, version {summary['version']!r:.80}; this program reads {VERSION}")
    return summary


def check_history(path, summary, member="history"):
    """Raises ResultsError where a history has not the rows that it had when the summary was written; more may follow."""
    wanted = summary[member]
    with open(path, "rb") as file:
        crc, count = crc32(file, wanted["bytes"])
    if count != wanted["bytes"] or crc != int(wanted["crc32"], 16):
        raise ResultsError(f"{path}: it is damaged: its first {count} bytes are not the {wanted['bytes']} that summary.json names")


def sheet_is_whole(data):
    """Whether it ends with the SHA-256 of what is before."""
    found = SIGNATURE.search(data)
    return bool(found) and hashlib.sha256(data[: found.start()]).hexdigest() == found[1].decode()


def picture_is_whole(data):
    """A PNG: each of its chunks has a CRC-32 of its own, the last one is IEND."""
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
    """A film with its CRC-32 as its last comment, which programs that show it pass over."""
    body = data[:-1]
    return body + b"!\xfe\x0e" + b"crc32 %08x" % zlib.crc32(body) + b"\0;"


def signed_mp4(data):
    """The same in a last box of free space."""
    return data + b"\0\0\0\x16free" + b"crc32 %08x" % zlib.crc32(data)


def film_is_whole(data):
    """A GIF or MP4 that a tool has signed."""
    for frame in (b"!\xfe\x0ecrc32 %08x\0;", b"\0\0\0\x16freecrc32 %08x"):
        size = len(frame % 0)
        if data[-size:] == frame % zlib.crc32(data[:-size]):
            return True
    return False


def check_made(folder):
    """Paths of what the tools have made of the run; raises ResultsError at the first that is not whole."""
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


def check_folder(folder):
    """Lines about the files of an output folder; raises ResultsError or OSError at the first that is not whole."""
    paths = {name: os.path.join(folder, name) for name in ("results.h5", "results.xdmf", "summary.json", "history.csv")}
    check_results(paths["results.h5"])
    read_text(paths["results.xdmf"])
    summary = read_summary(paths["summary.json"])
    check_history(paths["history.csv"], summary)
    for member in ("joint_history", "anchor_history"):  # a run with a dynamic stage, with anchors
        if member in summary:
            paths[f"{member}.csv"] = os.path.join(folder, f"{member}.csv")
            check_history(paths[f"{member}.csv"], summary, member)
    return [f"{path}: whole, {os.path.getsize(path)} bytes" for path in (*paths.values(), *check_made(folder))]


def main(arguments=None):
    parser = Parser(prog="quoin whole", description="Are the files of output folders what was written?")
    parser.add_argument("folders", nargs="+", metavar="FOLDER")
    for folder in parser.parse_args(arguments).folders:
        print("\n".join(check_folder(folder)))
    return 0
