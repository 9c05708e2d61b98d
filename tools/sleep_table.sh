#!/usr/bin/env bash
# What sleep saves and what it changes: fluid that has come to rest, run awake and with time.sleep (`whorl tradeoff`, one thread). Prints a table in Markdown.
#
#   tools/sleep_table.sh [--whorl PROGRAM] [POOL ...]        POOL: the first word of its name
#
# CPU seconds of the simulation from the start and over the last second; largest difference of the potential energy from the run that stays awake, as the
# height [spacings] by which the fluid's middle differs, and over the energy that water of that height holds; mean CIE76 difference of the last picture.
set -euo pipefail
cd "$(dirname "$0")/.."
whorl=$PWD/build/release/whorl
[ "${1:-}" != --whorl ] || { whorl=$2; shift 2; }
wanted=("$@")
echo "| pool | time.sleep | CPU s, all | awake | times | CPU s, last second | awake | times | height differs by | energy by | picture by |"
echo "|---|---|---|---|---|---|---|---|---|---|---|"
# pool WORDS SCENE END SLEEP SETTING...
pool() {
    local words=$1 scene=$2 end=$3 sleep=$4 folder=out/sleep/${1//[^a-z]/_}
    shift 4
    [ ${#wanted[@]} -eq 0 ] || [[ " ${wanted[*]} " == *" ${words%%[, ]*} "* ]] || return 0
    rm -rf "$folder"; mkdir -p "$folder"
    {
        printf 'scenes = ["%s"]\nlimit = 3600\npictures = true\nset = ["time.end=%s", "time.fps=8", "time.slow_motion=1", "output.size=[480, 270]"' "$PWD/$scene" "$end"
        for setting in "$@"; do printf ", '%s'" "$setting"; done
        printf ']\n[[knob]]\nkey = "time.sleep"\nvalues = [0, %s]\n[accuracy]\nof = "picture"\nreference = ["time.sleep=0"]\n' "$sleep"
    } > "$folder/study.toml"
    "$whorl" tradeoff "$folder/study.toml" --all --threads 1 --jobs 1 --out "$folder" > "$folder/log"
    python3 - "$words" "$sleep" "$folder" <<'PY'
import csv, glob, json, re, sys
words, sleep, folder = sys.argv[1:4]
def run(value):
    path = glob.glob(f"{folder}/points/*time.sleep={value}-*/")[0]
    rows = [{k: float(v) if v else 0.0 for k, v in r.items()} for r in csv.DictReader(open(path + "diagnostics.csv"))]
    report = json.load(open(path + "run.json"))
    drawing = sum(s["cpu_seconds"] for n, s in report["stages"].items() if n in ("surface", "draw", "write", "encode"))
    frames = len(rows)
    late = [r for r in rows if r["time"] >= rows[-1]["time"] - 1 - 1e-9]
    return rows, report["cpu_seconds"] - drawing, late[-1]["cpu_seconds"] - late[0]["cpu_seconds"] - drawing * (len(late) - 1) / frames, path
awake, all_awake, late_awake, path = run("0")
asleep, all_asleep, late_asleep, _ = run(sleep)
text = open(path + "scene.resolved.toml").read().split("[fluid]")[1]
def value(key): return float(re.search(rf"^{key} = ([-+.e0-9]+)", text, re.M).group(1))
d, rho = value("spacing"), value("density")
weight = awake[-1]["particles"] * rho * d ** 3 * 9.81
most = max(abs(a["potential_energy"] - b["potential_energy"]) for a, b in zip(awake, asleep))
picture = [r for r in csv.DictReader(open(folder + "/tradeoff.csv")) if float(r["time.sleep"]) > 0][0]["error"]
gain = f"{late_awake/late_asleep:.0f}" if 100 * late_asleep > late_awake else "> 100"
print(f"| {words} | {sleep} | {all_asleep:.2f} | {all_awake:.2f} | {all_awake/all_asleep:.1f} | {max(late_asleep, 0):.3f} | {late_awake:.2f} | "
      f"{gain} | {most/weight/d:.3f} d | {100*most/abs(awake[-1]['potential_energy']):.2f} % | {float(picture):.2g} dE |")
PY
}
pool "honey, coupled" scenes/studies/puddle.toml 3 0.06
pool "honey, ppe" scenes/studies/puddle.toml 3 1 'models.pressure=ppe'
pool "water, ppe" scenes/studies/puddle.toml 8 1 'models.pressure=ppe' 'fluid.viscosity=0' 'look.material=water'
pool "honey_ball, poured out after 1 s" scenes/honey_ball.toml 5 0.06 'fluid.spacing=2.5e-3' 'emitter[0].stop=1' 'look.samples=1'
pool "toothpaste, laid in one place for 1 s" scenes/toothpaste.toml 8 0.15 'fluid.spacing=2.5e-3' 'emitter[0].stop=1' 'solid[0].position=["0", "0", "0"]' 'look.samples=1'
