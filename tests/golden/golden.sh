#!/usr/bin/env bash
# golden.sh PYTHON PROGRAM OPTIONS...: golden.py on the samples, with HEXRELIEF_DATA on the maps and pairs there as well.
set -euo pipefail
python=$1
shift
exec "$python" "$(dirname "$0")/golden.py" "$@" ${HEXRELIEF_DATA:+--data "$HEXRELIEF_DATA"}
