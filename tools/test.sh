#!/usr/bin/env bash
# test.sh [--long] [argument of ctest ...]: installs what is missing, builds Whorl and its tests, and runs them. bash tools/test.sh -L fast runs
# the fast ones. With --long: builds the benchmarks too, runs the fast tests under the address and undefined sanitizers, then all tests, including
# those that take minutes each (the ctest label long).
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
bash tools/setup.sh chromium  # for the page of whorl live
if [ "${CI:-}" = true ]; then export CONFIGURE="-DWHORL_WERROR=ON"; fi
bash tools/build.sh release "${targets[@]}"
# One more than there are cores: some tests wait for a folder, an encoder or a browser.
ctest --preset release -j "$(($(nproc) + 1))" "${which[@]}" "$@"
