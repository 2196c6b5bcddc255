#!/usr/bin/env bash
# CPU seconds that each picture of the gallery takes, the least of several runs: with an empty cache, with the tables it kept, and
# with every effect and no cache; how many times faster the second is than the last; and what a plan takes beside the choices that
# the first picture finds, in hundredths of that picture, the median of the runs.
# `bench/gallery.sh [STRATUS] [WIDTH] [RUNS]`
set -euo pipefail
stratus=${1:-build/cli/stratus} width=${2:-256} runs=${3:-3}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
TIMEFORMAT='%U %S'

# seconds COMMAND OPTION...: what it takes for $scene.
seconds() {
    local command=$1
    shift
    { time STRATUS_CACHE=$folder/cache "$stratus" "$command" "$scene" --width "$width" --quiet "$@" >/dev/null; } 2>&1 |
        awk '{ print $1 + $2 }'
}
render() { seconds render -o "$folder/picture.png" "$@"; }

printf '%-18s %6s %6s %12s %6s %6s\n' "width $width" cold warm "all effects" times "plan %"
for scene in "$(dirname "$0")"/../tables/scenes/*.toml; do
    grep -qE '^\[(lobes|lambert)\]' "$scene" && continue
    for ((run = 0; run < runs; ++run)); do
        rm -rf "$folder/cache"
        of_render="$(render) $(render) $(render --effects all --no-cache)"
        rm -rf "$folder/cache"
        echo "$of_render $(seconds plan) $(render)"
    done | awk -v name="$(basename "$scene" .toml)" '
        {
            for (k = 1; k <= 3; ++k) if (NR == 1 || $k < least[k]) least[k] = $k
            plan = 100 * ($4 + $5 - $1) / $1
            for (place = NR; place > 1 && sorted[place - 1] > plan; --place) sorted[place] = sorted[place - 1]
            sorted[place] = plan
        }
        END {
            printf "%-18s %6.2f %6.2f %12.2f %6.1f %6.0f\n", name, least[1], least[2], least[3], least[3] / least[2],
                sorted[int((NR + 1) / 2)]
        }'
done
