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

# browse PAGE FLAGS...: what a driven page reports, and its notice. Chromium that has not started after a minute gets another.
browse() {
    local page=$1 code=124 try
    shift
    for try in 1 2; do
        [ $code -eq 124 ] || break
        HOME=$logs timeout 60 chromium --headless --no-sandbox --disable-gpu-sandbox --user-data-dir="$logs/browser$try" \
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
{
    sed '/^<head>$/a <script>const pageErrors = []; addEventListener("error", (event) => pageErrors.push(event.message)); \
        console.error = console.warn = (text) => pageErrors.push(String(text)); \
        requestAnimationFrame = (draw) => setTimeout(draw, 0);</script>' haze.html
    echo '<script>const scenesToCompare = {
sphere: { depth: 0, albedo: 0.9, ground: 0.3, exposure: 1, "sun-elevation": 20, "sun-azimuth": 50, "camera-elevation": 10, "camera-azimuth": -15 },
slab: { ground: 0, "sun-elevation": 20, "sun-azimuth": 50, "camera-elevation": 40, "camera-azimuth": 30 },
rings: { albedo: 0.9, depth: Math.log10(2), ground: 0.5, "sun-elevation": 20, "sun-azimuth": 50, "camera-elevation": 20, "camera-azimuth": 30 } };
const rendered = {'
    for scene in sphere slab rings; do echo "$scene: \"data:image/png;base64,$(base64 -w 0 $scene.png)\","; done
    echo '};'
    cat "$driver"
    echo '</script>'
} >driven.html
browse driven.html --enable-logging=stderr --use-angle=swiftshader --enable-unsafe-swiftshader
reported() { sed -n "s/^report $1 = //p" "$out"; }
expect_says "$out" 'report errors = none'
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

browse haze.html --disable-gpu --disable-3d-apis
expect_says "$out" '<p id="notice" role="alert">This browser offers no WebGL2'

expect_refused 2 --output .html haze.htm -- view haze.stratus -o haze.htm
expect_refused 1 absent.stratus -- view absent.stratus -o new.html
"$make_fixture" mixed mixed.h5
expect_refused 2 TABLE "of one phase function" "a mixture axis" -- view mixed.h5 -o new.html
"$make_fixture" endless endless.h5
expect_refused 2 TABLE "of both sides" -- view endless.h5 -o new.html
finish
