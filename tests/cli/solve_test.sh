#!/usr/bin/env bash
# stratus solve: known figures, queries, phase functions, and every refusal.
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

query() { printf '%s\n' "$@" >query.csv; }

# figure NAME: the number, or the list of numbers, of the last answer's JSON.
figure() { sed -nE 's/^ *"'"$1"'": \[?"?([^]"]*[^]",])"?\]?,?$/\1/p' "$out"; }

expect_json() {
    if command -v python3 >/dev/null; then
        python3 -m json.tool "$out" >"$logs/json" 2>&1 || fail "the answer must be JSON: $(cat "$logs/json")"
    fi
}

# --- fluxes

expect_ok solve --phase isotropic --albedo 1 --optical-depth 1
expect_silent "$err"
expect_json
expect_near "$(figure spherical_albedo)" 0.446594006673394 1e-9
expect_near "$(figure total_transmittance)" 0.553405993326606 1e-9
expect_near "$(figure absorptance)" 0 0
grep -qE '"spherical_albedo": 0\.[0-9]{15,17},$' "$out" || fail "17 significant digits are needed"

# independent figures: long double, 64 nodes
expect_ok solve --phase henyey_greenstein:g=0.75 --albedo 0.99 --optical-depth 8 --mu-in 1,0.5 --nodes 64
expect_json
expect_near "$(figure spherical_albedo)" 0.537148228651 1e-9
expect_near "$(figure total_transmittance)" 0.322024848212 1e-9
expect_near "$(figure absorptance)" 0.140826923137 1e-9
[ "$(figure mu_in)" = "1, 0.5" ] || fail "mu_in must come back as it was asked for"
expect_near "$(figure plane_albedo | cut -d, -f1)" 0.433048223113 1e-9
expect_near "$(figure direct_transmittance | cut -d, -f1)" 0.00033546262790251185 1e-18
expect_near "$(figure direct_transmittance | cut -d, -f2)" 1.1253517471925912e-07 1e-21
[ "$(figure diffuse_transmittance | tr , '\n' | wc -l)" -eq 2 ] || fail "each mu_in needs a diffuse transmittance"

# the limits: no layer, no end to it
expect_ok solve --phase rayleigh --albedo 0.5 --optical-depth 0 --mu-in 0.5
expect_json
expect_near "$(figure spherical_albedo)" 0 0
expect_near "$(figure total_transmittance)" 1 0
expect_ok solve --phase rayleigh --albedo 1 --optical-depth inf --mu-in 0.5
expect_json
[ "$(figure optical_depth)" = inf ] || fail "JSON has no infinity: it must be the word inf"
expect_near "$(figure spherical_albedo)" 1 1e-12
expect_near "$(figure plane_albedo)" 1 1e-12
expect_near "$(figure total_transmittance)" 0 0

# nodes and schemes: more nodes come nearer, both schemes to the same
layer=(--phase henyey_greenstein:g=0.5 --albedo 0.9 --optical-depth 2)
expect_ok solve "${layer[@]}" --nodes 48
fine=$(figure spherical_albedo)
expect_ok solve "${layer[@]}" --nodes 2
awk -v coarse="$(figure spherical_albedo)" -v fine="$fine" 'BEGIN { exit coarse == fine }' ||
    fail "two nodes must show"
expect_ok solve "${layer[@]}" --nodes 016
expect_near "$(figure spherical_albedo)" "$fine" 1e-7
expect_ok solve "${layer[@]}" --scheme classic
classic=$(figure spherical_albedo)
expect_ok solve "${layer[@]}" --scheme harmonic
expect_near "$(figure spherical_albedo)" "$classic" 1e-7

# --- reference solvers: every scheme agrees within its stated error

query mu_in,mu_out,azimuth_deg 0.5,0.8,60 0.2,0.2,180
layer=(--phase isotropic --albedo 0.9 --optical-depth 1 --query query.csv)
expect_ok solve "${layer[@]}"
R=$(awk -F, 'NR == 2 { print $4 }' "$out") T=$(awk -F, 'NR == 2 { print $5 }' "$out")
agree() { # agree WITHIN: the condition that the first row has these R and T
    echo "NR > 2 || (f[\"reflection\"] - $R) ^ 2 <= ($1) ^ 2 && (f[\"transmission\"] - $T) ^ 2 <= ($1) ^ 2"
}
sums='(f["reflection"] - f["reflection_single"] - f["reflection_multiple"]) ^ 2 < 1e-30'
expect_ok solve "${layer[@]}" --scheme h-function
expect_rows 2 "($(agree 1e-9)) && $sums"
expect_ok solve "${layer[@]}" --scheme classic --start single --start-depth 1e-6
expect_rows 2 "($(agree 1e-5)) && $sums"
expect_ok solve "${layer[@]}" --scheme classic --start diamond --start-depth 1e-5
expect_rows 2 "($(agree 1e-6)) && $sums"
expect_ok solve "${layer[@]}" --scheme markov --sublayers 16
expect_rows 2 "($(agree 'f["reflection_error"] + f["transmission_error"]')) && $sums"
expect_ok solve "${layer[@]}" --scheme photons --photons 20000 --threads 1
expect_rows 2 "($(agree '4 * (f["reflection_error"] + f["transmission_error"])')) && f[\"reflection_error\"] > 0"
cp "$out" photons.csv
expect_ok solve "${layer[@]}" --scheme photons --photons 20000 --threads 2
expect_same "$out" photons.csv
expect_ok solve "${layer[@]}" --scheme photons --photons 20000 --seed 2
cmp -s "$out" photons.csv && fail "another seed must draw other photons"
expect_ok solve "${layer[@]}" --scheme photons --photons 20000 --backward-collisions 4
expect_rows 2 "($(agree '4 * (f["reflection_error"] + f["transmission_error"])')) && f[\"reflection_error\"] > 0"
cmp -s "$out" photons.csv && fail "paths followed back must draw other photons"

# fluxes of each, too
layer=(--phase isotropic --albedo 0.9 --optical-depth 1 --mu-in 0.5)
expect_ok solve "${layer[@]}"
albedo=$(figure spherical_albedo) plane=$(figure plane_albedo)
expect_ok solve "${layer[@]}" --scheme h-function
expect_near "$(figure spherical_albedo)" "$albedo" 1e-10
expect_near "$(figure plane_albedo)" "$plane" 1e-10
expect_ok solve "${layer[@]}" --scheme markov
expect_near "$(figure plane_albedo)" "$plane" "$(figure error)"
expect_ok solve "${layer[@]}" --scheme photons --photons 50000
expect_json
expect_near "$(figure plane_albedo)" "$plane" "$(awk -v e="$(figure plane_albedo_error)" 'BEGIN { print 4 * e }')"

# orders one by one
layer=(--phase rayleigh --albedo 0.8 --optical-depth 1 --query query.csv --orders 3)
expect_ok solve "${layer[@]}"
one='(f["reflection_order_1"] - f["reflection_single"]) ^ 2 < 1e-28'
all='(f["transmission_order_1"] + f["transmission_order_2"] + f["transmission_order_3"] - f["transmission"]) ^ 2 < 1e-28'
expect_rows 2 "$one && $all"
second=$(awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == "reflection_order_2") c = i } NR == 2 { print $c }' "$out")
expect_ok solve "${layer[@]}" --scheme markov
expect_rows 2 "NR > 2 || (f[\"reflection_order_2\"] - $second) ^ 2 < 1e-10"
expect_ok solve --phase rayleigh --albedo 0.8 --optical-depth 1 --orders 2
expect_json
[ "$(figure spherical_albedo_of_order | tr , '\n' | wc -l)" -eq 2 ] || fail "each order needs its flux"

# options that belong to other schemes, and what a reference solver cannot do
layer=(solve --phase isotropic --albedo 0.9 --optical-depth 1)
expect_refused 2 --scheme "photons with --seed" "got harmonic" -- "${layer[@]}" --seed 1
expect_refused 2 --scheme "photons with --backward-collisions" "got harmonic" -- "${layer[@]}" --backward-collisions 4
expect_refused 2 --backward-collisions "[0, 100]" "got 101" -- "${layer[@]}" --scheme photons --backward-collisions 101
expect_refused 2 --scheme "photons with --photons" "got markov" -- "${layer[@]}" --scheme markov --photons 10
expect_refused 2 --scheme "classic with --start" "got harmonic" -- "${layer[@]}" --start single
expect_refused 2 --scheme "classic with --start-depth" -- "${layer[@]}" --start-depth 1e-3
expect_refused 2 --scheme "markov with --sublayers" -- "${layer[@]}" --sublayers 8
expect_refused 2 --scheme "harmonic or markov or photons with --orders" "got classic" -- "${layer[@]}" --scheme classic --orders 2
expect_refused 2 --orders "[1, 200]" "got 0" -- "${layer[@]}" --orders 0
expect_refused 2 --start-depth "[1e-15, 1]" "got 2" -- "${layer[@]}" --scheme classic --start-depth 2
expect_refused 2 --photons "[2, 1000000000000]" "got 1" -- "${layer[@]}" --scheme photons --photons 1
expect_refused 2 --phase isotropic rayleigh -- solve --scheme h-function --phase rayleigh --albedo 1 --optical-depth 1
expect_refused 2 optical_depth "[0, inf)" -- solve --scheme markov --phase rayleigh --albedo 1 --optical-depth inf
expect_refused 2 optical_depth finite -- solve --scheme photons --phase rayleigh --albedo 1 --optical-depth inf
expect_refused 2 sublayers even "got 5" -- "${layer[@]}" --scheme markov --sublayers 5

# negative answers are not passed over in silence
query mu_in,mu_out,azimuth_deg 0.3,0.3,60 1,0.3,90 0.6,0.6,20 1,1,0
layer=(solve --phase henyey_greenstein:g=-0.9 --albedo 0.9 --optical-depth 1 --nodes 2 --query query.csv)
expect_ok "${layer[@]}"
expect_says "$err" note negative series --nodes
expect_ok "${layer[@]}" --quiet
expect_silent "$err"

# --- stacks

air="[[layers]]
phase_function = 'rayleigh'
albedo = 1.0
optical_depth = 0.25"
echo "$air" >air.toml
expect_ok solve --phase rayleigh --albedo 1 --optical-depth 0.25 --mu-in 0.5
one=$(figure plane_albedo)
expect_ok solve --layers air.toml --mu-in 0.5
expect_json
expect_silent "$err"
expect_near "$(figure plane_albedo)" "$one" 1e-14
expect_near "$(figure direct_transmittance)" 0.60653065971263342 1e-16
expect_near "$(figure optical_depth)" 0.25 0
expect_near "$(figure absorptance)" 0 0
! grep -q ground "$out" || fail "there is no ground to speak of"

# over a surface that takes in 0.7 of what falls on it: figures of one layer, put together by hand
t=$(awk -v one="$one" 'BEGIN { printf "%.17g", 1 - one }')  # plane transmittance of a layer that loses nothing
expect_ok solve --layers air.toml
s=$(figure spherical_albedo)
printf '%s\n[below]\nlambert_albedo = 0.3\n' "$air" >ground.toml
expect_ok solve --layers ground.toml --mu-in 0.5
expect_json
expect_near "$(figure plane_ground_absorptance)" \
    "$(awk -v t="$t" -v s="$s" 'BEGIN { printf "%.17g", 0.7 * t / (1 - 0.3 * s) }')" 1e-14
expect_near "$(figure ground_absorptance)" "$(figure absorptance)" 1e-14
# what falls on the surface, reflected back and forth: 0.7 of it is absorbed there
expect_near "$(figure direct_transmittance)" 0.60653065971263342 1e-16
expect_near "$(figure diffuse_transmittance)" \
    "$(awk -v t="$t" -v s="$s" 'BEGIN { printf "%.17g", t / (1 - 0.3 * s) - 0.60653065971263342 }')" 1e-14
expect_near "$(figure total_transmittance)" \
    "$(awk -v a="$(figure ground_absorptance)" 'BEGIN { printf "%.17g", a / 0.7 }')" 1e-14
# the same ground by its text, a law that is Lambert's, and an ocean
expect_ok solve --layers ground.toml --mu-in 0.5
over=$(figure plane_albedo)
for ground in 0.3 rpv:rho0=0.3,k=1,theta=0,rho_c=1; do
    expect_ok solve --phase rayleigh --albedo 1 --optical-depth 0.25 --mu-in 0.5 --over "$ground"
    expect_near "$(figure plane_albedo)" "$over" 1e-13
done
printf '%s\n[below]\nground = "ocean:wind=5"\n' "$air" >sea.toml
expect_ok solve --layers sea.toml --mu-in 0.5
expect_near "$(figure plane_ground_absorptance)" \
    "$(awk -v r="$(figure plane_albedo)" 'BEGIN { printf "%.17g", 1 - r }')" 1e-12
expect_refused 2 "--over" -- solve --layers air.toml --over 0.3
expect_refused 2 "wind must be in [0, 50] m/s" "got 60" -- \
    solve --phase isotropic --albedo 1 --optical-depth 1 --over ocean:wind=60
query mu_in,mu_out,azimuth_deg 0.5,0.8,60
expect_ok solve --layers ground.toml --query query.csv
[ "$(wc -l <"$out")" -eq 2 ] || fail "a row for every row of the query"
expect_near "$(tail -1 "$out" | cut -d, -f5)" 0 0  # nothing is transmitted
expect_ok solve --layers ground.toml --query query.csv --orders 3
expect_rows 1 '(f["reflection_order_1"] + f["reflection_order_2"] + f["reflection_order_3"] - f["reflection"]) ^ 2 < 1e-28 && f["reflection_order_1"] == f["reflection_single"] && f["reflection_error"] < 1e-4 * f["reflection"]'

refuse_stack() { # refuse_stack LINES FRAGMENT...
    printf '%s\n' "$1" >stack.toml
    shift
    expect_refused 2 "$@" -- solve --layers stack.toml
}
refuse_stack "$air
depth = 1" "line 5: unknown key 'layer 1.depth'" "did you mean"
refuse_stack "${air/1.0/1.5}" "layer 1.albedo" "[0, 1]" "got 1.5"
refuse_stack "${air/0.25/inf}
$air" "layer 1.optical_depth" finite "got inf"
refuse_stack "$air
[below]
lambert_albedo = 2" below.lambert_albedo "[0, 1]" "got 2"
refuse_stack "" layers "got nothing"
for option in --phase=rayleigh --albedo=1 --optical-depth=1 --scheme=classic; do
    expect_refused 2 "${option%=*}" --layers -- solve --layers air.toml "$option"
done
expect_refused 2 --layers -- solve --layers ''
expect_refused 1 absent.toml -- solve --layers absent.toml
expect_refused 2 "--phase is required" -- solve --albedo 1 --optical-depth 1

# --- tolerance: nodes are chosen, and every value has its error

query mu_in,mu_out,azimuth_deg 0.5,0.5,0 0.5,0.5,180 0.2,0.9,60
layer=(--phase henyey_greenstein:g=-0.95 --albedo 1 --optical-depth 10 --query query.csv)
expect_ok solve "${layer[@]}" --nodes 200
fine=$(awk -F, 'NR == 2 { print $4 }' "$out")
for tolerance in 1e-2 1e-4 1e-6; do
    expect_ok solve "${layer[@]}" --tolerance $tolerance
    expect_silent "$err"
    expect_rows 3 "f[\"reflection_error\"] > 0 && f[\"reflection_error\"] <= $tolerance * f[\"reflection\"] && (NR > 2 || (f[\"reflection\"] - $fine) ^ 2 <= (2 * f[\"reflection_error\"]) ^ 2)"
done
expect_ok solve "${layer[@]}" --nodes 12
expect_rows 3 "NR > 2 || f[\"reflection_error\"] > 1e-2 * f[\"reflection\"]"
expect_ok solve --phase henyey_greenstein:g=0.9 --albedo 0.9 --optical-depth 1 --tolerance 1e-9 --mu-in 0.5
expect_json
awk -v e="$(figure error)" 'BEGIN { exit !(e > 0 && e < 1e-9) }' || fail "fluxes need their error, within the tolerance"

# water as it absorbs in its band at 1.94 um: the same by material and by an index of that wavelength
query mu_in,mu_out,azimuth_deg 0.6,0.7,90
cloud=mie:radius=10um,variance=0.1,wavelength=1.94um
for index in material=water index=1.2986+0.001911i; do
    expect_ok solve --phase "$cloud,$index" --albedo phase_function --optical-depth 20 --query query.csv
    awk -F, 'NR == 2 { print $4 }' "$out"
done >reflections
expect_near "$(sed -n 1p reflections)" "$(sed -n 2p reflections)" 2e-4

# one that is out of reach
query mu_in,mu_out,azimuth_deg 0.1,0.15,0 0.5,0.8,90
layer=(solve --phase henyey_greenstein:g=0.999 --albedo 1 --optical-depth 2 --query query.csv --tolerance 1e-6)
"$stratus" "${layer[@]}" >"$out" 2>"$err"  # the answers are printed all the same
[ $? -eq 1 ] || fail "a tolerance that is missed needs exit code 1"
expect_says "$err" "tolerance of 1e-06 is missed" "of 2 rows" "mu_in 0.1, mu_out 0.15, azimuth_deg 0" --accept
expect_rows 2 'f["reflection_error"] > 0'
expect_ok "${layer[@]}" --accept
layer=(solve --phase isotropic --albedo 0.9 --optical-depth 1)
expect_refused 2 --tolerance "[1e-12, 1]" "got 0" -- "${layer[@]}" --tolerance 0
expect_refused 2 --tolerance --nodes -- "${layer[@]}" --tolerance 1e-3 --nodes 8
expect_refused 2 --scheme "harmonic with --tolerance" "got classic" -- "${layer[@]}" --scheme classic --tolerance 1e-3

# --- queries

columns=mu_in,mu_out,azimuth_deg
parts=reflection,transmission,reflection_single,transmission_single,reflection_multiple,transmission_multiple
parts+=,reflection_error,transmission_error
sums='f["reflection"] == f["reflection_single"] + f["reflection_multiple"]'
sums+=' && f["transmission"] == f["transmission_single"] + f["transmission_multiple"]'
layer=(--phase henyey_greenstein:g=0.75 --albedo 0.99 --optical-depth 8 --nodes 64)

query $columns 1,1,0 0.5,0.5,0 0.5,0.5,90 0.5,0.5,180
expect_ok solve "${layer[@]}" --query query.csv
expect_silent "$err"
expect_header $columns,$parts
expect_rows 4 "$sums"
expect_near "$(sed -n 2p "$out" | cut -d, -f4)" 0.4157451335 1e-9
expect_near "$(sed -n 3p "$out" | cut -d, -f4)" 1.06218291 1e-8
expect_near "$(sed -n 4p "$out" | cut -d, -f4)" 0.58840936 1e-8
expect_near "$(sed -n 5p "$out" | cut -d, -f4)" 0.44184658 1e-8
grep -qE '^0.5,0.5,90,0\.[0-9]{15,17},' "$out" || fail "17 significant digits are needed"

# columns in any order; comments and blank lines; standard input
layer=(--phase rayleigh --albedo 0.9 --optical-depth 1.5 --nodes 8)
query $columns 0.5,0.8,60
expect_ok solve "${layer[@]}" --query query.csv
cp "$out" answer.csv
query '# in another order' azimuth_deg,mu_out,mu_in '' 60,0.8,0.5
expect_ok solve "${layer[@]}" --query - <query.csv
expect_header azimuth_deg,mu_out,mu_in,$parts
[ "$(sed -n 2p "$out" | cut -d, -f4-)" = "$(sed -n 2p answer.csv | cut -d, -f4-)" ] ||
    fail "the order of the columns must not change the answer"

# to a file, new and in place of an older one
cp "$out" other_order.csv
expect_ok solve "${layer[@]}" --query query.csv -o out.csv
expect_silent "$out"
expect_same out.csv other_order.csv
echo older >out.csv
expect_ok solve "${layer[@]}" --query query.csv -o out.csv
expect_same out.csv other_order.csv
expect_ok solve "${layer[@]}" --query query.csv -o -
expect_same "$out" other_order.csv
expect_ok solve "${layer[@]}" -o fluxes.json
expect_silent "$out"
expect_says fluxes.json spherical_albedo
rm out.csv answer.csv other_order.csv fluxes.json

# angles as observers have them are the same geometries: cosine 0.5 both, azimuth 180; cosine 0.5 below, straight on. Of
# the side that a row does not see there are no numbers
query $columns 0.5,0.5,180 0.5,0.5,0
expect_ok solve "${layer[@]}" --query query.csv
cp "$out" answer.csv
query phase_deg,incidence_deg,emission_deg 0,60,60 180,60,120
expect_ok solve "${layer[@]}" --query query.csv
expect_header phase_deg,incidence_deg,emission_deg,$parts
expect_rows 2 '(f["emission_deg"] < 90) == (f["transmission_single"] == "nan")'
expect_near "$(sed -n 2p "$out" | cut -d, -f4)" "$(sed -n 2p answer.csv | cut -d, -f4)" 1e-14
expect_near "$(sed -n 3p "$out" | cut -d, -f5)" "$(sed -n 3p answer.csv | cut -d, -f5)" 1e-14
[ "$(sed -n 3p "$out" | cut -d, -f4)" = nan ] || fail "the lit side is not seen at 120 degrees"
rm answer.csv

# the light inside: at both ends what leaves; energy from level to level; radiance
layer=(solve --phase henyey_greenstein:g=0.5 --albedo 1 --optical-depth 2)
expect_ok "${layer[@]}" --mu-in 0.5,1
cp "$out" outside.json
expect_ok "${layer[@]}" --mu-in 0.5,1 --levels 0,0.7,2
expect_header level,mu_in,direct_flux,diffuse_flux,upward_flux,actinic_flux,heating_rate,error
expect_rows 6 'f["heating_rate"] == 0 && f["error"] < 1e-4'
grep -q "plane_albedo\": \[$(sed -n 2p "$out" | cut -d, -f5 | cut -c 1-7)" outside.json || fail "upward at the top is the plane albedo"
awk -F, 'NR > 1 { net = $3 + $4 - $5; if ($2 in first && (net - first[$2]) ^ 2 > 1e-24) bad = 1; first[$2] = net }
    END { exit bad }' "$out" || fail "the net flux must be one at all levels"
expect_ok "${layer[@]}" --levels 1
expect_rows 1 'f["mu_in"] == 1'
query $columns 0.5,0.8,60
expect_ok "${layer[@]}" --query query.csv
R=$(sed -n 2p "$out" | cut -d, -f4) T=$(sed -n 2p "$out" | cut -d, -f5)
expect_ok "${layer[@]}" --query query.csv --levels 2,0
expect_header $columns,level,upward,downward,upward_single,downward_single,upward_multiple,downward_multiple,upward_error,downward_error
expect_near "$(sed -n 2p "$out" | cut -d, -f6)" "$T" 1e-4
expect_near "$(sed -n 3p "$out" | cut -d, -f5)" "$R" 1e-4
query incidence_deg,emission_deg,phase_deg 60,40,50 60,140,120
expect_ok "${layer[@]}" --query query.csv --levels 1
expect_rows 2 '(f["emission_deg"] < 90) == (f["downward"] == "nan") && (f["emission_deg"] > 90) == (f["upward"] == "nan")'
expect_refused 2 levels "in [0, 2], the optical depth" "got 3" -- "${layer[@]}" --levels 3
expect_refused 2 --levels "[0, inf)" "got -1" -- "${layer[@]}" --levels -1
expect_refused 2 --levels --orders -- "${layer[@]}" --levels 1 --orders 3
expect_refused 2 --scheme "harmonic with --levels" "got markov" -- "${layer[@]}" --levels 1 --scheme markov
rm outside.json
layer=(--phase rayleigh --albedo 0.9 --optical-depth 1.5 --nodes 8)

# no rows, no answers
query $columns
expect_ok solve "${layer[@]}" --query query.csv
expect_rows 0 1

# more cosines than are solved at once: the same values as one by one
awk -v columns=$columns 'BEGIN {
    print columns
    for (i = 0; i < 300; ++i) printf "%.4f,%.4f,%d\n", (i + 1) / 301, (i + 0.5) / 300, 7 * i % 360 }' >query.csv
expect_ok solve "${layer[@]}" --query query.csv
expect_rows 300 "$sums"
cp "$out" together.csv
for row in 2 33 34 150 301; do
    sed -n "1p;${row}p" query.csv >single.csv
    expect_ok solve "${layer[@]}" --query single.csv
    rounding=$(sed -n ${row}p together.csv | awk -F, '{ print 1e-14 * (1 + $4) }')  # orders n >= 2 are R less the first
    for field in 4 5 8 9; do
        together=$(sed -n ${row}p together.csv | cut -d, -f$field)
        expect_near "$(sed -n 2p "$out" | cut -d, -f$field)" "$together" "$rounding"
    done
done
rm together.csv single.csv

# an empty layer scatters nothing, however it is asked
query $columns 0.5,0.8,60
expect_ok solve --phase rayleigh --albedo 1 --optical-depth 0 --query query.csv
expect_rows 1 'f["reflection"] == 0 && f["transmission"] == 0'
expect_ok solve --phase rayleigh --albedo 0 --optical-depth 1 --query query.csv
expect_rows 1 'f["reflection"] < 1e-15 && f["reflection"] > -1e-15 && f["transmission"] < 1e-15 && f["transmission"] > -1e-15'

# --- phase functions

albedo_of() { # albedo_of PHASE: the plane albedo of a layer of it
    expect_ok solve --phase "$1" --albedo 0.9 --optical-depth 1 --nodes 16 --mu-in 0.3
    figure plane_albedo
}
isotropic=$(albedo_of isotropic)
expect_near "$(albedo_of anisotropic:x=0)" "$isotropic" 1e-13
expect_near "$(albedo_of henyey_greenstein:g=0)" "$isotropic" 1e-13
for phase in rayleigh anisotropic:x=0.5 lambert_sphere henyey_greenstein:g=-0.5; do
    awk -v other="$(albedo_of $phase)" -v isotropic="$isotropic" 'BEGIN { exit other == isotropic }' ||
        fail "$phase must not be isotropic"
done
expect_near "$(albedo_of '0.5*anisotropic:x=0.5 + 0.5*anisotropic:x=-0.5')" "$isotropic" 1e-13

mkdir phases
printf 'phase_angle_deg,value\n0,1\n90,1\n180,1\n' >phases/flat.csv
printf 'value,phase_angle_deg\n3,0\n3,90\n3,180\n' >phases/flat_times_3.csv
awk 'BEGIN { print "l,chi"; for (l = 0; l < 40; ++l) print l "," 0.5 ^ l }' >phases/moments.csv
expect_near "$(albedo_of tabulated:file=phases/flat.csv)" "$isotropic" 1e-9
expect_silent "$err"
expect_near "$(albedo_of tabulated:file=phases/flat_times_3.csv)" "$isotropic" 1e-9
albedo_of "0.7*tabulated:file=$PWD/phases/flat.csv + 0.3*isotropic" >/dev/null
expect_near "$(figure plane_albedo)" "$isotropic" 1e-9
expect_ok solve --phase tabulated:file=phases/flat_times_3.csv --albedo 1 --optical-depth 1 --nodes 4
expect_says "$err" "note: phases/flat_times_3.csv" "spherical mean 3"
henyey=$(albedo_of henyey_greenstein:g=0.5)
expect_near "$(albedo_of moments:file=phases/moments.csv)" "$henyey" 1e-9

# the albedo of droplets is what `stratus phase` says of them
droplets=mie:radius=5um,wavelength=3um,material=water
expect_ok phase $droplets
stated=$(sed -n 's/.*albedo \([0-9.]*\).*/\1/p' "$err")
expect_ok solve --phase $droplets --albedo phase_function --optical-depth 1 --nodes 16
expect_near "$(figure albedo)" "$stated" 1e-8

# weights that do not sum to 1 are said, and are no error
expect_ok solve --phase '2*rayleigh + 6*isotropic' --albedo 0.9 --optical-depth 1 --nodes 16 --mu-in 0.3
expect_says "$err" "note: " "weights summed to 8"
[ "$(wc -l <"$err")" -eq 1 ] || fail "one note is enough"
expect_near "$(albedo_of '0.25*rayleigh + 0.75*isotropic')" "$(figure plane_albedo)" 1e-14
expect_ok solve --phase '2*rayleigh + 6*isotropic' --albedo 0.9 --optical-depth 1 --nodes 16 --quiet
expect_silent "$err"

# --- refusals

# refuse OPTION ALLOWED VALUE: in a call that is right without it
refuse() {
    local -A option=([--phase]=isotropic [--albedo]=0.9 [--optical-depth]=1)
    option[$1]=$3
    local arguments=() name
    for name in "${!option[@]}"; do arguments+=("$name" "${option[$name]}"); done
    expect_refused 2 "$1" "$2" "got ${3:-nothing}" -- solve "${arguments[@]}"
}
for value in 1.2 -0.1 nan inf 0.5x x ''; do refuse --albedo "in [0, 1]" "$value"; done
for value in -1 -inf nan 1e x ''; do refuse --optical-depth "in [0, inf]" "$value"; done
for value in 0 -1 513 2.5 99999999999999999999 x ''; do refuse --nodes "in [1, 512]" "$value"; done
for value in 0 -0.5 1.0001 nan x ''; do refuse --mu-in "in (0, 1]" "$value"; done
refuse --query "the name of a file" ''
refuse --output "the name of a file" ''
expect_refused 2 --mu-in "(0, 1]" "got 1.1" -- solve --phase isotropic --albedo 1 --optical-depth 1 --mu-in 0.5,1.1
expect_refused 2 --scheme fast harmonic classic -- solve --phase isotropic --albedo 1 --optical-depth 1 --scheme fast
expect_refused 2 --query --mu-in -- solve --phase isotropic --albedo 1 --optical-depth 1 --mu-in 1 --query query.csv
expect_refused 2 --phase required -- solve --albedo 1 --optical-depth 1
expect_refused 2 --albedo required -- solve --phase isotropic --optical-depth 1
expect_refused 2 --optical-depth required -- solve --phase isotropic --albedo 1
expect_refused 2 --albedo -- solve --phase isotropic --optical-depth 1 --albedo
expect_refused 2 extra -- solve --phase isotropic --albedo 1 --optical-depth 1 extra

refuse_phase() { # refuse_phase PHASE FRAGMENT...
    local phase=$1
    shift
    expect_refused 2 "$@" -- solve --phase "$phase" --albedo 0.9 --optical-depth 1
}
for g in 1 -1 1.5 inf; do refuse_phase henyey_greenstein:g=$g "g must be in (-1, 1)" "got $g"; done
refuse_phase henyey_greenstein:g=nan "g must be a number" "got 'nan'"
refuse_phase henyey_greenstein:g=half "g must be a number" "got 'half'"
refuse_phase henyey_greenstein "needs g="
refuse_phase anisotropic:x=1.1 "x must be in [-1, 1]" "got 1.1"
refuse_phase isotropic:g=0.5 "isotropic takes no parameter" g=0.5
refuse_phase '' "got ''"
refuse_phase henyey "henyey_greenstein" "got 'henyey'"
refuse_phase "-1*isotropic + 2*rayleigh" weight "at least 0" "got -1"
refuse_phase "0*isotropic" weight "above 0" "got 0"
refuse_phase "isotropic +" "got ''"

refuse_table() { # refuse_table ROWS FRAGMENT...: rows of a tabulated phase function
    { echo phase_angle_deg,value; tr ' ' '\n' <<<"$1"; } >table.csv
    shift
    expect_refused 2 "$@" -- solve --phase tabulated:file=table.csv --albedo 0.9 --optical-depth 1
}
refuse_table "0,1 180,1" "at least 3 rows" "got 2"
refuse_table "0,1 90,-0.5 180,1" value "table.csv, line 3" "at least 0" "got -0.5"
refuse_table "0,1 90,1 60,1 180,1" phase_angle_deg "table.csv, line 4" "got 60"
refuse_table "0,1 90,1 190,1" phase_angle_deg "table.csv, line 4" "got 190"
refuse_table "0,0 90,0 180,0" value "got 0"
refuse_table "0,1 90,one 180,1" value "line 3" "got 'one'"
printf 'l,chi\n0,1\n2,0.5\n' >table.csv
expect_refused 2 "table.csv, line 3" "must be 1" "got 2" -- \
    solve --phase moments:file=table.csv --albedo 0.9 --optical-depth 1
printf 'l,chi\n0,1\n1,1.5\n' >table.csv
expect_refused 2 chi "got 1.5" -- solve --phase moments:file=table.csv --albedo 0.9 --optical-depth 1
printf 'angle,value\n0,1\n180,1\n' >table.csv
expect_refused 2 table.csv phase_angle_deg "got angle" -- \
    solve --phase tabulated:file=table.csv --albedo 0.9 --optical-depth 1
expect_refused 1 absent.csv -- solve --phase tabulated:file=absent.csv --albedo 0.9 --optical-depth 1
expect_refused 1 phases -- solve --phase moments:file=phases --albedo 0.9 --optical-depth 1

refuse_row() { # refuse_row ROW FRAGMENT...
    query $columns 0.5,0.5,0 "$1"
    shift
    expect_refused 2 "query.csv, line 3" "$@" -- solve "${layer[@]}" --query query.csv
}
refuse_row 0,0.5,0 mu_in "(0, 1]" "got 0"
refuse_row 1.0001,0.5,0 mu_in "(0, 1]" "got 1.0001"
refuse_row 0.5,-0.5,0 mu_out "(0, 1]" "got -0.5"
refuse_row 0.5,nan,0 mu_out nan
refuse_row 0.5,0.5,inf azimuth_deg finite "got inf"
refuse_row 0.5,0.5 "3 values" "got 2"
refuse_angles() { # refuse_angles ROW FRAGMENT...
    query incidence_deg,emission_deg,phase_deg 30,30,0 "$1"
    shift
    expect_refused 2 "query.csv, line 3" "$@" -- solve "${layer[@]}" --query query.csv
}
refuse_angles 90,30,60 incidence_deg "[0, 90)" "got 90"
refuse_angles 30,90,60 emission_deg "beyond 90 is the unlit side" "got 90"
refuse_angles 30,50,81 phase_deg "[20, 80] at incidence_deg 30 and emission_deg 50" "got 81"
query incidence_deg,emission_deg 30,30
expect_refused 2 query.csv phase_deg -- solve "${layer[@]}" --query query.csv
query mu_in,azimuth_deg 0.5,0
expect_refused 2 query.csv mu_out -- solve "${layer[@]}" --query query.csv
query $columns,albedo 0.5,0.5,0,0.9
expect_refused 2 query.csv "mu_in, mu_out" "got albedo" -- solve "${layer[@]}" --query query.csv
: >query.csv
expect_refused 2 query.csv header -- solve "${layer[@]}" --query query.csv
expect_refused 1 absent.csv -- solve "${layer[@]}" --query absent.csv
expect_refused 1 phases -- solve "${layer[@]}" --query phases
query $columns
expect_refused 2 --albedo "in [0, 1], or phase_function" "got droplets" -- solve --phase rayleigh --albedo droplets --optical-depth 1
expect_refused 2 --albedo "mie" "got phase_function" -- solve --phase rayleigh --albedo phase_function --optical-depth 1
expect_refused 2 --albedo "got 2" -- solve --phase rayleigh --albedo 2 --optical-depth 1 --query query.csv

# files that cannot be written; an older one comes to no harm
expect_refused 1 absent/out.json "No such file" -- solve "${layer[@]}" -o absent/out.json
expect_refused 1 phases directory -- solve "${layer[@]}" -o phases
expect_ok solve "${layer[@]}" -o /dev/null
expect_refused 2 query.csv another -- solve "${layer[@]}" --query query.csv -o ./query.csv
echo older >older.csv
query $columns 0.5,0.5,0 0.5,0.5,2x
expect_refused 2 "got '2x'" -- solve "${layer[@]}" --query query.csv -o older.csv
awk -v columns=$columns 'BEGIN { print columns; for (i = 0; i < 400; ++i) print "0.5,0.8," i / 3 }' >query.csv
through "$size_limited" expect_refused 1 older.csv "too large" -- \
    solve "${layer[@]}" --query query.csv -o older.csv
if [ -n "$small_disk" ]; then
    for file in older.csv new.csv; do
        through "$small_disk" expect_refused 1 disk/$file "No space left" -- \
            solve "${layer[@]}" --query query.csv -o disk/$file
    done
else
    echo "skipped: a full disk, which this machine does not let us make"
fi
if [ -n "$user_refused" ]; then
    through "$user_refused" expect_refused 1 shut/out.json "Permission denied" -- solve "${layer[@]}" -o shut/out.json
else
    echo "skipped: a folder that must not be written to"
fi
if [ -w /dev/full ]; then
    "$stratus" solve "${layer[@]}" >/dev/full 2>"$err"
    [ $? -eq 1 ] || fail "an answer that could not be written must not exit 0"
    expect_says "$err" "standard output: No space left"
fi
finish
