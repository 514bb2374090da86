#!/bin/bash
# Section 4.3 asked of many fabrics: least friction by limit analysis of 200 for each of three facings, of 40 for each change of stones, facing and
# crest; trials of the solver beside some; tables of what explains it, figures. An hour on a core; begun again it goes on.
#
#   examples/guilhofrei_voronoi/fabrics.sh [OUT [PART...]]     parts: facings, changes, trials, tables; all of them, if none is named
#
# For a try: SAMPLES=10 fabrics a facing; STONES='--side, 4, --course, 2, ' for all. JOBS: how many at a time.
set -eu
here=$(dirname "${BASH_SOURCE[0]}") out=${1:-out/fabrics} samples=${SAMPLES:-200} jobs=${JOBS:-$(nproc)}
parts=" ${*:2} "
[ $# -gt 1 ] || parts=" facings changes trials tables "
some=$(((samples + 4) / 5)) few=$(((samples + 9) / 10))
export PYTHONPATH=tools
mkdir -p "$out"
grep -v '^  facing:' "$here/scene.yaml" >"$out/scene_none.yaml" # a mesh without a facing has no such group

# ensemble <name> <samples> <words of quoin import voronoi>: OUT/<name>.yaml
ensemble() {
  local scene=$here/scene.yaml
  [ "$1" != none ] || scene=$out/scene_none.yaml
  sed -e "s|^scene: .*|scene: $(realpath "$scene")|" -e "s|^mesh: .*|mesh: [voronoi, ${STONES:-}$3--seed, \"{seed}\"]|" -e "s|^samples: .*|samples: $2|" "$here/fabrics.yaml" >"$out/$1.yaml"
}

# trials <name> <samples> <words>: the first of the same fabrics by the solver, in OUT/trials_<name>
trials() {
  ensemble "trials_$1" "$2" "$3"
  sed -i -e 's|^judge: .*|judge: solver\noptions: [-stages_reduction_limit, 5]|' -e 's|^fail: .*|fail: strength_reduction.stable > 18|' "$out/trials_$1.yaml"
  python tools/quoin.py ensemble "$out/trials_$1.yaml" -o "$out/trials_$1" -j "$jobs"
}

for part in $parts; do
  case $part in
  facings)
    ensemble square "$samples" "--square, "
    ensemble none "$samples" "--facing, 0, 0, "
    ensemble level "$samples" ""
    python "$here/mechanisms.py" -j "$jobs" "$out"/{square,none,level}.yaml
    ;;
  changes) # of courses square to the face
    ensemble coping_1 $some "--square, --coping, 1, "
    ensemble coping_2 $some "--square, --coping, 2, "
    ensemble coping_all $some "--square, --coping, 4.85, " # down to the change of slope
    ensemble bonded $some "--square, --bonded, 4.85, "
    ensemble side_1.5 $some "--square, --side, 1.5, "
    ensemble side_3 $some "--square, --side, 3, "
    ensemble even $some "--square, --lloyd, 4, "
    ensemble facing_2 $some "--square, --facing, 2, 2, --course, 2, "
    python "$here/mechanisms.py" -j "$jobs" "$out"/{coping_1,coping_2,coping_all,bonded,side_1.5,side_3,even,facing_2}.yaml
    ;;
  trials)
    trials square $few "--square, "
    trials coping_2 $(((few + 1) / 2)) "--square, --coping, 2, "
    trials bonded $(((few + 1) / 2)) "--square, --bonded, 4.85, "
    ;;
  tables) python "$here/fabrics.py" "$out" ;;
  *)
    echo "fabrics.sh: $part: expected facings, changes, trials or tables" >&2
    exit 2
    ;;
  esac
done
