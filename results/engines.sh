#!/bin/sh
# Writes rays of scenes with their truth, and what other engines answer to them, into target/engines: what is there already stays.
# results/engines.sh SCENE...
set -eu
cd "$(dirname "$0")/.."
python=$(tests/engines.sh)
rays() { [ -e "$3/diffuse/manifest.json" ] || target/release/tracebench rays --scene "$1" --rays diffuse --size "$2" --quiet --out "$3"; }
ask() {
    script=$1; set=$2; answers=$3; shift 3
    [ -e "$answers/rays_sha256" ] || "$python" "harness/examples/engines/$script" "$set/diffuse" "$answers" "$@"
}
for scene in "$@"; do
    of=target/engines/$scene
    rays "$scene" 256x128 "$of"
    ask embree.py "$of" "$of-embree"
    ask embree.py "$of" "$of-embree-fast" fast
    # trimesh's own test takes at most 4,096 rays.
    rays "$scene" 64x32 "$of-few"
    ask trimesh_own.py "$of-few" "$of-trimesh"
done
