#!/bin/sh
# Unpacks SwiftShader, a Vulkan driver in software that is independent of Mesa's, and prints its manifest, which makes it the driver:
#     export VK_DRIVER_FILES="$(tests/swiftshader.sh)"
# Debian's chromium brings it as a library; nothing is installed. Does nothing but print where it was unpacked before.
set -eu
cd "$(dirname "$0")/.."
folder="$PWD/target/swiftshader"
library='libvk_swiftshader.so'
manifest='vk_swiftshader_icd.json'

fail() { printf 'swiftshader: %s\n' "$*" >&2; exit 1; }

if [ ! -s "$folder/$manifest" ] || [ ! -s "$folder/$library" ]; then
    command -v apt-get >/dev/null 2>&1 && command -v dpkg-deb >/dev/null 2>&1 ||
        fail "this system has no apt-get: get $library and $manifest by other means, and name the latter in VK_DRIVER_FILES"
    scratch=$(mktemp -d)
    trap 'rm -rf "$scratch"' EXIT
    # Which of chromium's packages holds it has changed between releases.
    for package in chromium-common chromium; do
        # Lists may be missing, or too old to name a package that can still be had.
        (cd "$scratch" && apt-get download -q "$package" >&2) || {
            as_root=''
            [ "$(id -u)" -eq 0 ] || as_root='sudo'
            $as_root apt-get update -q >&2
            (cd "$scratch" && apt-get download -q "$package" >&2)
        } || fail "apt-get cannot download $package, the package of Debian that holds $library"
        dpkg-deb -x "$scratch/$package"_*.deb "$scratch/unpacked"
        found=$(find "$scratch/unpacked" -name "$manifest")
        if [ -n "$found" ]; then break; fi
    done
    [ -n "$found" ] || fail "none of chromium's packages holds $manifest any longer"
    mkdir -p "$folder"
    # The manifest names the library as its neighbour; it goes last, so that what is there is whole.
    cp "$(dirname "$found")/$library" "$found" "$folder"
fi
printf '%s\n' "$folder/$manifest"
