#!/usr/bin/env bash
# build.sh PRESET [target ...]: configures if necessary, and builds. Arguments for cmake's configure step: CONFIGURE="-DX=Y ...".
set -euo pipefail
cd "$(dirname "$0")/.."
preset=$1
shift
[ -f "build/$preset/build.ninja" ] && [ -z "${CONFIGURE:-}" ] || cmake --preset "$preset" ${CONFIGURE:-} >/dev/null
cmake --build --preset "$preset" ${1:+--target "$@"}
