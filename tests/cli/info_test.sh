#!/usr/bin/env bash
# stratus info: its output, its picture, its refusals.
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

"$make_fixture" full full.h5 || exit 1
"$make_fixture" endless endless.h5 || exit 1
"$make_fixture" mixed mixed.h5 || exit 1

expect_ok info full.h5
expect_silent "$err"
expect_says "$out" title "Saturn's rings" "phase function" henyey_greenstein "asymmetry g" -0.096 \
    "8 samples" "0.01 to inf" "finite to 8" logarithmic "0 to 180 degrees" "reflection, transmission" \
    tolerance 0.001 0.00081 "in memory" "MB as float" "MB as half" 0.0.0-synthetic "made up for tests"
expect_ok info endless.h5
expect_says "$out" isotropic "1 sample at 0.9" "1 sample at inf"

expect_ok info mixed.h5
expect_says "$out" "second phase function isotropic" "2 samples at 0 to 1, identity, the share of the first phase function"

is_png() { [ "$(head -c 8 "$1" | od -An -tx1 | tr -d ' \n')" = 89504e470d0a1a0a ]; }
for table in full endless mixed; do
    expect_ok info $table.h5 --picture $table.png
    expect_says "$out" $table.png
    is_png $table.png || fail "$table.png is not a PNG file"
done
echo older >full.png
expect_ok info full.h5 --picture full.png
is_png full.png || fail "an older picture must be replaced"

expect_refused 1 absent.h5 -- info absent.h5
expect_refused 2 table.txt .h5 .exr -- info table.txt
echo "not a table" >foreign.h5
expect_refused 1 foreign.h5 -- info foreign.h5
expect_refused 2 info --picture .png "got full.gif" -- info full.h5 --picture full.gif
expect_refused 1 absent/full.png -- info full.h5 --picture absent/full.png
expect_refused 2 full.h5 another -- info full.h5 --picture full.h5
# every command that reads a table honours a limit on memory, before it looks at what it would read
cp full.h5 large.h5
truncate -s 2M large.h5
echo mu_in,mu_out,azimuth_deg,optical_depth,albedo >query.csv
for command in "info large.h5" "verify large.h5" "eval large.h5 --query query.csv" "convert large.h5 new.exr"; do
    # shellcheck disable=SC2086  # words of a command
    expect_refused 1 large.h5 "needs 2 MiB" "limit of 1 MiB" -- $command --max-memory 1
done
expect_refused 2 --max-memory 0 -- info --max-memory 0 full.h5
expect_refused 2 --max-memory 1.5 -- info --max-memory 1.5 full.h5
expect_ok info --max-memory 1 full.h5
finish
