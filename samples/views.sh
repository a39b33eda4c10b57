#!/usr/bin/env bash
# Draws the pages' pictures of meshes of Middlebury's scenes.
# usage: samples/views.sh pairs|silhouettes|turn DIR OUT.jpg [PROGRAM]
# pairs: samples/pairs.jpg, four scenes, a row each: from the pair the disparity map and the mesh from 20 degrees to the left and to
# the right, then the same from the ground truth. silhouettes: samples/figures/silhouettes.jpg, the same scenes as one bridged mesh,
# and cut along depth discontinuities, which is the default. turn: samples/turn.jpg, Aloe from its two images, turned: above the
# mesh of the left view alone, below with what only the right camera saw, and what continues behind silhouettes.
# DIR holds Middlebury's sets as figures/BENCHMARKS.md lists them, with images, and middlebury2014-quarter/Piano.
set -euo pipefail
if [[ $# -lt 3 ]]; then
    sed -n '2,8s/^# //p' "$0"
    exit 2
fi
what=$1 data=$2 out=$3 program=${4:-build/hexrelief} baseline=0.16
here=$(dirname "$0")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
aloe_camera=(--set input.calibration.focal_px=1870 --set input.calibration.baseline_m="$baseline"
    --set input.calibration.doffs_px=135)

files=()
# NAME FOLDER LEFT RIGHT MAP SCALE [OPTION ...]
pairs() {
    local name=$1 left=$data/$2/$3 right=$data/$2/$4 map=$data/$2/$5 scale=$6
    shift 6
    "$program" run --quiet --left "$left" --right "$right" "$@" -o "$work/$name.obj" --save-stages "$work/$name"
    "$program" run --quiet --disparity "$map" --disparity-scale "$scale" --color "$left" "$@" -o "$work/$name-truth.obj" \
        --save-stages "$work/$name-truth"
    files+=("$work/$name/disparity.png" "$work/$name.obj" "$work/$name-truth/disparity.png" "$work/$name-truth.obj")
}
silhouettes() {
    local name=$1 left=$data/$2/$3 map=$data/$2/$5 scale=$6 way
    shift 6
    for way in bridge cut; do
        "$program" run --quiet --disparity "$map" --disparity-scale "$scale" --color "$left" "$@" \
            --set surface.discontinuities=$way -o "$work/$name-$way.obj"
        files+=("$work/$name-$way.obj")
    done
}
aloe_and_piano() {
    local piano=middlebury2014-quarter/Piano
    "$what" aloe middlebury2006/aloe-half left.png right.png disp.png 2 "${aloe_camera[@]}"
    "$what" Piano $piano left.png right.png disp.pfm 1 --calib "$data/$piano/calib.txt"
}
cones_and_teddy() {
    "$what" cones middlebury2003/cones-half left.ppm right.ppm disp.pgm 2
    "$what" teddy middlebury2003/teddy-half left.ppm right.ppm disp.pgm 2
}
case $what in
pairs) aloe_and_piano; cones_and_teddy; "$here/side_views.py" "$out" 4 "${files[@]}" ;;
silhouettes) cones_and_teddy; aloe_and_piano; "$here/side_views.py" "$out" 2 "${files[@]}" ;;
turn)
    aloe=$data/middlebury2006/aloe-half
    for views in left both; do
        "$program" run --quiet --left "$aloe/left.png" --right "$aloe/right.png" "${aloe_camera[@]}" \
            --set surface.views=$views -o "$work/$views.obj"
    done
    "$here/turn_views.py" "$out" $baseline "$work/left.obj" "$work/both.obj"
    ;;
*) sed -n '2,8s/^# //p' "$0"; exit 2 ;;
esac
