#!/usr/bin/env bash
# Earthquake on section G1: pseudo-static, yield coefficient, record and after it; the same with free ground beside the sides, and with a rock box that
# is held. From the top of the checkout: examples/guilhofrei_earthquake/run.sh [OUTPUT]
set -eu
here=$(dirname "${BASH_SOURCE[0]}") out=${1:-out/guilhofrei_earthquake}
export PYTHONPATH=tools
mkdir -p "$out"
python "$here/../guilhofrei_sliding/mesh.py" "$out/model.h5"
python "$here/record.py" "$out/quake.csv"
run() {
  mpirun -n "${RANKS:-1}" build/quoin -options_file "$here/scene.yaml" -model "$out/model.h5" -motions_quake_file "$out/quake.csv" \
    -output "$out/$1" -stages "$2" "${@:3}"
}
run pseudo sw,full,pseudo
run yield sw,full,yield
run record sw,full,periods,shake,after,less
run free sw,full,shake -supports_rock_sides_boundary free_field
run box sw,full,shake -supports_rock_sides_fix xy -supports_rock_sides_motion quake -supports_rock_bottom_boundary fixed
python "$here/chart.py" "$out"
quoin show --film "$out/record"
quoin motion "$out/record" --record --points rock_heel crest_upstream --ky "$out/yield"
quoin report "$out/record" --ky "$out/yield"
