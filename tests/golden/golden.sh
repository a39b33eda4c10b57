#!/usr/bin/env bash
# golden.sh PYTHON PROGRAM: golden.py on the samples, with HEXRELIEF_DATA on the maps and pairs there as well.
set -euo pipefail
exec "$1" "$(dirname "$0")/golden.py" "$2" ${HEXRELIEF_DATA:+--data "$HEXRELIEF_DATA"}
