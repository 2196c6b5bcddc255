#!/usr/bin/env bash
# --keys prints what the pages show, and what is refused names file and line.
# shellcheck source=tests/cli/expect.sh
docs=$(realpath "$(dirname "$0")/../../docs")
source "$(dirname "$0")/expect.sh"

# expect_page PAGE: its table of keys has the columns of the last answer
expect_page() {
    awk -F ' [|] ' 'NF == 6 { sub(/^[|] /, ""); sub(/ [|]$/, ""); gsub(/`/, ""); gsub(/ [|] /, "\t"); print }' "$docs/$1" |
        grep -v '^---' >"$logs/page"
    sed 's/   */\t/g' "$out" >"$logs/columns"
    diff "$logs/columns" "$logs/page" >"$err" || fail "docs/$1 must show the keys that the program prints"
}

expect_ok render --keys
expect_silent "$err"
expect_says "$out" "camera.field_of_view_deg" degrees "[1e-3, 170]" layer.opposition.law
expect_page scenes.md
expect_ok bake --keys
expect_says "$out" discretisation.mu_samples "[4, 512]" optical_depth.max "or inf"
expect_page recipes.md

cat >rings.csv <<'ROWS'
radius,optical_depth,w1,w2
1.2,1,0.6,0.2
1.1,1,0.6,0.2
ROWS
cat >rings.toml <<'SCENE'
[camera]
distance = 10.0
field_of_view_deg = 20.0
[sun]
elevation_deg = 20.0
[layer]
components = ["isotropic", "rayleigh"]
[rings]
profile = "rings.csv"
surface = { image = "absent.png" }
SCENE
expect_refused 2 "rings.toml, line 9: rings.profile: rings.csv, line 3: radius must be above" "got 1.1" -- \
    render rings.toml -o a.png
sed -i 's/^1.1/1.3/' rings.csv
expect_refused 1 "rings.toml, line 10: rings.surface.image: " absent.png -- render rings.toml -o a.png
printf '[[panels]]\nrings.inner = 1.9\n' >>rings.toml
sed -i 's/^surface.*/surface = 0.5/' rings.toml
expect_refused 2 "rings.toml, line 12: rings.inner must be within the profile" "got 1.9" -- render rings.toml -o a.png
finish
