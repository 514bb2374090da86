#!/usr/bin/env python3
"""Coverage-guided fuzzing of what comes from outside: the YAML scene, the block mesh, the HDF5 file itself.

    cmake --preset fuzz && cmake --build build-fuzz -j
    tests/fuzz/run.py                     20 s each, from the corpus in tests/fuzz/corpus
    tests/fuzz/run.py --seconds 3600      a long one; what it finds new stays in build-fuzz/corpus for the next

Prints a line for each target: executions, coverage of the files that read input, findings. A finding is an input that
a sanitizer, a time of 25 s or an error other than "bad input" has stopped; it is written to build-fuzz/. Exit code 1
when there is one.
"""

import argparse
import json
import os
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
TARGETS = {"scene": 4096, "mesh": 1024, "hdf5": 16384}  # longest input [byte]


def dictionary(path):
    """Words of the scene language for the mutator: the keys and choices of the one table."""
    text = (HERE.parent.parent / "src" / "scene_keys.h").read_text(encoding="utf-8")
    words = sorted(set(re.findall(r'"([a-z_0-9]{2,24})"', text)) | {": ", "- ", "{", "}", "[", "]", "\\x0a  ", "1e308", "-1", "nan", "&a ", "*a"})
    path.write_text("".join(f'"{word}"\n' for word in words), encoding="utf-8")
    return path


def fuzz(name, build, seconds):
    """One target; its figures."""
    corpus = build / "corpus" / name
    corpus.mkdir(parents=True, exist_ok=True)
    before = set(build.glob(f"{name}-*"))
    environment = os.environ | {
        "QUOIN_FUZZ_MODEL": str(HERE / "corpus" / "hdf5" / "two_bodies.h5"),
        "ASAN_OPTIONS": "detect_leaks=0:allocator_may_return_null=1:handle_abort=1",
        "UBSAN_OPTIONS": "print_stacktrace=1",
        "OMPI_MCA_opal_signal": "11",  # aborts are for the sanitizer to report
        "OPENBLAS_NUM_THREADS": "1",
    }
    command = [build / "tests" / "fuzz" / f"fuzz_{name}", corpus, HERE / "corpus" / name, f"-max_total_time={seconds}",
               f"-max_len={TARGETS[name]}", "-timeout=25", "-rss_limit_mb=4096", "-print_final_stats=1",
               f"-artifact_prefix={build}/{name}-"]  # fmt: skip
    if name == "scene":
        command.append(f"-dict={dictionary(build / 'scene.dict')}")
    for left in pathlib.Path("/dev/shm").glob("quoin-fuzz-*"):  # noqa: S108 (fuzz.h writes there)
        left.unlink()
    log = subprocess.run([str(word) for word in command], env=environment, capture_output=True, text=True, errors="replace")
    (build / f"{name}.log").write_text(log.stderr, encoding="utf-8")
    counters = re.search(r"\((\d+) inline 8-bit counters\)", log.stderr)
    covered = re.findall(r"cov: (\d+)", log.stderr)
    runs = re.findall(r"^#(\d+)\s", log.stderr, re.MULTILINE)
    return {
        "target": name,
        "seconds": seconds,
        "executions": int(runs[-1]) if runs else 0,
        "edges_covered": int(covered[-1]) if covered else 0,
        "edges": int(counters[1]) if counters else 0,
        "findings": sorted(path.name for path in set(build.glob(f"{name}-*")) - before),
        "exit_code": log.returncode,
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("targets", nargs="*", default=list(TARGETS), help="scene, mesh, hdf5")
    parser.add_argument("--seconds", type=int, default=20, help="for each target")
    parser.add_argument("--build", type=pathlib.Path, default=HERE.parent.parent / "build-fuzz")
    parser.add_argument("--json", type=pathlib.Path, help="figures to this file")
    arguments = parser.parse_args()
    results = []
    for name in arguments.targets:
        result = fuzz(name, arguments.build.resolve(), arguments.seconds)
        results.append(result)
        print(f"{name:6s} {result['executions']:9d} executions, {result['edges_covered']:5d} of {result['edges']} edges, "
              f"findings: {', '.join(result['findings']) or 'none'}", flush=True)  # fmt: skip
    if arguments.json:
        arguments.json.write_text(json.dumps(results, indent=1), encoding="utf-8")
    failed = [result["target"] for result in results if result["findings"] or result["exit_code"] or not result["executions"]]
    if failed:
        print(f"failed: {', '.join(failed)}; see {arguments.build}/<target>.log", file=sys.stderr)
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
