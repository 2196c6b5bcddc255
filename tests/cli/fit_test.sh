#!/usr/bin/env bash
# stratus fit: recovers known layers, reports undetermined parameters, refuses bad rows.
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

"$make_fixture" mixed mixed.h5 || exit 1
"$make_fixture" full full.h5 || exit 1
"$make_fixture" endless endless.h5 || exit 1
"$make_fixture" family family.h5 || exit 1

# observe W1 W2 DEPTH [RADIUS]: rows of a ring's brightness from the table, sigma 1 % of it, both sides
observe() {
    local mu_in mu_out azimuth
    echo mu_in,mu_out,azimuth_deg,optical_depth,albedo,mixture >"$logs/query.csv"
    for mu_in in 0.2 0.6; do
        for mu_out in 0.15 0.5 0.9; do
            for azimuth in 10 90 170; do
                awk -v in_out=$mu_in,$mu_out,$azimuth -v a="$1" -v b="$2" -v depth="$3" \
                    'BEGIN { printf "%s,%s,%.17g,%.17g\n", in_out, depth, a + b, a / (a + b) }' >>"$logs/query.csv"
            done
        done
    done
    "$stratus" eval mixed.h5 --query "$logs/query.csv" >"$logs/seen.csv" || fail "eval"
    awk -F, -v radius="${4:+,$4}" 'NR > 1 {
        printf "%s,%s,%s,%.17g,%.17g%s\n", $1, $2, $3, $1 * $7, $1 * $7 / 100, radius
        printf "%s,-%s,%s,%.17g,%.17g%s\n", $1, $2, $3, $1 * $8, $1 * $8 / 100, radius }' "$logs/seen.csv"
}
columns=mu_in,mu_out,azimuth_deg,brightness,sigma
pairs() { # pairs NAME...: columns of their covariances and correlations
    local kind first rest
    for kind in covariance correlation; do
        rest=("$@")
        while [ ${#rest[@]} -gt 1 ]; do
            first=${rest[0]}
            rest=("${rest[@]:1}")
            printf "${kind}_${first}_%s," "${rest[@]}"
        done
    done
}
judged=chi_square,degrees_of_freedom,probability,remarks
answer=w1,w1_sigma,w2,w2_sigma,optical_depth,optical_depth_sigma,$(pairs w1 w2 optical_depth)$judged
near() { echo "(f[\"$1\"] - $2) ^ 2 < 1e-6"; }  # within 0.001

# --- answers

{ echo $columns; observe 0.5 0.25 1.2; } >one.csv
expect_ok fit one.csv --table mixed.h5
expect_silent "$err"
expect_header $answer
expect_rows 1 "$(near w1 0.5) && $(near w2 0.25) && $(near optical_depth 1.2) && f[\"chi_square\"] < 0.01"
expect_rows 1 'f["probability"] > 0.999 && f["covariance_w1_w2"] ^ 2 < (f["w1_sigma"] * f["w2_sigma"]) ^ 2'
expect_rows 1 '(f["correlation_w1_w2"] * f["w1_sigma"] * f["w2_sigma"] / f["covariance_w1_w2"] - 1) ^ 2 < 1e-20'
expect_rows 1 'f["degrees_of_freedom"] == 33 && f["w1_sigma"] > 0 && f["w1_sigma"] < 0.05 && f["remarks"] == "\"\""'
cp "$out" answer.csv
expect_ok fit - --table mixed.h5 -o out.csv <one.csv
expect_silent "$out"
expect_same out.csv answer.csv
expect_ok convert mixed.h5 mixed.exr
expect_ok fit one.csv --table mixed.exr
expect_same "$out" answer.csv
rm out.csv mixed.exr

# a fit for each radius, in the order of the file, on any number of threads
{ echo $columns,radius; observe 0.5 0.25 1.2 100.5; observe 0.1 0.7 0.3 74.5; } >bins.csv
expect_ok fit bins.csv --table mixed.h5 --threads 1
expect_header radius,$answer
expect_rows 2 '(f["radius"] == 100.5) == ((f["w1"] - 0.5) ^ 2 < 1e-6)'
expect_rows 2 '(f["radius"] == 74.5) == ((f["optical_depth"] - 0.3) ^ 2 < 1e-6)'
sed -n 2p "$out" | grep -q '^100.5,' || fail "the first radius comes first"
cp "$out" answers.csv
expect_ok fit bins.csv --table mixed.h5 --threads 3
expect_same "$out" answers.csv

# undetermined parameters are named: the depth of a deep layer from its lit side
{ echo $columns; observe 0.3 0.2 7 | grep -v ',-'; } >deep.csv
expect_ok fit deep.csv --table mixed.h5
expect_says "$out" '"optical_depth not determined by these geometries (above '

# parameters that are held: not varied, no variance, one degree of freedom more
expect_ok fit one.csv --table mixed.h5 --fix w2=0.25
expect_header $answer
expect_rows 1 "$(near w1 0.5) && $(near optical_depth 1.2) && f[\"w2\"] == 0.25 && f[\"w2_sigma\"] == 0"
expect_rows 1 'f["degrees_of_freedom"] == 34 && f["covariance_w1_w2"] == 0 && f["covariance_w1_optical_depth"] != 0'
expect_ok fit one.csv --table mixed.h5 --fix w1=0.5,tau=1.2
expect_rows 1 "$(near w2 0.25) && f[\"optical_depth\"] == 1.2 && f[\"degrees_of_freedom\"] == 35"
expect_ok fit one.csv --table mixed.h5 --fix w2=0.35  # contradicts the rows
expect_says "$out" '"refused: chi_square ' 'for 34 degrees of freedom (probability '

# a table of one phase function has w and tau alone
echo mu_in,mu_out,azimuth_deg,optical_depth,albedo >query.csv
printf '%s,1.5,0.9\n' 0.5,0.8,60 0.3,0.2,180 0.9,0.5,0 >>query.csv
"$stratus" eval full.h5 --query query.csv --density 0.1 --opposition hapke:width=0.05 --effects reflection >seen.csv || fail "eval"
{ echo $columns; awk -F, 'NR > 1 { printf "%s,%s,%s,%.17g,0.001\n", $1, $2, $3, $1 * $6 }' seen.csv; } >w.csv
expect_ok fit w.csv --table full.h5 --density 0.1 --opposition hapke:width=0.05
expect_header w,w_sigma,optical_depth,optical_depth_sigma,$(pairs w optical_depth)$judged
expect_rows 1 "$(near w 0.9) && $(near optical_depth 1.5) && f[\"degrees_of_freedom\"] == 1"

# without a table: light scattered once, (w/4) (1 - exp(-tau (1/mu + 1/mu0))) / (mu + mu0) of isotropic particles
awk 'BEGIN {
    print "side,mu_in,mu_out,azimuth_deg,brightness,sigma"
    w = 0.8; tau = 0.6
    for (mu = 0.2; mu < 1; mu += 0.2) {
        printf "lit,0.5,%g,90,%.17g,0.001\n", mu, 0.5 * w / 4 * (1 - exp(-tau * (1 / mu + 2))) / (mu + 0.5)
        printf "beam,1,%g,0,%.17g,0.001\n", mu, exp(-tau / mu) } }' >once.csv
expect_ok fit once.csv --single --phase isotropic
expect_header w,w_sigma,optical_depth,optical_depth_sigma,$(pairs w optical_depth)$judged
expect_rows 1 "$(near w 0.8) && $(near optical_depth 0.6) && f[\"degrees_of_freedom\"] == 6"
expect_ok fit once.csv --single --phase henyey_greenstein:g=0.3 --second-phase lambert_sphere --fix w2=0 --free g1
expect_header "w1,w1_sigma,w2,w2_sigma,optical_depth,optical_depth_sigma,g1,g1_sigma,$(pairs w1 w2 optical_depth g1)$judged"
expect_rows 1 "$(near w1 0.8) && $(near optical_depth 0.6) && $(near g1 0)"
"$stratus" solve --phase henyey_greenstein:g=0.4 --albedo 0.9 --optical-depth 0.6 --query - >seen.csv <<END || fail "solve"
mu_in,mu_out,azimuth_deg
0.5,0.3,20
0.5,0.8,160
0.2,0.4,90
END
{ echo $columns; awk -F, 'NR > 1 { printf "%s,%s,%s,%.17g,0.001\n", $1, $2, $3, $1 * $4 }' seen.csv; } >all.csv
expect_ok fit all.csv --phase henyey_greenstein:g=0.4
expect_rows 1 "$(near w 0.9) && $(near optical_depth 0.6)"

# occultations alone need nothing else: tau = -mu ln I, its standard deviation mu sigma / I
printf 'side,mu_out,brightness,sigma\nbeam,0.5,0.3,0.01\n' >star.csv
expect_ok fit star.csv
expect_header optical_depth,optical_depth_sigma,$judged
expect_rows 1 "$(near optical_depth 0.6019864) && $(near optical_depth_sigma 0.0166667)"
expect_ok fit star.csv --density 0.5
expect_rows 1 "$(near optical_depth 0.3009932) && $(near optical_depth_sigma 0.0083333)"

# what the model makes of every row, as text and drawn; words stay words
awk -F, 'BEGIN { OFS = "," } NR > 1 { $5 += 0.001 * (NR % 3 - 1) } { print }' once.csv >noisy.csv
expect_ok fit noisy.csv --single --phase isotropic --rows rows.csv --svg fit.svg
chi_square=$(awk -F, 'NR == 2 { print $7 }' "$out")
cp rows.csv "$out"
expect_header side,mu_in,mu_out,azimuth_deg,brightness,sigma,model,residual
expect_rows 8 '(f["brightness"] - f["model"] - f["residual"]) ^ 2 < 1e-30 && (f["side"] == "lit") == (f["mu_in"] == 0.5)'
expect_near "$(awk -F, 'NR > 1 { sum += ($8 / $6) ^ 2 } END { print sum }' rows.csv)" "$chi_square" 1e-5
expect_says fit.svg "<svg "
awk -F, '/beam/ || NR == 1' noisy.csv >beams.csv
expect_ok fit beams.csv --svg beams.svg
expect_ok fit star.csv --svg star.svg  # one point
if command -v python3 >/dev/null; then
    for figure in fit.svg beams.svg star.svg; do
        python3 -c 'import sys, xml.dom.minidom; xml.dom.minidom.parse(sys.argv[1])' $figure 2>"$logs/xml" ||
            fail "$figure must be XML: $(cat "$logs/xml")"
    done
fi

# angles as observers have them are the same rows; of beams the emission angle alone counts
observed='BEGIN { FS = OFS = ","; d = atan2(0, -1) / 180 }
    function acos(c) { return atan2(sqrt((1 - c) * (1 + c)), c) / d }
    NR == 1 { print "incidence_deg,emission_deg,phase_deg,brightness,sigma"; next }
    { s = sqrt((1 - $1 ^ 2) * (1 - $2 ^ 2))
      printf "%.15g,%.15g,%.15g,%s,%s\n", acos($1), acos($2), 180 - acos(s * cos($3 * d) - $1 * $2), $4, $5 }'
awk "$observed" all.csv >angles.csv
expect_ok fit all.csv --phase henyey_greenstein:g=0.4
cp "$out" answer.csv
expect_ok fit angles.csv --phase henyey_greenstein:g=0.4
expect_rows 1 "$(near w 0.9) && $(near optical_depth 0.6)"
printf 'side,emission_deg,brightness,sigma\nbeam,60,0.3,0.01\nbeam,120,0.3,0.01\n' >sun.csv
expect_ok fit sun.csv
expect_rows 1 "$(near optical_depth 0.6019864)"
for view in 60,35,40 60,120,90 30,150,150; do echo $view; done >views.csv
{ echo incidence_deg,emission_deg,phase_deg; cat views.csv; } >query.csv
"$stratus" solve --phase isotropic --albedo 0.9 --optical-depth 0.6 --query query.csv >seen.csv || fail "solve"
{ echo incidence_deg,emission_deg,phase_deg,brightness,sigma
    awk -F, 'NR > 1 { printf "%s,%s,%s,%.17g,0.001\n", $1, $2, $3, cos($1 * atan2(0, -1) / 180) * ($2 < 90 ? $4 : $5) }' \
        seen.csv; } >both_sides.csv
expect_ok fit both_sides.csv --phase isotropic
expect_rows 1 "$(near w 0.9) && $(near optical_depth 0.6)"

# a family's parameter is free, or held, or a column
echo mu_in,mu_out,azimuth_deg,optical_depth,albedo,g >query.csv
for view in 0.5,0.8,60 0.3,0.2,180 0.9,0.5,0 0.6,0.3,20; do echo "$view,1.5,0.9,0.42"; done >>query.csv
"$stratus" eval family.h5 --query query.csv --effects reflection >seen.csv || fail "eval"
{ echo $columns; awk -F, 'NR > 1 { printf "%s,%s,%s,%.17g,0.001\n", $1, $2, $3, $1 * $7 }' seen.csv; } >lobes.csv
expect_ok fit lobes.csv --table family.h5
expect_header "w,w_sigma,optical_depth,optical_depth_sigma,g,g_sigma,$(pairs w optical_depth g)$judged"
expect_rows 1 "$(near w 0.9) && $(near optical_depth 1.5) && $(near g 0.42) && f[\"degrees_of_freedom\"] == 1"
cp "$out" answer.csv
expect_ok fit lobes.csv --table family.h5 --free g
expect_same "$out" answer.csv
expect_ok fit lobes.csv --table family.h5 --fix g=0.42
expect_header w,w_sigma,optical_depth,optical_depth_sigma,$(pairs w optical_depth)$judged
expect_rows 1 "$(near w 0.9) && f[\"degrees_of_freedom\"] == 2"
cp "$out" answer.csv
sed '1s/$/,g,pixel/; 2,$s/$/,0.42,7/' lobes.csv >known.csv
expect_ok fit known.csv --table family.h5
expect_header pixel,w,w_sigma,optical_depth,optical_depth_sigma,$(pairs w optical_depth)$judged
expect_rows 1 "$(near w 0.9) && f[\"pixel\"] == 7 && f[\"degrees_of_freedom\"] == 2"

expect_ok fit --help
expect_says "$out" "I/F = mu_in R" "mu_out < 0" "exp(-tau / mu_out)" "--single" "probability" "--rows" "emission_deg"

# --- refusals

refuse_row() { # refuse_row ROW FRAGMENT...: as line 4
    { sed -n 1,3p one.csv; echo "$1"; sed -n '4,$p' one.csv; } >bad.csv
    shift
    expect_refused 2 "bad.csv, line 4" "$@" -- fit bad.csv --table mixed.h5 -o older.csv
}
echo older >older.csv
refuse_row 0,0.5,0,0.1,0.01 mu_in "(0, 1]" "got 0"
refuse_row 0.5,0,0,0.1,0.01 mu_out "[-1, 1] and not 0" "got 0"
refuse_row 0.5,-1.5,0,0.1,0.01 mu_out "[-1, 1]" "got -1.5"
refuse_row 0.5,0.5,inf,0.1,0.01 azimuth_deg finite "got inf"
refuse_row 0.5,0.5,0,inf,0.01 brightness finite "got inf"
{ cat one.csv; echo 0.5,0.5,0,1e308,0.01; } >bad.csv
expect_refused 2 "brightness / sigma" "[-1e100, 1e100]" "got inf" -- fit bad.csv --table mixed.h5 -o older.csv
refuse_row 0.5,0.5,0,0.1,0 sigma "(0, inf)" "got 0"
refuse_row 0.5,0.5,0,0.1,-0.01 sigma "(0, inf)" "got -0.01"
refuse_row 0.5,0.5,0,dark,0.01 brightness "got 'dark'"
refuse_row 0.5,0.5,0,0.1 "5 values" "got 4"
sed -n 1,3p one.csv >bad.csv
expect_refused 2 bad.csv "at least 3" "free parameter" "got 2" -- fit bad.csv --table mixed.h5
{ cat bins.csv; echo 0.5,0.5,0,0.1,0.01,3; } >bad.csv
expect_refused 2 bad.csv "at least 3" "got 1 of 3" -- fit bad.csv --table mixed.h5
echo $columns >bad.csv
expect_refused 2 bad.csv "no observations" -- fit bad.csv --table mixed.h5
cut -d , -f 1-4 one.csv >bad.csv
expect_refused 2 bad.csv sigma -- fit bad.csv --table mixed.h5
sed '1s/sigma/error/' one.csv >bad.csv
expect_refused 2 bad.csv sigma -- fit bad.csv --table mixed.h5
sed '1s/$/,side/; 2,$s/$/,1/' one.csv >bad.csv
expect_refused 2 bad.csv "line 2" "lit, unlit, beam" "got '1'" -- fit bad.csv --table mixed.h5
expect_refused 2 "--table or --phase" neither -- fit one.csv
expect_refused 2 --table --phase both -- fit one.csv --table mixed.h5 --phase isotropic
expect_refused 2 --table --single both -- fit one.csv --table mixed.h5 --single
expect_refused 2 --single --phase alone -- fit star.csv --single
expect_refused 2 --second-phase --phase alone -- fit star.csv --second-phase isotropic
expect_refused 2 isotopic isotropic -- fit one.csv --phase isotopic
expect_refused 2 --fix "w1, w2, tau, g1, g2" "got w3=1" -- fit one.csv --table mixed.h5 --fix w3=1
expect_refused 2 --fix "w, tau, g" "got w2=1" -- fit one.csv --table full.h5 --fix w2=1
expect_refused 2 --fix NAME=VALUE "got w1" -- fit one.csv --table mixed.h5 --fix w1
expect_refused 2 --fix NAME=VALUE "got w1=much" -- fit one.csv --table mixed.h5 --fix w1=much
expect_refused 2 --fix "w1 once" "got w1=0.3" -- fit one.csv --table mixed.h5 --fix w1=0.2,w1=0.3
expect_refused 2 "w1 held" "[0, 1]" "got 2" -- fit one.csv --table mixed.h5 --fix w1=2
expect_refused 2 --free --fix "got g1" -- fit one.csv --phase henyey_greenstein:g=0.1 --second-phase isotropic --fix g1=0 --free g1
expect_refused 2 g2 Henyey-Greenstein "got free" -- fit one.csv --table mixed.h5 --free g2
expect_refused 2 --density "[0, 1)" "got 1" -- fit one.csv --table mixed.h5 --density 1
expect_refused 2 one.csv "line 3" side "table holds" "got unlit" -- fit one.csv --table endless.h5
expect_refused 2 --opposition "fit: " "got lommel" -- fit one.csv --table mixed.h5 --opposition lommel
sed '2,$s/0.42,7$/0.7,7/' known.csv >bad.csv
expect_refused 2 "bad.csv, line 2" g "in [0.3, 0.6] of the table" "got 0.7" -- fit bad.csv --table family.h5
expect_refused 2 "g held" "in [0.3, 0.6] of the table" "got 0.7" -- fit lobes.csv --table family.h5 --fix g=0.7
expect_refused 2 "either held or known" "got both" -- fit known.csv --table family.h5 --fix g=0.42
expect_refused 2 known.csv "column g" "left out unless" -- fit known.csv --table full.h5
expect_refused 2 --fix "w, tau, g," "got radius=8" -- fit lobes.csv --table family.h5 --fix radius=8
sed '1s/$/,radius/; 2,$s/$/,7/' known.csv >bad.csv
expect_refused 2 bad.csv "column pixel" "without radius" "got both" -- fit bad.csv --table family.h5
sed '2s/^beam,0.5/beam,-0.5/' star.csv >bad.csv
expect_refused 2 "line 2" mu_out "(0, 1]" "got -0.5" -- fit bad.csv
printf 'side,mu_out,brightness,sigma\nlit,0.5,0.3,0.01\n' >bad.csv
expect_refused 2 bad.csv mu_in -- fit bad.csv --phase isotropic
sed '3s/120,90/120,20/' both_sides.csv >bad.csv
expect_refused 2 "bad.csv, line 3" phase_deg "[60, 180] at incidence_deg 60 and emission_deg 120" "got 20" -- fit bad.csv --phase isotropic
sed '1s/$/,side/; 2,$s/$/,lit/' both_sides.csv >bad.csv
expect_refused 2 "bad.csv, line 3" emission_deg "below 90 on the side lit" "got 120" -- fit bad.csv --phase isotropic
sed '1s/$/,mu_in/; 2,$s/$/,1/' both_sides.csv >bad.csv
expect_refused 2 bad.csv "one of incidence_deg, emission_deg, phase_deg" "got mu_in" -- fit bad.csv --phase isotropic
expect_refused 2 --svg .svg "got fit.png" -- fit star.csv --svg fit.png
expect_refused 1 absent/rows.csv "no folder absent" -- fit star.csv --rows absent/rows.csv
expect_refused 2 star.csv another -- fit star.csv --rows star.csv
expect_refused 1 absent.csv -- fit absent.csv --table mixed.h5
expect_refused 1 absent.h5 -- fit one.csv --table absent.h5
expect_refused 2 one.csv another -- fit one.csv --table mixed.h5 -o ./one.csv
expect_refused 2 mixed.h5 another -- fit one.csv --table mixed.h5 -o mixed.h5
expect_refused 1 absent/out.csv -- fit one.csv --table mixed.h5 -o absent/out.csv
expect_refused 2 --threads "[0, 1024]" "got -1" -- fit one.csv --table mixed.h5 --threads -1
finish
