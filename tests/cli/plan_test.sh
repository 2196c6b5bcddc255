#!/usr/bin/env bash
# stratus plan, bake, render --table: the recipes that a plan writes make the tables that its scene is rendered with, for every
# picture of the gallery that needs one. At a coarse tolerance and one ray a pixel of few, so that plans, bakes and pictures take little.
tables=$(realpath "$(dirname "$0")/../../tables")
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

cp -r "$tables" .
scenes=tables/scenes
sed -i 's/^samples = .*/samples = 1/' "$scenes"/*.toml
chains=0
for scene in "$scenes"/*.toml; do
    grep -qE '^\[(lobes|lambert)\]' "$scene" && continue
    name=$(basename "$scene" .toml)
    expect_ok plan "$scene" --width 64 --quiet --tolerance 0.05 --write "$name.toml"
    expect_says "$out" "render takes about" "tolerance 0.05"
    tables=()
    for recipe in "$name.toml" "$name"_*.toml; do
        [ -e "$recipe" ] || continue
        expect_ok bake "$recipe" -o "${recipe%.toml}.h5" --quiet --accept
        tables+=(--table "${recipe%.toml}.h5")
    done
    [ ${#tables[@]} -gt 0 ] || fail "$name must have a recipe"
    expect_ok render "$scene" -o "$name.png" "${tables[@]}" --width 32 --quiet
    chains=$((chains + 1))
done
[ $chains -ge 7 ] || fail "the gallery has seven pictures at least"

# a table without what the scene looks up is refused
expect_refused 2 "table.phase_function" "wavelength=0.55" -- render "$scenes"/fogbow.toml -o a.png --table fogbow_red.h5
finish
