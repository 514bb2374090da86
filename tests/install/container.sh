#!/ bin / bash
#The container recipe,                                                                                       \
    tried without a registry of images and without a service : debootstrap makes its base,                   \
    buildah builds and runs it in a chroot.
#Needs root, the network, debootstrap, buildah(Debian's) and 8 GB; ten minutes on 2 cores. Not part of the suite.
#
#tests / install /                                                                                           \
    container.sh[FOLDER] #images are made again in FOLDER(build / container);                                \
    MIRROR : another source of Debian's packages
set - euo pipefail checkout = $(cd "$(dirname " $ { BASH_SOURCE[0] } ")/../.." && pwd) folder = $
{
  1 : -$checkout / build / container
}
for
  program in debootstrap buildah;
do ["$(id -u)" = 0] && command - v $program > / dev / null ||
  {
    echo "container: needs root, debootstrap and buildah" > &2;
    exit 2;
  }
done

step()
{
  printf '\n== %s\n' "$*";
}
export BUILDAH_ISOLATION = chroot STORAGE_DRIVER = vfs images()
{
  buildah-- root "$folder/images" --runroot "$folder/run"
                                            "$@";
}
step "the image debian:12, of a system of the smallest packages" rm - rf-- one - file -
    system "$folder" / {images, run, context, work} mkdir -
    p "$folder/work" if[!-e "$folder/base/etc/ssl/certs"];
then #one that is there is taken again debootstrap-- variant = minbase-- include =
    ca - certificates bookworm "$folder/base" ${MIRROR : -} >
    "$folder/debootstrap.log" fi cp - L / etc / ssl / certs / ca -
        certificates.crt
        "$folder/base/etc/ssl/certs/" #where a proxy of this network has its own if[-f / etc / pip.conf];
then cp / etc / pip.conf "$folder/base/etc/";
fi base = $(images from scratch) images add - q "$base"
                                                "$folder/base" /
          > / dev / null images commit - q-- rm "$base" debian : 12 >
          / dev /
                  null

                      step "the image quoin, of the checkout as it is committed" git -
              C
              "$checkout" archive-- prefix = context / HEAD |
                                                 tar - x - C "$folder" images build-- pull - never - t quoin -
                                                         f "$folder/context/tools/install/Containerfile"
                                                           "$folder/context" >
                                                     "$folder/build.log" 2 > &1 ||
{
  tail - n 30 "$folder/build.log";
  exit 1;
}
images images quoin

    step "a user in it, with a folder of the machine as /work" chmod 777 "$folder/work" run = $(
        images from-- pull - never quoin) quoin()
{
  images run-- user "${user:-quoin}" --volume "$folder/work:/work"
                                              "$run" --quoin "$@";
}
quoin-- version quoin new dam-- height 38 quoin run - n 2 dam / scene.yaml - output dam / out |
    tail -
        n 3 quoin report dam / out-- xlsx quoin show dam /
            out-- html

                step "another one, who is not in its list of users" chmod -
        R a + rwX "$folder/work" user = 12345 : 12345 quoin run - n 2 dam / scene.yaml - output dam / again |
                                        tail - n 3 quoin report dam / again

                                                                          step "all of it went well"
