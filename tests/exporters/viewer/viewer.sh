#!/bin/sh
# viewer.sh MODULES PROGRAM SAMPLES: viewer_test.mjs, or exit code 77 (ctest: skipped) where something for it is missing.
skip() {
    echo "SKIPPED: $1"
    exit 77
}
command -v node >/dev/null || skip "node is not there; install nodejs to look at pages in a browser"
command -v chromium >/dev/null || skip "chromium is not there; install it to look at pages in a browser"
[ -d "$1/playwright-core" ] || [ -d "$1/node_modules/playwright-core" ] ||
    skip "playwright-core is not there; tests/npm-install.sh installs it"
exec node "$(dirname "$0")/viewer_test.mjs" "$@"
