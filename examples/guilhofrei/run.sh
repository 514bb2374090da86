#!/usr/bin/env bash
# Section 4.1: stresses under self-weight, reservoir, both. From the top of the checkout: examples/guilhofrei/run.sh [OUTPUT]
# CONNECTIVITY=variable computes it in the paper's way; README.md has the numbers of both.
set -eu
here=$(dirname "${BASH_SOURCE[0]}") out=${1:-out/guilhofrei}
export PYTHONPATH=tools
mkdir -p "$out"
python "$here/mesh.py" "$out/model.h5"
mpirun -n "${RANKS:-2}" build/quoin -options_file "$here/scene.yaml" -model "$out/model.h5" -output "$out" \
  -contact_connectivity "${CONNECTIVITY:-fixed}"
python "$here/../compare.py" guilhofrei "$out"
