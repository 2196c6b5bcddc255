"""stratus pack: the packed file serves wherever a table does; its refusals."""

from expect import *

write("haze.toml", 'title = "haze"', 'phase_function = "henyey_greenstein:g=0.5"', "tolerance = 1e-2",
      "optical_depth = { min = 0.1, max = 4.0 }", "albedo = { min = 0.8, max = 1.0 }")
expect_ok("bake haze.toml -o haze.h5 --quiet")
expect_ok("pack haze.h5 -o haze.stratus", out="", err="haze.stratus | MB | % of the table's samples")
expect_ok("pack haze.h5 -o again.stratus --quiet", err="")
expect_same("haze.stratus", "again.stratus")

expect_ok("info haze.stratus", out="haze | henyey_greenstein:g=0.5")
for flag in "", "--bound":
    expect_ok("verify haze.stratus --samples 50 " + flag)
write("query.csv", "mu_in,mu_out,azimuth_deg,optical_depth,albedo", "0.5,0.8,60,1,0.9")
expect_ok("eval haze.stratus --query query.csv")

# back to samples, which say what they are
expect_ok("convert haze.stratus back.exr")
expect_ok("info back.exr", out="samples               evaluated")
back, haze = (expect_ok(f"eval {table} --query query.csv").row for table in ("back.exr", "haze.h5"))
for part in "reflection", "transmission", "reflection_single":
    expect_near(getattr(back, part), getattr(haze, part), getattr(haze, part) / 200)

# a bent byte serves, but is found; other files are told by what they are
packed = Path("haze.stratus").read_bytes()
bent = bytes([packed[-100] ^ 0x55])
Path("flipped.stratus").write_bytes(packed[:-100] + bent + packed[-99:])
expect_ok("eval flipped.stratus --query query.csv")
Path("short.stratus").write_bytes(packed[:2000])
expect_refused(
    "info flipped.stratus => flipped.stratus | checksum",
    "verify flipped.stratus => flipped.stratus | checksum",
    "info short.stratus => short.stratus",
    "pack absent.h5 -o new.stratus => absent.h5", code=1)
expect_ok("convert haze.h5 haze.exr")
write("haze.txt", "a text of some length")
for ending, fragments in [("h5", "got an HDF5 file | `stratus pack`"), ("exr", "got an OpenEXR file"),
                          ("txt", "got another kind of file | `stratus bake`")]:
    shutil.copy("haze." + ending, "foreign.stratus")
    expect_refused("eval foreign.stratus --query query.csv => foreign.stratus | " + fragments, code=1)
expect_refused(
    "haze.h5 -o haze.h5 => --output | .stratus | haze.h5",
    "haze.stratus -o other.stratus => TABLE | .h5 | .exr | haze.stratus", prefix="pack ")
finish()
