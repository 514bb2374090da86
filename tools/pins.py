"""Pin the Python packages with their hashes: each list that pip installs from, what these packages need too.

    python tools/pins.py             writes the lists again; network is needed, nothing is installed but a new pip in a folder of its own
    python tools/pins.py NAME...     some of them, such as requirements.txt

To change a version: change it in the upper part of the list, above the line `# what these need`, and run this. Hashes are those of the wheels for
x86-64 and the versions of Python below. What these need keeps its version where that still fits.
"""

import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LISTS = {name: ROOT / name for name in ("tools/requirements.txt", "tools/requirements_checkers.txt", "tools/requirements_docs.txt", "tools/requirements_peers.txt", "tools/requirements_petsc.txt",
                                        "tests/fuzz/requirements.txt")}  # fmt: skip
ALONE = ("tools/requirements_peers.txt",)  # installed with --no-deps
PYTHONS = ("3.11", "3.12", "3.13")  # the first must have a wheel of each package
PLATFORMS = ["linux_x86_64", "manylinux1_x86_64", "manylinux2010_x86_64", "manylinux2014_x86_64", *(f"manylinux_2_{k}_x86_64" for k in range(5, 37))]
NEED = "# what these need"
PIN = re.compile(r"^([A-Za-z0-9][\w.-]*)==([^\s\\]+)", flags=re.M)


def bare(name):
    """As package indexes compare names."""
    return re.sub(r"[-_.]+", "-", name).lower()


def pins(text):
    """{name: version} of a list, all of it."""
    return {bare(name): version for name, version in PIN.findall(text)}


def resolved(pip, wanted, keep, python, alone):
    """{name: (version, hash)} of what pip would install, or None where something has no wheel for this Python."""
    with tempfile.TemporaryDirectory() as folder:
        constraints, report = Path(folder) / "keep.txt", Path(folder) / "report.json"
        constraints.write_text("".join(f"{name}=={version}\n" for name, version in keep.items()), encoding="utf-8")
        words = [pip, "install", "--quiet", "--dry-run", "--ignore-installed", "--only-binary", ":all:", "--python-version", python, "--target", folder, "--report", report,
                 *(word for name in PLATFORMS for word in ("--platform", name)), *(["--no-deps"] if alone else ["-c", constraints]), *(f"{n}=={v}" for n, v in wanted.items())]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode:
            print(f"Python {python}: {done.stderr.strip().splitlines()[-1]}", file=sys.stderr)
            return None
        found = json.loads(report.read_text(encoding="utf-8"))["install"]
    return {bare(one["metadata"]["name"]): (one["metadata"]["version"], one["download_info"]["archive_info"]["hashes"]["sha256"]) for one in found}


def entry(name, version, hashes):
    return " \\\n".join([f"{name}=={version}", *(f"    --hash=sha256:{one}" for one in sorted(hashes))]) + "\n"


def lock(name, pip):
    """Writes one list again."""
    path = LISTS[name]
    text = path.read_text(encoding="utf-8")
    upper = text.partition(NEED)[0]
    head = "".join(line + "\n" for line in upper.splitlines() if line.startswith("#"))
    wanted = pins(upper)
    keep = {one: version for one, version in pins(text).items() if one not in wanted}
    versions, hashes = {}, {}
    for python in PYTHONS:
        found = resolved(pip, wanted, keep, python, name in ALONE)
        if found is None and python == PYTHONS[0]:
            raise SystemExit(f"{name}: no list for Python {python}")
        for one, (version, digest) in (found or {}).items():
            if versions.setdefault(one, version) != version:
                raise SystemExit(f"{name}: {one} is {versions[one]} and, for Python {python}, {version}: pin it in the upper part")
            hashes.setdefault(one, set()).add(digest)
    lower = sorted(set(versions) - set(wanted))
    body = "".join(entry(one, versions[one], hashes[one]) for one in wanted)
    rest = f"{NEED}\n" + "".join(entry(one, versions[one], hashes[one]) for one in lower) if lower else ""
    path.write_text(head + body + rest, encoding="utf-8")
    print(f"{name}: {len(wanted)} packages and {len(lower)} that these need")


def main(names):
    unknown = [name for name in names if name not in LISTS and f"tools/{name}" not in LISTS]
    if unknown:
        raise SystemExit(f"{unknown[0]}: no list; there are: {', '.join(LISTS)}")
    with tempfile.TemporaryDirectory() as folder:  # Debian's pip would load each wheel to know what it needs
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        pip = str(Path(folder) / "bin/pip")
        subprocess.run([pip, "install", "--quiet", "--disable-pip-version-check", "--upgrade", "pip"], check=True)
        for name in LISTS:
            if not names or name in names or name.removeprefix("tools/") in names:
                lock(name, pip)


if __name__ == "__main__":
    main(sys.argv[1:])
