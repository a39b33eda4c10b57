#!/usr/bin/env bash
# Makes samples/turn.jpg: Aloe from its two images, turned. The upper row is the mesh of the left view alone, the lower one has what
# only the right camera saw, and what continues behind silhouettes.
# usage: samples/turn_views.sh DIR OUT.jpg [PROGRAM]
# DIR holds middlebury2006/aloe-half with images, as figures/BENCHMARKS.md lists it.
set -euo pipefail
if [[ $# -lt 2 ]]; then
    sed -n '2,5s/^# //p' "$0"
    exit 2
fi
aloe=$1/middlebury2006/aloe-half out=$2 program=${3:-build/hexrelief}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

baseline=0.16
for views in left both; do
    "$program" run --quiet --left "$aloe/left.png" --right "$aloe/right.png" --set input.calibration.focal_px=1870 \
        --set input.calibration.baseline_m=$baseline --set input.calibration.doffs_px=135 --set surface.views=$views \
        -o "$work/$views.obj"
done
"$(dirname "$0")/turn_views.py" "$out" $baseline "$work/left.obj" "$work/both.obj"
