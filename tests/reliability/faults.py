"""Faults other than kills: each function makes one happen and returns (what, times, exit codes, what was lost)."""

import json
import os
import random
import shlex
import shutil
import signal
import subprocess
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import h5py
import scenes  # noqa: F401 (finds the tools)
from quoin_tools.mesh.blockmesh import write
from quoin_tools.mesh.dam import G1, dam_mesh

# exit codes of include/quoin.h
OK, DIVERGED, INTERRUPTED, OUTPUT, LOCKED, RESTART, MEMORY = 0, 3, 5, 8, 9, 10, 11
NOTHING = "nothing: the restart ends with the checksum of the undisturbed run"
EVERY = ("-checkpoint_every", 300)
LONGEST = 300  # s: what hangs is found, however busy the machine is
LONG = ("-relaxation_velocity_tolerance", "1e-30", "-relaxation_max_cycles", 10**9)  # never ends by itself


def ensure(condition, what):
    if not condition:
        raise AssertionError(what)


def one_line(error, word):
    """The one line that Quoin says about it."""
    lines = [line for line in error.splitlines() if line.startswith("quoin: error:")]
    ensure(len(lines) == 1 and word in lines[0], f"expected one line with '{word}', not: {error}")
    return lines[0]


def same(bench, folder, name):
    from run import outcome
    ensure(outcome(folder) == bench.reference(name), f"{folder}: the result is another")


def restart(bench, folder, name, *options):
    code, out, error = bench.run(folder, 1, "-restart", "auto", *options)
    ensure(code == OK and "goes on from" in out, f"{folder}: exit code {code} after the restart: {out}{error}")
    same(bench, folder, name)


@contextmanager
def disk(path, options):
    """A disk of its own at path; None where none can be mounted."""
    path.mkdir()
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(path)], capture_output=True)
    try:
        yield None if done.returncode else path
    finally:
        if not done.returncode:
            subprocess.run(["umount", "-l", str(path)], check=False)


def remount(path, options):
    subprocess.run(["mount", "-o", f"remount,{options}", str(path)], check=True)


def wait_for(job, folder, pattern, patience=LONGEST):
    """Until the run has written such files."""
    start = time.monotonic()
    while not list(folder.glob(pattern)):
        ensure(job.process.poll() is None and time.monotonic() - start < patience, f"{folder}: no {pattern}")
        time.sleep(0.005)


def full_disk(bench):
    times = 0
    for kilobytes in (8, 16, 60, 150, 250, 272, 340):
        folder = bench.prepare("static")
        with disk(folder / "out", f"size={kilobytes}k") as small:
            if not small:
                return None
            code, _, error = bench.run(folder, 2, *EVERY)
            ensure(code == OUTPUT, f"{folder}: exit code {code} on a disk of {kilobytes} kB: {error}")
            line = one_line(error, "out")
            remount(small, "size=64m")
            known = "none" not in line.rsplit(":", 1)[1]
            ensure(known == bool(list(small.glob("checkpoints/*.h5"))), f"{folder}: {line}")
            if known:
                restart(bench, folder, "static")
            times += 1
    return ("disk full (8, 16, 60, 150, 250, 272, 340 kB)", times, OUTPUT, NOTHING)


def read_only(bench):
    for late in (False, True):
        folder = bench.prepare("static")
        with disk(folder / "out", "size=64m") as small:
            if not small:
                return None
            if late:
                job = bench.job(folder, 2, *EVERY, *LONG)
                wait_for(job, folder, "out/checkpoints/*2.h5")
            if late:  # files are open for writing: the disk can only be filled
                with open(small / "filler", "wb", buffering=0) as filler, suppress(OSError):
                    while True:
                        filler.write(bytes(2**14))
            else:
                remount(small, "ro")
                job = bench.job(folder, 2)
            code, _, error = job.end()
            ensure(code == OUTPUT, f"{folder}: exit code {code}: {error}")
            one_line(error, "out")
    return ("output read-only from the start; disk filled by others on the way", 2, OUTPUT, "nothing: files written before stay whole")


def removed(bench):
    for what in ("out/history.csv.part", "out/checkpoints", "out"):
        folder = bench.prepare("static")
        job = bench.job(folder, 2, *EVERY, *LONG)
        wait_for(job, folder, "out/checkpoints/*2.h5")
        path = folder / what
        path.rename(folder / "gone")
        if what != "out":
            shutil.rmtree(folder / "gone", ignore_errors=True)
            (folder / "gone").unlink(missing_ok=True)
        if what == "out/checkpoints":
            code, _, error = stop(job)
            ensure(code == INTERRUPTED and list(folder.glob("out/checkpoints/*.h5")), f"{folder}: {code} {error}")
            continue
        code, _, error = job.end()
        ensure(code == OUTPUT, f"{folder}: exit code {code} without {what}: {error}")
        one_line(error, "out")
    return ("history.csv, all checkpoints, the whole output folder removed while running", 3, f"{OUTPUT}, {INTERRUPTED}",
            "what was removed; removed checkpoints are followed by new ones")


def stop(job):
    time.sleep(0.5)
    job.process.send_signal(signal.SIGUSR2)
    return job.end()


def two_runs(bench):
    folder = bench.prepare("static")
    job = bench.job(folder, 1, *LONG)
    wait_for(job, folder, "out/checkpoints/*.h5")
    code, _, error = bench.run(folder, 2)
    ensure(code == LOCKED, f"{folder}: exit code {code} of a second run: {error}")
    ensure("process" in one_line(error, "another run"), error)
    pids = job.kill("all ranks")
    job.end()
    ensure(pids and (folder / "out" / "quoin.lock").exists(), "the lock of a killed run stays")
    code, _, error = bench.run(folder, 2)
    ensure(code == OK, f"{folder}: a stale lock: {error}")
    same(bench, folder, "static")
    return ("a second run into the same folder; a lock left by a killed run", 2, f"{LOCKED}, {OK}", "nothing: the first run goes on")


def slow_rank(bench):
    folder = bench.prepare("reduction")
    job = bench.job(folder, 2, "-checkpoint_every", 700)
    wait_for(job, folder, "out/checkpoints/*1.h5")
    for pid in job.ranks()[-1:]:
        os.kill(pid, signal.SIGSTOP)
        time.sleep(3)
        os.kill(pid, signal.SIGCONT)
    code, _, error = job.end()
    ensure(code == OK, error)
    same(bench, folder, "reduction")
    return ("one rank stopped for 3 s", 1, OK, "nothing: the others wait, same checksum")


def interrupted(bench, name="static"):
    """A folder with checkpoints of a run that was stopped on its way."""
    folder = bench.prepare(name)
    job = bench.job(folder, 1, *EVERY, "-checkpoint_keep", 4)
    wait_for(job, folder, "out/checkpoints/*4.h5")
    job.kill("all ranks")
    job.end()
    return folder, sorted((folder / "out" / "checkpoints").glob("*.h5"))


def damaged(bench, flips=20):
    rng = random.Random(3)  # noqa: S311
    folder, files = interrupted(bench)
    good = files[-1].read_bytes()
    for i in range(flips):
        data = bytearray(good)
        at = rng.randrange(len(data)) if i else rng.randrange(64)
        data[at] ^= 1 << rng.randrange(8)
        files[-1].write_bytes(bytes(data) if i % 4 else good[:rng.randrange(len(good))])
        if i < 6:  # a start of the program each: the rest by the fallback below
            code, _, error = bench.run(folder, 1, "-restart", files[-1])
            ensure(code == RESTART, f"{files[-1]}: exit code {code}: {error}")
            one_line(error, "damaged" if len(good) == files[-1].stat().st_size else "")
    files[-2].write_bytes(b"")
    code, out, error = bench.run(folder, 2, "-restart", "auto", "-checkpoint_keep", 2)
    ensure(code == OK and "goes on from" in out and error.count("is passed over") == 2, f"{folder}: {code} {error}")
    same(bench, folder, "static")
    kept = sorted((folder / "out" / "checkpoints").glob("*"))
    ensure(len(kept) == 2 and kept[-1].name > files[-1].name, f"{folder}: the newest two checkpoints stay, not {kept}")
    for path in (folder / "out" / "checkpoints").glob("*.h5"):
        path.write_bytes(path.read_bytes()[:-1])
    code, _, error = bench.run(folder, 1, "-restart", "out")
    ensure(code == RESTART, f"{folder}: all damaged: {code} {error}")
    one_line(error, "no good checkpoint")
    return ("checkpoint cut off, or with one bit flipped; an older one is taken", 8, f"{RESTART}, {OK}", NOTHING)


def other(bench):
    folder, files = interrupted(bench)
    code, out, error = bench.run(folder, 1, "-restart", files[-1], "-materials_dam_young", "11e9", "-output", "b")
    ensure(code == OK and "materials_dam_young: 10000000000.0 -> 11e9" in out, f"{code} {out} {error}")
    ensure("history.csv' does not hold" in error, error)
    elsewhere = bench.prepare("dynamic")
    code, _, error = bench.run(elsewhere, 1, "-restart", files[-1])
    ensure(code == RESTART, f"{elsewhere}: {code} {error}")
    one_line(error, "another block mesh")
    files[-1].write_bytes(files[-1].read_bytes().replace(b"version 0.", b"version 9.", 1))
    code, _, error = bench.run(folder, 1, "-restart", files[-1])
    ensure(code == RESTART, f"{code} {error}")
    one_line(error, "of version 9.")
    return ("restart with other options (told), another mesh, another version", 3, f"{OK}, {RESTART}, {RESTART}", "nothing")


def motion_file(bench):
    duration = 0.2
    folder = bench.prepare("dynamic", lambda scene: scenes.shake(scene, duration))
    (folder / "motion.csv").write_text(scenes.motion(duration), encoding="utf-8")
    job = bench.job(folder, 1, "-checkpoint_every", 1000, "-checkpoint_keep", 100)
    wait_for(job, folder, "out/checkpoints/*3.h5")
    job.kill("all ranks")
    job.end()
    (folder / "motion.csv").write_text(scenes.motion(duration, amplitude=0.1), encoding="utf-8")
    code, out, error = bench.run(folder, 1, "-restart", "auto")
    ensure(code == OK and "changed since the checkpoint: supports_base_motion_checksum: " in out, f"{folder}: {code} {out} {error}")
    return ("restart with another content of a file of motion (told)", 1, OK, "nothing")


def model_file(bench):
    rng = random.Random(5)  # noqa: S311
    folder = bench.prepare("static")
    path = folder / "model.h5"
    good = path.read_bytes()
    with h5py.File(path) as file:
        at = file["vertices"].id.get_chunk_info(0).byte_offset + 8 * rng.randrange(20)
    flipped = bytearray(good)
    flipped[at] ^= 1
    for data in (good[:len(good) // 2], good[:-100], bytes(flipped)):
        path.write_bytes(data)
        code, _, error = bench.run(folder, 2)
        ensure(code == 2, f"{folder}: exit code {code} of a damaged model: {error}")
        one_line(error, "model.h5")
    return ("model file cut off, or with one bit of a coordinate flipped (Fletcher checksums inside)", 3, 2, "nothing")


def not_a_number(bench):
    def overload(scene):
        scene["loads"]["water"]["density"] = 1e306
    code, out, _ = bench.run(bench.prepare("static", overload), 2)
    ensure(code == DIVERGED and "not a finite number, first in block" in out, f"{code} {out}")

    def too_fast(scene):
        scene["stages"][0]["fall"] |= {"dt_factor": 1.0}
        scene["joints"]["default"] |= {"damping": 0.5}
    code, out, _ = bench.run(bench.prepare("dynamic", too_fast), 1)
    ensure(code == DIVERGED and "diverged" in out, f"{code} {out}")
    return ("numbers that overflow in a block (named); a step in time that is too large", 2, DIVERGED, "nothing: told within a cycle")


def memory(bench):
    from run import ENVIRONMENT
    small, large = bench.prepare("static"), bench.prepare("static")
    write(str(large / "model.h5"), dam_mesh(G1, 120))
    command = [bench.quoin, "-options_file", "scene.yaml"]
    job = subprocess.Popen([*command, *map(str, LONG)], cwd=small, env=ENVIRONMENT | dict(os.environ), stdout=subprocess.DEVNULL)
    start = time.monotonic()
    while not list(small.glob("out/checkpoints/*.h5")) and time.monotonic() - start < LONGEST:
        time.sleep(0.02)
    lines = Path(f"/proc/{job.pid}/status").read_text(encoding="ascii").splitlines()
    size = next(int(line.split()[1]) for line in lines if line.startswith("VmSize:"))
    job.kill()
    job.wait()
    limited = f"ulimit -v {size + 20000}; exec {shlex.join(command)}"
    done = subprocess.run(["bash", "-c", limited], cwd=large, capture_output=True, text=True, env=ENVIRONMENT | dict(os.environ))
    ensure(done.returncode == MEMORY, f"{large}: {done.returncode} {done.stderr}")
    one_line(done.stderr, "GB of memory")
    return ("a model larger than the memory the process may take", 1, MEMORY, "nothing: refused, with the numbers, before it is read")


def signals(bench):
    for number, expected in ((signal.SIGTERM, INTERRUPTED), (signal.SIGINT, INTERRUPTED), (signal.SIGUSR2, INTERRUPTED),
                             (signal.SIGUSR1, None)):
        folder = bench.prepare("reduction")
        job = bench.job(folder, 2)
        wait_for(job, folder, "out/checkpoints/*0.h5")
        while not job.ranks():
            time.sleep(0.01)
        for pid in job.ranks() if number in (signal.SIGTERM, signal.SIGINT) else [job.process.pid]:
            os.kill(pid, number)
        code, out, error = job.end()
        if expected is None:
            ensure(code == OK, f"{folder}: {code} {error}")
            same(bench, folder, "reduction")
        elif code != OK:  # it may have been over before
            ensure(code == expected and "-restart out/checkpoints" in out, f"{folder}: {number}: {code} {out} {error}")
            restart(bench, folder, "reduction")
    folder = bench.prepare("reduction")
    code, out, error = bench.run(folder, 1, "-checkpoint_wall_limit", "0.0001")
    ensure(code == INTERRUPTED and "wall time" in out, f"{folder}: {code} {error}")
    restart(bench, folder, "reduction")
    return ("SIGTERM, SIGINT, SIGUSR2, limit of wall time: checkpoint and stop; SIGUSR1: checkpoint", 5, f"{INTERRUPTED}, {OK}", NOTHING)


def hangup(bench):
    """A terminal that is closed, without and with nohup, and a pipe that is: one process, without mpirun (which has its own way)."""
    from run import ENVIRONMENT

    def start(folder, *words, **more):
        command = [*words, bench.quoin, "-options_file", "scene.yaml", *map(str, more.pop("options", ()))]
        return subprocess.Popen(command, cwd=folder, env=ENVIRONMENT | dict(os.environ), stdin=subprocess.DEVNULL, **more)
    for words in ((), ("nohup",)):
        folder = bench.prepare("reduction")
        with open(folder / "log", "w") as log:
            process = start(folder, *words, stdout=log, stderr=log)
            began = time.monotonic()
            while not list(folder.glob("out/checkpoints/*0.h5")) and time.monotonic() - began < LONGEST:
                time.sleep(0.005)
            process.send_signal(signal.SIGHUP)
            code = process.wait(LONGEST)
        said = (folder / "log").read_text(encoding="utf-8")
        ensure(code == OK if words else code in (INTERRUPTED, OK), f"{folder}: {words} {code} {said}")
        if code == OK:
            same(bench, folder, "reduction")
        else:
            restart(bench, folder, "reduction")
    folder = bench.prepare("static")
    process = start(folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    process.stdout.close()
    ensure(process.wait(LONGEST) == OK, f"{folder}: {process.stderr.read()}")
    same(bench, folder, "static")
    return ("terminal closed (SIGHUP): checkpoint and stop, with nohup the run goes on; the pipe of its output closed: it goes on", 3,
            f"{INTERRUPTED}, {OK}", NOTHING)


def newton_method(bench):
    """A stop within an increment of Newton's method; a restart on other ranks, where MUMPS rounds differently."""
    def slow(scene):
        scene["relaxation"] |= {"tolerance": 1e-9}
    expected = None
    for number in (None, signal.SIGUSR2, signal.SIGUSR1):
        folder = bench.prepare("newton", slow)
        job = bench.job(folder, 1)
        job.wait_for("out/checkpoints/*1.h5")
        if number:
            job.process.send_signal(number)
        code, out, error = job.end()
        if number is None:
            ensure(code == OK, f"{folder}: {code} {error}")
            expected = final(folder)
        elif number == signal.SIGUSR2:
            ensure(code == INTERRUPTED and "-restart out/checkpoints" in out, f"{folder}: {code} {out} {error}")
            other = folder / "other"
            shutil.copytree(folder / "out", other / "out")
            for name in ("scene.yaml", "model.h5"):
                shutil.copy(folder / name, other)
            for where, ranks in ((folder, 1), (other, 2)):
                code, out, error = bench.run(where, ranks, "-restart", "auto")
                ensure(code == OK and "goes on from" in out, f"{where}: {code} {error}")
            ensure(final(folder) == expected, f"{folder}: the result is another")
            compare(final(other), expected, other)
        else:
            ensure(code == OK and final(folder) == expected, f"{folder}: {code} {error}")
    return ("SIGUSR2 and SIGUSR1 within a stage by Newton's method, restart on 1 and 2 ranks", 3, f"{INTERRUPTED}, {OK}",
            "nothing: the same checksum on 1 rank, on 2 the same verdicts and displacements to 1e-6")


def newton_everywhere(bench, points=60):
    """Restarts on one rank from checkpoints all along a run by Newton's method: the bits are those of the straight run."""
    def slow(scene):
        scene["relaxation"] |= {"increments": 30}
    folder = bench.prepare("newton", slow)
    code, _, error = bench.run(folder, 1, "-checkpoint_every", 1, "-checkpoint_keep", 1000)
    ensure(code == OK, error)
    expected = final(folder)
    files = sorted((folder / "out" / "checkpoints").glob("*.h5"))[:-1]
    files = files[::max(1, len(files) // points)]
    for path in files:
        shutil.rmtree(folder / "again", ignore_errors=True)
        code, _, error = bench.run(folder, 1, "-restart", path, "-output", "again")
        ensure(code == OK, f"{path}: {code} {error}")
        ensure(final(folder, "again") == expected, f"{path}: the result is another")
    return ("restart from checkpoints all along a run by Newton's method, 1 rank", len(files), OK, "nothing: the same checksums")


def everywhere(bench):
    """Restarts on other ranks from checkpoints all along runs that keep what kills meet rarely: closures of crushed joints, a guard that has
    restarted, springs on their way to the law of friction, contacts found again, bodies that have left their place."""
    times = 0
    for name, (make, every, expected) in scenes.EVERYWHERE.items():
        folder = bench.prepare(name, made=make())
        code, _, error = bench.run(folder, 1, "-checkpoint_every", every, "-checkpoint_keep", 1000)
        ensure(code == expected and ("restarted" in error) == (name == "guarded"), f"{folder}: exit code {code}: {error}")
        told, rows = ended(folder)
        ensure(name != "left_place" or told[0][-1], f"{folder}: no body has left its place")
        files = sorted((folder / "out" / "checkpoints").glob("*.h5"))[1:-1]
        ensure(len(files) >= 3, f"{folder}: {len(files)} checkpoints only")
        points = min(bench.points, len(files))
        for i in range(points):
            path = files[i * len(files) // points]
            shutil.rmtree(folder / "again", ignore_errors=True)
            code, _, error = bench.run(folder, min((1, 2, 4)[i % 3], 2 if name == "crushed" else 4), "-restart", path, "-output", "again")
            ensure(code == expected, f"{path}: exit code {code}: {error}")
            ensure(ended(folder, "again")[0] == told and ended(folder, "again")[1] == rows[-1:], f"{path}: the result is another")
            times += 1
    return ("restart on 1, 2 or 4 ranks from checkpoints all along runs with crushing in statics and in time, a guard that starts again, slip on its "
            "way to the law, local damping, variable connectivity, bodies that leave their place", times, f"{OK}, 4",
            "nothing: the same checksums and bodies")


def ended(folder, output="out"):
    """Per stage name, verdict, cycles, checksum, bodies; the last row of history.csv but for energies, which other ranks round in another way."""
    stages = json.loads((folder / output / "summary.json").read_text(encoding="utf-8"))["stages"]
    rows = (folder / output / "history.csv").read_text(encoding="utf-8").splitlines()
    return ([[stage[key] for key in ("name", "verdict", "cycles", "checksum")] + [stage.get("bodies")] for stage in stages],
            [row.split(",")[:4] for row in rows[-1:]])


def final(folder, output="out"):
    """Per stage: name, verdict, largest displacement, checksum; outcomes of the trials."""
    stages = json.loads((folder / output / "summary.json").read_text(encoding="utf-8"))["stages"]
    rows = [[stage["name"], stage["verdict"], stage["max_displacement"]["value"], stage["checksum"]] for stage in stages]
    return rows, [[trial["value"], trial["outcome"]] for trial in stages[-1]["strength_reduction"]["trials"]]


def compare(ours, expected, folder):
    ensure(ours[1] == expected[1], f"{folder}: other trials: {ours[1]} {expected[1]}")
    for stage, other in zip(ours[0], expected[0], strict=True):
        ensure(stage[:2] == other[:2] and abs(stage[2] - other[2]) <= 1e-6 * other[2], f"{folder}: {stage}, expected {other}")


ALL = (signals, hangup, newton_method, newton_everywhere, everywhere, slow_rank, two_runs, damaged, other, motion_file, model_file, not_a_number, memory, removed, full_disk,
       read_only)


def tried(fault, bench):
    """Its row of the table; None: it needs a small disk, which cannot be mounted here."""
    row = fault(bench)
    print(f"{fault.__name__}: {'left out: tmpfs cannot be mounted' if row is None else 'nothing lost'}", flush=True)
    return row
