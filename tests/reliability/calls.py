"""Let every call to the system that touches the output folder fail in turn: open, read, write, sync, rename, close, truncate.

    python tests/reliability/calls.py --quoin build/quoin                       # every call, every failure, every kind of run: hours
    python tests/reliability/calls.py --quoin build/quoin --short               # each file once; kinds of call, run and failure go round
    python tests/reliability/calls.py --quoin build/quoin --short --from 1      # the same of others: 0, 1, 2, ... walk over all
    python tests/reliability/calls.py --quoin build/quoin --only lifts report   # all calls of some of them

A run must end with exit code 8 and one line about it, and go on with -restart auto to the results of an undisturbed run, every number of
results.h5, results.xdmf and history.csv; or end with 0 and these results. So must a restart in the middle of a run; it may end with 10, too, without a change. Tools that write into the folder
(pictures, the sheet, a study, an ensemble) must end with one line and an exit code that is not 0, or with 0; each of their files is whole then, the new one or that of
before; a study and an ensemble that are begun again have the answers of an undisturbed one. fail_call (tests/reliability/fail_call.c) is expected beside the program, or is compiled."""

import argparse
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import h5py
import numpy as np
import yaml

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "tools")]

import scenes  # noqa: E402
from quoin_tools.base.integrity import check_folder  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from run import ENVIRONMENT, outcome  # noqa: E402

FAILURES = ("EIO", "ENOSPC", "EDQUOT", "SHORT")
OK, OUTPUT, NO_RESTART = 0, 8, 10
CANNOT = 2  # of a tool
LONGEST = 1200  # s: what hangs is found, however busy the machine is


def frames():
    """Blocks that fall for a moment: frames of a dynamic stage, each a file of its own."""
    mesh, scene = scenes.dynamic(0.02, 2)
    scene["stages"][0]["fall"]["frames"] = 2
    scene["relaxation"]["history_every"] = 50
    return mesh, scene


SCENES = {"static": lambda: scenes.static(4), "frames": frames, "transient": scenes.transient, "trials": scenes.trials, "lifts": scenes.lifts,
          "stages": lambda: scenes.stages(18)}


def content(folder):
    """What a run has left, but for times of day: all of results.h5 as digests by name, results.xdmf, history.csv, the outcome in the summary,
    and joint_history.csv where a stage runs in time."""
    found = {}

    def keep(name, item):
        found.update({f"{name} {key}": str(value) for key, value in item.attrs.items()})
        if isinstance(item, h5py.Dataset):
            found[name] = hashlib.sha256(np.asarray(item).tobytes()).hexdigest()

    with h5py.File(folder / "out" / "results.h5") as file:
        keep("/", file)
        file.visititems(keep)
    return [found, *((folder / "out" / name).read_bytes() for name in ("results.xdmf", "history.csv")), outcome(folder),
            *(path.read_bytes() for path in sorted((folder / "out").glob("*_history.csv")))]


def kind_of(call):
    """Of a line of the log, kind of call and file, but for numbers in its name: what --short tries once."""
    kind, _, path = call.partition(" ")
    path = re.sub(r"^\.(.*)\.\w{8}(\.part)?$", r"\1\2", path.removesuffix(" (deleted)"))
    return kind, re.sub(r"\d+(?=(_\d+)?\.h5|/)", "#", path)


def file_of(call):
    """Of a line of the log: the kind of call, and the file whose name it was to get."""
    kind, _, path = call.partition(" ")
    name = re.sub(r"^\.(.*)\.\w{8}$", r"\1", path.removesuffix(".part"))
    return kind, "the folder" if not name else "checkpoints" if name.startswith("checkpoints") else "pictures" if name.endswith(".png") else name


class Scene:
    """A folder with a scene, what its undisturbed run comes to, and how many calls that makes."""

    kind, ends = "run", (OK, OUTPUT)

    def __init__(self, name, quoin, tool, folder):
        self.name, self.quoin, self.tool, self.folder = name, quoin, tool, folder
        folder.mkdir()
        mesh, scene = SCENES[name]()
        write(str(folder / "model.h5"), mesh)
        (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
        self.count()
        self.expected = content(folder)

    def count(self):
        """Lines of the calls that fail_call may let fail, by failure."""
        self.fail("EIO", 0)
        lines = (self.folder / "log").read_text(encoding="utf-8").splitlines()[:-1]
        self.calls = dict.fromkeys(FAILURES, lines) | {"SHORT": [line for line in lines if line.startswith("write ")]}

    def run(self, *before, more=()):
        command = [*before, self.quoin, "-options_file", "scene.yaml", *more]
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, errors="replace", timeout=LONGEST,
                              env=ENVIRONMENT | dict(os.environ))
        return done.returncode, done.stderr

    def fail(self, failure, n):
        """Exit code, stderr, number of calls, and the one that failed."""
        shutil.rmtree(self.folder / "out", ignore_errors=True)
        (self.folder / "out").mkdir()
        return self.fail_on(failure, n)

    def fail_on(self, failure, n, more=()):
        code, error = self.run(self.tool, "out", "all", failure, str(n), "log", more=more)
        lines = (self.folder / "log").read_text(encoding="utf-8").splitlines()
        return code, error, int(lines[-1].split()[0]), lines[0]

    def whole(self):
        """Whether the folder holds what the undisturbed run has left."""
        check_folder(self.folder / "out")
        left = [path.name for path in (self.folder / "out").rglob("*.part")]
        assert not left, f"left behind: {left}"
        assert content(self.folder) == self.expected, "the results are others"

    def check(self, failure, n):
        """Raises AssertionError or what a reader raises; the exit code and the call otherwise."""
        code, error, _, call = self.fail(failure, n)
        said = [line for line in error.splitlines() if line.startswith("quoin: error:")]
        assert code in self.ends, f"exit code {code}: {error}"
        if code != OK:
            assert len(said) == 1, f"expected one line, not {error!r}"
            again, error = self.run(more=("-restart", "auto"))
            assert again == OK, f"exit code {again} after the restart: {error}"
        self.whole()
        return code, call


class Restart(Scene):
    """A restart from the one checkpoint in the middle of a run; beside it the results of a run that had come further."""

    kind, ends = "restart", (OK, OUTPUT, NO_RESTART)

    def __init__(self, name, quoin, tool, folder):
        self.name, self.quoin, self.tool, self.folder = name, quoin, tool, folder
        folder.mkdir()
        mesh, scene = scenes.static(4)
        write(str(folder / "model.h5"), mesh)
        (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
        assert self.run(more=("-checkpoint_every", "150", "-checkpoint_keep", "1000"))[0] == OK
        self.expected = content(folder)
        files = sorted((folder / "out" / "checkpoints").glob("*.h5"))
        for path in {*files} - {files[len(files) // 2]}:
            path.unlink()
        shutil.copytree(folder / "out", folder / "before")
        self.count()

    def fail(self, failure, n):
        shutil.rmtree(self.folder / "out")
        shutil.copytree(self.folder / "before", self.folder / "out")
        return self.fail_on(failure, n, more=("-restart", "auto"))


WORDS = {"plots": ("show", "--pictures"), "report": ("report",)}  # of each tool: its command


class Tool(Scene):
    """A tool that makes files of a run, in a folder where it has made them before."""

    kind = "tools"

    def __init__(self, name, quoin, tool, folder):
        self.name, self.quoin, self.tool, self.folder = name, quoin, tool, folder
        folder.mkdir()
        mesh, scene = scenes.static(4)
        write(str(folder / "model.h5"), mesh)
        (folder / "scene.yaml").write_text(yaml.safe_dump(scene | {"stages": scene["stages"][:1]}, sort_keys=False), encoding="utf-8")
        assert self.run()[0] == OK
        self.count()
        self.files = sorted(path.name for path in (folder / "out").iterdir())

    def fail(self, failure, n):
        command = [self.tool, "out", "all", failure, str(n), "log", sys.executable, "-m", "quoin_tools", *WORDS[self.name], "out"]
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, errors="replace", timeout=LONGEST,
                              env=os.environ | {"PYTHONPATH": str(HERE.parents[1] / "tools")})
        lines = (self.folder / "log").read_text(encoding="utf-8").splitlines()
        return done.returncode, done.stderr, int(lines[-1].split()[0]), lines[0]

    def check(self, failure, n):
        code, error, _, call = self.fail(failure, n)
        assert code in (OK, CANNOT), f"exit code {code}: {error}"
        assert len(error.splitlines()) == (code == CANNOT), f"expected one line, not {error!r}"
        check_folder(self.folder / "out")
        assert sorted(path.name for path in (self.folder / "out").iterdir()) == self.files, "a file is missing, or left behind"
        return code, call


class Command(Scene):
    """A command that makes several runs: a study, an ensemble. Begun again, it has the answers of one that nothing has disturbed."""

    kind = "commands"

    def __init__(self, name, quoin, tool, folder):
        self.name, self.quoin, self.tool, self.folder = name, quoin, tool, folder
        folder.mkdir()
        mesh, scene = scenes.stages(1)
        scene["stages"] = [{"both": {"loads": ["weight", "push"]}}]
        write(str(folder / "model.h5"), mesh)
        (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
        chance = {"distribution": "normal", "mean": 15, "deviation": 3}
        (folder / "ensemble.yaml").write_text(yaml.safe_dump({"scene": "scene.yaml", "samples": 6, "seed": 1, "fail": "collapsed",
                                                              "variables": {"joints.default.friction": chance}}), encoding="utf-8")
        self.words = {"study": ["study", "scene.yaml", "joints.default.friction=20,30", "-o", "out"], "ensemble": ["ensemble", "ensemble.yaml", "-j", "1", "-o", "out"]}[name]
        self.count()
        self.expected = self.answers()

    def command(self, *before):
        done = subprocess.run([*before, sys.executable, str(HERE.parents[1] / "tools/quoin.py"), *self.words], cwd=self.folder, capture_output=True, text=True, errors="replace",
                              timeout=LONGEST, env=ENVIRONMENT | dict(os.environ) | {"PYTHONPATH": str(HERE.parents[1] / "tools"), "QUOIN_SOLVER": self.quoin})
        return done.returncode, done.stderr

    def fail(self, failure, n):
        shutil.rmtree(self.folder / "out", ignore_errors=True)
        (self.folder / "out").mkdir()
        code, error = self.command(self.tool, "out", "all", failure, str(n), "log")
        lines = (self.folder / "log").read_text(encoding="utf-8").splitlines()
        return code, error, int(lines[-1].split()[0]), lines[0]

    def answers(self):
        """All but seconds."""
        if self.name == "study":
            return (self.folder / "out/study.csv").read_bytes()
        with h5py.File(self.folder / "out/samples.h5") as file:
            numbers = [file[name][:].tolist() for name in ("sample", "outcome", "weight")]
        return numbers, yaml.safe_load((self.folder / "out/ensemble.json").read_text(encoding="utf-8"))["probabilities"]

    def check(self, failure, n):
        code, error, _, call = self.fail(failure, n)
        assert code in (OK, CANNOT, OUTPUT), f"exit code {code}: {error}"
        assert len(error.splitlines()) == (code != OK), f"expected one line, not {error!r}"
        if code != OK:
            again, error = self.command()
            assert again == OK, f"exit code {again} when begun again: {error}"
        assert self.answers() == self.expected, "the answers are others"
        return code, call


RUNS = dict.fromkeys(SCENES, Scene) | {"restart": Restart}
TOOLS = dict.fromkeys(("plots", "report"), Tool) | dict.fromkeys(("study", "ensemble"), Command)
OF_COMMANDS = {"study": ("study.csv", "study_1"), "ensemble": ("samples.h5", "rows_")}  # all other files are those of runs, or of tools


def tool_of(quoin, folder):
    tool = Path(quoin).with_name("fail_call")
    if not tool.exists():
        tool = folder / "fail_call"
        subprocess.run(["cc", "-O1", "-o", tool, HERE / "fail_call.c"], check=True)
    return str(tool.resolve())


def works(tool, folder):
    """Whether processes may be traced here."""
    return subprocess.run([tool, folder, "all", "EIO", "0", folder / "log", "true"], capture_output=True).returncode == 0


def every_call(runs):
    return [(run, failure, n) for run in runs for failure in FAILURES for n in range(1, len(run.calls[failure]) + 1)]


def some_calls(runs, first, only=""):
    """Of each file that is written one call. Its kind (open, write, close, ...), who makes it, which of such calls it is (the last, the first, one between) and how it
    fails go round; `first` shifts them, so that first = 0, 1, 2, ... walk over all. only: files whose names begin so."""
    places = {}
    for run in runs:
        for n, line in enumerate(run.calls["EIO"], 1):
            kind, file = kind_of(line)
            if file.startswith(only):
                places.setdefault(file, {}).setdefault(kind, {}).setdefault(run, []).append(n)
    tries = []
    for k, (file, kinds) in enumerate(sorted(places.items()), first):
        kind = sorted(kinds)[k % len(kinds)]
        k += first // len(kinds)
        run = list(kinds[kind])[k % len(kinds[kind])]
        numbers, failure = kinds[kind][run], FAILURES[k % 3]
        n = (numbers[-1], numbers[0], numbers[k // 3 % len(numbers)])[k % 3]
        if kind == "write" and k % 2:  # half of what it should write
            failure, n = "SHORT", 1 + max(i for i, line in enumerate(run.calls["SHORT"]) if kind_of(line) == (kind, file))
        tries.append((run, failure, n))
    return tries


def lines_of(ends):
    """One for each file: how many calls failed, of which kinds, how, and the exit codes."""
    lines = []
    for who, name in sorted({(who, name) for who, _, name, _, _ in ends}):
        mine = [((kind, failure, f"exit code {code}:"), n) for (w, kind, f, failure, code), n in ends.items() if (w, f) == (who, name)]
        sums = [Counter(key[i] for key, n in mine for _ in range(n)) for i in range(3)]
        counted = "; ".join(", ".join(f"{key} {n}" for key, n in sorted(one.items())) for one in sums)
        lines.append(f"{who}, {name}: {sums[0].total()} ({counted})")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default="build/quoin")
    parser.add_argument("--short", action="store_true", help="one call of each file")
    parser.add_argument("--from", type=int, default=0, dest="first", metavar="K", help="of --short: where runs, calls and failures begin to go round")
    parser.add_argument("--only", nargs="+", choices=(*RUNS, *TOOLS), help="some of the runs and tools; by default all, with --short those that take no pictures")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        tool = tool_of(options.quoin, folder)
        if not works(tool, folder):
            print("calls: left out: processes cannot be traced here (ptrace)")
            return 0
        quoin = str(Path(options.quoin).resolve())
        made = {name: make(name, quoin, tool, folder / name) for name, make in (RUNS | TOOLS).items()
                if (name in options.only if options.only else not options.short or make is not Tool)}
        runs, commands = ([run for name, run in made.items() if (name in RUNS) == solver] for solver in (True, False))
        tries = some_calls(runs, options.first) if options.short else every_call(made.values())
        if options.short:  # of what commands write, the file that is theirs alone
            tries += [one for command in commands for one in some_calls([command], options.first, OF_COMMANDS[command.name][options.first % 2])]
        ends, bad = Counter(), 0
        for run, failure, n in tries:
            try:
                code, call = run.check(failure, n)
                ends[(run.kind, *file_of(call), failure, code)] += 1
            except (AssertionError, ValueError, OSError, KeyError, subprocess.TimeoutExpired) as error:
                bad += 1
                print(f"{run.name}, {failure}, call {n}: {(run.folder / 'log').read_text().splitlines()[0]}: {error}", flush=True)
        print("\n".join(lines_of(ends)))
        print(f"{len(tries)} failed calls: {bad} lost something")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
