#!/usr/bin/env bash
# reproducible.sh SOURCES: builds the packages in two folders, whose names differ in length; they must be the same to the byte, and
# lintian must find no error in them. It builds the program twice: .ci/nightly runs it, ctest does not.
set -euo pipefail
sources=$(realpath "$1")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
SOURCE_DATE_EPOCH=$(git -C "$sources" log -1 --format=%ct)
export SOURCE_DATE_EPOCH
for build in "$work/one" "$work/another/folder"; do
    cmake -S "$sources" -B "$build" -G Ninja -DHEXRELIEF_TESTS=OFF -DHEXRELIEF_CUDA=OFF -DHEXRELIEF_BUILD_FOLDER= >/dev/null
    cmake --build "$build" >/dev/null
    (cd "$build" && cpack -G DEB >/dev/null)
done
for deb in "$work"/one/*.deb; do
    cmp "$deb" "$work/another/folder/${deb##*/}" || { echo "FAIL ${deb##*/} depends on where it was built"; exit 1; }
    sha256sum "$deb" | sed "s#$work/one/##"
done
lintian --fail-on error --tag-display-limit 0 "$work"/one/*.deb
