#!/usr/bin/env bash
# Installs what is missing, builds Release in build/ and runs all tests. A second call builds only what changed.
# HEXRELIEF_DATA=DIR adds the tests on Middlebury's maps, which are not part of this repository.
set -euo pipefail
cd "$(dirname "$0")/.."
tests/install-packages.sh tests
tests/build.sh build
# Where the registry cannot be reached npm goes on trying for many minutes.
timeout 120 tests/npm-install.sh build || echo "NOTE: the tests that need node modules will be skipped"
ctest --test-dir build --no-tests=error --output-on-failure --parallel "$(($(nproc) + 1))"
