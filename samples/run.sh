#!/usr/bin/env bash
# Installs what is missing, builds Release in build/, fetches a real stereo pair and turns it into meshes, twice: from the
# pair, and from its ground-truth disparities. The pair is Middlebury's Aloe, full size, out of Debian's package opencv-doc,
# which is unpacked, not installed; where that fails, the small rendered pair beside this script.
set -euo pipefail
cd "$(dirname "$0")/.."
tests/install-packages.sh
tests/build.sh build hexrelief

aloe=build/aloe
if samples/fetch_photos.sh "$aloe"; then
    left=$aloe/aloeL.jpg
    pair=(--left "$left" --right $aloe/aloeR.jpg --config config/aloe.yaml)
    truth=(--disparity $aloe/aloeGT.png --color "$left" --config config/aloe.yaml)
else
    echo "Aloe cannot be had here: using the small rendered pair in samples/ instead"
    left=samples/left.png
    pair=(--left "$left" --right samples/right.png --calib samples/calib.txt)
    truth=(--disparity samples/disparity.pfm --color "$left" --calib samples/calib.txt)
fi

# A build without node.js or npm has no page to write.
page=
[[ ! -f build/exporters/viewer/page.html ]] || page=relief.html

# Whether a .glb is compressed is a setting, so the compressed one takes a run of its own.
relief() {
    local folder=$1
    shift
    mkdir -p "$folder"
    build/hexrelief run "$@" -o "$folder/relief.glb" -o "$folder/relief.obj" ${page:+-o "$folder/$page"} \
        --report "$folder/report.json" --save-stages "$folder/stages"
    build/hexrelief run "$@" -o "$folder/relief-draco.glb" --set export.compression=draco --quiet
}
relief out/pair "${pair[@]}"
relief out/ground-truth "${truth[@]}"
cmake --build build --target render_pair >/dev/null
samples/photos/mesh_photos.sh build out/photos

echo "Meshes to look at: out/pair/relief.glb, from the pair, and out/ground-truth/relief.glb, from known disparities"
[[ -z $page ]] || echo "Turn them in a browser: out/pair/relief.html, out/ground-truth/relief.html"
echo "Beside them: relief-draco.glb (compressed), relief.obj with .mtl and texture, report.json (what was done)"
echo "Pictures of each step: out/pair/stages/ and out/ground-truth/stages/, mesh2d.png and relief.png first"
