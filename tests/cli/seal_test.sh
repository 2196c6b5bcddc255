#!/usr/bin/env bash
# stratus seal: a table changed on purpose is refused until it is sealed; what is no table is not sealed.
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

"$make_fixture" full full.h5 || exit 1
expect_ok convert full.h5 full.exr

# a table as it was written stays as it is
for table in full.h5 full.exr; do
    expect_ok seal $table -o sealed."${table#*.}"
    expect_silent "$out"
    expect_silent "$err"
    expect_same $table sealed."${table#*.}"
done

# another title, as long; not through HDF5, whose headers have checksums of their own
title=$("$stratus" info full.exr | sed -n 's/^title *//p')
for table in full.h5 full.exr; do
    sed "s/$title/${title/?/#}/" $table >changed."${table#*.}"
done
expect_refused 1 changed.h5 checksum -- info changed.h5
expect_refused 1 changed.h5 checksum -- seal changed.h5
expect_refused 1 "changed.exr: the metadata was changed or damaged since it was sealed" \
    "if on purpose, \`stratus seal changed.exr\`" -- info changed.exr
expect_ok seal changed.exr
expect_ok info changed.exr
expect_says "$out" "${title/?/#}"

expect_refused 2 TABLE .h5 .exr table.txt -- seal table.txt
expect_refused 2 TABLE .h5 .exr full.stratus -- seal full.stratus
expect_refused 2 --output .h5 .exr new.txt -- seal full.h5 -o new.txt
expect_refused 1 absent.h5 -- seal absent.h5
expect_refused 1 absent/new.h5 -- seal full.h5 -o absent/new.h5
head -c 1000 full.h5 >short.h5
expect_refused 1 short.h5 -- seal short.h5
sed 's/stratus-table/stratus-chair/' full.exr >other.exr
expect_refused 1 other.exr "is not a stratus-table file" -- seal other.exr
finish
