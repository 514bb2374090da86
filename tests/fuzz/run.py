#!/usr/bin/env python3
"""Coverage-guided fuzzing of what comes from outside: scene, block mesh, files of motion, checkpoints, results.

    cmake --preset fuzz && cmake --build build-fuzz -j
    tests/fuzz/run.py                        20 s each
    tests/fuzz/run.py --hours 8              all night, the time shared by the targets; corpora minimised at the end
    tests/fuzz/run.py scene --runs 10000000  one target, so many executions
    tests/fuzz/run.py scene --input FILE     one input again, with what the reader says about it

It starts from tests/fuzz/corpus and from what earlier runs have left in build-fuzz/corpus. Prints a line for each target:
executions, executions a second, findings. A finding is an input that a sanitizer, a time of 10 s, memory of 3 GB or an error other
than "bad input" has stopped; it is kept in build-fuzz/findings, and the target goes on. Where the HDF5 library reads what is not its own, or
writes into its own memory beyond an end, the fault is that library's: kept in build-fuzz/library, and reported by the function it happened in. Exit code 1 when there is a
finding. build-fuzz/figures.json adds up the executions of all runs; --table writes them into docs/generated/fuzzing.md. --ship packs the
minimised corpora into tests/fuzz/corpus.
"""

import argparse
import collections
import concurrent.futures
import importlib.util
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
TARGETS = {"scene": 600, "motion": 256, "mesh": 1024, "hdf5": 16384, "checkpoint": 8192, "results": 8192,
           "scene_setup": 4096, "mesh_setup": 1024, "python": 16384}  # longest input [byte]  # fmt: skip
READERS = ("scene/*.c", "*/*_keys.c", "mesh/mesh_file.c", "mesh/hdf5.c", "mesh/check.c", "mesh/topology.c", "mesh/resolve.c", "boundary/motion.c", "boundary/support_motion.c", "archive/archive_file.c")
# HDF5 1.10 forgets memory when a file is damaged; a set-up that is refused leaves its memory to the end of the program
FORGET = ("hdf5", "checkpoint", "results", "scene_setup", "mesh_setup")
MOST_FINDINGS = 50  # of one run of a target
RUNTIME = re.compile(r"sanitizer|asan_|__asan|__interceptor|fuzzer::|libc\.so|nptl|sysdeps|/fuzzer|operator new| in (str|mem)\w+ |\bmalloc\b|\bfree\b|\bcalloc\b|\brealloc\b")


class Target:
    """A target with its folders."""

    def __init__(self, name, build):
        self.name, self.build = name, build
        self.corpus = build / "corpus" / name
        self.seeds = [folder for folder in (HERE / "corpus" / name.removesuffix("_setup"), build / "seeds" / name) if folder.is_dir()]
        self.command = [build / "tests" / "fuzz" / f"fuzz_{name}"] if name != "python" else [sys.executable, HERE / "fuzz_python.py"]

    def environment(self, profile="/dev/null"):
        return os.environ | {"LLVM_PROFILE_FILE": str(profile)} | ({"ASAN_OPTIONS": "detect_leaks=0"} if self.name in FORGET else {})

    def run(self, *words, folders=True):
        """stderr and exit code of one process."""
        command = [*self.command, *([self.corpus, *self.seeds] if folders else []), f"-max_len={TARGETS[self.name]}", *words]
        done = subprocess.run([str(word) for word in command], env=self.environment(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
        return done.stdout, done.returncode

    def minimise(self):
        """The smallest part of the corpus that reaches all that it reaches."""
        least = self.build / "least" / self.name
        shutil.rmtree(least, ignore_errors=True)
        least.mkdir(parents=True)
        self.run("-merge=1", least, self.corpus, *self.seeds, folders=False)
        if any(least.iterdir()):
            shutil.rmtree(self.corpus)
            least.rename(self.corpus)


def dictionary(target, path):
    """Words for the mutator: of numbers, and of the scene language the keys and choices of the one table."""
    text = (ROOT / "src" / "scene" / "keys.h").read_text(encoding="utf-8") if target.name != "motion" else ""
    more = {"\\x0a", ",", "# ", "t,x,y", "\\xef\\xbb\\xbf", "UNITS OF G\\x0a", "UNITS OF CM/S", "NPTS=", "DT=", " NPTS, DT\\x0a"} if target.name == "motion" else {": ", "- ", "{", "}", "[", "]", "\\x0a  ", "&a ", "*a"}
    words = sorted(set(re.findall(r'"([a-z_0-9]{2,24})"', text)) | more | {"1e308", "-1e308", "1e200", "-1", "nan", "inf", "0x1p9"})
    path.write_text("".join(f'"{word}"\n' for word in words), encoding="utf-8")
    return path


def frames(text):
    """Those of the first stack in a report that are not of the sanitizers or the C library."""
    stack = re.search(r"(?:^ +#\d+ .*\n)+", text, re.MULTILINE)
    return [line for line in stack[0].splitlines() if not RUNTIME.search(line)] if stack else []


def library(text):
    """The function of the HDF5 library in which that library went wrong by itself; None: it was not."""
    if "libhdf5" not in next(iter(frames(text)), ""):
        return None
    owner = text.partition("allocated by thread")[2]
    if "WRITE of size" in text and "libhdf5" not in next(iter(frames(owner)), ""):
        return None  # it wrote into memory that a reader has given it
    named = [re.search(r" in (H5(?!FL|MM|SL|AC|C_|E_)\w+)", line) for line in frames(text)]
    return next((name[1] for name in named if name), "H5")


def keep(target, path, text, found, ends):
    """One input that has stopped the target goes to the findings, or to what is the library's."""
    where = library(text)
    (target.corpus / path.name.rpartition("-")[2]).unlink(missing_ok=True)  # it would end every run at its start
    if not where and ("out-of-memory (used" in text or "-timeout-" in path.name) and not target.run(path, folders=False)[1]:
        path.unlink()  # alone it needs little: HDF5 has kept what damaged files made it take, or others have kept the processor
        return
    folder = target.build / ("library" if where else "findings")
    folder.mkdir(exist_ok=True)
    if where:
        ends[where] += 1
        path.replace(folder / f"{target.name}-{where}")
    else:
        found.append(path.replace(folder / path.name).name)
        (folder / f"{path.name}.log").write_text(text, encoding="utf-8")


def clean():
    """Files in memory of targets that were stopped."""
    for folder in pathlib.Path("/dev/shm").glob("quoin-fuzz-*"):  # noqa: S108 (fuzz.h writes there)
        if not pathlib.Path("/proc", folder.name.rpartition("-")[2]).exists():
            shutil.rmtree(folder, ignore_errors=True)


def fuzz(target, seconds, runs):
    """One target until its time or its executions are over; its figures."""
    target.corpus.mkdir(parents=True, exist_ok=True)
    start, done, found, ends = time.monotonic(), 0, [], collections.Counter()
    words = ["-timeout=10", "-rss_limit_mb=3000", "-malloc_limit_mb=1000000", "-print_funcs=0", "-print_final_stats=1", "-entropic=0"]
    if target.name.startswith("scene") or target.name == "motion":
        words.append(f"-dict={dictionary(target, target.build / f'{target.name}.dict')}")
    if target.name in FORGET:
        words.append("-detect_leaks=0")
    failed = False
    while not failed and len(found) < MOST_FINDINGS and time.monotonic() - start < seconds and done < runs:
        prefix = target.build / "stopped" / f"{target.name}-"
        prefix.parent.mkdir(exist_ok=True)
        left = max(1, int(seconds - (time.monotonic() - start)))
        text, code = target.run(f"-max_total_time={left}", f"-runs={min(runs - done, 2**31 - 1)}", f"-artifact_prefix={prefix}", *words)
        count = re.search(r"number_of_executed_units: (\d+)", text) or re.search(r"^Done (\d+) runs", text, re.MULTILINE)
        done += int(count[1]) if count else 0
        stopped = [path for path in prefix.parent.glob(f"{target.name}-*") if not path.name.startswith(f"{target.name}-slow")]
        for path in stopped:
            keep(target, path, text, found, ends)
        failed = not count or (code and not stopped)
        if failed:
            (target.build / f"{target.name}.log").write_text(text, encoding="utf-8")
        clean()
    return {"target": target.name, "seconds": round(time.monotonic() - start), "executions": done, "findings": found, "library": dict(ends), "failed": failed}


def unpack(name, build):
    """The packed corpus, when there is one."""
    packed, folder = HERE / "corpus" / f"{name.removesuffix('_setup')}.tar.xz", build / "seeds" / name
    if packed.exists():
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        with tarfile.open(packed) as file:
            for entry in file:
                (folder / pathlib.PurePath(entry.name).name).write_bytes(file.extractfile(entry).read())


def ship(target):
    """The minimised corpus as one file: the same bytes whenever it holds the same."""
    paths = sorted(target.corpus.iterdir(), key=lambda path: (path.stat().st_size, path.name))
    with tarfile.open(HERE / "corpus" / f"{target.name}.tar.xz", "w:xz") as file:
        for path in paths:
            entry = tarfile.TarInfo(path.name)
            entry.size = path.stat().st_size
            with path.open("rb") as data:
                file.addfile(entry, data)


def tool(name):
    """Of the LLVM that clang belongs to; None: it is not installed (Debian: llvm)."""
    return shutil.which(subprocess.run(["clang", f"-print-prog-name={name}"], capture_output=True, text=True, check=True).stdout.strip())


def coverage(targets, build):
    """Lines of the readers that the corpora of these targets reach: {file: [covered, all]}; {} without the tools."""
    profdata, cov = tool("llvm-profdata"), tool("llvm-cov")
    targets = [target for target in targets if target.name != "python"]
    if not profdata or not cov or not targets:
        return {}
    profiles = [build / f"{target.name}.profraw" for target in targets]
    for target, profile in zip(targets, profiles, strict=True):
        words = [*target.command, target.corpus, *target.seeds, "-runs=0", f"-max_len={TARGETS[target.name]}",
                 f"-artifact_prefix={build}/{target.name}-"]  # fmt: skip
        profile.unlink(missing_ok=True)
        subprocess.run([str(word) for word in words], env=target.environment(profile), capture_output=True)
    profiles = [profile for profile in profiles if profile.exists()]  # none where an input ends in a library
    merged = build / "readers.profdata"
    subprocess.run([profdata, "merge", "-sparse", *profiles, "-o", merged], check=True)
    sources = sorted(path for pattern in READERS for path in (ROOT / "src").glob(pattern))
    objects = [word for target in targets[1:] for word in ("-object", target.command[0])]
    report = subprocess.run([cov, "export", "-summary-only", f"-instr-profile={merged}", targets[0].command[0], *objects, *sources],
                            capture_output=True, text=True, check=True)  # fmt: skip
    names = {path.name for path in sources}  # without the headers
    lines = {pathlib.Path(file["filename"]).name: file["summary"]["lines"] for file in json.loads(report.stdout)["data"][0]["files"]}
    return {name: [count["covered"], count["count"]] for name, count in lines.items() if name in names}


def add_up(path, results, covered):
    """The figures of all runs since the corpus was begun."""
    known = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {"targets": {}}
    for result in results:
        total = known["targets"].setdefault(result["target"], {"seconds": 0, "executions": 0, "findings": 0, "library": {}})
        for key in ("seconds", "executions"):
            total[key] += result[key]
        total["findings"] += len(result["findings"])
        total["library"] = dict(collections.Counter(total["library"]) + collections.Counter(result["library"]))
    known["lines"] = covered or known.get("lines", {})
    path.write_text(json.dumps(known, indent=1), encoding="utf-8")
    return known


def table(path, known):
    """docs/generated/fuzzing.md."""
    rows = ["| target | executions | a second | findings | ends inside the HDF5 library |", "|---|---|---|---|---|"]
    for name, total in known["targets"].items():
        ends = ", ".join(f"{where} {times}" for where, times in sorted(total["library"].items())) or "-"
        rows.append(f"| {name} | {total['executions']} | {total['executions'] / max(1, total['seconds']):.0f} | {total['findings']} | {ends} |")
    if known["lines"]:
        some, every = (sum(counts[i] for counts in known["lines"].values()) for i in (0, 1))
        parts = ", ".join(f"{name} {100 * a / b:.0f} %" for name, (a, b) in sorted(known["lines"].items()))
        rows += ["", f"Lines of the readers that the inputs reach: {100 * some / every:.1f} % of {every} ({parts})."]
    version = re.search(r"^project\(quoin VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), flags=re.M).group(1)
    head = ["# Fuzzing", "", "Written by `tests/fuzz/run.py`; [reliability](../reliability.md#fuzzing) says how.",
            f"Version {version}, {time.strftime('%Y-%m-%d')}; files have the names of that day.", ""]  # fmt: skip
    path.write_text("\n".join([*head, *rows, ""]), encoding="utf-8")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("targets", nargs="*", default=[], metavar="target", help=", ".join(TARGETS))
    parser.add_argument("--seconds", type=float, help="for each target (20)")
    parser.add_argument("--hours", type=float, help="for all targets together")
    parser.add_argument("--runs", type=int, help="executions of each target")
    parser.add_argument("--jobs", type=int, default=1, help="targets side by side (%(default)s)")
    parser.add_argument("--input", type=pathlib.Path, help="an input to try again")
    parser.add_argument("--ship", action="store_true", help="pack the minimised corpora into tests/fuzz/corpus")
    parser.add_argument("--table", type=pathlib.Path, help="document to write the figures into")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build-fuzz")
    options = parser.parse_args()
    unknown = [name for name in options.targets if name not in TARGETS]
    if unknown:
        parser.error(f"no target {unknown[0]}: there are {', '.join(TARGETS)}")
    if not options.targets:
        options.targets = [name for name in TARGETS if name != "python" or all(map(importlib.util.find_spec, ("atheris", "h5py")))]
    if options.seconds is None:
        options.seconds = 20 if options.hours is None and options.runs is None else 3600 * options.hours / len(options.targets) if options.hours else 1e9
    return options


def main():
    options = arguments()
    build = options.build.resolve()
    for name in options.targets:
        unpack(name, build)
    targets = [Target(name, build) for name in options.targets]
    if options.input:
        return subprocess.run([*targets[0].command, options.input, f"-artifact_prefix={build}/again-"], env=targets[0].environment() | {"QUOIN_FUZZ_SAY": "1"}).returncode
    results = []
    pool = concurrent.futures.ThreadPoolExecutor(options.jobs)
    for target, result in zip(targets, pool.map(lambda target: fuzz(target, options.seconds, options.runs or 2**62), targets)):
        results.append(result)
        rate = result["executions"] / max(1, result["seconds"])
        ends = f"; ends inside HDF5: {sum(result['library'].values())}" if result["library"] else ""
        print(f"{target.name:11s} {result['executions']:9d} executions, {rate:6.0f} a second, findings: {', '.join(result['findings']) or 'none'}{ends}", flush=True)
        if options.hours or options.ship:
            target.minimise()
        if options.ship:
            ship(target)
    covered = coverage(targets, build)
    if covered:
        some, every = (sum(counts[i] for counts in covered.values()) for i in (0, 1))
        print(f"{some} of {every} lines of the readers reached ({100 * some / every:.1f} %)")
    known = add_up(build / "figures.json", results, covered)
    if options.table:
        table(options.table, known)
    bad = [result["target"] for result in results if result["findings"] or result["failed"] or not result["executions"]]
    if bad:
        print(f"failed: {', '.join(bad)}; see {build}/findings and {build}/<target>.log", file=sys.stderr)
    return int(bool(bad))


if __name__ == "__main__":
    sys.exit(main())
