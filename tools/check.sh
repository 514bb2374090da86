#!/usr/bin/env bash
# Checkers that run nothing: clang-format, clang-tidy and cppcheck on the C side, ruff and mypy on the Python side.
# Settings: .clang-format, .clang-tidy, pyproject.toml. Prints what is wrong; exit code 0 when nothing is.
#   ./tools/check.sh             all
#   ./tools/check.sh format      those whose names are given: format tidy cppcheck ruff mypy
#   ./tools/check.sh --changed   clang-tidy and cppcheck on what has changed since the last release (tag v*, or else the commit that set
#                                the version): C files, and those that include a changed header
set -euo pipefail
export QUOIN_PACKAGES="${QUOIN_PACKAGES:-} clang-format clang-tidy cppcheck"
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
cd "$QUOIN_ROOT"

quoin_checkers_make() {
  if quoin_is_anothers checkers; then
    echo "build/checkers leads to $(readlink -f build/checkers), which has no mypy: remove the link"
    return 1
  fi
  build/venv/bin/python -m venv --clear build/checkers &&
    build/checkers/bin/pip install --disable-pip-version-check --require-hashes -r tools/requirements_checkers.txt
}

# the Python checkers live beside the tools' own packages, so that users need not install them
checkers=$QUOIN_ROOT/build/checkers/bin
[ -x "$checkers/mypy" ] || quoin_step "checkers build/checkers" quoin_checkers_make

format() {
  find src include tests -name '*.[ch]' -print0 | xargs -0 clang-format --dry-run --Werror &&
    ! grep -rnE '^[^"]{111,}$' --include='*.[ch]' src include tests # comments are laid out by hand
}

# C files to look into, with a null behind each
to_check() {
  local since names
  if [ -z "$changed" ]; then
    find src -name '*.c' -print0
    return
  fi
  since=$(git describe --tags --abbrev=0 --match 'v[0-9]*' 2>/dev/null) || since=$(git log -1 --format=%h -G'^project.quoin VERSION' -- CMakeLists.txt)
  [ -n "$since" ] || { echo "tools/check.sh: no release is known here; all files are checked" >&2; find src -name '*.c' -print0; return; }
  names=$(git diff --name-only --diff-filter=d "$since" -- 'src/*.c' 'src/*.h')
  {
    grep '\.c$' <<<"$names" || true
    grep '\.h$' <<<"$names" | sed 's|^src/||' | while read -r header; do grep -rlF --include='*.c' "#include \"$header\"" src || true; done || true
  } | sort -u | tr '\n' '\0'
}

tidy() {
  cmake -S . -B build -D CMAKE_EXPORT_COMPILE_COMMANDS=ON >/dev/null
  # the compiler's own flags that clang does not know are no business of the checker
  to_check | xargs -0 -r -n 4 -P "$(quoin_cores)" clang-tidy -p build --quiet --extra-arg=-Wno-unknown-warning-option 2>/dev/null
}

cppcheck_c() {
  to_check | xargs -0 -r cppcheck -q -j "$(quoin_cores)" --std=c11 --enable=warning,performance,portability --inline-suppr --error-exitcode=1 \
    --suppress=missingIncludeSystem --suppress=unknownMacro -I include -I src
}

changed=""
[ "${1:-}" != --changed ] || { changed=yes; shift; }
failed=""
for name in ${@:-format tidy cppcheck ruff mypy}; do
  printf -- '-- %s\n' "$name"
  case $name in
    format) format || failed+=" $name" ;;
    tidy) tidy || failed+=" $name" ;;
    cppcheck) cppcheck_c || failed+=" $name" ;;
    ruff) "$checkers/ruff" check --quiet tools tests examples setup.py || failed+=" $name" ;;
    mypy) "$checkers/mypy" --python-executable build/venv/bin/python --no-error-summary || failed+=" $name" ;;
    *) echo "tools/check.sh: no checker named $name" >&2 && exit 2 ;;
  esac
done
[ -z "$failed" ] || { echo "failed:$failed" >&2; exit 1; }
