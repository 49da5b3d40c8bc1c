#!/bin/sh
# Installs what tracebench needs beside Rust: a C linker, a C++17 compiler (for FLIP), the Vulkan loader and, where no
# graphics adapter is found, Mesa's software driver. Does nothing where nothing is missing; may be run any number of times.
set -eu

say() { printf 'setup: %s\n' "$*"; }
fail() { printf 'setup: %s\n' "$*" >&2; exit 1; }

has_cxx17() {
    printf '#include <optional>\nint main() { if constexpr (true) return 0; }\n' |
        "${CXX:-c++}" -std=c++17 -fsyntax-only -x c++ - 2>/dev/null
}

has_vulkan_loader() {
    { ldconfig -p 2>/dev/null || /sbin/ldconfig -p 2>/dev/null || true; } | grep -q 'libvulkan\.so\.1'
}

# A Vulkan driver is a JSON manifest in one of the loader's folders, or named by the environment.
drivers() {
    if [ -n "${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}" ]; then
        printf '%s\n' "${VK_DRIVER_FILES:-$VK_ICD_FILENAMES}" | tr ':' '\n' | while IFS= read -r file; do
            if [ -e "$file" ]; then printf '%s\n' "$file"; fi
        done
        return
    fi
    for folder in /etc/vulkan/icd.d /usr/share/vulkan/icd.d /usr/local/share/vulkan/icd.d \
        "${XDG_DATA_HOME:-${HOME:-/nonexistent}/.local/share}/vulkan/icd.d"; do
        if [ -d "$folder" ]; then find "$folder" -name '*.json'; fi
    done
}

has_gpu_node() {
    for node in /dev/dri/renderD* /dev/nvidia[0-9]* /dev/dxg; do
        if [ -e "$node" ]; then return 0; fi
    done
    return 1
}

# Software (lvp: lavapipe) counts always, any other driver only beside a device that it could drive.
has_adapter() {
    if drivers | grep -q 'lvp_icd'; then return 0; fi
    has_gpu_node && [ -n "$(drivers)" ]
}

command -v cargo >/dev/null 2>&1 || fail 'cargo is missing: install Rust 1.89 or later (https://rustup.rs), then run this again'

if [ -n "${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}" ] && [ -z "$(drivers)" ]; then
    fail "VK_DRIVER_FILES or VK_ICD_FILENAMES names no file that exists (${VK_DRIVER_FILES:-$VK_ICD_FILENAMES}), and the Vulkan loader looks nowhere else: unset it, then run this again"
fi

missing=''
if ! command -v cc >/dev/null 2>&1; then
    say 'a C linker is missing'
    missing="$missing gcc libc6-dev"
fi
if ! has_cxx17; then
    say 'a C++ compiler that knows C++17 is missing'
    missing="$missing g++"
fi
if ! has_vulkan_loader; then
    say 'the Vulkan loader is missing'
    missing="$missing libvulkan1"
fi
if ! has_adapter; then
    say 'no graphics adapter was found: Mesa'"'"'s software driver will serve'
    missing="$missing mesa-vulkan-drivers"
fi

if [ -z "$missing" ]; then
    say 'nothing is missing'
    exit 0
fi

system='unknown'
if [ -r /etc/os-release ]; then
    system=$(. /etc/os-release && printf '%s %s' "${ID:-unknown}" "${ID_LIKE:-}")
fi
case " $system " in
    *' debian '* | *' ubuntu '*) ;;
    *)
        fail "this system ($system) is not known here. Install C and C++17 compilers, the Vulkan loader (libvulkan.so.1) and a
setup: Vulkan driver (Mesa's lavapipe is one in software) with its own means, then run this again. On Debian the packages are:$missing"
        ;;
esac

as_root=''
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null 2>&1 || fail "root is needed: run 'apt-get install$missing' as root, then this again"
    as_root='sudo'
fi
say "installing:$missing"
export DEBIAN_FRONTEND=noninteractive
$as_root apt-get update -q
# shellcheck disable=SC2086  # the list is meant to be split
$as_root apt-get install -q -y --no-install-recommends $missing
command -v cc >/dev/null 2>&1 || fail 'a C linker is still missing'
has_cxx17 || fail 'there is still no C++17 compiler'
has_vulkan_loader || fail 'the Vulkan loader is still missing'
has_adapter || fail 'there is still no Vulkan driver'
say 'done'
