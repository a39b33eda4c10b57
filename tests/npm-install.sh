#!/bin/sh
# npm-install.sh BUILD_DIR: installs the node modules of the exporters' tests into BUILD_DIR/npm; quick when they are there.
# Without them those tests are skipped, so a failure here is one line, not the end of a test run.
set -eu
if [ $# -ne 1 ]; then
    echo "usage: $0 BUILD_DIR" >&2
    exit 2
fi
source_dir=$(cd "$(dirname "$0")" && pwd)/exporters
target=$1/npm
if cmp -s "$source_dir/package.json" "$target/package.json" && [ -f "$target/.installed" ]; then
    exit 0
fi
if ! command -v npm >/dev/null; then
    echo "npm-install.sh: npm is not there; install npm to run Khronos' validator in the tests" >&2
    exit 1
fi
mkdir -p "$target"
rm -f "$target/.installed"
cp "$source_dir/package.json" "$target/package.json"
(cd "$target" && npm install --no-audit --no-fund --silent --no-package-lock >npm.log 2>&1) || {
    echo "npm-install.sh: npm install failed, see $target/npm.log" >&2
    exit 1
}
touch "$target/.installed"
