#!/usr/bin/env bash
# Builds the installed example of a CMake project and looks up the table of RECIPE, packed, with it: the numbers of `stratus eval`.
#
#     example.sh PREFIX RECIPE CXX
set -eu
prefix=$1 recipe=$2 cxx=$3
work=$prefix/../example
rm -rf "$work"
mkdir "$work"
cmake -S "$(find "$prefix" -path '*/stratus/examples/cmake')" -B "$work/build" -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_CXX_COMPILER="$cxx" >"$work/log"
cmake --build "$work/build" >>"$work/log"

"$prefix/bin/stratus" bake "$recipe" -o "$work/table.h5" --accept --quiet
"$prefix/bin/stratus" pack "$work/table.h5" -o "$work/table.stratus" --quiet
"$work/build/look_up" "$work/table.stratus" >"$work/printed"
printf '%s\n' 'mu_in,mu_out,azimuth_deg,optical_depth,albedo' '0.8,0.5,60,1.2,0.95' '0.8,0.5,60,0.6,0.9' \
    '0.8,0.5,60,1.2,0.95' '0.8,0.5,60,2,1' |
    "$prefix/bin/stratus" eval "$work/table.stratus" |
    awk -F, 'NR == 2 { printf "R = %.5f, T = %.5f\n", $6, $7 } NR > 2 { printf "%.4f\n", $6 }' |
    diff "$work/printed" -
