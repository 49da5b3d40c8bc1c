#!/usr/bin/env bash
# The wider set: the tests that take too long for every run, each of which says so by `#[ignore = "wider set: ..."]`; and all tests on
# a second Vulkan driver, where tests/swiftshader.sh can unpack one; and the recipes for notebooks. Runs them and writes down what came of it, by which commit and on
# which machine: tests/wider.sh [FILE]. DRIVERS=own or DRIVERS=second runs a half of it.
set -euo pipefail
cd "$(dirname "$0")/.."
record=${1:-results/wider-tests.txt}
drivers=${DRIVERS:-own second}
export CARGO_TERM_COLOR=never

commit=$(git rev-parse HEAD)
[ -z "$(git status --porcelain -- . ":!$record")" ] || commit="$commit + changes"
log=$(mktemp)
found=$(mktemp)
# What drivers answer, for the second to be held against the first.
TRACEBENCH_HITS=$(mktemp -d)
export TRACEBENCH_HITS
trap 'rm -rf "$log" "$found" "$TRACEBENCH_HITS"' EXIT
outcome=passed

# Tests on one driver: its name in the record, and which tests of all.
run() {
    # Binaries are named on stderr, tests on stdout.
    cargo test --release --workspace --lib --bins --tests --no-fail-fast -- "$2" 2>&1 | tee "$log" || outcome=FAILED
    {
        # Built with the tests.
        target/release/tracebench doctor --quiet | sed -n "s/^\([0-9]*: \)/$1: adapter \1/p"
        echo
        # `ok binary name`, in the order of the run.
        awk '/^ +Running /{ binary = $NF; sub(/.*\//, "", binary); sub(/-[0-9a-f]+(\.exe)?\)$/, "", binary) }
             /^test .* \.\.\. (ok|FAILED)$/{ print $NF, binary, $2 }' "$log"
        echo
    } >> "$found"
}

# Without these a test of engines passes unseen.
tests/engines.sh > "$log" 2>&1 || { outcome=FAILED && tail -n 1 "$log" >> "$found"; }

for driver in $drivers; do
    case $driver in
        own) run own --ignored ;;
        second)
            if manifest=$(tests/swiftshader.sh 2> "$log"); then
                VK_DRIVER_FILES=$manifest run second --include-ignored
            else
                echo "second: skipped, $(tail -n 1 "$log")" | tee -a "$found"
            fi
            ;;
        *)
            echo "DRIVERS is own, second, or both; it is '$drivers'" >&2
            exit 2
            ;;
    esac
done

# By the program that was built with the tests.
tests/notebooks.sh > "$log" 2>&1 || outcome=FAILED
tail -n 1 "$log" >> "$found"

{
    echo "outcome: $outcome"
    echo "commit: $commit"
    echo "date: $(date -u +%Y-%m-%dT%H:%M:%SZ)"
    echo "system: $(uname -srm), $(nproc) threads"
    cat "$found"
} > "$record.new"
mv "$record.new" "$record"
echo "$outcome; the record: $record"
[ "$outcome" = passed ]
