"""stratus solve: known figures, queries, phase functions, and every refusal."""

import re

from expect import *

columns = "mu_in,mu_out,azimuth_deg"


def query(*rows, columns=columns):
    write("query.csv", columns, *rows)


def solve(arguments, **how):
    return expect_ok("solve " + arguments, **how)


def fluxes(arguments, within=0, **expected):
    """Returns the fluxes of a layer, some of which are expected."""
    met = solve(arguments).json
    for name, values in expected.items():
        found = getattr(met, name)
        for pair in zip(found, values, strict=True) if isinstance(values, list) else [(found, values)]:
            expect_near(*pair, within)
    return met


# --- fluxes

said = solve("--phase isotropic --albedo 1 --optical-depth 1", err="")
expect(re.search(r'"spherical_albedo": 0\.\d{15,17},\n', said.out), "17 significant digits are needed")
expect_near(said.json.spherical_albedo, 0.446594006673394, 1e-9)
expect_near(said.json.total_transmittance, 0.553405993326606, 1e-9)
expect_near(said.json.absorptance, 0, 0)

# independent figures: long double, 64 nodes
met = fluxes("--phase henyey_greenstein:g=0.75 --albedo 0.99 --optical-depth 8 --mu-in 1,0.5 --nodes 64", 1e-9,
             spherical_albedo=0.537148228651, total_transmittance=0.322024848212, absorptance=0.140826923137)
expect(met.mu_in == [1, 0.5], "mu_in must come back as it was asked for")
expect_near(met.plane_albedo[0], 0.433048223113, 1e-9)
expect_near(met.direct_transmittance[0], 0.00033546262790251185, 1e-18)
expect_near(met.direct_transmittance[1], 1.1253517471925912e-07, 1e-21)
expect(len(met.diffuse_transmittance) == 2, "each mu_in needs a diffuse transmittance")

# the limits: no layer, no end to it
fluxes("--phase rayleigh --albedo 0.5 --optical-depth 0 --mu-in 0.5", spherical_albedo=0, total_transmittance=1)
met = fluxes("--phase rayleigh --albedo 1 --optical-depth inf --mu-in 0.5", 1e-12, spherical_albedo=1, plane_albedo=[1])
expect(met.optical_depth == "inf", "JSON has no infinity: it must be the word inf")
expect_near(met.total_transmittance, 0, 0)

# nodes and schemes: more nodes come nearer, both schemes to the same
layer = "--phase henyey_greenstein:g=0.5 --albedo 0.9 --optical-depth 2 "
fine = fluxes(layer + "--nodes 48").spherical_albedo
expect(fluxes(layer + "--nodes 2").spherical_albedo != fine, "two nodes must show")
fluxes(layer + "--nodes 016", 1e-7, spherical_albedo=fine)
classic = fluxes(layer + "--scheme classic").spherical_albedo
fluxes(layer + "--scheme harmonic", 1e-7, spherical_albedo=classic)

# --- reference solvers: every scheme agrees within its stated error

query("0.5,0.8,60", "0.2,0.2,180")
layer = "--phase isotropic --albedo 0.9 --optical-depth 1 --query query.csv "
first = solve(layer).row


def expect_agreement(scheme, within=0, errors=0):
    """The first row of this scheme is near the solver's: within so much, or so many of the row's own errors."""
    said = solve(layer + scheme)
    expect_rows(said, 2, "abs(reflection - reflection_single - reflection_multiple) < 1e-15")
    row = said.row
    if errors:
        expect(row.reflection_error > 0, f"{scheme} must tell its error")
        within = errors * (row.reflection_error + row.transmission_error)
    expect_near(row.reflection, first.reflection, within)
    expect_near(row.transmission, first.transmission, within)
    return said.out


expect_agreement("--scheme h-function", 1e-9)
expect_agreement("--scheme classic --start single --start-depth 1e-6", 1e-5)
expect_agreement("--scheme classic --start diamond --start-depth 1e-5", 1e-6)
expect_agreement("--scheme markov --sublayers 16", errors=1)
isotropic = layer
layer = "--phase henyey_greenstein:g=0.9 --albedo 0.95 --optical-depth 2 --query query.csv "
first = solve(layer).row
expect_agreement("--scheme markov --sublayers 8", errors=1)
layer = isotropic
first = solve(layer).row
photons = "--scheme photons --photons 20000 "
drawn = expect_agreement(photons + "--threads 1", errors=4)
expect(solve(layer + photons + "--threads 2").out == drawn, "threads must not change what photons find")
expect(solve(layer + photons + "--seed 2").out != drawn, "another seed must draw other photons")
expect(expect_agreement(photons + "--backward-collisions 4", errors=4) != drawn, "paths followed back must draw other photons")

# fluxes of each, too
layer = "--phase isotropic --albedo 0.9 --optical-depth 1 --mu-in 0.5 "
met = fluxes(layer)
fluxes(layer + "--scheme h-function", 1e-10, spherical_albedo=met.spherical_albedo, plane_albedo=met.plane_albedo)
markov = fluxes(layer + "--scheme markov")
expect_near(markov.plane_albedo[0], met.plane_albedo[0], markov.error)
without = fluxes(layer.replace("--mu-in 0.5", "--scheme markov"))
expect(without.error < 1e-4, f"the error without cosines is {without.error}")
expect_near(without.spherical_albedo, met.spherical_albedo, without.error)
drawn = fluxes(layer + "--scheme photons --photons 50000")
expect_near(drawn.plane_albedo[0], met.plane_albedo[0], 4 * drawn.plane_albedo_error[0])

# orders one by one
layer = "--phase rayleigh --albedo 0.8 --optical-depth 1 "
said = solve(layer + "--query query.csv --orders 3")
expect_rows(said, 2, "abs(reflection_order_1 - reflection_single) < 1e-14")
expect_rows(said, 2, "abs(transmission_order_1 + transmission_order_2 + transmission_order_3 - transmission) < 1e-14")
markov = solve(layer + "--query query.csv --orders 3 --scheme markov")
expect_near(markov.row.reflection_order_2, said.row.reflection_order_2, 1e-5)
expect(len(fluxes(layer + "--orders 2").spherical_albedo_of_order) == 2, "each order needs its flux")

# options that belong to other schemes, and what a reference solver cannot do
layer = "solve --phase isotropic --albedo 0.9 --optical-depth 1 "
expect_refused(
    "--seed 1 => --scheme | photons with --seed | got harmonic",
    "--backward-collisions 4 => --scheme | photons with --backward-collisions | got harmonic",
    "--scheme photons --backward-collisions 101 => --backward-collisions | [0, 100] | got 101",
    "--scheme markov --photons 10 => --scheme | photons with --photons | got markov",
    "--start single => --scheme | classic with --start | got harmonic",
    "--start-depth 1e-3 => --scheme | classic with --start-depth",
    "--sublayers 8 => --scheme | markov with --sublayers",
    "--scheme classic --orders 2 => --scheme | harmonic or markov or photons with --orders | got classic",
    "--orders 0 => --orders | [1, 200] | got 0",
    "--scheme classic --start-depth 2 => --start-depth | [1e-15, 1] | got 2",
    "--scheme photons --photons 1 => --photons | [2, 1000000000000] | got 1",
    "--scheme markov --sublayers 5 => sublayers | even | got 5",
    "--tolerance 0 => --tolerance | [1e-12, 1] | got 0",
    "--tolerance 1e-3 --nodes 8 => --tolerance | --nodes",
    "--scheme classic --tolerance 1e-3 => --scheme | harmonic with --tolerance | got classic",
    prefix=layer)
expect_refused("solve --phase rayleigh --albedo 1 --optical-depth inf --scheme photons => optical_depth | finite")

# negative answers are not passed over in silence
query("0.3,0.3,60", "1,0.3,90", "0.6,0.6,20", "1,1,0")
layer = "--phase henyey_greenstein:g=-0.9 --albedo 0.9 --optical-depth 1 --nodes 2 --query query.csv "
solve(layer, err="note | negative | series | --nodes")
solve(layer + "--quiet", err="")

# --- stacks

air = ["[[layers]]", "phase_function = 'rayleigh'", "albedo = 1.0", "optical_depth = 0.25"]
write("air.toml", *air)
layer = "--phase rayleigh --albedo 1 --optical-depth 0.25 --mu-in 0.5 "
one = fluxes(layer).plane_albedo
said = solve("--layers air.toml --mu-in 0.5", err="")
air_alone = said.json
expect_near(air_alone.plane_albedo[0], one[0], 1e-14)
expect_near(air_alone.direct_transmittance[0], 0.60653065971263342, 1e-16)
expect_near(air_alone.optical_depth, 0.25, 0)
expect_near(air_alone.absorptance, 0, 0)
expect("ground" not in said.out, "there is no ground to speak of")

# over a surface that takes in 0.7 of what falls on it, reflected back and forth: figures of one layer, put together by hand
falls = (1 - one[0]) / (1 - 0.3 * air_alone.spherical_albedo)  # of the sun's light on the surface
write("ground.toml", *air, "[below]", "lambert_albedo = 0.3")
over = fluxes("--layers ground.toml --mu-in 0.5", 1e-14, plane_ground_absorptance=[0.7 * falls],
              diffuse_transmittance=[falls - 0.60653065971263342])
expect_near(over.direct_transmittance[0], 0.60653065971263342, 1e-16)
expect_near(over.ground_absorptance, over.absorptance, 1e-14)
expect_near(over.total_transmittance, over.ground_absorptance / 0.7, 1e-14)
# the same ground by its text, a law that is Lambert's, and an ocean
for ground in "0.3", "rpv:rho0=0.3,k=1,theta=0,rho_c=1":
    fluxes(layer + "--over " + ground, 1e-13, plane_albedo=over.plane_albedo)
write("sea.toml", *air, "[below]", 'ground = "ocean:wind=5"')
sea = fluxes("--layers sea.toml --mu-in 0.5")
expect_near(sea.plane_ground_absorptance[0], 1 - sea.plane_albedo[0], 1e-12)
expect_refused(
    "--layers air.toml --over 0.3 => --over",
    "--phase isotropic --albedo 1 --optical-depth 1 --over ocean:wind=60 => wind must be in [0, 50] m/s | got 60",
    prefix="solve ")
query("0.5,0.8,60")
said = solve("--layers ground.toml --query query.csv")
expect_rows(said, 1, "transmission == 0")
said = solve("--layers ground.toml --query query.csv --orders 3")
expect_rows(said, 1, "abs(reflection_order_1 + reflection_order_2 + reflection_order_3 - reflection) < 1e-14")
expect_rows(said, 1, "reflection_order_1 == reflection_single and reflection_error < 1e-4 * reflection")

write("stack.toml", *air, "depth = 1")
expect_refused("solve --layers stack.toml => stack.toml, line 5: unknown key 'layer 1.depth' | did you mean")
for option in "--phase=rayleigh", "--albedo=1", "--optical-depth=1", "--scheme=classic":
    expect_refused(f"solve --layers air.toml {option} => --layers | {option.partition('=')[0]}")
expect_refused("solve --layers air.toml --mu-in 1 -o air.toml => air.toml | another file than the input")
expect_refused("solve --layers '' => --layers")
expect_refused("solve --layers absent.toml => absent.toml", code=1)

# --- tolerance: nodes are chosen, and every value has its error

query("0.5,0.5,0", "0.5,0.5,180", "0.2,0.9,60")
layer = "--phase henyey_greenstein:g=-0.9 --albedo 1 --optical-depth 10 --query query.csv "
fine = solve(layer + "--nodes 128").row.reflection
for tolerance in "1e-2", "1e-4", "1e-6":
    said = solve(layer + "--tolerance " + tolerance, err="")
    expect_rows(said, 3, f"0 < reflection_error <= {tolerance} * reflection")
    expect_near(said.row.reflection, fine, 2 * said.row.reflection_error)
said = solve(layer + "--nodes 12")
expect_rows(said, 3)
expect(said.row.reflection_error > 1e-2 * said.row.reflection, "twelve nodes are too few, which the error must tell")
met = fluxes("--phase henyey_greenstein:g=0.9 --albedo 0.9 --optical-depth 1 --tolerance 1e-9 --mu-in 0.5")
expect(0 < met.error < 1e-9, "fluxes need their error, within the tolerance")

# water as it absorbs in its band at 1.94 um: the same by material and by an index of that wavelength
query("0.6,0.7,90")
water, index = (
    solve(f"--phase mie:radius=10um,variance=0.1,wavelength=1.94um,{of} --albedo phase_function --optical-depth 20 "
          "--query query.csv").row.reflection for of in ("material=water", "index=1.2986+0.001911i"))
expect_near(water, index, 2e-4)

# one that is out of reach: the answers are printed all the same
query("0.1,0.15,0", "0.5,0.8,90")
layer = "--phase henyey_greenstein:g=0.999 --albedo 1 --optical-depth 2 --query query.csv --tolerance 1e-6 "
said = solve(layer, code=1, err="tolerance of 1e-06 is missed | of 2 rows | mu_in 0.1, mu_out 0.15, azimuth_deg 0 | --accept")
expect_rows(said, 2, "reflection_error > 0")
solve(layer + "--accept")

# --- queries

parts = ("reflection,transmission,reflection_single,transmission_single,reflection_multiple,transmission_multiple,"
         "reflection_error,transmission_error")


adds_up = ("reflection == reflection_single + reflection_multiple and "
           "transmission == transmission_single + transmission_multiple")
query("1,1,0", "0.5,0.5,0", "0.5,0.5,90", "0.5,0.5,180")
said = solve("--phase henyey_greenstein:g=0.75 --albedo 0.99 --optical-depth 8 --nodes 64 --query query.csv", err="",
             header=f"{columns},{parts}")
expect_rows(said, 4, adds_up)
for row, published, unit in zip(said.rows, [0.4157451335, 1.06218291, 0.58840936, 0.44184658], [1e-9, 1e-8, 1e-8, 1e-8]):
    expect_near(row.reflection, published, unit)
expect(re.search(r"^0.5,0.5,90,0\.\d{15,17},", said.out, re.M), "17 significant digits are needed")

# columns in any order; comments and blank lines; standard input
layer = "--phase rayleigh --albedo 0.9 --optical-depth 1.5 --nodes 8 "
query("0.5,0.8,60")
answer = solve(layer + "--query query.csv").rows
query("azimuth_deg,mu_out,mu_in", "", "60,0.8,0.5", columns="# in another order")
said = solve(layer + "--query -", stdin=read("query.csv"), header=f"azimuth_deg,mu_out,mu_in,{parts}")
expect(said.rows == answer, "the order of the columns must not change the answer")

expect_every_output(f"solve {layer} --query query.csv")
solve(layer + "-o fluxes.json", out="")
expect_says(read("fluxes.json"), "spherical_albedo")

# angles as observers have them are the same geometries: cosine 0.5 both, azimuth 180; cosine 0.5 below, straight on. Of
# the side that a row does not see there are no numbers
query("0.5,0.5,180", "0.5,0.5,0")
answer = solve(layer + "--query query.csv").rows
query("0,60,60", "180,60,120", columns="phase_deg,incidence_deg,emission_deg")
said = solve(layer + "--query query.csv", header=f"phase_deg,incidence_deg,emission_deg,{parts}")
expect_rows(said, 2, "(emission_deg < 90) == isnan(transmission_single) != isnan(reflection)")
expect_near(said.row.reflection, answer[0].reflection, 1e-14)
expect_near(said.rows[1].transmission, answer[1].transmission, 1e-14)

# the light inside: at both ends what leaves; energy from level to level; radiance
inside = "--phase henyey_greenstein:g=0.5 --albedo 1 --optical-depth 2 "
outside = fluxes(inside + "--mu-in 0.5,1")
said = solve(inside + "--mu-in 0.5,1 --levels 0,0.7,2",
             header="level,mu_in,direct_flux,diffuse_flux,upward_flux,actinic_flux,heating_rate,error")
expect_rows(said, 6, "heating_rate == 0 and error < 1e-4")
expect_near(said.row.upward_flux, outside.plane_albedo[0], 1e-5)
for mu_in in 0.5, 1:
    net = [row.direct_flux + row.diffuse_flux - row.upward_flux for row in said.rows if row.mu_in == mu_in]
    expect(len(net) == 3 and max(net) - min(net) < 1e-12, "the net flux must be one at all levels")
expect_rows(solve(inside + "--levels 1"), 1, "mu_in == 1")
query("0.5,0.8,60")
answer = solve(inside + "--query query.csv").row
said = solve(inside + "--query query.csv --levels 2,0", header=(
    columns + ",level,upward,downward,upward_single,downward_single,upward_multiple,downward_multiple,upward_error,downward_error"))
expect_near(said.row.downward, answer.transmission, 1e-4)
expect_near(said.rows[1].upward, answer.reflection, 1e-4)
query("60,40,50", "60,140,120", columns="incidence_deg,emission_deg,phase_deg")
expect_rows(solve(inside + "--query query.csv --levels 1"), 2,
            "(emission_deg < 90) == isnan(downward) and (emission_deg > 90) == isnan(upward)")
expect_refused(
    "--levels 3 => levels | in [0, 2], the optical depth | got 3",
    "--levels -1 => --levels | [0, inf) | got -1",
    "--levels 1 --orders 3 => --levels | --orders",
    "--levels 1 --scheme classic => --scheme | harmonic with --levels | got classic", prefix="solve " + inside)

# no rows, no answers
query()
expect_rows(solve(layer + "--query query.csv"), 0)

# more cosines than are solved at once: the same values as one by one
rows = [f"{(i + 1) / 301:.4f},{(i + 0.5) / 300:.4f},{7 * i % 360}" for i in range(300)]
query(*rows)
together = solve(layer + "--query query.csv")
expect_rows(together, 300, adds_up)
for i in 0, 31, 32, 148, 299:
    query(rows[i])
    single, among = solve(layer + "--query query.csv").row, together.rows[i]
    for part in "reflection", "transmission", "reflection_multiple", "transmission_multiple":
        # orders n >= 2 are R less the first
        expect_near(getattr(single, part), getattr(among, part), 1e-14 * (1 + among.reflection))

# an empty layer scatters nothing, however it is asked
query("0.5,0.8,60")
for albedo, depth, most in (1, 0, 0), (0, 1, 1e-15):
    said = solve(f"--phase rayleigh --albedo {albedo} --optical-depth {depth} --query query.csv")
    expect_rows(said, 1, f"max(abs(reflection), abs(transmission)) <= {most}")

# --- phase functions


def albedo_of(phase, **how):
    said = solve(f"--phase '{phase}' --albedo 0.9 --optical-depth 1 --nodes 16 --mu-in 0.3", **how)
    return said.json.plane_albedo[0]


Path("phases").mkdir()
write("phases/flat.csv", "phase_angle_deg,value", "0,1", "90,1", "180,1")
write("phases/flat_times_3.csv", "value,phase_angle_deg", "3,0", "3,90", "3,180")
write("phases/moments.csv", "l,chi", *(f"{l},{0.5 ** l}" for l in range(40)))
isotropic = albedo_of("isotropic")
for phase, within in [
        ("anisotropic:x=0", 1e-13), ("henyey_greenstein:g=0", 1e-13), ("tabulated:file=phases/flat_times_3.csv", 1e-9),
        ("0.5*anisotropic:x=0.5 + 0.5*anisotropic:x=-0.5", 1e-13),
        (f"0.7*tabulated:file={folder}/phases/flat.csv + 0.3*isotropic", 1e-9)]:
    expect_near(albedo_of(phase), isotropic, within)
expect_near(albedo_of("tabulated:file=phases/flat.csv", err=""), isotropic, 1e-9)
for phase in "rayleigh", "anisotropic:x=0.5", "lambert_sphere", "henyey_greenstein:g=-0.5":
    expect(albedo_of(phase) != isotropic, phase + " must not be isotropic")
solve("--phase tabulated:file=phases/flat_times_3.csv --albedo 1 --optical-depth 1 --nodes 4",
      err="note: phases/flat_times_3.csv | spherical mean 3")
expect_near(albedo_of("moments:file=phases/moments.csv"), albedo_of("henyey_greenstein:g=0.5"), 1e-9)

# the albedo of droplets is what `stratus phase` says of them
droplets = "mie:radius=5um,wavelength=3um,material=water"
stated = re.search(r"albedo ([\d.]*)", expect_ok("phase " + droplets).err)[1]
fluxes(f"--phase {droplets} --albedo phase_function --optical-depth 1 --nodes 16", 1e-8, albedo=float(stated))

# weights that do not sum to 1 are said in one note, and are no error
weighted = albedo_of("2*rayleigh + 6*isotropic", err="note: | weights summed to 8")
expect_near(albedo_of("0.25*rayleigh + 0.75*isotropic", err=""), weighted, 1e-14)
layer = "--phase '2*rayleigh + 6*isotropic' --albedo 0.9 --optical-depth 1 --nodes 16 "
expect(solve(layer).err.count("\n") == 1, "one note is enough")
solve(layer + "--quiet", err="")

# --- refusals

for option, allowed, values in [
        ("--albedo", "in [0, 1]", ["1.2", "-0.1", "nan", "inf", "0.5x", "x", ""]),
        ("--optical-depth", "in [0, inf]", ["-1", "nan", "1e"]),
        ("--nodes", "in [1, 512]", ["0", "513", "2.5", "99999999999999999999"]),
        ("--mu-in", "in (0, 1]", ["0", "1.0001", "x"]),
        ("--query", "the name of a file", [""]),
        ("--phase", "a phase function", [""]),
        ("--over", "a ground", [""]),
        ("--output", "the name of a file", [""])]:
    for value in values:
        options = {"--phase": "isotropic", "--albedo": "0.9", "--optical-depth": "1", option: f"'{value}'"}
        expect_refused("solve " + " ".join(f"{name} {given}" for name, given in options.items())
                       + f" => {option} | {allowed} | got {value or 'nothing'}")
expect_refused(
    "--mu-in 0.5,1.1 => --mu-in | (0, 1] | got 1.1",
    "--scheme fast => --scheme | fast | harmonic | classic",
    "--mu-in 1 --query query.csv => --query | --mu-in",
    "extra => extra",
    prefix="solve --phase isotropic --albedo 1 --optical-depth 1 ")
expect_refused(
    "--albedo 1 --optical-depth 1 => --phase is required",
    "--phase isotropic --optical-depth 1 => --albedo is required",
    "--phase isotropic --albedo 1 => --optical-depth is required",
    "--phase isotropic --optical-depth 1 --albedo => --albedo",
    "--phase rayleigh --optical-depth 1 --albedo droplets => --albedo | in [0, 1], or phase_function | got droplets",
    "--phase rayleigh --optical-depth 1 --albedo phase_function => --albedo | mie | got phase_function",
    "--phase rayleigh --optical-depth 1 --albedo 2 --query query.csv => --albedo | got 2", prefix="solve ")

layer = "solve --albedo 0.9 --optical-depth 1 --phase "
write("table.csv", "phase_angle_deg,value", "0,1", "90,-0.5", "180,1")
expect_refused("henyey_greenstein:g=1 => g must be in (-1, 1) | got 1",
               "tabulated:file=table.csv => value | table.csv, line 3 | at least 0 | got -0.5", prefix=layer)
expect_refused("tabulated:file=absent.csv => absent.csv", "moments:file=phases => phases", prefix=layer, code=1)

layer = "solve --phase rayleigh --albedo 0.9 --optical-depth 1.5 --nodes 8 "
for header, first, *rows in [
        (columns, "0.5,0.5,0",
         "0,0.5,0 => mu_in | (0, 1] | got 0",
         "1.0001,0.5,0 => mu_in | (0, 1] | got 1.0001",
         "0.5,-0.5,0 => mu_out | (0, 1] | got -0.5",
         "0.5,nan,0 => mu_out | nan",
         "0.5,0.5,inf => azimuth_deg | finite | got inf",
         "0.5,0.5 => 3 values | got 2"),
        ("incidence_deg,emission_deg,phase_deg", "30,30,0",
         "90,30,60 => incidence_deg | [0, 90) | got 90",
         "30,90,60 => emission_deg | beyond 90 is the unlit side | got 90",
         "30,50,81 => phase_deg | [20, 80] at incidence_deg 30 and emission_deg 50 | got 81")]:
    for row, fragments in cases(*rows):
        query(first, row, columns=header)
        expect_refused(f"{layer} --query query.csv => query.csv, line 3 | {fragments}")
for header, fragments in cases(
        "incidence_deg,emission_deg => phase_deg",
        "mu_in,azimuth_deg => mu_out",
        f"{columns},albedo => mu_in, mu_out | got albedo",
        "# nothing => header"):
    query(columns=header)
    expect_refused(f"{layer} --query query.csv => query.csv | {fragments}")
expect_refused("absent.csv => absent.csv", "phases => phases", prefix=layer + "--query ", code=1)

# files that cannot be written; an older one comes to no harm
expect_refused("absent/out.json => absent/out.json | No such file", "phases => phases | directory", prefix=layer + "-o ",
               code=1)
write("older.csv", "older")
query("0.5,0.5,0", "0.5,0.5,2x")
expect_refused("./query.csv => query.csv | another", "older.csv => got '2x'", prefix=layer + "--query query.csv -o ")
query(*(f"0.5,0.8,{i / 3:.6g}" for i in range(400)))
expect_refused(layer + "--query query.csv -o older.csv => older.csv | too large", code=1, **size_limited())
if where_permitted(small_disk):
    expect_refused("older.csv => disk/older.csv | No space left", "new.csv => disk/new.csv | No space left", code=1,
                   prefix=layer + "--query query.csv -o disk/", **small_disk)
if where_permitted(user_refused):
    expect_refused(layer + "-o shut/out.json => shut/out.json | Permission denied", code=1, **user_refused)
expect_full(layer)
finish()
