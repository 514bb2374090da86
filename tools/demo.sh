#!/usr/bin/env bash
# Builds Quoin, runs the Guilhofrei dam under self-weight and reservoir on 2 ranks and draws the results.
# Everything it writes is in out/guilhofrei and is named at the end.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/setup.sh

out=out/guilhofrei
example=examples/guilhofrei
mkdir -p "$out"
start=$(mktemp)
trap 'rm -f "$start"' EXIT

export PYTHONPATH=tools MPLBACKEND=Agg
python "$example/mesh.py" "$out/model.h5"
mpirun -n 2 build/quoin -options_file "$example/scene.yaml" -model "$out/model.h5" -output "$out"
echo
python examples/compare.py guilhofrei "$out"
echo
quoin show "$out" --pictures

echo
echo "Files written in $PWD/$out:"
find "$out" -type f -newer "$start" -printf '%s %P\n' | sort -k 2 | while read -r size name; do
  printf '  %8s  %s\n' "$(numfmt --to=iec --suffix=B "$size")" "$name"
done

echo
echo "Your own dam: source tools/setup.sh; quoin new dam"
