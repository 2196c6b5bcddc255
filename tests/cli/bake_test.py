"""stratus bake: both files, what it says, the same bytes on any number of threads; interruptions and every refusal."""

import re
from math import cos

from expect import *

Path("recipes").mkdir()
write("recipes/curve.csv", "phase_angle_deg,value", *(f"{angle},{2 + cos(angle / 57.3):.6g}" for angle in range(0, 181, 20)))
write("recipes/narrow.toml",
      'title = "Narrow and coarse"',
      'phase_function = "3*tabulated:file=curve.csv + 1*isotropic"  # beside the recipe',
      "tolerance = 1e-2",
      "optical_depth = { min = 0.5, max = 2.0 }",
      "albedo = { min = 0.8, max = 0.9 }")
write("recipes/chosen.toml",  # nothing is left to be measured
      'phase_function = "henyey_greenstein:g=0.3"',
      "tolerance = 0.1",
      "optical_depth = { min = 0.5, max = 2.0 }",
      "albedo = { min = 0.5, max = 0.6 }",
      'sides = ["reflection"]',
      "[discretisation]",
      "nodes = 8",
      "modes = 4",
      "mu_samples = 6",
      "azimuth_samples = 5",
      "optical_depth_samples_per_octave = 1",
      "albedo_samples = 2",
      'scheme = "classic"')
capped = ['phase_function = "isotropic"', "tolerance = 1e-6", "albedo = { min = 0.5, max = 0.9 }", 'sides = ["reflection"]']


def bake(arguments, **how):
    return expect_ok("bake recipes/" + arguments, **how)


def is_there(name):
    return Path(name).exists()


# --- answers

bake("narrow.toml -o narrow.h5 --exr narrow.exr --threads 1", out="",
     err="note:  | curve.csv | weights summed to 4 | nodes  | modes  | mu_samples  | azimuth_samples  | checked at 2000 random "
         "points | samples a side | MiB on disk | asked for 0.01 | in memory and uncompressed; about  |  s to solve and ")
expect(set(os.listdir()) == {"disk", "shut", "recipes", "narrow.h5", "narrow.exr"}, "only the two tables may be made")

# a dry run tells size and time alone, and writes nothing
bake("narrow.toml --dry-run --quiet", err="", out="nodes =  | azimuth_scale =  | samples a side,  |  s to check")
write("recipes/capped.toml", *capped, "optical_depth = { min = inf, max = inf }", "[discretisation]", "nodes = 16")
bake("capped.toml --dry-run --accept --quiet", out="mu_samples is at its cap of 56 | would do, in a table of")

# the same bytes on any number of threads; quiet is silent; an older file is replaced
for threads in 2, 7:
    write("again.h5", "older")
    bake(f"narrow.toml -o again.h5 --exr again.exr --threads {threads} --quiet", out="", err="")
    expect_same("narrow.h5", "again.h5")
    expect_same("narrow.exr", "again.exr")

columns = "mu_in,mu_out,azimuth_deg,optical_depth,albedo"
write("query.csv", columns, "0.5,0.8,60,1.5,0.85", "1,0.1,0,0.5,0.8", "0.03,0.3,180,2,0.9")


def values(table):
    return expect_ok(f"eval {table} --query query.csv")


# straight into the packed table, from a few samples of most layers: the same bytes on any number of threads
bake("narrow.toml -o narrow.stratus --threads 1 --quiet")
bake("narrow.toml -o again.stratus --threads 3 --quiet")
expect_same("narrow.stratus", "again.stratus")
# with all samples beside it: those of a bake of samples, and what packing them afterwards gives; both are near each other
bake("narrow.toml -o again.stratus --h5 again.h5 --exr again.exr --threads 3 --quiet")
sampled = values("narrow.h5")
for again in "narrow.exr", "again.h5", "again.exr":
    expect(values(again).out == sampled.out, f"{again} must hold the same values")
expect_ok("pack narrow.h5 -o packed.stratus --quiet")
packed = values("packed.stratus")
expect(values("again.stratus").out == packed.out, "packing afterwards must give the same")
for direct, afterwards in zip(values("narrow.stratus").rows, packed.rows, strict=True):
    expect_near(direct.reflection, afterwards.reflection, afterwards.reflection / 100)
expect_ok("verify narrow.stratus --samples 200 --quiet", out="tolerance 0.01: 100.00 % of values within it")

# both files hold values near those of the solver, and become one another without loss
write("solved.csv", "mu_in,mu_out,azimuth_deg", "0.5,0.8,60")
solved = expect_ok("solve --phase '0.75*tabulated:file=recipes/curve.csv + 0.25*isotropic' --albedo 0.85 --optical-depth 1.5 "
                   "--query solved.csv").row
for side in "reflection", "transmission":
    expect_near(getattr(sampled.row, side), getattr(solved, side), getattr(solved, side) / 100)
expect_ok("convert narrow.exr back.h5")
expect_ok("convert narrow.h5 back.exr")
expect_same("narrow.h5", "back.h5")
expect_same("narrow.exr", "back.exr")

# info: the recipe as given and as resolved, which bakes the same samples wherever it lies
expect_ok("info narrow.h5", out="Narrow and coarse | 0.5 to 2 | 0.8 to 0.9 | reflection, transmission | tolerance             "
          '0.01 | 3*tabulated:file=curve.csv + 1*isotropic | # beside the recipe | resolved recipe | mu_samples | scheme = '
          '"harmonic" | lower boundary        none')
expect_ok("verify narrow.h5 --samples 200", out="200 random points | median | tolerance 0.01: 100.00 %")
write("resolved.toml", expect_ok("info narrow.exr").out.partition("\nresolved recipe\n")[2])
expect_ok("bake resolved.toml -o resolved.h5 --quiet")
expect(values("resolved.h5").out == sampled.out, "the resolved recipe must bake the same samples")

# over ground: both files keep it, info tells it, verify solves it, eval adds its single scattering
edit("recipes/chosen.toml", "recipes/ground.toml", ('sides = ["reflection"]\n', ""),
     ('"classic"', '"classic"\n[below]\nlambert_albedo = 0.3'))
bake("ground.toml -o ground.h5 --exr ground.exr --quiet")
write("query.csv", columns, "0.5,0.8,60,1,0.55")
for table in "ground.h5", "ground.exr":
    expect_ok("info " + table, out="Lambert surface, albedo 0.3 | lambert_albedo = 0.3")
expect(values("ground.h5").out == values("ground.exr").out, "both files must give the same values")
expect_ok("verify ground.h5 --samples 200")

# two kinds of scattering in any mixture
write("recipes/mixed.toml", 'phase_function = "henyey_greenstein:g=-0.3"', 'second_phase_function = "isotropic"',
      "tolerance = 5e-2", "optical_depth = { min = 1.0, max = 1.0 }", "albedo = { min = 0.9, max = 0.9 }",
      'sides = ["reflection"]')
bake("mixed.toml -o mixed.h5 --exr mixed.exr", err="mixture 0.5: | mixture_samples")
expect_ok("convert mixed.exr mixed_back.h5")
expect_same("mixed.h5", "mixed_back.h5")
expect_ok("info mixed.h5", out='second phase function isotropic | the share of the first | second_phase_function = "isotropic"')
for flag in "--seed=2", "--bound":
    expect_ok("verify mixed.h5 --samples 200 " + flag, out="mixture | tolerance 0.05: 100.00 %")

# an expert's choice is taken
bake("chosen.toml -o chosen.h5", err="checked at 2000 random points")
said = expect_ok("info chosen.h5", out='6 samples | 5 samples | 2 samples | scheme = "classic"')
expect(re.search("^sides *reflection$", said.out, re.M), "only the side asked for")

# --- a table that misses its tolerance: written, told in one sentence, exit code 1 unless accepted

write("recipes/missed.toml", *capped, "optical_depth = { min = 1.0, max = 1.0 }")
said = bake("missed.toml -o missed.h5", code=1)
expect(said.err.count("checked at 2000 random points") == 1, "an axis at its cap must end the attempts")
for flags, code in ("--quiet", 1), ("--quiet --accept", 0):
    said = bake("missed.toml -o again.h5 " + flags, code=code, out="",
                err="stratus: bake: again.h5: the table misses its tolerance 1e-06: 99.9 % of values are within  | "
                    "mu_samples is at its cap of 56")
    expect(said.err.count("\n") == 1, "one line is enough")
    expect_same("again.h5", "missed.h5")
expect(not is_there("missed.h5.checkpoint"), "the checkpoint must be removed")

# --- interruptions: no partial file, finished work is kept

edit("recipes/narrow.toml", "recipes/long.toml", ("1e-2", "1e-5"),
     ("3*tabulated:file=curve.csv + 1*isotropic", "henyey_greenstein:g=0.6"), ("0.9 }", "0.9 }\n[discretisation]\nnodes = 16"))
write("older.h5", "older")
checkpoint = Path("older.h5.checkpoint")


def start_long_bake(*flags):
    """Returns a bake that has made a choice, and what it has said."""
    process = start(" ".join(["bake recipes/long.toml -o older.h5 --exr new.exr", *flags]))
    said = ""
    while not re.search("^  modes |_samples [0-9]", said, re.M) and (line := process.stderr.readline()):
        said += line
    return process, said


before = snapshot()
for sent in signal.SIGINT, signal.SIGTERM, signal.SIGHUP:
    process, said = start_long_bake()
    process.send_signal(sent)
    said += process.stderr.read()
    expect(process.wait() == 128 + sent, f"exit code {process.returncode} after {sent.name}")
    expect(said.splitlines()[-1] == f"stratus: interrupted; finished work is kept in {checkpoint}: repeat the command with "
           "--resume", f"the last line must say how to go on, not {said}")
    checkpoint.rename(logs / "kept")
    expect(snapshot() == before, f"files differ after {sent.name}")

# a checkpoint is neither overwritten by accident nor used for another recipe
(logs / "kept").rename(checkpoint)
expect_refused(f"long.toml -o older.h5 --quiet => {checkpoint} | --resume | removing",
               f"chosen.toml -o older.h5 --resume --quiet => {checkpoint} | another recipe | Narrow and coarse | remove",
               prefix="bake recipes/", code=1)
# nor shared by two bakes at once
process, said = start_long_bake("--resume")
expect_says(said, f"resuming from {checkpoint}")
process.send_signal(signal.SIGSTOP)
resume = "bake recipes/long.toml -o older.h5 --resume --quiet => "
expect_refused(f"{resume}{checkpoint} | another bake of this table is running", code=1)
for sent in signal.SIGCONT, signal.SIGTERM:
    process.send_signal(sent)
process.communicate()
write(checkpoint, "older")
expect_refused(f"{resume}{checkpoint} | is not a checkpoint", code=1)
checkpoint.unlink()

# without a checkpoint, the bake begins from the start
bake("chosen.toml -o resumed.h5 --resume", err="no checkpoint to resume from")
expect_same("resumed.h5", "chosen.h5")
# in the short time in which a file is written it waits
for seconds in 0.005, 0.01, 0.015, 0.02, 0.03, 0.05:
    interrupt("convert narrow.exr new.h5", seconds, signal.SIGINT)
    expect(not list(Path().glob(".*.*")), "a file of its own is left over after SIGINT")
    if is_there("new.h5"):
        expect_same("new.h5", "narrow.h5")
        Path("new.h5").unlink()

# --- refusals

Path("folder.h5").mkdir()
Path("folder.exr").mkdir()
os.mkfifo("pipe.h5")
expect_refused(
    " => --output | required",
    "-o table.txt => --output | .h5 | got table.txt",
    "-o table => --output | .h5 | got table",
    "-o '' => --output | .h5 | got nothing",
    "-o table.exr => --output | .h5 | got table.exr",
    "-o new.h5 --exr table.h5 => --exr | .exr | got table.h5",
    "-o new.h5 --exr '' => --exr | file | got nothing",
    "-o new.stratus --h5 table.exr => --h5 | .h5 | got table.exr",
    "-o new.h5 --h5 more.h5 => --h5 | left out for an output that is itself .h5 | got more.h5",
    "-o folder.h5 => --output | file | got the folder folder.h5",
    "-o new.h5 --exr folder.exr => --exr | file | got the folder folder.exr",
    "-o pipe.h5 => --output | file | pipe.h5",
    *(f"-o new.h5 --threads '{value}' => --threads | in [0, 1024] | got {value or 'nothing'}"
      for value in ("-1", "1025", "1.5", "x", "")),
    "-o new.h5 extra => extra", prefix="bake recipes/chosen.toml ")
expect_refused(
    "-o new.stratus --h5 absent/new.h5 => absent/new.h5 | no folder absent",
    "-o absent/new.h5 => absent/new.h5 | no folder absent",
    "-o new.h5 --exr absent/new.exr => absent/new.exr | no folder absent", prefix="bake recipes/chosen.toml ", code=1)
shutil.copy("recipes/chosen.toml", "recipe.h5")
expect_refused("-o new.h5 => RECIPE | required", "recipe.h5 -o recipe.h5 => recipe.h5 | another", prefix="bake ")
expect_refused("absent.toml -o new.h5 => absent.toml", "recipes -o new.h5 => recipes", prefix="bake ", code=1)


def expect_bad(old, new, fragments, **how):
    """Refuses a recipe edited so; an older table comes to no harm."""
    edit("recipes/chosen.toml", "recipes/bad.toml", (old, new))
    expect_refused("bake recipes/bad.toml -o older.h5 => " + fragments, **how)


expect_bad("tolerance", "tolerence", "unknown key 'tolerence' | line 2 | 'tolerance'")
expect_bad("henyey_greenstein:g=0.3", "tabulated:file=absent.csv", "recipes/absent.csv", code=1)
write("recipes/bad.csv", "phase_angle_deg,value", "0,1", "90,-1", "180,1")
expect_bad("henyey_greenstein:g=0.3", "tabulated:file=bad.csv", "value | recipes/bad.csv, line 3 | got -1")
Path("recipes/bad.toml").write_bytes(Path("/bin/sh").read_bytes()[:3000])
expect_refused("bake recipes/bad.toml -o older.h5 => bad.toml must be TOML text, got a binary file")

# a disk that fills up, a folder that refuses
expect_refused("bake recipes/chosen.toml --quiet -o older.h5 => older.h5 | too large",
               "convert narrow.exr new.h5 => new.h5 | too large", code=1, **size_limited())
if where_permitted(small_disk):
    for file in "disk/older.h5", "disk/new.h5":
        expect_refused(f"bake recipes/chosen.toml --quiet -o {file} => {file} | No space left",
                       f"convert narrow.exr {file} => {file} | No space left", code=1, **small_disk)
    # a bake that cannot be written is not lost
    bake("narrow.toml -o kept.h5 --exr disk/new.exr --quiet", code=1, **small_disk,
         err="disk/new.exr: No space left on device; finished work is kept in kept.h5.checkpoint for --resume")
    bake("narrow.toml -o kept.h5 --exr kept.exr --resume --quiet")
    expect_same("kept.h5", "narrow.h5")
    expect_same("kept.exr", "narrow.exr")
    expect(not is_there("kept.h5.checkpoint"), "the checkpoint must be removed")
if where_permitted(user_refused):
    expect_refused("bake recipes/chosen.toml -o shut/new.h5 => shut/new.h5 | cannot be written",
                   "convert narrow.exr shut/new.h5 => shut/new.h5 | Permission denied", code=1, **user_refused)
finish()
