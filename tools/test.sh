#!/usr/bin/env bash
# The checks, in two lanes. Warnings of the compiler are errors in both. Other arguments go to ctest.
#   ./tools/test.sh                  the first lane, some minutes: build, unit tests, house, tools, and every verification case in its
#                                    short form (mostly 1 and 2 ranks, without what is long: tests/verification/driver.py, the mark `long`);
#                                    at its end a table of the tests that took longest
#   ./tools/test.sh -R contact -V    of the first lane those whose names match
#   ./tools/test.sh --all            the second lane, up to an hour: whatever the first leaves out, valgrind on the unit tests, all ranks,
#                                    kills and restarts, installations, checkers, sanitizers, fuzzing; a table of times at its end
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
source "$root/tests/parts.sh"

# suite <arguments of ctest>: the tests of build/, then a table of times
suite() {
  local said code=0
  said=$(mktemp)
  ctest --test-dir "$root/build" --output-on-failure -j 2 "$@" 2>&1 | tee "$said" || code=$?
  dearest "$said"
  rm -f "$said"
  return $code
}

if [ "${1:-}" = --all ]; then
  shift
  export QUOIN_PRESET=${QUOIN_PRESET:-ci}
  export QUOIN_PACKAGES="${QUOIN_PACKAGES:-} chromium iproute2 clang libclang-rt-dev llvm clang-format clang-tidy cppcheck valgrind"
  source "$root/tools/setup.sh"
  cd "$root"
  run "suite, valgrind" suite "$@"
  run "checkers" ./tools/check.sh
  run "sanitizers" sanitizers
  run "fuzzing, a little" tests/fuzz/run.py --seconds 5 --jobs "$(env -u OMP_NUM_THREADS nproc)"
  finish
  exit
fi
export QUOIN_PRESET=${QUOIN_PRESET:-test} QUOIN_SHORT=1
source "$root/tools/setup.sh"
suite -LE '^long$' "$@"
