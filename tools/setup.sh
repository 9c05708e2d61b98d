#!/usr/bin/env bash
# setup.sh [extra package ...]: installs the packages that Whorl needs on Debian 12 and lists them. Does nothing if none is missing.
set -euo pipefail

packages=(g++ cmake ninja-build pkg-config ccache
  libeigen3-dev libopenvdb-dev libboost-dev libboost-iostreams-dev libtbb-dev
  libegl-dev libgl-dev libepoxy-dev libgl1-mesa-dri libegl1 libegl-mesa0
  libstb-dev zlib1g-dev libcairo2-dev libopenexr-dev libassimp-dev libtinygltf-dev fonts-dejavu-core libtomlplusplus-dev libcli11-dev libspdlog-dev libfmt-dev libmuparser-dev
  nlohmann-json3-dev libcpp-httplib-dev catch2 libbenchmark-dev ffmpeg python3 python3-numpy python3-matplotlib "$@")

missing=()
for package in "${packages[@]}"; do
  [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

if [ "$(id -u)" -eq 0 ]; then as_root=()
elif sudo -n true 2>/dev/null; then as_root=(sudo)
else
  echo "Whorl needs more packages, and installing them needs root. Run this line, then this script again:" >&2
  echo "  sudo apt-get install -y --no-install-recommends ${missing[*]}" >&2
  exit 1
fi
echo "Installing: ${missing[*]}"
export DEBIAN_FRONTEND=noninteractive
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
