#!/usr/bin/env bash
# format.sh [--check]: formats every C++ source by .clang-format. With --check it only lists files that differ, and fails if there are any.
set -euo pipefail
cd "$(dirname "$0")/.."
bash tools/setup.sh clang-format
how=(-i)
if [ "${1:-}" = --check ]; then how=(--dry-run -Werror); fi
git ls-files -z '*.h' '*.cpp' | xargs -0 clang-format "${how[@]}"
