#!/usr/bin/env bash
# Draws the pages' pictures of meshes of Middlebury's scenes.
# usage: samples/views.sh silhouettes|turn DIR OUT.jpg [PROGRAM]
# silhouettes: samples/figures/silhouettes.jpg, four scenes from the ground truth, from 20 degrees to the left and to the right: as
# one bridged mesh, and cut along depth discontinuities, which is the default. turn: samples/turn.jpg, Aloe from its two images,
# turned: above the mesh of the left view alone, below with what only the right camera saw, and what continues behind silhouettes.
# DIR holds Middlebury's sets as figures/BENCHMARKS.md lists them, with images, and middlebury2014-quarter/Piano.
set -euo pipefail
if [[ $# -lt 3 ]]; then
    sed -n '2,7s/^# //p' "$0"
    exit 2
fi
what=$1 data=$2 out=$3 program=${4:-build/hexrelief} baseline=0.16
here=$(dirname "$0")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
aloe_camera=(--set input.calibration.focal_px=1870 --set input.calibration.baseline_m="$baseline"
    --set input.calibration.doffs_px=135)

files=()
# NAME FOLDER LEFT MAP SCALE [OPTION ...]
silhouettes() {
    local name=$1 left=$data/$2/$3 map=$data/$2/$4 scale=$5 way
    shift 5
    for way in bridge cut; do
        "$program" run --quiet --disparity "$map" --disparity-scale "$scale" --color "$left" "$@" \
            --set surface.discontinuities=$way -o "$work/$name-$way.obj"
        files+=("$work/$name-$way.obj")
    done
}
case $what in
silhouettes)
    piano=middlebury2014-quarter/Piano
    silhouettes cones middlebury2003/cones-half left.ppm disp.pgm 2
    silhouettes teddy middlebury2003/teddy-half left.ppm disp.pgm 2
    silhouettes aloe middlebury2006/aloe-half left.png disp.png 2 "${aloe_camera[@]}"
    silhouettes Piano $piano left.png disp.pfm 1 --calib "$data/$piano/calib.txt"
    "$here/side_views.py" "$out" 2 "${files[@]}"
    ;;
turn)
    aloe=$data/middlebury2006/aloe-half
    for views in left both; do
        "$program" run --quiet --left "$aloe/left.png" --right "$aloe/right.png" "${aloe_camera[@]}" \
            --set surface.views=$views -o "$work/$views.obj"
    done
    "$here/turn_views.py" "$out" $baseline "$work/left.obj" "$work/both.obj"
    ;;
*) sed -n '2,7s/^# //p' "$0"; exit 2 ;;
esac
