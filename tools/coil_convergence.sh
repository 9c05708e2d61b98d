#!/usr/bin/env bash
# Runs one row of coil_rows.sh at several spacings and draws frequency and radius over theory against the spacing, as an SVG picture.
#
#   tools/coil_convergence.sh                                 row 2 at 2.5, 2, 1.5 and 1.25 mm -> docs/pictures/coil_convergence.svg
#   tools/coil_convergence.sh --row 7 --to plot.svg 2e-3 1e-3
#   tools/coil_convergence.sh --from TABLE --to plot.svg      draws what coil_rows.sh printed before
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
row=2 to=$top/docs/pictures/coil_convergence.svg from= spacings=() passed=()
while [ $# -gt 0 ]; do
    case $1 in
        --row) row=$2; shift 2 ;;
        --to) to=$2; shift 2 ;;
        --from) from=$2; shift 2 ;;
        --whorl | --out | --turns) passed+=("$1" "$2"); shift 2 ;;
        -h | --help) sed -n '2,7s/^# \{0,1\}//p' "$0"; exit 0 ;;
        *) spacings+=("$1"); shift ;;
    esac
done
[ ${#spacings[@]} -gt 0 ] || spacings=(2.5e-3 2e-3 1.5e-3 1.25e-3)
if [ -z "$from" ]; then
    from=$(mktemp)
    for spacing in "${spacings[@]}"; do "$top/tools/coil_rows.sh" --spacing "$spacing" "${passed[@]}" "$row"; done | tee "$from"
fi
# Of a row's words: 5 spacing, 7 and 9 frequency and its uncertainty, 10 theory; 13 and 15 radius, 16 theory.
awk '
function x(mm) { return 70 + 480 * mm / 3 }
function y(part) { return 30 + 300 * (1.2 - part) / 0.4 }
function line(x1, y1, x2, y2, style) { printf "<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" %s/>\n", x1, y1, x2, y2, style }
function text(px, py, anchor, what) { printf "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">%s</text>\n", px, py, anchor, what }
function point(mm, value, error, colour, side) {
    line(x(mm) + side, y(value - error), x(mm) + side, y(value + error), "stroke=\"" colour "\" stroke-width=\"2\"")
    printf "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"5\" fill=\"%s\"/>\n", x(mm) + side, y(value), colour
}
BEGIN {
    print "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"580\" height=\"390\" font-family=\"sans-serif\" font-size=\"13\">"
    print "<rect width=\"580\" height=\"390\" fill=\"white\"/>"
    printf "<rect x=\"%.1f\" y=\"%.1f\" width=\"480\" height=\"%.1f\" fill=\"#eef3e6\"/>\n", x(0), y(1.1), y(0.9) - y(1.1)
    for (p = 80; p <= 120; p += 10) { line(x(0), y(p / 100), x(3), y(p / 100), "stroke=\"#ccc\""); text(x(0) - 8, y(p / 100) + 4, "end", p " %") }
    for (mm = 0; mm <= 3; mm += 0.5) { line(x(mm), y(0.8), x(mm), y(0.8) + 5, "stroke=\"#555\""); text(x(mm), y(0.8) + 20, "middle", mm) }
    line(x(0), y(1), x(3), y(1), "stroke=\"#555\" stroke-width=\"1.5\"")
    text(x(1.5), y(0.8) + 42, "middle", "particle spacing [mm]; nozzle radius 5 mm")
    text(x(0), 20, "start", "coil over slender-thread theory")
    blue = "#1f5fa8"; red = "#b8432f"
    printf "<circle cx=\"330\" cy=\"16\" r=\"5\" fill=\"%s\"/><circle cx=\"440\" cy=\"16\" r=\"5\" fill=\"%s\"/>\n", blue, red
    text(342, 20, "start", "frequency"); text(452, 20, "start", "radius")
}
$1 ~ /^[0-9]+$/ && $8 == "+-" { point(1000 * $5, $7 / $10, $9 / $10, blue, -3); point(1000 * $5, $13 / $16, $15 / $16, red, 3) }
END { print "</svg>" }' "$from" > "$to"
echo "$to"
