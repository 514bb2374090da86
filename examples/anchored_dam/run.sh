#!/usr/bin/env bash
# A heightened dam in a flood, without steel, with tendons from its crest, with the same steel grouted; the force for a sliding factor of 1.3. From the top of the
# checkout: examples/anchored_dam/run.sh [OUTPUT]
set -eu
here=$(dirname "${BASH_SOURCE[0]}") out=${1:-out/anchored_dam}
export PYTHONPATH=tools
mkdir -p "$out"
python "$here/mesh.py" "$out/model.h5"
mpirun -n "${RANKS:-1}" build/quoin -options_file "$here/scene.yaml" -model "$out/model.h5" -output "$out/with"
mpirun -n "${RANKS:-1}" build/quoin -options_file "$here/scene_without.yaml" -model "$out/model.h5" -output "$out/without"
mpirun -n "${RANKS:-1}" build/quoin -options_file "$here/scene_grouted.yaml" -model "$out/model.h5" -output "$out/grouted"
python "$here/chart.py" "$out"
mpirun -n "${RANKS:-1}" build/quoin -options_file "$here/scene_force.yaml" -model "$out/model.h5" -output "$out/force"
quoin show "$out/with" --pictures
quoin report "$out/with"
