#!/usr/bin/env bash
# What a model costs that a scene does not need: the plan's prediction beside what a run takes, with the model and without, for the beginning of shipped scenes at
# draft quality (one thread, no pictures, CPU seconds). Prints a table in Markdown.
#
#   tools/model_table.sh [--whorl PROGRAM] [SCENE ...]
set -euo pipefail
cd "$(dirname "$0")/.."
whorl=build/release/whorl wanted=()
while [ $# -gt 0 ]; do
    case $1 in
        --whorl) whorl=$2; shift 2 ;;
        *) wanted+=("$1"); shift ;;
    esac
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
echo "| scene | until | switched on | predicted | taken | predicted, without | taken, without | times as dear, predicted | taken | off by |"
echo "|---|---|---|---|---|---|---|---|---|---|"

# cost WORD SCENE UNTIL SETTING...: puts "predicted taken" into $folder/WORD, or the plan's refusal into $folder/refused
cost() {
    local word=$1 scene=$2 until=$3 options=()
    shift 3
    for setting in "$@"; do options+=(--set "$setting"); done
    options+=(--quality draft --until "$until" --threads 1 --no-images)
    "$whorl" plan "scenes/$scene.toml" "${options[@]}" --json > "$folder/plan.json" 2> "$folder/refused" || return 1
    "$whorl" render "scenes/$scene.toml" "${options[@]}" --quiet --out "$folder/run" > "$folder/log" 2>&1 || { cp "$folder/log" "$folder/refused"; return 1; }
    python3 -c "import json; p, r = (json.load(open('$folder/' + f)) for f in ('plan.json', 'run/run.json')); print(p['cost']['film_seconds'], r['cpu_seconds'])" \
        > "$folder/$word" || return 1
    rm -rf "$folder/run"
}
# pair SCENE UNTIL WORDS OFF ON: OFF and ON are settings, separated by blanks
pair() {
    local scene=$1 until=$2 words=$3
    [ ${#wanted[@]} -eq 0 ] || [[ " ${wanted[*]} " == *" $scene "* ]] || return 0
    # shellcheck disable=SC2086
    if cost without "$scene" "$until" $4 && cost with "$scene" "$until" $4 $5; then
        awk -v s="$scene" -v u="$until" -v w="$words" '{ p[NR] = $1; t[NR] = $2 } END {
            printf "| %s | %s s | %s | %.2f s | %.2f s | %.2f s | %.2f s | %.2f | %.2f | %+.0f %% |\n", s, u, w, p[2], t[2], p[1], t[1], p[2]/p[1], t[2]/t[1],
                100 * (p[2]/p[1] / (t[2]/t[1]) - 1) }' "$folder/without" "$folder/with"
    else
        echo "| $scene | $until s | $words | refused: $(head -1 "$folder/refused" | sed 's/^whorl: //; s/|/ /g') | | | | | | |"
    fi
}
fixed=""
for k in 1 2 3 4 5 6; do fixed+=" solid[$k].density=0"; done
pair honey_coil 1.2 "surface tension" "" "fluid.surface_tension=0.05"
pair honey_ball 0.9 "surface tension" "" "fluid.surface_tension=0.05"
pair honey_ball 0.9 "sleep" "" "time.sleep=0.06"
pair cake_batter 0.7 "surface tension" "" "fluid.surface_tension=0.05"
pair lava 0.8 "surface tension" "" "fluid.surface_tension=0.05"
pair toothpaste 0.8 "sleep" "" "time.sleep=0.06"
pair rotating_drop 0.3 "surface tension" "" "fluid.surface_tension=0.05"
pair dam_break 0.4 "surface tension" "" "fluid.surface_tension=0.07"
pair dam_break 0.4 "shifting" "" "models.shifting=fickian"
pair dam_break 0.4 "divergence-free velocities" "" "pressure.divergence_free=true"
pair dam_break_obstacle 0.3 "multigrid" "" "pressure.preconditioner=multigrid"
pair paddle 0.3 "divergence-free velocities" "" "pressure.divergence_free=true"
pair paddle 0.3 "sleep" "" "time.sleep=1"
pair floating_boxes 0.3 "free bodies" "$fixed" "solid[1].density=450 solid[2].density=350 solid[3].density=250 solid[4].density=2500 solid[5].density=500 solid[6].density=150"
pair floating_boxes 0.3 "divergence-free velocities" "" "pressure.divergence_free=true"
pair karman_street 0.1 "implicit viscosity (full)" "" "models.viscosity=full"
pair shear_layer 0.1 "implicit viscosity (full)" "" "models.viscosity=full"
pair shear_layer 0.1 "implicit exchange of spin" "" "micropolar.exchange=implicit"
pair vortex_rings 0.1 "implicit viscosity (full)" "" "models.viscosity=full"
pair taylor_green 0.1 "implicit viscosity (full)" "" "models.viscosity=full"
pair stirred_tank 0.2 "implicit viscosity (full)" "" "models.viscosity=full"
pair stirred_tank 0.2 "shifting" "" "models.shifting=fickian"
