#!/usr/bin/env bash
# run.sh for ctest: HEXRELIEF_FUZZ_SECONDS for each target; 77 (skipped) where that is not set.
set -euo pipefail
if [ -z "${HEXRELIEF_FUZZ_SECONDS:-}" ]; then
    echo "nothing is fuzzed: set HEXRELIEF_FUZZ_SECONDS"
    exit 77
fi
exec "$(dirname "$0")/run.sh" "$HEXRELIEF_FUZZ_SECONDS"
