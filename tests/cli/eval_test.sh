#!/usr/bin/env bash
# stratus eval: answers, what may be left out, and every refusal.
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

"$make_fixture" full full.h5 || exit 1
"$make_fixture" endless endless.h5 || exit 1
"$make_fixture" mixed mixed.h5 || exit 1

every=mu_in,mu_out,azimuth_deg,optical_depth,albedo
sum='f["reflection"] == f["reflection_single"] + f["reflection_multiple"]'
query() { printf '%s\n' "$@" >query.csv; }

# --- answers

query $every 0.5,0.8,60,1.5,0.9 1,1,0,8,1 0.3,0.2,180,inf,1 0.5,0.5,0,0,0.5
expect_ok eval full.h5 --query query.csv
expect_silent "$err"
expect_header $every,reflection,transmission,reflection_single,transmission_single,reflection_multiple,transmission_multiple
expect_rows 4 'f["reflection"] >= f["reflection_single"] && f["transmission"] >= f["transmission_single"]'
grep -q '^0.3,0.2,180,inf,1,' "$out" || fail "a query's numbers must come back as they were"
grep -qE '^0.5,0.8,60,1.5,0.9,0\.[0-9]{15,17},' "$out" || fail "17 significant digits are needed"
grep -q '^0.5,0.5,0,0,0.5,0,0,0,0,0,0$' "$out" || fail "an empty layer must scatter nothing"
cp "$out" answer.csv

# (w/4) (1 - exp(-tau (1/mu + 1/mu0))) / (mu + mu0) at mu = mu0 = 0.5, w = 0.9, infinite depth, isotropic: 0.225
query $every 0.5,0.5,0,inf,0.9
expect_ok eval endless.h5 --query query.csv --effects reflection
expect_rows 1 'f["reflection_single"] == 0.225'

# angles as observers have them: the same values, and none on the side that a row does not see
query $every 0.5,0.5,180,1.5,0.9 0.5,0.5,0,1.5,0.9
expect_ok eval full.h5 --query query.csv
cp "$out" cosines.csv
query emission_deg,incidence_deg,phase_deg,optical_depth,albedo 60,60,0,1.5,0.9 120,60,180,1.5,0.9
expect_ok eval full.h5 --query query.csv
expect_rows 2 '(f["emission_deg"] == 60) == (f["transmission"] == "nan") && (f["emission_deg"] == 120) == (f["reflection"] == "nan")'
expect_near "$(sed -n 2p "$out" | cut -d, -f6)" "$(sed -n 2p cosines.csv | cut -d, -f6)" 1e-12
expect_near "$(sed -n 3p "$out" | cut -d, -f7)" "$(sed -n 3p cosines.csv | cut -d, -f7)" 1e-12
query emission_deg,incidence_deg,phase_deg,optical_depth,albedo 60,60,130,1.5,0.9
expect_refused 2 "query.csv, line 2" phase_deg "[0, 120]" "got 130" -- eval full.h5 --query query.csv

# columns in any order; comments and blank lines; standard input
query '# in another order' azimuth_deg,albedo,mu_out,optical_depth,mu_in '' 60,0.9,0.8,1.5,0.5
expect_ok eval full.h5 <query.csv
expect_header azimuth_deg,albedo,mu_out,optical_depth,mu_in,reflection,transmission,reflection_single,transmission_single,reflection_multiple,transmission_multiple
[ "$(sed -n 2p "$out" | cut -d, -f6-)" = "$(sed -n 2p answer.csv | cut -d, -f6-)" ] ||
    fail "the order of the columns must not change the answer"
cp "$out" other_order.csv
expect_ok eval full.h5 --query - <query.csv
expect_same "$out" other_order.csv

# to a file, new and in place of an older one
expect_ok eval full.h5 --query query.csv -o out.csv
expect_silent "$out"
expect_same out.csv other_order.csv
echo older >out.csv
expect_ok eval full.h5 --query query.csv -o out.csv
expect_same out.csv other_order.csv
expect_ok eval full.h5 --query query.csv -o -
expect_same "$out" other_order.csv
rm out.csv

# no rows, no answers
query $every
expect_ok eval full.h5 --query query.csv
expect_rows 0 1

# effects: only what was asked for, totals made of it
query $every 0.5,0.8,60,1.5,0.9
expect_ok eval full.h5 --query query.csv --effects reflection
expect_header $every,reflection,reflection_single,reflection_multiple
expect_rows 1 "$sum"
expect_ok eval full.h5 --query query.csv --effects single
expect_header $every,reflection,transmission,reflection_single,transmission_single
expect_rows 1 'f["reflection"] == f["reflection_single"] && f["transmission"] == f["transmission_single"]'
expect_ok eval --query query.csv --effects multiple,transmission full.h5
expect_header $every,transmission,transmission_multiple
expect_rows 1 'f["transmission"] == f["transmission_multiple"]'
expect_ok eval full.h5 --query query.csv --effects single,multiple,reflection,transmission
expect_rows 1 "$sum"

# a background, a dense layer, opposition
query $every 0.5,0.5,180,1.5,0.9
expect_ok eval full.h5 --query query.csv --effects single,reflection
plain=$(tail -n 1 "$out" | cut -d , -f 6)
expect_ok eval full.h5 --query query.csv --effects single,reflection,background
expect_header $every,reflection,reflection_single,background
expect_rows 1 'f["background"] > exp(-3) && f["background"] < 1'
expect_ok eval full.h5 --query query.csv --effects background
expect_rows 1 'f["background"] > exp(-3) && f["background"] <= 1'
query $every 0.5,1,180,0.01,1
expect_ok eval full.h5 --query query.csv --effects single,reflection,background
expect_rows 1 'f["background"] > exp(-0.01) && f["background"] <= 1'
query $every 0.5,0.5,180,1.5,0.9
expect_ok eval full.h5 --query query.csv --effects single,reflection --density 0.25
expect_rows 1 "f[\"reflection\"] > $plain"
expect_ok eval full.h5 --query query.csv --effects single,reflection --opposition hapke:width=0.05,amplitude=0.5
expect_near "$(tail -n 1 "$out" | cut -d , -f 6)" "$(awk -v R="$plain" 'BEGIN { print 1.5 * R }')" 2e-5  # a slice samples the bump
query $every 0.5,0.5,180,1.2,0.9
expect_ok eval full.h5 --query query.csv --effects single,reflection --density 0.2 --opposition blinn
expect_near "$(tail -n 1 "$out" | cut -d , -f 6)" "$(awk -v R="$plain" 'BEGIN { e = exp(-3); print R * 2 / (1 + e) }')" 1e-5  # [Blinn82] 5.2
dense=$(tail -n 1 "$out")
expect_ok eval full.h5 --query query.csv --effects single,reflection --density number=0.2,radius=0.62035049089940009 --opposition blinn
expect_near "$(tail -n 1 "$out" | cut -d , -f 6)" "$(cut -d , -f 6 <<<"$dense")" 1e-6  # 4/3 pi radius^3 = 1
expect_ok eval full.h5 --query query.csv --effects single,reflection --density 0.2 --opposition hapke:amplitude=0.5
expect_ok eval full.h5 --query query.csv --effects single,reflection --density 0.2 --opposition hapke
expect_refused 2 radius "[0, 1)" -- eval full.h5 --query query.csv --density number=1,radius=1
expect_refused 2 --density "number=N,radius=R" "got thick" -- eval full.h5 --query query.csv --density thick
expect_refused 2 --density "[0, 1)" "got 1" -- eval full.h5 --query query.csv --density 1
expect_refused 2 --opposition "blinn or hapke" "got moon" -- eval full.h5 --query query.csv --opposition moon
expect_refused 2 --opposition "--density above 0" -- eval full.h5 --query query.csv --opposition blinn
expect_refused 2 width "(0, inf)" "got 0" -- eval full.h5 --query query.csv --opposition hapke:width=0

# a side that the table does not hold; columns that it does not need
query mu_in,mu_out,azimuth_deg 0.5,0.8,60
expect_ok eval endless.h5 --query query.csv
expect_header mu_in,mu_out,azimuth_deg,reflection,reflection_single,reflection_multiple
expect_rows 1 "$sum"
expect_says "$err" "endless.h5" "no transmission"
query mu_in,mu_out,azimuth_deg,albedo 0.5,0.8,60,0.9
expect_ok eval endless.h5 --query query.csv --effects reflection
expect_silent "$err"

# the other file format gives the same answer
query $every 0.5,0.8,60,1.5,0.9
expect_ok convert full.h5 full.exr
expect_ok eval full.h5 --query query.csv -o h5.csv
expect_ok eval full.exr --query query.csv -o exr.csv
expect_same h5.csv exr.csv

# a table that mixes: at mixture 1 it is that of the first phase function
query $every 0.5,0.8,60,1.5,0.9
expect_ok eval full.h5 --query query.csv --effects reflection,background
plain=$(tail -n 1 "$out" | cut -d , -f 6)
query $every,mixture 0.5,0.8,60,1.5,0.9,1 0.5,0.8,60,1.5,0.9,0.5 0.5,0.8,60,1.5,0.9,0
expect_ok eval mixed.h5 --query query.csv --effects reflection,background
expect_header $every,mixture,reflection,reflection_single,reflection_multiple,background
expect_near "$(sed -n 2p "$out" | cut -d , -f 7)" "$plain" 1e-6  # floats
awk -F, 'NR > 1 { R[NR] = $8 } END { off = R[3] - (R[2] + R[4]) / 2; exit off > 1e-12 || off < -1e-12 }' "$out" ||
    fail "half of each must scatter once as the mean of both"
expect_ok convert mixed.h5 mixed.exr
expect_ok eval mixed.h5 --query query.csv -o h5.csv
expect_ok eval mixed.exr --query query.csv -o exr.csv
expect_same h5.csv exr.csv
query $every 0.5,0.8,60,1.5,0.9
expect_refused 2 query.csv mixture -- eval mixed.h5 --query query.csv
query $every,mixture 0.5,0.8,60,1.5,0.9,0.5 0.5,0.8,60,1.5,0.9,1.5
expect_refused 2 "query.csv, line 3" mixture "[0, 1]" "got 1.5" -- eval mixed.h5 --query query.csv
query $every,mixture 0.5,0.8,60,1.5,0.9,0.5
expect_refused 2 query.csv "got mixture" -- eval full.h5 --query query.csv

# outside the axes: one warning with the rows counted for each axis
query $every 0.005,0.8,60,1.5,0.9 0.005,0.001,60,0.005,0.9 0.5,0.8,60,100,0.9
expect_ok eval full.h5 --query query.csv
expect_rows 3 1
expect_says "$err" warning "2 in mu_in" "1 in mu_out"
[ "$(wc -l <"$err")" -eq 1 ] || fail "one warning is enough"
expect_ok eval full.h5 --query query.csv --effects single
expect_silent "$err"

# layers outside the table are refused, or clamped on request
query $every 0.5,0.8,60,inf,0.9 0.5,0.8,60,inf,0.5
expect_refused 2 "query.csv, line 3" albedo "[0.9, 0.9]" "got 0.5" "--clamp" -- \
    eval endless.h5 --query query.csv --effects reflection
query $every 0.5,0.8,60,1,0.9
expect_refused 2 "query.csv, line 2" optical_depth inf "got 1" -- \
    eval endless.h5 --query query.csv --effects reflection
expect_ok eval endless.h5 --query query.csv --effects reflection,single
query $every 0.5,0.8,60,1,0.5
expect_ok eval endless.h5 --query query.csv --effects reflection --clamp
expect_says "$err" "1 in optical_depth" "1 in albedo"
query $every 0.5,0.8,60,inf,0
expect_ok eval endless.h5 --query query.csv --effects reflection
expect_silent "$err"
expect_rows 1 'f["reflection"] == 0'

# --- refusals

refuse_row() { # refuse_row ROW FRAGMENT...
    query $every 0.5,0.5,0,1,0.5 "$1"
    shift
    expect_refused 2 "query.csv, line 3" "$@" -- eval full.h5 --query query.csv
}
refuse_row 0,0.5,0,1,0.5 mu_in "(0, 1]" "got 0"
refuse_row 1.0001,0.5,0,1,0.5 mu_in "(0, 1]" "got 1.0001"
refuse_row 0.5,-0.5,0,1,0.5 mu_out "(0, 1]" "got -0.5"
refuse_row 0.5,1.5,0,1,0.5 mu_out "(0, 1]" "got 1.5"
refuse_row 0.5,0.5,inf,1,0.5 azimuth_deg finite "got inf"
refuse_row 0.5,0.5,0,-1e-9,0.5 optical_depth "[0, inf]" "got -1e-09"
refuse_row 0.5,0.5,0,nan,0.5 optical_depth nan
refuse_row 0.5,0.5,0,1,-0.1 albedo "[0, 1]" "got -0.1"
refuse_row 0.5,0.5,0,1,1.1 albedo "[0, 1]" "got 1.1"
refuse_row 0.5,0.5,0,1 "5 values" "got 4"
refuse_row 0.5,0.5,0,one,0.5 optical_depth "got 'one'"

query mu_in,mu_out,azimuth_deg,albedo 0.5,0.5,0,0.5
expect_refused 2 query.csv optical_depth -- eval full.h5 --query query.csv
query mu_in,azimuth_deg 0.5,0
expect_refused 2 query.csv mu_out -- eval endless.h5 --query query.csv
query $every,wavelength 0.5,0.5,0,1,0.5,0.6
expect_refused 2 query.csv "mu_in, mu_out" "got wavelength" -- eval full.h5 --query query.csv
: >query.csv
expect_refused 2 query.csv header -- eval full.h5 --query query.csv

query $every 0.5,0.5,0,1,0.5
expect_refused 2 --effects "single, multiple, reflection, transmission, background" "got double" -- \
    eval full.h5 --query query.csv --effects single,double
expect_refused 1 absent.csv -- eval full.h5 --query absent.csv
expect_refused 1 absent.h5 -- eval absent.h5 --query query.csv
expect_refused 2 table.txt .h5 .exr -- eval table.txt --query query.csv
expect_refused 1 absent/out.csv -- eval full.h5 --query query.csv -o absent/out.csv
expect_refused 2 full.h5 another -- eval full.h5 --query query.csv -o full.h5
expect_refused 2 query.csv another -- eval full.h5 --query query.csv -o ./query.csv

# devices, pipes and what is open take the answer behind what they hold
expect_ok eval full.h5 --query query.csv -o /dev/null
expect_ok eval full.h5 --query query.csv
cp "$out" answer.csv
(echo before && cat answer.csv && echo after) >expected.csv
(echo before && "$stratus" eval full.h5 --query query.csv -o /dev/stdout >>kept.csv; echo after >>kept.csv) >kept.csv
expect_same kept.csv expected.csv
mkfifo pipe
timeout 20 cat pipe >piped.csv &
expect_ok eval full.h5 --query query.csv -o pipe
wait $!
expect_same piped.csv answer.csv
rm pipe piped.csv kept.csv expected.csv

# the smallest cosine is one
echo "$every" >smallest.csv
echo 5e-324,5e-324,0,1,0.5 >>smallest.csv
expect_ok eval full.h5 --query smallest.csv
! grep -qi nan "$out" || fail "a cosine of 5e-324 must give numbers: $(cat "$out")"

# beyond the largest size of a file: refused, not killed
head -c 4000 /dev/zero | tr '\0' '\n' >>query.csv
for row in $(seq 200); do echo 0.5,0.5,0,1,0.5; done >>query.csv
through 'ulimit -f 1; exec "$stratus" "$@"' expect_refused 1 "out.csv: File too large" -- \
    eval full.h5 --query query.csv -o out.csv
through 'ulimit -f 1; exec "$stratus" "$@"' expect_refused 1 "small.stratus: File too large" -- pack full.h5 -o small.stratus

# what is no table is refused, not waited for
ln -s /dev/zero zero.h5
expect_refused 1 "zero.h5: is not a regular file" -- eval zero.h5 --query query.csv
rm zero.h5
expect_refused 2 "67108864 bytes" -- eval full.h5 --query /dev/zero
through "yes '#' | \"\$stratus\" \"\$@\"" expect_refused 2 "standard input, line" "67108864 bytes" -- eval full.h5
head -c 1000 full.h5 >short.h5
expect_refused 1 short.h5 -- eval short.h5 --query query.csv

# an older answer survives a refusal
echo older >out.csv
query $every 0.5,0.5,0,1,2
expect_refused 2 "got 2" -- eval full.h5 --query query.csv -o out.csv
rm out.csv

# a side that the table cannot give is an error only when nothing else was asked for
query mu_in,mu_out,azimuth_deg 0.5,0.8,60
expect_refused 2 --effects "got transmission" -- \
    eval endless.h5 --query query.csv --effects transmission

# a full disk is told, not swallowed
if [ -w /dev/full ]; then
    query $every 0.5,0.5,0,1,0.5
    "$stratus" eval full.h5 --query query.csv >/dev/full 2>"$err"
    [ $? -eq 1 ] || fail "an answer that could not be written must not exit 0"
    expect_says "$err" "standard output"
fi
finish
