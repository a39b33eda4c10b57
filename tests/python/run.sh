#!/usr/bin/env bash
# run.sh PYTHON SOURCES BUILD: the module's tests. Exits 77 where that Python has no numpy or no pytest.
set -euo pipefail
python=$1
export HEXRELIEF_SOURCES=$2 HEXRELIEF_BUILD=$3 PYTHONPATH=$3/python PYTHONDONTWRITEBYTECODE=1
"$python" -c 'import numpy, pytest' 2>/dev/null || {
    echo "NOTE: python3-numpy or python3-pytest is missing: the Python module is not tested"
    exit 77
}
"$python" -m pytest -q -rs -p no:cacheprovider "$HEXRELIEF_SOURCES/tests/python"
