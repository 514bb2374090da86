"""Files of an output folder that a test has changed, with checksums that fit again."""

import json
import zlib

from quoin_tools.base.whole import HEADER, TEXTS, VERSION


def write_summary(folder, summary):
    """summary.json from a dict; a checksum of before is renewed, format and version are added."""
    summary = {"format": "quoin-summary", "version": VERSION} | summary
    text = json.dumps({name: value for name, value in summary.items() if name != "crc32"}).encode()[:-1] + b",\n"
    before, after = TEXTS["summary.json"]
    (folder / "summary.json").write_bytes(text + before + b"%08x" % zlib.crc32(text) + after)


def read_summary(folder):
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


def seal_results(path):
    """results.h5, made with a user block of HEADER bytes."""
    data = path.read_bytes()[HEADER:]
    head = b"quoin-results\nbytes %d\ncrc32 %08x\n" % (len(data), zlib.crc32(data))
    path.write_bytes(head.ljust(HEADER, b"\0") + data)


def history_member(data):
    """What the summary says of history.csv with these bytes."""
    return {"bytes": len(data), "crc32": f"{zlib.crc32(data):08x}"}
