# For the scripts beside this that measure by the program, which source it with the table that they write, below results/:
#     . "$(dirname "$0")/study.sh" software-exact/exact.csv
# Gives `root`, `out` (the table, or the file that OUT names), `program` (built where it is missing, or what PROGRAM names) and `scratch`.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
out=$(realpath -m "${OUT:-$root/results/$1}")
program=${PROGRAM:-$root/target/release/tracebench}
[ -x "$program" ] || (cd "$root" && cargo build --release --bin tracebench)
command -v jq > /dev/null || { echo "$(basename "$0" .sh): jq is missing: install it (Debian: apt-get install jq), then run this again" >&2; exit 1; }
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
