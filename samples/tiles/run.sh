#!/usr/bin/env bash
# run.sh [PROGRAM]: a made-up map of 4096 x 4096 px in tiles, as 3D Tiles on a page, into out/tiles/. Where there is a screen, the
# page is opened and served until Ctrl-C; elsewhere headless Chromium takes a picture of it. Without PROGRAM installs what is
# missing and builds it in build/. The map needs
# python3 with numpy; the page needs npm, and python3 as its web server.
set -euo pipefail
cd "$(dirname "$0")/../.."
program=${1:-build/hexrelief}
if [[ $# -eq 0 ]]; then
    tests/install-packages.sh
    tests/build.sh build hexrelief
fi
out=out/tiles viewer=samples/tiles/viewer
mkdir -p "$out"

[[ -f $out/map.pfm ]] || samples/tiles/make_map.py 4096x4096 "$out/map.pfm"
# A camera so high above that hills and houses are as high as they are wide; the walls of houses are closed.
"$program" tiles plan "$out/map.pfm" -o "$out/relief" --tile-vertices 128 --set export.compression=draco \
    --set input.calibration.focal_px=4096 --set input.calibration.baseline_m=0.5 \
    --set input.calibration.doffs_px=2048 --set surface.discontinuities=bridge
"$program" tiles solve "$out/relief"
"$program" tiles merge "$out/relief" -o "$out/relief/tileset.json"

for tool in npm python3; do
    command -v $tool >/dev/null || { echo "NOTE: no $tool here: no page"; exit 0; }
done
[[ -d $viewer/node_modules ]] || npm --prefix "$viewer" ci --silent --no-audit --no-fund
npm --prefix "$viewer" run --silent build
cp -r "$viewer/build/." "$out/"

address_file=$(mktemp)
trap 'kill "$server" 2>/dev/null || true; rm -f "$address_file"' EXIT
python3 -u -m http.server --bind 127.0.0.1 --directory "$out" 0 >"$address_file" 2>/dev/null &
server=$!
until [[ -s $address_file ]] || ! kill -0 "$server" 2>/dev/null; do sleep 0.1; done
port=$(sed -n 's/.* port \([0-9]*\) .*/\1/p' "$address_file")
page="http://127.0.0.1:$port/index.html?tileset=relief/tileset.json&error_px=0.5"
if [[ -n ${DISPLAY:-}${WAYLAND_DISPLAY:-} ]] && command -v xdg-open >/dev/null; then
    echo "$page (Ctrl-C ends it)"
    xdg-open "$page"
    wait "$server"
else
    code=0
    node "$viewer/picture.mjs" "$viewer/node_modules" "$page" "$out/page.png" || code=$?
    [[ $code == 0 || $code == 77 ]] || exit "$code"
fi
