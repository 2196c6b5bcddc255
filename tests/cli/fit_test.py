"""stratus fit: recovers known layers, reports undetermined parameters, refuses bad rows."""

from itertools import combinations, product
from math import acos, cos, degrees, exp, radians, sqrt

from expect import *

fixtures("mixed", "full", "endless", "family")
columns = "mu_in,mu_out,azimuth_deg,brightness,sigma"


def observe(w1, w2, depth, *more):
    """Yields rows of a ring's brightness from the table, of both sides, each with a standard deviation of 1 %."""
    views = product((0.2, 0.6), (0.15, 0.5, 0.9), (10, 90, 170), (depth,), (w1 + w2,), (w1 / (w1 + w2),))
    write("query.csv", "mu_in,mu_out,azimuth_deg,optical_depth,albedo,mixture", *(",".join(map(str, view)) for view in views))
    for row in expect_ok("eval mixed.h5 --query query.csv").rows:
        for mu_out, light in (row.mu_out, row.mu_in * row.reflection), (-row.mu_out, row.mu_in * row.transmission):
            yield ",".join(map(str, (row.mu_in, mu_out, row.azimuth_deg, light, light / 100, *more)))


def observe_lit(name, command):
    """Writes what a command says of the lit side as observations."""
    write(name, columns, *(f"{row.mu_in},{row.mu_out},{row.azimuth_deg},{row.mu_in * row.reflection},0.001"
                           for row in expect_ok(command).rows))


def columns_of(*parameters):
    pairs = (f"{kind}_{one}_{other}" for kind in ("covariance", "correlation") for one, other in combinations(parameters, 2))
    return ",".join([*(f"{name},{name}_sigma" for name in parameters), *pairs,
                     "chi_square,degrees_of_freedom,probability,remarks"])


def fit(arguments, header=None, within=1e-3, **expected):
    """Returns the one row of a fit, some of whose figures are expected."""
    said = expect_ok("fit " + arguments, header=header)
    expect_rows(said, 1)
    for name, value in expected.items():
        expect_near(getattr(said.row, name), value, within)
    return said.row


def with_column(name, target, column, value):
    first, *rows = read(name).splitlines()
    write(target, f"{first},{column}", *(f"{row},{value}" for row in rows))


# --- answers

write("one.csv", columns, *observe(0.5, 0.25, 1.2))
ring = columns_of("w1", "w2", "optical_depth")
row = fit("one.csv --table mixed.h5", ring, w1=0.5, w2=0.25, optical_depth=1.2, degrees_of_freedom=33)
expect(row.chi_square < 0.01 and row.probability > 0.999 and row.remarks == "", "the fit must be a good one")
expect(0 < row.w1_sigma < 0.05 and abs(row.covariance_w1_w2) < row.w1_sigma * row.w2_sigma, "other deviations")
expect_near(row.correlation_w1_w2 * row.w1_sigma * row.w2_sigma / row.covariance_w1_w2, 1, 1e-10)
expect_every_output("fit one.csv --table mixed.h5")
said = expect_ok("fit - --table mixed.h5", stdin=read("one.csv"), err="")
expect_ok("convert mixed.h5 mixed.exr")
expect(expect_ok("fit one.csv --table mixed.exr").out == said.out, "both files of a table must give the same fit")

# a fit for each radius, in the order of the file, on any number of threads
write("bins.csv", columns + ",radius", *observe(0.5, 0.25, 1.2, 100.5), *observe(0.1, 0.7, 0.3, 74.5))
said = expect_ok("fit bins.csv --table mixed.h5 --threads 1", header="radius," + ring)
for row, (radius, w1, depth) in zip(said.rows, [(100.5, 0.5, 1.2), (74.5, 0.1, 0.3)], strict=True):
    expect(row.radius == radius, "the first radius comes first")
    expect_near(row.w1, w1, 1e-3)
    expect_near(row.optical_depth, depth, 1e-3)
expect(expect_ok("fit bins.csv --table mixed.h5 --threads 3").out == said.out, "threads must not change fits")

# undetermined parameters are named: the depth of a deep layer from its lit side
write("deep.csv", columns, *(row for row in observe(0.3, 0.2, 7) if ",-" not in row))
expect_ok("fit deep.csv --table mixed.h5", out='"optical_depth not determined by these geometries (above ')

# parameters that are held: not varied, no variance, one degree of freedom more
row = fit("one.csv --table mixed.h5 --fix w2=0.25", ring, w1=0.5, optical_depth=1.2, degrees_of_freedom=34)
expect(row.w2 == 0.25 and row.w2_sigma == row.covariance_w1_w2 == 0 != row.covariance_w1_optical_depth, "w2 must be held")
row = fit("one.csv --table mixed.h5 --fix w1=0.5,tau=1.2", w2=0.25, degrees_of_freedom=35)
expect(row.optical_depth == 1.2, "the depth must be held")
expect_ok("fit one.csv --table mixed.h5 --fix w2=0.35",  # contradicts the rows
          out='"refused: chi_square  | for 34 degrees of freedom (probability ')

# a table of one phase function has w and tau alone
layer = columns_of("w", "optical_depth")
views = "0.5,0.8,60", "0.3,0.2,180", "0.9,0.5,0"
write("query.csv", "mu_in,mu_out,azimuth_deg,optical_depth,albedo", *(view + ",1.5,0.9" for view in views))
effects = "--density 0.1 --opposition hapke:width=0.05"
observe_lit("w.csv", f"eval full.h5 --query query.csv --effects reflection {effects}")
fit("w.csv --table full.h5 " + effects, layer, w=0.9, optical_depth=1.5, degrees_of_freedom=1)

# without a table: light scattered once, (w/4) (1 - exp(-tau (1/mu + 1/mu0))) / (mu + mu0) of isotropic particles
w, tau = 0.8, 0.6
write("once.csv", "side,mu_in,mu_out,azimuth_deg,brightness,sigma", *(row for mu in (0.2, 0.4, 0.6, 0.8) for row in (
    f"lit,0.5,{mu},90,{0.5 * w / 4 * (1 - exp(-tau * (1 / mu + 2))) / (mu + 0.5)},0.001",
    f"beam,1,{mu},0,{exp(-tau / mu)},0.001")))
fit("once.csv --single --phase isotropic", layer, w=w, optical_depth=tau, degrees_of_freedom=6)
fit("once.csv --single --phase henyey_greenstein:g=0.3 --second-phase lambert_sphere --fix w2=0 --free g1",
    columns_of("w1", "w2", "optical_depth", "g1"), w1=w, optical_depth=tau, g1=0)
write("query.csv", "mu_in,mu_out,azimuth_deg", "0.5,0.3,20", "0.5,0.8,160", "0.2,0.4,90")
observe_lit("all.csv", "solve --phase henyey_greenstein:g=0.4 --albedo 0.9 --optical-depth 0.6 --query query.csv")
fit("all.csv --phase henyey_greenstein:g=0.4", w=0.9, optical_depth=0.6)

# occultations alone need nothing else: tau = -mu ln I, its standard deviation mu sigma / I
write("star.csv", "side,mu_out,brightness,sigma", "beam,0.5,0.3,0.01")
fit("star.csv", columns_of("optical_depth"), optical_depth=0.6019864, optical_depth_sigma=0.0166667)
fit("star.csv --density 0.5", optical_depth=0.3009932, optical_depth_sigma=0.0083333)

# what the model makes of every row, as text and drawn; words stay words
first, *rows = (row.split(",") for row in read("once.csv").splitlines())
noisy = [",".join([*row[:4], str(float(row[4]) + 0.001 * (i % 3 - 1)), row[5]]) for i, row in enumerate(rows, 2)]
write("noisy.csv", ",".join(first), *noisy)
row = fit("noisy.csv --single --phase isotropic --rows rows.csv --svg fit.svg")
told = Answer(out=read("rows.csv"))
expect(told.header == "side,mu_in,mu_out,azimuth_deg,brightness,sigma,model,residual", "another header")
expect_rows(told, 8, "abs(brightness - model - residual) < 1e-15 and (side == 'lit') == (mu_in == 0.5)")
expect_near(sum((each.residual / each.sigma) ** 2 for each in told.rows), row.chi_square, 1e-5)
write("beams.csv", ",".join(first), *(row for row in noisy if "beam" in row))
expect_ok("fit beams.csv --svg beams.svg")
expect_ok("fit star.csv --svg star.svg")  # one point
for figure in "fit.svg", "beams.svg", "star.svg":
    expect_svg(figure)

# angles as observers have them are the same rows; of beams the emission angle alone counts
angles = "incidence_deg,emission_deg,phase_deg"
rows = []
for row in Answer(out=read("all.csv")).rows:
    sines = sqrt((1 - row.mu_in ** 2) * (1 - row.mu_out ** 2))
    phase = 180 - degrees(acos(sines * cos(radians(row.azimuth_deg)) - row.mu_in * row.mu_out))
    rows.append(f"{degrees(acos(row.mu_in))},{degrees(acos(row.mu_out))},{phase},{row.brightness},{row.sigma}")
write("angles.csv", angles + ",brightness,sigma", *rows)
fit("angles.csv --phase henyey_greenstein:g=0.4", w=0.9, optical_depth=0.6)
write("sun.csv", "side,emission_deg,brightness,sigma", "beam,60,0.3,0.01", "beam,120,0.3,0.01")
fit("sun.csv", optical_depth=0.6019864)
write("query.csv", angles, "60,35,40", "60,120,90", "30,150,150")
seen = expect_ok("solve --phase isotropic --albedo 0.9 --optical-depth 0.6 --query query.csv").rows
write("both_sides.csv", angles + ",brightness,sigma", *(
    f"{row.incidence_deg:g},{row.emission_deg:g},{row.phase_deg:g},{cos(radians(row.incidence_deg)) * light},0.001"
    for row in seen for light in [row.reflection if row.emission_deg < 90 else row.transmission]))
fit("both_sides.csv --phase isotropic", w=0.9, optical_depth=0.6)

# a family's parameter is free, or held, or a column
write("query.csv", "mu_in,mu_out,azimuth_deg,optical_depth,albedo,g", *(
    view + ",1.5,0.9,0.42" for view in (*views, "0.6,0.3,20")))
observe_lit("lobes.csv", "eval family.h5 --query query.csv --effects reflection")
free = fit("lobes.csv --table family.h5", columns_of("w", "optical_depth", "g"), w=0.9, optical_depth=1.5, g=0.42,
           degrees_of_freedom=1)
expect(fit("lobes.csv --table family.h5 --free g") == free, "g must be free unless it is held")
fit("lobes.csv --table family.h5 --fix g=0.42", layer, w=0.9, degrees_of_freedom=2)
with_column("lobes.csv", "known.csv", "g,pixel", "0.42,7")
fit("known.csv --table family.h5", "pixel," + layer, pixel=7, w=0.9, degrees_of_freedom=2)

expect_ok("fit --help", out="I/F = mu_in R | mu_out < 0 | exp(-tau / mu_out) | --single | probability | --rows | emission_deg")

# --- refusals

write("older.csv", "older")
lines = read("one.csv").splitlines()
for row, fragments in cases(
        "0,0.5,0,0.1,0.01 => mu_in | (0, 1] | got 0",
        "0.5,0,0,0.1,0.01 => mu_out | [-1, 1] and not 0 | got 0",
        "0.5,-1.5,0,0.1,0.01 => mu_out | [-1, 1] | got -1.5",
        "0.5,0.5,inf,0.1,0.01 => azimuth_deg | finite | got inf",
        "0.5,0.5,0,inf,0.01 => brightness | finite | got inf",
        "0.5,0.5,0,0.1,0 => sigma | (0, inf) | got 0",
        "0.5,0.5,0,0.1,-0.01 => sigma | (0, inf) | got -0.01",
        "0.5,0.5,0,dark,0.01 => brightness | got 'dark'",
        "0.5,0.5,0,0.1 => 5 values | got 4"):
    write("bad.csv", *lines[:3], row, *lines[3:])
    expect_refused(f"fit bad.csv --table mixed.h5 -o older.csv => bad.csv, line 4 | {fragments}")


def expect_bad(arguments, *rows):
    """Refuses the table of these rows."""
    if rows:
        write("bad.csv", *rows)
    expect_refused("fit bad.csv " + arguments)


expect_bad("--table '' --phase isotropic => --table | the name of a file, got nothing", *lines)
expect_bad("--phase '' => --phase | a phase function, got nothing")
expect_bad("--table mixed.h5 => bad.csv | at least 3 | free parameter | got 2", *lines[:3])
expect_bad("--table mixed.h5 => bad.csv | at least 3 | got 1 of 3", read("bins.csv") + "0.5,0.5,0,0.1,0.01,3")
expect_bad("--table mixed.h5 => brightness / sigma | [-1e100, 1e100] | got inf", *lines, "0.5,0.5,0,1e308,0.01")
expect_bad("--table mixed.h5 => bad.csv | no observations", columns)
expect_bad("--table mixed.h5 => bad.csv | sigma", *(line.rpartition(",")[0] for line in lines))
expect_bad("--table mixed.h5 => bad.csv | sigma", columns.replace("sigma", "error"), *lines[1:])
expect_bad("--phase isotropic => bad.csv | mu_in", "side,mu_out,brightness,sigma", "lit,0.5,0.3,0.01")
expect_bad(" => line 2 | mu_out | (0, 1] | got -0.5", "side,mu_out,brightness,sigma", "beam,-0.5,0.3,0.01")
with_column("one.csv", "bad.csv", "side", 1)
expect_bad("--table mixed.h5 => bad.csv | line 2 | lit, unlit, beam | got '1'")
edit("known.csv", "bad.csv", ("0.42,7", "0.7,7"))
expect_bad("--table family.h5 => bad.csv, line 2 | g | in [0.3, 0.6] of the table | got 0.7")
with_column("known.csv", "bad.csv", "radius", 7)
expect_bad("--table family.h5 => bad.csv | column pixel | without radius | got both")
edit("both_sides.csv", "bad.csv", ("120,90", "120,20"))
expect_bad("--phase isotropic => bad.csv, line 3 | phase_deg | [60, 180] at incidence_deg 60 and emission_deg 120 | got 20")
with_column("both_sides.csv", "bad.csv", "side", "lit")
expect_bad("--phase isotropic => bad.csv, line 3 | emission_deg | below 90 on the side lit | got 120")
with_column("both_sides.csv", "bad.csv", "mu_in", 1)
expect_bad("--phase isotropic => bad.csv | one of incidence_deg, emission_deg, phase_deg | got mu_in")
write("narrow.toml", "phase_function = 'rayleigh'", "tolerance = 1e-2", "optical_depth = { min = 0.5, max = 1 }",
      "albedo = { min = 1, max = 1 }", "mu_in = { min = 0.3, max = 0.7 }", "azimuth_deg = { min = 20, max = 130 }")
expect_ok("bake narrow.toml -o narrow.stratus --quiet")
expect_bad("--table narrow.stratus => bad.csv, line 3 | mu_in | in [0.3, 0.7] of the table | got 0.95",
           columns, "0.5,0.5,90,0.1,0.01", "0.95,0.5,90,0.1,0.01")
expect_refused(
    "one.csv => --table or --phase | neither",
    "one.csv --table mixed.h5 --phase isotropic => --table | --phase | both",
    "one.csv --table mixed.h5 --single => --table | --single | both",
    "star.csv --single => --single | --phase | alone",
    "star.csv --second-phase isotropic => --second-phase | --phase | alone",
    "one.csv --phase isotopic => isotopic | isotropic",
    "one.csv --table full.h5 --fix w2=1 => --fix | w, tau, g | got w2=1",
    "one.csv --phase henyey_greenstein:g=0.1 --second-phase isotropic --fix g1=0 --free g1 => --free | --fix | got g1",
    "one.csv --table endless.h5 => one.csv | line 3 | side | table holds | got unlit",
    "lobes.csv --table family.h5 --fix g=0.7 => g held | in [0.3, 0.6] of the table | got 0.7",
    "lobes.csv --table family.h5 --fix radius=8 => --fix | w, tau, g, | got radius=8",
    "known.csv --table family.h5 --fix g=0.42 => either held or known | got both",
    "known.csv --table full.h5 => known.csv | column g | left out unless",
    "star.csv --svg fit.png => --svg | .svg | got fit.png",
    "star.csv --rows star.csv => star.csv | another", prefix="fit ")
expect_refused(
    "--fix w3=1 => --fix | w1, w2, tau, g1, g2 | got w3=1",
    "--fix w1 => --fix | NAME=VALUE | got w1",
    "--fix w1=much => --fix | NAME=VALUE | got w1=much",
    "--fix w1=0.2,w1=0.3 => --fix | w1 once | got w1=0.3",
    "--fix w1=2 => w1 held | [0, 1] | got 2",
    "--free g2 => g2 | Henyey-Greenstein | got free",
    "--density 1 => --density | [0, 1) | got 1",
    "--opposition lommel => --opposition | fit:  | got lommel",
    "--threads -1 => --threads | [0, 1024] | got -1",
    "-o ./one.csv => one.csv | another",
    "-o mixed.h5 => mixed.h5 | another",
    "--rows mixed.h5 => mixed.h5 | another file than the input",
    "-o same.csv --rows ./same.csv => same.csv | another file than the other output", prefix="fit one.csv --table mixed.h5 ")
expect_refused(
    "star.csv --rows absent/rows.csv => absent/rows.csv | no folder absent",
    "absent.csv --table mixed.h5 => absent.csv",
    "one.csv --table absent.h5 => absent.h5",
    "one.csv --table mixed.h5 -o absent/out.csv => absent/out.csv", prefix="fit ", code=1)
finish()
