#!/usr/bin/env bash
# Section 4.2: local failure factors, three scenarios. From the top of the checkout: examples/guilhofrei_local/run.sh [OUTPUT]
# CONNECTIVITY=variable computes it in the paper's way; README.md has the numbers of both.
set -eu
here=$(dirname "${BASH_SOURCE[0]}") out=${1:-out/guilhofrei_local}
export PYTHONPATH=tools
mkdir -p "$out"
python "$here/mesh.py" "$out/model.h5"

# run <scenario> <tension [Pa]> <cohesion [Pa]>
run() {
  mpirun -n "${RANKS:-2}" build/quoin -options_file "$here/scene.yaml" -model "$out/model.h5" -output "$out/$1" \
    -materials_dam_tension "$2" -materials_dam_cohesion "$3" -contact_connectivity "${CONNECTIVITY:-fixed}"
}
run 1 1.0e6 1.58e6
run 2 0.5e6 1.12e6
run 3 0.25e6 0.79e6
python "$here/../compare.py" guilhofrei_local "$out"
