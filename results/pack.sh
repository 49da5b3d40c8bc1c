#!/bin/bash
# Makes folders of results small enough to keep: records compressed (every verb reads them so), pictures as SVG alone, without
# pages in HTML or tables in CSV; of tables of papers without summaries and plain charts. `tracebench report DIR` makes what is left out again,
# and with `--html` the pages.
# Only what tracebench.sha256, the list of a folder, has as it is there is touched; a folder without a list is left alone.
# results/pack.sh DIR...
set -euo pipefail
list=tracebench.sha256
pack='xz -9e'

# Whether a file of the folder is on its list, unchanged.
is_ours() { [ -f "$1" ] && [ ! -L "$1" ] && grep -qxF -- "$(sha256sum -- "$1")" "$list"; }

for folder in "$@"; do
    [ -n "$(find "$folder" -name "$list" -type f)" ] || echo "pack: left alone, no $list: $folder" >&2
done
find "$@" -name "$list" -type f -printf '%h\n' | while read -r folder; do (
    cd "$folder"
    # Of a paper's table its page, verdicts and figures tell what its summary and plain charts do.
    of_paper=
    for verdicts in verdicts_*.json; do if [ -f "$verdicts" ]; then of_paper=1; fi; done
    # Sorted, so that the list is not read while it is written.
    cut -d ' ' -f 3- "$list" | sort -u | while read -r name; do
        case $name in
            # What frames show is in no record.
            pictures/*) continue ;;
            *.png | *.csv | report.html) ;;
            summary.md | error_vs_speed_*.svg | agreement_over_tolerance_*.svg) [ "$of_paper" ] || continue ;;
            run.json) ;;
            *) continue ;;
        esac
        is_ours "$name" || continue
        if [ "$name" = run.json ]; then
            $pack run.json < /dev/null
            sha256sum run.json.xz >> "$list"
        else
            rm "$name"
        fi
    done
); done
