#!/usr/bin/env bash
# Unpacks photographs out of Debian's package opencv-doc (96 MB) into a folder, without installing it: Middlebury's Aloe with its
# truth, a pair of two cameras side by side that nobody rectified (left06, right06), and two frames of one camera (basketball).
#     samples/fetch_photos.sh FOLDER
set -euo pipefail
folder=${1:?usage: samples/fetch_photos.sh FOLDER}
wanted=(aloeGT.png aloeL.jpg aloeR.jpg basketball1.png basketball2.png left06.jpg right06.jpg)
has_all() {
    local name
    for name in "${wanted[@]}"; do [[ -f $1/$name ]] || return 1; done
}
if has_all "$folder"; then exit 0; fi
rm -rf "$folder.part"
mkdir -p "$folder.part/files"
echo "Fetching photographs (Debian package opencv-doc, 96 MB)"
# Machines made from images often come without apt's package lists.
if ! apt-cache show opencv-doc >/dev/null 2>&1; then
    if [[ $(id -u) -eq 0 ]]; then apt-get -q update; else sudo apt-get -q update; fi >/dev/null 2>&1 || true
fi
(
    cd "$folder.part"
    # As root apt-get warns that its own user may not write here, which is of no matter.
    apt-get -q download opencv-doc 2>apt.log >&2 || { grep -v '^W:' apt.log >&2; exit 1; }
    dpkg-deb --fsys-tarfile opencv-doc_*.deb | tar -x -C files --strip-components=7 \
        "${wanted[@]/#/./usr/share/doc/opencv-doc/examples/data/}"
)
has_all "$folder.part/files"
rm -rf "$folder"
mv "$folder.part/files" "$folder"
rm -rf "$folder.part"
