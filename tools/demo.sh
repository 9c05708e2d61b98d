#!/usr/bin/env bash
# Installs what is missing, builds Whorl, pours honey, and ends with the path of the video.
# Arguments go to `whorl render`: bash tools/demo.sh --quality fine
set -euo pipefail
cd "$(dirname "$0")/.."
bash tools/setup.sh
echo "Building (the first time takes some minutes) ..."
CONFIGURE= bash tools/build.sh release whorl
build/release/whorl render scenes/honey_coil.toml "$@"
