#!/usr/bin/env bash
# The wider set: the tests that take too long for every run, each of which says so by `#[ignore = "wider set: ..."]`. Runs them and
# writes down what came of it, by which commit and on which machine: tests/wider.sh [FILE]
set -euo pipefail
cd "$(dirname "$0")/.."
record=${1:-results/wider-tests.txt}
export CARGO_TERM_COLOR=never

commit=$(git rev-parse HEAD)
[ -z "$(git status --porcelain -- . ":!$record")" ] || commit="$commit + changes"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
outcome=passed
# Binaries are named on stderr, tests on stdout.
cargo test --release --workspace --lib --bins --tests --no-fail-fast -- --ignored 2>&1 | tee "$log" || outcome=FAILED

{
    echo "outcome: $outcome"
    echo "commit: $commit"
    echo "date: $(date -u +%Y-%m-%dT%H:%M:%SZ)"
    echo "system: $(uname -srm), $(nproc) threads"
    # Built with the tests.
    target/release/tracebench adapters --quiet | sed 's/^/adapter /'
    echo
    # `ok binary name`, in the order of the run.
    awk '/^ +Running /{ binary = $NF; sub(/.*\//, "", binary); sub(/-[0-9a-f]+(\.exe)?\)$/, "", binary) }
         /^test .* \.\.\. (ok|FAILED)$/{ print $NF, binary, $2 }' "$log"
} > "$record.new"
mv "$record.new" "$record"
echo "$outcome; the record: $record"
[ "$outcome" = passed ]
