#!/usr/bin/env bash
# Holds an analytic tracer against the truth in f64 by every ray set from five viewpoints of every scene of the catalogue, and of the
# files that are given; some 20 million rays in all. A table of what came of every set goes to results/software-exact/exact.csv, or to
# the file that OUT names, and the records that it is made of to the folder exact-records beside it. Ends well if no ray is wrong under `tight`
# (ambiguous ones included; `ties` has their number).
#     tests/exact.sh [scene.glb...]
#     TRACER=bvh-gpu OUT=mine.csv tests/exact.sh
. "$(dirname "$0")/study.sh" software-exact/exact.csv
makes_records
tracer=${TRACER:-dirt:improved}
table=$scratch/exact.csv
number=0

# One scene from one viewpoint: `pixel-random` has two rays a pixel here, so that no set outweighs the others.
try() {
    local folder=$scratch/run
    rm -rf "$folder"
    "$program" run --tracer "$tracer" --preset quick --scene "$1" ${2:+--view "$2"} --rays all --set rays.pixel_random_count=2 \
        --samples 1 --quiet --out "$folder" > /dev/null
    # Ambiguous any-hit rays are in no class: either answer is right.
    jq -r '.commit as $commit | .runs[] | .scene as $scene | .viewpoint.name as $view | .tracer as $tracer | .traces[]
        | .judgement as $judged | ($judged.classes.tight // $judged.occlusion) as $class
        | [$scene.name, $scene.triangles, $view, $tracer.name, $tracer.preset, .rays, .count,
           ([$class | .false_hit, .false_miss, .early, .late, .false_occluded, .false_free | numbers] | if . == [] then error("no classes") else add end), $judged.ties, $commit]
        | @csv' \
        "$folder/run.json" | tr -d '"' >> "$table"
    number=$((number + 1))
    keep "$folder" "$(printf '%02d-%s' "$number" "$(basename "$1")${2:+-$2}" | tr -c '[:alnum:].-' _)"
    awk -F, '{ rays += $7; wrong += $8 } END { printf "exact: %d rays, %d wrong\n", rays, wrong }' "$table" >&2
}

echo 'scene,triangles,viewpoint,tracer,preset,rays,count,wrong_tight,ties,commit' > "$table"
views=$("$program" list scenes --json | jq -r '.[] | .name as $scene | .viewpoints[:5][] | "\($scene) \(.)"')
[ -n "$views" ] || { echo 'exact: no scene is listed' >&2; exit 1; }
while read -r scene view; do
    echo "exact: $scene from $view" >&2
    try "$scene" "$view"
done <<< "$views"

for file in "$@"; do
    echo "exact: $file" >&2
    try "$file" ''
    # Four more eyes on the circle through the viewpoint that the rule finds, about what lies half a diagonal before it.
    found=$(jq -r '.runs[0] | (.scene.diagonal / 2) as $r | .viewpoint as $v
        | [range(3) | $v.eye[.] + $r * $v.forward[.]] as $c | ([range(3) | $v.eye[.] - $c[.]]) as $d | (range(1; 5) * 1.2566) as $a
        | [$c[0] + ($a | cos) * $d[0] + ($a | sin) * $d[2], $v.eye[1], $c[2] + ($a | cos) * $d[2] - ($a | sin) * $d[0]]
        | "\(.[0]),\(.[1]),\(.[2]):\($c[0]),\($c[1]),\($c[2])"' "$scratch/run/run.json")
    mapfile -t poses <<< "$found"
    for pose in "${poses[@]}"; do
        try "$file" "$pose"
    done
done

finish "$table"
awk -F, 'NR > 1 { rays += $7; wrong += $8; ties += $9 } END { printf "exact: %d rays, %d wrong, %d ambiguous\n", rays, wrong, ties; exit wrong > 0 }' "$out"
