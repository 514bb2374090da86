#!/usr/bin/env python3
"""Writes the small HDF5 files that fuzzing starts from into tests/fuzz/corpus: a checkpoint and results without their heads, with
little in them but what a restart asks for, and some that are wrong. A change of these formats needs new ones.
"""

import pathlib

import h5py
import numpy as np

CORPUS = pathlib.Path(__file__).parent / "corpus"
HEAD = 512  # bytes of text before the HDF5 part
OPTIONS = b"title two\nmodel model.h5\nrelaxation.ramp 11\nrelaxation.safety 0.8\n"


def checkpoint(path, **others):
    """others: entries with other contents, _of_ for slashes."""
    entries = {
        "mesh": np.zeros((1, 1), dtype="<i8"),
        "run/stage": np.ones((1, 1), dtype="<i8"),
        "run/last_reals": np.arange(16, dtype="<f8")[:, None],
        "run/last_counts": np.arange(7, dtype="<i8")[:, None],
        "run/last_evidence": np.frombuffer(b"ratio 1e-7", dtype=np.uint8)[:, None],
        "run/joints": np.frombuffer(b"default\n", dtype=np.uint8)[:, None],
        "run/options": np.frombuffer(OPTIONS, dtype=np.uint8)[:, None],
    }
    entries |= {name.replace("_of_", "/"): x for name, x in others.items() if name != "contents"}
    kinds = {"f": 0, "i": 1, "u": 2}
    lines = "".join(f"{name} {kinds[x.dtype.kind]} {x.shape[0]} {x.shape[1]}\n" for name, x in entries.items())
    with h5py.File(path, "w", libver="earliest") as file:
        file["contents"] = others.get("contents", np.frombuffer(lines.encode(), dtype=np.uint8)[:, None])
        for name, x in entries.items():
            file[name] = x


def declared(path):
    """A checkpoint with 2^40 numbers that are not there."""
    line = f"mesh 1 {1 << 40} 1\n"
    with h5py.File(path, "w", libver="earliest") as file:
        file["contents"] = np.frombuffer(line.encode(), dtype=np.uint8)[:, None]
        file.create_dataset("mesh", (1 << 40, 1), "<i8", chunks=(1024, 1))


def half(path):
    """A block mesh of which only some chunks are written."""
    path.write_bytes((CORPUS / "hdf5" / "two_bodies.h5").read_bytes())
    with h5py.File(path, "a") as file:
        del file["vertices"]
        file.create_dataset("vertices", (1 << 20, 2), "f8", chunks=(16, 2))[0] = 1.0


def results(path, run=1):
    whole = path.with_suffix(".h5")
    with h5py.File(whole, "w", libver="earliest", userblock_size=HEAD) as file:
        file.attrs["format"] = np.bytes_("quoin-results")
        file.attrs["run"] = np.uint64(run)
        for stage in ("rest", "push"):
            file.create_group(f"stages/{stage}").attrs["index"] = np.int32(0)
    path.write_bytes(whole.read_bytes()[HEAD:])
    whole.unlink()


def main():
    for name in ("checkpoint", "results"):
        (CORPUS / name).mkdir(parents=True, exist_ok=True)
    checkpoint(CORPUS / "checkpoint" / "two")
    results(CORPUS / "results" / "two")
    # what has crashed a reader once
    checkpoint(CORPUS / "checkpoint" / "options_without_lines", run_of_options=np.full((40, 1), ord("x"), dtype=np.uint8))
    checkpoint(CORPUS / "checkpoint" / "no_mesh", mesh=np.zeros((0, 1), dtype="<i8"))
    checkpoint(CORPUS / "checkpoint" / "contents_of_many_dimensions", contents=np.zeros((1,) * 32, dtype=np.uint8))
    declared(CORPUS / "checkpoint" / "declared")
    results(CORPUS / "results" / "many_runs", run=np.arange(200))
    half(CORPUS / "hdf5" / "half")


if __name__ == "__main__":
    main()
