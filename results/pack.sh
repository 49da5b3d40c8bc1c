#!/bin/sh
# Makes folders of results small enough to keep: records compressed (every verb reads them so), pictures as SVG alone, without
# lists that no page shows. `tracebench report DIR` makes what is left out again.
# results/pack.sh DIR...
set -eu
for folder in "$@"; do
    find "$folder" \( -name '*.png' -o -name traces.csv -o -name wrong_rays.csv \) -delete
    find "$folder" -name run.json -exec gzip -9 -n -f {} +
done
