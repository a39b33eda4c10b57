#!/usr/bin/env bash
# tiles.sh PROGRAM: the tiles of a small map by `hexrelief tiles solve`, by the commands that it prints, by shards, by Snakemake, by
# a Slurm array, and by Snakemake on Slurm, whose workers are killed at random and which are then started again; with a disk that
# becomes full, and with a node that is lost. All files have the bytes of an undisturbed run. What is not installed, or needs root,
# is passed over aloud. Some minutes: not one of ctest's tests.
set -euo pipefail
program=$(realpath "$1")
here=$(cd "$(dirname "$0")" && pwd)
samples=$(realpath "$here/../../samples")
# shellcheck source=kills.sh
source "$here/kills.sh"

"$samples/tiles/make_map.py" 1500x1200 map.pfm
options=(--tile-vertices 40 --set mesh.spacing_px=2.5 --set export.compression=draco
    --set input.calibration.focal_px=1500 --set input.calibration.baseline_m=0.5)
hexrelief tiles plan map.pfm -o plan "${options[@]}" --quiet
cp -r plan undisturbed
hexrelief tiles solve undisturbed --quiet
hexrelief tiles merge undisturbed -o undisturbed/tileset.json --quiet

# Of all that a plan's folder holds, but Snakemake's marks.
sums() { (cd "$1" && find . -type f ! -path './solved/*' ! -name '.hexrelief-*' -print0 | sort -z | xargs -0 sha256sum); }
# shellcheck disable=SC2094 # another sums
sums undisturbed > sums
tiles=$(hexrelief tiles solve plan --print-commands | wc -l)
((tiles >= 30)) || fail "a plan of $tiles tiles only"

check() {  # check FOLDER WORDS
    sums "$1" | diff - sums || fail "$1: other files, or other bytes, than those of the undisturbed run"
    told_leftovers "$1"
    echo "PASS $1: $tiles tiles, $(wc -l < sums) files; $2"
}
merge() { hexrelief tiles merge "$1" -o "$1/tileset.json" --quiet; }

until_done plan hexrelief tiles plan map.pfm -o jobs "${options[@]}" --quiet
all=$told
until_done jobs hexrelief tiles solve jobs --jobs 2
all+="; $told"
until_done merge merge jobs
check jobs "plan: $all; merge: $told"

cp -r plan commands
hexrelief tiles solve commands --print-commands --threads 1 > commands.txt
# shellcheck disable=SC2016 # the inner shell's
until_done commands xargs -a commands.txt -P 2 -d '\n' -n 1 sh -c 'eval "$0" || exit 1'
merge commands
check commands "$told"

cp -r plan shards
seq 8 > numbers.txt
# shellcheck disable=SC2016 # the inner shell's
until_done shards xargs -a numbers.txt -P 2 -n 1 sh -c 'hexrelief tiles solve shards --shard "$0/8" --threads 1 || exit 1'
merge shards
check shards "$told"

# A disk with room for the plan and some of the tiles.
mkdir full
room=$(($(du -sk plan | cut -f1) + $(du -sk undisturbed/tiles | cut -f1) / 3))
if mount -t tmpfs -o "size=${room}k" tmpfs full 2>mount.log; then
    mounts+=("$work/full")
    cp -r plan/. full
    code=0
    hexrelief tiles solve full --quiet 2>full.log || code=$?
    [[ $code == 4 ]] || { cat full.log; fail "a full disk gave exit code $code"; }
    done_before=$(find full/tiles -name '*.json' | wc -l)
    mount -o "remount,size=$((4 * room))k" full
    hexrelief tiles solve full > log
    merge full
    ((done_before > 0)) || fail "a full disk: no tile was done before it was full"
    check full "$done_before done before the disk was full ($(head -n 1 full.log))"
else
    echo "NOTE: no disk can be full here: $(cat mount.log)"
fi

cp -r "$samples"/tiles/Snakefile "$samples"/cluster/{local,slurm} .
snake() {  # snake PROFILE OUT CONFIG...
    snakemake --profile "$1" --latency-wait 5 --config map=map.pfm out="$2" threads=1 options="${options[*]}" "${@:3}"
}
if command -v snakemake >/dev/null; then
    until_done snakemake snake local snakemake shards=8
    check snakemake "$told"
else
    echo "NOTE: no snakemake here: the Snakefile is not tested"
fi

# shellcheck source=slurm.sh
source "$here/slurm.sh"
if start_slurm; then
    array() {  # array FOLDER OPTION...
        sbatch --wait --array=1-8 --cpus-per-task=1 --mem=500 --output=array-%a.log "${@:2}" "$samples/tiles/array.sbatch" "$1"
    }
    cp -r plan array
    until_done array array array --no-requeue
    merge array
    check array "$told"

    cp -r plan lost
    array lost > log 2>&1 &
    submitted=$!
    until [[ -n $(find lost/tiles -name '*.json' 2>/dev/null | head -n 3) ]]; do sleep 0.02; done
    lose_node
    wait $submitted || { cat log; fail "the array ended with the node that was lost"; }
    requeued=$(grep -c 'Requeuing JobId' slurm/slurmctld.log) || fail "nothing was on the node that was lost"
    done_since=$(find lost/tiles -name '*.json' -newer slurm/lost | wc -l)
    merge lost
    check lost "the node was lost, $requeued tasks queued again; $done_since tiles since"

    if command -v snakemake >/dev/null; then
        until_done slurm snake slurm slurm-out shards=4 mem_mb=500
        check slurm-out "$told"
    fi
else
    echo "NOTE: Slurm could not be started here: $slurm_problem"
fi
echo "ALL PASSED"
