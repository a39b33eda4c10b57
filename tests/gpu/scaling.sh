#!/usr/bin/env bash
# scaling.sh FOLDER [SIDE] [WORK] [TILE_VERTICES]: tiles on 1, 2, 4, ... CUDA devices of this machine, each with its share of the
# processors. FOLDER as run.sh takes it. Strong scaling: one map of SIDE x SIDE px (32768), planned once, solved by more and more
# devices, whose bytes are compared. Weak scaling: a map of as many pixels a device. Needs 6 bytes of disk a pixel in WORK (a
# temporary folder).
set -euo pipefail
folder=$1
side=${2:-32768}
work=$(mktemp -d "${3:-/tmp}/scaling-XXXXXX")
trap 'rm -rf "$work"' EXIT
tile_vertices=${4:-512}
program=$folder/hexrelief
make_map=$(cd "$(dirname "$0")/../.." && pwd)/samples/tiles/make_map.py  # needs numpy
[[ -d $folder/lib ]] && export LD_LIBRARY_PATH=$folder/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
devices=$(nvidia-smi -L | wc -l)
cores_each=$(($(nproc) / devices))

# plan_of MAP FOLDER
plan_of() {
    "$program" tiles plan "$1" -o "$2" --tile-vertices "$tile_vertices" --backend cuda --quiet \
        --set input.calibration.focal_px=20000 --set input.calibration.baseline_m=0.5
}
# solve_on COUNT FOLDER: seconds of `tiles solve` by so many devices.
solve_on() {
    local begun
    begun=$(date +%s.%N)
    taskset -c "0-$(($1 * cores_each - 1))" "$program" tiles solve "$2" --backend cuda --gpus "$1" --force --quiet
    awk -v from="$begun" -v to="$(date +%s.%N)" 'BEGIN { print to - from }'
}
tiles_of() { find "$1/tiles" -name '*.json' | wc -l; }
sums_of() { (cd "$1" && find tiles -name '*.mesh' -o -name '*.glb' | sort | xargs sha256sum); }

"$make_map" "${side}x$side" "$work/map.pfm"
plan_of "$work/map.pfm" "$work/plan"
solve_on 1 "$work/plan" >/dev/null  # the files' pages and the folders are there from now on
for ((n = 1; n <= devices; n *= 2)); do
    seconds=$(solve_on $n "$work/plan")
    [[ $n == 1 ]] && one=$seconds && sums_of "$work/plan" >"$work/sums"
    sums_of "$work/plan" | cmp - "$work/sums"
    awk -v n=$n -v cores=$((n * cores_each)) -v s="$seconds" -v one="$one" -v tiles="$(tiles_of "$work/plan")" 'BEGIN {
        printf "strong: %d devices, %d cores: %.2f s, %.1f tiles/s, %.2f times one\n", n, cores, s, tiles / s, one / s }'
done
rm -rf "$work/plan" "$work/map.pfm"
for ((n = 1; n <= devices; n *= 2)); do
    part=$(awk -v side="$side" -v n=$n -v all="$devices" 'BEGIN { print int(side * sqrt(n / all) / 512 + 0.5) * 512 }')
    "$make_map" "${part}x$part" "$work/map.pfm"
    plan_of "$work/map.pfm" "$work/plan"
    solve_on $n "$work/plan" >/dev/null
    awk -v n=$n -v side="$part" -v s="$(solve_on $n "$work/plan")" -v tiles="$(tiles_of "$work/plan")" 'BEGIN {
        printf "weak: %d devices, %d x %d px: %.2f s, %.1f tiles/s, %.1f tiles/s a device\n", n, side, side, s, tiles / s,
            tiles / s / n }'
    rm -rf "$work/plan" "$work/map.pfm"
done
