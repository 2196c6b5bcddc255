"""stratus phase: values, moments, summary, figure, and every refusal."""

from expect import *


def phase(arguments, **how):
    return expect_ok("phase " + arguments, **how)


# --- answers

said = phase("rayleigh --step 90", err="rayleigh: g 0", header="scattering_angle_deg,value")
expect_rows(said, 3, "abs(value - 0.75 * (1 + (scattering_angle_deg != 90))) < 1e-14")

said = phase("rayleigh henyey_greenstein:g=0.5 --moments 3 --quiet", err="", header="l,chi_1,chi_2")
expect_rows(said, 3, "abs(chi_2 - 0.5 ** l) < 1e-14")

phase("mie:radius=0.5um,variance=0.1,index=1.5+0.01i --moments 100 -o chi.csv --svg phase.svg", out="",
      err=": g 0. | , albedo 0. | , extinction efficiency  | , effective radius 0.5 um")
expect_svg("phase.svg")

# moments that were written are a phase function
said = phase("moments:file=chi.csv mie:radius=500nm,index=1.5+0.01i,variance=0.1 --step 30")
expect_rows(said, 7, "abs(value_1 / value_2 - 1) < 1e-6")
# and so are values that were written: 180 degrees less a scattering angle is a phase angle
phase("henyey_greenstein:g=0.6 -o values.csv")
said = phase("tabulated:file=values.csv henyey_greenstein:g=0.6 --step 7.5", err="tabulated:file=values.csv: g 0.6")
expect_rows(said, 25, "abs(value_1 / value_2 - 1) < 1e-3")

moments = "phase rayleigh --moments 3 --quiet"
expect_every_output(moments)
if os.access("/dev/full", os.W_OK):
    expect_refused(moments + " -o /dev/full => /dev/full: No space left on device", code=1)

# --- refusals

write("weighted.csv", "l,chi", "0,1", "1,2.25", "2,2.8")
expect_refused(
    "moments:file=weighted.csv => chi_1 (weighted.csv, line 3) | (2 l + 1) chi_l divided by 2 l + 1 | got 2.25",
    " => PHASE | required",
    "mie:radius=10 => radius | um or nm | got '10'",
    "mie:radius=1um,variance=0.6 => variance | [1e-6, 0.5] | got 0.6",
    "mie:radius=1000um -o new.csv => largest droplet | at most 10000",
    "rayleigh --moments 0 => --moments | [1, 20000] | got 0",
    "rayleigh --step 0 => --step | [0.001, 90] | got 0",
    "rayleigh --svg phase.png => --svg | .svg | got phase.png",
    "rayleigh -o '' => --output | file | got nothing", prefix="phase ")
expect_refused("phase rayleigh -o absent/new.csv => absent/new.csv | no folder absent", code=1)
finish()
