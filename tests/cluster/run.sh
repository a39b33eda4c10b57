#!/usr/bin/env bash
# run.sh PROGRAM [ROWS]: a batch, Snakemake, a Slurm array and make over ROWS (200) tiny pairs, whose workers are killed at random
# and which are then started again: each row is there once, with the bytes of an undisturbed batch. Slurm's one node is started
# here, and needs root. What is not installed (Debian's snakemake, slurm-wlm, munge) is passed over aloud. Some minutes: not one of
# ctest's tests.
set -euo pipefail
program=$(realpath "$1") rows=${2:-200}
here=$(cd "$(dirname "$0")" && pwd)
samples=$(realpath "$here/../../samples/cluster")
# shellcheck source=kills.sh
source "$here/kills.sh"

python3 "$here/make_pairs.py" in "$rows"
{
    echo left,right,name,mesh.spacing_px
    for left in in/*_left.ppm; do
        name=$(basename "$left" _left.ppm)
        echo "$left,in/${name}_right.ppm,$name,5"
    done
} > pairs.csv
hexrelief batch pairs.csv -o undisturbed --quiet

sums() { (cd "$1" && sha256sum ./*.glb); }
# shellcheck disable=SC2094 # another sums
sums undisturbed > sums
[[ $(wc -l < sums) == "$rows" ]] || fail "the undisturbed batch has not all rows"

# Every row once, with the right bytes, in the table too, and nothing else in the folder.
check() {
    local folder=$1
    sums "$folder" | cmp - sums || fail "$folder: other bytes than those of the undisturbed batch"
    [[ $(find "$folder" -name '*.json' ! -name 'batch*' | wc -l) == "$rows" ]] || fail "$folder: not a report a row"
    [[ $(tail -n +2 "$folder/batch.csv" | cut -d, -f1 | sort -u | wc -l) == "$rows" ]] || fail "$folder: the table"
    told_leftovers "$folder"
    echo "PASS $folder: $rows rows; $2"
}

until_done batch hexrelief batch pairs.csv -o batch
check batch "$told"

hexrelief batch pairs.csv -o commands --print-commands > commands.txt
# shellcheck disable=SC2016 # the inner shell's
until_done commands xargs -a commands.txt -P 2 -d '\n' -n 1 sh -c 'eval "$0" || exit 1'
hexrelief batch pairs.csv -o commands --quiet
check commands "$told"

cp "$samples/Makefile" .
echo 'mesh: {spacing_px: 5}' > my.yaml
until_done make make -k -j2 IN=in OUT=make ENDING=ppm OPTIONS='--config my.yaml'
make -q IN=in OUT=make ENDING=ppm OPTIONS='--config my.yaml' || fail "make: not all is up to date"
touch my.yaml
make -q IN=in OUT=make ENDING=ppm OPTIONS='--config my.yaml' && fail "make: the depfiles do not name the configuration"
hexrelief batch pairs.csv -o make --quiet
check make "$told"

cp -r "$samples"/{Snakefile,local,slurm} .
if command -v snakemake >/dev/null; then
    until_done snakemake snakemake --profile local --config manifest=pairs.csv out=snakemake shards=8 threads=1
    check snakemake "$told"
else
    echo "NOTE: no snakemake here: the Snakefile is not tested"
fi

# shellcheck source=slurm.sh
source "$here/slurm.sh"
if start_slurm; then
    until_done array sbatch --wait --array=1-8 --cpus-per-task=1 --mem=500 --no-requeue --output=array-%a.log \
        "$samples/array.sbatch" pairs.csv array
    hexrelief batch pairs.csv -o array --quiet
    check array "$told"
    if command -v snakemake >/dev/null; then
        until_done slurm snakemake --profile slurm --latency-wait 5 \
            --config manifest=pairs.csv out=slurm-out shards=4 threads=1 mem_mb=500
        check slurm-out "$told"
    fi
else
    echo "NOTE: Slurm could not be started here: $slurm_problem"
fi
echo "ALL PASSED"
