"""tools/setup.sh where build/venv is a link: an environment that another checkout has made is used as it is, never emptied."""

import os
import re
import shutil
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MAKE = 'quoin_venv_make() { mkdir -p "$2/bin" && echo "command = python -m venv --clear $2" >"$2/pyvenv.cfg" && ln -sf "$1" "$2/bin/python"; }'


@pytest.fixture
def checkout(tmp_path):
    """The functions of the script without its last line, which calls them; making an environment is only described, and needs no network."""
    *functions, call = (ROOT / "tools/setup.sh").read_text(encoding="utf-8").splitlines()
    assert call.startswith("quoin_setup ||")
    folder = tmp_path / "checkout"
    (folder / "tools").mkdir(parents=True)
    (folder / "build").mkdir()
    (folder / "tools/setup.sh").write_text("\n".join([*functions, 'eval "$MAKE"', ""]), encoding="utf-8")
    for name in ("requirements.txt", "requirements_peers.txt"):
        shutil.copy(ROOT / "tools" / name, folder / "tools")
    return folder


def call(checkout, function, **more):
    done = subprocess.run(["bash", "-c", f"source tools/setup.sh; {function}"], cwd=checkout, capture_output=True, text=True, check=False,
                          env={"PATH": "/usr/bin:/bin", "MAKE": MAKE} | more)  # fmt: skip
    assert not done.stderr
    return done.returncode, re.sub(r"\d+ s$", "done", done.stdout, flags=re.M)


def content(folder):
    return sorted((str(path.relative_to(folder)), path.read_bytes() if path.is_file() else None) for path in folder.rglob("*"))


def environment(folder, command):
    """What stands in an environment that this command has made."""
    (folder / "bin").mkdir(parents=True)
    (folder / "bin/python").symlink_to("/bin/true")
    (folder / "pyvenv.cfg").write_text(f"command = {command}\n", encoding="utf-8")
    (folder / "stamp").write_text("/another/build/venv Python 3.11.2 of other packages\n", encoding="utf-8")


def test_of_another_checkout(checkout, tmp_path):
    other = tmp_path / "other/build/venv"
    environment(other, f"/usr/bin/python3 -m venv --clear {other}")
    (checkout / "build/venv").symlink_to(other)
    before = content(other)
    assert call(checkout, "quoin_venv") == (0, f"setup: build/venv leads to {other}, which is used as it is\n")
    assert call(checkout, "quoin_peers", QUOIN_PEERS="1") == (1, f"setup: build/venv leads to {other}: programs to compare with are installed from there\n")
    assert content(other) == before


def test_of_no_environment(checkout, tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "data/precious").write_text("yes")
    (checkout / "build/venv").symlink_to(tmp_path / "data")
    code, said = call(checkout, "quoin_venv")
    assert code == 1 and said == f"setup: build/venv leads to {tmp_path / 'data'}, which is no Python environment: remove the link\n"
    assert (tmp_path / "data/precious").read_text() == "yes"


@pytest.mark.parametrize("linked", ["", "build", "venv"])
def test_its_own_is_made_and_renewed(checkout, tmp_path, linked):
    """On another disk, too; and again where it is half made, or for other packages."""
    if linked == "build":
        (checkout / "build").rmdir()
    if linked:
        (tmp_path / "disk").mkdir()
        (checkout / "build" / (linked if linked == "venv" else "")).symlink_to(tmp_path / "disk")
    made = "setup: Python environment build/venv ... done\n"
    assert call(checkout, "quoin_venv") == (0, made) and call(checkout, "quoin_venv") == (0, "")
    (checkout / "build/venv/stamp").unlink()
    assert call(checkout, "quoin_venv") == (0, made)
    with open(checkout / "tools/requirements.txt", "a", encoding="utf-8") as file:
        file.write("# more\n")
    assert call(checkout, "quoin_venv") == (0, made) and call(checkout, "quoin_venv") == (0, "")


sys.path.append(str(ROOT / "tools"))

import licences  # noqa: E402
import pins as PINS  # noqa: E402


@pytest.mark.parametrize("name", PINS.LISTS)
def test_pins_have_hashes(name):
    """A line of a list is a pin with a hash or more, or a comment: else pip refuses all of it."""
    text = PINS.LISTS[name].read_text(encoding="utf-8").replace(" \\\n    ", " ")
    for line in text.splitlines():
        assert line.startswith("#") or re.fullmatch(r"[a-z][\w-]*==\S+( --hash=sha256:[0-9a-f]{64})+", line, flags=re.I), line


def test_what_pins_need_is_pinned():
    """In the environment that runs this: what a package of the list needs is in the list, with the version that is here."""
    pinned = PINS.pins(PINS.LISTS["tools/requirements.txt"].read_text(encoding="utf-8"))
    if Path(sys.prefix) != ROOT / "build/venv" and not (ROOT / "build/venv/stamp").exists():
        pytest.skip("build/venv is not what runs this")
    for name, version in pinned.items():
        assert metadata.version(name) == version, name
        for need in metadata.requires(name) or []:
            word, _, condition = need.partition(";")
            if "extra" not in condition and "python_version <" not in condition and "platform" not in condition:
                assert PINS.bare(re.match(r"[\w.-]+", word)[0]) in pinned, (name, need)


def test_scripts_install_by_hashes():
    found = [line for path in (*ROOT.glob("tools/*.sh"), ROOT / ".ci/run") for line in path.read_text(encoding="utf-8").splitlines() if re.search(r"pip install(?! --quiet .*pip)", line)]
    assert found and all("--require-hashes" in line for line in found), found


def test_licences_name_every_pin_and_library():
    """docs/licences.md, which tools/licences.py writes: each package of each list with its version, and whatever the solver is linked with here. It is installed."""
    page = licences.PAGE.read_text(encoding="utf-8")
    for name, version, licence, _ in licences.python_rows():
        assert f"| {name} | {version} | {licence} |" in page, name
    for name, packages in licences.checkers():
        assert f"| {name} | {packages} |" in page, name
    quoin = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
    if quoin.exists() and shutil.which("dpkg-query") and shutil.which("objdump"):
        for source, (version, _, _) in licences.libraries(str(quoin)).items():
            assert version == "not of Debian" or f"| {source} | " in page, source
    assert "docs/licences.md" in (ROOT / "tools/install/CMakeLists.txt").read_text(encoding="utf-8")
    for word in ("FFTW", "SuiteSparse", "Gmsh", "GEOS"):
        assert word in page.partition("## Libraries of the solver")[0]
