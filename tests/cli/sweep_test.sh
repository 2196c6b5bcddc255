#!/usr/bin/env bash
# stratus bake --sweep: the tables that single bakes make, its summary, kills and resumptions, and every refusal.
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

cat >base.toml <<'RECIPE'
title = "Base"
phase_function = "isotropic"
tolerance = 0.1
optical_depth = { min = 1.0, max = 1.0 }
albedo = { min = 0.9, max = 0.9 }
sides = ["reflection"]
[discretisation]
nodes = 8
RECIPE
cat >sweep.csv <<'CSV'
# any key a column, an empty cell as the recipe has it
name,phase_function,optical_depth.min,optical_depth.max,discretisation.nodes,discretisation.mu_samples,sides
thin,,0.25,0.5,,6,
"rayleigh, both",rayleigh,,,10,6,"[""reflection"", ""transmission""]"
again,rayleigh,,,10,6,"[""reflection"", ""transmission""]"
grey,0.5*rayleigh + 0.5*isotropic,2,2,,6,
CSV
grep -v again sweep.csv >three.csv
header=name,asked,met,worst,seconds,bytes,remark
all_met='f["met"] == "yes" && f["asked"] == 0.1 && f["worst"] > 0 && f["worst"] < 0.1 && f["bytes"] > 1000'

# --- answers

expect_ok bake base.toml --sweep sweep.csv -o whole --quiet
expect_silent "$err"
expect_header "$header"
expect_same "$out" whole/summary.csv
tr -d '"' <whole/summary.csv | sed 's/rayleigh, both/rayleigh/' >"$out"
expect_rows 4 "$all_met"
[ "$(cd whole && echo *)" = "again.stratus grey.stratus rayleigh, both.stratus summary.csv thin.stratus" ] || fail "there is $(ls whole)"
expect_same whole/again.stratus "whole/rayleigh, both.stratus"
expect_says whole/summary.csv "the same as rayleigh, both"

# a row's table is that of its recipe alone, which it carries; on any number of threads
expect_ok info whole/thin.stratus
sed -n '/^recipe/,/^resolved recipe/p' "$out" | sed '1d; $d; s/^    //' >thin.toml
expect_says thin.toml 0.25 "nodes = 8" "mu_samples = 6"
expect_ok bake thin.toml -o single.stratus --quiet
printf '%s\n' mu_in,mu_out,azimuth_deg,optical_depth,albedo 0.5,0.8,60,0.3,0.9 >query.csv
expect_ok eval single.stratus --query query.csv -o single.csv
expect_ok eval whole/thin.stratus --query query.csv -o thin.csv
expect_same single.csv thin.csv
for threads in 1 5; do
    expect_ok bake base.toml --sweep three.csv -o threads --quiet --threads $threads
    for table in thin grey "rayleigh, both"; do expect_same "threads/$table.stratus" "whole/$table.stratus"; done
done

# without names they are numbered
printf 'albedo.min\n0.8\n0.7\n' >numbers.csv
expect_ok bake base.toml --sweep numbers.csv -o numbers
expect_says "$out" "1,0.1,yes" "2,0.1,yes"
[ "$(cd numbers && echo *)" = "1.stratus 2.stratus summary.csv" ] || fail "there is $(ls numbers)"

# a layer of a stack
cat >stack.toml <<'RECIPE'
tolerance = 0.1
sides = ["reflection"]
[[layers]]
phase_function = "rayleigh"
albedo = 1.0
optical_depth = 0.2
[[layers]]
phase_function = "isotropic"
albedo = 0.9
optical_depth = 1.0
[discretisation]
nodes = 8
RECIPE
printf 'layers.2.optical_depth\n0.5\n' >layers.csv
expect_ok bake stack.toml --sweep layers.csv -o stack --quiet
expect_ok info stack/1.stratus
expect_says "$out" "0.7"

# the rows may stand in the recipe itself: the same tables
cat base.toml - >own.toml <<'RECIPE'
[sweep]
name = ["thin", "rayleigh, both", "grey"]
phase_function = ["isotropic", "rayleigh", "0.5*rayleigh + 0.5*isotropic"]
optical_depth.min = [0.25, 1.0, 2.0]
"optical_depth.max" = [0.5, 1.0, 2.0]
discretisation.nodes = [8, 10, 8]
discretisation.mu_samples = [6, 6, 6]
sides = [["reflection"], ["reflection", "transmission"], ["reflection"]]
RECIPE
expect_ok bake own.toml -o own --quiet
for table in thin grey "rayleigh, both"; do
    expect_ok eval "whole/$table.stratus" --query query.csv -o as_csv.csv --clamp
    expect_ok eval "own/$table.stratus" --query query.csv -o as_own.csv --clamp
    expect_same as_csv.csv as_own.csv
done

# --- kills and resumptions

taken() { grep -c 'was there' "$out"; }
rm whole/grey.stratus
cp whole/thin.stratus "$logs/thin.stratus"
expect_ok bake base.toml --sweep sweep.csv -o whole --resume --quiet
[ "$(taken)" -eq 2 ] || fail "two tables must be found"
expect_same whole/grey.stratus threads/grey.stratus
expect_same whole/thin.stratus "$logs/thin.stratus"

# a name is not enough: another recipe's table and a damaged one are baked again
cp whole/grey.stratus whole/thin.stratus
truncate -s -1000 "whole/rayleigh, both.stratus"
expect_ok bake base.toml --sweep three.csv -o whole --resume --quiet
[ "$(taken)" -eq 1 ] || fail "one table must be found"
for table in thin grey "rayleigh, both"; do expect_same "threads/$table.stratus" "whole/$table.stratus"; done

# so are what a power cut may leave of tables that the disk had not taken yet: nothing, or zeros
: >whole/thin.stratus
size=$(stat -c %s whole/grey.stratus)
truncate -s 0 whole/grey.stratus
truncate -s "$size" whole/grey.stratus
expect_ok bake base.toml --sweep three.csv -o whole --resume --quiet
[ "$(taken)" -eq 1 ] || fail "one table must be found"
for table in thin grey "rayleigh, both"; do expect_same "threads/$table.stratus" "whole/$table.stratus"; done

# killed at random moments, it ends with the same tables
RANDOM=1982
kills=0
for _ in $(seq 8); do
    (
        timeout -s KILL --preserve-status "0.$((RANDOM % 30 + 1))" "$stratus" bake base.toml --sweep three.csv -o killed \
            --resume --quiet >"$out" 2>"$err"
        exit $?
    ) 2>/dev/null || kills=$((kills + 1))
done
expect_ok bake base.toml --sweep three.csv -o killed --resume --quiet
for table in thin grey "rayleigh, both"; do expect_same "threads/$table.stratus" "killed/$table.stratus"; done
[ "$(find killed -type f | wc -l)" -eq 4 ] || fail "there is $(ls -A killed)"

# a signal stops it in order; without --foreground timeout sends two, and the second stops it at once
sed 's/= 0.1/= 1e-5/; s/max = 1.0/max = inf/; s/max = 0.9/max = 1.0/' base.toml >long.toml
printf 'phase_function\nhenyey_greenstein:g=0.7\nhenyey_greenstein:g=0.8\n' >long.csv
timeout --foreground -s INT 1 "$stratus" bake long.toml --sweep long.csv -o long --quiet >"$out" 2>"$err"
[ $? -eq 124 ] || fail "it must be interrupted by SIGINT"
expect_says "$err" "repeat the command with --resume"
expect_silent "$out"

# --- a table that misses, one that fails: the others are baked, and the exit code is 1

printf 'name,discretisation.mu_samples,tolerance\ngood,,\nbad,4,1e-3\n' >missed.csv
"$stratus" bake base.toml --sweep missed.csv -o missed --quiet >"$out" 2>"$err"
[ $? -eq 1 ] || fail "the exit code must be 1"
expect_says "$err" "1 of 2 tables miss their tolerance (--accept"
expect_says "$out" "good,0.1,yes," "bad,0.001,no," "the table misses its tolerance"
[ -f missed/bad.stratus ] || fail "it must be written all the same"
expect_ok bake base.toml --sweep missed.csv -o missed --resume --accept --quiet
expect_says "$out" "bad,0.001,no,"
expect_says "$err" "1 of 2 tables miss their tolerance"
mkdir -p failed/good.stratus
"$stratus" bake base.toml --sweep missed.csv -o failed --accept --quiet >"$out" 2>"$err"
[ $? -eq 1 ] || fail "the exit code must be 1"
expect_says "$err" "1 of 2 tables failed"
expect_says "$out" "good,0.1,failed," "is a directory" "bad,0.001,no,"

# --- refusals, before anything is baked

refused() { # refused CSV FRAGMENT...: exit code 2
    local csv=$1
    shift
    printf '%b' "$csv" >bad.csv
    expect_refused 2 "$@" -- bake base.toml --sweep bad.csv -o new
    [ ! -e new ] || fail "no folder may be made"
}
refused 'tolerance\n0.01\n2\n' "bad.csv, line 3: tolerance must be a number in [1e-6, 0.1], got 2"
refused 'tolerance\nfine\n' "bad.csv, line 2: tolerance must be a number" fine
refused 'discretisation.nodes\n1.5\n' "bad.csv, line 2: discretisation.nodes must be a whole number in [1, 512]"
refused 'phase_function\nhenyey_greenstein:g=1\n' "bad.csv, line 2: phase_function"
refused 'optical_depth.min\n3\n' "bad.csv, line 2: optical_depth.min must be at most max"
refused 'mu_in.min,mu_in.max\n0.5,1\n0.5,\n' "bad.csv, line 3" mu_in.max
refused 'tolerence\n0.01\n' "no key of the recipe is 'tolerence'; did you mean 'tolerance'?"
refused 'layers.1.albedo\n0.5\n' "no key of the recipe is 'layers.1.albedo'"
refused 'name\na\na\n' "bad.csv, line 3: name must be a new one" "'a' again"
refused 'name\na/b\n' "bad.csv, line 2: name must be a file's name" "got 'a/b'"
refused 'name,tolerance\n,0.1\n' "bad.csv, line 2: name must be" "got ''"
refused 'tolerance\n' "at least one row"
refused '' "a header naming the columns"
refused 'tolerance,albedo.min\n0.1\n' "line 2: a row must have 2 values, got 1"
printf 'layers.3.albedo\n0.5\n' >bad.csv
expect_refused 2 "bad.csv, line 2: layers.3.albedo" "up to 2" -- bake stack.toml --sweep bad.csv -o new
section() { # section LINES FRAGMENT...: of a recipe with this [sweep]; exit code 2
    { cat base.toml && printf '[sweep]\n%b' "$1"; } >bad.toml
    shift
    expect_refused 2 bad.toml "$@" -- bake bad.toml -o new
    [ ! -e new ] || fail "no folder may be made"
}
section 'tolerance = [0.01, 2]\n' "table 2: tolerance must be a number in [1e-6, 0.1], got 2"
section 'tolerance = [0.01]\nalbedo.max = [1, 1]\n' "line 10: sweep.tolerance must be as long as the other lists of [sweep], 2, got 1"
section 'tolerance = []\n' "sweep.tolerance must be a list of values"
section 'tolerance = 0.01\n' "sweep.tolerance must be a list of values, one for each table, got 0.01"
section 'tolerence = [0.01]\n' "no key of the recipe is 'tolerence'; did you mean 'tolerance'?"
section 'name = [1]\n' "table 1: name must be a file's name" "got 1"
section 'name = ["a", "a"]\n' "table 2: name must be a new one"
section '' "sweep must be a list of values a key"
expect_refused 2 "--sweep must be left out for a recipe that has a [sweep]" -- bake own.toml --sweep sweep.csv -o new
expect_refused 2 "own.toml" "sweep must be absent but for" -- bake own.toml -o new --dry-run
expect_refused 2 "--exr must be left out for a sweep" -- bake own.toml -o new --exr t.exr
expect_refused 2 "--h5 must be left out for a sweep" -- bake own.toml -o new --h5 t.h5
expect_refused 1 absent.csv -- bake base.toml --sweep absent.csv -o new
expect_refused 2 --sweep file -- bake base.toml --sweep '' -o new
expect_refused 2 --sweep --exr -- bake base.toml --sweep sweep.csv -o new --exr t.exr
expect_refused 2 --sweep --dry-run -- bake base.toml --sweep sweep.csv -o new --dry-run
expect_refused 2 "--output is required" -- bake base.toml --sweep sweep.csv
expect_refused 1 absent/new -- bake base.toml --sweep sweep.csv -o absent/new
expect_refused 1 base.toml -- bake base.toml --sweep sweep.csv -o base.toml
: >long/1.stratus.checkpoint
expect_refused 1 "is left from an interrupted sweep; --resume continues it" -- bake long.toml --sweep long.csv -o long
finish
