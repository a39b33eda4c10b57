#!/usr/bin/env bash
# bundle.sh BUILD FOLDER: the program, its CUDA tests and benchmark, and their shared libraries in one folder, to be carried to
# a machine with a GPU that has neither compiler nor packages; there: `FOLDER/run.sh FOLDER`.
set -euo pipefail
build=$1
folder=$2
mkdir -p "$folder/lib"
cp "$build/hexrelief" "$build/tests/cuda/test_cuda" "$build/tests/cuda/"bench_{matching,paper} "$(dirname "$0")/run.sh" "$folder/"
# the loader and the C library are the machine's own
ldd "$folder/hexrelief" "$folder/test_cuda" | awk '$2 == "=>" && $3 ~ /^\// { print $3 }' | sort -u |
    grep -Ev '/(ld-linux|libc|libm|libpthread|libdl|librt|libgcc_s|libstdc\+\+)[-.]' | xargs cp -Lt "$folder/lib"
strip "$folder"/lib/*.so* "$folder/hexrelief" "$folder/test_cuda" "$folder/"bench_{matching,paper} 2>/dev/null || true
du -sh "$folder"
