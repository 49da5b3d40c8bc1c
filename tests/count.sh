#!/bin/bash
# count.sh [DIR]: lines of .rs and .wgsl without tests (inline ones too), of tracked files: all, and those of harness/src.
cd "${1:-.}" || exit 1
# Modules that only tests have.
only_tests=$(git grep -A1 '^#\[cfg(test)\]$' -- '*.rs' | sed -nE 's#^(.*)/(lib|mod)\.rs-mod ([a-z_]+);$#\1/\3.rs#p')
sources() { git ls-files | grep -E '\.(rs|wgsl)$' | grep -vE '(^|/)tests?/|tests?\.(rs|wgsl)$|_tests|fixture|/test/' | grep -vxF "$only_tests"; }
# What follows `#[cfg(test)]` and `mod tests {` is a test, up to the file's end.
lines() { awk '/^#\[cfg\(test\)\]$/ {held = 1; next} held {if ($0 ~ /^mod tests? *\{/) exit; n++; held = 0} {n++} END {print n + 0}' "$1"; }
all=0; harness=0
while read -r file; do
    [ -f "$file" ] || continue
    count=$(lines "$file")
    all=$((all + count))
    case "$file" in harness/src/*) harness=$((harness + count)) ;; esac
done < <(sources)
echo "all $all harness/src $harness"
