"""`cmake --install` under a clean prefix: a program of another project is built with the installed library, and runs; for another user too.
ranks: 1 2"""

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest
from quoin_tools.base.results import Results
from quoin_tools.mesh import dam

ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
VERSION = re.search(r"^project\(quoin VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), flags=re.M)[1]
NOBODY = 65534
USERS = [None, pytest.param(NOBODY, marks=pytest.mark.skipif(os.geteuid() != 0, reason="only root can be another user"))]

pytestmark = pytest.mark.skipif(not (QUOIN.exists() and (QUOIN.parent / "CMakeCache.txt").exists()), reason="the program is not built")


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
    kept = {key: value for key, value in os.environ.items() if key.startswith(("OMPI_", "OMP_", "OPENBLAS_"))}
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
    return call(["pkg-config", *words, "quoin"], env={"PKG_CONFIG_PATH": str(prefix / "lib/pkgconfig")}).stdout.split()


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
    assert "stage swhp" in call([*ranks, prefix / "bin/quoin-solver", "-options_file", scene], user, cwd=folder).stdout


def test_another_version_is_not_found(prefix, place):
    text = (ROOT / "tests/install/CMakeLists.txt").read_text(encoding="utf-8")
    (place / "later").mkdir()
    (place / "later/CMakeLists.txt").write_text(text.replace("find_package(quoin 0.2 ", "find_package(quoin 9.0 "), encoding="utf-8")
    said = call(["cmake", "-S", place / "later", "-B", place / "later", f"-DCMAKE_PREFIX_PATH={prefix}"], code=1).stderr
    assert 'with requested version "9.0"' in " ".join(said.split())


def test_no_file_knows_the_checkout(prefix):
    """Texts; programs hold names of sources for debuggers."""
    texts = [path for path in prefix.rglob("*") if path.suffix in (".pc", ".cmake", ".h")]
    assert len(texts) == 4
    assert not [path for path in texts if str(ROOT) in path.read_text(encoding="utf-8") or "at first" in path.read_text(encoding="utf-8")]
