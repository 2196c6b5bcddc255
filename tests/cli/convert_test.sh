#!/usr/bin/env bash
# stratus convert: both ways and back without loss; its refusals.
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

# an older table survives a reader's refusal
head -c 1000 full.h5 >short.h5
expect_refused 1 short.h5 -- convert short.h5 full.exr
finish
