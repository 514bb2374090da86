# shellcheck shell=bash
# For scripts that run several parts of the checks one after the other (tools/test.sh --all, .ci/run): shows each part, notes its time,
# counts the tests of its ctest runs and names at the end what failed. A script sources this file, calls `run NAME COMMAND...` for each
# part and ends with `finish`, whose last line is "N passed, N failed" and whose exit code is 0 when nothing failed.

parts_log=$(mktemp)  # what the part prints
parts_lost=$(mktemp) # names of what failed
parts_times=""
passed=0
failed=0
trap 'rm -f "$parts_log" "$parts_lost"' EXIT

# show <name> <command...>: run the command, keep its output in the log, note its time
show() {
  local name=$1 start=$SECONDS code=0
  shift
  printf '\n== %s\n' "$name"
  "$@" 2>&1 | tee "$parts_log" || code=$?
  parts_times+=$(printf '%6d s  %s' $((SECONDS - start)) "$name")$'\n'
  return $code
}

# count <name> <exit code>: add the ctest runs of the log; a part without any, or one that failed outside its tests, counts as one test
count() {
  local name=$1 code=$2 bad all runs=0 before=$failed
  while read -r bad all; do
    runs=$((runs + 1))
    failed=$((failed + bad))
    passed=$((passed + all - bad))
  done < <(sed -nE 's/^[0-9]+% tests passed, ([0-9]+) tests? failed out of ([0-9]+)$/\1 \2/p' "$parts_log")
  grep -E '^[[:space:]]+[0-9]+ - .*\(.*\)$|^(FAILED|ERROR) | FAILED *$' "$parts_log" | sed "s/^/$name: /" >>"$parts_lost" || true
  if [ "$code" -ne 0 ] && [ "$failed" -eq "$before" ]; then
    failed=$((failed + 1))
    tail -n 5 "$parts_log" | sed "s/^/$name: /" >>"$parts_lost"
  elif [ "$runs" -eq 0 ]; then
    passed=$((passed + 1))
  fi
}

run() {
  local code=0
  show "$@" || code=$?
  count "$1" $code
}

# unit tests and refusals under the address and undefined-behaviour sanitizers
sanitizers() {
  cmake --preset fuzz && cmake --build build-fuzz -j "$(env -u OMP_NUM_THREADS nproc)" --target unit_tests refusals quoin &&
    ctest --test-dir build-fuzz --output-on-failure -j 2 -L unit
}

# dearest <file>: prints the twenty tests that took longest, from what ctest has printed into the file, and the time since the script began
dearest() {
  printf '\nThe longest of %d tests:\n' "$(grep -cE ' (Passed|\*\*\*[A-Za-z ]+) +[0-9.]+ sec' "$1")"
  sed -nE 's/^.*Test +#[0-9]+: ([^ ]+) .* ([0-9.]+) sec.*$/\2 s  \1/p' "$1" | sort -rn | sed -n '1,20s/^/  /p' # to the end of its input: head would end sort by a signal
  tail -n 30 "$1" | grep -E '^(Label Time|[a-z]+ +=|Total Test)' || true
  printf 'In all, with the build: %d s\n' $SECONDS
}

finish() {
  printf '\n%s%6d s  total\n' "$parts_times" $SECONDS
  cat "$parts_lost"
  printf '%d passed, %d failed\n' $passed $failed
  [ $failed -eq 0 ]
}
