#!/usr/bin/env bash
# Runs the fluid mechanical sewing machine (scenes/studies/sewing_machine.toml) at several belt speeds and prints the pattern that the thread writes.
#
#   tools/sewing_machine.sh                     belt speeds of 0.1 to 1.2 times the thread's where it lands
#   tools/sewing_machine.sh 0.2 0.4 0.8         these
#   options: --whorl PROGRAM, --out FOLDER (default out/sewing_machine), --spacing M
#
# Columns: belt speed over the thread's, belt speed [m/s]; frequency across the belt [Hz], along the belt over across; amplitude across the belt and along it [mm]; how fast the
# thread swings along the belt, at most, over the belt's speed (more than 1: it runs back, and crosses itself); the pattern.
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
whorl=$top/build/release/whorl out=out/sewing_machine spacing=2.5e-3 ratios=()
# Slender-thread theory: the thread lands 1.02 times as thick as it leaves the nozzle with 0.25 m/s.
landing=0.240
while [ $# -gt 0 ]; do
    case $1 in
        --whorl) whorl=$2; shift 2 ;;
        --out) out=$2; shift 2 ;;
        --spacing) spacing=$2; shift 2 ;;
        -h | --help) sed -n '2,10s/^# \{0,1\}//p' "$0"; exit 0 ;;
        *) ratios+=("$1"); shift ;;
    esac
done
[ ${#ratios[@]} -gt 0 ] || ratios=(0.1 0.2 0.3 0.4 0.5 0.6 0.8 1.0 1.2)
mkdir -p "$out"
printf '%6s %7s | %7s %6s | %7s %7s | %5s  %s\n' "V/Uc" "V" "f_z" "f_x/f_z" "A_z" "A_x" "back" "pattern"
for ratio in "${ratios[@]}"; do
    speed=$(awk "BEGIN { print $ratio * $landing }")
    folder=$out/$ratio
    "$whorl" render "$top/scenes/studies/sewing_machine.toml" --no-images --quiet --out "$folder" --set "fluid.spacing=$spacing" \
        --set "solid[0].position=[\"-$speed*t\", \"0\", \"0\"]" > "$folder.log" 2>&1 || { echo "V/Uc = $ratio failed, see $folder.log"; continue; }
    # The newest 2 s: frequencies from the times at which x and z cross their means upward, amplitudes from the standard deviation.
    awk -F, -v ratio="$ratio" -v V="$speed" '
        NR == 1 { for (k = 1; k <= NF; ++k) { if ($k == "centroid_x") cx = k; if ($k == "centroid_z") cz = k }; next }
        { t[++n] = $1; x[n] = $cx; z[n] = $cz }
        function frequency(s, mean, width,   k, first, last, turns, at, below) {
            turns = -1; below = 0
            for (k = start; k <= n; ++k) {
                if (s[k] < mean - 0.2 * width) below = 1
                if (below && s[k] > mean + 0.2 * width) { last = t[k]; if (turns < 0) first = last; ++turns; below = 0 }
            }
            return turns > 0 ? turns / (last - first) : 0
        }
        END {
            for (start = 1; t[start] < t[n] - 2; ++start);
            for (k = start; k <= n; ++k) { mx += x[k]; mz += z[k]; ++m }
            mx /= m; mz /= m
            for (k = start; k <= n; ++k) {
                sx += (x[k] - mx)^2; sz += (z[k] - mz)^2
                if (k > start && (back = -(x[k] - x[k - 1]) / (t[k] - t[k - 1]) / V) > most) most = back
            }
            sx = sqrt(sx / m); sz = sqrt(sz / m)
            fz = frequency(z, mz, sz); fx = frequency(x, mx, sx)
            pattern = "straight"
            if (sz > 1e-3) pattern = fx < 1.4 * fz ? "translated coils" : most > 1 ? "alternating loops" : "meanders"
            printf "%6.2f %7.4f | %7.3f %6.2f | %7.2f %7.2f | %5.2f  %s\n", ratio, V, fz, fz > 0 ? fx / fz : 0, 1414 * sz, 1414 * sx, most, pattern
        }' "$folder/probes/thread.csv"
done
