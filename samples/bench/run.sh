#!/bin/sh
# run.sh BENCHMARK [OPTIONS]: table2, rd, match, faults, sparse or batch, by the Python module of the build folder
# HEXRELIEF_BUILD (build).
set -eu
here=$(cd "$(dirname "$0")" && pwd)
build=${HEXRELIEF_BUILD:-$here/../../build}
benchmark=${1:?name a benchmark: table2, rd, match, faults, sparse, batch}
shift
if [ ! -d "$build/python/hexrelief" ]; then
    echo "run.sh: no Python module in $build/python; build it first (tests/build.sh build), or set HEXRELIEF_BUILD" >&2
    exit 3
fi
HEXRELIEF_BUILD=$build PYTHONPATH=$build/python exec /usr/bin/python3 "$here/$benchmark.py" "$@"
