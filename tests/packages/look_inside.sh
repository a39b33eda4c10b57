#!/usr/bin/env bash
# look_inside.sh SOURCES BUILD: makes the packages and looks into them; the tarball's program runs from another folder.
# Exits 77 where dpkg's tools are missing.
set -euo pipefail
sources=$1 build=$2
for tool in cpack dpkg-deb dpkg-shlibdeps; do
    command -v $tool >/dev/null || { echo "NOTE: no $tool here (dpkg-dev): packages are not tested"; exit 77; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "FAIL $*"; exit 1; }

cpack --config "$build/CPackConfig.cmake" -G 'DEB;TGZ' -B "$work" -D CPACK_DEBIAN_COMPRESSION_TYPE=gzip >"$work/log" 2>&1 ||
    { cat "$work/log"; exit 1; }
version=$(sed -n 's/^project(hexrelief VERSION \([0-9]*\.[0-9]*\).*/\1/p' "$sources/CMakeLists.txt")
expected="hexrelief libhexrelief-dev libhexrelief$version"
! ls "$build"/python/hexrelief/_core*.so >/dev/null 2>&1 || expected+=" python3-hexrelief"
! ls "$build"/hexrelief-heif.so >/dev/null 2>&1 || expected+=" hexrelief-heif"
! ls "$build"/hexrelief-onnx >/dev/null 2>&1 || expected+=" hexrelief-onnx"
for name in $expected; do
    deb=$(echo "$work/$name"_*.deb)
    [[ -f $deb ]] || fail "no package $name: $(ls "$work")"
    field() { dpkg-deb -f "$deb" "$1"; }
    files=$(dpkg-deb -c "$deb" | awk '{print $6}')
    holds() { grep -q "^\./usr/$1" <<<"$files" || fail "$name does not hold $1: $files"; }
    [[ $(field Maintainer) == *@* && -n $(field Description) ]] || fail "$name: maintainer, description"
    holds "share/doc/$name/copyright" && holds "share/doc/$name/changelog.gz"
    case $name in
    hexrelief)
        for file in bin/hexrelief share/man/man1/hexrelief-run.1 share/bash-completion/completions/hexrelief \
            share/zsh/vendor-completions/_hexrelief share/fish/vendor_completions.d/hexrelief.fish \
            share/doc/hexrelief/hexrelief.spdx.json; do holds $file; done
        [[ $(field Depends) == *libopencv-calib3d* && $(field Depends) != *contrib* ]] || fail "depends: $(field Depends)"
        ;;
    libhexrelief0*) holds "lib/.*libhexrelief.so.$version" ;;
    libhexrelief-dev)
        holds include/hexrelief/hexrelief.h && holds '.*/libhexrelief.a' && holds '.*/hexreliefConfig.cmake'
        [[ $(field Depends) == *libhexrelief$version\ \(=* ]] || fail "depends: $(field Depends)"
        ;;
    python3-hexrelief)
        holds lib/python3/dist-packages/hexrelief/__init__.py && holds 'lib/python3/dist-packages/hexrelief/_core'
        [[ $(field Depends) == *python3-numpy* ]] || fail "depends: $(field Depends)"
        ;;
    hexrelief-heif) holds lib/hexrelief/hexrelief-heif.so ;;
    hexrelief-onnx) holds lib/hexrelief/hexrelief-onnx ;;
    esac
    if grep -vE '^\./(usr/((bin|lib|include|share)/.*)?)?$' <<<"$files"; then fail "$name holds files elsewhere"; fi
done

# What was linked: the libraries that dpkg-shlibdeps sees stand in the list, and so does what pages hold.
dpkg-deb --fsys-tarfile "$work"/hexrelief_*.deb | tar -xO ./usr/share/doc/hexrelief/hexrelief.spdx.json >"$work/spdx.json"
for package in $(dpkg-deb -f "$work"/hexrelief_*.deb Depends | sed 's/([^)]*)//g; s/,/ /g') three meshoptimizer; do
    grep -qF "\"name\": \"$package\"" "$work/spdx.json" || fail "hexrelief.spdx.json does not name $package"
done

mkdir "$work/elsewhere"
tar -xzf "$work"/hexrelief-*.tar.gz -C "$work/elsewhere" --strip-components=1
"$work/elsewhere/bin/hexrelief" run --disparity "$sources/samples/disparity.pfm" --calib "$sources/samples/calib.txt" \
    --color "$sources/samples/left.png" -o "$work/tarball.glb" --quiet
"$build/hexrelief" run --disparity "$sources/samples/disparity.pfm" --calib "$sources/samples/calib.txt" \
    --color "$sources/samples/left.png" -o "$work/build.glb" --quiet
cmp "$work/tarball.glb" "$work/build.glb"
