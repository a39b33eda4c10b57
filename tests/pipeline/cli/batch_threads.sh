#!/usr/bin/env bash
# batch_threads.sh PROGRAM SAMPLES: a batch of 20 rows with 3 workers of 2 threads each, by a program under ThreadSanitizer: pairs
# by both matchers, maps, both methods of the mesher, several formats. Fails where a row fails or the sanitizer says something.
set -euo pipefail
program=$(realpath "$1") samples=$(realpath "$2")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
{
    echo "left,right,disparity,calib,name,disparity.method,mesh.spacing_px,mesh.method"
    for row in {1..20}; do
        pair=$samples/left.png,$samples/right.png,, map=,,$samples/disparity.pfm,
        more=$((8 + row % 4)) method=cellular
        [[ $((row % 6)) -ne 4 ]] || method=sequential
        case $((row % 5)) in
            0) echo "$pair$samples/calib.txt,row$row,sgm,$more,$method" ;;
            1) echo "$pair$samples/calib.txt,row$row,sgbm,$more,$method" ;;
            *) echo "$map$samples/calib.txt,row$row,,$more,$method" ;;
        esac
    done
} >"$work/rows.csv"
export TSAN_OPTIONS="${TSAN_OPTIONS:-} log_path=$work/race"
"$program" batch "$work/rows.csv" -o "$work/out" --format glb,drc,obj,ply,usdz --jobs 3 --threads 2 >"$work/log" 2>&1 ||
    { cat "$work/log" "$work"/race.*; exit 1; }
if compgen -G "$work/race.*" >/dev/null; then
    cat "$work"/race.*
    exit 1
fi
[[ $(find "$work/out" -name '*.glb' | wc -l) -eq 20 ]]
