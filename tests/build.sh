#!/usr/bin/env bash
# build.sh FOLDER [TARGET...]: configures the Release build in FOLDER where that was not done yet, and builds the targets
# (all, if none are named). Uses ccache where it is installed. Builds the CUDA backend where there are nvcc and a GPU, for
# that GPU; CUDAARCHS (such as 90-real) names the architectures instead, and needs no GPU.
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
    export CCACHE_SLOPPINESS=pch_defines,time_macros  # what ccache needs to know precompiled headers
    options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache -DCMAKE_CUDA_COMPILER_LAUNCHER=ccache)
fi
architectures=${CUDAARCHS:-}
if [[ -z $architectures ]] && nvidia-smi -L >/dev/null 2>&1; then architectures=native; fi
if [[ -n $architectures ]]; then
    options+=(-DHEXRELIEF_CUDA=AUTO "-DCMAKE_CUDA_ARCHITECTURES=$architectures")
else
    options+=(-DHEXRELIEF_CUDA=OFF)
fi
cmake -S "$source_dir" -B "$folder" -G Ninja "${options[@]}"
if [[ -z $architectures ]]; then
    echo "NOTE: no GPU here: this build leaves the CUDA backend out (CUDAARCHS=90-real builds it all the same)"
elif ! grep -Eq '^CMAKE_CUDA_COMPILER:[^=]*=/' "$folder/CMakeCache.txt"; then
    echo "NOTE: no nvcc here: this build leaves the CUDA backend out"
fi
targets=()
for target in "$@"; do targets+=(--target "$target"); done
cmake --build "$folder" "${targets[@]}"
