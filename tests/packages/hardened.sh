#!/usr/bin/env bash
# hardened.sh BUILD: program and libraries are built so that a bug in a reader is harder to use. Exits 77 without readelf.
set -euo pipefail
build=$1
command -v readelf >/dev/null || { echo "NOTE: no readelf here (binutils): the programs' hardening is not tested"; exit 77; }
failed=0
expect() {  # FILE WHAT TEXT PATTERN
    grep -qE "$4" <<<"$3" || { echo "FAIL $1 has no $2"; failed=1; }
}
for file in "$build/hexrelief" "$build/libhexrelief.so"; do
    header=$(readelf -hW "$file") segments=$(readelf -lW "$file") dynamic=$(readelf -dW "$file")
    symbols=$(readelf --dyn-syms -W "$file")
    expect "$file" "position of its own choice (PIE)" "$header" 'Type: +DYN'
    expect "$file" "read-only tables (RELRO)" "$segments" GNU_RELRO
    expect "$file" "tables filled at start (BIND_NOW)" "$dynamic" 'BIND_NOW|FLAGS_1.*NOW'
    expect "$file" "guarded stacks (stack protector)" "$symbols" __stack_chk_fail
    expect "$file" "checked copies (FORTIFY)" "$symbols" '__[a-z]+_chk(@| |$)'
    if grep -E 'GNU_STACK' <<<"$segments" | grep -q RWE; then
        echo "FAIL $file can run what is on its stack"
        failed=1
    fi
done
exit $failed
