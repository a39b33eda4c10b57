# For the scripts that kill workers; sourced with the program in $program. A folder for all, $work, which is entered, a copy of
# the program at the head of PATH, and:
#   until_done NAME COMMAND...   calls the command again and again until it succeeds, and meanwhile kills some of its processes
#   processes                    the ids of those
#   fail WORDS                   ends the test
# What is started for all of the test (`daemons`: process ids; `mounts`: folders) ends with it.
work=$(mktemp -d /tmp/hexrelief-cluster-XXXXXX)
daemons=() mounts=()
clean_up() {
    local pid folder
    for pid in "${daemons[@]}"; do kill "$pid" 2>/dev/null || true; done
    for pid in "${daemons[@]}"; do tail --pid="$pid" -f /dev/null; done
    for folder in "${mounts[@]}"; do umount "$folder" || true; done
    rm -rf "$work"
}
trap clean_up EXIT
mkdir "$work/bin"
cp "$program" "$work/bin/hexrelief"  # whose processes are known by their program
export PATH="$work/bin:$PATH"
cd "$work"
fail() { echo "FAIL: $*"; exit 1; }

# Workers and batches of this test alone: those of the copy of the program.
processes() { find /proc -maxdepth 2 -name exe -lname "$work/bin/hexrelief" 2>/dev/null | cut -d/ -f3 || true; }

# kill_some COMMAND...: the command, during which every now and then one of the processes is killed for good. Its exit code.
kill_some() {
    local victim command code=0
    "$@" > log 2>&1 &
    command=$!
    while kill -0 "$command" 2>/dev/null; do
        sleep "0.$((RANDOM % 3))$((RANDOM % 9 + 1))"
        until victim=$(processes | shuf -n 1) && [[ -n $victim ]] || ! kill -0 "$command" 2>/dev/null; do :; done
        if [[ -n $victim ]] && ((kills_left > 0)) && kill -9 "$victim" 2>/dev/null; then
            kills_left=$((kills_left - 1)) killed=$((killed + 1))
        fi
    done
    wait "$command" || code=$?
    return $code
}

# Leaves in `told` what was done.
until_done() {
    local name=$1 calls=1
    shift
    killed=0 kills_left=8
    until kill_some "$@"; do
        ((++calls <= 25)) || { cat log; fail "$name does not come to an end"; }
    done
    ((killed > 0)) || fail "$name: nothing was killed"
    told="$killed killed, $calls calls"
}

# told_leftovers FOLDER: what killed processes left there is told, and is no failure.
told_leftovers() {
    local left one
    left=$(find "$1" -name '.hexrelief-*' | wc -l)
    one=$(find "$1" -name '.hexrelief-*' -print -quit)
    [[ $left == 0 ]] || echo "NOTE: $1: $left files that killed processes left behind; one is $one"
}
