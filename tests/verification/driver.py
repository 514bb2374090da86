"""Run verification cases: tests/verification/<case>/case.py compares the solver with closed forms and references.

    python tests/verification/driver.py patch stack --quoin build/quoin
    python tests/verification/driver.py bending --keep out/        # leave folders of the runs there
    python tests/verification/driver.py --all --record build/verification       # every case; what it found stays in this folder
    python tests/verification/driver.py --tables build/verification             # from there: docs/generated/verification.md and every_check.md
    python tests/verification/driver.py --beside build/beside      # the cases that hold published numbers of others, and docs/generated/beside.md
    python tests/verification/driver.py --all --same-bits          # every run of every case on 1, 2, 3 and 4 ranks

A case.py has WHAT (one line), SOURCE (closed form or reference), BY (who computed the reference) and run(case), which runs scenes and checks numbers. It may have
LONG, the names of functions with the one argument `case` that the short form leaves out (QUOIN_SHORT=1 in the environment, as
tools/test.sh sets it). Case.ranks and Case.some say what else it leaves out.

    stage = case.run(mesh, scene, ranks=2).stage("weight")
    case.check("closure of the base [m]", -stage.contacts.opening[0], 4.7088e-6, relative=1e-6)

Numbers that others published are in examples/published/problems.yaml; case.published(problem, {quantity: ours}) checks ours against them.

Exit code 0: every check of every case holds; 1: one does not; 2: no such case or program."""

import argparse
import copy
import functools
import importlib.util
import json
import os
import queue
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import traceback
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import yaml

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
REFERENCE = ROOT / "tests" / "data" / "reference"
PUBLISHED = ROOT / "examples" / "published"
sys.path.insert(0, str(ROOT / "tools"))
sys.path.append(str(PUBLISHED))  # models, problem
sys.path.append(str(ROOT / "examples" / "fig6"))  # triangle_dam; last, for it has a mesh.py too

from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from turns import turn  # noqa: E402

ENVIRONMENT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
               "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_hwloc_base_binding_policy": "none",
               "OMPI_MCA_odls_base_sigkill_timeout": "0", "OMPI_MCA_mpi_yield_when_idle": "1",
               "OMPI_MCA_pml": "ob1", "OMPI_MCA_ess_singleton_isolated": "1",  # what it takes anyway: a start 0.3 s sooner
               "HWLOC_COMPONENTS": "no_os,stop", "HWLOC_PLUGINS_PATH": "",  # no rank is bound: no look at caches and devices
               "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
VERDICTS = {0: "converged", 2: "bad input", 3: "diverged", 4: "undecided", 5: "interrupted", 6: "collapsed"}
FAR = 0.01  # share of a tolerance below which errors are those of rounding
MODELS = ("pt", "r2pt", "r3pt", "t2pt", "t3pt", "tptm")


@dataclass
class Check:
    """One row of the table; of arrays the entry with the largest error against its tolerance."""

    what: str
    expected: object
    ours: object
    error: float
    tolerance: float
    kind: str  # relative, absolute, equal, or reported: relative error, without a tolerance
    ranks: str
    seconds: float
    passed: bool
    published: dict | None = None  # problem, quantity and what others found, of a row of case.published


class Run(Results):
    """Results of a run, with its exit code (0: all stages converged) and what it printed."""

    def __init__(self, folder, exit_code, stdout, stderr, seconds):
        self.exit_code, self.stdout, self.stderr, self.seconds = exit_code, stdout, stderr, seconds
        self.verdict = VERDICTS.get(exit_code, f"exit code {exit_code}")
        if exit_code in VERDICTS and exit_code != 2:
            super().__init__(folder)
        elif exit_code != 2:
            raise RuntimeError(f"{folder}: exit code {exit_code}\n{stdout[-2000:]}{stderr[-4000:]}")

    def moved(self, folder):
        """Its files are in this folder now."""
        self.folder, self.path = str(folder), str(folder / "results.h5")

    def probe(self, stage, point):
        """Displacement (u_x, u_y) [m] of a named point at the end of a stage."""
        values = self.stage_summary(stage)["probes"][point]
        return np.array([values["u_x"], values["u_y"]])


class Starter:
    """Runs of one rank by copies of build/tests/runs (runs.c), which has loaded the shared libraries once; one process for each run at a time."""

    def __init__(self, program):
        self.program, self.idle, self.environment = program, queue.SimpleQueue(), dict(os.environ)

    def takes(self, words):
        """False for words that a request cannot hold, and where a case has changed the environment."""
        return dict(os.environ) == self.environment and not any(sign in word for word in words for sign in "\t\n")

    def run(self, words, folder):
        try:
            process = self.idle.get_nowait()
        except queue.Empty:
            process = subprocess.Popen([self.program], env=ENVIRONMENT | self.environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        with tempfile.TemporaryDirectory(prefix="quoin_said_") as said:
            out, err = Path(said, "out"), Path(said, "err")
            process.stdin.write("\t".join([str(folder), str(out), str(err), *words]) + "\n")
            process.stdin.flush()
            code = int(process.stdout.readline())
            self.idle.put(process)
            return subprocess.CompletedProcess(words, code, *(path.read_text(encoding="utf-8", errors="replace") for path in (out, err)))

    def end(self):
        while not self.idle.empty():
            process = self.idle.get_nowait()
            process.stdin.close()
            process.wait()
            process.stdout.close()


class Case:
    """What a case.py works with: runs of the solver, and checks."""

    def __init__(self, name, quoin, folder, full=False, same_bits=False, starter=None):
        self.name, self.quoin, self.folder, self.starter = name, quoin, Path(folder), starter
        self.full = full  # also what takes too long for every day
        self.short = bool(os.environ.get("QUOIN_SHORT"))  # the first lane of checks
        self.same_bits = same_bits  # repeat every run on other numbers of ranks
        self.bits = []  # (run, ranks, whether the checksums are those of the run) of these repetitions
        self._last = {}  # folder: the Run whose results are in it
        self._told = {}  # run: checksums of the numbers of ranks that it has been on
        self.checks = []
        self.runs = 0
        self._since = []  # (ranks, seconds) of the runs since the last check
        self._processor = processor_seconds()  # when the last problem of others was told

    def prepare(self, mesh, scene):
        """A new folder with a scene (dict, or its text) and its mesh (BlockMesh); None: without."""
        self.runs += 1
        folder = self.folder / f"run_{self.runs:03d}"
        folder.mkdir(parents=True)
        if mesh is not None:
            write(str(folder / "model.h5"), mesh)
        if scene is not None:
            (folder / "scene.yaml").write_text(scene if isinstance(scene, str) else dump(scene), encoding="utf-8")
        return folder

    def ranks(self, *numbers):
        """The numbers of ranks that a check goes over; in the short form 2 stands for all that are larger."""
        return tuple(sorted({min(n, 2) for n in numbers})) if self.short else numbers

    def some(self, sequence, n=1):
        """A sequence (checkpoints, joint laws, ...); in the short form n of its entries, evenly spread, the last among them."""
        entries = list(sequence)
        if not self.short or len(entries) <= n:
            return entries
        return [entries[-1 - (i * len(entries)) // n] for i in reversed(range(n))]

    def run(self, mesh, scene, *options, ranks=1):
        """Run a scene on a mesh in a folder of its own."""
        return self.again(self.prepare(mesh, scene), *options, ranks=ranks)

    def again(self, folder, *options, ranks=1, short=False):
        """Run what is in a folder; short: it ends before its first cycle."""
        if "-output" not in options:
            self._put_aside(folder, "-restart" in options)
        with turn(alone=ranks > 1 and not short):
            start = time.monotonic()
            done = self._start(folder, options, ranks)
            seconds = time.monotonic() - start
        self._since.append((ranks, seconds))
        run = Run(folder / "out", done.returncode, done.stdout, done.stderr, seconds)
        if run.exit_code != 2:  # one that is refused has no results
            self._last[folder] = run
        if self.same_bits and run.exit_code != 2:
            self._repeat(folder, options, ranks, checksums(run))
        return run

    def _put_aside(self, folder, continued):
        """Results that a Run still reads get a folder of their own before the next run is written over them."""
        out, aside = folder / "out", folder / f"out_before_{len(list(folder.glob('out_before_*')))}"
        if folder in self._last and out.is_dir():
            if continued:
                shutil.copytree(out, aside)
            else:
                out.rename(aside)
            self._last.pop(folder).moved(aside)

    def _start(self, folder, options, ranks):
        command = [self.quoin, *(["-options_file", "scene.yaml"] if (folder / "scene.yaml").exists() else []), *map(str, options)]
        if self.starter and ranks == 1 and self.starter.takes(command):
            return self.starter.run(command, folder)
        launch = ["mpirun", "-q", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"] if ranks > 1 else []
        done = subprocess.run(launch + command, cwd=folder, capture_output=True, text=True, errors="replace",
                              env=ENVIRONMENT | dict(os.environ), timeout=500)
        # Open MPI's event library may write such a line when a run ends; it is not ours
        done.stderr = "".join(line for line in done.stderr.splitlines(keepends=True) if not line.startswith("[warn] Epoll"))
        return done

    def _repeat(self, folder, options, ranks, expected):
        """The run again on the numbers of ranks it has not been on, where a parallel factor has no part in it."""
        if not expected:
            return
        # options may name files: such runs are only like those in their own folder
        files = [folder.name if options else "", *(path.read_bytes() for path in sorted(folder.glob("*.*")) if path.is_file())]
        told = self._told.setdefault((*files, *map(str, options)), {ranks: expected})
        if told.get(ranks, expected) != expected:
            self.bits.append((folder.name, ranks, False))
        for other in {1, 2, 3, 4} - set(told):
            told[other] = expected
            if "-restart" in options:  # into a folder with what the run had left before its checkpoint
                shutil.copytree(folder / "out", folder / "other_ranks")
            try:
                with turn(alone=True):
                    done = self._start(folder, [*options, "-output", "other_ranks"], other)
            except subprocess.TimeoutExpired:
                self.bits.append((f"{folder.name}, which does not end,", other, False))
                continue
            if "expected at most one rank per block" not in done.stderr:
                self.bits.append((folder.name, other, checksums(Results(folder / "other_ranks")) == expected))
                shutil.rmtree(folder / "other_ranks")

    def run_all(self, jobs):
        """Runs of one rank, two at a time; jobs: (mesh, scene) pairs. Results in the same order."""
        folders = [self.prepare(mesh, scene) for mesh, scene in jobs]
        with ThreadPoolExecutor(2) as pool:
            return list(pool.map(self.again, folders))

    def report(self, what, ours, expected):
        """A row without a tolerance, for what is known to differ or is only measured."""
        self.check(what, ours, expected, relative=np.inf)
        self.checks[-1].kind, self.checks[-1].tolerance = "reported", None

    def scene_of(self, problem, mesh=None, *changes, options=()):
        """Runs the scene of a published problem, on its own mesh or on another, with changed keys."""
        import models

        scene = yaml.safe_load((PUBLISHED / f"{problem}.yaml").read_text(encoding="utf-8"))
        folder = self.prepare(mesh or models.MESHES[problem](), changed(scene, *changes))
        for file, rows in models.TABLES.get(problem, {}).items():
            (folder / file).write_text(rows(), encoding="utf-8")
        return self.again(folder, *options)

    def published(self, problem, ours, curves=None):
        """Checks what we find of a problem of examples/published/problems.yaml, by quantity, against the first of those who published it.

        curves: {name: (x, y)}, drawn in the page beside the points that the others have in `picture`.
        A quantity is within `tolerance` of the first number (in the short form within `short`, where its model is coarser), or is only told where it has none."""
        about, spent = published_problems()[problem], processor_seconds()
        unknown = set(ours) - set(about["numbers"])
        assert not unknown, f"{problem}: problems.yaml has no {', '.join(sorted(unknown))}"
        for quantity, value in ours.items():
            numbers = about["numbers"][quantity]
            tolerance = numbers.get("short", numbers.get("tolerance")) if self.short else numbers.get("tolerance")
            first = next(iter(numbers["others"].values()))
            what = f"{about['title']}: {quantity}"
            if tolerance is None:
                self.report(what, value, first)
            else:
                self.check(what, value, first, **({"absolute": tolerance} if numbers.get("absolute") else {"relative": tolerance}))
            self.checks[-1].published = {"problem": problem, "quantity": quantity, "ours": float(value), "processor": spent - self._processor, "curves": thinned(curves)}
            curves = None
        self._processor = processor_seconds()

    def check(self, what, ours, expected, relative=None, absolute=None):
        """Compare numbers, or arrays entry by entry; without a tolerance: equal."""
        ranks, seconds = ", ".join(str(n) for n in sorted({n for n, _ in self._since})), sum(t for _, t in self._since)
        self._since = []
        if relative is None and absolute is None:
            ours = ours.item() if isinstance(ours, np.generic) else ours
            row = Check(what, expected, ours, 0.0 if ours == expected else 1.0, 0.0, "equal", ranks, seconds,
                        bool(ours == expected))
        else:
            row = compare(what, ours, expected, relative, absolute)
            row.ranks, row.seconds = ranks, seconds
        self.checks.append(row)


def processor_seconds():
    """Processor time [s] of this process and of the runs that it has waited for."""
    return sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))


def thinned(curves, most=400):
    """The curves as lists of at most so many points."""
    return {name: [np.asarray(axis)[:: 1 + len(axis) // most].tolist() for axis in curve] for name, curve in (curves or {}).items()}


@functools.cache
def published_problems():
    return yaml.safe_load((PUBLISHED / "problems.yaml").read_text(encoding="utf-8"))


def checksums(results):
    """Of the stages of a run; None when one of them is not by the explicit method."""
    stages = results.summary["stages"]
    return None if any(stage.get("method", "explicit") != "explicit" for stage in stages) else [stage["checksum"] for stage in stages]


def energies(results):
    """Of all stages of a run, over the largest: sums over ranks, so the same to rounding."""
    found = np.array([value for stage in results.summary["stages"] for value in stage.get("energy", {}).values() if value is not None])
    return found / np.abs(found).max(initial=1e-300)


def check_restarts(case, folder, first):
    """From checkpoints at the quarters of a run and near its end, on one rank and on two, it ends as the run that went through."""
    case.again(folder, "-output", "kept")
    kept = sorted((folder / "kept" / "checkpoints").iterdir())
    for i, at in case.some(enumerate((len(kept) // 4, len(kept) // 2, 3 * len(kept) // 4, len(kept) - 2)), 2):
        again = case.again(folder, "-restart", kept[at], ranks=1 + i % 2)
        case.check(f"restart from checkpoint {at} of {len(kept)}: checksums", checksums(again), checksums(first))
        case.check("... verdicts", [stage["verdict"] for stage in again.summary["stages"]], [stage["verdict"] for stage in first.summary["stages"]])
        if len(energies(first)):
            case.check("... energies over the largest", energies(again), energies(first), absolute=1e-9)


def compare(what, ours, expected, relative, absolute):
    ours, expected = np.atleast_1d(np.asarray(ours, dtype=float)), np.atleast_1d(np.asarray(expected, dtype=float))
    ours, expected = (array.ravel() for array in np.broadcast_arrays(ours, expected))
    if not len(ours):
        return Check(what, None, None, float("nan"), relative or absolute, "absolute", "", 0.0, False)
    error = np.abs(ours - expected)
    if relative is not None:
        with np.errstate(divide="ignore", invalid="ignore"):
            error = error / np.abs(expected)
    error = np.where(np.isfinite(error), error, np.inf)
    worst = int(np.argmax(error))
    tolerance, kind = (absolute, "absolute") if relative is None else (relative, "relative")
    what = f"{what}: worst of {len(ours)}" if len(ours) > 1 else what
    return Check(what, float(expected[worst]), float(ours[worst]), float(error[worst]), tolerance, kind, "", 0.0,
                 bool(error[worst] <= tolerance))


def dump(scene):
    """YAML of a scene; `model` may be left out, tuples are lists."""
    scene = json.loads(json.dumps({"model": "model.h5"} | scene))
    return yaml.safe_dump(scene, sort_keys=False, default_flow_style=None, width=120)


def changed(scene, *changes):
    """A copy of a scene with dotted keys set: changed(scene, ("joints.default.friction", 30), ("stages.0.full.ramp", 10))."""
    scene = copy.deepcopy(scene)
    for key, value in changes:
        *path, last = key.split(".")
        at = scene
        for word in path:
            at = at[int(word)] if isinstance(at, list) else at[word]
        at[last] = copy.deepcopy(value)
    return scene


# ---- cases, records, the table

def case_names():
    return sorted(path.parent.name for path in HERE.glob("*/case.py"))


def load(name):
    spec = importlib.util.spec_from_file_location(f"case_{name}", HERE / name / "case.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def run_case(name, quoin, folder, full=False, same_bits=False, starter=None):
    """Run one case; the record of it as a dict."""
    module = load(name)
    case = Case(name, quoin, folder, full, same_bits, starter)
    if case.short:
        for part in getattr(module, "LONG", ()):
            assert callable(getattr(module, part)), f"{name}: LONG names {part}, which is no function of the case"
            setattr(module, part, lambda case: None)
    start, problem = time.monotonic(), None
    try:
        module.run(case)
    except Exception:  # a case that breaks is a failure of that case only
        problem = traceback.format_exc()
    if starter:
        starter.end()
    if case.bits:
        other = [f"{folder} on {ranks} ranks" for folder, ranks, same in case.bits if not same]
        what = f"checksums of {len({folder for folder, _, _ in case.bits})} explicit runs on 1 to {max(ranks for _, ranks, _ in case.bits)} ranks"
        case.check(what, ", ".join(other) or "the same", "the same")
    record = {"case": name, "what": module.WHAT, "source": module.SOURCE, "by": module.BY, "runs": case.runs, "short": case.short,
              "seconds": time.monotonic() - start, "problem": problem,
              "passed": problem is None and bool(case.checks) and all(check.passed for check in case.checks),
              "checks": [asdict(check) for check in case.checks]}
    return record


def number(value):
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return str(value)
    return f"{value:.7g}"


def cells(check):
    # an equality shows no error
    error = "" if check["kind"] == "equal" else f"{check['error']:.1e}"
    tolerance = {"relative": "{:g}", "absolute": "{:g} abs."}.get(check["kind"], check["kind"]).format(check["tolerance"])
    return [check["what"], number(check["expected"]), number(check["ours"]), error, tolerance, check["ranks"],
            f"{check['seconds']:.1f}" if check["ranks"] else "", "" if check["passed"] else "FAILED"]


def show(record):
    print(f"{record['case']}: {record['what']}")
    rows = [["check", "expected", "ours", "error", "tolerance", "ranks", "s", ""]] + [cells(c) for c in record["checks"]]
    widths = [max(len(row[i]) for row in rows) for i in range(8)]
    for row in rows:
        print("  " + "  ".join(word.ljust(w) if i == 0 else word.rjust(w)
                               for i, (word, w) in enumerate(zip(row, widths))).rstrip())
    if record["problem"]:
        print(record["problem"])
    print(f"{record['case']}: {tally([record])}, "
          f"{record['runs']} runs, {record['seconds']:.1f} s\n", flush=True)


def judged(records):
    """The checks that hold or do not, without those that are only reported."""
    return [check for record in records for check in record["checks"] if check["kind"] != "reported"]


def tally(records):
    checks = judged(records)
    return f"{sum(check['passed'] for check in checks)} of {len(checks)} checks hold"


def title(records):
    return f"{tally(records)} ({len(records)} cases, {sum(record['runs'] for record in records)} runs)."


def nearest(record):
    """The check that comes nearest to its tolerance: (share of the tolerance, check), or None where all are equalities."""
    shares = [(check["error"] / check["tolerance"], check) for check in judged([record]) if check["kind"] != "equal" and check["tolerance"]]
    return max(shares, key=lambda pair: pair[0], default=None)


def row(*cells):
    return "| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |"


def summary_table(records):
    """docs/generated/verification.md: a row a case, without numbers that change from machine to machine."""
    lines = ["# Verification: every case", "",
             f"{title(records)} Written by `tests/verification/driver.py`; [verification](../verification.md) says how to make the table of "
             "every single check.", "",
             row("case", "what it holds", "against", "who computed the reference", "checks", "runs", "nearest to its tolerance"),
             "|---|---|---|---|---:|---:|---|"]
    for record in records:
        share, check = nearest(record) or (0, None)
        close = "equalities only"
        if check:  # what is far from its tolerance is rounding, and another on each machine
            close = f"{share:.1g} of {cells(check)[4]}: {check['what']}" if share >= FAR else f"all below {FAR:g} of their tolerance"
        lines.append(row(f"[{record['case']}](../../tests/verification/{record['case']}/case.py)", record["what"], record["source"], record["by"],
                         tally([record]).removesuffix(" checks hold"), record["runs"], close))
    return "\n".join(lines) + "\n"


def every_check(records):
    """A table a case, a row a check."""
    lines = ["# Verification: every check of every case", "", title(records), ""]
    for record in records:
        lines += [f"## {record['case']}: {record['what']}", "", f"Source: {record['source']}", "",
                  "| check | expected | ours | error | tolerance | ranks | time [s] | |", "|---|---|---|---|---|---|---|---|"]
        lines += [row(*cells(check)) for check in record["checks"]]
        lines += ["", f"This case broke: `{record['problem'].strip().splitlines()[-1]}`"] if record["problem"] else []
        lines.append("")
    return "\n".join(lines)


def write_tables(folder):
    """Both tables, from the records in a folder. Records of the short form, and of less than all cases, are refused."""
    records = [json.loads((folder / f"{name}.json").read_text(encoding="utf-8")) for name in case_names()]
    short = [record["case"] for record in records if record["short"]]
    if short:
        sys.exit(f"{folder}: records of the short form: {', '.join(short)}; run them without QUOIN_SHORT")
    (ROOT / "docs" / "generated" / "verification.md").write_text(summary_table(records), encoding="utf-8")
    (folder / "every_check.md").write_text(every_check(records), encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description="Run verification cases.")
    parser.add_argument("cases", nargs="*", help=", ".join(case_names()))
    parser.add_argument("--all", action="store_true", help="every case")
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"), help="the program (%(default)s)")
    parser.add_argument("--runs", metavar="PROGRAM", help="in the short form this program (runs.c) does the runs of one rank")
    parser.add_argument("--record", type=Path, metavar="FOLDER", help="write what each case found into FOLDER/<case>.json")
    parser.add_argument("--tables", type=Path, metavar="FOLDER", help="run nothing; write the tables from the records in this folder")
    parser.add_argument("--beside", type=Path, metavar="FOLDER", help="run the cases that hold published numbers, keep their records there and write docs/generated/beside.md")
    parser.add_argument("--full", action="store_true", help="also what takes minutes (cases that know a longer form)")
    parser.add_argument("--same-bits", action="store_true", help="repeat every explicit run on 1, 2, 3 and 4 ranks and compare the checksums")
    parser.add_argument("--keep", help="folder to keep the runs in")
    options = parser.parse_args()
    if options.tables:
        write_tables(options.tables)
        return 0
    if options.beside:
        options.cases, options.record = [name for name in case_names() if "case.published(" in (HERE / name / "case.py").read_text(encoding="utf-8")], options.beside
    names = case_names() if options.all else options.cases
    unknown = [name for name in names if name not in case_names()]
    if unknown or not names:
        parser.error(f"no case {', '.join(unknown)}; there are: {', '.join(case_names())}")
    if not os.access(options.quoin, os.X_OK):
        parser.error(f"no program {options.quoin}; build it or name it with --quoin")
    records = []
    for name in names:
        folder = tempfile.mkdtemp(prefix=f"quoin_{name}_") if not options.keep else os.path.join(options.keep, name)
        starter = Starter(os.path.abspath(options.runs)) if options.runs and os.environ.get("QUOIN_SHORT") else None
        records.append(run_case(name, os.path.abspath(options.quoin), folder, options.full, options.same_bits, starter))
        show(records[-1])
        if options.record:
            options.record.mkdir(parents=True, exist_ok=True)
            (options.record / f"{name}.json").write_text(json.dumps(records[-1], indent=1, default=lambda value: sorted(value, key=str) if isinstance(value, set) else str(value)), encoding="utf-8")
        if not options.keep:
            shutil.rmtree(folder, ignore_errors=True)
    if options.beside:
        import beside

        beside.write(records, published_problems(), ROOT)
    return 0 if all(record["passed"] for record in records) else 1


if __name__ == "__main__":
    sys.modules["driver"] = sys.modules["__main__"]  # cases import this very module
    sys.exit(main())
