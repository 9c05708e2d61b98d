#!/usr/bin/env bash
# Runs steady coils on a plate (scenes/studies/coil_on_plate.toml) and prints frequency and radius beside slender-thread theory.
#
#   tools/coil_rows.sh                          every row of scenes/studies/coil_theory.csv, 4 particles across the nozzle's radius
#   tools/coil_rows.sh --spacing 2e-3 2 3       rows 2 and 3, coarser
#   options: --whorl PROGRAM, --out FOLDER (default out/coil_rows), --turns N (default 8)
#
# Columns: row, speed [m/s], fall [m], kinematic viscosity [m^2/s], spacing [m]; frequency [Hz] measured +- uncertainty, in theory, deviation;
# coil radius [mm] likewise; fall that the probe saw [mm]; turns counted; CPU seconds.
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
whorl=$top/build/release/whorl out=out/coil_rows spacing=1.25e-3 turns=8 rows=()
while [ $# -gt 0 ]; do
    case $1 in
        --spacing) spacing=$2; shift 2 ;;
        --whorl) whorl=$2; shift 2 ;;
        --out) out=$2; shift 2 ;;
        --turns) turns=$2; shift 2 ;;
        -h | --help) sed -n '2,10s/^# \{0,1\}//p' "$0"; exit 0 ;;
        *) rows+=("$1"); shift ;;
    esac
done
theory=$top/scenes/studies/coil_theory.csv
[ ${#rows[@]} -gt 0 ] || mapfile -t rows < <(seq "$(($(wc -l < "$theory") - 1))")
mkdir -p "$out"
printf '%3s %6s %6s %6s %8s | %22s %7s %6s | %20s %6s %6s | %6s %6s %6s\n' \
    row speed fall nu spacing "frequency [Hz]" theory dev "radius [mm]" theory dev fall turns cpu
for row in "${rows[@]}"; do
    IFS=, read -r speed fall nu frequency radius _ < <(sed -n "$((row + 1))p" "$theory")
    folder=$out/row$row-$spacing
    # The fall takes no longer than fall/speed; what was laid goes after 0.6 of a turn; the plate circles until the thread has been down for 1.5 turns.
    end=$(awk "BEGIN { print $fall / $speed + $turns / $frequency }")
    circle=$(awk "BEGIN { printf \"%g*max(0, min(1, (%g-t)*%g))\", $radius, $fall / $speed + 1.5 / $frequency, $frequency }")
    phase=$(awk "BEGIN { printf \"(%g*t)\", 6.283185 * $frequency }")
    "$whorl" render "$top/scenes/studies/coil_on_plate.toml" --no-images --quiet --out "$folder" \
        --set "fluid.spacing=$spacing" --set "fluid.viscosity=$(awk "BEGIN { print 1000 * $nu }")" \
        --set "emitter[0].speed=$speed" --set "emitter[0].position=[0, $fall, 0]" \
        --set "solid[0].position=[\"$circle*cos$phase\", \"0\", \"$circle*sin$phase\"]" \
        --set "drain[0].after=$(awk "BEGIN { print 0.6 / $frequency }")" --set "time.end=$end" > "$folder.log" 2>&1 ||
        { echo "row $row failed, see $folder.log"; continue; }
    cpu=$(sed -n 's/.*"cpu_seconds": *\([0-9.]*\).*/\1/p' "$folder/run.json" | head -1)
    tail -1 "$folder/probes/coil.csv" | awk -F, -v r="$row" -v v="$speed" -v h="$fall" -v nu="$nu" -v d="$spacing" -v f="$frequency" -v R="$radius" \
        -v cpu="$cpu" '{
        if ($2 == "") { printf "%3d %6g %6g %6g %8g | no full turn\n", r, v, h, nu, d; exit }
        printf "%3d %6g %6g %6g %8g | %9.3f +- %-8.3f %9.3f %5.1f%% | %8.2f +- %-6.2f %7.2f %5.1f%% | %6.1f %6.1f %6.0f\n",
            r, v, h, nu, d, $2, $8, f, 100 * ($2 / f - 1), 1000 * $3, 1000 * $9, 1000 * R, 100 * ($3 / R - 1), 1000 * $10, $4, cpu
    }'
done
