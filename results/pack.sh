#!/bin/sh
# Makes folders of results small enough to keep: records compressed (every verb reads them so), pictures as SVG alone, without
# lists that no page shows; of tables of papers without summaries and plain charts. `tracebench report DIR` makes what is left out again.
# results/pack.sh DIR...
set -eu
for folder in "$@"; do
    find "$folder" \( -name '*.png' -o -name traces.csv -o -name wrong_rays.csv \) -delete
    find "$folder" -name run.json -exec gzip -9 -n -f {} +
done
# Of a paper's table its page, verdicts and figures tell what its summary and plain charts do.
for folder in "$@"; do
    find "$folder" -name 'verdicts_*.json' | while read -r verdicts; do
        table=$(dirname "$verdicts")
        rm -f "$table"/summary.md "$table"/error_vs_speed_*.svg "$table"/agreement_over_tolerance_*.svg
    done
done
