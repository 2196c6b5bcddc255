#!/usr/bin/env bash
# Seconds that each picture of the gallery takes: first with an empty cache, again with the tables it kept, and with every effect
# and no cache. `bench/gallery.sh [STRATUS] [WIDTH]`
set -euo pipefail
stratus=${1:-build-bench/cli/stratus} width=${2:-256}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# seconds OPTION...: of a picture of $scene.
seconds() {
    local started=$EPOCHREALTIME
    STRATUS_CACHE=$cache "$stratus" render "$scene" --width "$width" -o "$folder/picture.png" --quiet "$@"
    awk "BEGIN { printf \"%.2f\", $EPOCHREALTIME - $started }"
}

printf '%-18s %6s %6s %12s\n' "width $width" cold warm "all effects"
for scene in "$(dirname "$0")"/../tables/scenes/*.toml; do
    grep -qE '^\[(lobes|lambert)\]' "$scene" && continue
    name=$(basename "$scene" .toml) cache=$folder/$name
    printf '%-18s %6s %6s %12s\n' "$name" "$(seconds)" "$(seconds)" "$(seconds --effects all --no-cache)"
done
