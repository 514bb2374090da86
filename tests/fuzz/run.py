#!/usr/bin/env python3
"""Coverage-guided fuzzing of what comes from outside: the YAML scene, the block mesh, the HDF5 file itself.

    cmake --preset fuzz && cmake --build build-fuzz -j
    tests/fuzz/run.py                     20 s each, from the corpus in tests/fuzz/corpus
    tests/fuzz/run.py --seconds 3600      a long one; what it finds new stays in build-fuzz/corpus for the next

Prints a line for each target: executions, findings; then how much of the files that read input the corpus covers. A
finding is an input that a sanitizer, a time of 25 s or an error other than "bad input" has stopped; it is written to
build-fuzz/. Exit code 1 when there is one. build-fuzz/figures.json adds up the executions of all runs since the corpus
was begun.
"""

import argparse
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
TARGETS = {"scene": 4096, "mesh": 1024, "hdf5": 16384}  # longest input [byte]
READERS = ("entries*.c", "scene*.c", "mesh*.c")


def dictionary(path):
    """Words of the scene language for the mutator: the keys and choices of the one table."""
    text = (HERE.parent.parent / "src" / "scene_keys.h").read_text(encoding="utf-8")
    words = sorted(set(re.findall(r'"([a-z_0-9]{2,24})"', text)) | {": ", "- ", "{", "}", "[", "]", "\\x0a  ", "1e308", "-1", "nan", "&a ", "*a"})
    path.write_text("".join(f'"{word}"\n' for word in words), encoding="utf-8")
    return path


def environment(profile):
    return os.environ | {
        "LLVM_PROFILE_FILE": str(profile),
        "QUOIN_FUZZ_MODEL": str(HERE / "corpus" / "hdf5" / "two_bodies.h5"),
        "ASAN_OPTIONS": f"detect_leaks=0:allocator_may_return_null=1:handle_abort=1:suppressions={HERE / 'asan.supp'}",
        "UBSAN_OPTIONS": "print_stacktrace=1",
        "OMPI_MCA_opal_signal": "11",  # aborts are for the sanitizer to report
        "OPENBLAS_NUM_THREADS": "1",
    }


def fuzz(name, build, seconds):
    """One target; its figures."""
    corpus = build / "corpus" / name
    corpus.mkdir(parents=True, exist_ok=True)
    before = set(build.glob(f"{name}-*"))
    command = [build / "tests" / "fuzz" / f"fuzz_{name}", corpus, HERE / "corpus" / name, f"-max_total_time={seconds}",
               f"-max_len={TARGETS[name]}", "-timeout=25", "-rss_limit_mb=4096", "-detect_leaks=0", "-print_funcs=0",
               f"-artifact_prefix={build}/{name}-"]  # fmt: skip
    if name == "scene":
        command.append(f"-dict={dictionary(build / 'scene.dict')}")
    for left in pathlib.Path("/dev/shm").glob("quoin-fuzz-*"):  # noqa: S108 (fuzz.h writes there)
        left.unlink()
    log = subprocess.run([str(word) for word in command], env=environment("/dev/null"), capture_output=True, text=True, errors="replace")
    (build / f"{name}.log").write_text(log.stderr, encoding="utf-8")
    runs = re.findall(r"^#(\d+)\s", log.stderr, re.MULTILINE)
    return {
        "target": name,
        "seconds": seconds,
        "executions": int(runs[-1]) if runs else 0,
        "findings": sorted(path.name for path in set(build.glob(f"{name}-*")) - before if "slow-unit" not in path.name),
        "exit_code": log.returncode,
    }


def tool(name):
    """Of the LLVM that clang belongs to; None: it is not installed (Debian: llvm)."""
    return shutil.which(subprocess.run(["clang", f"-print-prog-name={name}"], capture_output=True, text=True, check=True).stdout.strip())


def coverage(build):
    """Lines of the readers that the corpora of all targets reach: {file: [covered, all]}; {} without the tools."""
    profdata, cov = tool("llvm-profdata"), tool("llvm-cov")
    if not profdata or not cov:
        return {}
    programs = [build / "tests" / "fuzz" / f"fuzz_{name}" for name in TARGETS]
    profiles = [build / f"{name}.profraw" for name in TARGETS]
    for name, program, profile in zip(TARGETS, programs, profiles, strict=True):
        corpora = [folder for folder in (build / "corpus" / name, HERE / "corpus" / name) if folder.exists()]
        subprocess.run([program, "-runs=0", f"-max_len={TARGETS[name]}", f"-artifact_prefix={build}/{name}-", *corpora], env=environment(profile), capture_output=True, check=True)
    merged = build / "readers.profdata"
    subprocess.run([profdata, "merge", "-sparse", *profiles, "-o", merged], check=True)
    sources = sorted(path for pattern in READERS for path in (HERE.parent.parent / "src").glob(pattern))
    objects = [word for program in programs[1:] for word in ("-object", program)]
    report = subprocess.run([cov, "export", "-summary-only", f"-instr-profile={merged}", programs[0], *objects, *sources],
                            capture_output=True, text=True, check=True)  # fmt: skip
    files = json.loads(report.stdout)["data"][0]["files"]
    names = {path.name for path in sources}  # without the headers
    lines = {pathlib.Path(file["filename"]).name: file["summary"]["lines"] for file in files}
    return {name: [count["covered"], count["count"]] for name, count in lines.items() if name in names}


def add_up(path, results, covered):
    """The figures of all runs since the corpus was begun."""
    known = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {"targets": {}}
    for result in results:
        total = known["targets"].setdefault(result["target"], {"seconds": 0, "executions": 0, "findings": 0})
        total["seconds"] += result["seconds"]
        total["executions"] += result["executions"]
        total["findings"] += len(result["findings"])
    known["lines"] = covered
    path.write_text(json.dumps(known, indent=1), encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("targets", nargs="*", default=list(TARGETS), help="scene, mesh, hdf5")
    parser.add_argument("--seconds", type=int, default=20, help="for each target")
    parser.add_argument("--build", type=pathlib.Path, default=HERE.parent.parent / "build-fuzz")
    arguments = parser.parse_args()
    results = []
    for name in arguments.targets:
        result = fuzz(name, arguments.build.resolve(), arguments.seconds)
        results.append(result)
        print(f"{name:6s} {result['executions']:9d} executions, findings: {', '.join(result['findings']) or 'none'}", flush=True)
    covered = coverage(arguments.build.resolve())
    if covered:
        some, every = (sum(counts[i] for counts in covered.values()) for i in (0, 1))
        print(f"{some} of {every} lines of the readers reached ({100 * some / every:.1f} %)")
    add_up(arguments.build / "figures.json", results, covered)
    failed = [result["target"] for result in results if result["findings"] or result["exit_code"] or not result["executions"]]
    if failed:
        print(f"failed: {', '.join(failed)}; see {arguments.build}/<target>.log", file=sys.stderr)
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
