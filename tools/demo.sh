#!/usr/bin/env bash
# Installs what is missing, builds Whorl, pours honey, and ends with the path of the video.
# Arguments go to `whorl render`: bash tools/demo.sh --quality fine
set -euo pipefail
cd "$(dirname "$0")/.."
bash tools/setup.sh
echo "Building (the first time takes some minutes) ..."
bash tools/build.sh release whorl
video=out/honey_coil/honey_coil.mp4
if [ $# -eq 0 ] && [ "$video" -nt build/release/whorl ] && [ "$video" -nt scenes/honey_coil.toml ]; then
  echo "Already poured with this program and scene: $PWD/$video"
  exit 0
fi
build/release/whorl render scenes/honey_coil.toml --overwrite "$@"
