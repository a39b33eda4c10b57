#!/usr/bin/env bash
# tidy.sh SOURCES [PATTERN]: clang-tidy 14 over the C++ sources, by .clang-tidy; silent where all is well. PATTERN chooses rooms,
# such as '^pipeline/batch'. The preset `dev`, configured for clang, says how each source is compiled. Kernels (.cu) are left out,
# for clang 14 knows no CUDA of today; HEXRELIEF_CUDA=ON adds cuda/*.cpp.
set -euo pipefail
sources=$(realpath "$1") pattern=${2:-.}
for program in clang-tidy clang++; do
    command -v $program >/dev/null || { echo "NOTE: no $program here: nothing is checked"; exit 77; }
done
export build=${HEXRELIEF_TIDY_BUILD:-$sources/build-tidy}
(cd "$sources" && cmake --preset dev -B "$build" -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=Release \
    "-DHEXRELIEF_CUDA=${HEXRELIEF_CUDA:-OFF}" >/dev/null)

tidy() {
    local said
    said=$(clang-tidy --quiet -p "$build" "$1" 2>&1) || { grep -vE '^[0-9]+ warnings? ' <<<"$said"; return 1; }
}
export -f tidy
mapfile -t files < <(sed -n 's/^  "file": "\(.*\.cpp\)".*/\1/p' "$build/compile_commands.json" | sort -u |
    while read -r file; do
        [[ $file == "$build"/* || ! ${file#"$sources"/} =~ $pattern ]] || echo "$file"
    done)
[[ ${#files[@]} -gt 0 ]] || { echo "no source of a build is in '$pattern'"; exit 1; }
printf '%s\0' "${files[@]}" | nice xargs -0 -n 1 -P "${HEXRELIEF_TIDY_JOBS:-$(nproc)}" bash -c 'tidy "$1"' -
