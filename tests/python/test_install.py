"""`cmake --install` under a clean prefix: a program of another project is built with the installed library, and runs; for another user too. `cpack`: the Debian packages."""

import ast
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

import pytest
from quoin_tools.base.results import Results
from quoin_tools.front import main
from quoin_tools.mesh import dam

ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
VERSION = re.search(r"^project\(quoin VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), flags=re.M)[1]
NOBODY = 65534
SOON = ["-relaxation_tolerance", "1e-2", "-relaxation_velocity_tolerance", "1e-2"]  # on a machine with other work two ranks wait for each other


def is_possible():
    """Whether this process can be another user, who reaches the Python of these tests."""
    try:
        return subprocess.run([sys.executable, "-c", ""], user=NOBODY, group=NOBODY, extra_groups=[], check=False, capture_output=True).returncode == 0
    except OSError:
        return False


USERS = [None, pytest.param(NOBODY, marks=pytest.mark.skipif(not is_possible(), reason="needs root, and a Python that others may run"))]

pytestmark = [pytest.mark.long, pytest.mark.skipif(not (QUOIN.exists() and (QUOIN.parent / "CMakeCache.txt").exists()), reason="the program is not built")]


@pytest.fixture(scope="module")
def place():
    """A folder that other users may look into, which those of pytest are not."""
    with tempfile.TemporaryDirectory(prefix="quoin-install-") as folder:
        os.chmod(folder, 0o755)  # noqa: S103
        yield Path(folder)


@pytest.fixture(scope="module")
def prefix(place):
    """Installed, then moved: no file may know where it was."""
    call(["cmake", "--install", QUOIN.parent, "--prefix", place / "at first"])
    (place / "at first").rename(place / "prefix")
    return place / "prefix"


@pytest.fixture(scope="module")
def scene(place):
    assert dam.main(["-o", str(place / "model.h5"), "--columns", "3"]) == 0
    shutil.copy(ROOT / "examples/guilhofrei/scene.yaml", place)
    return place / "scene.yaml"


def call(words, user=None, code=0, **options):
    """Runs a command in an environment that knows nothing of this checkout."""
    kept = {key: value for key, value in os.environ.items() if key.startswith(("OMPI_", "OMP_", "OPENBLAS_", "LD_LIBRARY_PATH", "PKG_CONFIG_PATH"))}
    who = {} if user is None else {"user": user, "group": user, "extra_groups": []}
    environment = kept | {"PATH": "/usr/local/bin:/usr/bin:/bin"} | options.pop("env", {})
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False, env=environment, **who, **options)
    assert done.returncode == code, f"{words}: exit code {done.returncode}\n{done.stdout}{done.stderr}"
    return done


def folder_of(user, place):
    """A working directory that belongs to the user."""
    folder = Path(tempfile.mkdtemp(dir=place))
    if user is not None:
        os.chown(folder, user, user)
    return folder


def flags(prefix, *words):
    return call(["pkg-config", *words, "quoin"], env={"PKG_CONFIG_PATH": f"{prefix / 'lib/pkgconfig'}:{os.environ.get('PKG_CONFIG_PATH', '')}"}).stdout.split()


@pytest.fixture(scope="module")
def by_pkg_config(prefix, place):
    assert flags(prefix, "--modversion") == [VERSION]
    call(["cc", ROOT / "tests/install/solve.c", "-o", place / "by pkg-config", *flags(prefix, "--cflags", "--libs")])
    return place / "by pkg-config"


@pytest.fixture(scope="module")
def by_cmake(prefix, place):
    call(["cmake", "-S", ROOT / "tests/install", "-B", place / "build", f"-DCMAKE_PREFIX_PATH={prefix}"])
    call(["cmake", "--build", place / "build"])
    return place / "build/solve"


@pytest.mark.parametrize("user", USERS)
@pytest.mark.parametrize("way", ["by_pkg_config", "by_cmake"])
def test_a_program_with_the_library(way, user, scene, place, request):
    """It finds what the solver finds, and refuses in one line."""
    folder = folder_of(user, place)
    program = request.getfixturevalue(way)
    call([program, scene], user, cwd=folder)
    call([QUOIN, "-options_file", scene, "-output", place / f"{way} {user}"])
    assert Results(folder / "out/guilhofrei").summary["stages"][-1]["checksum"] == Results(place / f"{way} {user}").summary["stages"][-1]["checksum"]
    assert call([program, "none.yaml"], user, code=2, cwd=folder).stderr == "quoin: error: none.yaml: cannot read the scene: No such file or directory\n"


@pytest.mark.parametrize("user", USERS)
def test_the_installed_solver(prefix, scene, place, user):
    folder = folder_of(user, place)
    ranks = ["mpirun", "-n", "2", "--oversubscribe", "--bind-to", "none"]
    assert "stage hp" in call([*ranks, prefix / "bin/quoin-solver", "-options_file", scene, "-stages", "hp", *SOON], user, cwd=folder).stdout


def test_another_version_is_not_found(prefix, place):
    text = (ROOT / "tests/install/CMakeLists.txt").read_text(encoding="utf-8")
    (place / "later").mkdir()
    (place / "later/CMakeLists.txt").write_text(re.sub(r"find_package\(quoin [\d.]+ ", "find_package(quoin 9.0 ", text), encoding="utf-8")
    said = call(["cmake", "-S", place / "later", "-B", place / "later", f"-DCMAKE_PREFIX_PATH={prefix}"], code=1).stderr
    assert 'with requested version "9.0"' in " ".join(said.split())


def test_no_file_knows_the_checkout(prefix):
    """Texts; programs hold names of sources for debuggers."""
    texts = [path for path in prefix.rglob("*") if path.suffix in (".pc", ".cmake", ".h") and "site" not in path.parts]
    assert len(texts) == 4
    assert not [path for path in texts if str(ROOT) in path.read_text(encoding="utf-8") or "at first" in path.read_text(encoding="utf-8")]


# ---- the command quoin: of the prefix, as a Python package, of the checkout


def uses(command, user, scene, place, env):
    """A new dam, checked and run on two ranks by a user in a folder of his own; nothing is asked of the environment."""
    folder = folder_of(user, place)
    options = {"cwd": folder, "env": env | {"HOME": str(folder), "MPLCONFIGDIR": str(folder)}}
    assert call([*command, "--version"], user, **options).stdout == f"quoin {VERSION}\n"
    call([*command, "new", "dam", "--columns", "3"], user, **options)
    options["cwd"] = folder / "dam"
    call([*command, "check", "scene.yaml"], user, **options)
    call([*command, "run", "-n", "2", "scene.yaml", "-stages", "empty", *SOON], user, **options)
    assert "Extreme principal stresses" in call([*command, "show", "out"], user, **options).stdout
    assert call([*command, "show", "out", "--html"], user, **options).stdout == "out/view.html\n"
    assert call([*command, "report", "out"], user, **options).stdout == "out/report.html\n"
    assert "loads.<name>.level" in call([*command, "help", "loads"], user, **options).stdout
    assert call([*command, "run", "none.yaml"], user, code=2, **options).stderr.startswith("quoin: error: none.yaml")


@pytest.mark.parametrize("user", USERS)
def test_the_installed_command(prefix, scene, place, user):
    """By its place, and by a link to it."""
    link = folder_of(user, place) / "quoin"
    link.symlink_to(prefix / "bin/quoin")
    uses([link], user, scene, place, {"QUOIN_PYTHON": sys.executable})


@pytest.fixture(scope="module")
def package(place):
    """`pip install .` into an environment of its own, of the wheel that pip builds; what it depends on is that of these tests."""
    pip = [sys.executable, "-m", "pip", "-q", "--disable-pip-version-check"]
    before = sorted(ROOT.iterdir())
    call([*pip, "wheel", "--no-deps", "--no-build-isolation", "-w", place / "wheels", ROOT])
    assert sorted(ROOT.iterdir()) == before and not (ROOT / "build/lib").exists()
    (wheel,) = (place / "wheels").iterdir()
    assert wheel.name == f"quoin-{VERSION}-py3-none-any.whl"
    call([sys.executable, "-m", "venv", "--without-pip", place / "venv"])
    call([*pip, "--python", place / "venv/bin/python", "install", "--no-deps", "--no-index", wheel])
    (packages,) = (place / "venv/lib").glob("python*/site-packages")
    (packages / "theirs.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    return place / "venv/bin"


@pytest.mark.parametrize("user", USERS)
def test_the_python_package(package, prefix, scene, place, user):
    """With the solver on the PATH; without it, it says what is missing."""
    uses([package / "quoin"], user, scene, place, {"PATH": f"{prefix / 'bin'}:/usr/bin:/bin"})
    assert "the solver is not installed" in call([package / "quoin", "run", "scene.yaml"], user, code=2).stderr
    told = call([package / "python", "-c", "import quoin; print(quoin.__version__, quoin.run.__module__, quoin.__file__)"], user, cwd="/").stdout
    assert told.startswith(f"{VERSION} quoin_tools.front.python {place / 'venv'}")


@pytest.mark.parametrize("user", USERS)
def test_a_shell_of_the_checkout(scene, place, user):
    """`source tools/setup.sh` for who owns the checkout (here without its making anything, which other tests do), and for who does not."""
    checkout = folder_of(None, place)
    os.chmod(checkout, 0o755)  # noqa: S103
    shutil.copytree(ROOT / "tools", checkout / "tools", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "docs", checkout / "docs", ignore=shutil.ignore_patterns("img", "data"))
    shutil.copy(ROOT / "CMakeLists.txt", checkout)
    (checkout / "build/bin").mkdir(parents=True)
    shutil.copy(QUOIN, checkout / "build")
    (checkout / "build/venv").symlink_to(sys.prefix)
    launcher = (QUOIN.parent / "bin/quoin").read_text(encoding="utf-8")
    (checkout / "build/bin/quoin").write_text(launcher.replace(str(QUOIN.parent), str(checkout / "build")).replace(str(ROOT), str(checkout)), encoding="utf-8")
    (checkout / "build/bin/quoin").chmod(0o755)
    shell = place / f"shell {user}"
    if user is None:
        script = (checkout / "tools/setup.sh").read_text(encoding="utf-8")
        assert script.count("\nquoin_setup || {") == 1
        (checkout / "tools/setup.sh").write_text(script.replace("\nquoin_setup || {", "\nquoin_environment || {"), encoding="utf-8")
    shell.write_text(f'#!/bin/bash\n. "{checkout}/tools/setup.sh" && exec "${{WHAT:-quoin}}" "$@"\n', encoding="utf-8")
    shell.chmod(0o755)
    uses([shell], user, scene, place, {})
    told = call([shell, "-c", "import quoin; print(quoin.__file__)"], user, env={"WHAT": "python"}, cwd="/").stdout
    assert told == f"{checkout / 'tools/quoin.py'}\n"
    if user is not None:
        assert not (checkout / "build/setup.log").exists()
        (checkout / "build/bin/quoin").unlink()
        said = call([shell, "--version"], user, code=1).stdout
        assert said == f"setup: build/bin/quoin is not there, and {checkout} belongs to another user, who can run tools/setup.sh\n"


# ---- the Debian packages


@pytest.fixture(scope="module")
def packages(place):
    """Files of the two packages, not compressed; clean_system.sh installs them."""
    missing = [name for name in ("cpack", "dpkg-deb", "dpkg-shlibdeps", "file") if shutil.which(name) is None]
    if missing:
        pytest.skip(f"no {missing[0]} here")
    call(["cpack", "--config", QUOIN.parent / "CPackConfig.cmake", "-B", place / "packages", "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=none"],
         env={"DEBFULLNAME": "A. Builder", "DEBEMAIL": "a@b.example"})  # fmt: skip
    made = {path.name.split("_")[0]: path for path in (place / "packages").glob("*.deb")}
    architecture = call(["dpkg", "--print-architecture"]).stdout.strip()
    assert {path.name for path in made.values()} == {f"{name}_{VERSION}-1_{architecture}.deb" for name in ("quoin", "libquoin-dev")}
    return made


@pytest.fixture(scope="module")
def unpacked(packages, place):
    for package in packages.values():
        call(["dpkg-deb", "-x", package, place / "system"])
    return place / "system"


def field(package, name):
    return call(["dpkg-deb", "-f", package, name]).stdout.strip()


def test_fields_of_the_packages(packages):
    command, library = packages["quoin"], packages["libquoin-dev"]
    assert field(command, "Section") == "science" and field(library, "Section") == "libdevel"
    assert field(command, "Maintainer") == field(library, "Maintainer") == "A. Builder <a@b.example>"
    assert field(command, "Version") == field(library, "Version") == f"{VERSION}-1"
    for package in (command, library):
        summary, *more = field(package, "Description").splitlines()
        assert len(summary) < 80 and more
    depends = field(command, "Depends")
    assert all(re.search(rf"(^|, ){name}", depends) for name in ("libc6", "libpetsc", "libslepc", "libmetis5", "libyaml-0-2", "openmpi-bin", "python3 ")), depends
    assert all(re.search(rf"(^|, ){name}", field(library, "Depends")) for name in ("libpetsc-real3.*-dev", "libslepc-real3.*-dev", "libmetis-dev"))


def loads_with_commands(trees):
    """Returns the modules of quoin_tools that load as a command loads: those of main.COMMANDS and main.FORMS, and what they import outside functions."""
    house = ROOT / "tools/quoin_tools"
    named = [place for place, _ in main.COMMANDS.values()] + [place for forms in main.FORMS.values() for place in forms.values()]
    left, found = [house / "front/main.py", *(house / f"{place.partition(':')[0].replace('.', '/')}.py" for place in named)], set()
    while left:
        path = left.pop()
        if path in found or path not in trees:
            continue
        found.add(path)
        for node in trees[path].body:
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("quoin_tools"):
                place = ROOT / "tools" / node.module.replace(".", "/")
                left += [place.with_suffix(".py"), *(place / f"{alias.name}.py" for alias in node.names)]
    return found


def test_every_python_package_is_named(packages):
    """What a command imports when it loads is needed by all; what a function imports, by who calls it."""
    at_once, later = set(), set()
    trees = {path: ast.parse(path.read_text(encoding="utf-8")) for path in (ROOT / "tools/quoin_tools").rglob("*.py")}
    loaded = loads_with_commands(trees)
    for path, tree in trees.items():
        for where, nodes in ((at_once, tree.body if path in loaded else ()), (later, ast.walk(tree))):
            for node in nodes:
                names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else [node.module] if isinstance(node, ast.ImportFrom) else []
                where.update(name.split(".")[0].replace("PIL", "pil") for name in names)
    known = {*sys.stdlib_module_names, "quoin_tools", "clarabel", "gmsh", "shapely", "paraview"}  # three are in the package; paraview has its own Python
    names = {kind: set(re.findall(r"python3-(\w+)", field(packages["quoin"], kind))) for kind in ("Depends", "Recommends", "Suggests")}
    assert {"numpy", "h5py"} <= at_once - known <= names["Depends"]
    assert {"numpy", "ezdxf"} <= later - known <= set.union(*names.values())


def test_files_of_the_packages(packages, unpacked):
    for name, package in packages.items():
        listed = [line.split(None, 5) for line in call(["dpkg-deb", "-c", package]).stdout.splitlines()]
        assert {row[1] for row in listed} == {"root/root"}
        assert {row[0] for row in listed} <= {"drwxr-xr-x", "-rw-r--r--", "-rwxr-xr-x"}
        assert not [row[5] for row in listed if re.search("__pycache__|/tests/|venv", row[5])]
        assert {f"./usr/share/doc/{name}/copyright", f"./usr/share/doc/{name}/changelog.Debian.gz"} <= {row[5] for row in listed}
    files = {str(path.relative_to(unpacked)) for path in unpacked.rglob("*") if path.is_file()}
    assert {"usr/bin/quoin", "usr/bin/quoin-solver", "usr/lib/quoin/quoin.py", "usr/lib/quoin/quoin_tools/docs/install.md", "usr/include/quoin.h", "usr/lib/libquoin.a",
            "usr/lib/pkgconfig/quoin.pc", "usr/lib/cmake/quoin/quoinConfig.cmake", "usr/share/bash-completion/completions/quoin"} <= files  # fmt: skip
    assert (unpacked / "usr/lib/python3/dist-packages/quoin.pth").read_text(encoding="utf-8") == "/usr/lib/quoin\n"
    place = str(QUOIN.parent).encode()
    assert not [name for name in files if place in (unpacked / name).read_bytes() or str(ROOT).encode() in (unpacked / name).read_bytes()]
    scripts = unpacked.parent / "control"
    call(["dpkg-deb", "-e", packages["quoin"], scripts])
    for script in ("postinst", "prerm"):
        assert os.access(scripts / script, os.X_OK)
        call(["sh", "-n", scripts / script])


def test_the_command_of_the_package(unpacked, place):
    """With the Python of these tests; Clarabel, Gmsh and Shapely are those of the package."""
    command, folder = unpacked / "usr/bin/quoin", folder_of(None, place)
    options = {"env": {"QUOIN_PYTHON": sys.executable, "HOME": str(folder)}}
    assert call([command, "--version"], **options).stdout == f"quoin {VERSION}\n"
    call([command, "new", folder / "dam", "--columns", "3"], **options)
    assert "stage empty" in call([command, "run", "-n", "2", "scene.yaml", "-stages", "empty", *SOON], cwd=folder / "dam", **options).stdout
    told = call([sys.executable, "-c", "import quoin, clarabel, gmsh, shapely; print(clarabel.__file__, gmsh.__file__, shapely.__file__)"], env={"PYTHONPATH": str(unpacked / "usr/lib/quoin")}).stdout
    packages = unpacked / "usr/lib/quoin/packages"
    assert told == f"{packages}/clarabel/__init__.py {packages}/gmsh.py {packages}/shapely/__init__.py\n"
