#!/usr/bin/env bash
# Fuzzes: tests/fuzz/run.sh [SECONDS for each target, 30] [TARGET...]. Needs clang. HEXRELIEF_FUZZ_JOBS (2) run at a time. A unit
# may take HEXRELIEF_FUZZ_UNIT_SECONDS (2; of `run` five times that) and the process 2 GB. HEXRELIEF_FUZZ_SEED makes the same
# units each time, as many as there is time for. What is found lies in build-fuzz/found/TARGET, and grown corpora in
# build-fuzz/corpus/TARGET.
set -euo pipefail
cd "$(dirname "$0")/../.."
seconds="${1:-30}"
shift || true
if ! command -v clang++ >/dev/null; then
    echo "clang++ is not there; install the package clang" >&2
    exit 77
fi
cmake --preset fuzz >/dev/null
cmake --build --preset fuzz
targets="$*"
[ -n "$targets" ] || targets="$(ls tests/fuzz/seeds)"

[ ! -d /dev/shm ] || export TMPDIR=/dev/shm  # ten times as many units as on a disk

fuzz_one() {
    local target="$1" seconds="$2"
    local found="build-fuzz/found/$target" corpus="build-fuzz/corpus/$target"
    mkdir -p "$found" "$corpus"
    local unit_seconds="${HEXRELIEF_FUZZ_UNIT_SECONDS:-2}"
    [ "$target" != run ] || unit_seconds=$((unit_seconds * 5))  # all stages are some fifty times as slow with all these checks
    local options=(-max_total_time="$seconds" -seed="${HEXRELIEF_FUZZ_SEED:-0}" -timeout="$unit_seconds" -rss_limit_mb=2048
        -malloc_limit_mb=8192 -detect_leaks=1 -max_len=4096 -print_final_stats=1 -artifact_prefix="$found/")
    if HEXRELIEF_FUZZ_TARGET="$target" ASAN_OPTIONS=allocator_may_return_null=1:detect_leaks=1 \
        UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1 \
        build-fuzz/tests/fuzz/hexrelief_fuzz "${options[@]}" "$corpus" "tests/fuzz/seeds/$target" >"$found/log" 2>&1; then
        echo "$target: $(sed -n 's/^stat::number_of_executed_units: *//p' "$found/log") units in $seconds s, nothing found"
    else
        echo "$target: FOUND, see $found: $(grep -m 1 -E 'SUMMARY|no Error|more than a line' "$found/log")"
        return 1
    fi
}
export -f fuzz_one
printf '%s\n' $targets | xargs -P "${HEXRELIEF_FUZZ_JOBS:-2}" -I{} bash -c 'fuzz_one "$@"' - {} "$seconds"
