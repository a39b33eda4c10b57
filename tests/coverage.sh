#!/usr/bin/env bash
# coverage.sh: the share of each room's lines that the tests run, as a table. Builds the preset `coverage`
# and runs each test program once, and the few tests by ctest that run other programs of the build. Needs the package gcovr.
set -euo pipefail
cd "$(dirname "$0")/.."
if ! command -v gcovr >/dev/null; then
    echo "$0: gcovr is not there; install the package gcovr" >&2
    exit 77
fi
build=build-coverage
cmake --preset coverage >/dev/null
cmake --build --preset coverage
find $build -name '*.gcda' -delete  # of earlier runs, and of the build, which asks the programs for their tests
failed=0
programs=$(find $build/tests -name 'test_*' -type f -perm -u+x ! -name test_headers ! -name test_house ! -name test_fuzz_seeds)
for program in $(sort <<<"$programs"); do
    echo "--- $program"
    (cd "$(dirname "$program")" && "./$(basename "$program")" --gtest_brief=1) || failed=1
done
ctest --test-dir $build --output-on-failure -R '^(Fuzz.StoredSeeds|Python.Module|CommandLine.ShellsManualAndDemo)$' || failed=1
[[ $failed == 0 ]] || echo "NOTE: a test failed; the lines that it did run count all the same" >&2

# A room's files are those whose innermost folder with a README is the room's.
declare -A lines covered
while IFS=, read -r file total hit _; do
    [[ $file == */* ]] || continue
    room=$(dirname "$file")
    until [[ -e $room/README.md ]]; do room=$(dirname "$room"); done
    lines[$room]=$((${lines[$room]:-0} + total)) covered[$room]=$((${covered[$room]:-0} + hit))
    lines[all]=$((${lines[all]:-0} + total)) covered[all]=$((${covered[all]:-0} + hit))
done < <(gcovr --root . --filter '(exporters|mesher|pipeline)/' --csv -j "$(nproc)" $build | tail -n +2)
printf '| room | lines | run by tests |\n| --- | --- | --- |\n'
for room in $(printf '%s\n' "${!lines[@]}" | LC_ALL=C sort); do
    printf '| %s | %d | %d %% |\n' "$room" "${lines[$room]}" $((100 * ${covered[$room]} / ${lines[$room]}))
done
exit $failed
