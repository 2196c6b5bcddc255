"""stratus verify: tables that keep what they state, one that does not, and files that are no tables."""

import re

from expect import *


def write_recipe(name, tolerance, sides):
    """A recipe of a coarse table, whatever the tolerance."""
    write(name, 'phase_function = "isotropic"', f"tolerance = {tolerance}", "optical_depth = { min = 0.5, max = 2.0 }",
          "albedo = { min = 0.9, max = 1.0 }", f"sides = [{sides}]", "[discretisation]", "nodes = 8", "modes = 1", "mu_samples = 6",
          "azimuth_samples = 4", "optical_depth_samples_per_octave = 1", "albedo_samples = 3")


def verify(arguments, **how):
    return expect_ok("verify " + arguments, **how)


def expect_line(said, pattern):
    """A line of a side begins so, before four errors."""
    expect(re.search(f"^{pattern}( +[0-9.]+e[-+][0-9]+){{4}}$", said.out, re.M), f"there is no line '{pattern}'")


def expect_five_worst(said, sides):
    worst = said.out.partition("\nworst points")[2].partition("\n\n")[0]
    expect(len(re.findall(f"^({sides})( +[-+0-9.e]+){{8}}$", worst, re.M)) == 5, "the five worst points are needed")


# --- a table within its tolerance

write_recipe("kept.toml", 0.1, '"reflection", "transmission"')
expect_ok("bake kept.toml -o kept.h5 --accept --quiet")
answer = verify("kept.h5 --samples 300", err="", out="300 random points | median | 99 % | 99.9 % | worst | worst points | "
                "energy: at albedo 1 | white furnace | tolerance 0.1:  | % of values within it")
for side in "reflection", "transmission":
    expect_line(answer, side + " +all directions +300")
expect_five_worst(answer, "reflection|transmission")

# the same answer from either file, on any number of threads; other points for another seed
expect_ok("convert kept.h5 kept.exr")
expect(verify("kept.exr --samples 300 --threads 2 --seed 1 --quiet").out == answer.out, "both files must be told the same")
expect(verify("kept.h5 --samples 300 --seed 2 --threads 1").out != answer.out, "another seed must be other points")
verify("kept.h5 --samples 1")

# --- a peaked phase function: rows of their own near forward and at grazing pairs

edit("kept.toml", "peaked.toml", ("isotropic", "henyey_greenstein:g=0.8"), ("modes = 1", "modes = 8"))
expect_ok("bake peaked.toml -o peaked.h5 --accept --quiet")
peaked = verify("peaked.h5 --samples 40 --quiet", code=1,  # eight modes are too few for it
                err="99 % within 10 degrees of forward and at cosines below 0.15, got ")
for side in "reflection", "transmission":
    expect_line(peaked, side + " +drawn within 10 degrees +20")
    expect_line(peaked, side + " +drawn at cosines below 0.15 +10")

# --- a table that misses it: the answer all the same, exit 1 and why

write_recipe("missed.toml", 1e-4, '"reflection"')
expect_ok("bake missed.toml -o missed.h5 --accept --quiet")
before = snapshot()
missed = verify("missed.h5 --samples 300", code=1, out="all directions | worst points | tolerance 0.0001: ",
                err="stratus: verify: missed.h5 | 99.9 % | tolerance 0.0001 | 5 times | got ")
expect(snapshot() == before, "files differ after verify")
expect(missed.err.count("\n") == 1, "one line is enough")
expect_five_worst(missed, "reflection")
expect("\ntransmission" not in missed.out, "the table has no transmission")

# --- refusals

for option, allowed, values in [
        ("--samples", "in [1, 100000000]", ["0", "-1", "1.5", "1e3", "x", ""]),
        ("--seed", "in [0, 4294967295]", ["-1", "4294967296", "x", ""]),
        ("--threads", "in [0, 1024]", ["-1", "1025", "x", ""])]:
    expect_refused(*(f"{option} '{value}' => {option} | {allowed} | got {value or 'nothing'}" for value in values),
                   prefix="verify kept.h5 ")
expect_refused(" => TABLE | required", "kept.h5 extra => extra", "kept.txt => kept.txt | .h5 | .exr", "'' => .h5 | .exr",
               prefix="verify ")

# what is no table is refused by every command that reads one, and harms nothing
for older in "older.h5", "older.exr", "older.csv":
    write(older, "older")
write("query.csv", "mu_in,mu_out,azimuth_deg,optical_depth,albedo", "0.5,0.5,0,1,0.95")
for ending, other, format in ("h5", "exr", "HDF5"), ("exr", "h5", "OpenEXR"):
    table = Path("kept." + ending).read_bytes()
    half = len(table) // 2
    for name, bytes in [("short", table[:half]), ("bent", table[:half] + b"\xff\0\x55" + table[half + 3:]),
                        ("foreign", b"not a table, whatever its name says\n")]:
        file = f"{name}.{ending}"
        Path(file).write_bytes(bytes)
        expect_refused(*(f"{command} => {file}" for command in (
            f"info {file}", f"info {file} --picture new.png", f"verify {file}", f"eval {file} --query query.csv -o older.csv",
            f"convert {file} older.h5", f"convert {file} older.exr")), code=1)
    for length in 0, 1, 7, 100, len(table) - 100:
        Path("short." + ending).write_bytes(table[:length])
        expect_refused(f"verify short.{ending} => short.{ending}", code=1)
    Path("folder." + ending).mkdir()
    shutil.copy("kept." + other, "disguised." + ending)
    expect_refused(f"folder.{ending} => folder.{ending}", f"absent.{ending} => absent.{ending} | No such file",
                   f"disguised.{ending} => disguised.{ending} | {format}", prefix="verify ", code=1)

for command in "info kept.h5", "verify kept.h5 --samples 10", "verify --help":
    expect_full(command, "stratus: standard output: No space left")
finish()
