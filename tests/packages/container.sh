#!/usr/bin/env bash
# container.sh SOURCES [build]: the Containerfile names what there is. With `build` it is built as well, by podman or buildah,
# and the sample is run in it.
set -euo pipefail
cd "$1"
file=samples/container/Containerfile
fail() { echo "FAIL $file: $*"; exit 1; }
grep -vE '^(#.*|FROM .*|COPY .*|RUN .*|WORKDIR .*|ENTRYPOINT .*|CMD .*|    .*|)$' "$file" && fail "unknown instructions"
while read -r image; do [[ $image == docker.io/library/debian:bookworm* ]] || fail "not Debian 12: $image"; done \
    < <(sed -n 's/^FROM \([^ ]*\).*/\1/p' "$file")
while read -r source _; do [[ -e $source ]] || fail "no $source"; done < <(grep -v -- --from= "$file" | sed -n 's/^COPY //p')
[[ -x tests/install-packages.sh ]]
for ignored in .git 'build*'; do grep -qxF "$ignored" .containerignore || fail ".containerignore lets $ignored in"; done
while read -r option; do grep -rq "$option" CMakeLists.txt || fail "there is no option $option"; done \
    < <(grep -o 'HEXRELIEF_[A-Z]*' "$file")
if command -v hadolint >/dev/null; then hadolint --ignore DL3008 "$file"; else echo "NOTE: no hadolint here: only looked at"; fi

[[ ${2:-} == build ]] || exit 0
if command -v podman >/dev/null; then
    podman build -q -f $file -t hexrelief-test . && podman run --rm -v "$PWD/samples:/work:ro" hexrelief-test info left.png
elif command -v buildah >/dev/null; then
    buildah build -q -f $file -t hexrelief-test .
else
    echo "NOTE: neither podman nor buildah here: not built"
    exit 77
fi
