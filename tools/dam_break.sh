#!/usr/bin/env bash
# A whole dam break (scenes/dam_break.toml, 4 s) without pictures: prints lines for docs/pressure.md, one a number of threads. Minutes to hours: an idle machine.
#
#   tools/dam_break.sh [--whorl PROGRAM] [--out FOLDER] [--spacing M] [--until S] [--threads "1 2"]       (5.47e-3: 49,000 particles, 3.43e-3: 200,000)
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
whorl=$top/build/release/whorl out=out/dam_break spacing=5.47e-3 until=4 threads="2"
while [ $# -gt 0 ]; do
    case $1 in
        --whorl) whorl=$2; shift 2 ;;
        --out) out=$2; shift 2 ;;
        --spacing) spacing=$2; shift 2 ;;
        --until) until=$2; shift 2 ;;
        --threads) threads=$2; shift 2 ;;
        *) sed -n '2,4s/^# \{0,1\}//p' "$0"; exit 2 ;;
    esac
done
mkdir -p "$out"
number() { sed -n "s/^ *\"$1\": *\([0-9.e+-]*\),\{0,1\}$/\1/p" "$2" | head -1; }
echo "| particles | threads | steps | iterations a step | wall us a particle-step | CPU us | simulated s a wall s | mean density error % | largest % | lost | bytes a particle |"
echo "|---|---|---|---|---|---|---|---|---|---|---|"
for count in $threads; do
    folder=$out/${spacing}_$count
    "$whorl" render "$top/scenes/dam_break.toml" --no-images --no-video --quiet --threads "$count" --until "$until" --out "$folder" --set "fluid.spacing=$spacing" > "$folder.log" 2>&1 ||
        { echo "| $spacing m | $count | failed: see $folder.log |"; continue; }
    run=$folder/run.json
    # Solver time alone: the wall and CPU seconds of all stages; frames are surfaced and written beside it.
    iterations=$(awk '/^  "iterations": \{/ { on = 1; next } on && /\}/ { exit } on { gsub(/[^0-9.]/, "", $2); sum += $2 } END { print sum + 0 }' "$run")
    awk -F, -v run_particles="$(number particles "$run")" -v count="$count" -v steps="$(number steps "$run")" -v iterations="$iterations" -v wall="$(number wall_seconds "$run")" \
        -v cpu="$(number cpu_seconds "$run")" -v particle_steps="$(number particle_steps "$run")" -v lost="$(number lost_particles "$run")" -v bytes="$(number peak_memory_bytes "$run")" '
        NR == 1 { for (k = 1; k <= NF; ++k) column[$k] = k; next }
        { mean += $column["density_error_mean"]; ++rows; if ($column["density_error_max"] > largest) largest = $column["density_error_max"]; time = $column["time"] }
        END { printf "| %d | %d | %d | %.1f | %.2f | %.2f | %.4f | %.3f | %.2f | %d | %.0f |\n", run_particles, count, steps, iterations / steps, 1e6 * wall / particle_steps, 1e6 * cpu / particle_steps,
                     time / wall, 100 * mean / rows, 100 * largest, lost, bytes / run_particles }' "$folder/diagnostics.csv"
done
