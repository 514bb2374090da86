"""The command `quoin`: what it can be asked to do."""

import difflib
import importlib
import os
import sys
import traceback
import types

import quoin_tools
from quoin_tools.base import solver
from quoin_tools.base.command import command, said

# what calls what: module and function, in a line what it does
WAY = {
    "new": ("front.new:main", "a folder with a section and a scene to begin with"),
    "import": ("mesh.section:imported", "block mesh of a section, a drawing (DXF), a Gmsh file"),
    "check": ("front.running:check", "are scene and mesh right? nothing is run"),
    "advise": ("front.running:advise", "what will a run cost, what can be left out?"),
    "run": ("front.running:run", "runs a scene, with -n on several ranks"),
    "show": ("front.show:main", "numbers of a run; --pictures, --film; picture of a mesh"),
    "report": ("show.report:main", "the sheet of a run, HTML and PDF"),
    "study": ("front.study:main", "a scene over values of its keys: a table"),
    "ensemble": ("front.ensemble:main", "samples of a scene that scatters: how likely it fails"),
    "compare": ("show.compare:main", "two runs: what differs, by how much"),
    "export": ("show.export:main", "a run as CSV; --dxf: as drawings"),
    "schema": ("front.schema:main", "for editors: completes and checks scenes as you write"),
    "help": ("front.topics:main", "keys of the scene and documents: quoin help loads"),
}
TOOLS = {
    "dam": ("mesh.dam:main", "block mesh of a gravity dam on rock"),
    "voronoi": ("mesh.voronoi:main", "block mesh of a dam of random polygons"),
    "walls": ("mesh.walls:main", "block meshes of walls, arches and slopes"),
    "blockmesh": ("mesh.blockmesh:main", "checks a block mesh, or says what is in it"),
    "plot_mesh": ("show.plot_mesh:main", "picture of a block mesh"),
    "section": ("mesh.section:main", "as import"),
    "gmsh_import": ("mesh.gmsh_import:main", "block mesh from a Gmsh file"),
    "results": ("base.results:main", "numbers of a run"),
    "plots": ("show.plots:main", "pictures of a run"),
    "animate": ("show.animate:main", "film of a stage in time, or of how a stage fails"),
    "assessment": ("assess.terminal:main", "the gravity method beside a run, in the terminal"),
    "limit": ("show.limit:main", "what rigid blocks can bear at most, beside the trials of a run"),
    "hinges": ("assess.hinges:main", "how a limit moves with the stiffness of the joints"),
    "motion": ("show.motion:main", "a record, its spectrum, a block that slides; points of a run"),
    "whole": ("base.whole:main", "are the files of a run what it wrote?"),
    "verify": ("show.verify:main", "is a sheet as written, and about these files?"),
}
PACKAGES = {"yaml": "pyyaml", "PIL": "pillow"}  # where a module has another name on PyPI
FAULT = 7  # exit code of a fault of the program, as the solver's


class CommandError(ValueError):
    """No such command, in one line."""


def main(words=None):
    words = list(sys.argv[1:] if words is None else words)
    if not words or words[0] in ("-h", "--help") or words == ["help", "commands"]:
        return command(lambda: print(usage()))
    if words[0] == "--version":
        return command(lambda: print(f"quoin {quoin_tools.__version__}"))
    if words[0].startswith("-"):  # as the solver is called: mpirun -n 2 quoin -options_file scene.yaml
        return ended("", lambda: solver.become(words))
    if words[0] == "help" and words[1:2] and words[1] in WAY | TOOLS:
        words = [words[1], "-h"]
    return ended(words[0], lambda: function_of(words[0])(words[1:]))


def usage():
    lines = ["usage: quoin COMMAND ...        quoin COMMAND -h says more; quoin --version", ""]
    for commands in (WAY, TOOLS):
        lines += [f"  {name:12} {what}" for name, (_, what) in commands.items()] + [""]
    return "\n".join([*lines, "quoin -options_file scene.yaml ... is the solver itself, also behind mpirun;",
                      "quoin -help prints its table of keys."])  # fmt: skip


def function_of(name):
    place = (WAY | TOOLS).get(name)
    if place is None:
        close = difflib.get_close_matches(name, [*WAY, *TOOLS], 1)
        raise CommandError(f"no command '{name}'" + (f"; did you mean {close[0]}?" if close else "; quoin -h lists them"))
    module, function = place[0].split(":")
    return getattr(importlib.import_module(f"quoin_tools.{module}"), function)


def ended(name, task):
    """Exit code of a task; whatever it cannot do is one line. QUOIN_TRACE=1 shows where a fault of the program is."""
    sys.argv[0] = f"quoin {name}".strip()  # by which errors are signed
    try:
        return command(task)
    except Exception as error:
        if os.environ.get("QUOIN_TRACE"):
            raise
        reason = of_package(error)
        if reason:
            return said(reason)
        place = traceback.extract_tb(error.__traceback__)[-1]
        said(f"a fault of the program: {type(error).__name__}: {error} ({os.path.basename(place.filename)}, line {place.lineno}; QUOIN_TRACE=1 prints the whole trace)")
        return FAULT


def of_package(error):
    """What is wrong with the Python packages, where an error comes from one that is not there or that is too old."""
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
