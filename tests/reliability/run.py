"""Kill runs and restart them, try faults, soak; write docs/generated/faults.md.

    python tests/reliability/run.py --quoin build/quoin                        # 5 kills and the faults
    python tests/reliability/run.py --quoin build/quoin --kills 100 --soak 1000000 --table docs/generated/faults.md

With --table the catalogue of bad input is tried too, on 1 and 2 ranks. Exit code 0: nothing was lost; 1: something was. Faults that need a small
disk of their own are left out where tmpfs cannot be mounted."""

import argparse
import contextlib
import copy
import itertools
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Lock

import yaml

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import faults  # noqa: E402
import scenes  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402

ENVIRONMENT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
               "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_hwloc_base_binding_policy": "none",
               "OMPI_MCA_mpi_yield_when_idle": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
LONGEST = 300  # s in which a run writes nothing, see Job.end
EVERY = {"static": 300, "cracked": 1000, "reduction": 700, "flood": 700, "variable": 500, "dynamic": 2000, "condensed": 300,
         "newton": 20, "stages": 10000}
TRIES = 8  # runs that were over before the signal, one after the other


def written(folder):
    """When its files were written; one may be gone before it is looked at."""
    times = {}
    for path in folder.rglob("*"):
        with contextlib.suppress(FileNotFoundError):
            times[path] = path.stat().st_mtime_ns
    return times


def worked(pids):
    """Processor time of the process that has had most of it [s]."""
    most = 0.0
    for pid in pids:
        with contextlib.suppress(OSError):
            user, system = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[11:13]
            most = max(most, (int(user) + int(system)) / os.sysconf("SC_CLK_TCK"))
    return most


class Job:
    """A run of the program that may be killed on its way."""

    def __init__(self, quoin, folder, ranks, *options):
        self.folder, self.start = folder, time.monotonic()
        command = ["mpirun", "-q", "-n", str(ranks), "--oversubscribe", "--bind-to", "none", quoin, "-options_file", "scene.yaml"]
        self.process = subprocess.Popen([*command, *map(str, options)], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        text=True, errors="replace", env=ENVIRONMENT | dict(os.environ))

    def wait_for(self, pattern, patience=LONGEST):
        """Until the run has written such files, or is over."""
        start = time.monotonic()
        while not list(self.folder.glob(pattern)) and self.process.poll() is None:
            assert time.monotonic() - start < patience, f"{self.folder}: no {pattern}"
            time.sleep(0.005)

    def ranks(self):
        """Process ids of the ranks, as far as they have started."""
        try:
            children = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split()
        except OSError:
            return []
        return [int(pid) for pid in children]

    def kill(self, how):
        """SIGKILL to one rank, to all ranks, or to mpirun; the ids of the ranks."""
        pids = self.ranks()
        victims = {"one rank": pids[-1:], "all ranks": pids, "mpirun": [self.process.pid]}[how]
        for pid in victims or [self.process.pid]:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        return pids

    def end(self, longest=LONGEST):
        """Exit code, stdout, stderr; a run that hangs is an error. It writes nothing for so long, and either its ranks have all slept or one of them
        has had the processor for so long; one that waits for its turn on a busy machine does neither."""
        files, at_file, before = None, 0.0, None
        while True:
            try:
                out, error = self.process.communicate(timeout=longest)
                return self.process.returncode, out, error
            except subprocess.TimeoutExpired:
                last, files, now = files, written(self.folder), worked(self.ranks())
                if files != last:
                    at_file = now
                elif now == before or now - at_file > longest:
                    self.kill("all ranks")
                    self.process.kill()
                    raise AssertionError(f"{self.folder}: hangs") from None
                before = now


def orphans(pids, patience=120.0):
    """Those of the processes that are still there after a while."""
    def alive(pid):
        try:
            return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
        except OSError:
            return False
    start = time.monotonic()
    while any(map(alive, pids)) and time.monotonic() - start < patience:
        time.sleep(0.1)
    return [pid for pid in pids if alive(pid)]


class Bench:
    """Folders with scenes, and what their undisturbed runs come to."""

    def __init__(self, quoin, folder, points=2):
        self.quoin, self.folder, self.numbers = str(Path(quoin).resolve()), Path(folder), itertools.count(1)
        self.known: dict = {}
        self.lengths: dict = {}
        self.points = points  # restarts from checkpoints of one run

    def prepare(self, name, change=None, made=None):
        """A new folder with a scene and its mesh, those of that name unless made; change(scene): in place, for this folder."""
        folder = self.folder / f"{next(self.numbers):03d}_{name}"
        folder.mkdir(parents=True)
        mesh, scene = made or scenes.ALL[name]()
        if change:
            scene = copy.deepcopy(scene)  # scenes share their parts
            change(scene)
        write(str(folder / "model.h5"), mesh)
        (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
        return folder

    def job(self, folder, ranks, *options):
        return Job(self.quoin, folder, ranks, *options)

    def run(self, folder, ranks, *options):
        return self.job(folder, ranks, *options).end()

    def reference(self, name):
        """What the run comes to when nothing disturbs it, on any number of ranks."""
        if name not in self.known:
            results = []
            for ranks in (1,) if name in scenes.ROUNDED else (1, 2):
                folder = self.prepare(name)
                code, _, error = self.run(folder, ranks)
                assert code == 0, error
                results.append(outcome(folder))
            assert results[0] == results[-1], f"{name}: 1 and 2 ranks differ"
            self.known[name] = results[0]
        return self.known[name]

    def length(self, name, ranks):
        """How long the undisturbed run takes, from its start to its first checkpoint and from there to its summary [s]."""
        if (name, ranks) not in self.lengths:
            folder = self.prepare(name)
            job = self.job(folder, ranks, "-checkpoint_every", EVERY[name])
            job.wait_for("out/checkpoints/*.h5")
            first, seen = time.monotonic() - job.start, time.time()
            job.end()
            self.lengths[name, ranks] = first, max(0.0, (folder / "out" / "summary.json").stat().st_mtime - seen)
        return self.lengths[name, ranks]


def outcome(folder, output="out"):
    """Per stage: name, verdict, cycles, checksum; and the cycles in history.csv."""
    summary = json.loads((folder / output / "summary.json").read_text(encoding="utf-8"))
    rows = (folder / output / "history.csv").read_text(encoding="utf-8").splitlines()[1:]
    stages = [[stage[key] for key in ("name", "verdict", "cycles", "checksum")] for stage in summary["stages"]]
    return [stages, [row.split(",")[:2] for row in rows]]


def stages_done(folder):
    summary = folder / "out" / "summary.json"
    return len(json.loads(summary.read_text(encoding="utf-8"))["stages"]) if summary.exists() else 0


def kill_on_the_way(bench, name, how, rng):
    """A folder whose run was killed at a random moment, the number of its ranks, and runs that were over before."""
    for over in range(TRIES):
        folder, ranks = bench.prepare(name), 1 if name in scenes.ROUNDED else rng.choice((1, 2))
        first, rest = bench.length(name, ranks)
        job = bench.job(folder, ranks, "-checkpoint_every", EVERY[name])
        if rng.random() < 0.1:  # while it starts
            time.sleep(rng.uniform(0.0, first))
        else:
            job.wait_for("out/checkpoints/*.h5")
            time.sleep(rng.uniform(0.0, rest) / 2**over)  # the machine may have had more other work when the length was measured
        late = job.process.poll() is not None or stages_done(folder) == len(bench.reference(name)[0])
        pids = job.kill(how)
        job.end(LONGEST / 2)
        assert not orphans(pids), f"{folder}: ranks that nobody has ended"
        if not late:
            return folder, ranks, over
        shutil.rmtree(folder)
    raise AssertionError(f"{name}: {TRIES} runs were over before the signal")


def kill_and_restart(bench, name, how, rng):
    """Kill a run at a random moment, restart it on other ranks, and compare; runs over before, and whether it went on."""
    expected = bench.reference(name)
    folder, ranks, over = kill_on_the_way(bench, name, how, rng)
    ranks = ranks if name in scenes.ROUNDED else rng.choice((1, 2, 4))
    code, out, error = bench.run(folder, ranks, "-checkpoint_every", EVERY[name], "-restart", "auto")
    assert code == 0, f"{folder}: exit code {code} after the restart: {error}"
    assert outcome(folder) == expected, f"{folder}: the result is another"
    left = [path.name for path in folder.rglob("*.part")]
    assert not left, f"{folder}: left behind: {left}"
    shutil.rmtree(folder)
    return over, "goes on from" in out


class Known:
    """What has been done so far, in a JSON file when one is named: a call that was stopped goes on there."""

    def __init__(self, path):
        self.path, self.lock = path, Lock()
        self.all = json.loads(path.read_text(encoding="utf-8")) if path and path.exists() else {}

    def __call__(self, name, make):
        """The result of that name; make(): unless it is known."""
        if name not in self.all:
            result = make()
            with self.lock:
                self.all[name] = result
                if self.path:
                    self.path.write_text(json.dumps(self.all, indent=1), encoding="utf-8")
        return self.all[name]


WAYS = ("one rank", "all ranks", "mpirun")


def kills(bench, n, seed, known):
    """n kills, two at a time: a run mostly waits for its messages. Rows of the table."""
    names = list(scenes.ALL)

    def kill(i):
        name, how = names[i % len(names)], WAYS[i % len(WAYS)]
        over, resumed = known(f"kill {i + 1}", lambda: kill_and_restart(bench, name, how, random.Random(1000 * seed + i)))  # noqa: S311
        print(f"kill {i + 1}: {name}, {how}: same checksum, {'from a checkpoint' if resumed else 'from the start'}", flush=True)
        return how, over, resumed

    for name in names[:n]:
        bench.known[name] = known(f"reference {name}", lambda name=name: bench.reference(name))
    with ThreadPoolExecutor(2) as pool:
        done = list(pool.map(kill, range(n)))
    rows = []
    for way in WAYS:
        mine = [(over, resumed) for how, over, resumed in done if how == way]
        if mine:
            rows.append((f"SIGKILL of {way} at a random moment, restart on 1, 2 or 4 ranks", len(mine), "-",
                         f"nothing: final checksum and rows of history.csv of the undisturbed run ({sum(r for _, r in mine)} went on "
                         f"from a checkpoint, the others from the start; not counted: {sum(o for o, _ in mine)} runs over before the signal)"))
    return rows


def memory_of(pids):
    """Resident memory [kB] of the largest of the processes."""
    most = 0
    for pid in pids:
        try:
            lines = Path(f"/proc/{pid}/status").read_text().splitlines()
        except OSError:
            continue
        most = max([most] + [int(line.split()[1]) for line in lines if line.startswith("VmRSS:")])
    return most


def watched(job, folder):
    """What the run says, and the memory of its largest rank [kB], looked at every 0.02 s from its first checkpoint on."""
    samples, checkpoints = [], folder / "out" / "checkpoints"
    while job.process.poll() is None:
        time.sleep(0.02)
        if any(checkpoints.glob("*.h5")):
            samples.append(memory_of(job.ranks()))
    code, out, error = job.end()
    assert code == 0, error
    samples = [kb for kb in samples if kb][:-1]  # the last is of ranks that end
    assert len(samples) >= 50, f"{folder}: memory looked at {len(samples)} times only: more cycles"
    return out, samples


def account(energy, dt_factor, out):
    """Of a stage in time: the balance is the error of the trapezoidal rule for works, (omega dt)^2/12 of what was turned over,
    with omega dt <= 2 dt_factor for every frequency; the program has nothing to warn of (1 %); friction has only taken."""
    turned = energy["friction"] + sum(abs(energy[name]) for name in ("kinetic", "strain", "joints"))
    bound = (2 * dt_factor) ** 2 / 12 * turned
    assert abs(energy["balance"]) <= bound, f"energy balance {energy['balance']} J, by theory at most {bound} J"
    assert "energy account is out" not in out, out
    return (f"energy balance {energy['balance']:.2g} J of {turned:.3g} J turned over (theory: at most {bound:.2g} J); finding contacts "
            f"again made {energy['detection']:.2g} J; supports and loads gave {energy['supports'] + energy['outside']:.3g} J, "
            f"friction and dashpots took {energy['friction']:.3g} J")


def soak(bench, cycles):
    """Blocks that slide in a shaken tray: memory, balance, every checkpoint."""
    duration, keep = 1.01 * cycles * scenes.SOAK_STEP, 1000
    folder = bench.prepare("tray", made=scenes.tray(duration))
    (folder / "motion.csv").write_text(scenes.motion(duration, amplitude=1.0, frequency=1.0), encoding="utf-8")
    job = bench.job(folder, 2, "-checkpoint_every", max(1, cycles // 50), "-checkpoint_keep", keep, "-checkpoint_minutes", 0)
    out, samples = watched(job, folder)
    tenth = len(samples) // 10
    early, late = samples[tenth], max(samples[-tenth:])
    assert late < 1.05 * early, f"{folder}: memory grows from {early} to {late} kB"
    summary = json.loads((folder / "out" / "summary.json").read_text(encoding="utf-8"))["stages"][-1]
    assert summary["cycles"] >= cycles and "contacts verified" in summary["evidence"], summary
    files = sorted((folder / "out" / "checkpoints").glob("*.h5"))
    for path in files:
        code, text, error = bench.run(folder, 1, "-restart", path, "-output", "again", "-checkpoint_wall_limit", "1e-9")
        assert code in (0, 5) and "goes on from" in text, f"{path}: {code} {error}"
    return [f"{summary['cycles']} cycles on 2 ranks: contacts verified {summary['evidence'].split('contacts verified ')[1]}",
            account(summary["energy"], 0.05, out),
            f"largest resident memory of a rank: {early / 1024:.1f} MB after a tenth of the run, {late / 1024:.1f} MB at its end",
            f"{len(files)} checkpoints, all of them loaded and gone on from"]


def bad_input(quoin):
    """The catalogue, on 1 and 2 ranks."""
    command = [sys.executable, HERE.parent / "verification" / "bad_input" / "catalogue.py", "--quoin", quoin, "--ranks", "1", "2"]
    done = subprocess.run(command, capture_output=True, text=True, env=os.environ | {"PYTHONPATH": str(scenes.ROOT / "tools")})
    assert done.returncode == 0, done.stdout + done.stderr
    return [f"{done.stdout.split()[0]} wrong scenes, options, meshes and files, each on 1 and 2 ranks: refused in one line, exit code 2"]


def calls(quoin, short):
    """Every call of the system on a file of the output folder, or one of each file, failing once."""
    chosen = ["--short"] if short else []
    done = subprocess.run([sys.executable, HERE / "calls.py", "--quoin", quoin, *chosen], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.splitlines()


def table(path, rows, lists):
    """docs/generated/faults.md; lists: {title: lines}."""
    body = "# Kills and faults\n\nWritten by `tests/reliability/run.py`; [reliability](../reliability.md) says how.\n\n"
    body += "| fault | times | exit code | what was lost |\n|---|---|---|---|\n"
    body += "".join(f"| {what} | {times} | {code} | {lost} |\n" for what, times, code, lost in rows)
    for title, lines in lists.items():
        if lines:
            body += f"\n{title}:\n\n" + "".join(f"- {line}\n" for line in lines)
    path.write_text(body, encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quoin", default="build/quoin")
    parser.add_argument("--kills", type=int, default=5)
    parser.add_argument("--no-faults", action="store_true")
    parser.add_argument("--soak", type=int, default=0, metavar="CYCLES")
    parser.add_argument("--short-calls", action="store_true", help="with --table: one failing call of each file; all by default, hours")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--table", type=Path)
    parser.add_argument("--known", type=Path, help="JSON file: what a call that was stopped has done is not done again")
    options = parser.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="quoin_reliability_"))
    bench, lists, known = Bench(options.quoin, folder, 6 if options.table else 2), {}, Known(options.known)
    try:
        rows = kills(bench, options.kills, options.seed, known)
        if not options.no_faults:
            rows += [row for row in (known(fault.__name__, lambda fault=fault: faults.tried(fault, bench)) for fault in faults.ALL) if row]
        if options.table:
            lists["One call of the system that fails, on a file of the output folder: exit code 8 and a restart to the same results, or 0 and "
                  "these results"] = known("calls", lambda: calls(bench.quoin, options.short_calls))
            lists["Bad input"] = known("bad input", lambda: bad_input(bench.quoin))
        if options.soak:
            lists["Soak"] = known("soak", lambda: soak(bench, options.soak))
    except AssertionError as error:
        print(f"LOST: {error}", file=sys.stderr)
        print(f"left for a look: {folder}", file=sys.stderr)
        return 1
    for what, times, code, lost in rows:
        print(f"{times:4d} x {what} [{code}]: {lost}")
    for title, lines in lists.items():
        print("\n  ".join([f"{title}:", *lines]))
    if options.table:
        table(options.table, rows, lists)
    shutil.rmtree(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
