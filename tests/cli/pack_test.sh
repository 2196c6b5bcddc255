#!/usr/bin/env bash
# stratus pack: the packed file serves wherever a table does; its refusals.
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

cat >haze.toml <<'END'
title = "haze"
phase_function = "henyey_greenstein:g=0.5"
tolerance = 1e-2
optical_depth = { min = 0.1, max = 4.0 }
albedo = { min = 0.8, max = 1.0 }
END
expect_ok bake haze.toml -o haze.h5 --quiet
expect_ok pack haze.h5 -o haze.stratus
expect_silent "$out"
expect_says "$err" "haze.stratus" "MB" "% of the table's samples"
expect_ok pack haze.h5 -o again.stratus --quiet
expect_silent "$err"
expect_same haze.stratus again.stratus

expect_ok info haze.stratus
expect_says "$out" "haze" "henyey_greenstein:g=0.5"
expect_ok verify haze.stratus --samples 50
expect_ok verify haze.stratus --samples 50 --bound
printf 'mu_in,mu_out,azimuth_deg,optical_depth,albedo\n0.5,0.8,60,1,0.9\n' >query.csv
expect_ok eval haze.stratus --query query.csv

expect_refused 2 --output .stratus haze.h5 -- pack haze.h5 -o haze.h5
expect_refused 2 TABLE .h5 .exr haze.stratus -- pack haze.stratus -o other.stratus
expect_refused 1 absent.h5 -- pack absent.h5 -o new.stratus
# back to samples, which say what they are
expect_ok convert haze.stratus back.exr
expect_ok info back.exr
expect_says "$out" "samples               evaluated"
expect_ok eval back.exr --query query.csv -o back.csv
expect_ok eval haze.h5 --query query.csv -o haze.csv
for field in 6 7 8; do
    expected=$(sed -n 2p haze.csv | cut -d, -f$field)
    expect_near "$(sed -n 2p back.csv | cut -d, -f$field)" "$expected" "$(awk -v e="$expected" 'BEGIN { print e / 200 }')"
done
cp haze.stratus flipped.stratus
printf '\125' | dd of=flipped.stratus bs=1 seek=$(($(stat -c %s flipped.stratus) - 100)) conv=notrunc status=none
cmp -s haze.stratus flipped.stratus && fail "a byte must have changed"
expect_ok eval flipped.stratus --query query.csv
for command in info verify; do
    expect_refused 1 flipped.stratus checksum -- "$command" flipped.stratus
done
head -c 2000 haze.stratus >short.stratus
expect_refused 1 short.stratus -- info short.stratus
cp haze.h5 foreign.stratus
expect_refused 1 foreign.stratus "got an HDF5 file" "\`stratus pack\`" -- eval foreign.stratus --query query.csv
expect_ok convert haze.h5 haze.exr
cp haze.exr foreign.stratus
expect_refused 1 foreign.stratus "got an OpenEXR file" -- eval foreign.stratus --query query.csv
echo "a text of some length" >foreign.stratus
expect_refused 1 foreign.stratus "got another kind of file" "\`stratus bake\`" -- eval foreign.stratus --query query.csv
finish
