#!/usr/bin/env bash
# States of the foundation: seepage, uplift, sliding factor. From the top of the checkout: examples/guilhofrei_seepage/run.sh [OUTPUT]
set -eu
here=$(dirname "${BASH_SOURCE[0]}") out=${1:-out/guilhofrei_seepage}
export PYTHONPATH=tools
mkdir -p "$out"
python "$here/mesh.py" "$out/model.h5"
mpirun -n "${RANKS:-1}" build/quoin -options_file "$here/scene.yaml" -model "$out/model.h5" -output "$out" \
  -stages rock,sw,rule,present,grouted,drained,clogged
python "$here/chart.py" "$out"
quoin show "$out" --pictures # pressures and discharge in the joints, among others
