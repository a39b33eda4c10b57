#!/bin/sh
# validate.sh MODULES SCENES: validate.mjs, or exit code 77 (ctest: skipped) where node is missing.
if ! command -v node >/dev/null; then
    echo "SKIPPED: node is not there; install nodejs to run Khronos' validator"
    exit 77
fi
exec node "$(dirname "$0")/validate.mjs" "$@"
