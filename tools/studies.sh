#!/usr/bin/env bash
# Runs the shipped studies again and puts their fronts, maps and tables into docs/studies: under half an hour on two cores. Points that are in out/ already
# are kept: remove out/<study> after a change of the program.
#
#   tools/studies.sh                       all
#   tools/studies.sh scale dam_front       these
set -euo pipefail
cd "$(dirname "$0")/.."
whorl=build/release/whorl
[ -x "$whorl" ] || bash tools/build.sh release whorl
mkdir -p docs/studies
run() {  # KIND STUDY
    [ "$2" != precision ] || bash tools/build.sh double whorl  # the other program of this map
    "$whorl" "$1" "$2" | tee "out/$2.log"
    cp "out/$2/$1.svg" "docs/studies/$2.svg"
    sed "s|$PWD/||g" "out/$2/$1.csv" > "docs/studies/$2.csv"  # messages name files
    [ "$1" != tradeoff ] || sed -n '/settings on the front/,/tradeoff.csv/p' "out/$2.log" | sed '$d' > "docs/studies/$2.txt"
}
mkdir -p out
for kind in tradeoff stability; do
    for file in scenes/studies/"$kind"/*.toml; do
        study=$(basename "$file" .toml)
        [ $# -eq 0 ] || [[ " $* " == *" $study "* ]] || continue
        run "$kind" "$study"
    done
done
