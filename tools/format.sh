#!/usr/bin/env bash
# format.sh [--check]: writes every C++ source as .clang-format says; with --check it only names files that differ, and fails.
set -euo pipefail
cd "$(dirname "$0")/.."
bash tools/setup.sh clang-format
how=(-i)
if [ "${1:-}" = --check ]; then how=(--dry-run -Werror); fi
git ls-files -z '*.h' '*.cpp' | xargs -0 clang-format "${how[@]}"
