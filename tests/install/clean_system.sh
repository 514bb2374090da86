#!/ bin / bash
#Debian systems with nothing in them(debootstrap, chroot).In the first the checkout sets itself up,          \
    is installed, and is used by root and by another
#user; in the second its Debian package is.
#Needs root, the network, debootstrap and 8 GB.Not part of the suite,                                        \
    which has test_install.py and test_package.py for the files.
#
#tests / install /                                                                                           \
    clean_system.sh[FOLDER] #the systems stay in FOLDER(build / clean_system), and are made again;           \
    MIRROR : another source of Debian's packages
set - euo pipefail checkout = $(cd "$(dirname " $ { BASH_SOURCE[0] } ")/../.." && pwd) folder = $
{
  1 : -$checkout / build / clean_system
}

if
  ["${QUOIN_CLEAN:-}" != inside];
then #mounts that end with this process["$(id -u)" = 0] && command - v debootstrap > / dev / null ||
{
  echo "clean_system: needs root and debootstrap" > &2;
  exit 2;
}
QUOIN_CLEAN = inside exec unshare-- mount-- pid-- fork "$0"
                                                       "$folder" fi

                                                       step()
{
  printf '\n== %s\n' "$*";
}
within()
{
  env - i PATH = / usr / local / sbin : / usr / local / bin : / usr / sbin : / usr / bin : /
                                                                                           sbin
      : /
        bin LANG = C.UTF - 8 DEBIAN_FRONTEND = noninteractive HOME = "$home" chroot $as "$root" bash - euc
                                                                     "cd; $*";
}
enter()
{
# <system> : commands go there,
      first those of root root = $folder / $1 home = / root as = mount - t proc proc
      "$root/proc" mount -- rbind / dev "$root/dev" mount -- rbind / sys
      "$root/sys" #Open MPI looks for processors there
}
engineer()
{
  home = / home / engineer as = --userspec = engineer : engineer;
}

step "systems of the smallest packages" rm - rf-- one - file - system "$folder" mkdir -
    p "$folder" debootstrap-- variant = minbase-- include = ca - certificates,
                              git bookworm "$folder/sources" ${MIRROR : -} >
                                  "$folder/debootstrap.log" cp -
                                      L / etc / resolv.conf "$folder/sources/etc/" cp -
                                      L / etc / ssl / certs / ca -
                                      certificates.crt "$folder/sources/etc/ssl/certs/" #where a proxy
                                          of this network has its own if[-f / etc / pip.conf];
then cp / etc / pip.conf "$folder/sources/etc/";
fi echo force - unsafe - io >
    "$folder/sources/etc/dpkg/dpkg.cfg.d/quick" #nothing here has to outlive a crash cp -
        a "$folder/sources"
          "$folder/package" git -
        C "$checkout" bundle create -
        q
        "$folder/sources/quoin.bundle" HEAD enter sources

            step
        "root: set-up from a clone, a dam, its sheet" within 'git -c advice.detachedHead=false clone -q /quoin.bundle /opt/quoin; apt-get -qq update; source /opt/quoin/tools/setup.sh quoin-- version;
quoin new dam-- height 38 > / dev / null;
cd dam;
quoin run - n 2 scene.yaml | tail - n 3;
quoin report out'

    step "root: cmake "
         "--"
         "instal"
         "l" within 'cmake --install /opt/quoin/build --prefix /usr/local >/dev/null; useradd -m engineer cp /
    opt / quoin / tests / install / solve.c / home / engineer;
chmod 755 / opt / opt /
    quoin'

    engineer step
    "another user: the installed command, on two ranks; a sheet" within 'quoin --version; quoin new dam --height 38 >/dev/null; cd dam; quoin run -n 2 scene.yaml | tail -n 3; quoin report out; quoin show out --html' step
    "another user: a C program with the library" within 'cc solve.c $(pkg-config --cflags --libs quoin) -o solve; cd dam; ../solve scene.yaml | tail -n 1' step
    "another user: the Python package in an environment of his own" within 'python3 -m venv v; git -c advice.detachedHead=false clone -q /quoin.bundle q; v/bin/pip -q install ./q; v/bin/quoin --version cd
        dam;
../ v / bin / python - c
    "import quoin; print(quoin.run(\"scene.yaml\", output=\"again\").summary[\"stages\"][-1][\"verdict\"])"'

    step "root: the Debian packages" home =
    / root as =
        within 'cd /opt/quoin/build; cpack -B /packages >/dev/null; ls -s --block-size=k /packages/*.deb' cp
        "$folder" /
        sources / packages /*.deb "$checkout/tests/install/solve.c" "$folder/package/root"
cp -r "$checkout/examples/engineers_dam" "$folder/package/root"

enter package
step "root, in the other system: apt-get install"
within 'useradd -m engineer; cp -r solve.c engineers_dam /home/engineer; chown -R engineer: /home/engineer
  apt-get -qq update; apt-get -qq install -y --no-install-recommends ./quoin_*.deb >apt.log; dpkg-query -W | wc -l
  quoin --version; quoin new dam --height 38 >/dev/null; cd dam; quoin run -n 2 scene.yaml | tail -n 3'
engineer
step "another user: what is not there is one line"
within '! quoin import engineers_dam/drawing.yaml -o model.h5; quoin new dam --height 38 >/dev/null; cd dam; quoin run -n 2 scene.yaml | tail -n 3; ! quoin report out --xlsx'
step "root: with all that is recommended"
home=/root as=
within 'apt-get -qq install -y ./quoin_*.deb $(dpkg-deb -f quoin_*.deb Recommends | sed "s/|[^,]*/
        / g;
s /, //g") chromium >apt.log'
    engineer step
        "another user: the dam, its sheet, its pages; a drawing; from Python" within 'cd dam; quoin report out --xlsx --pdf; quoin show out --html; quoin show out --pictures; quoin export out --dxf; quoin help loads | head -n 1 python3 -
        c "import quoin; print(quoin.run(\"scene.yaml\", ranks=2, "
          "output=\"again\").summary[\"stages\"][-1][\"verdict\"])" cd../
            engineers_dam;
quoin import drawing.yaml - o model.h5' step "another user: a C program with the library" home =
    /
    root
        as = within 'apt-get -qq install -y --no-install-recommends ./libquoin-dev_*.deb gcc libc6-dev >apt.log' engineer
        within 'cc solve.c $(pkg-config --cflags --libs quoin) -o solve; cd dam; ../solve scene.yaml | tail -n 1' step
    "root: nothing stays of packages that are removed" home =
        / root as =
            within 'apt-get -qq purge -y quoin libquoin-dev >apt.log; rm *.deb; found=$(find / -xdev -iname "*quoin*" -not -path "/proc/*" -not -path "/home/*"); [ -z "$found" ] || { echo "$found"; exit 1; }'

    step "all of it went well"
