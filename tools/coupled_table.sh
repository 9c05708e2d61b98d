#!/usr/bin/env bash
# pressure = "coupled" beside pressure = "ppe" with viscosity = "full", on the same scenes with one thread: prints a table for docs/viscosity.md.
#
#   tools/coupled_table.sh [--whorl PROGRAM] [--out FOLDER] [--spacing M]         (M: of the coil and the thread; default 2.5e-3)
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
whorl=$top/build/release/whorl out=out/coupled_table spacing=2.5e-3
while [ $# -gt 0 ]; do
    case $1 in
        --whorl) whorl=$2; shift 2 ;;
        --out) out=$2; shift 2 ;;
        --spacing) spacing=$2; shift 2 ;;
        *) sed -n '2,4s/^# \{0,1\}//p' "$0"; exit 2 ;;
    esac
done
mkdir -p "$out"

# row SCENE MODEL MEASURE SET...: runs it and prints a line; MEASURE FOLDER says what was found.
# Of all solvers in a run.json.
iterations() { awk '/^  "iterations": \{/ { on = 1; next } on && /\}/ { exit } on { gsub(/[^0-9.]/, "", $2); sum += $2 } END { print sum + 0 }' "$1"; }
number() { sed -n "s/^ *\"$1\": *\([0-9.e+-]*\),\{0,1\}$/\1/p" "$2" | head -1; }
row() {
    local scene=$1 model=$2 measure=$3; shift 3
    local folder=$out/$(basename "$scene" .toml)_$model arguments=(--set "models.pressure=$model")
    if [ "$model" = ppe ]; then arguments+=(--set models.viscosity=full); else arguments+=(--set models.viscosity=auto); fi
    for one in "$@"; do arguments+=(--set "$one"); done
    OMP_NUM_THREADS=1 "$whorl" render "$scene" --no-images --quiet --threads 1 --out "$folder" "${arguments[@]}" > "$folder.log" 2>&1 ||
        { echo "| $(basename "$scene" .toml) | $model | failed: see $folder.log | | | |"; return; }
    local run=$folder/run.json
    printf '| %s | %s | %s | %.1f | %.1f | %s |\n' "$(basename "$scene" .toml)" "$([ "$model" = ppe ] && echo 'ppe + full' || echo coupled)" "$(number steps "$run")" \
        "$(awk -v a="$(iterations "$run")" -v b="$(number steps "$run")" 'BEGIN { print a / b }')" \
        "$(awk -v a="$(number cpu_seconds "$run")" -v b="$(number particle_steps "$run")" 'BEGIN { print 1e6 * a / b }')" "$($measure "$folder")"
}

# Slender-thread theory for the fall of 8 cm: 2.14 Hz, 17.7 mm.
coil() {
    awk -F, 'NR > 1 && $2 > 0 { f = $2; R = $3 } END { if (f > 0) printf "%.2f Hz (%+.0f %%), %.1f mm (%+.0f %%)", f, 100 * (f / 2.14 - 1), 1000 * R, 100 * (R / 0.0177 - 1); else printf "no coil" }' \
        "$1/probes/coil.csv"
}
# Radius 0.14 m below the nozzle in the second half, beside that of one-dimensional theory, 3 nu (u'/u)' + g/u - u' = 0, u(0) = 0.1, u' = 0 where the thread is taken away.
thread() {
    awk -F, 'function end_speed(uL,   u, w, z, h) { u = uL; w = 0; h = 1e-4
                 for (z = 0.25; z > 0; z -= h) { w -= h * (w * u - 9.81 / u) / 0.15; u -= h * u * w; if (z >= 0.14 && z - h < 0.14) middle = u }
                 return u }
             NR > 1 && $1 > 0.8 { m += $3; ++n; if (least == "" || $3 < least) least = $3 }
             END { low = 0.1; high = 5
                   for (k = 0; k < 60; ++k) { try = (low + high) / 2; if (end_speed(try) > 0.1) high = try; else low = try }
                   end_speed(low); a = sqrt(0.1 / middle) * 5
                   R = sqrt(m / n / (1000 * 3.14159265 * 0.02)) * 1000
                   printf "radius %.2f mm (%+.1f %%), least mass %.0f %% of the mean", R, 100 * (R / a - 1), 100 * least / (m / n) }' "$1/probes/thread.csv"
}
# Kinetic and potential energy at 0.7 s over that at the start; height of the middle.
dam() { awk -F, 'NR == 1 { for (k = 1; k <= NF; ++k) { if ($k == "kinetic_energy") a = k; if ($k == "potential_energy") b = k }; next } NR == 2 { e0 = $a + $b } { e = $a + $b } END { printf "%.0f %% of the energy left", 100 * e / e0 }' "$1/diagnostics.csv"; }

echo '| scene | models | steps | iterations a step | CPU us a particle-step | found |'
echo '|---|---|---|---|---|---|'
for model in coupled ppe; do row "$top/scenes/studies/steady_coil.toml" $model coil "fluid.spacing=$spacing"; done
for model in coupled ppe; do row "$top/scenes/studies/falling_thread.toml" $model thread "fluid.spacing=$spacing"; done
sed '/^\[viscosity\]/d; /^alpha/d' "$top/scenes/studies/dam_slab.toml" > "$out/dam_slab.toml"  # those keys belong to xsph
for model in coupled ppe; do row "$out/dam_slab.toml" $model dam fluid.viscosity=1e-3 'solid[0].slip=free' time.end=0.7; done
