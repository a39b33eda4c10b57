#!/usr/bin/env bash
# run.sh SYSROOT BUILD [golden.py's options]: makes an arm64 Debian 12 in SYSROOT unless it is there, cross-compiles the program
# into BUILD without CUDA, and compares what it writes under qemu with the sums of tests/golden, which are x86-64's. Needs root or
# user namespaces for mmdebstrap; JOBS (2) compilers at a time.
set -euo pipefail
[[ $# -ge 2 ]] || { sed -n 2,4p "$0" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1" "$2"
sysroot=$(realpath "$1") build=$(realpath "$2")
shift 2
for tool in mmdebstrap qemu-aarch64 aarch64-linux-gnu-g++; do
    command -v $tool >/dev/null || { echo "SKIPPED: $tool is missing; see tests/arm64/README.md"; exit 77; }
done

if [[ ! -e $sysroot/complete ]]; then
    packages=$("$here/../install-packages.sh" print | grep -e '-dev$' | grep -v ^py | paste -sd,)
    mmdebstrap --quiet --architectures=arm64 --variant=extract --include="libc6-dev,libstdc++-12-dev,$packages" bookworm "$sysroot"
    # Unpacked packages are not configured: alternatives are missing, and links and Draco's CMake files say /usr.
    libraries=$sysroot/usr/lib/aarch64-linux-gnu
    ln -s blas/libblas.so.3 lapack/liblapack.so.3 "$libraries"
    find "$libraries" -lname '/*' -printf '%p %l\n' | while read -r link target; do ln -sf "$sysroot$target" "$link"; done
    sed -i "s|\"/usr|\"$sysroot/usr|" "$libraries"/cmake/draco/*.cmake
    touch "$sysroot/complete"
fi
export HEXRELIEF_SYSROOT=$sysroot
cmake -S "$here/../.." -B "$build" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$here/toolchain.cmake" -DCMAKE_BUILD_TYPE=Release \
    -DHEXRELIEF_CUDA=OFF -DHEXRELIEF_TESTS=OFF >"$build/configure.log"
cmake --build "$build" -j "${JOBS:-2}" --target hexrelief

printf '#!/bin/sh\nexec qemu-aarch64 -L "%s" "%s/hexrelief" "$@"\n' "$sysroot" "$build" >"$build/under-qemu"
chmod +x "$build/under-qemu"
python3 "$here/../golden/golden.py" "$build/under-qemu" "$@"
