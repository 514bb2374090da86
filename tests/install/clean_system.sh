#!/bin/bash
# A Debian system with nothing in it (debootstrap, chroot): the checkout sets itself up, is installed, and is used by root and by another user.
# Needs root, the network, debootstrap and 5 GB; four minutes on 2 cores. Not part of the suite, which has test_install.py for the installed files.
#
#   tests/install/clean_system.sh [FOLDER]      # the system stays in FOLDER (build/clean_system), and is made anew
set -euo pipefail
checkout=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
root=${1:-$checkout/build/clean_system}

if [ "${QUOIN_CLEAN:-}" != inside ]; then # mounts that end with this process
  [ "$(id -u)" = 0 ] && command -v debootstrap >/dev/null || { echo "clean_system: needs root and debootstrap" >&2; exit 2; }
  QUOIN_CLEAN=inside exec unshare --mount --pid --fork "$0" "$root"
fi

step() { printf '\n== %s\n' "$*"; }
within() { env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 HOME="$home" chroot $as "$root" bash -euc "cd; $*"; }
home=/root as=

step "a system of the smallest packages"
rm -rf --one-file-system "$root"
mkdir -p "$root"
debootstrap --variant=minbase --include=ca-certificates,git bookworm "$root" http://deb.debian.org/debian >"$root.debootstrap.log"
mount -t proc proc "$root/proc"
mount --rbind /dev "$root/dev"
mount --rbind /sys "$root/sys" # Open MPI looks for processors there
cp -L /etc/resolv.conf "$root/etc/"
cp -L /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/" # where a proxy of this network has its own
if [ -f /etc/pip.conf ]; then cp /etc/pip.conf "$root/etc/"; fi
git -C "$checkout" bundle create -q "$root/quoin.bundle" HEAD

step "root: set-up from a clone, a dam, its sheet"
within 'git -c advice.detachedHead=false clone -q /quoin.bundle /opt/quoin; apt-get -qq update; source /opt/quoin/tools/setup.sh
  quoin --version; quoin new dam --height 38 >/dev/null; cd dam; quoin run -n 2 scene.yaml | tail -n 3; quoin report out'

step "root: cmake --install"
within 'cmake --install /opt/quoin/build --prefix /usr/local >/dev/null; useradd -m engineer
  cp /opt/quoin/tests/install/solve.c /home/engineer; chmod 755 /opt /opt/quoin'

home=/home/engineer as=--userspec=engineer:engineer
step "another user: the installed command, on two ranks; a sheet"
within 'quoin --version; quoin new dam --height 38 >/dev/null; cd dam; quoin run -n 2 scene.yaml | tail -n 3; quoin report out; quoin show out --html'
step "another user: a C program with the library"
within 'cc solve.c $(pkg-config --cflags --libs quoin) -o solve; cd dam; ../solve scene.yaml | tail -n 1'
step "another user: the Python package in an environment of his own"
within 'python3 -m venv v; git -c advice.detachedHead=false clone -q /quoin.bundle q; v/bin/pip -q install ./q; v/bin/quoin --version
  cd dam; ../v/bin/python -c "import quoin; print(quoin.run(\"scene.yaml\", output=\"again\").summary[\"stages\"][-1][\"verdict\"])"'
step "all of it went well"
