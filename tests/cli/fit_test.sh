#!/usr/bin/env bash
# stratus fit: recovers known layers, reports undetermined parameters, refuses bad rows.
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

"$make_fixture" mixed mixed.h5 || exit 1
"$make_fixture" full full.h5 || exit 1

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
answer=w1,w1_sigma,w2,w2_sigma,optical_depth,optical_depth_sigma,chi_square,degrees_of_freedom,remarks
near() { echo "(f[\"$1\"] - $2) ^ 2 < 1e-6"; }  # within 0.001

# --- answers

{ echo $columns; observe 0.5 0.25 1.2; } >one.csv
expect_ok fit one.csv --table mixed.h5
expect_silent "$err"
expect_header $answer
expect_rows 1 "$(near w1 0.5) && $(near w2 0.25) && $(near optical_depth 1.2) && f[\"chi_square\"] < 0.01"
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

expect_ok fit --help
expect_says "$out" "I/F = mu_in R" "mu_out < 0"

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
refuse_row 0.5,0.5,0,0.1,0 sigma "(0, inf)" "got 0"
refuse_row 0.5,0.5,0,0.1,-0.01 sigma "(0, inf)" "got -0.01"
refuse_row 0.5,0.5,0,dark,0.01 brightness "got 'dark'"
refuse_row 0.5,0.5,0,0.1 "5 values" "got 4"
sed -n 1,3p one.csv >bad.csv
expect_refused 2 bad.csv "at least three" "got 2" -- fit bad.csv --table mixed.h5
{ cat bins.csv; echo 0.5,0.5,0,0.1,0.01,3; } >bad.csv
expect_refused 2 bad.csv "at least three" "got 1 of 3" -- fit bad.csv --table mixed.h5
echo $columns >bad.csv
expect_refused 2 bad.csv "no observations" -- fit bad.csv --table mixed.h5
cut -d , -f 1-4 one.csv >bad.csv
expect_refused 2 bad.csv sigma -- fit bad.csv --table mixed.h5
sed '1s/sigma/error/' one.csv >bad.csv
expect_refused 2 bad.csv sigma -- fit bad.csv --table mixed.h5
sed '1s/$/,side/; 2,$s/$/,1/' one.csv >bad.csv
expect_refused 2 bad.csv "got side" -- fit bad.csv --table mixed.h5
expect_refused 2 --table "mixture axis" "full.h5" -- fit one.csv --table full.h5
expect_refused 2 --table required -- fit one.csv
expect_refused 1 absent.csv -- fit absent.csv --table mixed.h5
expect_refused 1 absent.h5 -- fit one.csv --table absent.h5
expect_refused 2 one.csv another -- fit one.csv --table mixed.h5 -o ./one.csv
expect_refused 2 mixed.h5 another -- fit one.csv --table mixed.h5 -o mixed.h5
expect_refused 1 absent/out.csv -- fit one.csv --table mixed.h5 -o absent/out.csv
expect_refused 2 --threads "[0, 1024]" "got -1" -- fit one.csv --table mixed.h5 --threads -1
finish
