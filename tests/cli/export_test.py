"""stratus export: every format of tables and stacks, what it says, and every refusal."""

import re
import struct

from expect import *

stacks = source / "tables/stacks"
examples = source / "docs/examples"
fixtures("full", "mixed", "family")
layer = "--optical-depth 1 --albedo 0.9 --nodes 16"


def export(arguments, **how):
    return expect_ok("export " + arguments, **how)


def begins(name, bytes):
    expect(Path(name).read_bytes().startswith(bytes), f"{name} must begin with {bytes}")


# --- every format

beam = "note: the beam straight through, exp(-tau/mu) with tau = 1, is not in the file"
export(f"full.h5 {layer} --format fourier -o m.bsdf", out="",
       err=beam + " | m.bsdf:  |  MB in  | R and T within | as estimated (")
begins("m.bsdf", b"SCATFUN")
export(f"full.h5 {layer} --format tensor -o m.bsdf --quiet", err="")
begins("m.bsdf", b"tensor_file\0")
export(f"full.h5 {layer} --format tensor-rgb -o m.bsdf", err="diffuse transmission is not in the file")
export(f"full.h5 {layer} --format netcdf -o m.nc")
begins("m.nc", b"\x89HDF")
export(f"full.h5 {layer} --format exr-atlas -o m.exr --title 'A layer'")
expect_says(read("m.json"), '"format": "stratus-atlas" | "material": "A layer. ')
export(f"full.h5 {layer} --format slice -o m.safetensors --title 'A layer'", err=beam)
expect_says(read("m.safetensors"), '"format":"stratus-slice" | "material":"A layer.  | "transmission_multiple":')


def write_stack(name, phase_function):
    write(name, "[[layers]]", "phase_function = " + phase_function, "albedo = 0.9", "optical_depth = 1.0")


low, high = '"henyey_greenstein:g=0.35"', '"henyey_greenstein:g=0.4"'
write_stack("0.35.toml", low)
write_stack("0.4.toml", high)
write_stack("coloured.toml", f"[{low}, {high}, {low}]")
haze = stacks / "haze_over_ground.toml"
write("free.toml", read(haze).partition("\n[below]")[0])
expect_ok("bake free.toml -o stack.stratus --accept --quiet")

# --- refusals

expect_ok("export --help", out="stratus export baked/saturn_rings.stratus | solved again | fourier | exr-atlas")
expect_refused(
    "--optical-depth 1 --albedo 1 --format paint -o new.bsdf => --format | paint",
    "--optical-depth 1 --albedo 1 --format fourier -o new.nc => --output | .bsdf | new.nc",
    "--optical-depth 1 --albedo 1 --format slice -o new.stratus => --output | .safetensors | new.stratus",
    "--optical-depth 1 --albedo 1,1,1 --format netcdf -o new.nc => colours of netcdf | 3", prefix="export full.h5 ")
expect_refused(
    "full.h5 --optical-depth=-1 --albedo 1 => --optical-depth | [0, inf] | -1",
    "full.h5 --optical-depth 1 --albedo 1.5 => --albedo | [0, 1] | 1.5",
    "full.h5 --optical-depth 1 => --albedo | given | nothing",
    "full.h5 --albedo 1 => --optical-depth | given | nothing",
    "full.h5 --optical-depth 1 --albedo 1,0.5 => --albedo | three | 2",
    "full.h5 full.h5 --optical-depth 1 --albedo 1 => TABLE | three | 2",
    "full.h5 free.toml full.h5 --optical-depth 1 --albedo 1 => alone",
    "free.toml --optical-depth 1 => --optical-depth | left out | 1",
    f"{haze} --over 0.5 => --over | on something | 0.5",
    "free.toml --over 1.5 => --over | albedo | [0, 1] | 1.5",
    "free.toml --over lambert => --over | an albedo | rpv | lambert",
    "free.toml --over ocean:wind=99 => wind | [0, 50] | 99",
    "free.toml --over 0.1,0.2 => --over | three | 2",
    "free.toml --over ocean:wind=5 --over 0.1 => --over | three | 2",
    "full.h5 --optical-depth inf --albedo 1 --over 0.5 => --over | infinite | 0.5",
    "full.h5 --optical-depth 1 --albedo 1 --nodes 0 => --nodes | [1, 512] | 0",
    "coloured.toml coloured.toml 0.4.toml => coloured.toml, line 1 | without lists of three",
    "mixed.h5 --optical-depth 1 --albedo 1 => --at | given | as in mixture=0 | nothing",
    "stack.stratus --optical-depth 1 --albedo 1 => TABLE stack.stratus | one layer | .toml | a stack",
    "stack.stratus => TABLE stack.stratus | one layer | .toml | a stack",
    "full.h5 --at g=0.5 --optical-depth 1 --albedo 1 => --at | left out | g=0.5",
    "full.h5 --at '' --optical-depth 1 --albedo 1 => --at | a member | got nothing",
    "free.toml --at g=0.5 => --at | left out for a stack | g=0.5",
    "family.h5 --at g=0.5 --at g=0.4 --optical-depth 1 --albedo 1 => --at | three | 2",
    *(f"family.h5 --at g={g} --optical-depth 1 --albedo 1 => --at g | [0.3, 0.6] of the table | {g}" for g in ("0.7", "0.5um")),
    *(f"family.h5 --at {at} --optical-depth 1 --albedo 1 => --at | NAME=VALUE | as in g=0.3 | got {at}"
      for at in ("g", "mixture=0.5", "0.5", "g=0.4,g=0.5", ",")), prefix="export --format fourier -o new.bsdf ")
expect_refused("export absent.h5 --optical-depth 1 --albedo 1 --format fourier -o new.bsdf => absent.h5",
               "export full.h5 --optical-depth 1 --albedo 1 --format fourier -o absent/new.bsdf => absent/new.bsdf", code=1)
Path("new.json").mkdir()
expect_refused("export full.h5 --optical-depth 1 --albedo 1 --format exr-atlas -o new.exr => --output | new.json")
expect_refused(f"export full.h5 {layer} --format fourier -o m.bsdf --quiet => m.bsdf", code=1, **size_limited())
if sanitized:
    finish()

# --- the scenes in docs/examples: the line of each writes the file that it reads

for scene in "pbrt-v3/haze.pbrt", "pbrt-v4/haze.pbrt", "mitsuba/haze.xml", "blender/haze.py":
    text = read(examples / scene)
    line = re.search(r"build/cli/stratus export ([^?\n]*)", text)[1]
    written = re.search(r"docs/examples/\w[^/]*/(\S+)", line)[1]
    expect(f'"{written}"' in text, f"{scene} must read {written}")
    export(re.sub(r"docs/examples/.*/", "", line.replace("tables/stacks", str(stacks))) + " --nodes 16 --quiet")
    expect(Path(written).stat().st_size > 0, f"{scene}: {line} must write {written}")

# --- ground, colours, families, stacks; the same twice

to_fourier = "--nodes 16 --format fourier -o"
rgb = f"full.h5 --optical-depth 0.5,1,2 --albedo 1,0.9,0.8 --over 0.3 {to_fourier} "
said = export(rgb + "rgb.bsdf")
expect("note:" not in said.err, "nothing passes: nothing is left out")
expect_says(read("rgb.bsdf"), "albedo 0.8, optical depth 2 on a Lambert surface of albedo 0.3")
export(rgb + "again.bsdf --threads 1")
expect_same("rgb.bsdf", "again.bsdf")
export(f"full.h5 --optical-depth inf --albedo 1 {to_fourier} endless.bsdf --quiet")
export(f"mixed.h5 --at mixture=0.25 {layer} --format fourier -o mixed.bsdf")
expect_says(read("mixed.bsdf"), "0.75*isotropic")


for g in "0.35", "0.4":
    export(f"{g}.toml {to_fourier} {g}.bsdf --quiet")
    export(f"family.h5 --at g={g} {layer} --format fourier -o member.bsdf --quiet")
    expect_same(f"{g}.bsdf", "member.bsdf")
export(f"0.35.toml 0.4.toml 0.35.toml {to_fourier} rgb_layers.bsdf --quiet")
export(f"family.h5 --at g=0.35 --at g=0.4 --at g=0.35 {layer} --format fourier -o rgb_members.bsdf --quiet")
export(f"coloured.toml {to_fourier} coloured.bsdf --quiet")
expect_same("rgb_layers.bsdf", "rgb_members.bsdf", "coloured.bsdf")
export(f"{haze} {to_fourier} haze.bsdf")
expect_says(read("haze.bsdf"),
            "rayleigh, albedo 1, optical depth 0.1 on henyey_greenstein:g=0.7 | on a Lambert surface of albedo 0.3")
export("free.toml free.toml free.toml --over 0.1,0.2,0.3 --nodes 16 --format tensor-rgb -o m.bsdf")

# --- grounds with laws, one for each colour: the samples of a slice are what `solve --over` answers

grounds = "ocean:wind=5", "rpv:rho0=0.1,k=0.8,theta=-0.1", "table:file=full.stratus,optical_depth=1,albedo=0.9"
expect_ok("pack full.h5 -o full.stratus --quiet")
write_stack("haze.toml", low)
export("haze.toml --over " + " --over ".join(grounds) + " --nodes 16 --format slice -o grounds.safetensors --quiet")
data = Path("grounds.safetensors").read_bytes()
start_of_arrays = 8 + int.from_bytes(data[:8], "little")
samples = start_of_arrays + json.loads(data[8:start_of_arrays])["reflection"]["data_offsets"][0]
mu = [math.sin(math.pi / 2 * k / 63) ** 2 for k in range(64)]
places = [(20, 40, 10), (50, 15, 64), (45, 44, 1)]
write("query.csv", "mu_in,mu_out,azimuth_deg", *(f"{mu[i]},{mu[o]},{a * 180 / 64}" for i, o, a in places))
for colour, ground in enumerate(grounds):
    solved = expect_ok(f"solve --phase henyey_greenstein:g=0.35 --albedo 0.9 --optical-depth 1 --over {ground} --nodes 16 --query query.csv")
    for row, (i, o, a) in zip(solved.rows, places):
        sample, = struct.unpack_from("<f", data, samples + 4 * (((colour * 64 + i) * 64 + o) * 65 + a))
        expect_near(sample / (mu[i] + mu[o]), row.reflection, 1e-6 * row.reflection)
finish()
