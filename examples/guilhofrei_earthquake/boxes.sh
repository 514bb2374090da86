#!/usr/bin/env bash
# How much rock, and what at its edge: the record on an elastic dam in boxes that reach 1, 2 and 3 heights of the dam to each side and down. From
# the top of the checkout: examples/guilhofrei_earthquake/boxes.sh [OUTPUT]
set -eu
here=$(dirname "${BASH_SOURCE[0]}") out=${1:-out/guilhofrei_earthquake/boxes}
export PYTHONPATH=tools
mkdir -p "$out"
python "$here/record.py" "$out/quake.csv"
run() {
  mpirun -n "${RANKS:-1}" build/quoin -options_file "$here/scene.yaml" -model "$out/$1.h5" -motions_quake_file "$out/quake.csv" -output "$out/$2_$1" \
    -stages sw,full,shake -joints_base_law elastic -joints_base_damping 0 -stages_shake_alpha 0 -stages_shake_duration 8 -stages_shake_dt_factor 0.8 "${@:3}"
}
for extent in 1 2 3; do
  quoin import dam -o "$out/$extent.h5" --columns 15 --rock-extent "$extent"
  run "$extent" held -supports_rock_sides_fix xy -supports_rock_sides_motion quake -supports_rock_bottom_boundary fixed
  run "$extent" rollers
  run "$extent" free -supports_rock_sides_boundary free_field
done
python "$here/boxes.py" "$out"
