#!/bin/bash
# Least friction of 200 fabrics for each of three facings, by limit analysis; 16 minutes on a core. SAMPLES=10 for a try.
#
#   examples/guilhofrei_voronoi/fabrics.sh [OUT]
set -eu
here=$(dirname "${BASH_SOURCE[0]}") out=${1:-out/fabrics}
export PYTHONPATH=tools
mkdir -p "$out"
grep -v '^  facing:' "$here/scene.yaml" > "$out/scene_none.yaml" # a mesh without a facing has no such group
facing() {
  sed -e "s|^scene: .*|scene: $(realpath "${3:-$here/scene.yaml}")|" -e "s|^mesh: .*|mesh: [voronoi, $2--seed, \"{seed}\"]|" -e "s|^samples: .*|samples: ${SAMPLES:-200}|" \
    "$here/fabrics.yaml" > "$out/$1.yaml"
  python tools/quoin.py ensemble "$out/$1.yaml" -o "$out/$1"
}
facing square "--square, "
facing level ""
facing none "--facing, 0, 0, " "$out/scene_none.yaml"
python "$here/fabrics.py" "$out"
