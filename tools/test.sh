#!/usr/bin/env bash
# Installs what is missing, builds Whorl and its tests, and runs them all. Arguments go to ctest: bash tools/test.sh -L fast
set -euo pipefail
cd "$(dirname "$0")/.."
bash tools/setup.sh chromium  # for the page of whorl live
if [ "${CI:-}" = true ]; then export CONFIGURE="-DWHORL_WERROR=ON"; fi
bash tools/build.sh release
ctest --preset release "$@"
