#!/usr/bin/env bash
# Section 4.3: three dams of Voronoi polygons without cohesion, each on 1 and on 2 ranks at once: the same bits.
# From the top of the checkout: examples/guilhofrei_voronoi/run.sh [OUTPUT]
# CONNECTIVITY=variable computes it in the paper's way; README.md has the numbers of both.
set -u
here=$(dirname "${BASH_SOURCE[0]}") out=${1:-out/guilhofrei_voronoi} failed=0
export PYTHONPATH=tools
mkdir -p "$out/one_rank"

# run <seed> <ranks> <folder>; an undecided trial (exit code 4) is a result, the table tells it
run() {
  mpirun -n "$2" build/quoin -options_file "$here/scene.yaml" -model "$out/model_$1.h5" -output "$3/$1" \
    -contact_connectivity "${CONNECTIVITY:-fixed}"
  case $? in 0 | 4) ;; *) failed=1 ;; esac
}
for seed in 1 2 3; do
  python "$here/mesh.py" "$out/model_$seed.h5" "$seed" || exit 1
  run "$seed" "${RANKS:-2}" "$out"
  run "$seed" 1 "$out/one_rank"
done
python "$here/../compare.py" guilhofrei_voronoi "$out" && exit $failed
