#!/usr/bin/env bash
# Installs missing packages, builds Whorl, renders the scene honey_coil, and prints the path of the video.
# Arguments are passed to `whorl render`: bash tools/demo.sh --quality fine
set -euo pipefail
cd "$(dirname "$0")/.."
bash tools/setup.sh
echo "Building (the first time takes some minutes) ..."
bash tools/build.sh release whorl
video=out/honey_coil/honey_coil.mp4
if [ $# -eq 0 ] && [ "$video" -nt build/release/whorl ] && [ "$video" -nt scenes/honey_coil.toml ]; then
  echo "The video of this program and scene already exists: $PWD/$video"
  exit 0
fi
build/release/whorl render scenes/honey_coil.toml --overwrite "$@"
