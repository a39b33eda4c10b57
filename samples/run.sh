#!/usr/bin/env bash
# Installs what is missing, builds Release in build/, fetches a real stereo pair and turns it into meshes, twice: from the
# pair, and from its ground-truth disparities. The pair is Middlebury's Aloe, full size, out of Debian's package opencv-doc,
# which is unpacked, not installed; where that fails, the small rendered pair beside this script.
set -euo pipefail
cd "$(dirname "$0")/.."
tests/install-packages.sh
tests/build.sh build hexrelief

aloe=build/aloe
fetch_aloe() {
    [[ -f $aloe/aloeGT.png ]] && return 0
    rm -rf "$aloe.part"
    mkdir -p "$aloe.part/files"
    echo "Fetching Middlebury Aloe (Debian package opencv-doc, 96 MB)"
    # Machines made from images often come without apt's package lists.
    if ! apt-cache show opencv-doc >/dev/null 2>&1; then
        if [[ $(id -u) -eq 0 ]]; then apt-get -q update; else sudo apt-get -q update; fi >/dev/null 2>&1 || true
    fi
    (
        cd "$aloe.part"
        # As root apt-get warns that its own user may not write here, which is of no matter.
        apt-get -q download opencv-doc 2>apt.log >&2 || { grep -v '^W:' apt.log >&2; exit 1; }
        dpkg-deb --fsys-tarfile opencv-doc_*.deb | tar -x -C files --wildcards --strip-components=7 \
            './usr/share/doc/opencv-doc/examples/data/aloe*'
    ) || return 1
    [[ -f $aloe.part/files/aloeL.jpg && -f $aloe.part/files/aloeR.jpg && -f $aloe.part/files/aloeGT.png ]] || return 1
    rm -rf "$aloe"
    mv "$aloe.part/files" "$aloe"
    rm -rf "$aloe.part"
}

if fetch_aloe; then
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
