#!/bin/sh
# Makes an environment of Python with the engines that harness/examples/engines asks, and prints its interpreter. Nothing outside of
# target/ is installed, and nothing here depends on it. Does nothing but print where it was made before.
set -eu
cd "$(dirname "$0")/.."
folder="$PWD/target/engines"
fail() { printf 'engines: %s\n' "$*" >&2; exit 1; }

if [ ! -e "$folder/whole" ]; then
    python3 -m venv "$folder" >&2 || fail 'this system has no python3 with venv'
    "$folder/bin/pip" install -q embreex==4.4.0.post1 trimesh==5.2.0 numpy==2.4.6 rtree==1.4.1 >&2 || fail 'pip cannot install the packages'
    touch "$folder/whole"
fi
printf '%s\n' "$folder/bin/python"
