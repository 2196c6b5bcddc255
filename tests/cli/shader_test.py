"""stratus shader: what it writes, compiled by glslang; its refusals."""

import re

from expect import *

fixtures("full", "mixed", "family")
expect_ok("pack full.h5 -o full.stratus --quiet")


def shader(arguments, **how):
    return expect_ok("shader " + arguments, **how)


def expect_textures(folder, *names):
    """The folder has these textures, each of the bytes of its shape."""
    textures = json.loads(read(folder + "/stratus_textures.json"))["textures"]
    expect([texture["name"] for texture in textures] == ["stratus_" + name for name in names], f"other textures: {textures}")
    for texture in textures:
        values = texture["width"] * texture["height"] * texture.get("depth", 1) * texture["channels"]
        expect_near(Path(folder, texture["file"]).stat().st_size, values * {"float32": 4, "float16": 2}[texture["type"]], 0)


def expect_compiled(folder, body, light, before=""):
    """The folder's GLSL and HLSL compile with this body, whose light is this, after a definition."""
    glsl, hlsl = read(folder + "/stratus.glsl"), read(("hlsl" if folder == "glsl" else folder) + "/stratus.hlsl")
    write("es.frag", "#version 300 es", before, glsl, f"out vec4 light; void main() {{ {body} light = {light} }}")
    write("core.frag", "#version 450", before, glsl,
          f"layout(location = 0) out vec4 light; void main() {{ {body} light = {light} }}")
    write("main.hlsl", before, hlsl, f"float4 main() : SV_Target0 {{ {body} return {light} }}")
    for arguments in "es.frag", "-V core.frag -o core.spv", "-V -D -S frag -e main main.hlsl -o hlsl.spv":
        done = subprocess.run(["glslangValidator", *arguments.split()], capture_output=True, text=True)
        expect(done.returncode == 0, f"glslangValidator {arguments}: {done.stdout}")


def expect_table_compiled(folder, before=""):
    expect_compiled(
        folder,
        "StratusScattered r = stratus_reflection(0.9, 1.0, 0.5, 0.6, 1.0);"
        "StratusScattered t = stratus_transmission(0.9, 1.0, 0.5, 0.6, 1.0);"
        "float f = stratus_bsdf(vec3(0.0, 0.6, 0.8), vec3(0.0, 0.6, -0.8), 0.9, stratus_effective_depth(1.0, 0.1));"
        "float s = stratus_single(STRATUS_REFLECTION, 0.9, 1.0, 0.5, 0.6, 1.0) * stratus_hapke(0.5, 0.1, 0.2);"
        "float d = stratus_direct(1.0, 0.5) * stratus_phase(0.5);"
        "vec3 g = stratus_bsdf_rgb(vec3(0.0, 0.6, 0.8), vec3(0.0, 0.6, 0.8), vec3(0.9, 0.8, 0.7), 1.0);",
        "vec4(r.single + g.x, t.multiple, f, s * d);", before)


def expect_layer_compiled(folder, before=""):
    expect_compiled(
        folder,
        "vec3 wi = vec3(0.0, 0.6, 0.8); StratusSample d = stratus_layer_sample(wi, 0.3, 0.6, 0.9);"
        "vec3 f = stratus_layer_bsdf(wi, d.wo) / stratus_layer_pdf(wi, d.wo) + stratus_layer_direct(0.5);"
        "StratusColours c = stratus_layer_reflection(0.5, 0.6, 1.0);",
        "vec4(f + c.single, 1.0);", before)


# a table
shader("full.stratus --language glsl -o glsl", out="", err="glsl | 4 files | MB")
expect_says(read("glsl/stratus_textures.json"), '"reflection": true')
expect_textures("glsl", "numbers", "functions")
shader("full.h5 --language hlsl -o hlsl --quiet", err="")
expect_same("glsl/stratus_numbers.bin", "hlsl/stratus_numbers.bin")
expect_table_compiled("glsl")

# OSL
shader("full.stratus --language osl -o osl", err="osl: 4 files | MB")
expect_says(read("osl/stratus_textures.h"), 'STRATUS_NUMBERS "stratus_numbers.exr" | STRATUS_FUNCTIONS_HEIGHT')
code = re.sub("//.*", "", read("osl/stratus.osl.h"))
reserved = ("case char class const default double enum extern false friend inline long private protected short signed sizeof "
            "static switch template this true typedef uniform union unsigned varying virtual break closure color continue "
            "matrix normal output point public illuminate illuminance")
for pattern, text, why in [(r"[0-9]f\b", code, "OSL knows no suffix f"),
                           (r"\)\.[a-z]", code, "OSL selects components of variables alone"),
                           (rf"\b({reserved.replace(' ', '|')})\b",
                            re.sub("//.*", "", read("osl/stratus.osl.h").partition("elementary functions")[2]),
                            "a word of OSL's own")]:
    found = re.search(pattern, text)
    expect(not found, f"{why}: {found}")

# members
shader("mixed.h5 --at mixture=0.4 --language glsl -o mixed --quiet")
shader("family.h5 --at g=0.4 --language glsl -o family --quiet")

# C++: one header, and the table
shader("full.stratus --language cpp -o cpp --quiet")
expect_same("cpp/table.stratus", "full.stratus")
shader("mixed.h5 --at mixture=0.4 --language cpp -o member --quiet")
expect("family" not in read("member/table.stratus"), "a member is no family")

# one layer, bound; the same, filtered
bound = "full.stratus --optical-depth 0.5,1,2 --albedo 0.9 "
shader(bound + "--language glsl -o glsl", err="5 files")
expect_textures("glsl", "numbers", "functions", "layer")
expect_layer_compiled("glsl", "#define STRATUS_LAYER")
shader(bound + "--language glsl --filtered -o filtered", err="5 files | stratus_light: | for all but one in a thousand")
expect_textures("filtered", "numbers", "layer", "light")
shader(bound + "--language hlsl --filtered -o filtered --quiet")
expect_layer_compiled("filtered")

expect_refused(
    "full.stratus --language wgsl => --language | glsl | hlsl | osl",
    "mixed.h5 --language glsl => --at | given for mixed.h5, as in mixture=0 | got nothing",
    "full.stratus --at mixture=0.4 --language glsl => --at | left out | got mixture=0.4",
    "family.h5 --at g=0.9 --language glsl => --at g | [0.3, 0.6] | got 0.9",
    "full.stratus --language cpp --optical-depth 1 --albedo 0.9 => left out for cpp",
    "full.stratus --language glsl --albedo 0.9 => --optical-depth | --albedo",
    "full.stratus --language glsl --optical-depth 1 --albedo 0.9,0.8 => --albedo | three",
    "full.stratus --language osl --optical-depth 1 --albedo 0.9 --filtered => --filtered | glsl or hlsl | osl",
    prefix="shader -o new ")
expect_refused("shader full.stratus --at '' --language glsl -o new => --at | a member | got nothing",
               "view full.stratus --at '' -o new.html => --at | a member | got nothing")
expect_refused("shader full.stratus --language glsl -o '' => --output | the name of a folder, got nothing")
expect_refused("shader absent.stratus --language glsl -o new => absent.stratus", code=1)
if sanitized:
    finish()

# filtered, of layers that are not bound
shader("full.stratus --language glsl --filtered -o layers", err="5 files | stratus_light:")
expect_textures("layers", "numbers", "weights", "light")
shader("full.stratus --language hlsl --filtered -o layers --quiet")
expect_table_compiled("layers")
expect_table_compiled("layers", "#define STRATUS_FILTERED_PATH")
finish()
