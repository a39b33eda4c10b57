#!/usr/bin/env bash
# Renders the sample scene as two photographs by hand, and meshes them without any calibration.
#     samples/photos/mesh_photos.sh [BUILD] [OUT]
set -euo pipefail
build=${1:-build}
out=${2:-out/photos}
mkdir -p "$out"
"$build/samples/render_pair" --photographs "$out"
"$build/hexrelief" run --left "$out/left.png" --right "$out/right.png" -o "$out/relief.glb" --report "$out/report.json"
