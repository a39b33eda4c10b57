#!/usr/bin/env bash
# format.sh ROOT: all C++ and CUDA sources are as clang-format 14, Debian 12's, writes them; other versions differ in details.
set -euo pipefail
cd "$1"
if ! clang-format --version 2>/dev/null | grep -q 'version 14\.'; then
    echo "no clang-format 14 here: skipped"
    exit 77
fi
find pipeline mesher cuda exporters samples tests -name node_modules -prune -o \
    \( -name '*.h' -o -name '*.cpp' -o -name '*.cu' -o -name '*.cuh' \) -print0 |
    xargs -0 -n 16 -P "$(nproc)" clang-format --dry-run -Werror
