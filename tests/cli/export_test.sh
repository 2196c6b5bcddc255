#!/usr/bin/env bash
# stratus export: every format of tables and stacks, what it says, and every refusal.
stacks=$(realpath "$(dirname "$0")/../../tables/stacks")
examples=$(realpath "$(dirname "$0")/../../docs/examples")
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

"$make_fixture" full full.h5 || exit 1
"$make_fixture" mixed mixed.h5 || exit 1
"$make_fixture" family family.h5 || exit 1
layer="--optical-depth 1 --albedo 0.9 --nodes 16"

# starts_with FILE BYTES
starts_with() { [ "$(head -c ${#2} "$1" | tr -d '\0')" = "$2" ] || fail "$1 must begin with $2"; }

# --- every format

# shellcheck disable=SC2086  # words of a command
{
    expect_ok export full.h5 $layer --format fourier -o m.bsdf
    expect_silent "$out"
    expect_says "$err" "note: the beam straight through, exp(-tau/mu) with tau = 1, is not in the file" "m.bsdf: " " MB in " "R and T within" "as estimated ("
    starts_with m.bsdf SCATFUN
    expect_ok export full.h5 $layer --format tensor -o m.bsdf --quiet
    expect_silent "$err"
    starts_with m.bsdf tensor_file
    expect_ok export full.h5 $layer --format tensor-rgb -o m.bsdf
    expect_says "$err" "diffuse transmission is not in the file"
    expect_ok export full.h5 $layer --format netcdf -o m.nc
    grep -q HDF m.nc || fail "m.nc is not HDF5"
    expect_ok export full.h5 $layer --format exr-atlas -o m.exr --title 'A layer'
    expect_says m.json '"format": "stratus-atlas"' '"material": "A layer. '
    expect_ok export full.h5 $layer --format slice -o m.safetensors --title 'A layer'
    expect_says "$err" "note: the beam straight through"
    head -c 4000 m.safetensors | tr -d '\0' >header
    expect_says header '"format":"stratus-slice"' '"material":"A layer. ' '"transmission_multiple":'
}

# --- the scenes in docs/examples: the line of each writes the file that it reads

for scene in pbrt-v3/haze.pbrt pbrt-v4/haze.pbrt mitsuba/haze.xml blender/haze.py; do
    line=$(sed -n 's/.*build\/cli\/stratus \(export [^?]*\).*/\1/p' "$examples/$scene")
    written=${line##* docs/examples/"${scene%/*}"/}
    written=${written%% *}
    grep -q "\"$written\"" "$examples/$scene" || fail "$scene must read $written"
    # shellcheck disable=SC2046  # words of a command
    expect_ok $(echo "$line" | sed "s,tables/stacks,$stacks,; s,docs/examples/.*/,,") --nodes 16 --quiet
    [ -s "$written" ] || fail "$scene: $line must write $written"
done

# --- ground, colours, families, stacks; the same twice

expect_ok export full.h5 --optical-depth 0.5,1,2 --albedo 1,0.9,0.8 --over 0.3 --nodes 16 --format fourier -o rgb.bsdf
grep -q note: "$err" && fail "nothing passes: nothing is left out"
expect_says rgb.bsdf "albedo 0.8, optical depth 2 on a Lambert surface of albedo 0.3"
expect_ok export full.h5 --optical-depth 0.5,1,2 --albedo 1,0.9,0.8 --over 0.3 --nodes 16 --format fourier -o again.bsdf --threads 1
expect_same rgb.bsdf again.bsdf
expect_ok export full.h5 --optical-depth inf --albedo 1 --nodes 16 --format fourier -o endless.bsdf --quiet
expect_ok export mixed.h5 --at mixture=0.25 --optical-depth 1 --albedo 0.9 --nodes 16 --format fourier -o mixed.bsdf
expect_says mixed.bsdf "0.75*isotropic"
# shellcheck disable=SC2086  # words of a command
{
    for g in 0.35 0.4; do
        printf '[[layers]]\nphase_function = "henyey_greenstein:g=%s"\nalbedo = 0.9\noptical_depth = 1.0\n' $g >$g.toml
        expect_ok export $g.toml --nodes 16 --format fourier -o $g.bsdf --quiet
        expect_ok export family.h5 --at g=$g $layer --format fourier -o member.bsdf --quiet
        expect_same $g.bsdf member.bsdf
    done
    expect_ok export 0.35.toml 0.4.toml 0.35.toml --nodes 16 --format fourier -o rgb_layers.bsdf --quiet
    expect_ok export family.h5 --at g=0.35 --at g=0.4 --at g=0.35 $layer --format fourier -o rgb_members.bsdf --quiet
    expect_same rgb_layers.bsdf rgb_members.bsdf
    printf '[[layers]]\nphase_function = ["henyey_greenstein:g=0.35", "henyey_greenstein:g=0.4", "henyey_greenstein:g=0.35"]\nalbedo = 0.9\noptical_depth = 1.0\n' >coloured.toml
    expect_ok export coloured.toml --nodes 16 --format fourier -o coloured.bsdf --quiet
    expect_same coloured.bsdf rgb_members.bsdf
    expect_refused 2 "coloured.toml, line 1" "without lists of three" -- export coloured.toml coloured.toml 0.4.toml --format fourier -o no.bsdf
}
expect_ok export "$stacks/haze_over_ground.toml" --nodes 16 --format fourier -o haze.bsdf
expect_says haze.bsdf "rayleigh, albedo 1, optical depth 0.1 on henyey_greenstein:g=0.7" "on a Lambert surface of albedo 0.3"
sed '/^\[below\]/,$d' "$stacks/haze_over_ground.toml" >free.toml
expect_ok export free.toml free.toml free.toml --over 0.1,0.2,0.3 --nodes 16 --format tensor-rgb -o m.bsdf

# --- help

expect_ok export --help
expect_says "$out" "stratus export baked/saturn_rings.stratus" "solved again" fourier exr-atlas

# --- refusals

refuse() { # refuse FRAGMENT... -- ARGS...
    expect_refused 2 "$@"
}
refuse --format paint -- export full.h5 --optical-depth 1 --albedo 1 --format paint -o new.bsdf
refuse --output .bsdf new.nc -- export full.h5 --optical-depth 1 --albedo 1 --format fourier -o new.nc
refuse --output .safetensors new.stratus -- export full.h5 --optical-depth 1 --albedo 1 --format slice -o new.stratus
refuse --optical-depth "[0, inf]" -1 -- export full.h5 --optical-depth=-1 --albedo 1 --format fourier -o new.bsdf
refuse --albedo "[0, 1]" 1.5 -- export full.h5 --optical-depth 1 --albedo 1.5 --format fourier -o new.bsdf
refuse --albedo given nothing -- export full.h5 --optical-depth 1 --format fourier -o new.bsdf
refuse --optical-depth given nothing -- export full.h5 --albedo 1 --format fourier -o new.bsdf
refuse --albedo three 2 -- export full.h5 --optical-depth 1 --albedo 1,0.5 --format fourier -o new.bsdf
refuse TABLE three 2 -- export full.h5 full.h5 --optical-depth 1 --albedo 1 --format fourier -o new.bsdf
refuse alone -- export full.h5 free.toml full.h5 --optical-depth 1 --albedo 1 --format fourier -o new.bsdf
refuse --optical-depth "left out" 1 -- export free.toml --optical-depth 1 --format fourier -o new.bsdf
refuse --over "on something" 0.5 -- export "$stacks/haze_over_ground.toml" --over 0.5 --format fourier -o new.bsdf
refuse --over infinite 0.5 -- export full.h5 --optical-depth inf --albedo 1 --over 0.5 --format fourier -o new.bsdf
refuse --at given "as in mixture=0" nothing -- export mixed.h5 --optical-depth 1 --albedo 1 --format fourier -o new.bsdf
refuse --at "left out" g=0.5 -- export full.h5 --at g=0.5 --optical-depth 1 --albedo 1 --format fourier -o new.bsdf
refuse --at "left out for a stack" g=0.5 -- export free.toml --at g=0.5 --format fourier -o new.bsdf
refuse --at three 2 -- export family.h5 --at g=0.5 --at g=0.4 --optical-depth 1 --albedo 1 --format fourier -o new.bsdf
refuse "--at g" "[0.3, 0.6] of the table" 0.7 -- export family.h5 --at g=0.7 --optical-depth 1 --albedo 1 --format fourier -o new.bsdf
refuse "--at g" "[0.3, 0.6] of the table" 0.5um -- export family.h5 --at g=0.5um --optical-depth 1 --albedo 1 --format fourier -o new.bsdf
for at in g mixture=0.5 0.5 g=0.4,g=0.5 ,; do
    refuse --at NAME=VALUE "as in g=0.3" "got $at" -- export family.h5 --at $at --optical-depth 1 --albedo 1 --format fourier -o new.bsdf
done
refuse "colours of netcdf" 3 -- export full.h5 --optical-depth 1 --albedo 1,1,1 --format netcdf -o new.nc
refuse --nodes "[1, 512]" 0 -- export full.h5 --optical-depth 1 --albedo 1 --nodes 0 --format fourier -o new.bsdf
expect_refused 1 absent.h5 -- export absent.h5 --optical-depth 1 --albedo 1 --format fourier -o new.bsdf
expect_refused 1 absent/new.bsdf -- export full.h5 --optical-depth 1 --albedo 1 --format fourier -o absent/new.bsdf
mkdir new.json
expect_refused 2 --output new.json -- export full.h5 --optical-depth 1 --albedo 1 --format exr-atlas -o new.exr

# --- a limited disk: what was there stays

before=$(cksum rgb.bsdf)
through "$size_limited" expect_refused 1 rgb.bsdf -- export full.h5 --optical-depth 1 --albedo 1 --nodes 16 --format fourier -o rgb.bsdf --quiet
[ "$before" = "$(cksum rgb.bsdf)" ] || fail "rgb.bsdf is harmed"
finish
