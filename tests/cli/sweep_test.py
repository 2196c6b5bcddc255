"""stratus bake --sweep: the tables that single bakes make, its summary, kills and resumptions, and every refusal."""

import random

from expect import *

write("base.toml",
      'title = "Base"',
      'phase_function = "isotropic"',
      "tolerance = 0.1",
      "optical_depth = { min = 1.0, max = 1.0 }",
      "albedo = { min = 0.9, max = 0.9 }",
      'sides = ["reflection"]',
      "[discretisation]",
      "nodes = 8")
both = '"[""reflection"", ""transmission""]"'
rows = ["# any key a column, an empty cell as the recipe has it",
        "name,phase_function,optical_depth.min,optical_depth.max,discretisation.nodes,discretisation.mu_samples,sides",
        "thin,,0.25,0.5,,6,",
        f'"rayleigh, both",rayleigh,,,10,6,{both}',
        "grey,0.5*rayleigh + 0.5*isotropic,2,2,,6,"]
names = ["thin", "rayleigh, both", "grey"]
write("three.csv", *rows)
write("sweep.csv", *rows[:4], f"again,rayleigh,,,10,6,{both}", rows[4])


def sweep(arguments, **how):
    return expect_ok(f"bake {arguments} --quiet", **how)


def expect_tables(folder):
    """The folder has the tables of three.csv."""
    for name in names:
        expect_same(f"threads1/{name}.stratus", f"{folder}/{name}.stratus")


# --- answers

said = sweep("base.toml --sweep sweep.csv -o whole", err="", header="name,asked,met,worst,seconds,bytes,remark")
expect_rows(said, 4, "met == 'yes' and 0 < worst < 0.1 == asked and bytes > 1000")
expect(said.out == read("whole/summary.csv"), "the summary must be what was printed")
expect(sorted(os.listdir("whole")) == sorted(["summary.csv", "again.stratus", *(name + ".stratus" for name in names)]),
       "another list of tables")
expect_same("whole/again.stratus", "whole/rayleigh, both.stratus")
expect_says(said.out, "the same as rayleigh, both")

# a row's table is that of its recipe alone, which it carries; on any number of threads
recipe = expect_ok("info whole/thin.stratus").out.partition("\nrecipe\n")[2].partition("\nresolved recipe\n")[0]
expect_says(recipe, "0.25 | nodes = 8 | mu_samples = 6")
write("thin.toml", recipe)
expect_ok("bake thin.toml -o single.stratus --quiet")
write("query.csv", "mu_in,mu_out,azimuth_deg,optical_depth,albedo", "0.5,0.8,60,0.3,0.9")


def value(table):
    return expect_ok(f"eval '{table}.stratus' --query query.csv --clamp").out


expect(value("single") == value("whole/thin"), "a row's table must be that of its recipe")
for threads in 1, 5:
    sweep(f"base.toml --sweep three.csv -o threads{threads} --threads {threads}")
for folder in "threads5", "whole":
    expect_tables(folder)

# without names they are numbered
write("numbers.csv", "albedo.min", "0.8", "0.7")
sweep("base.toml --sweep numbers.csv -o numbers", out="1,0.1,yes | 2,0.1,yes")
expect(sorted(os.listdir("numbers")) == ["1.stratus", "2.stratus", "summary.csv"], "tables must be numbered")

# a layer of a stack
write("stack.toml", "tolerance = 0.1", 'sides = ["reflection"]',
      "[[layers]]", 'phase_function = "rayleigh"', "albedo = 1.0", "optical_depth = 0.2",
      "[[layers]]", 'phase_function = "isotropic"', "albedo = 0.9", "optical_depth = 1.0",
      "[discretisation]", "nodes = 8")
write("layers.csv", "layers.2.optical_depth", "0.5")
sweep("stack.toml --sweep layers.csv -o stack")
expect_ok("info stack/1.stratus", out="0.7")

# the rows may stand in the recipe itself: the same tables
write("own.toml", read("base.toml"),
      "[sweep]",
      'name = ["thin", "rayleigh, both", "grey"]',
      'phase_function = ["isotropic", "rayleigh", "0.5*rayleigh + 0.5*isotropic"]',
      "optical_depth.min = [0.25, 1.0, 2.0]",
      '"optical_depth.max" = [0.5, 1.0, 2.0]',
      "discretisation.nodes = [8, 10, 8]",
      "discretisation.mu_samples = [6, 6, 6]",
      'sides = [["reflection"], ["reflection", "transmission"], ["reflection"]]')
sweep("own.toml -o own")
for name in names:
    expect(value(f"own/{name}") == value(f"whole/{name}"), f"{name} must be the same table")

# --- kills and resumptions


def expect_resumed(rows, found):
    said = sweep(f"base.toml --sweep {rows}.csv -o whole --resume")
    expect(said.out.count("was there") == found, f"{found} tables must be found")
    expect_tables("whole")


grey, thin, rayleigh = (Path("whole", name + ".stratus") for name in ("grey", "thin", "rayleigh, both"))
grey.unlink()
expect_resumed("sweep", 2)
# a name is not enough: another recipe's table and a damaged one are baked again
shutil.copy(grey, thin)
rayleigh.write_bytes(rayleigh.read_bytes()[:-1000])
expect_resumed("three", 1)
# so are what a power cut may leave of tables that the disk had not taken yet: nothing, or zeros
thin.write_bytes(b"")
grey.write_bytes(bytes(grey.stat().st_size))
expect_resumed("three", 1)

# killed at random moments, it ends with the same tables
drawn = random.Random(1982)
for _ in range(8):
    interrupt("bake base.toml --sweep three.csv -o killed --resume --quiet", drawn.uniform(0.01, 0.3), signal.SIGKILL)
sweep("base.toml --sweep three.csv -o killed --resume")
expect_tables("killed")
expect(len(os.listdir("killed")) == 4, f"there is {os.listdir('killed')}")

# a signal stops it in order
edit("base.toml", "long.toml", ("= 0.1", "= 1e-5"), ("max = 1.0", "max = inf"), ("max = 0.9", "max = 1.0"))
write("long.csv", "phase_function", "henyey_greenstein:g=0.7", "henyey_greenstein:g=0.8")
said = interrupt("bake long.toml --sweep long.csv -o long --quiet", 1, signal.SIGINT)
expect(said.code == 130 and said.out == "", "it must be interrupted by SIGINT")
expect_says(said.err, "repeat the command with --resume")

# --- a table that misses, one that fails: the others are baked, and the exit code is 1

write("missed.csv", "name,discretisation.mu_samples,tolerance", "good,,", "bad,4,1e-3")
sweep("base.toml --sweep missed.csv -o missed", code=1, err="1 of 2 tables miss their tolerance (--accept",
      out="good,0.1,yes, | bad,0.001,no, | the table misses its tolerance")
expect(Path("missed/bad.stratus").is_file(), "it must be written all the same")
sweep("base.toml --sweep missed.csv -o missed --resume --accept", out="bad,0.001,no,", err="1 of 2 tables miss their tolerance")
Path("failed/good.stratus").mkdir(parents=True)
sweep("base.toml --sweep missed.csv -o failed --accept", code=1, err="1 of 2 tables failed",
      out="good,0.1,failed, | is a directory | bad,0.001,no,")

# --- refusals, before anything is baked


def expect_no_folder():
    expect(not Path("new").exists(), "no folder may be made")


for lines, fragments in cases(
        "tolerance 0.01 2 => bad.csv, line 3: tolerance must be a number in [1e-6, 0.1], got 2",
        "tolerance fine => bad.csv, line 2: tolerance must be a number | fine",
        "discretisation.nodes 1.5 => bad.csv, line 2: discretisation.nodes must be a whole number in [1, 512]",
        "phase_function henyey_greenstein:g=1 => bad.csv, line 2: phase_function",
        "optical_depth.min 3 => bad.csv, line 2: optical_depth.min must be at most max",
        "mu_in.min,mu_in.max 0.5,1 0.5, => bad.csv, line 3 | mu_in.max",
        "azimuth_deg 0 => bad.csv, line 2: azimuth_deg | azimuth_deg.max must be in [0.001, 180], got 0",
        "tolerence 0.01 => no key of the recipe is 'tolerence'; did you mean 'tolerance'?",
        "layers.1.albedo 0.5 => no key of the recipe is 'layers.1.albedo'",
        "name a a => bad.csv, line 3: name must be a new one | 'a' again",
        "name a/b => bad.csv, line 2: name must be a file's name | got 'a/b'",
        "name,tolerance ,0.1 => bad.csv, line 2: name must be | got ''",
        "tolerance => at least one row",
        " => a header naming the columns",
        "tolerance,albedo.min 0.1 => line 2: a row must have 2 values, got 1"):
    write("bad.csv", *lines.split())
    expect_refused("bake base.toml --sweep bad.csv -o new => " + fragments)
    expect_no_folder()
write("bad.csv", "layers.3.albedo", "0.5")
expect_refused("bake stack.toml --sweep bad.csv -o new => bad.csv, line 2: layers.3.albedo | up to 2")
for lines, fragments in [
        (["tolerance = [0.01, 2]"], "table 2: tolerance must be a number in [1e-6, 0.1], got 2"),
        (["tolerance = [0.01]", "albedo.max = [1, 1]"],
         "line 10: sweep.tolerance must be as long as the other lists of [sweep], 2, got 1"),
        (["tolerance = []"], "sweep.tolerance must be a list of values"),
        (["tolerance = 0.01"], "sweep.tolerance must be a list of values, one for each table, got 0.01"),
        (["tolerence = [0.01]"], "no key of the recipe is 'tolerence'; did you mean 'tolerance'?"),
        (["name = [1]"], "table 1: name must be a file's name | got 1"),
        (['name = ["a", "a"]'], "table 2: name must be a new one"),
        ([], "sweep must be a list of values a key")]:
    Path("bad.toml").write_text("\n".join([read("base.toml") + "[sweep]", *lines]))
    expect_refused("bake bad.toml -o new => bad.toml | " + fragments)
    expect_no_folder()
expect_refused(
    "own.toml --sweep sweep.csv -o new => --sweep must be left out for a recipe that has a [sweep]",
    "own.toml -o new --dry-run => own.toml | sweep must be absent but for",
    "own.toml -o new --exr t.exr => --exr must be left out for a sweep",
    "own.toml -o new --h5 t.h5 => --h5 must be left out for a sweep",
    "base.toml --sweep '' -o new => --sweep | file",
    "base.toml --sweep sweep.csv -o new --exr t.exr => --sweep | --exr",
    "base.toml --sweep sweep.csv -o new --dry-run => --sweep | --dry-run",
    "base.toml --sweep sweep.csv => --output is required", prefix="bake ")
Path("long/1.stratus.checkpoint").touch()
expect_refused(
    "base.toml --sweep absent.csv -o new => absent.csv",
    "base.toml --sweep sweep.csv -o absent/new => absent/new",
    "base.toml --sweep sweep.csv -o base.toml => base.toml",
    "long.toml --sweep long.csv -o long => is left from an interrupted sweep; --resume continues it", prefix="bake ", code=1)
finish()
