#!/usr/bin/env bash
# run.sh [FOLDER] [DATA]: everything that needs a CUDA device. FOLDER is a build folder or one made by bundle.sh; without
# one, and with cmake and nvcc here, build-cuda/ is built first. DATA holds Middlebury's maps as BENCHMARKS.md says.
# Needs no network. Ends with a summary; exits 1 where anything failed, was skipped, or did not use the GPU.
set -uo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
folder=${1:-}
data=${2:-}
if [[ -z $folder ]]; then
    folder=$root/build-cuda
    (cd "$root" && cmake --preset cuda "-DCMAKE_CUDA_ARCHITECTURES=${CUDAARCHS:-native}" && cmake --build --preset cuda) || exit 1
fi
programs=$folder
[[ -x $programs/test_cuda ]] || programs=$folder/tests/cuda
tests=$programs/test_cuda
program=$folder/hexrelief
[[ -d $folder/lib ]] && export LD_LIBRARY_PATH=$folder/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
results=()
failed=0

# check NAME COMMAND...: notes whether the command succeeded, and says so at once, so that a run that is cut short shows
# how far it came; its output is shown where it did not.
check() {
    local name=$1 start=$SECONDS result=pass
    shift
    "$@" >"$work/log" 2>&1 || result=FAIL
    results+=("$result  $name")
    echo "${results[-1]}  ($((SECONDS - start)) s)"
    [[ $result == pass ]] && return
    failed=1
    tail -n 30 "$work/log"
}
# A device that never answers is a failure, too.
limited() { timeout --kill-after=10 "$@"; }

# GoogleTest succeeds when everything was skipped; here that is a failure.
all_ran() { limited 300 "$@" && grep -q '\[  PASSED  \]' "$work/log" && ! grep -q 'no CUDA device here' "$work/log"; }
gpu_used() {
    nvidia-smi --query-gpu=name,driver_version --format=csv,noheader &&
        "$program" devices | grep -q '^cuda.*compute capability'
}
sanitized() {  # racecheck takes four minutes for the balancing in a cluster alone
    command -v compute-sanitizer >/dev/null || { echo "compute-sanitizer is missing"; return 1; }
    limited 900 compute-sanitizer --tool "$1" --error-exitcode 9 "$tests" \
        --gtest_filter='CudaSmall.*:Cuda/PaperSom.TimesItsKernels/*' && grep -q 'PASSED' "$work/log" &&
        ! grep -q 'no CUDA device here' "$work/log"
}
same_files() {  # a map by both backends: 2D mesh, GLB and Draco file must be the same bytes
    local map=$1 scale=$2 backend
    for backend in cpu cuda; do
        rm -rf "$work/$backend" && mkdir "$work/$backend"
        limited 60 "$program" run --disparity "$map" --disparity-scale "$scale" --unknown 0 --backend "$backend" --quiet \
            --save-stages "$work/$backend" -o "$work/$backend/m.glb" -o "$work/$backend/m.drc" \
            --report "$work/$backend.json" || return 1
        grep -q "\"backend\": \"$backend\"" "$work/$backend.json" || return 1
    done
    for file in mesh2d.obj m.glb m.drc; do cmp "$work/cpu/$file" "$work/cuda/$file" || return 1; done
}

check "the GPU is there and used" gpu_used
check "CPU and CUDA give the same bytes" all_ran "$tests"
for tool in memcheck racecheck initcheck synccheck; do check "compute-sanitizer $tool" sanitized "$tool"; done
check "200 runs give the same bytes" all_ran env HEXRELIEF_REPEATS=200 "$tests" --gtest_filter='CudaRepeats.*'
if [[ -n $data ]]; then
    while read -r map scale; do
        [[ -f $data/$map ]] && check "files of both backends: $map" same_files "$data/$map" "$scale"
    done <<'MAPS'
middlebury2001/tsukuba/disp.pgm 16
middlebury2001/venus/disp.pgm 8
middlebury2003/teddy-quarter/disp.png 4
middlebury2003/cones-quarter/disp.png 4
middlebury2006/rocks1-third/disp.png 3
middlebury2006/aloe-third/disp.png 3
middlebury2003/teddy-half/disp.pgm 2
middlebury2003/cones-half/disp.pgm 2
middlebury2006/rocks1-half/disp.png 2
middlebury2006/aloe-half/disp.png 2
middlebury2006/aloe-full/disp.png 1
middlebury2003/teddy-full/disp.pgm 1
middlebury2003/cones-full/disp.pgm 1
MAPS
    limited 600 "$programs/bench_paper" --data "$data" --experiments size --largest 2048 2>&1 | tail -n 120
fi
# Short forms: the paper's own program beside ours, on the made-up scene.
bench_paper() {
    limited 300 "$programs/bench_paper" --experiments memory,kernels,size --runs 3 --sweep-runs 1 --largest 4096 \
        --json "$work/bench.json" &&
        grep -q '"solver":"paper"' "$work/bench.json" && grep -q '"solver":"hexrelief"' "$work/bench.json"
}
check "the paper's experiments" bench_paper
cat "$work/log"
check "the matcher's time" limited 300 "$programs/bench_matching"
cat "$work/log"
printf '\n%s\n' "--- summary"
printf '%s\n' "${results[@]}"
[[ $failed -eq 0 ]] && echo "ALL PASSED" || echo "SOMETHING FAILED"
exit $failed
