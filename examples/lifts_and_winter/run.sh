#!/usr/bin/env bash
# A dam in lifts, its reservoir and a winter, beside the same dam placed in one piece. From the top of the checkout:
# examples/lifts_and_winter/run.sh [OUTPUT]
set -eu
here=$(dirname "${BASH_SOURCE[0]}") out=${1:-out/lifts_and_winter}
export PYTHONPATH=tools
mkdir -p "$out"
python "$here/mesh.py" "$out/model.h5"
mpirun -n "${RANKS:-1}" build/quoin -options_file "$here/scene.yaml" -model "$out/model.h5" -output "$out/lifts"
mpirun -n "${RANKS:-1}" build/quoin -options_file "$here/scene_whole.yaml" -model "$out/model.h5" -output "$out/whole"
python "$here/table.py" "$out"
quoin show "$out/lifts" --pictures
