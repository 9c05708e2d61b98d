#!/usr/bin/env bash
# tidy.sh [REVISION]: clang-tidy over the sources that have changed since that revision (default: HEAD, that is, uncommitted changes).
# The preset tidy has no unity builds or precompiled headers, because clang-tidy reads one source at a time.
set -euo pipefail
cd "$(dirname "$0")/.."
bash tools/setup.sh clang-tidy
mapfile -t changed < <(git diff --name-only --diff-filter=d "${1:-HEAD}" -- '*.cpp')
if [ ${#changed[@]} -eq 0 ]; then
  echo "No source has changed since ${1:-HEAD}."
  exit 0
fi
cmake --preset tidy >/dev/null
printf '%s\0' "${changed[@]}" | xargs -0 -n 1 -P "$(nproc)" clang-tidy -p build/tidy --quiet --extra-arg=-Wno-unknown-warning-option \
  --extra-arg=-Wno-ignored-optimization-argument --extra-arg=-Wno-unused-command-line-argument
