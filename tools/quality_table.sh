#!/usr/bin/env bash
# Measures draft, standard and fine of every shipped scene: CPU seconds, error and picture of the first part of its film (`whorl tradeoff`, one thread), and
# writes them into the scenes' rows of README.md, docs/studies/quality.csv and docs/pictures/quality. About half an hour of one core.
#
#   tools/quality_table.sh                       all scenes
#   tools/quality_table.sh honey_coil lava       these; the rest of the table stays
#   tools/quality_table.sh --rows                only writes the rows again from docs/studies/quality.csv
#   options: --whorl PROGRAM
#
# Points are kept in out/quality/SCENE. Time: CPU seconds of the simulation over the seconds of film that were run, pictures not counted. Error: below, by
# scene; fine is what the others are held against where nothing exact is known. dE: mean CIE76 difference of the last picture from that of fine, 480x270.
set -euo pipefail
self=$(realpath "$0")
cd "$(dirname "$0")/.."
whorl=$PWD/build/release/whorl rows_only=
wanted=()
while [ $# -gt 0 ]; do
    case $1 in
        --whorl) whorl=$2; shift 2 ;;
        --rows) rows_only=1; shift ;;
        -h | --help) sed -n '2,12s/^# \{0,1\}//p' "$self"; exit 0 ;;
        *) wanted+=("$1"); shift ;;
    esac
done
csv=docs/studies/quality.csv pictures=docs/pictures/quality
mkdir -p "$pictures" out/quality
[ -f "$csv" ] || echo "scene,until,quality,spacing,particles,cpu_seconds_a_second,error,error_of,picture_difference" > "$csv"

# study SCENE UNTIL ACCURACY...: the study file of a scene. Eight frames are enough to see, and pictures then cost little.
study() {
    local scene=$1 until=$2
    shift 2
    printf 'scenes = ["%s"]\n' "$scene"
    printf 'set = ["time.end=%s", "time.slow_motion=1", "time.fps=%s", "output.size=[480, 270]"]\n' "$until" "$(awk "BEGIN { printf \"%.12g\", 8 / $until }")"
    printf 'pictures = true\nlimit = 3600\n[[knob]]\nkey = "quality"\nvalues = ["draft", "standard", "fine"]\n[accuracy]\n'
    printf '%s\n' "$@"
}

# measure SCENE UNTIL WHAT ACCURACY...: rows of the table. WHAT: the error in words.
measure() {
    local scene=$1 until=$2 what=$3 folder=out/quality/$1
    shift 3
    [ ${#wanted[@]} -eq 0 ] || [[ " ${wanted[*]} " == *" $scene "* ]] || return 0
    mkdir -p "$folder"
    study "$scene" "$until" "$@" > "$folder/figures.toml"
    study "$scene" "$until" 'of = "picture"' 'reference = ["quality=fine"]' > "$folder/picture.toml"
    for kind in figures picture; do  # the second finds the points of the first
        "$whorl" tradeoff "$folder/$kind.toml" --all --threads 1 --jobs 1 --out "$folder" > "$folder/$kind.log"
        mv "$folder/tradeoff.csv" "$folder/$kind.csv"
    done
    python3 - "$scene" "$until" "$what" "$folder" "$csv" <<'PY'
import csv, glob, json, os, re, sys
scene, until, what, folder, table = sys.argv[1:6]
figures, picture = ({r["quality"]: r for r in csv.DictReader(open(f"{folder}/{kind}.csv"))} for kind in ("figures", "picture"))
rows = []
for quality in ("draft", "standard", "fine"):
    run = glob.glob(f"{folder}/points/{scene}_quality={quality}-*/")[0]
    parts = [json.load(open(f)) for f in sorted(glob.glob(run + "panels/*/run.json")) or [run + "run.json"]]
    drawing = ("surface", "draw", "write", "encode")
    cpu = sum(p["cpu_seconds"] - sum(s["cpu_seconds"] for n, s in p["stages"].items() if n in drawing) for p in parts)
    text = open(glob.glob(run + "**/scene.resolved.toml", recursive=True)[0]).read()
    spacing = re.search(r"^spacing = ([-+.e0-9]+)", text, re.M).group(1)
    rows.append([scene, until, quality, spacing, parts[0]["particles"], f"{cpu/parts[0]['time']:.4g}", figures[quality]["error"], what, picture[quality]["error"]])
known = [r for r in csv.reader(open(table))]
known = [known[0]] + [r for r in known[1:] if r[0] != scene] + rows
out = csv.writer(open(table + ".new", "w"), lineterminator="\n")
out.writerows(known)
os.rename(table + ".new", table)
PY
    local inputs=()
    for quality in draft standard fine; do inputs+=(-i "$(ls "$folder/points/$scene"_quality="$quality"-*/frames/*.png | tail -1)"); done
    ffmpeg -v error -y "${inputs[@]}" -filter_complex "[0]scale=320:-1:flags=area[a];[1]scale=320:-1:flags=area[b];[2]scale=320:-1:flags=area[c];[a][b][c]hstack=3" \
        -q:v 3 "$pictures/$scene.jpg"
    echo "$scene done"
}

against_fine() { printf 'of = "reference"\nreference = ["quality=fine"]\nat = "all"\ntable = "%s"\ncolumn = "%s"\n' "$1" "$2"; }
density='of = "exact"
column = "density_error_mean"
at = "all"
expected = "0"
scale = 1'

measure_all() {
    measure toothpaste 2.0 "potential energy, to fine" "$(against_fine diagnostics.csv potential_energy)"
    measure cake_batter 0.8 "potential energy, to fine" "$(against_fine diagnostics.csv potential_energy)"
    measure honey_ball 0.9 "potential energy, to fine" "$(against_fine diagnostics.csv potential_energy)"
    measure lava 1.2 "potential energy, to fine" "$(against_fine diagnostics.csv potential_energy)"
    measure rotating_drop 0.4 "angular momentum lost" 'of = "conserved"' 'column = "angular_momentum_z"' 'at = "all"'
    measure dripping_syrup 0.3 "potential energy, to fine" "$(against_fine diagnostics.csv potential_energy)"
    measure sewing_machine 0.7 "kinetic energy, to fine" "$(against_fine diagnostics.csv kinetic_energy)"
    measure honey_thread 0.45 "potential energy, to fine" "$(against_fine diagnostics.csv potential_energy)"
    measure dam_break 0.08 "mean density error" "$density"
    measure honey_coil 1.6 "frequency of the first turns to steady theory" 'of = "exact"' 'table = "probes/coil.csv"' 'column = "frequency"' 'expected = "2.139"'
    measure dam_break_obstacle 0.12 "mean density error" "$density"
    measure paddle 0.08 "mean density error" "$density"
    measure floating_boxes 0.06 "mean density error" "$density"
    measure taylor_green 0.04 "kinetic energy without spin, to theory" 'of = "exact"' 'table = "panels/1/diagnostics.csv"' 'column = "kinetic_energy"' \
        'at = "all"' 'expected = "0.004*exp(-4*2e-5*(20*pi)^2*t)"'
    measure stirred_tank 0.04 "kinetic energy, to fine" "$(against_fine panels/2/diagnostics.csv kinetic_energy)"
    measure karman_street 0.02 "kinetic energy, to fine" "$(against_fine panels/2/diagnostics.csv kinetic_energy)"
    measure shear_layer 0.02 "kinetic energy, to fine" "$(against_fine panels/2/diagnostics.csv kinetic_energy)"
    measure vortex_rings 0.015 "kinetic energy, to fine" "$(against_fine panels/2/diagnostics.csv kinetic_energy)"
}
[ -n "$rows_only" ] || measure_all

# Columns 3 on of the scenes' rows: what the error is of, then time, error and difference of each quality, then the picture.
python3 - "$csv" README.md <<'PY'
import csv, re, sys
rows = {}
for r in csv.DictReader(open(sys.argv[1])): rows.setdefault(r["scene"], {})[r["quality"]] = r
def cell(r):
    error, de = 100 * float(r["error"]), float(r["picture_difference"])
    cpu = float(r["cpu_seconds_a_second"])
    words = [f"{cpu:.0f} s" if cpu >= 1000 else f"{cpu:.3g} s"]
    if not (r["quality"] == "fine" and error < 1e-6):  # it is the reference
        words.append(f"{error:.2g} %")
    if r["quality"] != "fine": words.append(f"{de:.2g} dE")
    return ", ".join(words)
def row(match):
    scene, what = match.group(1), match.group(2)
    if scene not in rows: return match.group(0)
    q = rows[scene]
    return (f"| `{scene}` | {what} | {q['draft']['error_of']}, {q['draft']['until']} s | " + " | ".join(cell(q[k]) for k in ("draft", "standard", "fine")) +
            f" | ![](docs/pictures/quality/{scene}.jpg) |")
text = open(sys.argv[2]).read()
text = re.sub(r"^\| `(\w+)` \| ([^|\n]*?) \|.*$", row, text, flags=re.M)
open(sys.argv[2], "w").write(text)
PY
