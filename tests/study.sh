# For the scripts beside this that measure by the program, which source it with the table that they write, below results/:
#     . "$(dirname "$0")/study.sh" software-frames/frames.csv
# Gives `root`, `out` (the table, or the file that OUT names), `program` (built where it is missing, or what PROGRAM names) and `scratch`;
# `keep`, which keeps a record that was read, packed, in a folder beside the table; and `finish`, which puts both there.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
out=$(realpath -m "${OUT:-$root/results/$1}")
program=${PROGRAM:-$root/target/release/tracebench}
[ -x "$program" ] || (cd "$root" && cargo build --release --bin tracebench)
command -v jq > /dev/null || { echo "$(basename "$0" .sh): jq is missing: install it (Debian: apt-get install jq), then run this again" >&2; exit 1; }
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
kept=${out%.csv}-records

# keep FOLDER NAME: a run's record, under a name.
keep() {
    mkdir -p "$scratch/kept/$2"
    gzip -9 -n -c "$1/run.json" > "$scratch/kept/$2/run.json.gz"
}

# Records of before would pass for those of this table, and are not for this to remove.
makes_records() {
    [ ! -e "$kept" ] || { echo "$(basename "$0" .sh): $kept is there: move it away, or name another table by OUT" >&2; exit 1; }
}

# finish TABLE
finish() {
    mkdir -p "$(dirname "$out")"
    mv "$1" "$out"
    mv -n "$scratch/kept" "$kept"
}
