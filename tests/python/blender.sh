#!/usr/bin/env bash
# blender.sh PYTHON SOURCES BUILD: samples/blender renders the sample's mesh as the left camera saw it, which must be the
# photograph. Exits 77 without Blender, or where its Python is not the module's.
set -euo pipefail
python=$1 sources=$2
export PYTHONPATH=$3/python PYTHONDONTWRITEBYTECODE=1
command -v blender >/dev/null || { echo "NOTE: no blender here: samples/blender is not tested"; exit 77; }
blender -b --python-use-system-env --python-exit-code 1 --python-expr 'import hexrelief' >/dev/null 2>&1 || {
    echo "NOTE: blender's Python does not take this module or has no numpy: samples/blender is not tested"
    exit 77
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
blender -b --python-use-system-env --python-exit-code 1 -P "$sources/samples/blender/mesh_in_blender.py" -- \
    "$work/relief.png" "$work/relief.blend" >"$work/log" 2>&1 || { tail -20 "$work/log"; exit 1; }
[[ -s $work/relief.blend ]]
"$python" - "$work/relief.png" "$sources/samples/left.png" <<'END'
import sys
import hexrelief
import numpy as np
rendered, photograph = (hexrelief.read_picture(path).astype(int) for path in sys.argv[1:])
covered = rendered.max(axis=2) > 0
difference = np.abs(rendered - photograph)[covered].mean()
print(f"{100 * covered.mean():.1f} % of the picture is covered; mean difference to it {difference:.2f} of 255")
assert covered.mean() > 0.6 and difference < 5
END
