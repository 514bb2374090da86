#!/usr/bin/env bash
# The site: README.md, docs/ and examples/ as a folder of pages with a search that needs no network, build/site/index.html.
# A warning is an error, and so is a link or an anchor that leads nowhere.
#   ./tools/docs.sh [FOLDER]     cmake --install and cpack take it along from build/site
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
site=$(realpath -m "${1:-$root/build/site}")
cd "$root"
[ -x build/venv/bin/python ] || tools/setup.sh # the reference of Python imports the tools

stamp="$root $(sha256sum <tools/requirements_docs.txt)"
if [ "$(cat build/docs-venv/stamp 2>/dev/null)" != "$stamp" ]; then
  build/venv/bin/python -m venv --clear build/docs-venv
  build/docs-venv/bin/pip install --quiet --disable-pip-version-check --require-hashes -r tools/requirements_docs.txt
  echo "$stamp" >build/docs-venv/stamp
fi
rm -rf "$site"
build/docs-venv/bin/sphinx-build -q -W --keep-going -n -E -b html -c tools/site -d "$site/.trees" . "$site"
rm -rf "$site/.trees" "$site/.buildinfo" "$site/objects.inv"
printf '<!doctype html><meta charset="utf-8"><title>Quoin</title><meta http-equiv="refresh" content="0; url=README.html"><a href="README.html">Quoin</a>\n' >"$site/index.html"
printf 'wrote %s/index.html, %d pages\n' "$site" "$(find "$site" -name '*.html' | wc -l)"
