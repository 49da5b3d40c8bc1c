#!/usr/bin/env bash
# How fast tracers are beside the program of an earlier commit, on this machine: that commit is built beside the tree, then its process and today's take
# turns, today's first in every second round, and of every pair the ratio of speeds is told. Diffuse rays of every scene, with the agreement of the same
# traces and the commit of today's program (`now_dirty`: built from changed files).
# A table goes to results/software-against/against.csv, or to the file that OUT names.
#     tests/against.sh 2e0b5b4 dirt dirt:improved       # COMMIT, its tracer, today's tracer
#     ROUNDS=8 SCENES=room,candy tests/against.sh COMMIT THEN NOW
[ $# -eq 3 ] || { echo 'against: tell a commit, its tracer and the tracer of today, as 2e0b5b4 dirt dirt:improved' >&2; exit 1; }
commit=$1 then=$2 now=$3
. "$(dirname "$0")/study.sh" software-against/against.csv
earlier=${EARLIER:-}
if [ -z "$earlier" ]; then
    git -C "$root" worktree add --detach "$scratch/tree" "$commit" > /dev/null
    trap 'git -C "$root" worktree remove --force "$scratch/tree"; rm -rf "$scratch"' EXIT
    (cd "$scratch/tree" && cargo build --release --bin tracebench --target-dir "$scratch/target")
    earlier=$scratch/target/release/tracebench
fi

# Mesa's device-select layer complains where there is no display, of which earlier programs tell nothing.
export NODEVICE_SELECT=1

# The speed of one process, Mrays/s, and its agreement under `tight`.
trace() {
    rm -rf "$scratch/run"
    "$1" run --tracer "$2" --scene "$3" --rays diffuse --preset quick --quiet --out "$scratch/run" > /dev/null
    jq -r '.runs[0].traces[0] | "\(.mrays_per_s),\(.judgement.agreement.tight)"' "$scratch/run/run.json"
}

table=$scratch/against.csv
echo 'scene,round,then_mrays_per_s,then_tight_share,now_mrays_per_s,now_tight_share,now_over_then,then_commit,now_commit,now_dirty' > "$table"
for ((round = 1; round <= ${ROUNDS:-4}; round++)); do
    for scene in $(tr ',' ' ' <<< "${SCENES:-room,solids,cloth,hangar,candy,atrium,foliage,smithy}"); do
        if ((round % 2)); then before=$(trace "$earlier" "$then" "$scene"); fi
        after=$(trace "$program" "$now" "$scene")
        built=$(jq -r '"\(.commit),\(.dirty)"' "$scratch/run/run.json")
        if ((round % 2 == 0)); then before=$(trace "$earlier" "$then" "$scene"); fi
        echo "against: round $round, $scene: then $before, now $after" >&2
        echo "$scene,$round,$before,$after" | awk -F, -v OFS=, -v commits="$commit,$built" '{ print $0, $5 / $3, commits }' >> "$table"
    done
done
mkdir -p "$(dirname "$out")"
mv "$table" "$out"
