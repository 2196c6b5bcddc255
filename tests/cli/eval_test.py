"""stratus eval: answers, what may be left out, and every refusal."""

import re
from math import exp, isnan

from expect import *

fixtures("full", "endless", "mixed")
every = "mu_in,mu_out,azimuth_deg,optical_depth,albedo"
angles = "emission_deg,incidence_deg,phase_deg,optical_depth,albedo"
parts = "reflection,transmission,reflection_single,transmission_single,reflection_multiple,transmission_multiple"


def query(*rows, columns=every):
    write("query.csv", columns, *rows)


def evaluate(table, flags="", header=None, **how):
    """Returns the answer to query.csv, with the columns of the query and these."""
    header = header and read("query.csv").split("\n")[0] + "," + header
    return expect_ok(f"eval {table}.h5 --query query.csv {flags}", header=header, **how)


reflection_adds_up = "reflection == reflection_single + reflection_multiple"
# --- answers

query("0.5,0.8,60,1.5,0.9", "1,1,0,8,1", "0.3,0.2,180,inf,1", "0.5,0.5,0,0,0.5")
said = evaluate("full", header=parts, err="")
expect_rows(said, 4, "reflection >= reflection_single and transmission >= transmission_single")
expect_says(said.out, "\n0.3,0.2,180,inf,1, | \n0.5,0.5,0,0,0.5,0,0,0,0,0,0\n")  # as they were; an empty layer scatters nothing
expect(re.search(r"^0.5,0.8,60,1.5,0.9,0\.\d{15,17},", said.out, re.M), "17 significant digits are needed")
first = said.row

# (w/4) (1 - exp(-tau (1/mu + 1/mu0))) / (mu + mu0) at mu = mu0 = 0.5, w = 0.9, infinite depth, isotropic: 0.225
query("0.5,0.5,0,inf,0.9")
expect_rows(evaluate("endless", "--effects reflection"), 1, "reflection_single == 0.225")

# angles as observers have them: the same values, and none on the side that a row does not see
query("0.5,0.5,180,1.5,0.9", "0.5,0.5,0,1.5,0.9")
cosines = evaluate("full").rows
query("60,60,0,1.5,0.9", "120,60,180,1.5,0.9", columns=angles)
lit, unlit = evaluate("full").rows
expect(isnan(lit.transmission) and isnan(unlit.reflection), "the side that a row does not see has no values")
expect_near(lit.reflection, cosines[0].reflection, 1e-12)
expect_near(unlit.transmission, cosines[1].transmission, 1e-12)
query("60,60,130,1.5,0.9", columns=angles)
expect_refused("eval full.h5 --query query.csv => query.csv, line 2 | phase_deg | [0, 120] | got 130")

# columns in any order; comments and blank lines; standard input
query("azimuth_deg,albedo,mu_out,optical_depth,mu_in", "", "60,0.9,0.8,1.5,0.5", columns="# in another order")
said = expect_ok("eval full.h5", stdin=read("query.csv"), header="azimuth_deg,albedo,mu_out,optical_depth,mu_in," + parts)
expect(said.rows == [first], "the order of the columns must not change the answer")
expect(expect_ok("eval full.h5 --query -", stdin=read("query.csv")).out == said.out, "- must be standard input")

# no rows, no answers
query()
expect_rows(evaluate("full"), 0)

# effects: only what was asked for, totals made of it
query("0.5,0.8,60,1.5,0.9")
expect_rows(evaluate("full", "--effects reflection", "reflection,reflection_single,reflection_multiple"), 1, reflection_adds_up)
expect_rows(evaluate("full", "--effects single", "reflection,transmission,reflection_single,transmission_single"), 1,
            "reflection == reflection_single and transmission == transmission_single")
said = expect_ok("eval --query query.csv --effects multiple,transmission full.h5",
                 header=every + ",transmission,transmission_multiple")
expect_rows(said, 1, "transmission == transmission_multiple")
expect_rows(evaluate("full", "--effects single,multiple,reflection,transmission"), 1, reflection_adds_up)

# a background, a dense layer, opposition
single = "--effects single,reflection"
query("0.5,0.5,180,1.5,0.9")
plain = evaluate("full", single).row.reflection
expect_rows(evaluate("full", single + ",background", "reflection,reflection_single,background"), 1,
            "exp(-3) < background < 1")
expect_rows(evaluate("full", "--effects background"), 1, "exp(-3) < background <= 1")
expect_rows(evaluate("full", single + " --density 0.25"), 1, f"reflection > {plain}")
hapke = evaluate("full", single + " --opposition hapke:width=0.05,amplitude=0.5").row
expect_near(hapke.reflection, 1.5 * plain, 2e-5)  # a slice samples the bump
query("0.5,1,180,0.01,1")
expect_rows(evaluate("full", single + ",background"), 1, "exp(-0.01) < background <= 1")
query("0.5,0.5,180,1.2,0.9")
dense = evaluate("full", single + " --density 0.2 --opposition blinn").row.reflection
expect_near(dense, plain * 2 / (1 + exp(-3)), 1e-5)  # [Blinn82] 5.2
spheres = evaluate("full", single + " --density number=0.2,radius=0.62035049089940009 --opposition blinn").row
expect_near(spheres.reflection, dense, 1e-6)  # 4/3 pi radius^3 = 1
for law in "hapke:amplitude=0.5", "hapke":
    evaluate("full", f"{single} --density 0.2 --opposition {law}")
expect_refused(
    "--density number=1,radius=1 => radius | [0, 1)",
    "--density thick => --density | number=N,radius=R | got thick",
    "--density 1 => --density | [0, 1) | got 1",
    "--opposition moon => --opposition | blinn or hapke | got moon",
    "--opposition '' => --opposition | blinn or hapke, got nothing",
    "--opposition blinn => --opposition | --density above 0",
    "--opposition hapke:width=0 => width | (0, inf) | got 0", prefix="eval full.h5 --query query.csv ")

# a side that the table does not hold is an error only when nothing else was asked for; columns that it does not need
three = "mu_in,mu_out,azimuth_deg"
query("0.5,0.8,60", columns=three)
said = evaluate("endless", "", "reflection,reflection_single,reflection_multiple", err="endless.h5 | no transmission")
expect_rows(said, 1, reflection_adds_up)
expect_refused("eval endless.h5 --query query.csv --effects transmission => --effects | got transmission")
query("0.5,0.8,60,0.9", columns=three + ",albedo")
evaluate("endless", "--effects reflection", err="")

# the other file format gives the same answer
query("0.5,0.8,60,1.5,0.9")
expect_ok("convert full.h5 full.exr")
said = evaluate("full", "--effects reflection,background")
plain = said.row.reflection
expect(expect_ok("eval full.exr --query query.csv --effects reflection,background").out == said.out, "files differ")

# a table that mixes: at mixture 1 it is that of the first phase function
expect_refused("eval mixed.h5 --query query.csv => query.csv | mixture")
query(*(f"0.5,0.8,60,1.5,0.9,{share}" for share in (1, 0.5, 0)), columns=every + ",mixture")
said = evaluate("mixed", "--effects reflection,background", "reflection,reflection_single,reflection_multiple,background")
expect_near(said.row.reflection, plain, 1e-6)  # floats
singles = [row.reflection_single for row in said.rows]
expect_near(singles[1], (singles[0] + singles[2]) / 2, 1e-12)
expect_ok("convert mixed.h5 mixed.exr")
expect(expect_ok("eval mixed.exr --query query.csv --effects reflection,background").out == said.out, "files differ")
expect_refused("eval full.h5 --query query.csv => query.csv | got mixture")
query("0.5,0.8,60,1.5,0.9,0.5", "0.5,0.8,60,1.5,0.9,1.5", columns=every + ",mixture")
expect_refused("eval mixed.h5 --query query.csv => query.csv, line 3 | mixture | [0, 1] | got 1.5")

# outside the axes: one warning with the rows counted for each axis
query("0.005,0.8,60,1.5,0.9", "0.005,0.001,60,0.005,0.9", "0.5,0.8,60,100,0.9")
said = evaluate("full", err="warning | 2 in mu_in | 1 in mu_out")
expect_rows(said, 3)
expect(said.err.count("\n") == 1, "one warning is enough")
evaluate("full", "--effects single", err="")

# thinner layers than a table's first: extrapolated, and by how much that is off
write("thick.toml", "phase_function = 'henyey_greenstein:g=0.75'", "tolerance = 1e-2", "optical_depth = { min = 0.5, max = 1 }",
      "albedo = { min = 1, max = 1 }")
expect_ok("bake thick.toml -o thick.h5 --quiet")
query("0.5,0.8,60,0.3,1", "0.5,0.8,60,0.5,1", "0.5,0.8,60,0.2,1")
evaluate("thick", err="warning | of 3 rows 2 are of thinner layers | R or T is off by | % or so at most")
evaluate("thick", "--effects single", err="")

# layers outside the table are refused, or clamped on request
endless = "eval endless.h5 --query query.csv --effects reflection => "
query("0.5,0.8,60,inf,0.9", "0.5,0.8,60,inf,0.5")
expect_refused(endless + "query.csv, line 3 | albedo | [0.9, 0.9] | got 0.5 | --clamp")
query("0.5,0.8,60,1,0.9")
expect_refused(endless + "query.csv, line 2 | optical_depth | inf | got 1")
evaluate("endless", "--effects reflection,single")
query("0.5,0.8,60,1,0.5")
evaluate("endless", "--effects reflection --clamp", err="1 in optical_depth | 1 in albedo")
query("0.5,0.8,60,inf,0")
expect_rows(evaluate("endless", "--effects reflection", err=""), 1, "reflection == 0")

# nor is there another layer than a stack's own
write("stack.toml", "tolerance = 0.1", "[[layers]]", 'phase_function = "isotropic"', "albedo = 0.9", "optical_depth = 1.0",
      "[[layers]]", 'phase_function = "isotropic"', "albedo = 0.5", "optical_depth = 1.0")
expect_ok("bake stack.toml -o stack.h5 --quiet")
for flags in "--clamp", "--effects single", "":
    expect_refused(f"eval stack.h5 --query query.csv {flags} => albedo must be 0.7, that of the stack, got 0\n")

# the smallest cosine is one
query("5e-324,5e-324,0,1,0.5")
expect("nan" not in evaluate("full").out.lower(), "a cosine of 5e-324 must give numbers")

# --- refusals

for row, fragments in cases(
        "0,0.5,0,1,0.5 => mu_in | (0, 1] | got 0",
        "1.0001,0.5,0,1,0.5 => mu_in | (0, 1] | got 1.0001",
        "0.5,-0.5,0,1,0.5 => mu_out | (0, 1] | got -0.5",
        "0.5,1.5,0,1,0.5 => mu_out | (0, 1] | got 1.5",
        "0.5,0.5,inf,1,0.5 => azimuth_deg | finite | got inf",
        "0.5,0.5,0,-1e-9,0.5 => optical_depth | [0, inf] | got -1e-09",
        "0.5,0.5,0,nan,0.5 => optical_depth | nan",
        "0.5,0.5,0,1,-0.1 => albedo | [0, 1] | got -0.1",
        "0.5,0.5,0,1,1.1 => albedo | [0, 1] | got 1.1",
        "0.5,0.5,0,1 => 5 values | got 4",
        "0.5,0.5,0,one,0.5 => optical_depth | got 'one'"):
    query("0.5,0.5,0,1,0.5", row)
    expect_refused("eval full.h5 --query query.csv => query.csv, line 3 | " + fragments)
for arguments, fragments in cases(
        "full mu_in,mu_out,azimuth_deg,albedo => optical_depth",
        "endless mu_in,azimuth_deg => mu_out",
        "full mu_in,mu_out,azimuth_deg,optical_depth,albedo,wavelength => mu_in, mu_out | got wavelength",
        "full # => header"):
    table, columns = arguments.split()
    query(columns=columns)
    expect_refused(f"eval {table}.h5 --query query.csv => query.csv | {fragments}")

# an older answer survives a refusal; what is no table is refused, not waited for
write("out.csv", "older")
query("0.5,0.5,0,1,2")
expect_refused("eval full.h5 --query query.csv -o out.csv => got 2")
query("0.5,0.5,0,1,0.5")
os.symlink("/dev/zero", "zero.h5")
Path("short.h5").write_bytes(Path("full.h5").read_bytes()[:1000])
expect_refused(
    "full.h5 --query query.csv --effects single,double => "
    "--effects | single, multiple, reflection, transmission, background | got double",
    "table.txt --query query.csv => table.txt | .h5 | .exr",
    "full.h5 --query query.csv -o full.h5 => full.h5 | another",
    "full.h5 --query query.csv -o ./query.csv => query.csv | another",
    "full.h5 --query /dev/zero => 67108864 bytes", prefix="eval ")
expect_refused(
    "full.h5 --query absent.csv => absent.csv",
    "absent.h5 --query query.csv => absent.h5",
    "full.h5 --query query.csv -o absent/out.csv => absent/out.csv",
    "zero.h5 --query query.csv => zero.h5: is not a regular file",
    "short.h5 --query query.csv => short.h5", prefix="eval ", code=1)
endless_text = subprocess.Popen(["yes", "#"], stdout=subprocess.PIPE)
process = start("eval full.h5", stdin=endless_text.stdout)
endless_text.stdout.close()
said = process.communicate()[1]
endless_text.wait()
expect(process.returncode == 2 and said.count("\n") == 1, "standard input without an end must be refused")
expect_says(said, "standard input, line | 67108864 bytes")

expect_every_output("eval full.h5 --query query.csv")

# beyond the largest size of a file: refused, not killed
query(*["0.5,0.5,0,1,0.5"] * 200)
expect_refused("eval full.h5 --query query.csv -o out.csv => out.csv: File too large",
               "pack full.h5 -o small.stratus => small.stratus: File too large", code=1, **size_limited(1024))

# a full disk is told, not swallowed
query("0.5,0.5,0,1,0.5")
expect_full("eval full.h5 --query query.csv", "standard output")
finish()
