#!/usr/bin/env bash
# Makes samples/pairs.jpg: four Middlebury scenes, a row each. From the pair: the disparity map, the mesh from 20 degrees to the
# left and to the right; then the same from the ground truth.
# usage: samples/pair_views.sh DIR OUT.jpg [PROGRAM]
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
# scene NAME LEFT RIGHT MAP SCALE [OPTION ...]
scene() {
    local name=$1 left=$data/$2 right=$data/$3 map=$data/$4 scale=$5
    shift 5
    local pair=(--left "$left" --right "$right") truth=(--disparity "$map" --disparity-scale "$scale" --color "$left")
    "$program" run --quiet "${pair[@]}" "$@" -o "$work/$name.obj" --save-stages "$work/$name"
    "$program" run --quiet "${truth[@]}" "$@" -o "$work/$name-truth.obj" --save-stages "$work/$name-truth"
    files+=("$work/$name/disparity.png" "$work/$name.obj" "$work/$name-truth/disparity.png" "$work/$name-truth.obj")
}
scene aloe middlebury2006/aloe-half/{left.png,right.png,disp.png} 2 --set input.calibration.focal_px=1870 \
    --set input.calibration.baseline_m=0.16 --set input.calibration.doffs_px=135
scene Piano middlebury2014-quarter/Piano/{left.png,right.png,disp.pfm} 1 --calib "$data/middlebury2014-quarter/Piano/calib.txt"
scene cones middlebury2003/cones-half/{left.ppm,right.ppm,disp.pgm} 2
scene teddy middlebury2003/teddy-half/{left.ppm,right.ppm,disp.pgm} 2
"$(dirname "$0")/side_views.py" "$out" 4 "${files[@]}"
