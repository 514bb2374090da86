"""Runs the command `quoin`: finds the function of a command, and says in one line why it failed."""

import difflib
import importlib
import os
import sys
import traceback
import types

import quoin_tools
from quoin_tools.base import solver
from quoin_tools.base.command import command, print_error

# each command: module and function; its line in `quoin -h`
COMMANDS = {
    "new": ("front.new:main", "makes a folder with a section, its mesh and a scene"),
    "import": ("front.importing:main", "makes a block mesh: section, drawing, Gmsh; dam, walls"),
    "check": ("front.running:check", "checks a scene, a mesh, a run; --advise: the cost"),
    "run": ("front.running:run", "runs a scene, with -n on several ranks"),
    "show": ("front.show:main", "numbers of a run; --pictures, --film, --html; a mesh"),
    "report": ("show.report:main", "the sheet of a run; --terminal, --verify"),
    "study": ("front.study:main", "runs a scene for each value of its keys: a table"),
    "ensemble": ("front.ensemble:main", "runs samples of random properties: probability of failure"),
    "readings": ("front.readings:main", "readings of instruments: findings, HST and HTT, drift"),
    "limit": ("show.limit:main", "limit analysis of rigid blocks; --hinges: of joints"),
    "motion": ("show.motion:main", "ground motions: spectrum, sliding block, points of a run"),
    "compare": ("show.compare:main", "compares two runs: what differs, by how much"),
    "export": ("show.export:main", "writes a run as CSV; --dxf: as drawings; --paraview"),
    "help": ("front.topics:main", "explains keys and chapters: quoin help loads; --site; --schema"),
}
# options that choose another function of a command
FORMS = {
    "check": {"--advise": "front.running:advise"},
    "show": {"--pictures": "show.plots:main", "--film": "show.animate:main", "--html": "show.viewer:main"},
    "report": {"--terminal": "assess.terminal:main", "--verify": "show.verify:main"},
    "limit": {"--hinges": "assess.hinges:main"},
    "help": {"--schema": "front.schema:main", "--site": "front.site:main"},
}
# commands of earlier versions: module and function; the words of today
FORMER = {
    "advise": ("front.running:advise", "check --advise"),
    "animate": ("show.animate:main", "show --film"),
    "assessment": ("assess.terminal:main", "report --terminal"),
    "blockmesh": ("mesh.blockmesh:main", "check"),
    "dam": ("mesh.dam:main", "import dam"),
    "gmsh_import": ("mesh.gmsh_import:main", "import"),
    "hinges": ("assess.hinges:main", "limit --hinges"),
    "plot_mesh": ("show.plot_mesh:main", "show"),
    "plots": ("show.plots:main", "show --pictures"),
    "results": ("base.results:main", "show"),
    "schema": ("front.schema:main", "help --schema"),
    "section": ("mesh.section:main", "import"),
    "verify": ("show.verify:main", "report --verify"),
    "voronoi": ("mesh.voronoi:main", "import voronoi"),
    "walls": ("mesh.walls:main", "import walls"),
    "whole": ("base.integrity:main", "check"),
}
PACKAGES = {"yaml": "pyyaml", "PIL": "pillow"}  # where a module has another name on PyPI
FAULT = 7  # exit code of a fault of the program, as the solver's


class CommandError(ValueError):
    """There is no such command; the message is one line."""


def main(words=None):
    words = list(sys.argv[1:] if words is None else words)
    if not words or words[0] in ("-h", "--help") or words == ["help", "commands"]:
        return command(lambda: print(usage()))
    if words[0] == "--version":
        return command(lambda: print(f"quoin {quoin_tools.__version__}"))
    if words[0].startswith("-"):  # as the solver is called: mpirun -n 2 quoin -options_file scene.yaml
        return ended("", lambda: solver.become(words))
    if words[0] == "help" and words[1:2] and words[1] in COMMANDS | FORMER:
        words = [words[1], "-h"]
    return ended(words[0], lambda: run(*words))


def usage():
    lines = ["usage: quoin COMMAND ...        quoin COMMAND -h says more; quoin --version", ""]
    lines += [f"  {name:12} {what}" for name, (_, what) in COMMANDS.items()]
    return "\n".join([*lines, "", "quoin -options_file scene.yaml ... is the solver itself, also behind mpirun;",
                      "quoin -help prints its table of keys."])  # fmt: skip


def run(name, *words):
    """Runs a command with the words behind it. Returns its exit code; of several functions the largest."""
    if name in FORMER:
        place, today = FORMER[name]
        print(f"quoin: {name} is now: quoin {today}", file=sys.stderr)
        return function_at(place)(list(words))
    if name not in COMMANDS:
        close = difflib.get_close_matches(name, [*COMMANDS, *FORMER], 1)
        raise CommandError(f"no command '{name}'" + (f"; did you mean {close[0]}?" if close else "; quoin -h lists them"))
    forms = FORMS.get(name, {})
    chosen = [word for word in words if word in forms]
    rest = [word for word in words if word not in forms]
    return max(function_at(place)(rest) for place in [forms[word] for word in chosen] or [COMMANDS[name][0]])


def function_at(place):
    module, function = place.split(":")
    return getattr(importlib.import_module(f"quoin_tools.{module}"), function)


def ended(name, task):
    """Runs a task. Returns its exit code; an error becomes one line. QUOIN_TRACE=1 prints the trace of a fault of the program."""
    sys.argv[0] = f"quoin {name}".strip()  # the name in front of error messages
    try:
        return command(task)
    except Exception as error:
        if os.environ.get("QUOIN_TRACE"):
            raise
        reason = of_package(error)
        if reason:
            return print_error(reason)
        place = traceback.extract_tb(error.__traceback__)[-1]
        print_error(f"a fault of the program: {type(error).__name__}: {error} ({os.path.basename(place.filename)}, line {place.lineno}; QUOIN_TRACE=1 prints the whole trace)")
        return FAULT


def of_package(error):
    """Returns which Python package is missing or too old, None where an error has another cause."""
    if isinstance(error, ModuleNotFoundError) and error.name and not error.name.startswith("quoin"):
        module = error.name.split(".")[0]
        package = PACKAGES.get(module, module)
        if sys.prefix == "/usr" and os.path.exists("/usr/bin/apt-get"):  # Debian's Python, which pip may not change
            package, how = f"python3-{module.lower()}", "apt-get install"
        else:
            how = "pip install"
        return f"needs the Python package {package}, which {sys.executable} lacks: {how} {package}"
    module = getattr(error, "obj", None) if isinstance(error, AttributeError) else None
    if isinstance(module, types.ModuleType) and not module.__name__.startswith("quoin"):
        package = module.__name__.split(".")[0]
        version = getattr(sys.modules.get(package), "__version__", "installed")
        return f"the Python package {package} {version} of {sys.executable} has no {module.__name__}.{error.name}: another version is needed"
    return None
