#!/usr/bin/env bash
# two_builds.sh STRATUS OTHER_STRATUS: tables baked by two builds of the program agree to 1e-6.
set -eu
recipes=$(realpath "$(dirname "$0")/recipes")
one=$(realpath "$1")
other=$(realpath "$2")
python=/usr/bin/python3 # Debian's, which has h5py
[ -x "$python" ] || python=python3
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# At this tolerance, samples are not rounded. The first recipe sets no discretisation.
cat >open.toml <<'RECIPE'
phase_function = "rayleigh"
tolerance = 1e-4
optical_depth = { min = 0.5, max = 2.0 }
albedo = { min = 0.5, max = 1.0 }
RECIPE
for recipe in plain ground mixture; do
    sed 's/^tolerance.*/tolerance = 1e-4/' "$recipes/$recipe.toml" >$recipe.toml
done
for recipe in open plain ground mixture; do
    "$one" bake $recipe.toml -o $recipe.one.h5 --accept --quiet
    "$other" bake $recipe.toml -o $recipe.other.h5 --accept --quiet
    "$python" - $recipe.one.h5 $recipe.other.h5 <<'PYTHON'
import sys
import h5py
import numpy

one, other = (h5py.File(name) for name in sys.argv[1:])
if one.attrs["resolved_recipe"] != other.attrs["resolved_recipe"]:
    sys.exit(f"{sys.argv[1]}: the two builds made different choices")
largest = 0
for name in one:
    a, b = one[name][...].astype(float), other[name][...].astype(float)
    finite = numpy.isfinite(a)
    a, b = a[finite], b[finite]
    # relative error, but of values below a thousandth of the largest one relative to that
    scale = numpy.maximum(numpy.abs(a), 1e-3 * numpy.abs(a).max())
    worst = (numpy.abs(a - b) / numpy.where(scale > 0, scale, 1)).max()
    if not worst <= 1e-6:
        sys.exit(f"{sys.argv[1]}: {name} differs by {worst:.1e}, more than 1e-6")
    largest = max(largest, worst)
print(f"{sys.argv[1]}: largest difference {largest:.1e}")
PYTHON
done
