#!/usr/bin/env python3
"""fuzz_python.py: the tools' readers of results.h5, summary.json, history.csv, model.h5 and scenes, by atheris. The first byte says
which; the rest is the file, with the checksums made to fit. Whatever the bytes: an answer, or the reader's own error in one line.
Run by tests/fuzz/run.py; needs `pip install --require-hashes -r tests/fuzz/requirements.txt` beside the packages of the tools.
"""

import atexit
import io
import os
import pathlib
import shutil
import sys
import zlib

import atheris

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
with atheris.instrument_imports(include=["quoin_tools"]):
    from quoin_tools.base import integrity, results, scene
    from quoin_tools.mesh import blockmesh

ERRORS = (results.ResultsError, blockmesh.MeshError, scene.SceneError)
FOLDER = pathlib.Path(f"/dev/shm/quoin-fuzz-{os.getpid()}")  # noqa: S108 (memory; removed by run.py where this process cannot)


def read_results(data):
    head = b"quoin-results\nbytes %d\ncrc32 %08x\n" % (len(data), zlib.crc32(data))
    (FOLDER / "results.h5").write_bytes(head.ljust(integrity.HEADER, b"\0") + data)
    run = results.Results(FOLDER)
    run.mesh.areas()
    for name in run.stages[:2]:
        stage = run.stage(name)
        len(stage.displacement), stage.contacts.on_b(), run.frames(name)


def write_summary(data):
    before, after = integrity.TEXTS["summary.json"]
    (FOLDER / "summary.json").write_bytes(data + before + b"%08x" % zlib.crc32(data) + after)


def read_summary(data):
    write_summary(data)
    integrity.read_summary(FOLDER / "summary.json")


def read_history(data):
    (FOLDER / "history.csv").write_bytes(data)
    results.read_history(FOLDER / "history.csv")


def read_mesh(data):
    (FOLDER / "model.h5").write_bytes(data)
    blockmesh.check(blockmesh.read(FOLDER / "model.h5"))


def read_scene(data):
    (FOLDER / "scene.yaml").write_bytes(data)
    read = scene.read(FOLDER / "scene.yaml")
    for stage in list(read.stages)[:3]:
        read.stage_loads(stage)
        for joint in list(read.joints)[:3]:
            read.joint(joint, stage)


READERS = (read_results, read_summary, read_history, read_mesh, read_scene)


def try_one(data):
    try:
        READERS[data[0] % len(READERS) if data else 0](data[1:])
    except ERRORS as error:
        if "\n" in str(error) or len(str(error)) < 8:
            raise RuntimeError("no line that says something") from error
        if "QUOIN_FUZZ_SAY" in os.environ:
            print(error)


def main():
    FOLDER.mkdir(mode=0o700)
    atexit.register(shutil.rmtree, FOLDER, ignore_errors=True)
    sys.stdout = sys.stdout if "QUOIN_FUZZ_SAY" in os.environ else io.StringIO()
    atheris.Setup(sys.argv, try_one)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
