"""stratus view: the page, driven in Chromium: it loads without an error, sliders move its pictures, and its pixels are those
of `stratus render`."""

import base64
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "cli"))
from expect import *

if not shutil.which("chromium"):
    sys.exit("chromium was not found, in which this test opens the page; `./run test` installs it")


def browse(page, *flags):
    """Returns what a driven page reports, by name, and its document. Chromium is started again if it has not within a minute."""
    for attempt in range(3):
        command = ["timeout", "60", "chromium", "--headless", "--no-sandbox", "--disable-gpu-sandbox", "--no-first-run",
                   "--disable-dev-shm-usage", f"--user-data-dir={logs}/browser{attempt}", "--force-device-scale-factor=1",
                   "--window-size=250,400", "--virtual-time-budget=20000", *flags, "--dump-dom", f"file://{folder}/{page}"]
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", env=os.environ | {"HOME": str(logs)})
        if done.returncode != 124:
            break
    document = re.sub("</?pre[^>]*>", "", done.stdout)
    return dict(re.findall("^report (.*?) = ([^<\n]*)", document, re.M)), document


write("haze.toml", 'title = "haze <b>"', 'phase_function = "rayleigh"', "tolerance = 1e-3",
      "optical_depth = { min = 0.05, max = 4.0 }", "albedo = { min = 0.9, max = 1.0 }")
expect_ok("bake haze.toml -o haze.h5 --quiet")
expect_ok("pack haze.h5 -o haze.stratus --quiet")
expect_ok("view haze.stratus -o haze.html", out="", err="haze.html | MB")
page = read("haze.html")
expect(not re.search(r'(src|href)="?[a-z]*:?//|@import|fetch\(|XMLHttpRequest', page), "the page asks for other files")
expect("haze <b>" not in page, "the title is not escaped")

# The same pictures by the renderer, scattered once beside all orders.
picture = ["[picture]", "width = 96", "height = 96", "samples = 1", "white = 0.5",
           "[sun]", "elevation_deg = 20.0", "azimuth_deg = 50.0"]
layer = ["[layer]", 'phase_function = "rayleigh"', "albedo = 0.99", "optical_depth = 1.0"]
panels = ["[[panels]]", 'effects = ["-multiple"]', "[[panels]]"]
sphere = ["[camera]", "distance = 10.0", "elevation_deg = 10.0", "azimuth_deg = -15.0", "orthographic_width = 2.2",
          "[planet]", "surface = 0.3", *picture]
write("sphere.toml", *sphere, *layer, *panels)
write("slab.toml",
      "[camera]", "distance = 12.0", "elevation_deg = 40.0", "azimuth_deg = 30.0", "field_of_view_deg = 22.619864948040426",
      "[slab]", "surface = 0.0", "height = 0.4", "size = 3.0", *picture, *layer, *panels)
write("rings.csv", "radius,optical_depth,w1,w2", *(
    f"{radius},{depth},0.99,0" for depth, *ends in [
        (0.16, 1.24, 1.5299999), (2, 1.5300001, 1.9499999), (0.08, 1.9500001, 2.0299999), (0.8, 2.0300001, 2.27)]
    for radius in ends))
write("rings.toml",
      "[camera]", "distance = 10.0", "elevation_deg = 20.0", "azimuth_deg = 30.0", "orthographic_width = 4.9",
      "[rings]", 'profile = "rings.csv"', "surface = 0.5", *picture,
      "[layer]", 'components = ["rayleigh", "rayleigh"]',
      "[[panels]]", 'effects = ["-multiple", "-ringshine", "-planetshine"]',
      "[[panels]]", 'effects = ["-ringshine", "-planetshine"]')
for scene in "sphere", "slab", "rings":
    expect_ok(f"render {scene}.toml --table haze.stratus -o {scene}.png --quiet")


def drive(name, settings, **pictures):
    """Returns what the page NAME.html reports with the driver, which compares its scenes in these settings with pictures."""
    watch = ("<script>const pageErrors = []; addEventListener('error', (event) => pageErrors.push(event.message));"
             "console.error = console.warn = (text) => pageErrors.push(String(text));"
             "requestAnimationFrame = (draw) => setTimeout(draw, 0);</script>")
    rendered = {scene: "data:image/png;base64," + base64.b64encode(Path(file).read_bytes()).decode()
                for scene, file in pictures.items()}
    write("driven.html", read(name + ".html").replace("<head>", "<head>\n" + watch, 1),
          f"<script>const scenesToCompare = {json.dumps(settings)}; const rendered = {json.dumps(rendered)};",
          read(source / "tests/view/driver.js"), "</script>")
    reported, document = browse("driven.html", "--enable-logging=stderr", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
    expect(reported.get("errors") == "none", f"the page {name} fails: {reported} {document[-2000:]}")
    for orders in "once", "all":
        for scene in settings:
            expect(int(reported[f"{scene}-{orders}-lit"]) > 5000, f"{scene}, {orders}: hardly anything is lit")
            if scene != "rings":
                expect_near(int(reported[f"{scene}-{orders}-largest"]), 0, 1)
    return reported


def seen_from(elevation, azimuth, **more):
    return {"sun-elevation": 20, "sun-azimuth": 50, "camera-elevation": elevation, "camera-azimuth": azimuth, **more}


reported = drive(
    "haze",
    {"sphere": seen_from(10, -15, depth=0, albedo=0.9, ground=0.3, exposure=1), "slab": seen_from(40, 30, ground=0),
     "rings": seen_from(20, 30, albedo=0.9, depth=0.3010299956639812, ground=0.5)},
    sphere="sphere.png", slab="slab.png", rings="rings.png")
for orders in "once", "all":
    # The renderer takes rings by area: a quarter of these few pixels lies at an edge of them.
    expect(int(reported[f"rings-{orders}-near"]) > 0.7 * int(reported[f"rings-{orders}-lit"]), f"rings, {orders}: pixels differ")
expect(int(reported["moved"]) > 1000, "the slider of the optical depth does not move the picture")
expect_near(float(reported["depth"]), 0.5012, 1e-3)
expect_near(float(reported["turned"]), -3, 0)
expect(1.1 < float(reported["lobe"]) < 10, "lobes of all orders are not the larger ones")
# Thinner rings than the table's are extrapolated, and its tolerance says nothing of them.
expect_says(reported["zone-1"], "\u00b1 | incidence")
expect("thinner" not in reported["zone-1"], "rings of the table's own depth seem to be thinner")
expect_says(reported["zone-0"], "thinner than the table, which begins at depth 0.0496")
expect("\u00b1" not in reported["zone-0"], "the tolerance is stated of rings thinner than the table's")

# What is lit from above alone: a stack, and the haze in a table over the ground that the renderer puts beneath it.
write("layers.toml", "tolerance = 2e-3",
      "[[layers]]", 'phase_function = "rayleigh"', "albedo = 1.0", "optical_depth = 0.3",
      "[[layers]]", 'phase_function = "henyey_greenstein:g=0.5"', "albedo = 0.9", "optical_depth = 0.7")
write("grounded.toml", 'phase_function = "rayleigh"', "tolerance = 1e-3", "optical_depth = { min = 0.5, max = 2.0 }",
      "albedo = { min = 0.95, max = 1.0 }", "[below]", "lambert_albedo = 0.3")
for table in "layers", "grounded":
    expect_ok(f"bake {table}.toml -o {table}.h5 --quiet")
    expect_ok(f"view {table}.h5 -o {table}.html --quiet")
expect_ok("shader layers.h5 --language glsl -o layers", err="5 files")  # a stack is bound without being asked for
write("stack_sphere.toml", *sphere, "[layer]", 'stack = "layers.toml"', *panels)
expect_ok("render stack_sphere.toml --table layers.h5 -o stack_sphere.png --quiet")
reported = drive("layers", {"sphere": seen_from(10, -15, ground=0.3, exposure=1)}, sphere="stack_sphere.png")
expect(reported["scenes"] == "sphere,slab,lobes", "a stack has other scenes")
reported = drive("grounded", {"sphere": seen_from(10, -15, depth=0, albedo=0.9, exposure=1)}, sphere="sphere.png")
expect(reported["scenes"] == "sphere,lobes", "a table over ground has other scenes")

document = browse("haze.html", "--disable-gpu", "--disable-3d-apis")[1]
expect_says(document, '<p id="notice" role="alert">This browser offers no WebGL2')

fixtures("mixed", "family", "endless")
expect_refused(
    "haze.stratus -o haze.htm => --output | .html | haze.htm",
    "mixed.h5 -o new.html => --at | given for mixed.h5, as in mixture=0 | got nothing",
    "haze.h5 --at mixture=0.5 -o new.html => --at | left out | got mixture=0.5",
    "endless.h5 -o new.html => TABLE | of both sides", prefix="view ")
expect_refused("view absent.stratus -o new.html => absent.stratus", code=1)
for table, at, told in ("mixed", "mixture=0.4", "0.6*isotropic"), ("family", "g=0.45", "henyey_greenstein:g=0.45"):
    expect_ok(f"view {table}.h5 --at {at} -o {table}.html --quiet")
    expect_says(read(table + ".html"), told)
finish()
