#!/usr/bin/env bash
# stratus verify: tables that keep what they state, one that does not, and files that are no tables.
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

# bake_coarse TABLE TOLERANCE SIDES: coarse, whatever the tolerance
bake_coarse() {
    cat >recipe.toml <<RECIPE
phase_function = "isotropic"
tolerance = $2
optical_depth = { min = 0.5, max = 2.0 }
albedo = { min = 0.9, max = 1.0 }
sides = [$3]
[discretisation]
nodes = 8
modes = 1
mu_samples = 6
azimuth_samples = 4
optical_depth_samples_per_octave = 1
albedo_samples = 3
RECIPE
    expect_ok bake recipe.toml -o "$1" --accept --quiet
}

# --- a table within its tolerance

bake_coarse kept.h5 0.1 '"reflection", "transmission"'
expect_ok verify kept.h5 --samples 300
expect_silent "$err"
expect_says "$out" "300 random points" median "99 %" "99.9 %" worst "worst points" "energy: at albedo 1" \
    "white furnace" "tolerance 0.1: " "% of values within it"
grep -qE '^reflection +all directions +300( +[0-9.]+e-[0-9]+){4}$' "$out" || fail "300 reflections are needed"
grep -qE '^transmission +all directions +300( +[0-9.]+e-[0-9]+){4}$' "$out" || fail "300 transmissions are needed"
[ "$(sed -n '/^worst points/,/^$/p' "$out" | grep -cE '^(reflection|transmission)( +[-+0-9.e]+){8}$')" -eq 5 ] ||
    fail "the five worst points are needed"
cp "$out" answer

# the same answer from either file, on any number of threads; other points for another seed
expect_ok convert kept.h5 kept.exr
expect_ok verify kept.exr --samples 300 --threads 2 --seed 1 --quiet
expect_same "$out" answer
expect_ok verify kept.h5 --samples 300 --seed 2 --threads 1
cmp -s "$out" answer && fail "another seed must be other points"
expect_ok verify kept.h5 --samples 1
rm answer kept.exr

# --- a peaked phase function: rows of their own near forward and at grazing pairs

sed 's/isotropic/henyey_greenstein:g=0.8/; s/^modes = 1$/modes = 8/' recipe.toml >peaked.toml
expect_ok bake peaked.toml -o peaked.h5 --accept --quiet
"$stratus" verify peaked.h5 --samples 40 --quiet >"$out" 2>"$err"
[ $? -eq 1 ] || fail "eight modes are too few for it"
for side in reflection transmission; do
    grep -qE "^$side +drawn within 10 degrees +20( +[0-9.]+e[-+][0-9]+){4}$" "$out" || fail "20 forward values are needed"
    grep -qE "^$side +drawn at cosines below 0.15 +10( +[0-9.]+e[-+][0-9]+){4}$" "$out" || fail "10 grazing values are needed"
done
expect_says "$err" "99 % within 10 degrees of forward and at cosines below 0.15, got "
rm peaked.toml peaked.h5

# --- a table that misses it: the answer all the same, exit 1 and why

bake_coarse missed.h5 1e-4 '"reflection"'
before=$(snapshot)
"$stratus" verify missed.h5 --samples 300 >"$out" 2>"$err"
[ $? -eq 1 ] || fail "a table that misses its tolerance must exit 1"
[ "$before" = "$(snapshot)" ] || fail "files differ after verify"
[ "$(wc -l <"$err")" -eq 1 ] || fail "not one line on stderr"
expect_says "$err" "stratus: verify: missed.h5" "99.9 %" "tolerance 0.0001" "5 times" "got "
expect_says "$out" "all directions" "worst points" "tolerance 0.0001: "
[ "$(sed -n '/^worst points/,/^$/p' "$out" | grep -c '^reflection ')" -eq 5 ] || fail "the five worst points are needed"
grep -q '^transmission' "$out" && fail "the table has no transmission"

# --- refusals

for value in 0 -1 1.5 1e3 x ''; do
    expect_refused 2 --samples "in [1, 100000000]" "got ${value:-nothing}" -- verify kept.h5 --samples "$value"
done
for value in -1 4294967296 x ''; do
    expect_refused 2 --seed "in [0, 4294967295]" "got ${value:-nothing}" -- verify kept.h5 --seed "$value"
done
for value in -1 1025 x ''; do
    expect_refused 2 --threads "in [0, 1024]" "got ${value:-nothing}" -- verify kept.h5 --threads "$value"
done
expect_refused 2 TABLE required -- verify
expect_refused 2 extra -- verify kept.h5 extra

# what is no table is refused by every command that reads one, and harms nothing
expect_ok convert kept.h5 kept.exr
echo older >older.h5
echo older >older.exr
printf '%s\n' mu_in,mu_out,azimuth_deg,optical_depth,albedo 0.5,0.5,0,1,0.95 >query.csv
refuse_table() { # refuse_table CODE FILE FRAGMENT...
    local code=$1 file=$2
    shift
    expect_refused "$code" "$@" -- info "$file"
    expect_refused "$code" "$@" -- info "$file" --picture new.png
    expect_refused "$code" "$@" -- verify "$file"
    expect_refused "$code" "$@" -- eval "$file" --query query.csv -o older.csv
    expect_refused "$code" "$@" -- convert "$file" older.h5
    expect_refused "$code" "$@" -- convert "$file" older.exr
}
echo older >older.csv
for ending in h5 exr; do
    size=$(stat -c %s kept.$ending)
    head -c $((size / 2)) kept.$ending >short.$ending
    refuse_table 1 short.$ending
    for bytes in 0 1 7 100 $((size - 100)); do
        head -c "$bytes" kept.$ending >short.$ending
        expect_refused 1 short.$ending -- verify short.$ending
    done
    { head -c $((size / 2)) kept.$ending; printf '\377\0\125'; tail -c +$((size / 2 + 4)) kept.$ending; } >bent.$ending
    refuse_table 1 bent.$ending
    echo "not a table, whatever its name says" >foreign.$ending
    refuse_table 1 foreign.$ending
    mkdir folder.$ending
    expect_refused 1 folder.$ending -- verify folder.$ending
    expect_refused 1 absent.$ending "No such file" -- verify absent.$ending
done
cp kept.exr disguised.h5
expect_refused 1 disguised.h5 HDF5 -- verify disguised.h5
cp kept.h5 disguised.exr
expect_refused 1 disguised.exr OpenEXR -- verify disguised.exr
expect_refused 2 kept.txt .h5 .exr -- verify kept.txt
expect_refused 2 .h5 .exr -- verify ''

# an answer that no disk takes is told
if [ -w /dev/full ]; then
    for arguments in "info kept.h5" "verify kept.h5 --samples 10" "verify --help"; do
        # shellcheck disable=SC2086  # words of a command
        "$stratus" $arguments >/dev/full 2>"$err"
        [ $? -eq 1 ] || fail "$arguments: an answer that could not be written must not exit 0"
        expect_says "$err" "stratus: standard output: No space left"
    done
fi
finish
