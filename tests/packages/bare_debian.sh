#!/usr/bin/env bash
# bare_debian.sh SOURCES BUILD: installs the packages into a bare Debian 12, by their own dependencies alone, and runs the sample
# there: the program, the Python module, and a program that is built against the library. Needs root, mmdebstrap and Debian's
# archive, and some minutes: not one of ctest's tests.
set -euo pipefail
sources=$(realpath "$1") build=$(realpath "$2")
command -v mmdebstrap >/dev/null || { echo "NOTE: no mmdebstrap here: the packages are not installed"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cpack --config "$build/CPackConfig.cmake" -G DEB -B "$work/debs" >/dev/null
mkdir "$work/files"
cp "$work"/debs/*.deb "$work/files"
cp -r "$sources"/samples/{left.png,right.png,disparity.pfm,calib.txt} "$sources/tests/library/consumer" "$work/files"

cat >"$work/files/inside.sh" <<'END'
set -e
cd /packages
export DEBIAN_FRONTEND=noninteractive
apt-get -q update >/dev/null
install() { apt-get -y -q --no-install-recommends install "$@" >log 2>&1 || { cat log; exit 1; }; }
install ./hexrelief_*.deb
hexrelief --version --verbose
hexrelief run --left left.png --right right.png --calib calib.txt -o program.glb
hexrelief demo /tmp/demo
echo "libraries that came with the program: $(dpkg -l | grep -c '^ii  lib')"
install ./libhexrelief0*.deb ./python3-hexrelief_*.deb
cat >sample.py <<'PY'
import hexrelief
left, right = (hexrelief.read_picture(f"{side}.png") for side in ("left", "right"))
disparity = hexrelief.compute_disparity(left, right, camera="calib.txt")
mesh = hexrelief.mesh(disparity, color=left, camera="calib.txt")
print(mesh, mesh.save("python.glb"))
PY
python3 sample.py
cmp python.glb program.glb
install ./libhexrelief-dev_*.deb g++ cmake ninja-build
cmake -S consumer -B consumer-build -G Ninja >/dev/null
cmake --build consumer-build >/dev/null
consumer-build/consumer /packages consumer.glb
library=$(dpkg-query -W -f '${Package}' 'libhexrelief0*')
dpkg -V hexrelief "$library" python3-hexrelief libhexrelief-dev
apt-get -y -q purge hexrelief python3-hexrelief libhexrelief-dev "$library" >/dev/null 2>&1
! find / -xdev -name '*hexrelief*' -not -path '/packages/*' -not -path '/tmp/*' -not -path '/var/*' -not -path '/proc/*' | grep .
echo "ALL PASSED"
END
# shellcheck disable=SC2016
mmdebstrap --quiet --variant=apt --customize-hook="copy-in '$work/files' /" \
    --customize-hook='mv "$1/files" "$1/packages" && chroot "$1" sh /packages/inside.sh' bookworm /dev/null
