#!/usr/bin/env bash
# stratus view: the page, driven in Chromium: it loads without an error, sliders move its pictures, and its pixels are those
# of `stratus render`.
driver=$(dirname "$(realpath "$0")")/driver.js
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/../cli/expect.sh"

command -v chromium >/dev/null || {
    echo "chromium was not found, in which this test opens the page; \`./run test\` installs it" >&2
    exit 1
}

# browse PAGE FLAGS...: what a driven page reports, and its notice. Chromium that has not started after a minute is started again.
browse() {
    local page=$1 code=124 try
    shift
    for try in 1 2 3; do
        [ $code -eq 124 ] || break
        HOME=$logs timeout 60 chromium --headless --no-sandbox --disable-gpu-sandbox --no-first-run --disable-dev-shm-usage --user-data-dir="$logs/browser$try" \
            --force-device-scale-factor=1 --window-size=250,400 --virtual-time-budget=20000 "$@" \
            --dump-dom "file://$folder/$page" >"$logs/document.html" 2>"$logs/browser.txt"
        code=$?
    done
    grep -aE '^(<pre id="report">)?report |id="notice"' "$logs/document.html" | sed 's/<[/]*pre[^>]*>//g' >"$out"
    grep -a CONSOLE "$logs/browser.txt" >"$err"
}

cat >haze.toml <<'TOML'
title = "haze <b>"
phase_function = "rayleigh"
tolerance = 1e-3
optical_depth = { min = 0.05, max = 4.0 }
albedo = { min = 0.9, max = 1.0 }
TOML
expect_ok bake haze.toml -o haze.h5 --quiet
expect_ok pack haze.h5 -o haze.stratus --quiet
expect_ok view haze.stratus -o haze.html
expect_silent "$out"
expect_says "$err" haze.html MB
grep -qE '(src|href)="?[a-z]*:?//|@import|fetch\(|XMLHttpRequest' haze.html && fail "the page asks for other files"
grep -qF 'haze <b>' haze.html && fail "the title is not escaped"

# The same pictures by the renderer, scattered once beside all orders.
picture='[picture]
width = 96
height = 96
samples = 1
white = 0.5
[sun]
elevation_deg = 20.0
azimuth_deg = 50.0
[layer]
phase_function = "rayleigh"
albedo = 0.99
optical_depth = 1.0'
panels='[[panels]]
effects = ["-multiple"]
[[panels]]'
cat >sphere.toml <<TOML
[camera]
distance = 10.0
elevation_deg = 10.0
azimuth_deg = -15.0
orthographic_width = 2.2
[planet]
surface = 0.3
$picture
$panels
TOML
cat >slab.toml <<TOML
[camera]
distance = 12.0
elevation_deg = 40.0
azimuth_deg = 30.0
field_of_view_deg = 22.619864948040426
[slab]
surface = 0.0
height = 0.4
size = 3.0
$picture
$panels
TOML
cat >rings.csv <<'CSV'
radius,optical_depth,w1,w2
1.24,0.16,0.99,0
1.5299999,0.16,0.99,0
1.5300001,2,0.99,0
1.9499999,2,0.99,0
1.9500001,0.08,0.99,0
2.0299999,0.08,0.99,0
2.0300001,0.8,0.99,0
2.27,0.8,0.99,0
CSV
cat >rings.toml <<TOML
[camera]
distance = 10.0
elevation_deg = 20.0
azimuth_deg = 30.0
orthographic_width = 4.9
[rings]
profile = "rings.csv"
surface = 0.5
${picture%%phase_function*}components = ["rayleigh", "rayleigh"]
${panels/\"-multiple\"/\"-multiple\", \"-ringshine\", \"-planetshine\"}
effects = ["-ringshine", "-planetshine"]
TOML
for scene in sphere slab rings; do
    expect_ok render $scene.toml --table haze.stratus -o $scene.png --quiet
done
# drive NAME SCENES...: the page NAME.html with the driver and what it is to compare, `settings` and pictures of the renderer.
drive() {
    local name=$1 scene
    shift
    {
        sed '/^<head>$/a <script>const pageErrors = []; addEventListener("error", (event) => pageErrors.push(event.message)); \
            console.error = console.warn = (text) => pageErrors.push(String(text)); \
            requestAnimationFrame = (draw) => setTimeout(draw, 0);</script>' "$name.html"
        echo "<script>const scenesToCompare = { $settings }; const rendered = {"
        for scene in "$@"; do echo "${scene##*_}: \"data:image/png;base64,$(base64 -w 0 "$scene.png")\","; done
        echo '};'
        cat "$driver"
        echo '</script>'
    } >driven.html
    browse driven.html --enable-logging=stderr --use-angle=swiftshader --enable-unsafe-swiftshader
    expect_says "$out" 'report errors = none'
}
reported() { sed -n "s/^report $1 = //p" "$out"; }
seen_from='"sun-elevation": 20, "sun-azimuth": 50, "camera-elevation": 10, "camera-azimuth": -15'
settings="sphere: { depth: 0, albedo: 0.9, ground: 0.3, exposure: 1, $seen_from },
slab: { ground: 0, \"sun-elevation\": 20, \"sun-azimuth\": 50, \"camera-elevation\": 40, \"camera-azimuth\": 30 },
rings: { albedo: 0.9, depth: Math.log10(2), ground: 0.5, \"sun-elevation\": 20, \"sun-azimuth\": 50, \"camera-elevation\": 20, \"camera-azimuth\": 30 }"
drive haze sphere slab rings
for orders in once all; do
    for scene in sphere slab; do expect_near "$(reported $scene-$orders-largest)" 0 1; done
    # The renderer takes rings by area: a quarter of these few pixels lies at an edge of them.
    [ "$(reported rings-$orders-near)" -gt $((7 * $(reported rings-$orders-lit) / 10)) ] || fail "rings, $orders: pixels differ"
    for scene in sphere slab rings; do
        [ "$(reported $scene-$orders-lit)" -gt 5000 ] || fail "$scene, $orders: hardly anything is lit"
    done
done
[ "$(reported moved)" -gt 1000 ] || fail "the slider of the optical depth does not move the picture"
expect_near "$(reported depth)" 0.5012 1e-3
expect_near "$(reported turned)" -3 0
awk -v ratio="$(reported lobe)" 'BEGIN { exit !(ratio > 1.1 && ratio < 10) }' || fail "lobes of all orders are not the larger ones"

# What is lit from above alone: a stack, and the haze in a table over the ground that the renderer puts beneath it.
cat >layers.toml <<'TOML'
tolerance = 2e-3
[[layers]]
phase_function = "rayleigh"
albedo = 1.0
optical_depth = 0.3
[[layers]]
phase_function = "henyey_greenstein:g=0.5"
albedo = 0.9
optical_depth = 0.7
TOML
cat >grounded.toml <<'TOML'
phase_function = "rayleigh"
tolerance = 1e-3
optical_depth = { min = 0.5, max = 2.0 }
albedo = { min = 0.95, max = 1.0 }
[below]
lambert_albedo = 0.3
TOML
for table in layers grounded; do
    expect_ok bake $table.toml -o $table.h5 --quiet
    expect_ok view $table.h5 -o $table.html --quiet
done
expect_ok shader layers.h5 --language glsl -o layers
expect_says "$err" "5 files"  # a stack is bound without being asked for
sed '/^phase_function/d; /^albedo/d; s/^optical_depth.*/stack = "layers.toml"/' sphere.toml >stack_sphere.toml
expect_ok render stack_sphere.toml --table layers.h5 -o stack_sphere.png --quiet
check_sphere() {
    drive "$@"
    for orders in once all; do
        expect_near "$(reported sphere-$orders-largest)" 0 1
        [ "$(reported sphere-$orders-lit)" -gt 5000 ] || fail "$1, $orders: hardly anything is lit"
    done
    expect_says "$out" "report scenes = ${scenes?}"
}
settings="sphere: { ground: 0.3, exposure: 1, $seen_from }" scenes=sphere,slab,lobes check_sphere layers stack_sphere
settings="sphere: { depth: 0, albedo: 0.9, exposure: 1, $seen_from }" scenes=sphere,lobes check_sphere grounded sphere

browse haze.html --disable-gpu --disable-3d-apis
expect_says "$out" '<p id="notice" role="alert">This browser offers no WebGL2'

expect_refused 2 --output .html haze.htm -- view haze.stratus -o haze.htm
expect_refused 1 absent.stratus -- view absent.stratus -o new.html
"$make_fixture" mixed mixed.h5
expect_refused 2 --at "given for mixed.h5, as in mixture=0" "got nothing" -- view mixed.h5 -o new.html
expect_refused 2 --at "left out" "got mixture=0.5" -- view haze.h5 --at mixture=0.5 -o new.html
expect_ok view mixed.h5 --at mixture=0.4 -o mixed.html --quiet
grep -qF '0.6*isotropic' mixed.html || fail "the page does not tell the mixture"
"$make_fixture" family family.h5
expect_ok view family.h5 --at g=0.45 -o family.html --quiet
grep -qF 'henyey_greenstein:g=0.45' family.html || fail "the page does not tell the member"
"$make_fixture" endless endless.h5
expect_refused 2 TABLE "of both sides" -- view endless.h5 -o new.html
finish
