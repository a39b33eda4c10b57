#!/usr/bin/env bash
# Makes samples/photos.jpg: three pairs of photographs, a row each: the left picture, and the mesh from 12 degrees to the left and
# to the right. Two of the pairs nobody rectified: they are meshed without a calibration.
#     samples/photos/photo_views.sh OUT.jpg [PROGRAM]
set -euo pipefail
if [[ $# -lt 1 ]]; then
    sed -n '2,4s/^# *//p' "$0"
    exit 2
fi
out=$1 program=${2:-build/hexrelief}
samples=$(dirname "$0")/..
photos=build/aloe
"$samples/fetch_photos.sh" "$photos"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

files=()
# row NAME LEFT RIGHT [OPTION ...]
row() {
    local name=$1 left=$photos/$2 right=$photos/$3
    shift 3
    "$program" run --quiet --left "$left" --right "$right" "$@" -o "$work/$name.obj"
    files+=("$left" "$work/$name.obj")
}
row aloe aloeL.jpg aloeR.jpg --config "$samples/../config/aloe.yaml"
row board left06.jpg right06.jpg
row ball basketball1.png basketball2.png
"$samples/side_views.py" "$out" 2 --angle=12 "${files[@]}"
