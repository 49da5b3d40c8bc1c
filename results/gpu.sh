#!/bin/bash
# Figures of a machine with a GPU that can be had for ten minutes.
#     results/gpu.sh pack DIR     # where Rust is: the program, stripped, with the Vulkan loader, into a new folder that travels
#     DIR/gpu.sh run NAME         # where the GPU is: doctor.txt and `reproduce` at preset paper into the folder NAME, and NAME.tar.gz
# BUDGET (8m) and PRESET (paper) may be set. `run` again goes on with NAME. The archive is made to be handed in (RULES.md).
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
fail() { echo "gpu: $*" >&2; exit 1; }
[ $# = 2 ] || fail 'say `pack DIR` or `run NAME`'

# at_most MIB PATH WHAT
at_most() { [ "$(du -sk --apparent-size "$2" | cut -f 1)" -le $((1024 * $1)) ] || fail "$3 is larger than $1 MiB: $2"; }

case $1 in
pack)
    [ ! -e "$2" ] || fail "$2 is there already: name a new folder"
    (cd "$here/.." && cargo build --release --bin tracebench)
    loader=$(ldconfig -p | sed -n 's/.*libvulkan\.so\.1 .* => //p' | head -n 1)
    [ -n "$loader" ] || fail 'no Vulkan loader: run ./setup.sh'
    mkdir -p "$2/lib"
    cp -L "$loader" "$2/lib/libvulkan.so.1"
    strip -o "$2/tracebench" "$here/../target/release/tracebench"
    cp "$here/gpu.sh" "$here/pack.sh" "$2"
    at_most 60 "$2" 'what travels'
    du -sh --apparent-size "$2"
    ;;
run)
    program=$here/tracebench
    [ -x "$program" ] || fail "no program in $here: make a folder by \`results/gpu.sh pack DIR\`, and run the script there"
    # The machine's own loader, if it has one, knows where its drivers are.
    ldconfig -p | grep -q 'libvulkan\.so\.1' || export LD_LIBRARY_PATH=$here/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
    [ ! -e "$2" ] || [ -e "$2/reproduce.json" ] || fail "$2 is there already, and no reproduction: name another folder"
    "$program" doctor | tee "${2%/}-doctor.txt"
    resume=
    [ ! -e "$2" ] || resume=--resume
    # What failed stands in reproduce.md, and the rest is worth keeping.
    "$program" reproduce --budget "${BUDGET:-8m}" --preset "${PRESET:-paper}" --out "$2" $resume || echo 'gpu: not all went well, the rest is kept' >&2
    "$here/pack.sh" "$2"
    mv "${2%/}-doctor.txt" "$2/doctor.txt"
    tar -C "$(dirname "$2")" -czf "${2%/}.tar.gz" "$(basename "$2")"
    at_most 16 "${2%/}.tar.gz" 'the archive'
    echo "${2%/}.tar.gz"
    ;;
*) fail "'$1' is neither pack nor run" ;;
esac
