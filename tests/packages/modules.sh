#!/usr/bin/env bash
# modules.sh SOURCES BUILD: a program that was copied somewhere runs no library that lies around it; an installed one opens its own.
# Exits 77 where the build has no module.
set -euo pipefail
sources=$(realpath "$1") build=$(realpath "$2")
[[ -f $build/hexrelief-heif.so ]] || { echo "NOTE: no hexrelief-heif.so in this build: nothing to test"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "FAIL $*"; exit 1; }
pair=(run --stereo "$sources/samples/inputs/spatial.heic" --quiet)

mkdir -p "$work"/tree/{a/b,lib/hexrelief,hexrelief}
printf '__attribute__((constructor)) static void ran(void) { __builtin_trap(); }\n' >"$work/other.c"
cc -shared -fPIC -o "$work/other.so" "$work/other.c"
for place in . a a/b lib lib/hexrelief hexrelief; do cp "$work/other.so" "$work/tree/$place/hexrelief-heif.so"; done
for place in . a a/b; do
    cp "$build/hexrelief" "$work/tree/$place/program"
    code=0
    (cd "$work/tree" && LD_LIBRARY_PATH= "./$place/program" "${pair[@]}" -o "$work/a.ply") 2>"$work/log" || code=$?
    [[ $code -eq 3 && $(<"$work/log") == *"is in none"* ]] || fail "in $place the program gave $code: $(<"$work/log")"
done

for component in program heif library; do
    cmake --install "$build" --prefix "$work/installed" --component $component >/dev/null
done
mv "$work/installed" "$work/prefix"
"$work/prefix/bin/hexrelief" "${pair[@]}" -o "$work/installed.ply"
ln -s "$work/prefix/bin/hexrelief" "$work/link"
"$work/link" "${pair[@]}" -o "$work/link.ply"
"$build/hexrelief" "${pair[@]}" -o "$work/build.ply"
cmp "$work/installed.ply" "$work/build.ply"
cmp "$work/link.ply" "$work/build.ply"

[[ -x $build/hexrelief-onnx ]] || exit 0
cmake --install "$build" --prefix "$work/prefix" --component onnx >/dev/null
echo rubbish >"$work/model.onnx"
network=(run --left "$sources/samples/left.png" --right "$sources/samples/right.png" --quiet -o "$work/network.ply"
    --set disparity.method=onnx --set "disparity.model=$work/model.onnx")
for place in "$work/prefix/bin/hexrelief:it is no ONNX file" "$work/tree/program:is in none"; do
    code=0
    "${place%%:*}" "${network[@]}" 2>"$work/log" || code=$?
    [[ $code -eq 3 && $(<"$work/log") == *"${place#*:}"* ]] || fail "${place%%:*} gave $code: $(<"$work/log")"
done
