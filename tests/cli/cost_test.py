"""stratus cost: its CSV and its figure, what it says, and every refusal."""

from expect import *

recipe = ['phase_function = "isotropic"', "tolerance = 0.1", "optical_depth = { min = 1.0, max = 1.0 }",
          "albedo = { min = 0.9, max = 0.9 }", 'sides = ["reflection"]']
write("tiny.toml", *recipe)
header = ("kind,varied,tolerance,nodes,modes,mu_samples,azimuth_samples,optical_depth_samples_per_octave,albedo_samples,"
          "mixture_samples,g_samples,radius_samples,wavelength_samples,variance_samples,error_median,error_99_9,error_largest,"
          "solve_seconds,bake_seconds,bytes,lookup_ns,on_frontier,times_frontier")


def cost(arguments, **how):
    return expect_ok("cost " + arguments, **how)


# --- answers

before = set(os.listdir())
cost("tiny.toml -o cost.csv --svg cost.svg --seconds 1000", out="",
     err="converged solution:  |  nodes; with fewer it is  | tolerance 0.1: solver error  | tolerance 0.1: table error  | "
         "tolerance 0.1: packed error  |  us a lookup | times the time of the cheapest | times the bytes of the cheapest")
expect(set(os.listdir()) - before == {"cost.csv", "cost.svg"}, "only the two answers may be made")
answer = Answer(out=read("cost.csv"))
expect(answer.header == header, "another header")
for row in answer.rows:
    solver, table = (row.solve_seconds, row.bytes), (row.bytes, row.lookup_ns, row.solve_seconds)
    expect(row.kind == "solver" and solver[0] > 0 and solver[1] == ""
           or row.kind in ("table", "packed") and min(table[:2]) > 0 and table[2] == "", f"{row} must have what it costs")
expect_says(answer.out, "\nsolver,tolerance,0.1, | \nsolver,nodes,, | \ntable,tolerance,0.1, | \ntable,mu_samples,, | "
            "\npacked,tolerance,0.1,")
expect_svg("cost.svg")

# a family: rows of members along its axis
write("family.toml", *recipe, 'second_phase_function = "rayleigh"')
cost("family.toml -o family.csv --svg family.svg --seconds 1000", err="converged solution:  | tolerance 0.1: table error ")
expect(any(row.varied == "mixture_samples" and row.mixture_samples > 1 and row.bytes > 0 and row.bake_seconds > 0
           for row in Answer(out=read("family.csv")).rows), "the answer needs a row that varies the members")
expect_svg("family.svg")

# quiet is silent, - is stdout, an older figure is replaced
write("cost.svg", "older")
cost("tiny.toml -o - --svg cost.svg --seconds 1 --threads 1 --quiet", err="", header=header)
expect_svg("cost.svg")

cost("--help", out=" | ".join(["stratus cost tables/saturn_rings.toml -o cost.csv --svg cost.svg",
                               *(f"  {column}: " for column in header.split(","))]))

# --- interruption: no half file, nothing left over

write("older.csv", "older")
write("older.svg", "older")
edit("tiny.toml", "long.toml", ("isotropic", "henyey_greenstein:g=0.9"), ("= 0.1\n", "= 1e-5\n"))
before = snapshot()
said = interrupt("cost long.toml -o older.csv --svg older.svg", 0.4, signal.SIGINT)
expect(said.code == -signal.SIGINT, f"it must be interrupted by SIGINT, and ends with {said.code}")
expect(snapshot() == before, "files differ after SIGINT")

# --- refusals

Path("folder.svg").mkdir()
edit("tiny.toml", "bad.toml", ("0.1", "0.2"))
expect_refused(
    *(f"tiny.toml --seconds '{value}' => --seconds | above 0 | got {value or 'nothing'}" for value in ("0", "-1", "nan", "x", "")),
    "tiny.toml --threads -1 => --threads | in [0, 1024] | got -1",
    "tiny.toml --svg cost.png => --svg | .svg | got cost.png",
    "tiny.toml --svg '' => --svg | file | got nothing",
    "tiny.toml -o '' => --output | file | got nothing",
    "tiny.toml --svg folder.svg => --svg | file | got the folder folder.svg",
    "tiny.toml -o folder.svg => --output | file | got the folder folder.svg",
    "tiny.toml -o tiny.toml => tiny.toml | another",
    "tiny.toml -o older.svg --svg older.svg => older.svg | another",
    " => RECIPE | required",
    "tiny.toml extra => extra",
    "bad.toml -o older.csv --svg older.svg => tolerance | [1e-6, 0.1] | got 0.2", prefix="cost ")
expect_refused(
    "tiny.toml -o absent/new.csv => absent/new.csv | no folder absent",
    "tiny.toml --svg absent/new.svg => absent/new.svg | no folder absent",
    "absent.toml -o older.csv => absent.toml",
    "absent.toml -o /dev/stdout => absent.toml: cannot be read",  # which takes what comes
    prefix="cost ", code=1)

# a figure that no disk takes; the few rows have been written then
expect_refused(f"cost tiny.toml --seconds 1e-3 --quiet -o {logs}/cost.csv --svg older.svg => older.svg: | too large", code=1,
               **size_limited())
finish()
