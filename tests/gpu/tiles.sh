#!/usr/bin/env bash
# tiles.sh FOLDER [SIDE] [WORK]: tiles on a CUDA device. FOLDER as run.sh takes it. First a map of 4096 x 4096 px is solved by the
# CPU and by the device, and the bytes are compared; then one of SIDE x SIDE px (32768) is made in WORK (a temporary folder),
# planned, solved and merged by the device, with the times and the most memory of each command. Needs 5 bytes of disk a pixel.
set -euo pipefail
folder=$1
side=${2:-32768}
work=$(mktemp -d "${3:-/tmp}/tiles-XXXXXX")
trap 'rm -rf "$work"' EXIT
program=$folder/hexrelief
make_map=$(cd "$(dirname "$0")/../.." && pwd)/samples/tiles/make_map.py  # needs numpy
[[ -d $folder/lib ]] && export LD_LIBRARY_PATH=$folder/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
camera=(--set input.calibration.focal_px=20000 --set input.calibration.baseline_m=0.5)

# measured COMMAND...: its output, then seconds and MiB.
measured() {
    local begun most=0 now
    begun=$(date +%s.%N)
    "$@" &
    local process=$!
    while kill -0 $process 2>/dev/null; do
        now=$(awk '/VmHWM/ { print $2 }' /proc/$process/status 2>/dev/null || true)
        [[ -z $now || $now -le $most ]] || most=$now
        sleep 0.05
    done
    wait $process
    awk -v from="$begun" -v to="$(date +%s.%N)" -v kib="$most" -v name="$3" \
        'BEGIN { printf "%-8s %7.2f s %6d MiB\n", name, to - from, kib / 1024 }'
}

"$make_map" 4096x4096 "$work/small.pfm"
for backend in cpu cuda; do
    "$program" tiles plan "$work/small.pfm" -o "$work/$backend" --tile-vertices 200 --backend $backend --quiet \
        "${camera[@]}"
    "$program" tiles solve "$work/$backend" --backend $backend --quiet
    (cd "$work/$backend" && find . -name '*.lattice' -o -name '*.mesh' -o -name '*.glb' | sort | xargs sha256sum) \
        >"$work/$backend.sums"
done
cmp "$work/cpu.sums" "$work/cuda.sums"
echo "CPU and CUDA: the same bytes in $(wc -l <"$work/cpu.sums") files"

"$make_map" "${side}x$side" "$work/map.pfm"
for compression in none draco; do
    echo "--- $compression"
    measured "$program" tiles plan "$work/map.pfm" -o "$work/p" --backend cuda --verbose "${camera[@]}" \
        --set export.compression=$compression
    measured "$program" tiles solve "$work/p" --backend cuda
    measured "$program" tiles merge "$work/p" -o "$work/p/tileset.json" --verbose
    du -sh "$work/p" | cut -f1
    rm -rf "$work/p"
done
