"""Let every call to the system that touches the output folder fail in turn: open, write, sync, rename, close, truncate.

    python tests/reliability/calls.py --quoin build/quoin                    # every call, every failure, every scene: half an hour
    python tests/reliability/calls.py --quoin build/quoin --sample 40        # as many calls, spread over all of them

A run must end with exit code 8 and one line about it, and go on with -restart auto to the results of an undisturbed run; or end with 0 and
these results. Tools that write into the folder (pictures, the sheet) must end with one line and an exit code that is not 0, or with 0; each of
their files is whole then, the new one or that of before. fail_call (tests/reliability/fail_call.c) is expected beside the program, or is compiled."""

import argparse
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import yaml

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "tools")]

import scenes  # noqa: E402
from quoin_tools.base.whole import check_folder  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from run import ENVIRONMENT, outcome  # noqa: E402

FAILURES = ("EIO", "ENOSPC", "EDQUOT", "SHORT")
OK, OUTPUT = 0, 8
CANNOT = 2  # of a tool


def frames():
    """Blocks that fall for a moment: frames of a dynamic stage, each a file of its own."""
    mesh, scene = scenes.dynamic(0.02, 2)
    scene["stages"][0]["fall"]["frames"] = 2
    scene["relaxation"]["history_every"] = 50
    return mesh, scene


SCENES = {"static": lambda: scenes.static(4), "frames": frames}


class Scene:
    """A folder with a scene, what its undisturbed run comes to, and how many calls that makes."""

    kind = "run"

    def __init__(self, name, quoin, tool, folder):
        self.name, self.quoin, self.tool, self.folder = name, quoin, tool, folder
        folder.mkdir()
        mesh, scene = SCENES[name]()
        write(str(folder / "model.h5"), mesh)
        (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
        self.calls = {failure: self.fail(failure, 0)[2] for failure in FAILURES}
        self.expected = outcome(folder)

    def run(self, *before, more=()):
        command = [*before, self.quoin, "-options_file", "scene.yaml", *more]
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, errors="replace", timeout=120,
                              env=ENVIRONMENT | dict(os.environ))
        return done.returncode, done.stderr

    def fail(self, failure, n):
        """Exit code, stderr, number of calls, and the one that failed."""
        shutil.rmtree(self.folder / "out", ignore_errors=True)
        (self.folder / "out").mkdir()
        code, error = self.run(self.tool, "out", "all", failure, str(n), "log")
        lines = (self.folder / "log").read_text(encoding="utf-8").splitlines()
        return code, error, int(lines[-1].split()[0]), lines[0]

    def whole(self):
        """Whether the folder holds what the undisturbed run has left."""
        check_folder(self.folder / "out")
        left = [path.name for path in (self.folder / "out").rglob("*.part")]
        assert not left, f"left behind: {left}"
        assert outcome(self.folder) == self.expected, "the results are others"

    def check(self, failure, n):
        """Raises AssertionError or what a reader raises; the exit code and the call otherwise."""
        code, error, _, call = self.fail(failure, n)
        said = [line for line in error.splitlines() if line.startswith("quoin: error:")]
        assert code in (OK, OUTPUT), f"exit code {code}: {error}"
        if code == OUTPUT:
            assert len(said) == 1, f"expected one line, not {error!r}"
            again, error = self.run(more=("-restart", "auto"))
            assert again == OK, f"exit code {again} after the restart: {error}"
        self.whole()
        return code, call


class Tool(Scene):
    """A tool that makes files of a run, in a folder where it has made them before."""

    kind = "pictures, sheet"

    def __init__(self, name, quoin, tool, folder):
        self.name, self.quoin, self.tool, self.folder = name, quoin, tool, folder
        folder.mkdir()
        mesh, scene = scenes.static(4)
        write(str(folder / "model.h5"), mesh)
        (folder / "scene.yaml").write_text(yaml.safe_dump(scene | {"stages": scene["stages"][:1]}, sort_keys=False), encoding="utf-8")
        assert self.run()[0] == OK
        self.calls = {failure: self.fail(failure, 0)[2] for failure in FAILURES}
        self.files = sorted(path.name for path in (folder / "out").iterdir())

    def fail(self, failure, n):
        command = [self.tool, "out", "all", failure, str(n), "log", sys.executable, "-m", f"quoin_tools.{self.name}", "out"]
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, errors="replace", timeout=300,
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


TOOLS = ("plots", "report")


def tool_of(quoin, folder):
    tool = Path(quoin).with_name("fail_call")
    if not tool.exists():
        tool = folder / "fail_call"
        subprocess.run(["cc", "-O1", "-o", tool, HERE / "fail_call.c"], check=True)
    return str(tool.resolve())


def works(tool, folder):
    """Whether processes may be traced here."""
    return subprocess.run([tool, folder, "all", "EIO", "0", folder / "log", "true"], capture_output=True).returncode == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default="build/quoin")
    parser.add_argument("--sample", type=int, help="so many calls, drawn at random; all by default")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tools", type=int, default=0, metavar="N", help="as many calls of the tools that make pictures and the sheet, 5 s each")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        tool = tool_of(options.quoin, folder)
        if not works(tool, folder):
            print("calls: left out: processes cannot be traced here (ptrace)")
            return 0
        runs = [Scene(name, str(Path(options.quoin).resolve()), tool, folder / name) for name in SCENES]
        tries = [(run, failure, n) for run in runs for failure in FAILURES for n in range(1, run.calls[failure] + 1)]
        if options.sample:
            tries = random.Random(options.seed).sample(tries, min(options.sample, len(tries)))  # noqa: S311
        if options.tools:
            made = [Tool(name, str(Path(options.quoin).resolve()), tool, folder / name) for name in TOOLS]
            more = [(run, failure, n) for run in made for failure in FAILURES for n in range(1, run.calls[failure] + 1)]
            tries += random.Random(options.seed).sample(more, min(options.tools, len(more)))  # noqa: S311
        ends, bad = Counter(), 0
        for run, failure, n in tries:
            try:
                code, call = run.check(failure, n)
                ends[run.kind, failure, call.split()[0], code] += 1
            except (AssertionError, ValueError, OSError, KeyError) as error:
                bad += 1
                print(f"{run.name}, {failure}, call {n}: {(run.folder / 'log').read_text().splitlines()[0]}: {error}", flush=True)
        for who, code in sorted({(who, code) for who, _, _, code in ends}):
            mine = {(kind, failure): count for (w, failure, kind, c), count in sorted(ends.items()) if (w, c) == (who, code)}
            print(f"{who}, exit code {code}: {sum(mine.values())} ({', '.join(f'{kind} {failure} {n}' for (kind, failure), n in mine.items())})")
        print(f"{len(tries)} failed calls: {bad} lost something")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
