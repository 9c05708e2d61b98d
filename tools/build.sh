#!/usr/bin/env bash
# build.sh PRESET [target ...]: configures if necessary, and builds. CONFIGURE="-DX=Y ..." passes arguments to cmake's configure step.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=$1
shift
[ -f "build/$preset/build.ninja" ] && [ -z "${CONFIGURE:-}" ] || cmake --preset "$preset" ${CONFIGURE:-} >/dev/null
cmake --build --preset "$preset" ${1:+--target "$@"}
