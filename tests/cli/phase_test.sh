#!/usr/bin/env bash
# stratus phase: values, moments, summary, figure, and every refusal.
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

# --- answers

expect_ok phase rayleigh --step 90
expect_header scattering_angle_deg,value
expect_rows 3 '(f["value"] - 0.75 * (1 + (f["scattering_angle_deg"] != 90))) ^ 2 < 1e-28'
expect_says "$err" "rayleigh: g 0"

expect_ok phase rayleigh henyey_greenstein:g=0.5 --moments 3 --quiet
expect_silent "$err"
expect_header l,chi_1,chi_2
expect_rows 3 '(f["chi_2"] - 0.5 ^ f["l"]) ^ 2 < 1e-28'

expect_ok phase mie:radius=0.5um,variance=0.1,index=1.5+0.01i --moments 100 -o chi.csv --svg phase.svg
expect_silent "$out"
expect_says "$err" ": g 0." ", albedo 0." ", extinction efficiency " ", effective radius 0.5 um"
grep -q '<svg ' phase.svg || fail "the figure must be an SVG"
if command -v python3 >/dev/null; then
    python3 -c 'import sys, xml.dom.minidom; xml.dom.minidom.parse(sys.argv[1])' phase.svg 2>"$logs/xml" ||
        fail "the figure must be XML: $(cat "$logs/xml")"
fi

# moments that were written are a phase function
expect_ok phase moments:file=chi.csv mie:radius=500nm,index=1.5+0.01i,variance=0.1 --step 30
expect_rows 7 '(f["value_1"] / f["value_2"] - 1) ^ 2 < 1e-12'

# and so are values that were written: 180 degrees less a scattering angle is a phase angle
expect_ok phase henyey_greenstein:g=0.6 -o values.csv
expect_ok phase tabulated:file=values.csv henyey_greenstein:g=0.6 --step 7.5
expect_rows 25 '(f["value_1"] / f["value_2"] - 1) ^ 2 < 1e-6'
expect_says "$err" "tabulated:file=values.csv: g 0.6"

# devices, pipes and what is open take the values behind what they hold
expect_ok phase rayleigh --moments 3 --quiet
cp "$out" moments.csv
(echo before && cat moments.csv) >expected.csv
echo before >kept.csv
"$stratus" phase rayleigh --moments 3 --quiet -o /dev/stdout >>kept.csv
expect_same kept.csv expected.csv
mkfifo pipe
timeout 20 cat pipe >piped.csv &
expect_ok phase rayleigh --moments 3 --quiet -o pipe
wait $!
expect_same piped.csv moments.csv
[ ! -w /dev/full ] || expect_refused 1 "/dev/full: No space left on device" -- phase rayleigh --moments 3 --quiet -o /dev/full

# --- refusals

printf 'l,chi\n0,1\n1,2.25\n2,2.8\n' >weighted.csv
expect_refused 2 "chi_1 (weighted.csv, line 3)" "(2 l + 1) chi_l divided by 2 l + 1" "got 2.25" -- phase moments:file=weighted.csv

expect_refused 2 PHASE required -- phase
expect_refused 2 radius "um or nm" "got '10'" -- phase mie:radius=10
expect_refused 2 variance "[1e-6, 0.5]" "got 0.6" -- phase mie:radius=1um,variance=0.6
expect_refused 2 "largest droplet" "at most 10000" -- phase mie:radius=1000um -o new.csv
expect_refused 2 --moments "[1, 20000]" "got 0" -- phase rayleigh --moments 0
expect_refused 2 --step "[0.001, 90]" "got 0" -- phase rayleigh --step 0
expect_refused 2 --svg .svg "got phase.png" -- phase rayleigh --svg phase.png
expect_refused 2 --output file "got nothing" -- phase rayleigh -o ''
expect_refused 1 absent/new.csv "no folder absent" -- phase rayleigh -o absent/new.csv
finish
