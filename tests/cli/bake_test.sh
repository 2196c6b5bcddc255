#!/usr/bin/env bash
# stratus bake: both files, what it says, the same bytes on any number of threads; interruptions and every refusal.
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

mkdir recipes
awk 'BEGIN { print "phase_angle_deg,value"; for (a = 0; a <= 180; a += 20) print a "," 2 + cos(a / 57.3) }' \
    >recipes/curve.csv
cat >recipes/narrow.toml <<'RECIPE'
title = "Narrow and coarse"
phase_function = "3*tabulated:file=curve.csv + 1*isotropic"  # beside the recipe
tolerance = 1e-2
optical_depth = { min = 0.5, max = 2.0 }
albedo = { min = 0.8, max = 0.9 }
RECIPE
# everything chosen: nothing is left to be measured
cat >recipes/chosen.toml <<'RECIPE'
phase_function = "henyey_greenstein:g=0.3"
tolerance = 0.1
optical_depth = { min = 0.5, max = 2.0 }
albedo = { min = 0.5, max = 0.6 }
sides = ["reflection"]
[discretisation]
nodes = 8
modes = 4
mu_samples = 6
azimuth_samples = 5
optical_depth_samples_per_octave = 1
albedo_samples = 2
scheme = "classic"
RECIPE

# --- answers

expect_ok bake recipes/narrow.toml -o narrow.h5 --exr narrow.exr --threads 1
expect_silent "$out"
expect_says "$err" "note: " curve.csv "weights summed to 4" "nodes " "modes " "mu_samples " "azimuth_samples " \
    "checked at 2000 random points" "samples a side" "MiB on disk" "asked for 0.01"
[ "$(find . -name '*.h5' -o -name '*.exr' -o -name '.*.*' | wc -l)" -eq 2 ] || fail "only the two tables may be made"

# size and time before the bake; a dry run tells them alone, and writes nothing
expect_says "$err" "in memory and uncompressed; about " " s to solve and "
expect_ok bake recipes/narrow.toml --dry-run --quiet
expect_silent "$err"
expect_says "$out" "nodes = " "azimuth_scale = " "samples a side, " " s to check"
expect_refused 2 "--output is required" -- bake recipes/narrow.toml
cat >recipes/capped.toml <<'RECIPE'
phase_function = "isotropic"
tolerance = 1e-6
optical_depth = { min = inf, max = inf }
albedo = { min = 0.9, max = 0.9 }
sides = ["reflection"]
[discretisation]
nodes = 16
RECIPE
expect_ok bake recipes/capped.toml --dry-run --accept --quiet
expect_says "$out" "mu_samples is at its cap of 56" "would do, in a table of"
rm recipes/capped.toml

# the same bytes on any number of threads; quiet is silent; an older file is replaced
for threads in 2 7; do
    echo older >again.h5
    expect_ok bake recipes/narrow.toml -o again.h5 --exr again.exr --threads $threads --quiet
    expect_silent "$out"
    expect_silent "$err"
    expect_same narrow.h5 again.h5
    expect_same narrow.exr again.exr
done
rm again.*

printf '%s\n' mu_in,mu_out,azimuth_deg,optical_depth,albedo 0.5,0.8,60,1.5,0.85 1,0.1,0,0.5,0.8 0.03,0.3,180,2,0.9 \
    >query.csv
# straight into the packed table, from a few samples of most layers: the same bytes on any number of threads
expect_ok bake recipes/narrow.toml -o narrow.stratus --threads 1 --quiet
expect_ok bake recipes/narrow.toml -o again.stratus --threads 3 --quiet
expect_same narrow.stratus again.stratus
# with all samples beside it: those of a bake of samples, and what packing them afterwards gives; both are near each other
expect_ok bake recipes/narrow.toml -o again.stratus --h5 again.h5 --exr again.exr --threads 3 --quiet
for table in narrow again; do expect_ok eval $table.h5 --query query.csv -o $table.csv; done
expect_same narrow.csv again.csv
expect_ok eval again.exr --query query.csv -o again.csv
expect_same narrow.csv again.csv
expect_ok pack narrow.h5 -o packed.stratus --quiet
for table in narrow again packed; do expect_ok eval $table.stratus --query query.csv -o $table.csv; done
expect_same again.csv packed.csv
for row in 2 3 4; do
    expected=$(sed -n ${row}p packed.csv | cut -d, -f6)
    expect_near "$(sed -n ${row}p narrow.csv | cut -d, -f6)" "$expected" "$(awk -v e="$expected" 'BEGIN { print e / 100 }')"
done
expect_ok verify narrow.stratus --samples 200 --quiet
expect_says "$out" "tolerance 0.01: 100.00 % of values within it"
rm again.* packed.* narrow.stratus narrow.csv

# both files hold the same values, near those of the solver, and become one another without loss
expect_ok eval narrow.h5 --query query.csv -o h5.csv
expect_ok eval narrow.exr --query query.csv -o exr.csv
expect_same h5.csv exr.csv
printf '%s\n' mu_in,mu_out,azimuth_deg 0.5,0.8,60 >query.csv
expect_ok solve --phase '0.75*tabulated:file=recipes/curve.csv + 0.25*isotropic' --albedo 0.85 --optical-depth 1.5 \
    --query query.csv
for field in 1 2; do
    solved=$(sed -n 2p "$out" | cut -d, -f$((3 + field)))
    expect_near "$(sed -n 2p h5.csv | cut -d, -f$((5 + field)))" "$solved" "$(awk -v s="$solved" 'BEGIN { print s / 100 }')"
done
expect_ok convert narrow.exr back.h5
expect_same narrow.h5 back.h5
expect_ok convert narrow.h5 back.exr
expect_same narrow.exr back.exr
rm back.*

# info: the recipe as given and as resolved, which bakes the same samples wherever it lies
expect_ok info narrow.h5
expect_says "$out" "Narrow and coarse" "0.5 to 2" "0.8 to 0.9" "reflection, transmission" "tolerance             0.01" \
    "3*tabulated:file=curve.csv + 1*isotropic" "# beside the recipe" "resolved recipe" mu_samples 'scheme = "harmonic"'
expect_ok verify narrow.h5 --samples 200
expect_says "$out" "200 random points" median "tolerance 0.01: 100.00 %"
expect_ok info narrow.exr
sed -n '/^resolved recipe/,$p' "$out" | sed '1d; s/^    //' >resolved.toml
expect_ok bake resolved.toml -o resolved.h5 --quiet
printf '%s\n' mu_in,mu_out,azimuth_deg,optical_depth,albedo 0.5,0.8,60,1.5,0.85 1,0.1,0,0.5,0.8 0.03,0.3,180,2,0.9 \
    >query.csv
expect_ok eval resolved.h5 --query query.csv
expect_same "$out" h5.csv
rm resolved.* h5.csv exr.csv query.csv

# an expert's choice is taken
# over ground: both files keep it, info tells it, verify solves it, eval adds its single scattering
sed '/^sides/d' recipes/chosen.toml >recipes/ground.toml
printf '[below]\nlambert_albedo = 0.3\n' >>recipes/ground.toml
expect_ok bake recipes/ground.toml -o ground.h5 --exr ground.exr --quiet
for table in ground.h5 ground.exr; do
    expect_ok info $table
    expect_says "$out" "Lambert surface, albedo 0.3" "lambert_albedo = 0.3"
    printf 'mu_in,mu_out,azimuth_deg,optical_depth,albedo\n0.5,0.8,60,1,0.55\n' >query.csv
    expect_ok eval $table --query query.csv
    cp "$out" $table.csv
done
cmp -s ground.h5.csv ground.exr.csv || fail "both files must give the same values"
expect_ok verify ground.h5 --samples 200
expect_ok info narrow.h5
expect_says "$out" "lower boundary        none"
printf 'sides = ["transmission"]\n' | cat - recipes/ground.toml >recipes/bad.toml
expect_refused 2 sides "[below]" "got transmission" -- bake recipes/bad.toml -o new.h5

# two kinds of scattering in any mixture
cat >recipes/mixed.toml <<'EOT'
phase_function = "henyey_greenstein:g=-0.3"
second_phase_function = "isotropic"
tolerance = 5e-2
optical_depth = { min = 1.0, max = 1.0 }
albedo = { min = 0.9, max = 0.9 }
sides = ["reflection"]
EOT
expect_ok bake recipes/mixed.toml -o mixed.h5 --exr mixed.exr
expect_says "$err" "mixture 0.5:" "mixture_samples"
expect_ok convert mixed.exr back.h5
expect_same mixed.h5 back.h5
expect_ok info mixed.h5
expect_says "$out" "second phase function isotropic" "the share of the first" 'second_phase_function = "isotropic"'
for flag in --seed=2 --bound; do
    expect_ok verify mixed.h5 --samples 200 $flag
    expect_says "$out" "mixture" "tolerance 0.05: 100.00 %"
done
sed '/^second/d; /^sides/a mixture = { min = 0, max = 1 }' recipes/mixed.toml >recipes/bad.toml
expect_refused 2 mixture "no second_phase_function" -- bake recipes/bad.toml -o new.h5
rm back.h5

expect_ok bake recipes/chosen.toml -o chosen.h5
expect_says "$err" "checked at 2000 random points"
expect_ok info chosen.h5
expect_says "$out" "6 samples" "5 samples" "2 samples" 'scheme = "classic"'
grep -q '^sides *reflection$' "$out" || fail "only the side asked for"

# --- a table that misses its tolerance: written, told in one sentence, exit code 1 unless accepted

cat >recipes/missed.toml <<'RECIPE'
phase_function = "isotropic"
tolerance = 1e-6
optical_depth = { min = 1.0, max = 1.0 }
albedo = { min = 0.5, max = 0.9 }
sides = ["reflection"]
RECIPE
"$stratus" bake recipes/missed.toml -o missed.h5 >"$out" 2>"$err"
[ $? -eq 1 ] || fail "a table that misses its tolerance must exit 1"
[ "$(grep -c "checked at 2000 random points" "$err")" -eq 1 ] || fail "an axis at its cap must end the attempts"
for flags in --quiet "--quiet --accept"; do
    # shellcheck disable=SC2086  # words of a command
    "$stratus" bake recipes/missed.toml -o again.h5 $flags >"$out" 2>"$err"
    [ $? -eq "$([ "$flags" = --quiet ] && echo 1 || echo 0)" ] || fail "$flags: another exit code"
    expect_silent "$out"
    [ "$(wc -l <"$err")" -eq 1 ] || fail "$flags: not one line on stderr"
    expect_says "$err" "stratus: bake: again.h5: the table misses its tolerance 1e-06: 99.9 % of values are within " \
        "mu_samples is at its cap of 56"
    expect_same again.h5 missed.h5
    rm again.h5
done
[ ! -e missed.h5.checkpoint ] || fail "the checkpoint must be removed"
rm missed.h5

# --- interruptions: no partial file, finished work is kept

sed 's/1e-2/1e-5/; s/phase_function.*/phase_function = "henyey_greenstein:g=0.6"/' recipes/narrow.toml >recipes/long.toml
printf '[discretisation]\nnodes = 16\n' >>recipes/long.toml
echo older >older.h5
checkpoint=older.h5.checkpoint
start_long_bake() { # start_long_bake ARGS...: in the background, as $child, until it has made a choice
    : >"$err"  # of the bake before
    env --default-signal=INT "$stratus" bake recipes/long.toml -o older.h5 --exr new.exr "$@" >"$out" 2>"$err" &  # which bash ignores
    child=$!
    for _ in $(seq 600); do
        grep -q -e '^  modes ' -e '_samples [0-9]' "$err" && break
        sleep 0.05
    done
}
for end in "INT 130" "TERM 143" "HUP 129"; do
    before=$(snapshot | grep -v ./kept)
    start_long_bake
    kill -s "${end% *}" $child
    wait $child
    code=$?
    [ $code -eq "${end#* }" ] || fail "exit code $code after SIG$end"
    [ "$(tail -n 1 "$err")" = "stratus: interrupted; finished work is kept in $checkpoint: repeat the command with --resume" ] ||
        fail "the last line must say how to go on"
    mv $checkpoint kept || fail "no checkpoint after SIG$end"
    [ "$before" = "$(snapshot | grep -v ./kept)" ] || fail "files differ after SIG$end"
done

# a checkpoint is neither overwritten by accident nor used for another recipe
mv kept $checkpoint
expect_refused 1 $checkpoint --resume removing -- bake recipes/long.toml -o older.h5 --quiet
expect_refused 1 $checkpoint "another recipe" "Narrow and coarse" remove -- \
    bake recipes/chosen.toml -o older.h5 --resume --quiet
# nor shared by two bakes at once
start_long_bake --resume
expect_says "$err" "resuming from $checkpoint"
kill -s STOP $child
expect_refused 1 $checkpoint "another bake of this table is running" -- bake recipes/long.toml -o older.h5 --resume --quiet
kill -s CONT $child
kill -s TERM $child
wait $child
rm $checkpoint
echo older >$checkpoint
expect_refused 1 $checkpoint "is not a checkpoint" -- bake recipes/long.toml -o older.h5 --resume --quiet
rm $checkpoint

# without a checkpoint, the bake begins from the start
expect_ok bake recipes/chosen.toml -o resumed.h5 --resume
expect_says "$err" "no checkpoint to resume from"
expect_ok bake recipes/chosen.toml -o begun.h5
expect_same resumed.h5 begun.h5
rm resumed.h5 begun.h5
# in the short time in which a file is written it waits
for wait in 0.005 0.01 0.015 0.02 0.03 0.05; do
    timeout --foreground -s INT $wait "$stratus" convert narrow.exr new.h5 >"$out" 2>"$err"
    [ -z "$(find . -name '.*.*')" ] || fail "a file of its own is left over after SIGINT"
    [ ! -e new.h5 ] || expect_same new.h5 narrow.h5
    rm -f new.h5
done

# --- refusals

refuse() { # refuse CODE FRAGMENT... -- ARGUMENT...: in a bake of recipes/chosen.toml
    local fragments=()
    while [ "$1" != -- ]; do
        fragments+=("$1")
        shift
    done
    shift
    expect_refused "${fragments[@]}" -- bake recipes/chosen.toml "$@"
}
refuse 2 --output required --
refuse 2 --output .h5 "got table.txt" -- -o table.txt
refuse 2 --output .h5 "got table" -- -o table
refuse 2 --output .h5 "got nothing" -- -o ''
refuse 2 --output .h5 "got table.exr" -- -o table.exr
refuse 2 --exr .exr "got table.h5" -- -o new.h5 --exr table.h5
refuse 2 --exr file "got nothing" -- -o new.h5 --exr ''
refuse 2 --h5 .h5 "got table.exr" -- -o new.stratus --h5 table.exr
refuse 2 --h5 "left out for an output that is itself .h5" "got more.h5" -- -o new.h5 --h5 more.h5
refuse 1 absent/new.h5 "no folder absent" -- -o new.stratus --h5 absent/new.h5
refuse 1 absent/new.h5 "no folder absent" -- -o absent/new.h5
refuse 1 absent/new.exr "no folder absent" -- -o new.h5 --exr absent/new.exr
mkdir folder.h5 folder.exr
refuse 2 --output file "got the folder folder.h5" -- -o folder.h5
refuse 2 --exr file "got the folder folder.exr" -- -o new.h5 --exr folder.exr
mkfifo pipe.h5
refuse 2 --output file pipe.h5 -- -o pipe.h5
for value in -1 1025 1.5 x ''; do
    refuse 2 --threads "in [0, 1024]" "got ${value:-nothing}" -- -o new.h5 --threads "$value"
done
refuse 2 extra -- -o new.h5 extra
expect_refused 2 RECIPE required -- bake -o new.h5
expect_refused 1 absent.toml -- bake absent.toml -o new.h5
expect_refused 1 recipes -- bake recipes -o new.h5
cp recipes/chosen.toml recipe.h5
expect_refused 2 recipe.h5 another -- bake recipe.h5 -o recipe.h5

refuse_recipe() { # refuse_recipe SED FRAGMENT...: recipes/chosen.toml edited; an older table comes to no harm
    sed "$1" recipes/chosen.toml >recipes/bad.toml
    shift
    expect_refused 2 "$@" -- bake recipes/bad.toml -o older.h5
}
refuse_recipe 's/^tolerance/tolerence/' "unknown key 'tolerence'" "line 2" "'tolerance'"
refuse_recipe 's/^nodes/node/' "unknown key 'discretisation.node'" "'discretisation.nodes'"
refuse_recipe 's/^.discretisation.$/[discretization]/' "unknown key 'discretization'" "'discretisation'"
refuse_recipe '/^albedo/s/max/maximum/' "unknown key 'albedo.maximum'" "'albedo.max'"
refuse_recipe '/^tolerance/d' tolerance present "got nothing"
refuse_recipe '/^phase_function/d' phase_function present "got nothing"
refuse_recipe '/^tolerance/s/0.1/0.2/' tolerance "[1e-6, 0.1]" 0.2
refuse_recipe '/^tolerance/s/0.1/0/' tolerance "[1e-6, 0.1]" "got 0"
refuse_recipe '/^tolerance/s/0.1/nan/' tolerance "[1e-6, 0.1]" "got nan"
refuse_recipe '/^tolerance/s/0.1/"small"/' tolerance "line 2" number
refuse_recipe '/^tolerance/s/=/:/' "line 2"
refuse_recipe '/^albedo =/s/0.6/1.2/' albedo.max "[0, 1]" "got 1.2"
refuse_recipe '/^albedo =/s/0.5/-0.5/' albedo.min "[0, 1]" "got -0.5"
refuse_recipe '/^albedo =/s/0.6/0.25/' albedo.min "at most max" "got 0.5"
refuse_recipe '/^albedo =/s/=.*/= 0.5/' albedo "{ min, max }"
refuse_recipe '/^optical_depth =/s/0.5/-1/' optical_depth.min "[1e-6, 1e9] or inf" "got -1"
refuse_recipe '/^optical_depth =/s/2.0/nan/' optical_depth.max "[1e-6, 1e9] or inf" "got nan"
refuse_recipe '/^sides/d; /^optical_depth =/s/=.*/= { min = inf, max = inf }/' 'sides must be ["reflection"]' \
    "got no sides, which bakes both"
refuse_recipe '/^sides/d; $a [below]\nalbedo = 0.3' \
    "below must be lambert_albedo alone, ground alone, or both phase_function and albedo, got albedo alone"
refuse_recipe '/^sides/d; $a [below]\nphase_function = "isotropic"' "got phase_function alone"
refuse_recipe 's/"reflection"/"up"/' sides reflection transmission "got up"
refuse_recipe 's/"reflection"//' sides reflection transmission "got an empty list"
refuse_recipe 's/^nodes.*/nodes = 0/' discretisation.nodes "[1, 512]" "got 0"
refuse_recipe 's/^nodes.*/nodes = 8.5/' discretisation.nodes "whole number"
refuse_recipe 's/^mu_samples.*/mu_samples = 3/' discretisation.mu_samples "[4, 512]" "got 3"
refuse_recipe 's/"classic"/"modern"/' discretisation.scheme harmonic classic "got modern"
refuse_recipe 's/g=0.3/g=1/' "g must be in (-1, 1)" "got 1"
refuse_recipe 's/henyey_greenstein:g=0.3/henyey/' phase_function "got 'henyey'"
head -c 3000 /bin/sh >recipes/bad.toml
expect_refused 2 "bad.toml must be TOML text, got a binary file" -- bake recipes/bad.toml -o older.h5
sed 's/henyey_greenstein:g=0.3/tabulated:file=absent.csv/' recipes/chosen.toml >recipes/bad.toml
expect_refused 1 recipes/absent.csv -- bake recipes/bad.toml -o older.h5
sed 's/henyey_greenstein:g=0.3/tabulated:file=bad.csv/' recipes/chosen.toml >recipes/bad.toml
printf 'phase_angle_deg,value\n0,1\n180,1\n' >recipes/bad.csv
expect_refused 2 "at least 3 rows" "got 2" -- bake recipes/bad.toml -o older.h5
printf 'phase_angle_deg,value\n0,1\n90,-1\n180,1\n' >recipes/bad.csv
expect_refused 2 value "recipes/bad.csv, line 3" "got -1" -- bake recipes/bad.toml -o older.h5
printf 'phase_angle_deg,value\n0,1\n90,1\n80,1\n' >recipes/bad.csv
expect_refused 2 phase_angle_deg "recipes/bad.csv, line 4" "got 80" -- bake recipes/bad.toml -o older.h5

# a disk that fills up, a folder that refuses
through "$size_limited" expect_refused 1 older.h5 "too large" -- bake recipes/chosen.toml --quiet -o older.h5
through "$size_limited" expect_refused 1 new.h5 "too large" -- convert narrow.exr new.h5
if [ -n "$small_disk" ]; then
    for file in older.h5 new.h5; do
        through "$small_disk" expect_refused 1 disk/$file "No space left" -- bake recipes/chosen.toml --quiet -o disk/$file
        through "$small_disk" expect_refused 1 disk/$file "No space left" -- convert narrow.exr disk/$file
    done
    # a bake that cannot be written is not lost
    # shellcheck disable=SC2317  # `through` calls it
    fail_to_write() {
        "$stratus" bake recipes/narrow.toml -o kept.h5 --exr disk/new.exr --quiet >"$out" 2>"$err"
        [ $? -eq 1 ] || fail "the picture cannot be written"
        expect_says "$err" \
            "disk/new.exr: No space left on device; finished work is kept in kept.h5.checkpoint for --resume"
    }
    through "$small_disk" fail_to_write
    expect_ok bake recipes/narrow.toml -o kept.h5 --exr kept.exr --resume --quiet
    expect_same kept.h5 narrow.h5
    expect_same kept.exr narrow.exr
    [ ! -e kept.h5.checkpoint ] || fail "the checkpoint must be removed"
else
    echo "skipped: a full disk, which this machine does not let us make"
fi
if [ -n "$user_refused" ]; then
    through "$user_refused" expect_refused 1 shut/new.h5 "cannot be written" -- bake recipes/chosen.toml -o shut/new.h5
    through "$user_refused" expect_refused 1 shut/new.h5 "Permission denied" -- convert narrow.exr shut/new.h5
else
    echo "skipped: a folder that must not be written to"
fi
finish
