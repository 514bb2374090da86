#!/usr/bin/env bash
# Builds the newest PETSc with debugging on and SLEPc of its version, from their source packages on PyPI, Quoin against them, and runs
# the suite: so Debian's 3.18 and the newest both stay supported, and mistakes in collective calls show. Takes half an hour.
#   ./tools/newest_petsc.sh [ctest arguments]
#   QUOIN_PETSC_VERSION=3.25.6 ./tools/newest_petsc.sh     another version
# PETSc, SLEPc and the build stay in build-petsc/; a second call builds what has changed.
set -euo pipefail
export QUOIN_PACKAGES="${QUOIN_PACKAGES:-} gfortran g++ libmumps-dev libscalapack-openmpi-dev libblas-dev liblapack-dev"
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
here=$QUOIN_ROOT/build-petsc
mkdir -p "$here"

# the directory of the unpacked sources of a package, of a version ("3.24.*": the newest of these; "": the newest)
quoin_sources() {
  local name=$1 version=$2 archive
  (cd "$here" && venv/bin/python -m pip download --quiet --disable-pip-version-check \
    --no-build-isolation --no-deps --no-binary "$name" "$name${version:+==$version}" >&2) || return 1
  archive=$(find "$here" -maxdepth 1 -name "$name-${version:-*}.tar.gz" | sort -V | tail -n 1)
  [ -d "${archive%.tar.gz}" ] || tar -xzf "$archive" -C "$here" || return 1
  echo "${archive%.tar.gz}"
}

# MPI, HDF5, MUMPS and ScaLAPACK are Debian's, as in the package of PETSc 3.18
quoin_petsc_build() {
  local multiarch
  multiarch=$(gcc -print-multiarch)
  cd "$PETSC_DIR"
  if [ ! -f "$PETSC_ARCH/lib/petsc/conf/petscvariables" ]; then
    ./configure PETSC_ARCH="$PETSC_ARCH" --with-debugging=1 COPTFLAGS="-g -O1" --with-fortran-bindings=0 --with-x=0 \
      --with-hdf5-include=/usr/include/hdf5/openmpi --with-hdf5-lib="-L/usr/lib/$multiarch/hdf5/openmpi -lhdf5" \
      --with-scalapack-lib=-lscalapack-openmpi --with-mumps-include=/usr/include \
      --with-mumps-lib="-ldmumps -lmumps_common -lpord" || return 1
  fi
  make PETSC_ARCH="$PETSC_ARCH" PETSC_DIR="$PETSC_DIR" libs
}

# pip asks a source package for its metadata before it keeps it; SLEPc's would have pip build another PETSc for that, were they isolated
quoin_petsc_pip() {
  [ -x "$here/venv/bin/wheel" ] || { "$QUOIN_ROOT/build/venv/bin/python" -m venv "$here/venv" &&
    "$here/venv/bin/python" -m pip install --disable-pip-version-check --require-hashes -r "$QUOIN_ROOT/tools/requirements_petsc.txt"; }
}

# a SLEPc fits the PETSc of its minor version; the newest patch of each may differ
quoin_slepc_build() {
  cd "$SLEPC_DIR"
  [ -f "$PETSC_ARCH/lib/slepc/conf/slepcvariables" ] || ./configure || return 1
  make
}

quoin_step "Python environment build-petsc/venv" quoin_petsc_pip
PETSC_DIR=$(quoin_sources petsc "${QUOIN_PETSC_VERSION:-}")
export PETSC_DIR PETSC_ARCH=quoin-debug
quoin_step "$(basename "$PETSC_DIR"), debugging on (build-petsc/)" quoin_in_subshell quoin_petsc_build
minor=$(basename "$PETSC_DIR" | sed -E 's/petsc-([0-9]+\.[0-9]+).*/\1/')
SLEPC_DIR=$(quoin_sources slepc "$minor.*")
export SLEPC_DIR
quoin_step "$(basename "$SLEPC_DIR") (build-petsc/)" quoin_in_subshell quoin_slepc_build
cd "$QUOIN_ROOT"
export PKG_CONFIG_PATH=$PETSC_DIR/$PETSC_ARCH/lib/pkgconfig:$SLEPC_DIR/$PETSC_ARCH/lib/pkgconfig # not Debian's
cmake --preset newest-petsc
cmake --build "$here/quoin" -j "$(quoin_cores)"
exec ctest --test-dir "$here/quoin" --output-on-failure -j 2 "$@"
