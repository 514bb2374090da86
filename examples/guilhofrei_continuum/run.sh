#!/usr/bin/env bash
# Section 4.3's question: a dam of random stones beside the equivalent continuum with the same strengths. From the top of the checkout:
# examples/guilhofrei_continuum/run.sh [OUTPUT]
set -eu
here=$(dirname "${BASH_SOURCE[0]}") out=${1:-out/guilhofrei_continuum}
export PYTHONPATH=tools
mkdir -p "$out"
for seed in 1 2 3; do
  python "$here/mesh.py" "$out/stones_$seed.h5" "$seed"
done
python "$here/mesh.py" "$out/continuum.h5" 1 --continuous --refine 1
python "$here/friction.py" "$out"
