#!/usr/bin/env bash
# binary.sh PROGRAM ARCHITECTURES: the program needs no CUDA library to start, and holds code for the architectures that it was
# configured with (CMake's list; checked where cuobjdump is).
set -uo pipefail
program=$1
IFS=';' read -ra architectures <<<"$2"
needed=$(ldd "$program") || { echo "FAIL ldd $program"; exit 1; }
if grep -qiE 'libcu|libnv' <<<"$needed"; then
    echo "FAIL $program needs"
    grep -iE 'libcu|libnv' <<<"$needed"
    exit 1
fi
grep -q 'libstdc++' <<<"$needed" || { echo "FAIL ldd tells nothing"; exit 1; }
if ! command -v cuobjdump >/dev/null; then
    echo "NOTE: no cuobjdump here: its architectures were not checked"
    exit 0
fi
elf=$(cuobjdump --list-elf "$program") ptx=$(cuobjdump --list-ptx "$program")
for architecture in "${architectures[@]}"; do
    if [[ $architecture == native ]]; then
        [[ -n $elf ]] || { echo "FAIL no machine code"; exit 1; }
        continue
    fi
    number=${architecture%%-*}
    [[ $architecture == *-virtual ]] || grep -q "sm_$number\." <<<"$elf" || { echo "FAIL no machine code for sm_$number"; exit 1; }
    [[ $architecture == *-real ]] || grep -q "sm_$number\." <<<"$ptx" || { echo "FAIL no PTX for compute_$number"; exit 1; }
done
