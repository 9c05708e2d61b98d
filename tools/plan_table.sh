#!/usr/bin/env bash
# What `whorl plan` predicts beside what a run takes: CPU seconds of one thread and peak memory, for the beginning of every shipped scene at draft quality,
# without pictures. Prints a table in Markdown.
#
#   tools/plan_table.sh [WHORL ["SCENE:UNTIL ..."]]
set -euo pipefail
cd "$(dirname "$0")/.."
whorl=${1:-build/release/whorl}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
echo "| scene | until | predicted | taken | | memory predicted | taken | |"
echo "|---|---|---|---|---|---|---|---|"
cases="honey_coil:1.5 honey_ball:1.2 honey_thread:0.7 sewing_machine:1 cake_batter:0.8 toothpaste:1 lava:1 dripping_syrup:0.8 dam_break:0.6
dam_break_obstacle:0.6 paddle:0.4 floating_boxes:0.5 rotating_drop:0.3 karman_street:0.2 shear_layer:0.15 stirred_tank:0.3 taylor_green:0.15 vortex_rings:0.15"
for case in ${2:-$cases}; do
    scene=${case%:*} until=${case#*:}
    set=(--quality draft --until "$until" --threads 1)
    "$whorl" plan "scenes/$scene.toml" "${set[@]}" --no-images --json > "$folder/plan.json"
    "$whorl" render "scenes/$scene.toml" "${set[@]}" --no-images --quiet --out "$folder/$scene" > /dev/null 2>&1
    python3 - "$scene" "$until" "$folder/plan.json" "$folder/$scene" <<'PY'
import glob, json, sys
scene, until, plan, folder = sys.argv[1], sys.argv[2], json.load(open(sys.argv[3])), sys.argv[4]
runs = [json.load(open(f)) for f in glob.glob(folder + "/panels/*/run.json") or [folder + "/run.json"]]
p, t = plan["cost"]["film_seconds"], sum(r["cpu_seconds"] for r in runs)
m, n = plan["cost"]["memory_bytes"], max(r["peak_memory_bytes"] for r in runs)
print(f"| {scene} | {until} s | {p:.1f} s | {t:.1f} s | {100*(p/t-1):+.0f} % | {m/1e6:.0f} MB | {n/1e6:.0f} MB | {100*(m/n-1):+.0f} % |")
PY
done
