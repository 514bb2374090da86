#!/usr/bin/env bash
# Builds Quoin with warnings as errors and runs the whole test suite; arguments go to ctest, e.g.
#   ./tools/test.sh -L unit      ./tools/test.sh -R contact -V
set -euo pipefail
export QUOIN_PRESET=${QUOIN_PRESET:-test}
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
exec ctest --test-dir "$QUOIN_ROOT/build" --output-on-failure -j 2 "$@"
