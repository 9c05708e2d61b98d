#!/usr/bin/env bash
# Is "auto" a good choice? The beginning of shipped scenes at draft quality with models.pressure and models.viscosity left to the plan, beside every combination of
# the two that a user might choose by hand (`whorl tradeoff`, one thread, CPU seconds, least of two timings). Prints a table in Markdown; what was measured is in
# out/auto/SCENE/tradeoff.csv.
#
#   tools/auto_table.sh [--whorl PROGRAM] [SCENE ...]
#
# Error: of the kinetic energy over all frames against a run with models chosen by the plan and standard spacing, over its largest value. A combination that takes
# more than four times the wall time of auto is broken off: it cannot be the cheaper one.
set -euo pipefail
cd "$(dirname "$0")/.."
whorl=$PWD/build/release/whorl wanted=()
while [ $# -gt 0 ]; do
    case $1 in
        --whorl) whorl=$2; shift 2 ;;
        *) wanted+=("$1"); shift ;;
    esac
done
echo "| scene | until | auto takes | time | error | best by hand that is as exact | time | auto is dearer by | others |"
echo "|---|---|---|---|---|---|---|---|---|"

# compare SCENE UNTIL COMBINATION...: PRESSURE+VISCOSITY each. A scene file of its own for each: tables of models that are not chosen may not stand there.
compare() {
    local scene=$1 until=$2 folder=out/auto/$1
    shift 2
    [ ${#wanted[@]} -eq 0 ] || [[ " ${wanted[*]} " == *" $scene "* ]] || return 0
    rm -rf "$folder"
    mkdir -p "$folder/scenes"
    python3 - "scenes/$scene.toml" "$folder/scenes" "$@" <<'PY'
import re, sys
text, folder, combinations = open(sys.argv[1]).read(), sys.argv[2], sys.argv[3:]
text = text[:text.index("[[panel]]")] + "\n[output]\n" + text[text.index("[quality.draft]"):] if "[[panel]]" in text else text
def without(text, table, keep=lambda line: False):  # the lines of a table that are not kept
    out, inside = [], False
    for line in text.splitlines(True):
        if line.startswith("["): inside = line.strip().split("]")[0] == "[" + table
        if not inside or line.startswith("[") or keep(line): out.append(line)
    return "".join(out)
for combination in combinations:
    pressure, viscosity = combination.split("+")
    t = without(text, "models", lambda line: not re.match("pressure|viscosity", line))
    t = re.sub(r"^\[models\].*\n", f'[models]\npressure = "{pressure}"\nviscosity = "{viscosity}"\n', t, flags=re.M) if "[models]" in t else \
        t.replace("[fluid]", f'[models]\npressure = "{pressure}"\nviscosity = "{viscosity}"\n\n[fluid]', 1)
    if viscosity != "xsph": t = without(t, "viscosity")
    if pressure not in ("auto", "wcsph") or "micropolar" not in text: t = without(t, "pressure")
    if pressure == "wcsph": t = re.sub(r'^"pressure\.tolerance".*\n', "", t, flags=re.M)  # it solves nothing
    open(f"{folder}/{combination}.toml", "w").write(t)
PY
    local limit=120
    # study COMBINATION...
    study() {
        printf 'scenes = ["scenes/%s.toml"]\nquality = "draft"\nlimit = %s\n' "auto+auto" "$limit"
        printf 'set = ["time.end=%s", "time.slow_motion=1", "time.fps=%s"]\n' "$until" "$(awk "BEGIN { printf \"%.12g\", 12 / $until }")"
        printf '[[knob]]\nkey = "scene"\nvalues = ['
        for combination in "$@"; do printf '"%s", ' "$PWD/$folder/scenes/$combination.toml"; done
        printf ']\n[accuracy]\nof = "reference"\nreference = ["quality=standard"]\ncolumn = "kinetic_energy"\nat = "all"\n[cost]\nrepeat = 2\n'
    }
    for some in 2 $#; do  # auto tells how long the others may take
        study "${@:1:$some}" > "$folder/study.toml"
        "$whorl" tradeoff "$folder/study.toml" --all --threads 1 --jobs 1 --out "$folder" > "$folder/log" 2>&1 || { echo "| $scene: $(tail -1 "$folder/log") |"; return 0; }
        limit=$(python3 -c 'import csv, sys; print(2 + 4*max(float(r["wall_seconds"]) for r in csv.DictReader(open(sys.argv[1])) if "auto+auto" in r["scene"]))' \
            "$folder/tradeoff.csv")
    done
    python3 - "$scene" "$until" "$folder" <<'PY'
import csv, glob, json, os, sys
scene, until, folder = sys.argv[1:4]
rows = {}
reader = csv.reader(open(folder + "/tradeoff.csv"))
head = next(reader)
at = {name: k for k, name in enumerate(head)}
knob = 1  # the second column is the knob
for r in reader: rows[os.path.basename(r[knob])[:-5]] = {n: r[at[n]] for n in ("cost_low", "error", "status", "message")}
auto = rows.pop("auto+auto")
cost, error = float(auto["cost_low"]), float(auto["error"])
run = json.load(open([f for f in glob.glob(folder + "/points/*auto+auto*/run.json") if "standard" not in f][0]))
took = "+".join(m["value"] for key in ("models.pressure", "models.viscosity") for m in run["models"] if m["key"] == key)
if took in rows and rows[took]["error"] == auto["error"]:  # the same run: four timings of it
    cost = min(cost, float(rows[took]["cost_low"]))
    rows[took]["cost_low"] = str(cost)
good = {n: r for n, r in rows.items() if r["status"] == "done" and float(r["error"]) <= 1.1 * error}
best = min(good, key=lambda n: float(good[n]["cost_low"]), default=None)
words = []
for name, r in rows.items():
    if name == best: continue
    why = r["message"].strip()
    words.append(f"{name} {float(r['cost_low']):.2g} s, {100*float(r['error']):.2g} %" if r["status"] == "done" else
                 f"{name} {r['status']}" + (f" ({why.split(': ', 1)[-1].split(';')[0][:90]})" if r["status"] == "refused" else ""))
hand = f"{best} | {float(good[best]['cost_low']):.2f} s | {100*(cost/float(good[best]['cost_low'])-1):+.0f} %" if best else "none | | "
print(f"| {scene} | {until} s | {took} | {cost:.2f} s | {100*error:.2g} % | {hand} | {'; '.join(words)} |".replace("\n", " "))
PY
}
honey="auto+auto coupled+none ppe+full ppe+full_assembled ppe+explicit wcsph+full"
water="auto+auto ppe+none ppe+xsph wcsph+none wcsph+xsph"
vortices="auto+auto wcsph+explicit wcsph+full ppe+explicit ppe+full"
# shellcheck disable=SC2086
for case in honey_coil:0.9 honey_ball:0.7 honey_thread:0.4 sewing_machine:0.6 cake_batter:0.6 toothpaste:0.7 lava:0.8 rotating_drop:0.2 dripping_syrup:0.15; do
    compare "${case%:*}" "${case#*:}" $honey
done
# shellcheck disable=SC2086
for case in dam_break:0.25 dam_break_obstacle:0.1 paddle:0.2 floating_boxes:0.06; do compare "${case%:*}" "${case#*:}" $water; done
# shellcheck disable=SC2086
for case in karman_street:0.02 shear_layer:0.02 vortex_rings:0.015 taylor_green:0.02 stirred_tank:0.03; do compare "${case%:*}" "${case#*:}" $vortices; done
