#!/usr/bin/env bash
# stratus convert: both ways and back without loss; its refusals.
newer=$(realpath "$(dirname "$0")/../golden/newer.exr")
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

for kind in full endless; do
    "$make_fixture" $kind $kind.h5 || exit 1
    expect_ok convert $kind.h5 $kind.exr
    expect_silent "$out"
    expect_silent "$err"
    expect_ok convert $kind.exr back.h5
    expect_ok convert back.h5 back.exr
    expect_same $kind.h5 back.h5
    expect_same $kind.exr back.exr
done

echo older >back.h5
expect_ok convert full.exr back.h5
expect_same full.h5 back.h5
rm back.h5 back.exr

expect_refused 2 OUT .h5 .exr table.txt -- convert full.h5 table.txt
expect_refused 2 IN .h5 .exr table -- convert table full.exr
expect_refused 2 full.h5 another -- convert full.h5 ./full.h5
ln -s full.h5 link.h5
expect_refused 2 link.h5 another -- convert full.h5 link.h5
expect_refused 1 absent.h5 -- convert absent.h5 new.exr
expect_refused 1 absent/new.exr -- convert full.h5 absent/new.exr
mkdir folder.exr
expect_refused 1 folder.exr -- convert full.h5 folder.exr

# a file of a version to come is read, and every command says so
printf 'mu_in,mu_out,azimuth_deg,optical_depth,albedo\n0.5,0.8,60,1,0.8\n' >query.csv
for command in "info $newer" "eval $newer --query query.csv" "convert $newer newer.h5"; do
    # shellcheck disable=SC2086  # words of a command
    expect_ok $command
    expect_says "$err" "newer.exr: format 1.9 is newer than 1.4"
done
expect_ok info newer.h5
expect_silent "$err"

# an older table survives a reader's refusal
head -c 1000 full.h5 >short.h5
expect_refused 1 short.h5 -- convert short.h5 full.exr
finish
