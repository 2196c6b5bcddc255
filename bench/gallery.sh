#!/usr/bin/env bash
# CPU seconds that each picture of the gallery takes, the least of several runs: with an empty cache, with the tables it kept, and
# with every effect and no cache; and how many times faster the second is than the last.
# `bench/gallery.sh [STRATUS] [WIDTH] [RUNS]`
set -euo pipefail
stratus=${1:-build/cli/stratus} width=${2:-256} runs=${3:-3}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
TIMEFORMAT='%U %S'

# render OPTION...: seconds of a picture of $scene.
render() {
    { time STRATUS_CACHE=$folder/cache "$stratus" render "$scene" --width "$width" -o "$folder/picture.png" --quiet "$@"; } 2>&1 |
        awk '{ print $1 + $2 }'
}

printf '%-18s %6s %6s %12s %6s\n' "width $width" cold warm "all effects" times
for scene in "$(dirname "$0")"/../tables/scenes/*.toml; do
    grep -qE '^\[(lobes|lambert)\]' "$scene" && continue
    for ((run = 0; run < runs; ++run)); do
        rm -rf "$folder/cache"
        echo "$(render) $(render) $(render --effects all --no-cache)"
    done | awk -v name="$(basename "$scene" .toml)" '
        { for (k = 1; k <= 3; ++k) if (NR == 1 || $k < least[k]) least[k] = $k }
        END { printf "%-18s %6.2f %6.2f %12.2f %6.1f\n", name, least[1], least[2], least[3], least[3] / least[2] }'
done
