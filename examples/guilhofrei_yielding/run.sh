#!/usr/bin/env bash
# Section 4.2 beyond the first violation: masonry that yields at toe and heel, and that cracks at the heel in a flood. From the top of the
# checkout: examples/guilhofrei_yielding/run.sh [OUTPUT]
set -eu
here=$(dirname "${BASH_SOURCE[0]}") out=${1:-out/guilhofrei_yielding}
export PYTHONPATH=tools
mkdir -p "$out"
python "$here/mesh.py" "$out/model.h5"
python "$here/strengths.py" "$out/model.h5" "$out"
python "$here/cracks.py" "$out/model.h5" "$out"
quoin show "$out/3_swhp_5.3" --pictures
quoin show "$out/heel_3" --pictures
quoin report "$out/heel_3"
