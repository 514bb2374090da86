"""Write docs/licences.md: what the solver is linked with and what the tools import, by version and licence, from the metadata of the packages.

    python tools/licences.py [build/quoin]     on Debian, with the Python of build/venv

Licences of libraries are those that Debian's copyright files give the library itself; where such a file cannot be read by a program, or names
licences of several parts, BY_HAND says which counts."""

import re
import subprocess
import sys
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tools"))

from pins import LISTS, NEED, bare, pins  # noqa: E402

PAGE = ROOT / "docs/licences.md"
BY_HAND = {  # Debian's source package: licence of the library that is linked
    "arpack": "BSD-3-Clause", "avahi": "LGPL-2.1+", "brotli": "MIT", "bzip2": "bzip2-1.0.6 (BSD)", "combblas": "BSD-3-Clause", "cups": "Apache-2.0", "curl": "curl (MIT)", "cyrus-sasl2": "BSD-4-Clause-UC", "dbus": "GPL-2+ or AFL-2.1",
    "e2fsprogs": "MIT", "fftw3": "GPL-2+", "gcc-12": "GPL-3+ with the GCC runtime library exception", "gcc-14": "GPL-3+ with the GCC runtime library exception", "glibc": "LGPL-2.1+", "gmp": "LGPL-3+ or GPL-2+",
    "gnutls28": "LGPL-2.1+", "hdf5": "BSD-3-Clause (HDF5)", "hwloc": "BSD-3-Clause", "hypre": "Apache-2.0 or MIT", "keyutils": "LGPL-2.1+", "krb5": "MIT", "libaec": "BSD-2-Clause", "libbsd": "BSD-3-Clause", "libcap2": "BSD-3-Clause or GPL-2",
    "libevent": "BSD-3-Clause", "libffi": "MIT", "libidn2": "LGPL-3+ or GPL-2+", "libmd": "BSD-3-Clause", "libpsl": "MIT", "libssh2": "BSD-3-Clause", "libtasn1-6": "LGPL-2.1+", "libunistring": "LGPL-3+ or GPL-2+",
    "libx11": "MIT", "libxau": "MIT", "libxcb": "MIT", "libxdmcp": "MIT", "libyaml": "MIT", "libzstd": "BSD-3-Clause or GPL-2", "metis": "Apache-2.0", "mumps": "CeCILL-C", "nettle": "LGPL-3+ or GPL-2+", "nghttp2": "MIT",
    "ocl-icd": "BSD-2-Clause", "openblas": "BSD-3-Clause", "openldap": "OpenLDAP-2.8", "openmpi": "BSD-3-Clause", "openssl": "Apache-2.0", "p11-kit": "BSD-3-Clause", "petsc": "BSD-2-Clause", "rtmpdump": "LGPL-2.1+",
    "scalapack": "BSD-3-Clause", "scotch": "CeCILL-C", "slepc": "BSD-2-Clause", "suitesparse": "BSD-3-Clause (AMD, CAMD, COLAMD, CCOLAMD), LGPL-2.1+ (BTF, KLU, CHOLMOD without its supernodal part), GPL-2+ (UMFPACK, SPQR, supernodal CHOLMOD)",
    "superlu": "BSD-3-Clause", "superlu-dist": "BSD-3-Clause", "systemd": "LGPL-2.1+", "trilinos": "BSD-3-Clause (Amesos, Teuchos, Zoltan and most others), LGPL-2.1+ (some)", "xz-utils": "public domain (liblzma)", "zlib": "Zlib",
}  # fmt: skip
PYTHON = {"contourpy": "BSD-3-Clause", "cycler": "BSD-3-Clause", "ezdxf": "MIT", "kiwisolver": "BSD-3-Clause", "markdown-it-py": "MIT", "matplotlib": "Matplotlib (PSF-2.0)", "mdurl": "MIT", "meshio": "MIT", "scipy": "BSD-3-Clause",
          "gmsh": "GPL-2.0-or-later with exceptions", "sortedcontainers": "Apache-2.0", "vtk": "BSD-3-Clause", "shapely": "BSD-3-Clause; GEOS, in its wheel: LGPL-2.1"}  # where the metadata has no short name, or not of what the wheel brings  # fmt: skip
FOR_TESTS = {"hypothesis", "pytest", "setuptools", "vtk"}  # of tools/requirements.txt: no tool imports these

TEXT = """# Licences of what Quoin is linked with and imports

Quoin itself is under the BSD-2-Clause licence ([LICENSE](../LICENSE)). This page lists what it is linked with and what it imports, and says what that means for who hands Quoin on. `python tools/licences.py` writes it from the
metadata of the packages of Debian 12 and of `tools/requirements.txt`. It is no legal advice.

## What it means

- **You run it, or change it for yourself**: nothing. None of these licences restricts use, and what you compute is yours.
- **You hand on the sources**: the BSD-2-Clause licence alone counts. The sources contain none of what is listed here. They contain [uPlot](https://github.com/leeoniya/uPlot) 1.6.32, which draws the charts of `quoin show --html`, under the MIT licence (`tools/quoin_tools/show/page/uPlot.LICENSE`).
- **You hand on the solver as a program** (`quoin-solver`, the Debian package, the container image): on Debian it is linked with libraries under the GPL through PETSc (FFTW; UMFPACK, SPQR and the supernodal part of CHOLMOD, of SuiteSparse). The program as a whole is
  then under the GPL, version 2 or later, for those who get it from you. BSD-2-Clause and the other licences of numerical libraries allow that; Apache-2.0 (METIS) goes with version 3 of the GPL alone, so it is version 3. Give or offer the sources of the program you hand on, under the same terms, with the licence texts. The Debian package does not
  contain these libraries, nor those of the system that they load (OpenSSL, Kerberos, SASL, by way of HDF5's curl): it names them, and Debian has their sources. A container image contains them: then their sources must be offered too, which a reference to Debian's archive of sources of these versions does.
- **You want to hand it on under other terms**: link it with a PETSc that was configured without FFTW, SuiteSparse and Trilinos' and others' parts that you do not want (`--with-fftw=0 --with-suitesparse=0`). Quoin asks PETSc for CHOLMOD only where it is there and takes MUMPS otherwise
  ([reliability](reliability.md#checkers)); nothing of Quoin calls FFTW.
- **You hand on the tools with Gmsh** (`quoin import` and the generators; the Debian package and the container image contain it): Gmsh is under the GPL, version 2 or later, with exceptions that its `LICENSE.txt` names. The tools that import it are then under the GPL for those who get them together with it. Sources: gmsh.info. Without Gmsh the other tools run. Clarabel, which limit analysis imports, is under Apache-2.0, which goes with version 3 of the GPL alone.
- **Shapely's wheel contains GEOS** (LGPL-2.1), which the Debian package contains too: who gets it must be able to replace it, which the shared library allows, and must get its licence and the place of its sources: libgeos.org.
- **The pages of `tools/docs.sh`**, which the Debian package contains where they were built, have scripts and styles of Sphinx (BSD-2-Clause), Furo and sphinx-copybutton (MIT).
- **MUMPS and Scotch** are under CeCILL-C, which is like the LGPL.

In the Debian package `/usr/share/doc/quoin/copyright` says the same of what it contains, and `/usr/lib/quoin/packages/licences` has the texts.
"""


def lines_of(*words):
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.splitlines()


def linked(program):
    """{shared library: path} of all that it loads, and those that it names itself."""
    loaded = dict(found.groups() for line in lines_of("ldd", program) if (found := re.match(r"\s*(\S+) => (/\S+)", line)))
    named = {found[1] for line in lines_of("objdump", "-p", program) if (found := re.match(r"\s*NEEDED\s+(\S+)", line))}
    return loaded, named


def owners(paths):
    """Debian's source package of each file and its version. Debian's list takes a second to search, for one file or for a hundred."""
    places = {path: (path, path.removeprefix("/usr"), str(Path(path).resolve())) for path in paths}
    asked = sorted({place for row in places.values() for place in row})
    done = subprocess.run(["dpkg-query", "-S", *asked], capture_output=True, text=True, check=False)  # exit code 1: it knows some of them only
    package = {place: packages.split(",")[0].strip() for packages, _, place in (line.partition(": ") for line in done.stdout.splitlines())}
    rows = lines_of("dpkg-query", "-W", "-f", "${binary:Package}\t${source:Package}\t${source:Upstream-Version}\n", *sorted(set(package.values()))) if package else []
    source = {name: words for name, *words in (row.split("\t") for row in rows)}
    source |= {name.partition(":")[0]: words for name, words in source.items() if name.partition(":")[0] not in source}
    found = {path: next((package[place] for place in row if place in package), None) for path, row in places.items()}
    return {path: source[name] if name else (Path(path).name, "not of Debian") for path, name in found.items()}


def libraries(program):
    """{source package: (version, libraries, whether the program names one of them itself)}."""
    loaded, named = linked(program)
    found, owner = {}, owners(loaded.values())
    for library, path in sorted(loaded.items()):
        source, version = owner[path]
        row = found.setdefault(source, [version, [], False])
        row[1].append(re.sub(r"\.so.*", "", library))
        row[2] |= library in named
    return found


def python_licence(name):
    if name in PYTHON:
        return PYTHON[name]
    data = metadata.metadata(name)
    said = data.get("License-Expression") or (data.get("License") or "").split("\n")[0]
    return said or ", ".join(c.rpartition(" :: ")[2] for c in data.get_all("Classifier", []) if c.startswith("License ::")) or "not told"


def table(header, rows):
    return "\n".join(f"| {' | '.join(row)} |" for row in (header, ["---"] * len(header), *rows)) + "\n"


def python_rows():
    text = LISTS["tools/requirements.txt"].read_text(encoding="utf-8")
    asked = pins(text.partition(NEED)[0])
    rows = []
    for name, version in pins(text).items():
        what = "tests" if name in FOR_TESTS else "tools" if name in asked else "what these need"
        rows.append((what, name, version, python_licence(name)))
    order = {"tools": 0, "what these need": 1, "tests": 2}
    return [(name, version, licence, what) for what, name, version, licence in sorted(rows, key=lambda row: (order[row[0]], row[1]))]


def checkers():
    """Beside the tools: what only developers install."""
    rows = []
    for name in LISTS:
        if name != "tools/requirements.txt":
            rows.append((f"`{name}`", ", ".join(f"{bare(one)} {version}" for one, version in pins(LISTS[name].read_text(encoding="utf-8")).items())))
    return rows


def main(program=ROOT / "build/quoin"):
    found = libraries(str(program))
    unknown = sorted(set(found) - set(BY_HAND))
    if unknown:
        raise SystemExit(f"licences: what is the licence of {', '.join(unknown)}? BY_HAND does not say")
    rows = [(source, version, ", ".join(sorted(set(names))), BY_HAND[source], "itself" if direct else "through others") for source, (version, names, direct) in sorted(found.items())]
    text = (TEXT + "\n## Libraries of the solver\n\n`ldd build/quoin` on Debian 12; *itself*: the program names one of these libraries, *through others*: only libraries that it loads do.\n\n"
            + table(("source package", "version", "libraries", "licence", "linked"), rows)
            + "\n## Python packages of the tools\n\nThose of `tools/requirements.txt`, as their wheels say.\n\n" + table(("package", "version", "licence", "for"), python_rows())
            + "\n## What only developers install\n\nNothing of this is handed on.\n\n" + table(("list", "packages"), checkers()))  # fmt: skip
    PAGE.write_text(text, encoding="utf-8")
    print(f"wrote {PAGE.relative_to(ROOT)}: {len(rows)} libraries by source package, {len(python_rows())} Python packages")


if __name__ == "__main__":
    main(*sys.argv[1:])
