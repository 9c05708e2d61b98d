#!/usr/bin/env bash
# Draws the pictures of the README again (docs/pictures): some minutes on two cores.
set -euo pipefail
cd "$(dirname "$0")/.."
bash tools/setup.sh
bash tools/build.sh release whorl

# picture SCENE FRAME [render option ...]: that frame of the scene, 720 pixels wide (or $width).
picture() {
  local scene=$1 frame=$2 folder
  shift 2
  folder=$(mktemp -d)
  build/release/whorl render "$scene" --frames "$frame" --no-video --out "$folder/$scene" "$@"
  ffmpeg -v error -y -i "$(printf '%s/%s/frames/%06d.png' "$folder" "$scene" "$frame")" -vf "scale=${width:-720}:-1:flags=area" "docs/pictures/$scene.png"
  rm -r "$folder"
}

picture honey_coil 54
picture honey_ball 62 --quality draft --set look.samples=4
picture dam_break 16 --quality draft --set look.samples=4
width=560 picture karman_street 60 --quality draft

# The page of a live run, as Chromium shows it.
bash tools/setup.sh chromium
bash tools/build.sh release whorl_validation
WHORL_PICTURE=$PWD/docs/pictures/live.png build/release/tests/whorl_validation "[page_picture]"
