"""stratus render: pictures and figures from scene files, the same bytes on any number of threads; effects; a table that is
there already; every refusal."""

import re

from expect import *

write("slab.toml",
      'title = "A slab"',
      "tolerance = 0.05",
      "[picture]",
      "width = 12",
      "height = 6",
      "[camera]",
      "position = [0.0, -4.0, 4.0]",
      "field_of_view_deg = 60.0",
      "[sun]",
      "elevation_deg = 40.0",
      "[background]",
      "colour = [0.25, 0.5, 1.0]",
      "[layer]",
      'phase_function = "rayleigh"',
      "albedo = 0.9",
      "optical_depth = 1.0",
      "[slab]",
      "size = 4.0")
write("lambert.toml", "[lambert]", 'phase_function = "isotropic"', "albedo = 1.0", "optical_depth = inf", "mu_in = [1.0]")
cache = logs / "cache"


def render(arguments, **how):
    return expect_ok("render " + arguments, **how)


def begins(name, bytes):
    expect(Path(name).read_bytes().startswith(bytes), f"{name} must begin with {bytes}")


# --- answers

render("slab.toml -o one.exr -o one.png --threads 1", out="", err="12 x 6 pixels | tables | all")
begins("one.png", b"\x89PNG")
begins("one.exr", b"\x76\x2f\x31\x01")
expect_says(read("one.exr"), 'title = "A slab" | relative to a white Lambert surface')
render("slab.toml -o two.exr -o two.png --threads 3 --quiet", err="")
expect_same("one.exr", "two.exr")
expect_same("one.png", "two.png")

# a picture tells what its plan has left of the scene's effects: asked for, they make the same picture
edit("slab.toml", "dark.toml", ("albedo = 0.9", "albedo = 0.01"))
render("dark.toml -o dark.exr", err="without multiple")
effects = re.search("(all,-[a-z_,-]*)lineOrder", re.sub(r"[^\x20-\x7e]", "", read("dark.exr")))[1]
render(f"dark.toml -o asked.exr --effects {effects} --quiet")
expect_same("asked.exr", "dark.exr")

# without a title
edit("slab.toml", "untitled.toml", ('title = "A slab"\n', ""), ("rayleigh", "isotropic"))
render("untitled.toml -o untitled.exr", err="plan: the picture: without azimuth")
# a plan shows where each effect changes the scene
expect_ok("plan untitled.toml --quiet --picture changes.png", out=(
    "Simulate single | their azimuth may be left out, without which light changes by nothing | "
    "a sparse picture of 12 x 6 pixels, one ray each"))
begins("changes.png", b"\x89PNG")
# and names what shows nowhere
edit("untitled.toml", "deep.toml", ("optical_depth = 1.0", "optical_depth = 1e4"))
expect_ok("plan deep.toml --quiet", out="light changes by nothing; transmission and background show nowhere (tolerance")

# what a scene names is kept, unless it is dropped
edit("dark.toml", "named.toml", ("tolerance", 'effects = ["all", "multiple"]\ntolerance'))
expect("without multiple" not in render("named.toml -o named.exr").err, "multiple was named")
expect_differ("named.exr", "dark.exr", "orders n >= 2 must count")
render("named.toml -o dropped.png --drop multiple --quiet")
render("dark.toml -o without.png --drop multiple --quiet")
expect_same("dropped.png", "without.png")

# tables are kept: the second picture is the same, bit for bit, whatever happened to the files
expect(list(cache.glob("*.stratus")), "a table must be kept")


def expect_again(flags="", **how):
    render("slab.toml -o again.exr " + flags, **how)
    expect_same("again.exr", "one.exr")


expect_again()
for file in cache.iterdir():
    file.write_bytes(file.read_bytes()[:100])
expect_again()
expect(any(file.stat().st_size != 100 for file in cache.iterdir()), "a damaged table must be replaced")
shutil.rmtree(cache)
expect_again("--no-cache")
expect(not cache.exists(), "--no-cache must keep nothing")
expect_again("--cache-limit 0")
expect(not list(cache.iterdir()), "--cache-limit 0 must keep nothing")
expect_again(env=os.environ | {"STRATUS_CACHE": "slab.toml/folder"}, err="tables are not kept")

# effects change the picture; without higher orders nothing is baked; a table is looked up as it is
render("slab.toml -o once.exr --effects all,-multiple --quiet")
expect_says(read("once.exr"), "all,-multiple")
expect_differ("once.exr", "one.exr", "orders n >= 2 must count")
render("slab.toml -o nothing.exr --effects background --quiet")
expect_differ("nothing.exr", "once.exr", "single scattering must count")
edit("slab.toml", "once.toml", ("tolerance", 'effects = ["-multiple"]\ntolerance'))
render("once.toml -o named.png --quiet")
render("slab.toml -o once.png --effects=-multiple --quiet")
expect_same("named.png", "once.png")
write("rayleigh.toml", 'phase_function = "rayleigh"', "tolerance = 0.05", "optical_depth = { min = 0.5, max = 2.0 }",
      "albedo = { min = 0.8, max = 1.0 }")
expect_ok("bake rayleigh.toml -o rayleigh.h5 --quiet")
render("slab.toml -o table.png --table rayleigh.h5 --quiet")

# channels with a phase function each: the plan has a recipe for each of their tables, one where two are alike
edit("slab.toml", "colours.toml", ('"rayleigh"', "['rayleigh', 'rayleigh', 'isotropic']"))
render("colours.toml -o colours.png --quiet")
expect_differ("colours.png", "one.png", "blue must be scattered as by its own phase function")
said = expect_ok("plan colours.toml --quiet", out="layer: rayleigh | isotropic | One of the tables that colours.toml needs")
expect(said.out.count("\nphase_function") == 4, "two recipes a light path must be printed, green's being red's")
expect_ok("plan colours.toml --quiet --write needs.toml")
for table in "red", "blue", "fluxes_red", "fluxes_blue":
    expect_ok(f"bake needs_{table}.toml -o {table}.h5 --quiet")
render("colours.toml -o tables.png --table red.h5 --table blue.h5 --table fluxes_red.h5 --table fluxes_blue.h5 --quiet")
expect_same("tables.png", "colours.png")

# another width keeps the shape; panels stand side by side
render("slab.toml -o wide.png --width 24", err="24 x 12 pixels")
write("panels.toml", "columns = 2", read("slab.toml"), *(f'[[panels]]\ntitle = "{title}"' for title in ("1", "2", "3")))
said = render("panels.toml -o panels.png", err="24 x 12 pixels")
expect("clipped" not in said.err, "nothing is clipped")

# a film: each frame is the same whichever others are rendered, alone or with a table that its plan wrote
write("film.toml", read("slab.toml"),
      "[animation]",
      "frames = 4",
      "[[animation.keys]]",
      "frame = 0",
      "sun.elevation_deg = 40.0",
      "layer.optical_depth = 1.0",
      "[[animation.keys]]",
      "frame = 3",
      "sun.elevation_deg = 70",
      "layer.optical_depth = 4.5")
render("film.toml --frames 0:3 -o film_%02d.exr -o film_%d.png", err="4 frames of 12 x 6 pixels")
for frame in range(3):
    expect_differ(f"film_0{frame}.exr", f"film_0{frame + 1}.exr", "frames must differ")
render("film.toml --frames 2:2 -o alone_%d.exr --no-cache --quiet")
expect_same("alone_2.exr", "film_02.exr")
expect(not Path("alone_1.exr").exists(), "only one frame was asked for")
render("film.toml -o first.exr", err="frame 0 of 4")
expect_same("first.exr", "film_00.exr")
expect_ok("plan film.toml --quiet --write film_table.toml", out="tables serve all 4, each further one | max = 4.5")
for path in "", "_fluxes":
    expect_ok(f"bake film_table{path}.toml -o film{path}.stratus --quiet")
render("film.toml --frames 3:3 -o tabled_%d.png --table film.stratus --table film_fluxes.stratus --quiet")
expect_same("tabled_3.png", "film_3.png")
edit("film.toml", "film_bad.toml", ("frame = 3", "frame = 2"), ("= 4.5", "= -1"))
Path("cut_1.exr").mkdir()
expect_refused(
    *(f"film.toml --frames={frames} -o a_%d.png => --frames | A:B | within 0:3 | got {frames}"
      for frames in ("3", "1:0", "0:4", "a:b", "0:", ":3", "-1:3", "0:1x")),
    *(f"film.toml --frames 0:1 -o {name} => --output | with one %d, or %04d | got {name}"
      for name in ("a.png", "a_%d_%d.png", "a_%s.png", "a_%0d.png", "a_%12d.png", "%.png", "a_%")),
    "lambert.toml --frames 0:0 -o a_%d.svg => --frames | figures",
    "film_bad.toml --frames 0:1 -o a_%d.png => film_bad.toml, frame 2, line 29: layer.optical_depth | got -1",
    "film.toml --frames 0:3 -o cut_%d.exr --quiet => --output | got the folder cut_1.exr",  # before any frame
    prefix="render ")
expect_refused("render film.toml --frames 0:3 -o broad_%d.exr --quiet --width 200 => broad_0.exr", code=1, **size_limited())

# what a PNG cannot show is told
edit("slab.toml", "bright.toml", ("elevation_deg = 40.0", "elevation_deg = 40.0\ncolour = 255"))
render("bright.toml -o bright.png", err="lit pixels are brighter than picture.white, 1, and clipped; the brightest has")

# each panel is shown over its own white
whites = [read("slab.toml") + f"[[panels]]\n[[panels]]\n{own}\n"
          for own in ("picture.white = 0.25", "sun.colour = 4\nbackground.colour = [1.0, 2.0, 4.0]", "picture.white = 0.01\n[[panels]]\npicture.white = 0.02")]
for name, text in zip(("white", "bright_panel", "clipped"), whites):
    write(f"{name}.toml", text)
render("white.toml -o white.png --quiet")
render("bright_panel.toml -o bright_panel.png --quiet")
expect_same("white.png", "bright_panel.png")
render("clipped.toml -o clipped.png", err="% of all lit pixels are brighter than picture.white of their panel and clipped")
edit("slab.toml", "night.toml", ("[background]\ncolour = [0.25, 0.5, 1.0]\n", ""), ("= 40.0", "= -40.0"),
     ("optical_depth = 1.0", "optical_depth = inf"))
render("night.toml -o night.exr", err="all of the picture is black")

render("lambert.toml -o lambert.svg", out="largest deviation from Lambert's law | mu_in = 1")
write("lobes.toml", "[lobes]", 'phase_function = "isotropic"', "incident_deg = [36.0]", "optical_depths = [2.0]", "albedos = [1.0]")
render("lobes.toml -o lobes.svg --quiet", out="")
for figure in "lambert.svg", "lobes.svg":
    expect_svg(figure)

# --- refusals

render("-o first.png slab.toml --quiet")
expect_same("first.png", "one.png")
shutil.copy("slab.toml", "scene.png")
edit("slab.toml", "isotropic.toml", ("rayleigh", "isotropic"))
edit("slab.toml", "deep.toml", ("optical_depth = 1.0", "optical_depth = 4.0"))
edit("slab.toml", "misspelt.toml", ("width", "widht"))
Path("binary.toml").write_bytes(Path("/bin/sh").read_bytes()[:3000])
expect_refused(
    "render => SCENE | required",
    "render slab.toml => --output | required",
    "render slab.toml -o a.jpg => --output | .png or .exr or .svg | got a.jpg",
    "render slab.toml -o a.svg => --output | .png or .exr for pictures | got a.svg",
    "render lambert.toml -o a.png => --output | .svg for figures | got a.png",
    "render lambert.toml -o a.svg --width 5 => --width | figures",
    "render scene.png -o scene.png => scene.png | another",
    "render isotropic.toml -o a.png --table rayleigh.h5 => table.phase_function | must be isotropic | got rayleigh",
    "render colours.toml -o a.png --table red.h5 --table fluxes_red.h5 => table.phase_function | isotropic | got rayleigh",
    "render deep.toml -o a.png --table rayleigh.h5 => table.optical_depth.max | at least the scene's, 4 | got 2",
    "render misspelt.toml -o a.png => unknown key 'picture.widht' | line 4 | 'picture.width'",
    "render named.toml -o a.png --drop multipel => unknown effect 'multipel' | 'multiple'",
    "render rayleigh.toml -o a.png => rayleigh.toml must be a scene, got a recipe, which is for `stratus bake`",
    "plan rayleigh.toml => must be a scene, got a recipe",
    "plan untitled.toml --picture changes.exr => --picture | .png | got changes.exr",
    "bake slab.toml -o a.stratus => slab.toml must be a recipe, got a scene, which is for `stratus render`",
    "render binary.toml -o a.png => binary.toml must be TOML text, got a binary file",
    "render '' -o a.png => SCENE | the name of a file, got nothing",
    "bake '' -o a.stratus => RECIPE | the name of a file, got nothing")
expect_refused(
    *(f"--width '{value}' => --width | in [0, 16384] | got {value or 'nothing'}" for value in ("-1", "16385", "x", "")),
    "--threads 1025 => --threads | in [0, 1024]",
    "--cache-limit -1 => --cache-limit | in [0, | got -1",
    "--drop '' => --drop: must be names of effects, got nothing",
    "--effects '' => --effects: must be names of effects, got nothing",
    "--frames '' => --frames: must be frames, as A:B, got nothing",
    "--effects shadow => unknown effect 'shadow' | 'shadows'",
    "--table rayleigh.h5 --table blue.h5 => --table | that the scene needs | number 2", prefix="render slab.toml -o a.png ")
expect_refused(
    "slab.toml -o absent/a.png => absent/a.png | no folder absent",
    "absent.toml -o a.png => absent.toml",
    "slab.toml -o a.png --table absent.h5 => absent.h5", prefix="render ", code=1)
expect_refused("render slab.toml -o wide.exr --quiet --width 200 => wide.exr", code=1, **size_limited())
if where_permitted(user_refused):
    expect_refused("render slab.toml -o shut/new.png => shut/new.png | cannot be written", code=1, **user_refused)
finish()
