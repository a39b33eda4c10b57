#!/usr/bin/env bash
# build.sh FOLDER [TARGET...]: configures the Release build in FOLDER where that was not done yet, and builds the targets
# (all, if none are named). Uses ccache where it is installed, CUDA where nvcc is.
set -euo pipefail
source_dir=$(cd "$(dirname "$0")/.." && pwd)
folder=$1
shift

# CMake looks for nvcc only in the search path; NVIDIA's packages install it outside.
if [[ -z ${CUDACXX:-} ]] && ! command -v nvcc >/dev/null && [[ -x /usr/local/cuda/bin/nvcc ]]; then
    export CUDACXX=/usr/local/cuda/bin/nvcc
fi
options=()
if command -v ccache >/dev/null; then
    options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache -DCMAKE_CUDA_COMPILER_LAUNCHER=ccache)
fi
cmake -S "$source_dir" -B "$folder" -G Ninja "${options[@]}"
if ! grep -Eq '^CMAKE_CUDA_COMPILER:[^=]*=/' "$folder/CMakeCache.txt"; then
    echo "NOTE: no nvcc here: this build leaves the CUDA backend out"
fi
targets=()
for target in "$@"; do targets+=(--target "$target"); done
cmake --build "$folder" "${targets[@]}"
