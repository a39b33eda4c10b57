#!/usr/bin/env bash
# old_driver.sh PROGRAM LIBRARIES MAP: with a too old driver (the stand-in in LIBRARIES) --backend cuda exits 5 with one line that
# says so, and auto takes the CPU.
set -uo pipefail
program=$1
map=$3
export LD_LIBRARY_PATH=$2${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "FAIL $*"; cat "$work/err"; exit 1; }

"$program" run --disparity "$map" --backend cuda -o "$work/a.glb" --quiet >"$work/out" 2>"$work/err"
code=$?
[[ $code -eq 5 ]] || fail "exit code $code, not 5"
[[ $(wc -l <"$work/err") -eq 1 && ! -s $work/out ]] || fail "not one line"
grep -q 'driver is too old.*CUDA 11\.4.*--backend cpu' "$work/err" || fail "the line does not say which"
[[ ! -e $work/a.glb ]] || fail "a file was written"
"$program" devices | grep -q '^cuda .*too old.*not usable' || fail "devices does not say why"
"$program" run --disparity "$map" --backend auto -o "$work/a.glb" --report "$work/report.json" --quiet 2>"$work/err" || fail "auto"
grep -q '"backend": "cpu"' "$work/report.json" || fail "auto did not take the CPU"
