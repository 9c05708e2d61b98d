#!/usr/bin/env bash
# What `whorl plan` predicts beside what a run takes: CPU seconds of one thread and peak memory, for the beginning of every shipped scene at draft quality,
# without pictures. Prints a table in Markdown.
#
#   tools/plan_table.sh [WHORL]
set -euo pipefail
cd "$(dirname "$0")/.."
whorl=${1:-build/release/whorl}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
echo "| scene | until | predicted | taken | | memory predicted | taken | |"
echo "|---|---|---|---|---|---|---|---|"
for case in honey_coil:1.5 honey_ball:1.2 dam_break:0.6 rotating_drop:0.3 karman_street:0.3 shear_layer:0.15 stirred_tank:0.3 taylor_green:0.2 vortex_rings:0.2; do
    scene=${case%:*} until=${case#*:}
    set=(--quality draft --until "$until" --threads 1)
    "$whorl" plan "scenes/$scene.toml" "${set[@]}" --no-images --json > "$folder/plan.json"
    "$whorl" render "scenes/$scene.toml" "${set[@]}" --no-images --quiet --out "$folder/$scene" > /dev/null 2>&1
    python3 - "$scene" "$until" "$folder/plan.json" "$folder/$scene/run.json" <<'PY'
import json, sys
scene, until, plan, run = sys.argv[1], sys.argv[2], json.load(open(sys.argv[3])), json.load(open(sys.argv[4]))
cost = plan["cost"]
p, t = cost["film_seconds"], run["cpu_seconds"]
m, n = cost["memory_bytes"], run["peak_memory_bytes"]
print(f"| {scene} | {until} s | {p:.1f} s | {t:.1f} s | {100*(p/t-1):+.0f} % | {m/1e6:.0f} MB | {n/1e6:.0f} MB | {100*(m/n-1):+.0f} % |")
PY
done
