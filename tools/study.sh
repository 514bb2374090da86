#!/usr/bin/env bash
# The paper's safety study (section 4, the Guilhofrei dam): every scene, the table of the paper's numbers and ours, the pictures.
# Says how long each part took; a part that fails is told and the others go on. Exit code 0: all parts came to their end.
# What it writes is in out/: guilhofrei*, study. 5 minutes on 2 cores that other work shared (2026-11).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/setup.sh
export PYTHONPATH=tools MPLBACKEND=Agg OMPI_MCA_mpi_yield_when_idle=1

parts=(guilhofrei guilhofrei_local guilhofrei_voronoi guilhofrei_sliding)
titles=('4.1 stresses' '4.2 local failure' '4.3 Voronoi polygons without cohesion' '4.4 sliding and flood')
times=() failed=()
mkdir -p out/study
for i in "${!parts[@]}"; do
  name=${parts[$i]} start=$SECONDS told=''
  printf '\n== %s: examples/%s, log out/study/%s.log\n' "${titles[$i]}" "$name" "$name"
  mkdir -p "out/$name"
  rm -f "out/$name"/*.h5 "out/$name"/*/summary.json "out/$name"/*/*/summary.json "out/$name"/summary.json # nothing old in the table
  if "examples/$name/run.sh" >"out/study/$name.log" 2>&1; then
    sed -n '/: the paper, this run/,$p' "out/study/$name.log"
  else
    told="  FAILED with exit code $?"
    failed+=("$name")
    tail -n 15 "out/study/$name.log"
  fi
  times+=("$(printf '%5d s  %s%s' $((SECONDS - start)) "${titles[$i]}" "$told")")
done

printf '\n== The table: out/study/table.md, table.csv\n'
python examples/study.py out || failed+=(table)
find out/guilhofrei* -name 'fig_*.png' -exec cp {} out/study/ \;
printf '\nPictures:\n'
ls out/study/*.png
printf '\nTimes:\n'
printf '%s\n' "${times[@]}"
printf '%5d s  in all\n' "$SECONDS"
if [ ${#failed[@]} -gt 0 ]; then
  echo "study: failed: ${failed[*]}" >&2
  exit 1
fi
