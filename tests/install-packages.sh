#!/usr/bin/env bash
# install-packages.sh [tests|nightly|print]: the Debian 12 packages that the build needs; with `tests` also what the tests read
# results back with, with `nightly` also clang-tidy, lintian and others. Needs root or sudo only where something is missing; touches
# nothing otherwise. `print` names the packages.
set -euo pipefail

packages=(
    g++ cmake ninja-build
    libopencv-calib3d-dev  # SGBM
    libopenmesh-dev libdraco-dev libtinygltf-dev nlohmann-json3-dev
    libyaml-cpp-dev libcli11-dev nettle-dev
    libpng-dev libjpeg-dev libtiff-dev libwebp-dev liblcms2-dev libexif-dev zlib1g-dev
    libopenexr-dev  # optional: EXR maps
    libheif-dev  # optional: HEIC photographs and their depths
    libopencv-dnn-dev  # optional: networks as matchers (disparity.method=onnx)
    libmeshoptimizer-dev  # EXT_meshopt_compression; its simplification in samples/bench
    libgtest-dev
    python3-dev pybind11-dev  # optional: the Python module
)
# Pages (.html). By program, not by package: node from elsewhere brings its own npm, which Debian's package of that name
# conflicts with.
command -v node >/dev/null || packages+=(nodejs)
command -v npm >/dev/null || packages+=(npm)
if [[ ${1:-} == tests || ${1:-} == nightly ]]; then
    packages+=(draco ca-certificates clang-format libheif-examples python3-matplotlib python3-numpy python3-opencv)
    packages+=(python3-onnx python3-pytest)
    packages+=(chromium)  # in which the pages are looked at
    [[ -z ${HEXRELIEF_FUZZ_SECONDS:-} ]] || packages+=(clang)  # libFuzzer, which tests/fuzz asks for
    [[ $1 == tests ]] || packages+=(clang clang-tidy g++-aarch64-linux-gnu lintian mmdebstrap pandoc python3-venv qemu-user)
elif [[ ${1:-} == print ]]; then
    printf '%s\n' "${packages[@]}"
    exit 0
elif [[ $# -gt 0 ]]; then
    echo "usage: $0 [tests|nightly|print]" >&2
    exit 2
fi

missing=()
for package in "${packages[@]}"; do
    state=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
    [[ $state == installed ]] || missing+=("$package")
done
[[ ${#missing[@]} -gt 0 ]] || exit 0

as_root=()
if [[ $(id -u) -ne 0 ]]; then
    if ! command -v sudo >/dev/null; then
        echo "$0: neither root nor sudo here; have these Debian packages installed: ${missing[*]}" >&2
        exit 1
    fi
    as_root=(sudo)
fi
echo "Installing ${#missing[@]} packages: ${missing[*]}"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
quietly() {
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -y -q "$@" >"$log" 2>&1 </dev/null || {
        cat "$log" >&2
        echo "$0: apt-get $1 failed" >&2
        exit 1
    }
}
quietly update
quietly install --no-install-recommends "${missing[@]}"
