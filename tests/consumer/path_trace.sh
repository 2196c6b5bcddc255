#!/usr/bin/env bash
# Builds programs in C++ and C, the README's example among them, against an installed copy with a compiler and pkg-config
# alone, and checks what they print.
#
#     path_trace.sh PREFIX RECIPE PYTHON C_PROGRAM CXX CC
set -eu
prefix=$1 recipe=$2 python=$3 c_program=$4 cxx=$5 cc=$6
here=$(dirname "$0")
work=$prefix/../without_cmake
rm -rf "$work"
mkdir "$work"
PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name stratus.pc)")
export PKG_CONFIG_PATH
libraries=$(dirname "$PKG_CONFIG_PATH")

awk '/^...cpp$/ { inside = 1; next } /^...$/ { inside = 0 } inside' "$here/../../README.md" >"$work/readme.cpp"

# shellcheck disable=SC2046  # words of a command
{
    "$cxx" -O2 "$here/path_tracer.cpp" $(pkg-config --cflags --libs stratus-io) -o "$work/path_tracer"
    "$cxx" -O2 "$work/readme.cpp" $(pkg-config --cflags --libs stratus) -o "$work/readme"
    "$cxx" -O2 "$here/project/renderer.cpp" $(pkg-config --cflags --libs stratus) -o "$work/renderer"
    "$cc" -std=c99 "$(find "$prefix" -name bake.c)" $(pkg-config --cflags --libs stratus-c-baker) -Wl,-rpath,"$libraries" -o "$work/bake"
    "$cc" -std=c99 "$c_program" $(pkg-config --cflags --libs stratus-c) -lm -Wl,-rpath,"$libraries" -o "$work/look_up"
    "$cxx" -O2 "$here/project/renderer.cpp" $(pkg-config --cflags --libs --static stratus-io) -o "$work/renderer"
}
"$work/renderer" >/dev/null
(cd "$work" && ./bake >/dev/null 2>&1)

printf '%s\n' 'phase_function = "isotropic"' 'tolerance = 0.1' 'optical_depth = { min = 1.0, max = 2.0 }' \
    'albedo = { min = 0.9, max = 1.0 }' >"$work/haze.toml"
mkdir "$work/baked"
"$prefix/bin/stratus" bake "$work/haze.toml" -o "$work/baked/saturn_rings.stratus" --quiet
"$prefix/bin/stratus" bake "$recipe" -o "$work/dust.h5" 2>"$work/log" || { cat "$work/log"; exit 1; }
(cd "$work" && ./readme) | grep -qE '^0\.[0-9]+, sampled with density [0-9.]+, beam 0\.15' # exp(-1.5 / 0.8)
"$work/path_tracer" "$work/dust.h5" "$work/sunlit.ppm" 2.5 0 1
"$work/path_tracer" "$work/dust.h5" "$work/furnace.ppm" 0 0.5
"$python" -B "$here/check_pictures.py" "$prefix/bin/stratus" "$work/dust.h5" "$work/sunlit.ppm" 2.5 "$work/furnace.ppm" 0.5
bash "$here/../c/with_table.sh" "$prefix/bin/stratus" "$work/look_up"
