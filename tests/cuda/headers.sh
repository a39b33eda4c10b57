#!/usr/bin/env bash
# headers.sh ROOT COMPILER [CUDA-INCLUDES]: every header in cuda/ compiles with the host's C++ compiler alone. Those that the
# rest of the program includes do so without CUDA's own headers in reach; the others see those headers, but no nvcc.
# Exits 77 where CUDA's headers are not there, after the first kind.
set -uo pipefail
root=$1
compiler=$2
includes=${3:-}
public=(cuda_matcher.h cuda_mesher.h)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0

compiles() {  # FILE OPTIONS...
    local file=$1
    shift
    printf '#include "%s"\n#include "%s"\nint main() {}\n' "$file" "$file" >"$work/one.cpp"
    "$compiler" -std=c++20 -fsyntax-only -Wall -Wextra -Wpedantic -Wshadow -Werror -I"$root" "$@" "$work/one.cpp" 2>"$work/log"
}
expect() {
    compiles "$@" && return
    echo "FAIL $*"
    head -n 20 "$work/log"
    failed=1
}

# A header with kernel syntax must not pass, or the rest says nothing.
mkdir -p "$work/cuda"
echo '__global__ void kernel();' >"$work/cuda/bad.h"
if compiles cuda/bad.h -I"$work" ${includes:+-isystem "$includes"}; then
    echo "FAIL a header with kernel syntax passed"
    failed=1
fi

for header in "${public[@]}"; do
    expect "cuda/$header"
    if "$compiler" -std=c++20 -M -I"$root" ${includes:+-isystem "$includes"} "$root/cuda/$header" |
        grep -qE '/cuda(_runtime[a-z_]*)?\.h'; then
        echo "FAIL cuda/$header brings CUDA's headers with it"
        failed=1
    fi
done
[[ $failed -eq 0 ]] || exit 1
if [[ -z $includes ]]; then
    echo "NOTE: no CUDA headers here: only ${public[*]} were compiled; the rest is skipped"
    exit 77
fi
# Read once for all of them; StandardIncludes (tests/house) notices where a header lacks one of these.
printf '#include <%s>\n' algorithm cstdint cstring functional map memory mutex optional string thread vector >"$work/standard.h"
"$compiler" -std=c++20 -Wall -Wextra -Wpedantic -Wshadow -I"$root" -x c++-header "$work/standard.h" -o "$work/standard.h.gch"
count=0
while read -r header; do
    expect "$header" -isystem "$includes" -include "$work/standard.h"
    count=$((count + 1))
done < <(cd "$root" && find cuda -name "*.h" | sort)
echo "$count headers"
[[ $failed -eq 0 && $count -ge ${#public[@]} ]]
