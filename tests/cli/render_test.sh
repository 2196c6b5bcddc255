#!/usr/bin/env bash
# stratus render: pictures and figures from scene files, the same bytes on any number of threads; effects; a table that is
# there already; every refusal.
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

cat >slab.toml <<'SCENE'
title = "A slab"
tolerance = 0.05
[picture]
width = 12
height = 6
[camera]
position = [0.0, -4.0, 4.0]
field_of_view_deg = 60.0
[sun]
elevation_deg = 40.0
[background]
colour = [0.25, 0.5, 1.0]
[layer]
phase_function = "rayleigh"
albedo = 0.9
optical_depth = 1.0
[slab]
size = 4.0
SCENE
cat >lambert.toml <<'SCENE'
[lambert]
phase_function = "isotropic"
albedo = 1.0
optical_depth = inf
mu_in = [1.0]
SCENE

# --- answers

expect_ok render slab.toml -o one.exr -o one.png --threads 1
expect_silent "$out"
expect_says "$err" "12 x 6 pixels" "tables" "all"
[ "$(head -c 4 one.png | tail -c 3)" = PNG ] || fail "one.png must be a PNG file"
[ "$(head -c 4 one.exr | od -An -tx1 | tr -d ' ')" = 762f3101 ] || fail "one.exr must be an EXR file"
expect_says one.exr 'title = "A slab"' "relative to a white Lambert surface"
expect_ok render slab.toml -o two.exr -o two.png --threads 3 --quiet
expect_silent "$err"
expect_same one.exr two.exr
expect_same one.png two.png

# a picture tells what its plan has left of the scene's effects: asked for, they make the same picture
sed 's/albedo = 0.9/albedo = 0.01/' slab.toml >dark.toml
expect_ok render dark.toml -o dark.exr
expect_says "$err" "without multiple"
effects=$(grep -ao 'all,-[a-z_,-]*lineOrder' dark.exr)
[ -n "$effects" ] || fail "dark.exr must tell its effects"
expect_ok render dark.toml -o asked.exr --effects "${effects%lineOrder}" --quiet
expect_same asked.exr dark.exr

# without a title
sed '/^title/d; s/rayleigh/isotropic/' slab.toml >untitled.toml
expect_ok render untitled.toml -o untitled.exr
expect_says "$err" "plan: the picture: without azimuth"
expect_ok plan untitled.toml --quiet
expect_says "$out" "Simulate single" "their azimuth may be left out, without which light changes by nothing" "a sparse picture of 12 x 6 pixels, one ray each"

# a plan shows where each effect changes the scene
expect_ok plan untitled.toml --quiet --picture changes.png
[ "$(head -c 4 changes.png | tail -c 3)" = PNG ] || fail "changes.png must be a PNG file"
expect_refused 2 --picture .png "got changes.exr" -- plan untitled.toml --picture changes.exr

# what a scene names is kept, unless it is dropped
sed 's/^tolerance/effects = ["all", "multiple"]\n&/' dark.toml >named.toml
expect_ok render named.toml -o named.exr
grep -q "without multiple" "$err" && fail "multiple was named"
cmp -s named.exr dark.exr && fail "orders n >= 2 must count"
expect_ok render named.toml -o dropped.exr --drop multiple --quiet
expect_ok render dark.toml -o without.exr --effects=-multiple --quiet
for picture in dropped without; do expect_ok render dark.toml -o $picture.png --drop multiple --quiet; done
expect_same dropped.png without.png
expect_refused 2 "unknown effect 'multipel'" "'multiple'" -- render named.toml -o a.png --drop multipel

# tables are kept: the second picture is the same, bit for bit, whatever happened to the files
kept=$(find "$STRATUS_CACHE" -name '*.stratus' | head -n 1)
[ -n "$kept" ] || fail "a table must be kept"
expect_ok render slab.toml -o again.exr --quiet
expect_same again.exr one.exr
for file in "$STRATUS_CACHE"/*; do head -c 100 "$file" >damaged && cp damaged "$file"; done
expect_ok render slab.toml -o again.exr --quiet
expect_same again.exr one.exr
for file in "$STRATUS_CACHE"/*; do [ "$(wc -c <"$file")" -eq 100 ] || mended=yes; done
[ "${mended:-no}" = yes ] || fail "a damaged table must be replaced"
rm -r "$STRATUS_CACHE"
expect_ok render slab.toml -o again.exr --quiet --no-cache
expect_same again.exr one.exr
[ ! -e "$STRATUS_CACHE" ] || fail "--no-cache must keep nothing"
expect_ok render slab.toml -o again.exr --quiet --cache-limit 0
[ -z "$(ls "$STRATUS_CACHE")" ] || fail "--cache-limit 0 must keep nothing"
STRATUS_CACHE=slab.toml/folder expect_ok render slab.toml -o again.exr
expect_says "$err" "tables are not kept"
expect_same again.exr one.exr
expect_refused 2 --cache-limit "in [0," "got -1" -- render slab.toml -o a.png --cache-limit -1

# effects change the picture; without higher orders nothing is baked; a table is looked up as it is
expect_ok render slab.toml -o once.exr --effects all,-multiple --quiet
expect_says once.exr "all,-multiple"
cmp -s once.exr one.exr && fail "orders n >= 2 must count"
expect_ok render slab.toml -o nothing.exr --effects background --quiet
cmp -s nothing.exr once.exr && fail "single scattering must count"
sed 's/^tolerance/effects = ["-multiple"]\n&/' slab.toml >once.toml
expect_ok render once.toml -o named.png --quiet
expect_ok render slab.toml -o once.png --effects=-multiple --quiet
expect_same named.png once.png
cat >rayleigh.toml <<'RECIPE'
phase_function = "rayleigh"
tolerance = 0.05
optical_depth = { min = 0.5, max = 2.0 }
albedo = { min = 0.8, max = 1.0 }
RECIPE
expect_ok bake rayleigh.toml -o rayleigh.h5 --quiet
expect_ok render slab.toml -o table.png --table rayleigh.h5 --quiet

# channels with a phase function each: the plan has a recipe for each of their tables, one where two are alike
sed "s/\"rayleigh\"/['rayleigh', 'rayleigh', 'isotropic']/" slab.toml >colours.toml
expect_ok render colours.toml -o colours.png --quiet
cmp -s colours.png one.png && fail "blue must be scattered as by its own phase function"
expect_ok plan colours.toml --quiet
expect_says "$out" "layer: rayleigh" "isotropic" "One of the tables that colours.toml needs"
expect_ok plan colours.toml --quiet --write needs.toml
for colour in red blue; do expect_ok bake needs_$colour.toml -o $colour.h5 --quiet; done
expect_ok render colours.toml -o tables.png --table red.h5 --table blue.h5 --quiet
expect_same tables.png colours.png
expect_refused 2 "table.phase_function" "isotropic" "got rayleigh" -- render colours.toml -o a.png --table red.h5
expect_refused 2 --table "that the scene needs" "number 2" -- render slab.toml -o a.png --table rayleigh.h5 --table blue.h5
expect_ok plan colours.toml --quiet
[ "$(grep -c '^phase_function' "$out")" = 2 ] || fail "two recipes must be printed, green's being red's"

# another width keeps the shape; panels stand side by side
expect_ok render slab.toml -o wide.png --width 24
expect_says "$err" "24 x 12 pixels"
{ printf 'columns = 2\n'; cat slab.toml; printf '[[panels]]\ntitle = "%s"\n' first second third; } >panels.toml
expect_ok render panels.toml -o panels.png
expect_says "$err" "24 x 12 pixels"

# a film: each frame is the same whichever others are rendered, alone or with a table that its plan wrote
cat slab.toml - >film.toml <<'SCENE'
[animation]
frames = 4
[[animation.keys]]
frame = 0
sun.elevation_deg = 40.0
layer.optical_depth = 1.0
[[animation.keys]]
frame = 3
sun.elevation_deg = 70
layer.optical_depth = 4.5
SCENE
expect_ok render film.toml --frames 0:3 -o film_%02d.exr -o film_%d.png
expect_says "$err" "4 frames of 12 x 6 pixels"
for frame in 0 1 2; do cmp -s film_0$frame.exr film_0$((frame + 1)).exr && fail "frames $frame and the next must differ"; done
expect_ok render film.toml --frames 2:2 -o alone_%d.exr --no-cache --quiet
expect_same alone_2.exr film_02.exr
[ ! -e alone_1.exr ] || fail "only one frame was asked for"
expect_ok render film.toml -o first.exr
expect_says "$err" "frame 0 of 4"
expect_same first.exr film_00.exr
expect_ok plan film.toml --quiet --write film_table.toml
expect_says "$out" "tables serve all 4, each further one" "max = 4.5"
expect_ok bake film_table.toml -o film.stratus --quiet
expect_ok render film.toml --frames 3:3 -o tabled_%d.png --table film.stratus --quiet
expect_same tabled_3.png film_3.png
for range in 3 1:0 0:4 a:b 0: :3 -1:3 0:1x; do
    expect_refused 2 --frames "A:B" "within 0:3" "got $range" -- render film.toml --frames=$range -o a_%d.png
done
for name in a.png a_%d_%d.png a_%s.png a_%0d.png a_%12d.png %.png a_%; do
    expect_refused 2 --output "with one %d, or %04d" "got $name" -- render film.toml --frames 0:1 -o $name
done
expect_refused 2 --frames figures -- render lambert.toml --frames 0:0 -o a_%d.svg
sed 's/frame = 3/frame = 2/; s/= 4.5/= -1/' film.toml >film_bad.toml
expect_refused 2 "film_bad.toml, frame 2, line 28: layer.optical_depth" "got -1" -- render film_bad.toml --frames 0:1 -o a_%d.png
mkdir cut_1.exr
expect_refused 2 --output "got the folder cut_1.exr" -- render film.toml --frames 0:3 -o cut_%d.exr --quiet
[ ! -e cut_0.exr ] || fail "what cannot be written must be told before any frame"
through "$size_limited" expect_refused 1 broad_0.exr -- render film.toml --frames 0:3 -o broad_%d.exr --quiet --width 200
[ -z "$(ls | grep broad)" ] || fail "no half-written frame may remain"

# what a PNG cannot show is told
expect_ok render panels.toml -o panels.png
grep -q clipped "$err" && fail "nothing is clipped"
sed 's/^elevation_deg = 40.0/&\ncolour = 255/' slab.toml >bright.toml
expect_ok render bright.toml -o bright.png
expect_says "$err" "lit pixels are brighter than picture.white, 1, and clipped; the brightest has"
sed '/background/,+1d; s/= 40.0/= -40.0/; s/^optical_depth.*/optical_depth = inf/' slab.toml >night.toml
expect_ok render night.toml -o night.exr
expect_says "$err" "all of the picture is black"

expect_ok render lambert.toml -o lambert.svg
expect_says "$out" "largest deviation from Lambert's law" "mu_in = 1"
expect_says lambert.svg "<svg"
printf '[lobes]\nphase_function = "isotropic"\nincident_deg = [36.0]\noptical_depths = [2.0]\nalbedos = [1.0]\n' >lobes.toml
expect_ok render lobes.toml -o lobes.svg --quiet
expect_silent "$out"
expect_says lobes.svg "<svg"

# --- refusals

expect_refused 2 SCENE required -- render
expect_refused 2 --output required -- render slab.toml
expect_ok render -o first.png slab.toml --quiet
expect_same first.png one.png
expect_refused 2 --output ".png or .exr or .svg" "got a.jpg" -- render slab.toml -o a.jpg
expect_refused 2 --output ".png or .exr for pictures" "got a.svg" -- render slab.toml -o a.svg
expect_refused 2 --output ".svg for figures" "got a.png" -- render lambert.toml -o a.png
expect_refused 2 --width figures -- render lambert.toml -o a.svg --width 5
expect_refused 1 absent/a.png "no folder absent" -- render slab.toml -o absent/a.png
expect_refused 1 absent.toml -- render absent.toml -o a.png
cp slab.toml scene.png
expect_refused 2 scene.png another -- render scene.png -o scene.png
for value in -1 16385 x ''; do
    expect_refused 2 --width "in [0, 16384]" "got ${value:-nothing}" -- render slab.toml -o a.png --width "$value"
done
expect_refused 2 --threads "in [0, 1024]" -- render slab.toml -o a.png --threads 1025
expect_refused 2 "unknown effect 'shadow'" "'shadows'" -- render slab.toml -o a.png --effects shadow
expect_refused 1 absent.h5 -- render slab.toml -o a.png --table absent.h5
sed 's/rayleigh/isotropic/' slab.toml >other.toml
expect_refused 2 table.phase_function "must be isotropic" "got rayleigh" -- render other.toml -o a.png --table rayleigh.h5
sed 's/= 1.0$/= 4.0/' slab.toml >other.toml
expect_refused 2 table.optical_depth.max "at least the scene's, 4" "got 2" -- render other.toml -o a.png --table rayleigh.h5
sed 's/^white/whit/; s/^width/widht/' slab.toml >other.toml
expect_refused 2 "unknown key 'picture.widht'" "line 4" "'picture.width'" -- render other.toml -o a.png
expect_refused 2 "rayleigh.toml must be a scene, got a recipe, which is for \`stratus bake\`" -- render rayleigh.toml -o a.png
expect_refused 2 "must be a scene, got a recipe" -- plan rayleigh.toml
expect_refused 2 "slab.toml must be a recipe, got a scene, which is for \`stratus render\`" -- bake slab.toml -o a.stratus
head -c 3000 /bin/sh >other.toml
expect_refused 2 "other.toml must be TOML text, got a binary file" -- render other.toml -o a.png
expect_refused 2 SCENE "the name of a file, got nothing" -- render "" -o a.png
expect_refused 2 RECIPE "the name of a file, got nothing" -- bake "" -o a.stratus
through "$size_limited" expect_refused 1 wide.exr -- render slab.toml -o wide.exr --quiet --width 200
if [ -n "$user_refused" ]; then
    through "$user_refused" expect_refused 1 shut/new.png "cannot be written" -- render slab.toml -o shut/new.png
else
    echo "skipped: a folder that must not be written to"
fi
finish
