#!/usr/bin/env bash
# Looks at a page of `tracebench report --html` in headless Chromium: tests/look_at_report.sh PAGE.html FOLDER
# Checks that the console says nothing, that what is left out goes and comes back, that tables sort and points tell their parameters, and
# that the address holds the choice; writes pictures of light and dark, narrow and wide, and it printed, to the folder. Debian has the browser as
# `apt-get install chromium`; CHROMIUM names another one. It is part of no other command.
set -euo pipefail
[ $# -eq 2 ] || { sed -n 2p "$0" >&2; exit 2; }
page=$(realpath "$1")
mkdir -p "$2"
folder=$(realpath "$2")
probe=$(dirname "$(realpath "$0")")/look_at_report.js
browser=${CHROMIUM:-$(command -v chromium || command -v chromium-browser || command -v google-chrome)} ||
    { echo 'no Chromium: apt-get install chromium, or name one in CHROMIUM' >&2; exit 1; }
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

fail() { echo "look_at_report: $*" >&2; exit 1; }
call() {
    "$browser" --headless --no-sandbox --disable-gpu --hide-scrollbars --user-data-dir="$scratch/profile" --enable-logging=stderr \
        --virtual-time-budget=20000 "$@" 2> "$scratch/log"
    # What else it writes there is of the browser.
    if grep CONSOLE "$scratch/log" >&2; then fail 'the console has something to say'; fi
}

# The page itself, then a copy that tries everything and says what came of it. Neither may fetch anything.
call --dump-dom "file://$page" > "$scratch/plain.html"
standings() { grep -o 'class="mark [a-z]*"' "$1" || true; }
diff <(standings "$page") <(standings "$scratch/plain.html") > /dev/null || fail 'the page draws other fronts than the program'
{ cat "$page"; printf '<script>\n'; cat "$probe"; printf '</script>\n'; } > "$scratch/probed.html"
call --dump-dom "file://$scratch/probed.html" > "$scratch/probed.out"
sed -n 's/^.*<pre id="probe">//; s/<\/pre>.*$//; /^\(ok\|FAILED\|nothing\)/p' "$scratch/probed.out" | tee "$folder/checks.txt"
grep -q '^ok all' "$folder/checks.txt" || fail 'the probe did not come to its end'
! grep -q '^FAILED' "$folder/checks.txt" || fail 'see above'

picture() { call --window-size="$2" --blink-settings="preferredColorScheme=$3" --screenshot="$folder/$1.png" "file://$page${4:-}" > /dev/null; }
for light in 1 0; do
    name=$([ "$light" = 1 ] && echo light || echo dark)
    picture "wide-$name" 1400,4200 "$light"
    # Below 500 pixels no window gets: a frame of that width shows what a telephone would.
    printf '<body style="margin:0"><iframe src="file://%s" style="border:0;width:390px;height:4200px"></iframe>' "$page" > "$scratch/narrow.html"
    call --window-size=390,4200 --blink-settings="preferredColorScheme=$light" --screenshot="$folder/narrow-$name.png" \
        "file://$scratch/narrow.html" > /dev/null
done
call --no-pdf-header-footer --print-to-pdf="$folder/print.pdf" "file://$page" > /dev/null
echo "looked at $page: pictures are in $folder"
