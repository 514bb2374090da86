#!/usr/bin/env bash
# Makes the checkout ready to run: Debian packages, Python environment build/venv, program build/quoin.
# Does only what is missing; details of each step go to build/setup.log. A build/venv that is a link to another checkout's stays as it is.
#
#   ./tools/setup.sh             once
#   source tools/setup.sh        the same, and leaves the environment in this shell: the command quoin, venv, Open MPI, threads
#
# A user to whom the checkout does not belong can source it where its owner has set it up; nothing is made then.
#
# QUOIN_PRESET (release, package, test, ci) chooses the CMake preset; QUOIN_PACKAGES adds Debian packages; QUOIN_PEERS=1 adds the
# programs that tests/benchmark/peers.py compares with.

QUOIN_ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# Debian packages; "a|b" is satisfied by either and installs a
# shellcheck disable=SC2206  # QUOIN_PACKAGES is a list of words
quoin_packages=(
  gcc make libc6-dev cmake pkgconf                                  # build
  libpetsc-real-dev libslepc-real-dev                               # PETSc, SLEPc
  libhdf5-openmpi-dev libopenmpi-dev openmpi-bin                    # HDF5, MPI
  libmetis-dev libyaml-dev zlib1g-dev
  dpkg-dev file                                                     # cpack
  'libopenblas0-serial|libopenblas0-pthread|libopenblas0-openmp'    # a fast BLAS for the direct solvers
  python3 python3-venv
  libgl1 libglu1-mesa libxrender1 libxcursor1 libxfixes3 libxext6   # libraries the gmsh wheel loads
  libxft2 libfontconfig1 libxinerama1 libx11-6 libgomp1
  ${QUOIN_PACKAGES:-} ${QUOIN_PEERS:+calculix-ccx}
)

# quoin_step <text> <command...>: one line with the time; output to the log, its tail on failure
quoin_step() {
  local text=$1 start=$SECONDS from
  shift
  printf 'setup: %s ... ' "$text"
  printf '\n== %s\n' "$text" >>"$QUOIN_ROOT/build/setup.log"
  from=$(wc -l <"$QUOIN_ROOT/build/setup.log")
  if "$@" >>"$QUOIN_ROOT/build/setup.log" 2>&1 </dev/null; then
    printf '%d s\n' $((SECONDS - start))
  else
    printf 'failed after %d s; the end of build/setup.log:\n' $((SECONDS - start))
    tail -n "+$((from + 1))" "$QUOIN_ROOT/build/setup.log" | tail -n 40
    return 1
  fi
}

quoin_installed() {
  [ "$(dpkg-query -W -f '${db:Status-Status}\n' "$1" 2>/dev/null | head -n 1)" = installed ]
}

# packages of the list that are not there, one a line
quoin_missing() {
  local entry name names
  for entry in "${quoin_packages[@]}"; do
    IFS='|' read -r -a names <<<"$entry"
    for name in "${names[@]}"; do
      quoin_installed "$name" && continue 2
    done
    echo "${names[0]}"
  done
}

# install as root, with sudo without a question, or with sudo at a terminal; otherwise say what to run
quoin_apt() {
  local missing sudo=() install
  mapfile -t missing < <(quoin_missing)
  if [ ${#missing[@]} -eq 0 ]; then
    return 0
  fi
  install=(env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300
    install -y --no-install-recommends "${missing[@]}")
  if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
      sudo=(none)
    elif sudo -n true 2>/dev/null; then
      sudo=(sudo -n)
    elif [ -t 0 ] && [ -t 1 ]; then
      echo "setup: missing packages: ${missing[*]}"
      echo "setup: sudo asks for the password to install them with apt-get"
      if sudo -v; then sudo=(sudo -n); else sudo=(none); fi
    else
      sudo=(none)
    fi
  fi
  if [ "${sudo[*]}" = none ]; then
    echo "setup: packages are missing and this user cannot install them; as root, run"
    echo "  apt-get update && apt-get install -y --no-install-recommends ${missing[*]}"
    return 1
  fi
  quoin_step "package lists" "${sudo[@]}" apt-get update || return 1
  quoin_step "${#missing[@]} packages" "${sudo[@]}" "${install[@]}"
}

# no apt-get: only look, and name what is missing
quoin_tools_check() {
  local missing=() name
  for name in cc make cmake pkg-config mpicc mpirun python3; do
    command -v "$name" >/dev/null || missing+=("$name")
  done
  if command -v pkg-config >/dev/null; then
    pkg-config --exists 'PETSc >= 3.18' || missing+=("PETSc >= 3.18 (pkg-config PETSc)")
    pkg-config --exists 'slepc >= 3.18' || missing+=("SLEPc >= 3.18, built for the same PETSc (pkg-config slepc)")
    pkg-config --exists yaml-0.1 || missing+=("libyaml (pkg-config yaml-0.1)")
    pkg-config --exists zlib || missing+=("zlib (pkg-config zlib)")
    pkg-config --exists hdf5-openmpi || pkg-config --exists hdf5-mpich || pkg-config --exists hdf5 ||
      missing+=("parallel HDF5 (pkg-config hdf5-openmpi, hdf5-mpich or hdf5)")
  fi
  if [ ${#missing[@]} -gt 0 ]; then
    echo "setup: no apt-get here, so nothing is installed; missing, apart from METIS, which CMake looks for:"
    printf '  %s\n' "${missing[@]}"
    return 1
  fi
}

# whether build/<name> leads, by a link, to a folder that this checkout has not made: it is neither emptied nor given packages
quoin_is_anothers() {
  local folder=$QUOIN_ROOT/build/$1
  [ "$(readlink -f "$folder")" != "$(readlink -f "$QUOIN_ROOT")/build/$1" ] && [ -n "$(ls -A "$folder/" 2>/dev/null)" ] &&
    ! grep -qsF -- " $folder" "$folder/pyvenv.cfg"
}

# build/venv with the pinned packages; the stamp names place, Python and pins
quoin_venv() {
  local python=/usr/bin/python3 venv=$QUOIN_ROOT/build/venv stamp
  [ -x "$python" ] || python=$(command -v python3) || return 1
  stamp="$venv $("$python" --version) $(sha256sum <"$QUOIN_ROOT/tools/requirements.txt")"
  if [ -x "$venv/bin/python" ] && [ "$(cat "$venv/stamp" 2>/dev/null)" = "$stamp" ]; then
    return 0
  fi
  if quoin_is_anothers venv; then
    if [ ! -x "$venv/bin/python" ]; then
      echo "setup: build/venv leads to $(readlink -f "$venv"), which is no Python environment: remove the link"
      return 1
    fi
    echo "setup: build/venv leads to $(readlink -f "$venv"), which is used as it is"
    return 0
  fi
  quoin_step "Python environment build/venv" quoin_venv_make "$python" "$venv" || return 1
  echo "$stamp" >"$venv/stamp"
}

quoin_venv_make() {
  "$1" -m venv --clear "$2" &&
    "$2/bin/python" -m pip install --disable-pip-version-check --require-hashes -r "$QUOIN_ROOT/tools/requirements.txt" &&
    "$2/bin/python" -c 'import clarabel, ezdxf, gmsh, h5py, jsonschema, matplotlib, meshio, numpy, scipy, shapely, vtkmodules.all, yaml'
}

# other programs, in the same environment; CalculiX comes with the Debian packages
quoin_peers() {
  local venv=$QUOIN_ROOT/build/venv list=$QUOIN_ROOT/tools/requirements_peers.txt
  if [ -z "${QUOIN_PEERS:-}" ] || cmp -s "$list" "$venv/peers"; then
    return 0
  fi
  if quoin_is_anothers venv; then
    echo "setup: build/venv leads to $(readlink -f "$venv"): programs to compare with are installed from there"
    return 1
  fi
  quoin_step "programs to compare with" "$venv/bin/python" -m pip install --disable-pip-version-check --require-hashes --no-deps -r "$list" &&
    cp "$list" "$venv/peers"
}

quoin_cores() {
  env -u OMP_NUM_THREADS nproc # nproc obeys OMP_NUM_THREADS
}

quoin_build() {
  cd "$QUOIN_ROOT" && cmake --preset "${QUOIN_PRESET:-release}" && cmake --build build -j "$(quoin_cores)"
}

# may one process read another's memory? Containers often refuse what Open MPI's shared memory relies on
quoin_memory_copy_works() {
  PYTHONPATH=$QUOIN_ROOT/tools "$QUOIN_ROOT/build/venv/bin/python" -c \
    'import sys; from quoin_tools.base.solver import memory_copy_works; sys.exit(not memory_copy_works())'
}

quoin_environment() {
  export QUOIN_ROOT
  case ":$PATH:" in
  *":$QUOIN_ROOT/build/bin:"*) ;;
  *) export PATH="$QUOIN_ROOT/build/bin:$QUOIN_ROOT/build/venv/bin:$PATH" ;;
  esac
  case ":${PYTHONPATH:-}:" in
  *":$QUOIN_ROOT/tools:"*) ;;
  *) export PYTHONPATH="$QUOIN_ROOT/tools${PYTHONPATH:+:$PYTHONPATH}" ;; # for import quoin
  esac
  case $- in
  *i*) . "$QUOIN_ROOT/tools/install/quoin.bash" ;; # completion, in a shell that somebody types into
  esac
  export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 # the ranks are the threads
  export OMPI_MCA_rmaps_base_oversubscribe=1      # more ranks than cores are allowed
  if [ "$(id -u)" -eq 0 ]; then
    export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
  fi
  if ! quoin_memory_copy_works 2>/dev/null; then
    export OMPI_MCA_btl_vader_single_copy_mechanism=none
  fi
}

# a checkout of somebody else is used as it is
quoin_use() {
  local name
  for name in quoin bin/quoin venv/bin/python; do
    if [ ! -x "$QUOIN_ROOT/build/$name" ]; then
      echo "setup: build/$name is not there, and $QUOIN_ROOT belongs to another user, who can run tools/setup.sh"
      return 1
    fi
  done
  quoin_environment
}

quoin_setup() {
  if [ ! -w "$QUOIN_ROOT/build" ] && { [ -d "$QUOIN_ROOT/build" ] || [ ! -w "$QUOIN_ROOT" ]; }; then
    quoin_use
    return
  fi
  mkdir -p "$QUOIN_ROOT/build" || return 1
  : >"$QUOIN_ROOT/build/setup.log"
  if command -v apt-get >/dev/null && command -v dpkg-query >/dev/null; then
    quoin_apt || return 1
  else
    quoin_tools_check || return 1
  fi
  quoin_venv || return 1
  quoin_peers || return 1
  quoin_environment
  quoin_step "build/quoin (cmake, $(quoin_cores) cores)" quoin_in_subshell quoin_build
}

quoin_in_subshell() {
  ("$@")
}

quoin_setup || { return 1 2>/dev/null || exit 1; }
