"""Files of an output folder that a test has changed, with checksums that fit again."""

import json
import zlib

import h5py
import numpy as np
from quoin_tools.base.integrity import HEADER, TEXTS, VERSION


def write_summary(folder, summary):
    """summary.json from a dict; a checksum of before is renewed, format and version are added."""
    summary = {"format": "quoin-summary", "version": VERSION} | summary
    text = json.dumps({name: value for name, value in summary.items() if name != "crc32"}).encode()[:-1] + b",\n"
    before, after = TEXTS["summary.json"]
    (folder / "summary.json").write_bytes(text + before + b"%08x" % zlib.crc32(text) + after)
    if (folder / "results.h5").exists() and "stages" in summary:
        say_the_same(folder / "results.h5", summary["stages"])


def say_the_same(path, stages):
    """Gives stages of results.h5 the verdict, cycles and checksum of the summary, by which the tools hold the two against each other."""
    changed = False
    with h5py.File(path, "r+") as file:
        for stage in stages:
            attributes = file["stages"][stage["name"]].attrs if stage["name"] in file["stages"] else {}
            for key in ("verdict", "cycles", "checksum"):
                if key in attributes and key in stage and attributes[key] != (np.bytes_(stage[key]) if key != "cycles" else stage[key]):
                    attributes[key] = np.bytes_(stage[key]) if key != "cycles" else stage[key]
                    changed = True
    if changed:
        seal_results(path)


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
