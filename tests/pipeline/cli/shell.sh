#!/usr/bin/env bash
# shell.sh PROGRAM: completions, manual pages, the version at length and the demo. Shells that are missing are named.
set -euo pipefail
program=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "FAIL $*"; exit 1; }

# offered WORDS...: what bash offers after these words, the last of which is being typed.
"$program" completion bash >"$work/bash"
# shellcheck source=/dev/null
source "$work/bash"
compopt() { :; }
offered() {
    COMP_WORDS=(hexrelief "$@") COMP_CWORD=$#
    _hexrelief
    echo "${COMPREPLY[*]-}"
}
[[ $(offered ru) == run ]] || fail "ru: $(offered ru)"
[[ $(offered tiles pl) == plan ]] || fail "tiles pl: $(offered tiles pl)"
[[ $(offered run --disparity-s) == --disparity-scale ]] || fail "run --disparity-s: $(offered run --disparity-s)"
[[ $(offered run --backend c) == "cpu cuda" ]] || fail "--backend c: $(offered run --backend c)"
[[ $(offered run --set mesh.spac) == mesh.spacing_px= ]] || fail "--set: $(offered run --set mesh.spac)"
[[ $(offered run --set surface.views = b) == both ]] || fail "--set surface.views=b: $(offered run --set surface.views = b)"
[[ $(offered run --set surface.views=b) == surface.views=both ]] || fail "--set surface.views=b without word breaks"
[[ $(offered run --set export.lod =) == "" ]] || fail "--set export.lod=: $(offered run --set export.lod =)"
[[ $(offered run --backend = c) == "cpu cuda" ]] || fail "--backend=c: $(offered run --backend = c)"
[[ $(offered batch --log js) == jsonl ]] || fail "--log js: $(offered batch --log js)"
[[ $(offered completion z) == zsh ]] || fail "completion z: $(offered completion z)"
[[ $(offered run --config comp) == compact ]] || fail "--config comp: $(offered run --config comp)"
[[ $(offered run --left "$work/ba") == "$work/bash" ]] || fail "--left: $(offered run --left "$work/ba")"

"$program" completion zsh >"$work/_hexrelief"
if command -v zsh >/dev/null; then zsh -n "$work/_hexrelief"; else echo "NOTE: no zsh here"; fi
"$program" completion fish >"$work/hexrelief.fish"
if command -v fish >/dev/null; then
    fish_offers() { HOME=$work fish --no-config -c "source $work/hexrelief.fish; complete -C '$1'" | cut -f1 | tr '\n' ' '; }
    [[ $(fish_offers 'hexrelief dev') == "devices " ]] || fail "fish: $(fish_offers 'hexrelief dev')"
    [[ $(fish_offers 'hexrelief run --backend cu') == "cuda " ]] || fail "fish: $(fish_offers 'hexrelief run --backend cu')"
    [[ $(fish_offers 'hexrelief run --set surface.views=b') == "surface.views=both " ]] || fail "fish, --set"
    [[ $(fish_offers 'hexrelief run --disparity-s') == "--disparity-scale " ]] || fail "fish, options"
else
    echo "NOTE: no fish here"
fi
if "$program" completion tcsh 2>"$work/err"; then fail "tcsh was taken"; fi

mkdir "$work/man"
"$program" manual --into "$work/man"
for command in $("$program" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]\+\) .*/\1/p'); do
    [[ -s $work/man/hexrelief-$command.1 ]] || fail "no page of $command"
    grep -A 1 '^\.SH EXIT STATUS' "$work/man/hexrelief-$command.1" | grep -q TP || fail "no exit status of $command"
    cmp <("$program" manual "$command") "$work/man/hexrelief-$command.1"
done
if command -v man >/dev/null; then
    for page in "$work"/man/*; do
        LC_ALL=C.UTF-8 man --warnings -E UTF-8 -l -Tutf8 -Z "$page" >/dev/null 2>"$work/err"
        [[ ! -s $work/err ]] || fail "$page: $(cat "$work/err")"
    done
    LC_ALL=C.UTF-8 MANWIDTH=100 man -l "$work/man/hexrelief-run.1" 2>/dev/null | grep -q -- '-o, --output OUT' || fail "-o OUT"
else
    echo "NOTE: no man here: the pages are not formatted"
fi

"$program" --version --verbose | grep -q '^commit ' || fail "no commit in the version"
[[ $("$program" --version | wc -l) -eq 1 ]]

# The page is opened by what the desktop says, where there is one.
mkdir "$work/bin"
# shellcheck disable=SC2016
printf '#!/bin/sh\necho "$1" >"%s/opened"\n' "$work" >"$work/bin/xdg-open"
chmod +x "$work/bin/xdg-open"
cd "$work"
DISPLAY=:7 PATH="$work/bin:$PATH" "$program" demo --no-open >out
[[ -s hexrelief-demo/relief.glb && -s hexrelief-demo/left.png && ! -e opened ]] || fail "demo: $(cat out)"
if [[ -s hexrelief-demo/relief.html ]]; then
    DISPLAY=:7 PATH="$work/bin:$PATH" "$program" demo again >out
    [[ $(cat opened) == "$work/again/relief.html" ]] || fail "not opened: $(cat out)"
else
    grep -q nodejs out || fail "demo does not say why there is no page: $(cat out)"
fi
