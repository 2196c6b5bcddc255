#!/usr/bin/env bash
# CPU seconds that each picture of the gallery takes, the least of several runs: with an empty cache, with the tables it kept, and
# with every effect and no cache; and how many times faster the second is than the last.
# `bench/gallery.sh [STRATUS] [WIDTH] [RUNS]`
#
# What a plan takes beside the choices that the first picture finds, in hundredths of that picture, by instructions, which valgrind
# counts: times scatter by more than it. Minutes for each picture.
# `bench/gallery.sh --plan [STRATUS] [WIDTH]`
set -euo pipefail
plan=no
if [ "${1:-}" = --plan ]; then
    plan=yes
    shift
fi
stratus=${1:-build/cli/stratus} width=${2:-256} runs=${3:-3}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export STRATUS_CACHE=$folder/cache
TIMEFORMAT='%U %S'

# seconds COMMAND OPTION...: what it takes for $scene.
seconds() {
    local command=$1
    shift
    { time "$stratus" "$command" "$scene" --width "$width" --quiet "$@" >/dev/null; } 2>&1 | awk '{ print $1 + $2 }'
}
# instructions COMMAND OPTION...: how many that are.
instructions() {
    local command=$1
    shift
    valgrind --tool=callgrind --callgrind-out-file=/dev/null "$stratus" "$command" "$scene" --width "$width" --quiet "$@" \
        2>&1 >/dev/null | awk '/Collected/ { print $NF }'
}
picture=(render -o "$folder/picture.png")

measure_seconds() {
    for ((run = 0; run < runs; ++run)); do
        rm -rf "$folder/cache"
        echo "$(seconds "${picture[@]}") $(seconds "${picture[@]}") $(seconds "${picture[@]}" --effects all --no-cache)"
    done | awk -v name="$1" '
        { for (k = 1; k <= 3; ++k) if (NR == 1 || $k < least[k]) least[k] = $k }
        END { printf "%-18s %6.2f %6.2f %12.2f %6.1f\n", name, least[1], least[2], least[3], least[3] / least[2] }'
}
measure_plan() {
    local first
    rm -rf "$folder/cache"
    first=$(instructions "${picture[@]}")
    rm -rf "$folder/cache"
    echo "$1 $first $(instructions plan) $(instructions "${picture[@]}")" |
        awk '{ printf "%-18s %12.2f %8.1f\n", $1, $2 / 1e9, 100 * ($3 + $4 - $2) / $2 }'
}

if [ $plan = yes ]; then
    printf '%-18s %12s %8s\n' "width $width" "10^9 picture" "plan %"
else
    printf '%-18s %6s %6s %12s %6s\n' "width $width" cold warm "all effects" times
fi
for scene in "$(dirname "$0")"/../tables/scenes/*.toml; do
    grep -qE '^\[(lobes|lambert)\]' "$scene" && continue
    name=$(basename "$scene" .toml)
    if [ $plan = yes ]; then measure_plan "$name"; else measure_seconds "$name"; fi
done
