#!/usr/bin/env bash
# plots.sh ROOT: samples/paper/plot.py draws all figures from the measurements beside it, bench/plot_match.py one from a row.
# Exits 77 without Debian's python3-matplotlib.
set -uo pipefail
root=$1
/usr/bin/python3 -c 'import matplotlib' 2>/dev/null || { echo "NOTE: no python3-matplotlib here: skipped"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export PYTHONDONTWRITEBYTECODE=1 MPLCONFIGDIR=$work
/usr/bin/python3 "$root/samples/paper/plot.py" "$root"/samples/paper/*.json -o "$work" || exit 1
for figure in 08 09 10 11 12 13; do
    for picture in "$work/fig$figure.png" "$root/samples/paper/fig$figure.png"; do
        size=$(stat -c %s "$picture") || exit 1
        [[ $size -gt 2000 && $size -lt 100000 ]] || { echo "FAIL $picture has $size bytes"; exit 1; }
    done
done
echo '{"rows": [{"scene": "a", "method": "sgm", "backend": "cpu", "bad_2_percent": 9, "bad_2_nonoccluded_percent": 4,
"edge_wrong_percent": 20, "edge_unknown_percent": 1, "roughness_px": 0.1, "seconds": {"median": 0.2}}]}' >"$work/match.json"
/usr/bin/python3 "$root/samples/bench/plot_match.py" "$work/match.json" "$work/match.png" || exit 1
[[ $(stat -c %s "$work/match.png") -gt 2000 ]] || { echo "FAIL match.png is too small"; exit 1; }
echo '{"device": "none", "rows": []}' >"$work/empty.json"
if /usr/bin/python3 "$root/samples/paper/plot.py" "$work/empty.json" -o "$work" 2>/dev/null; then
    echo "FAIL an empty file was drawn"
    exit 1
fi
