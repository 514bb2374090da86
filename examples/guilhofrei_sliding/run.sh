#!/usr/bin/env bash
# Section 4.4: sliding, each run to failure from the same state. From the top of the checkout: examples/guilhofrei_sliding/run.sh [OUTPUT]
# CONNECTIVITY=variable computes it in the paper's way; README.md has the numbers of both.
set -eu
here=$(dirname "${BASH_SOURCE[0]}") out=${1:-out/guilhofrei_sliding}
export PYTHONPATH=tools
mkdir -p "$out"
python "$here/mesh.py" "$out/model.h5"

# run <name> <stages> <options...>
run() {
  mpirun -n "${RANKS:-2}" build/quoin -options_file "$here/scene.yaml" -model "$out/model.h5" -output "$out/$1" -stages "$2" \
    -contact_connectivity "${CONNECTIVITY:-fixed}" "${@:3}"
}
run s1 sw,swhp,swhpu,s1
python "$here/mesh_s2.py" "$out/model_s2.h5"
mpirun -n "${RANKS:-2}" build/quoin -options_file "$here/scene_s2.yaml" -model "$out/model_s2.h5" -output "$out/s2" \
  -contact_connectivity "${CONNECTIVITY:-fixed}"
run s3 sw,swhp,swhpuk,s3
run s3_brittle sw,swhp,swhpuk,s3 -stages_swhpuk_joints_key_cohesion_residual 0 -stages_swhpuk_joints_key_tension_residual 0
run s4 sw,swhp,swhpu,s4
run s4_2 sw,swhp,swhpu,s4 -stages_s4_limit 35 # the states at +2 and +5 m, for Fig. 17
run s4_5 sw,swhp,swhpu,s4 -stages_s4_limit 38
python "$here/../compare.py" guilhofrei_sliding "$out"
