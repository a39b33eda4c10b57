#!/usr/bin/env bash
# consumer.sh SOURCES BUILD: installs the library into an empty folder, moves that folder, builds a program of somebody else's
# against it, with the shared library and with the archive, and compares its mesh with the command line's.
set -euo pipefail
sources=$1
build=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for component in library development; do
    cmake --install "$build" --prefix "$work/installed" --component $component >/dev/null
done
mv "$work/installed" "$work/prefix"  # nothing may depend on where it was installed first
prefix=$work/prefix

headers=$(cd "$prefix/include" && find . -type f | sort | tr '\n' ' ')
[[ $headers == "./hexrelief/error.h ./hexrelief/hexrelief.h ./hexrelief/run.h ./hexrelief/version.h " ]] || {
    echo "FAIL other headers than the public ones: $headers"
    exit 1
}
if grep -hE '^#include' "$prefix"/include/hexrelief/*.h | grep -vE '<(hexrelief/[a-z]+\.h|[a-z]+)>'; then
    echo "FAIL public headers include more than the standard library's"
    exit 1
fi

samples=$sources/samples
"$build/hexrelief" run --disparity "$samples/disparity.pfm" --color "$samples/left.png" --calib "$samples/calib.txt" \
    --set mesh.spacing_px=8 --set density.background.fraction=0.1 -o "$work/expected.glb" --quiet
for kind in shared static; do
    cmake -S "$sources/tests/library/consumer" -B "$work/$kind" -G Ninja -DCMAKE_PREFIX_PATH="$prefix" -DKIND=$kind \
        -DCMAKE_BUILD_TYPE=Debug >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
    cmake --build "$work/$kind" >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
    "$work/$kind/consumer" "$samples" "$work/$kind.glb"
    cmp "$work/$kind.glb" "$work/expected.glb"
    "$work/$kind/consumer" "$samples" "$work/$kind-files.glb" files
    cmp "$work/$kind-files.glb" "$work/expected.glb"
    code=0
    "$work/$kind/consumer" "$work/missing" "$work/none.glb" 2>"$work/log" || code=$?
    [[ $code -eq 3 && $(wc -l <"$work/log") -eq 1 ]] || { echo "FAIL a missing file gave $code:"; cat "$work/log"; exit 1; }
done

if command -v pkg-config >/dev/null; then
    config=$(find "$prefix" -name pkgconfig)
    PKG_CONFIG_PATH=$config pkg-config --exists --print-errors 'hexrelief >= 0.1'
    libs=$(PKG_CONFIG_PATH=$config pkg-config --static --cflags --libs hexrelief)
    [[ $libs == *-lhexrelief*-lpng* && -f $(sed 's/^-I\([^ ]*\).*/\1/' <<<"$libs")/hexrelief/hexrelief.h ]] || {
        echo "FAIL pkg-config says: $libs"
        exit 1
    }
else
    echo "NOTE: no pkg-config here: its file is not tested"
fi
