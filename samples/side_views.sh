#!/usr/bin/env bash
# Makes samples/figures/silhouettes.jpg: four Middlebury scenes from 20 degrees to the left and to the right,
# first as one bridged mesh, then cut along depth discontinuities, which is the default.
# usage: samples/side_views.sh DIR OUT.jpg [PROGRAM]
# DIR holds Middlebury's sets as figures/BENCHMARKS.md lists them, with images, and middlebury2014-quarter/Piano.
set -euo pipefail
if [[ $# -lt 2 ]]; then
    sed -n '2,5s/^# //p' "$0"
    exit 2
fi
data=$1 out=$2 program=${3:-build/hexrelief}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

files=()
scene() {
    local name=$1
    shift
    for way in bridge cut; do
        "$program" run --quiet "$@" --set surface.discontinuities=$way -o "$work/$name-$way.obj"
        files+=("$work/$name-$way.obj")
    done
}
scene cones --disparity "$data/middlebury2003/cones-half/disp.pgm" --disparity-scale 2 \
    --color "$data/middlebury2003/cones-half/left.ppm"
scene teddy --disparity "$data/middlebury2003/teddy-half/disp.pgm" --disparity-scale 2 \
    --color "$data/middlebury2003/teddy-half/left.ppm"
scene aloe --disparity "$data/middlebury2006/aloe-half/disp.png" --disparity-scale 2 \
    --color "$data/middlebury2006/aloe-half/left.png" --set input.calibration.focal_px=1870 \
    --set input.calibration.baseline_m=0.16 --set input.calibration.doffs_px=135
scene Piano --disparity "$data/middlebury2014-quarter/Piano/disp.pfm" --color "$data/middlebury2014-quarter/Piano/left.png" \
    --calib "$data/middlebury2014-quarter/Piano/calib.txt"
"$(dirname "$0")/side_views.py" "$out" 2 "${files[@]}"
