#!/usr/bin/env bash
# test.sh [--long] [argument of ctest ...]: installs missing packages, builds Whorl and its tests, and runs the tests, except those with the
# ctest label long, which take minutes each. bash tools/test.sh -L fast runs only the fast tests. With --long it also builds the benchmarks,
# runs the fast tests under the address and undefined sanitizers, and then all tests.
set -euo pipefail
cd "$(dirname "$0")/.."
which=(-LE long)
targets=(whorl whorl_tests whorl_validation whorl_golden)
if [ "${1:-}" = --long ]; then
  which=()
  targets=(all whorl_solver_tables)
  shift
  bash tools/setup.sh
  bash tools/build.sh asan whorl whorl_tests
  ctest --preset asan -j "$(nproc)" -L fast
fi
bash tools/setup.sh chromium  # tests open the page of whorl live in it
if [ "${CI:-}" = true ]; then export CONFIGURE="-DWHORL_WERROR=ON"; fi
bash tools/build.sh release "${targets[@]}"
# One more process than cores, because some tests wait for a folder, an encoder or a browser.
ctest --preset release -j "$(($(nproc) + 1))" "${which[@]}" "$@"
