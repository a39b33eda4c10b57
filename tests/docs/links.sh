#!/usr/bin/env bash
# links.sh ROOT: runs links.py on ROOT, and on a folder with a dead link of each kind, which it must refuse. Exits 77 without
# python3.
set -uo pipefail
root=$1
here=$(cd "$(dirname "$0")" && pwd)
command -v python3 >/dev/null || { echo "NOTE: no python3 here: skipped"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/room"
echo 'x' >"$work/room/there.h"
refused() {  # refused TEXT: a page with a title and this text is refused
    printf '# a title\n%s\n' "$1" >"$work/README.md"
    refuse_page "$1"
}
refuse_page() {
    if python3 "$here/links.py" "$work" >/dev/null; then
        echo "FAIL this was let through: $1"
        exit 1
    fi
}
refused '[a page](room/missing.md)'
refused '![a picture](missing.png)'
refused '[a heading](#nowhere)'
refused 'see `room/missing.h`'
refused 'see `missing.h`'
refused "$(printf 'x%.0s' {1..133})"
refused "$(seq 151)"
touch "$work/room/CMakeLists.txt"
refused 'a room without a page'
rm "$work/room/CMakeLists.txt"
mkdir -p "$work/pipeline/inner/innermost"
page() { printf '# a title\n%s\n' "$2" >"$work/$1"; }
page pipeline/README.md '[inner](inner/README.md)'
page pipeline/inner/innermost/README.md 'no rooms here'
page ARCHITECTURE.md '[pipeline](pipeline/README.md) [inner](pipeline/inner/README.md)'
page pipeline/inner/README.md 'no rooms here'
refused 'a room that the page of the one around it does not list'
page pipeline/inner/README.md '[innermost](innermost/README.md)'
page ARCHITECTURE.md '[pipeline](pipeline/README.md)'
refused 'a room that ARCHITECTURE.md does not list'
page ARCHITECTURE.md '[pipeline](pipeline/README.md) [inner](pipeline/inner/README.md)'
echo 'a page without a title' >"$work/README.md"
refuse_page 'a page without a title'
printf '# a title\n%s\n' 'see `room/there.h`, [it](room/there.h) and [the web](https://example.org/missing)' >"$work/README.md"
python3 "$here/links.py" "$work" || { echo "FAIL a sound page was refused"; exit 1; }
python3 "$here/links.py" "$root"
